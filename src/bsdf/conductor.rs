//! The smooth conductor (polished metal): a mirror with Fresnel's reflectance.

use super::fresnel::Reflectance;
use super::mirror::mirror_image;
use super::{Bsdf, BsdfError, BsdfSample, Lobes, TransportMode};
use crate::math::Rgb;
use glam::DVec3;

/// Dirac reflection on both sides of a sheet of metal; what is not reflected is absorbed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    reflectance: Reflectance,
}

impl Conductor {
    /// A conductor with the index of refraction `eta + i k` relative to the medium around it.
    ///
    /// # Errors
    /// If a component is not in [0, 1e6].
    pub fn new(eta: Rgb, k: Rgb) -> Result<Self, BsdfError> {
        Reflectance::conductor(eta, k).map(|reflectance| Self { reflectance })
    }
}

impl Bsdf for Conductor {
    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::DIRAC_REFLECTION
    }

    #[inline]
    fn dirac_images(&self, fixed: DVec3, _walk: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        mirror_image(self.reflectance, fixed).into_iter().for_each(image);
    }
}
