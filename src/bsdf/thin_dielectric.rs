//! A pane of glass so thin that refraction at both faces cancels: Dirac reflection and straight
//! transmission.
//!
//! With R of one face, the light that bounces between the faces sums to a reflectance of `R + T² R
//! (1 + R² + …) = 2R/(1 + R)` and a transmittance of `(1 - R)/(1 + R)`. Interference and
//! displacement are left out.

use super::fresnel::{self, checked_relative_ior};
use super::mirror::mirrored;
use super::{Bsdf, BsdfError, BsdfSample, Lobes, TransportMode, same_side, sine};
use crate::math::Rgb;
use glam::DVec3;

/// Both faces of a pane in one surface, with the same medium on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    relative_ior: f64,
    stain: Rgb,
}

impl ThinDielectric {
    /// A pane with `relative_ior` = n_pane / n_outside.
    ///
    /// # Errors
    /// If `relative_ior` is not in [1e-6, 1e6].
    pub fn new(relative_ior: f64) -> Result<Self, BsdfError> {
        checked_relative_ior(relative_ior)
            .map(|relative_ior| Self { relative_ior, stain: Rgb::WHITE })
    }

    /// The same pane which lets through only a part, 0 to 1, of what is not reflected.
    #[must_use]
    pub(crate) fn stained(self, share: Rgb) -> Self {
        Self { stain: self.stain * share, ..self }
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
    fn dirac_images(&self, fixed: DVec3, _walk: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        if !same_side(fixed, fixed) {
            return;
        }
        let (reflectance, transmittance) = self.shares(fixed);
        let images =
            [(mirrored(fixed), Rgb::WHITE, reflectance), (-fixed, self.stain, transmittance)];
        for (next, weight, share) in images {
            if share > 0.0 {
                image(BsdfSample::of_dirac(next, weight, share));
            }
        }
    }
}
