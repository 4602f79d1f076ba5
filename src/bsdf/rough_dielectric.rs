//! The rough dielectric (frosted glass): a micro-surface of smooth interfaces (Walter et al. 2007,
//! eqs. 20 and 21).
//!
//! With `m = n_o o + n_i i` along the normal h that refracts o into i,
//!
//! ```text
//! reflection: f = R D G2 / (4 o_z i_z)
//! refraction: f = n_c² T D G2 (o·h)|i·h| / (o_z i_z |m|²)
//! ```
//!
//! with n_c the index on the side of `to_camera`, and G2 of directions on the same side or on
//! opposite sides, which are two functions (see [`microfacets`](super::microfacets)). So `f / n_c²`
//! is symmetric, and a sampled normal's density `D_o(h)` becomes `D_o(h) T n_i² |i·h| / |m|²` of
//! the refracted direction.

use super::rough_conductor::{Pair, is_above, reflect, upwards};
use super::{Bsdf, BsdfError, BsdfSample, Dielectric, Lobes, Microfacets, TransportMode, fresnel};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// Relative indices closer to 1 than this bend no ray measurably and leave no usable half vector.
pub(crate) const INDEX_MATCHED: f64 = 1e-6;

/// Glossy reflection and refraction, single scattering: what hits the micro-surface twice is lost.
///
/// It is the smooth [`Dielectric`] if the distribution [is smooth](Microfacets::is_smooth), and if
/// the index is within 1e-6 of 1, where light passes straight through. At this point the model is
/// discontinuous, as single scattering is: it counts a ray that meets two facets as lost even if
/// neither bends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    interface: Dielectric,
    distribution: Microfacets,
    dirac: bool,
}

impl RoughDielectric {
    /// A rough interface with `relative_ior` = n_inside / n_outside, where inside is z < 0.
    ///
    /// # Errors
    /// If `relative_ior` is not in [1e-6, 1e6].
    pub fn new(relative_ior: f64, distribution: impl Into<Microfacets>) -> Result<Self, BsdfError> {
        Dielectric::new(relative_ior).map(|interface| Self::of(interface, distribution.into()))
    }

    fn of(interface: Dielectric, distribution: Microfacets) -> Self {
        let is_matched = (interface.relative_ior() - 1.0).abs() < INDEX_MATCHED;
        Self { interface, distribution, dirac: distribution.is_smooth() || is_matched }
    }

    /// The same interface which lets through only a part, 0 to 1, of what is refracted.
    pub(super) fn stained(self, share: Rgb) -> Self {
        Self { interface: self.interface.stained(share), ..self }
    }

    /// The same interface with other roughnesses, at most 10; never smooth.
    pub(super) fn with_roughness(self, alpha_x: f64, alpha_y: f64) -> Self {
        Self::of(self.interface, self.distribution.with_roughness(alpha_x, alpha_y))
    }

    #[inline]
    fn pair(&self, fixed: DVec3, next: DVec3) -> Option<Scattering> {
        if self.dirac {
            return None;
        }
        let eta = self.interface.far_over_near(fixed);
        if upwards(next, fixed).z > 0.0 {
            let pair = Pair::new(fixed, next)?;
            let interface = fresnel::dielectric(pair.cosine, pair.o.cross(pair.h).length(), eta);
            Some(Scattering::Reflection { pair, reflectance: interface.reflectance })
        } else {
            Refraction::new(fixed, next, eta).map(Scattering::Refraction)
        }
    }
}

impl Bsdf for RoughDielectric {
    #[inline]
    fn lobes(&self) -> Lobes {
        if self.dirac { self.interface.lobes() } else { Lobes::GLOSSY }
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.pair(to_camera, to_light).map_or(Rgb::BLACK, |scattering| {
            let stain = match scattering {
                Scattering::Reflection { .. } => Rgb::WHITE,
                Scattering::Refraction(_) => self.interface.stain(),
            };
            stain * scattering.value(&self.distribution)
        })
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, _mode: TransportMode) -> PerProjected {
        self.pair(fixed, next)
            .map_or(PerProjected::ZERO, |scattering| scattering.pdf(&self.distribution))
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        if self.dirac {
            return self.interface.sample(fixed, mode, u1, u2);
        }
        let o = upwards(fixed, fixed);
        if !is_above(o) {
            return None;
        }
        let eta = self.interface.far_over_near(fixed);
        let h = self.distribution.sample_visible(o, u2)?;
        let interface = fresnel::dielectric(o.dot(h).max(0.0), o.cross(h).length(), eta);
        let reflects = u1 < interface.reflectance;
        let i =
            if reflects { reflect(o, h)? } else { refract(o, h, eta, interface.refracted_cosine)? };
        let next = upwards(i, fixed);
        let scattering = self.pair(fixed, next)?;
        let pdf = scattering.pdf(&self.distribution);
        let squeeze =
            if reflects || mode == TransportMode::Importance { 1.0 } else { 1.0 / (eta * eta) };
        let shadowing = if reflects {
            self.distribution.shadowing(o, i)
        } else {
            self.distribution.shadowing_across(o, DVec3::new(i.x, i.y, -i.z))
        };
        // R or T is in the value and in the density alike, and a T of 0 only occurs where rounding
        // met total reflection
        (pdf.value() > 0.0).then(|| BsdfSample {
            next,
            weight: if reflects { Rgb::WHITE } else { self.interface.stain() }
                * (squeeze * shadowing),
            pdf,
            pdf_reverse: scattering.swapped().pdf(&self.distribution),
            dirac: false,
            relative_ior: if reflects { 1.0 } else { eta },
        })
    }

    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        if self.dirac {
            self.interface.dirac_images(fixed, mode, image);
        }
    }
}

