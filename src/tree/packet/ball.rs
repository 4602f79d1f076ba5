//! Spheres and zones of spheres as packets read them.

use crate::geometry::Sphere;
use crate::tree::rounding::{CENTER_TOLERANCE, ROUNDOFF};
use crate::tree::space::Space;
use fearless_simd::{Simd, f32x16, prelude::*};

/// A sphere in the space of the boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    center: [f32; 3],
    /// The radius, and its square, up to which it may be hit.
    reach: f32,
    reach_squared: f32,
}

impl Ball {
    pub fn new(sphere: &Sphere, space: &Space) -> Self {
        let reach = (sphere.radius * space.inverse_extent) as f32 + CENTER_TOLERANCE;
        Self {
            center: space.place(sphere.center).as_vec3().to_array(),
            reach,
            reach_squared: reach * reach * (1.0 + 8.0 * ROUNDOFF),
        }
    }

    /// The rays that may hit before the limit; none if it is not a number. See "Why no sphere of a
    /// scene of few is missed" in [`crate::tree::rounding`].
    #[inline(always)]
    pub fn may_be_hit<S: Simd>(
        &self,
        origin: &[f32x16<S>; 3],
        direction: &[f32x16<S>; 3],
        limit: f32x16<S>,
    ) -> <f32x16<S> as SimdBase<S>>::Mask {
        let [x, y, z] = &self.center;
        let to_center = [-(origin[0] - *x), -(origin[1] - *y), -(origin[2] - *z)];
        let along = to_center[0]
            .mul_add(direction[0], to_center[1].mul_add(direction[1], to_center[2] * direction[2]));
        let across = [
            along.mul_add(direction[0], -to_center[0]),
            along.mul_add(direction[1], -to_center[1]),
            along.mul_add(direction[2], -to_center[2]),
        ];
        let squared =
            across[0].mul_add(across[0], across[1].mul_add(across[1], across[2] * across[2]));
        squared.simd_le(self.reach_squared)
            & along.simd_ge(-self.reach)
            & (along - self.reach).simd_le(limit)
    }
}
