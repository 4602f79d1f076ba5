//! A pane of glass so thin that refraction at both faces cancels: Dirac reflection and straight
//! transmission.
//!
//! With R of one face, the light that bounces between the faces sums to a reflectance of `R + T² R
//! (1 + R² + …) = 2R/(1 + R)` and a transmittance of `(1 - R)/(1 + R)`. Interference and
//! displacement are left out.

use super::fresnel::{self, checked_relative_ior};
use super::mirror::{is_mirrored, mirrored};
use super::null::is_straight;
use super::{Bsdf, BsdfError, BsdfSample, DiracValue, Lobes, Walk, same_side, sine};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// Both faces of a pane in one surface, with the same medium on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    relative_ior: f64,
}

impl ThinDielectric {
    /// A pane with `relative_ior` = n_pane / n_outside.
    ///
    /// # Errors
    /// If `relative_ior` is not in [1e-6, 1e6].
    pub fn new(relative_ior: f64) -> Result<Self, BsdfError> {
        checked_relative_ior(relative_ior).map(|relative_ior| Self { relative_ior })
    }

    /// Reflectance and transmittance of the pane.
    fn shares(&self, direction: DVec3) -> (f64, f64) {
        let face = fresnel::dielectric(direction.z.abs(), sine(direction), self.relative_ior);
        (
            2.0 * face.reflectance / (1.0 + face.reflectance),
            face.transmittance / (1.0 + face.reflectance),
        )
    }
}

impl Bsdf for ThinDielectric {
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
    fn sample(&self, fixed: DVec3, _walk: Walk, u1: f64, _u2: DVec2) -> Option<BsdfSample> {
        if !same_side(fixed, fixed) {
            return None;
        }
        let (reflectance, transmittance) = self.shares(fixed);
        let (next, share) =
            if u1 < reflectance { (mirrored(fixed), reflectance) } else { (-fixed, transmittance) };
        let pdf = PerProjected(share);
        (share > 0.0).then_some(BsdfSample {
            next,
            weight: Rgb::WHITE,
            pdf,
            pdf_reverse: pdf,
            dirac: true,
            relative_ior: 1.0,
        })
    }

    #[inline]
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        let (reflectance, transmittance) = self.shares(to_camera);
        let share = if is_mirrored(to_light, to_camera) {
            reflectance
        } else if is_straight(to_light, to_camera) {
            transmittance
        } else {
            return DiracValue::default();
        };
        DiracValue {
            value: Rgb::splat(share),
            pdf_to_light: PerProjected(share),
            pdf_to_camera: PerProjected(share),
        }
    }
}
