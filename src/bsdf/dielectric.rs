//! The smooth dielectric (glass, water): Dirac reflection and refraction, chosen in proportion to
//! Fresnel's R and T.

use super::fresnel::{self, checked_relative_ior};
use super::mirror::{is_mirrored, mirrored};
use super::{
    Bsdf, BsdfError, BsdfSample, DIRAC_TOLERANCE, DiracValue, Lobes, Walk, opposite_sides,
    same_side, sine,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// The interface between the medium outside (z > 0) and the one inside (z < 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    relative_ior: f64,
}

impl Dielectric {
    /// An interface with `relative_ior` = n_inside / n_outside. With 1 it is exactly invisible.
    ///
    /// # Errors
    /// If `relative_ior` is not in [1e-6, 1e6].
    pub fn new(relative_ior: f64) -> Result<Self, BsdfError> {
        checked_relative_ior(relative_ior).map(|relative_ior| Self { relative_ior })
    }

    /// n_inside / n_outside.
    #[must_use]
    pub const fn relative_ior(&self) -> f64 {
        self.relative_ior
    }

    /// Index of refraction across the surface over that on the direction's own side.
    #[inline]
    #[must_use]
    pub fn far_over_near(&self, direction: DVec3) -> f64 {
        if direction.z > 0.0 { self.relative_ior } else { 1.0 / self.relative_ior }
    }
}

impl Bsdf for Dielectric {
    #[inline]
    fn lobes(&self) -> Lobes {
        if self.relative_ior == 1.0 { Lobes::DIRAC_TRANSMISSION } else { Lobes::DIRAC }
    }

    #[inline]
    fn eval(&self, _to_light: DVec3, _to_camera: DVec3) -> Rgb {
        Rgb::BLACK
    }

    #[inline]
    fn pdf(&self, _fixed: DVec3, _next: DVec3, _walk: Walk) -> PerProjected {
        PerProjected::ZERO
    }

    #[inline]
    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, _u2: DVec2) -> Option<BsdfSample> {
        if !same_side(fixed, fixed) {
            return None;
        }
        let eta = self.far_over_near(fixed);
        let interface = fresnel::dielectric(fixed.z.abs(), sine(fixed), eta);
        if u1 < interface.reflectance {
            let pdf = PerProjected(interface.reflectance);
            return Some(BsdfSample {
                next: mirrored(fixed),
                weight: Rgb::WHITE,
                pdf,
                pdf_reverse: pdf,
                dirac: true,
                relative_ior: 1.0,
            });
        }
        let next = DVec3::new(
            -fixed.x / eta,
            -fixed.y / eta,
            -interface.refracted_cosine.copysign(fixed.z),
        );
        let probability = PerProjected(interface.transmittance);
        // n_camera² / n_light² of this pair of directions
        let squeeze = match walk {
            Walk::Camera => 1.0 / (eta * eta),
            Walk::Light => eta * eta,
        };
        let (weight, pdf, pdf_reverse) = match walk {
            Walk::Camera => (Rgb::splat(squeeze), probability, probability * squeeze),
            Walk::Light => (Rgb::WHITE, probability * squeeze, probability),
        };
        (opposite_sides(fixed, next) && interface.transmittance > 0.0).then_some(BsdfSample {
            next,
            weight,
            pdf,
            pdf_reverse,
            dirac: true,
            relative_ior: eta,
        })
    }

    #[inline]
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        let eta = self.far_over_near(to_camera);
        if is_mirrored(to_light, to_camera) {
            let reflectance =
                fresnel::dielectric(to_camera.z.abs(), sine(to_camera), eta).reflectance;
            let pdf = PerProjected(reflectance);
            return DiracValue {
                value: Rgb::splat(reflectance),
                pdf_to_light: pdf,
                pdf_to_camera: pdf,
            };
        }
        // Snell's law: n sin θ is the same on both sides
        let mismatch = (to_camera + eta * to_light).truncate().length_squared();
        let tolerance = DIRAC_TOLERANCE * eta.max(1.0);
        if !opposite_sides(to_light, to_camera) || mismatch >= tolerance * tolerance {
            return DiracValue::default();
        }
        let transmittance = fresnel::transmittance(to_camera.z.abs(), to_light.z.abs(), eta);
        let squeezed = transmittance / (eta * eta);
        DiracValue {
            value: Rgb::splat(squeezed),
            pdf_to_light: PerProjected(transmittance),
            pdf_to_camera: PerProjected(squeezed),
        }
    }
}
