//! The surface that is not there: `f = δ⊥(to_light + to_camera)`.

use super::{
    Bsdf, BsdfSample, DIRAC_TOLERANCE, DiracValue, Lobes, Walk, opposite_sides, same_side,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

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
    fn eval(&self, _to_light: DVec3, _to_camera: DVec3) -> Rgb {
        Rgb::BLACK
    }

    #[inline]
    fn pdf(&self, _fixed: DVec3, _next: DVec3, _walk: Walk) -> PerProjected {
        PerProjected::ZERO
    }

    #[inline]
    fn sample(&self, fixed: DVec3, _walk: Walk, _u1: f64, _u2: DVec2) -> Option<BsdfSample> {
        same_side(fixed, fixed).then(|| BsdfSample {
            next: -fixed,
            weight: Rgb::WHITE,
            pdf: PerProjected(1.0),
            pdf_reverse: PerProjected(1.0),
            dirac: true,
            relative_ior: 1.0,
        })
    }

    #[inline]
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        if is_straight(to_light, to_camera) {
            DiracValue {
                value: Rgb::WHITE,
                pdf_to_light: PerProjected(1.0),
                pdf_to_camera: PerProjected(1.0),
            }
        } else {
            DiracValue::default()
        }
    }
}

/// Whether the directions are opposite, up to rounding.
#[inline]
pub(super) fn is_straight(a: DVec3, b: DVec3) -> bool {
    opposite_sides(a, b) && (a + b).truncate().length_squared() < DIRAC_TOLERANCE * DIRAC_TOLERANCE
}
