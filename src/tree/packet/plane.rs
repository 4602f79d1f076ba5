//! Flat facets as packets read them: prepared once, in the form in which testing sixteen rays takes
//! the fewest operations.

use crate::tree::rounding::{FINEST, HEIGHT_TOLERANCE, PLANE_TOLERANCE, SMALLEST};
use fearless_simd::{Simd, f32x16, prelude::*};
use glam::DVec3;

/// A triangle or a parallelogram in the space of the boxes: its plane, and its parameters u and v
/// as functions of a point of the plane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Facet {
    normal: [f32; 3],
    /// Minus the plane's distance from the origin along the normal.
    minus_distance: f32,
    u: [f32; 3],
    u0: f32,
    v: [f32; 3],
    v0: f32,
    /// The uncertainty of the distance to a plane that is seen from straight above.
    uncertainty: f32,
    /// The uncertainty of u and v in units of that of the distance.
    scale: f32,
    /// 1 for a triangle, of which u + v is limited, and 0 for a parallelogram.
    is_triangle: f32,
}

impl Facet {
    /// The one with these edges from a corner.
    pub fn new(corner: DVec3, [edge1, edge2]: [DVec3; 2], is_triangle: bool) -> Self {
        let cross = edge1.cross(edge2);
        let inverse = 1.0 / cross.length();
        let normal = cross * inverse;
        let (u, v) = (edge2.cross(normal) * inverse, normal.cross(edge1) * inverse);
        let scale = (edge1.length() + edge2.length()) * inverse;
        let is_triangle = f32::from(u8::from(is_triangle));
        if scale.is_nan() || scale > FINEST {
            // Only the exact test can decide.
            let (none, uncertainty) = ([0.0; 3], f32::INFINITY);
            return Self {
                normal: none,
                minus_distance: 0.0,
                u: none,
                u0: 0.0,
                v: none,
                v0: 0.0,
                uncertainty,
                scale: 1.0,
                is_triangle,
            };
        }
        let row = |v: DVec3| v.as_vec3().to_array();
        Self {
            normal: row(normal),
            minus_distance: -normal.dot(corner) as f32,
            u: row(u),
            u0: -u.dot(corner) as f32,
            v: row(v),
            v0: -v.dot(corner) as f32,
            uncertainty: HEIGHT_TOLERANCE,
            scale: (scale as f32).next_up(),
            is_triangle,
        }
    }

    /// Meets sixteen rays.
    #[inline(always)]
    pub fn meet<S: Simd>(
        &self,
        simd: S,
        origin: &[f32x16<S>; 3],
        direction: &[f32x16<S>; 3],
    ) -> Seen<S> {
        let sink = along(simd, &self.normal, direction, 0.0);
        let height = along(simd, &self.normal, origin, self.minus_distance);
        let least_sink = f32x16::splat(simd, SMALLEST);
        let reciprocal = f32x16::splat(simd, -1.0) / sink.abs().max(least_sink).copysign(sink);
        let t = height * reciprocal;
        let floor = f32x16::splat(simd, PLANE_TOLERANCE);
        let error = reciprocal.abs().mul_add(self.uncertainty, floor);
        let p = [
            t.mul_add(direction[0], origin[0]),
            t.mul_add(direction[1], origin[1]),
            t.mul_add(direction[2], origin[2]),
        ];
        let u = along(simd, &self.u, &p, self.u0);
        let v = along(simd, &self.v, &p, self.v0);
        let least = u.min(v);
        let most = least.mul_add(self.is_triangle, u.max(v));
        let inside = least.min(f32x16::splat(simd, 1.0) - most);
        Seen { near: t - error, far: t + error, inside, margin: error * self.scale }
    }
}

/// `a · p + rest`. A function and not a closure, which would not be compiled for the instruction
/// set.
#[inline(always)]
fn along<S: Simd>(simd: S, a: &[f32; 3], p: &[f32x16<S>; 3], rest: f32) -> f32x16<S> {
    p[0].mul_add(a[0], p[1].mul_add(a[1], p[2].mul_add(a[2], f32x16::splat(simd, rest))))
}

/// The verdict of f32 on a facet and sixteen rays; see "Why no facet of a scene of few is missed" in
/// [`crate::tree::rounding`].
pub(super) struct Seen<S: Simd> {
    /// Bounds on the distance that the exact test finds if it finds any.
    pub near: f32x16<S>,
    pub far: f32x16<S>,
    /// What is not negative on the facet, but for the margin.
    inside: f32x16<S>,
    margin: f32x16<S>,
}

impl<S: Simd> Seen<S> {
    /// The rays that may hit before the limit; none if it is not a number.
    #[inline(always)]
    pub fn hits(&self, limit: f32x16<S>) -> <f32x16<S> as SimdBase<S>>::Mask {
        self.near.simd_le(limit) & self.far.simd_ge(0.0) & self.inside.simd_ge(-self.margin)
    }

    /// The rays that certainly hit somewhere.
    #[inline(always)]
    pub fn certain(&self) -> <f32x16<S> as SimdBase<S>>::Mask {
        self.near.simd_gt(0.0) & self.inside.simd_gt(self.margin)
    }
}
