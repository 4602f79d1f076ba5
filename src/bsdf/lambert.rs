//! The ideally diffuse reflector (Lambert 1760): `f = albedo / π`.

use super::error::checked_reflectance;
use super::{Bsdf, BsdfError, BsdfSample, LaneForm, Lobes, TransportMode, on_same_side, same_side};
use crate::lanes::{Lane, Vector};
use crate::math::warp::cosine_hemisphere;
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// Diffuse reflection on both sides of the surface, none through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    albedo: Rgb,
}

impl Lambert {
    /// A diffuse reflector that reflects the fraction `albedo` of the light.
    ///
    /// # Errors
    /// If a channel of `albedo` is not in [0, 1].
    pub fn new(albedo: Rgb) -> Result<Self, BsdfError> {
        checked_reflectance(albedo).map(|albedo| Self { albedo })
    }

    /// The same of an albedo that is known to be valid.
    #[inline]
    pub(crate) const fn of_valid(albedo: Rgb) -> Self {
        Self { albedo }
    }

    /// The reflected fraction of the light.
    #[inline]
    #[must_use]
    pub const fn albedo(&self) -> Rgb {
        self.albedo
    }
}

impl Bsdf for Lambert {
    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE_REFLECTION
    }

    #[inline]
    // ANCHOR: density
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        if same_side(to_light, to_camera) { self.albedo * FRAC_1_PI } else { Rgb::BLACK }
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, _walk: TransportMode) -> PerProjected {
        if same_side(fixed, next) { PerProjected(FRAC_1_PI) } else { PerProjected::ZERO }
    }
    // ANCHOR_END: density

    #[inline]
    // ANCHOR: sample
    fn sample(
        &self,
        fixed: DVec3,
        _walk: TransportMode,
        _u1: f64,
        u2: DVec2,
    ) -> Option<BsdfSample> {
        let (next, is_reflected) = reflected(fixed.z, u2.to_array());
        is_reflected.then_some(BsdfSample {
            next: next.into(),
            weight: self.albedo,
            pdf: PerProjected(FRAC_1_PI),
            pdf_reverse: PerProjected(FRAC_1_PI),
            dirac: false,
            relative_ior: 1.0,
        })
    }
    // ANCHOR_END: sample

    #[inline]
    fn lane_form(&self, _front: bool) -> Option<LaneForm> {
        Some(LaneForm::Lambert(*self))
    }
}

/// Sampled directions in the local frame in lanes, given the local z of the fixed ones; and where
/// they are any.
#[inline(always)]
pub(crate) fn reflected<L: Lane>(fixed_z: L, u: [L; 2]) -> (Vector<L>, L::Mask) {
    let mut next = cosine_hemisphere(u);
    next.z = next.z.copysign(fixed_z);
    (next, on_same_side(fixed_z, next.z))
}
