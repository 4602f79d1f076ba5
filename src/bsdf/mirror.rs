//! The perfect mirror: `f = reflectance · δ⊥(to_light - mirrored(to_camera))`.

use super::fresnel::Reflectance;
use super::{Bsdf, BsdfError, BsdfSample, Lobes, TransportMode, same_side, sine};
use crate::math::Rgb;
use glam::DVec3;

/// Dirac reflection on both sides of the surface with the same reflectance at all angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    reflectance: Reflectance,
}

impl Mirror {
    /// A mirror that reflects the fraction `reflectance` of the light.
    ///
    /// # Errors
    /// If a channel of `reflectance` is not in [0, 1].
    pub fn new(reflectance: Rgb) -> Result<Self, BsdfError> {
        Reflectance::constant(reflectance).map(|reflectance| Self { reflectance })
    }
}

impl Bsdf for Mirror {
    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::DIRAC_REFLECTION
    }

    #[inline]
    fn dirac_images(&self, fixed: DVec3, _walk: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        mirror_image(self.reflectance, fixed).into_iter().for_each(image);
    }
}

/// The direction mirrored in the normal.
#[inline]
pub(super) fn mirrored(direction: DVec3) -> DVec3 {
    DVec3::new(-direction.x, -direction.y, direction.z)
}

/// The only image of everything that only mirrors.
#[inline]
pub(super) fn mirror_image(reflectance: Reflectance, fixed: DVec3) -> Option<BsdfSample> {
    same_side(fixed, fixed).then(|| {
        BsdfSample::of_dirac(mirrored(fixed), reflectance.at(fixed.z.abs(), sine(fixed)), 1.0)
    })
}
