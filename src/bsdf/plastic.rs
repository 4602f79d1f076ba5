//! Smooth plastic: a diffuse body under a smooth dielectric coat.
//!
//! Light is mirrored by the coat, or enters it, is scattered by the body in all directions, and
//! leaves, possibly after being thrown back by the coat from inside. With the body's albedo a, the
//! coat's R and T for the angles outside, its relative index n and its mean reflectance from inside
//! `R_i`,
//!
//! ```text
//! f = R δ⊥ + a/(1 - a R_i) · T(to_light) T(to_camera) / (π n²)
//! ```
//!
//! The simpler model without the shift of colour by repeated reflections has `a/(1 - R_i)` in its
//! place; a white body reflects everything in both.

use super::error::checked_reflectance;
use super::fresnel::{self, checked_relative_ior};
use super::mirror::mirrored;
use super::{Bsdf, BsdfError, BsdfSample, Lobes, TransportMode, same_side, sample_diffuse, sine};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// Dirac reflection of a clear coat and diffuse reflection of what is below, on both sides of the
/// surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    pub(super) relative_ior: f64,
    /// Colour of the coat's reflection.
    pub(super) specular: Rgb,
    /// Mean reflectance of the coat from inside.
    pub(super) inside: f64,
    colour_shift: bool,
    /// Albedo of the body under a coat that transmits everything in and out: `a / (1 - a R_i) /
    /// n²`.
    body: Rgb,
    /// Share of samples for the body against the coat, before Fresnel's terms.
    body_share: f64,
}

impl Plastic {
    /// Plastic with the diffuse `albedo` of its body and `relative_ior` = n_coat / n_outside ≥ 1.
    /// `specular` scales the coat's reflection and is physically 1. `colour_shift` says whether
    /// light that the coat throws back to the body is coloured again, which saturates colours.
    ///
    /// # Errors
    /// If a channel of a colour is not in [0, 1], or `relative_ior` is not in [1, 1e6].
    pub fn new(
        albedo: Rgb,
        specular: Rgb,
        relative_ior: f64,
        colour_shift: bool,
    ) -> Result<Self, BsdfError> {
        let (albedo, specular) = (checked_reflectance(albedo)?, checked_reflectance(specular)?);
        let n = checked_relative_ior(relative_ior)
            .ok()
            .filter(|n| *n >= 1.0)
            .ok_or(BsdfError::RelativeIor(relative_ior))?;
        // 1 - R_i = (1 - R_e)/n²: what enters from one side leaves from the other.
        let inside = 1.0 - (1.0 - mean_reflectance(n)) / (n * n);
        Ok(Self {
            relative_ior: n,
            specular,
            inside,
            colour_shift,
            body: Rgb::BLACK,
            body_share: 0.0,
        }
        .with_albedo(albedo))
    }

    /// The same plastic with a body of another albedo, which must be in [0, 1].
    pub(crate) fn with_albedo(self, albedo: Rgb) -> Self {
        let n2 = self.relative_ior * self.relative_ior;
        let body =
            albedo.map(|a| a / (1.0 - if self.colour_shift { a } else { 1.0 } * self.inside) / n2);
        let (coat, below) = (self.specular.mean(), body.mean() * (1.0 - self.inside) * n2);
        let body_share = if coat + below > 0.0 { below / (coat + below) } else { 0.5 };
        Self { body, body_share, ..self }
    }

    /// The same body under a coat of another mean reflectance from inside.
    pub(super) fn with_inside(self, inside: f64, albedo: Rgb) -> Self {
        Self { inside, ..self }.with_albedo(albedo)
    }

    /// The body's value, given the coat's transmittances for both directions.
    pub(super) fn body_value(&self, [to_light, to_camera]: [f64; 2]) -> Rgb {
        self.body * (FRAC_1_PI * to_light * to_camera)
    }

    fn interface(&self, direction: DVec3) -> fresnel::Interface {
        fresnel::dielectric(direction.z.abs(), sine(direction), self.relative_ior)
    }

    /// The probability of sampling the coat, given its reflectance and transmittance.
    pub(super) fn coat_probability(&self, reflectance: f64, transmittance: f64) -> f64 {
        let coat = reflectance * (1.0 - self.body_share);
        let body = transmittance * self.body_share;
        // Neither only where nothing is reflected at all.
        if coat + body > 0.0 { coat / (coat + body) } else { 1.0 }
    }

