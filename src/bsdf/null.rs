//! The surface that is not there: `f = δ⊥(to_light + to_camera)`.

use super::{Bsdf, BsdfSample, Lobes, TransportMode, same_side};
use crate::math::Rgb;
use glam::DVec3;

/// Lets everything pass straight through, for example where only a light or a boundary between
/// media is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Null;

impl Bsdf for Null {
    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::DIRAC_TRANSMISSION
    }

    #[inline]
    fn dirac_images(&self, fixed: DVec3, _walk: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        if same_side(fixed, fixed) {
            image(BsdfSample::of_dirac(-fixed, Rgb::WHITE, 1.0));
        }
    }
}