/// The interaction of the interface with a pair of directions, seen from the first of them.
enum Scattering {
    Reflection { pair: Pair, reflectance: f64 },
    Refraction(Refraction),
}

impl Scattering {
    /// f if the first direction is `to_camera`.
    #[inline]
    fn value(&self, distribution: &Microfacets) -> f64 {
        match self {
            Self::Reflection { pair, reflectance } => reflectance * pair.value(distribution),
            Self::Refraction(refraction) => refraction.value(distribution),
        }
    }

    #[inline]
    fn pdf(&self, distribution: &Microfacets) -> PerProjected {
        match self {
            Self::Reflection { pair, reflectance } => pair.pdf(distribution) * *reflectance,
            Self::Refraction(refraction) => refraction.pdf(distribution),
        }
    }

    fn swapped(self) -> Self {
        match self {
            Self::Reflection { pair, reflectance } => {
                Self::Reflection { pair: pair.swapped(), reflectance }
            }
            Self::Refraction(refraction) => Self::Refraction(refraction.swapped()),
        }
    }
}

/// Two directions on opposite sides with the normal that refracts one into the other, all with z
/// seen from their own side.
pub(super) struct Refraction {
    /// The first direction, z > 0.
    pub o: DVec3,
    /// The second direction, its z flipped to be positive.
    i: DVec3,
    /// The micro-normal up to the signs of its components, to which D is blind.
    pub h: DVec3,
    /// o · h
    pub cosine_o: f64,
    /// |i · h|
    cosine_i: f64,
    /// |m|² = |n_o o + n_i i|² with n_o = 1
    m_squared: f64,
    /// n_i / n_o
    eta: f64,
    pub transmittance: f64,
}

impl Refraction {
    #[inline]
    pub fn new(fixed: DVec3, next: DVec3, eta: f64) -> Option<Self> {
        let (o, i) = (upwards(fixed, fixed), upwards(next, fixed));
        if !is_above(o) || !is_above(-i) {
            return None;
        }
        let m = o + eta * i;
        let m_squared = m.length_squared();
        let h = m.try_normalize()?;
        let h = if h.z < 0.0 { -h } else { h };
        let (cosine_o, cosine_i) = (o.dot(h), -i.dot(h));
        if !(cosine_o > 0.0 && cosine_i > 0.0) {
            return None;
        }
        let transmittance = fresnel::transmittance(cosine_o, cosine_i, eta);
        Some(Self {
            o,
            i: DVec3::new(i.x, i.y, -i.z),
            h,
            cosine_o,
            cosine_i,
            m_squared,
            eta,
            transmittance,
        })
    }

    /// f with `to_camera` = o, where n_c = n_o = 1 in these units.
    #[inline]
    fn value(&self, distribution: &Microfacets) -> f64 {
        let jacobian = self.cosine_o * self.cosine_i / self.m_squared;
        2.0 * self.transmittance
            * jacobian
            * distribution.density(self.h)
            * distribution.correlation_across(self.o, self.i)
    }

    /// The same without T, if masking and shadowing are independent.
    #[inline]
    pub fn value_of_independent(&self, distribution: &Microfacets) -> f64 {
        let jacobian = self.cosine_o * self.cosine_i / self.m_squared;
        let [area_o, area_i] = [self.o, self.i].map(|w| distribution.projected_area(w));
        jacobian * (distribution.density(self.h) / area_o) / area_i
    }

    #[inline]
    fn pdf(&self, distribution: &Microfacets) -> PerProjected {
        self.pdf_of_normal(distribution, self.transmittance)
    }

    /// The density if the normal refracts with the given probability.
    #[inline]
    pub fn pdf_of_normal(&self, distribution: &Microfacets, probability: f64) -> PerProjected {
        let jacobian = self.eta * self.eta * self.cosine_o * self.cosine_i / self.m_squared;
        PerProjected(
            probability * jacobian * distribution.visible_density_over_cosine(self.o, self.h)
                / self.i.z,
        )
    }

    fn swapped(self) -> Self {
        let eta = 1.0 / self.eta;
        Self {
            o: self.i,
            i: self.o,
            cosine_o: self.cosine_i,
            cosine_i: self.cosine_o,
            m_squared: self.m_squared * eta * eta,
            eta,
            ..self
        }
    }
}

/// `o` refracted through the normal `h`, if it leaves on the far side.
#[inline]
pub(super) fn refract(o: DVec3, h: DVec3, eta: f64, refracted_cosine: f64) -> Option<DVec3> {
    let i = ((o.dot(h) / eta - refracted_cosine) * h - o / eta).normalize();
    (i.z < 0.0).then_some(i)
}