    fn coat_probability_at(&self, interface: &fresnel::Interface) -> f64 {
        self.coat_probability(interface.reflectance, interface.transmittance)
    }

    fn body_pdf(&self, interface: &fresnel::Interface) -> PerProjected {
        PerProjected(FRAC_1_PI * (1.0 - self.coat_probability_at(interface)))
    }

    /// The reflection of the coat.
    fn coat_image(&self, fixed: DVec3, interface: &fresnel::Interface) -> Option<BsdfSample> {
        let probability = self.coat_probability_at(interface);
        (probability > 0.0).then(|| {
            let weight = self.specular * (interface.reflectance / probability);
            BsdfSample::of_dirac(mirrored(fixed), weight, probability)
        })
    }
}

impl Bsdf for Plastic {
    #[inline]
    fn lobes(&self) -> Lobes {
        let coat = if self.relative_ior == 1.0 || self.specular.is_black() {
            Lobes::NONE
        } else {
            Lobes::DIRAC_REFLECTION
        };
        if self.body.is_black() { coat } else { coat | Lobes::DIFFUSE_REFLECTION }
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        if !same_side(to_light, to_camera) {
            return Rgb::BLACK;
        }
        self.body_value([to_light, to_camera].map(|w| self.interface(w).transmittance))
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _walk: TransportMode) -> PerProjected {
        if same_side(fixed, next) {
            self.body_pdf(&self.interface(fixed))
        } else {
            PerProjected::ZERO
        }
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        if !same_side(to_light, to_camera) {
            return (Rgb::BLACK, PerProjected::ZERO);
        }
        let interface = self.interface(to_camera);
        let ends = [self.interface(to_light).transmittance, interface.transmittance];
        (self.body_value(ends), self.body_pdf(&interface))
    }

    fn sample(&self, fixed: DVec3, _walk: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        if !same_side(fixed, fixed) {
            return None;
        }
        let interface = self.interface(fixed);
        let coat_probability = self.coat_probability_at(&interface);
        if u1 < coat_probability {
            return self.coat_image(fixed, &interface);
        }
        let next = sample_diffuse(fixed, u2);
        let pdf = self.body_pdf(&interface);
        if !same_side(fixed, next) || pdf.value() <= 0.0 {
            return None;
        }
        let beyond = self.interface(next);
        Some(BsdfSample {
            next,
            weight: self.body_value([beyond.transmittance, interface.transmittance]) / pdf.value(),
            pdf,
            pdf_reverse: self.body_pdf(&beyond),
            dirac: false,
            relative_ior: 1.0,
        })
    }

    fn dirac_images(&self, fixed: DVec3, _walk: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        if same_side(fixed, fixed) {
            self.coat_image(fixed, &self.interface(fixed)).into_iter().for_each(image);
        }
    }
}

/// Fresnel's R of light that comes diffusely from the thinner side, `∫ 2 μ R(μ) dμ`, in closed form
/// (Walsh 1926; Duntley 1942).
fn mean_reflectance(n: f64) -> f64 {
    let d = n - 1.0;
    // The closed form loses two digits per decade of n - 1; its beginning is d/3.
    if d < 1e-4 {
        return d / 3.0;
    }
    let (n2, n4) = (n * n, n * n * n * n);
    0.5 + d * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 * (n2 - 1.0) * (n2 - 1.0) / (n2 + 1.0).powi(3) * libm::log(d / (n + 1.0))
        - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0) * (n4 - 1.0)) * libm::log(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn mean_reflectance_is_the_integral() {
        for n in [1.00005f64, 1.0002, 1.001, 1.05, 1.33, 1.5, 1.9, 3.0, 20.0] {
            // μ = t²: the steep part at grazing angles becomes smooth
            let m = 20_000;
            let integral: f64 = (0..m)
                .map(|i| {
                    let t = (f64::from(i) + 0.5) / f64::from(m);
                    let mu = t * t;
                    4.0 * t
                        * mu
                        * fresnel::dielectric(mu, ((1.0 - mu) * (1.0 + mu)).sqrt(), n).reflectance
                        / f64::from(m)
                })
                .sum();
            assert_relative_eq!(mean_reflectance(n), integral, epsilon = 5e-8, max_relative = 1e-6);
        }
        assert_relative_eq!(mean_reflectance(1.5), 0.091_777_959_342_351_21, max_relative = 1e-12);
    }
}
