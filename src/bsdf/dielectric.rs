//! The smooth dielectric (glass, water): Dirac reflection and refraction, chosen in proportion to
//! Fresnel's R and T.

use super::fresnel::{self, checked_relative_ior};
use super::mirror::mirrored;
use super::{Bsdf, BsdfError, BsdfSample, Lobes, TransportMode, opposite_sides, same_side, sine};
use crate::math::{PerProjected, Rgb};
use glam::DVec3;

/// The interface between the medium outside (z > 0) and the one inside (z < 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    relative_ior: f64,
    stain: Rgb,
}

impl Dielectric {
    /// An interface with `relative_ior` = n_inside / n_outside. With 1 it is exactly invisible.
    ///
    /// # Errors
    /// If `relative_ior` is not in [1e-6, 1e6].
    pub fn new(relative_ior: f64) -> Result<Self, BsdfError> {
        checked_relative_ior(relative_ior)
            .map(|relative_ior| Self { relative_ior, stain: Rgb::WHITE })
    }

    /// The same interface which lets through only a part, 0 to 1, of what is refracted.
    #[must_use]
    pub(crate) fn stained(self, share: Rgb) -> Self {
        Self { stain: self.stain * share, ..self }
    }

    /// The share of refracted light that passes; white unless the interface is stained.
    #[inline]
    pub(super) const fn stain(&self) -> Rgb {
        self.stain
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
    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        if !same_side(fixed, fixed) {
            return;
        }
        let eta = self.far_over_near(fixed);
        let interface = fresnel::dielectric(fixed.z.abs(), sine(fixed), eta);
        if interface.reflectance > 0.0 {
            image(BsdfSample::of_dirac(mirrored(fixed), Rgb::WHITE, interface.reflectance));
        }
        let next = DVec3::new(
            -fixed.x / eta,
            -fixed.y / eta,
            -interface.refracted_cosine.copysign(fixed.z),
        );
        if !opposite_sides(fixed, next) || interface.transmittance <= 0.0 {
            return;
        }
        let probability = PerProjected(interface.transmittance);
        // n_camera² / n_light² of this pair of directions
        let squeeze = match mode {
            TransportMode::Radiance => 1.0 / (eta * eta),
            TransportMode::Importance => eta * eta,
        };
        let (weight, pdf, pdf_reverse) = match mode {
            TransportMode::Radiance => (Rgb::splat(squeeze), probability, probability * squeeze),
            TransportMode::Importance => (Rgb::WHITE, probability * squeeze, probability),
        };
        let weight = weight * self.stain;
        image(BsdfSample { next, weight, pdf, pdf_reverse, dirac: true, relative_ior: eta });
    }
}
