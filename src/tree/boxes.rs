//! A ray against the eight boxes of a node, in f32.

use super::layout::Node;
use super::rounding::SMALLEST;
use fearless_simd::{Simd, f32x4, f32x8, i32x8, prelude::*, u32x8};

/// A ray in the space of the boxes.
pub(super) struct BoxRay {
    origin: [f32; 3],
    direction: [f32; 3],
    /// The reciprocals of the direction's components.
    reciprocal: [f32; 3],
    /// Minus origin times reciprocal.
    offset: [f32; 3],
    /// True for axes along which the ray runs downwards, and so meets a box's upper plane first.
    backwards: [bool; 3],
}

impl BoxRay {
    #[inline(always)]
    pub fn new(origin: glam::Vec3, direction: glam::Vec3) -> Self {
        let (origin, direction) = (origin.to_array(), direction.to_array());
        // A component too small to matter still needs a finite reciprocal.
        let reciprocal =
            direction.map(|d| 1.0 / if d.abs() < SMALLEST { SMALLEST.copysign(d) } else { d });
        let offset = [0, 1, 2].map(|i| -origin[i] * reciprocal[i]);
        let backwards = reciprocal.map(|r| r < 0.0);
        Self { origin, direction, reciprocal, offset, backwards }
    }
}

/// Vectors that hold one number of the ray in each lane.
pub(super) struct Splat<S: Simd> {
    pub origin: [f32x4<S>; 3],
    pub direction: [f32x4<S>; 3],
    reciprocal: [f32x8<S>; 3],
    offset: [f32x8<S>; 3],
}

#[inline(always)]
fn splat<S: Simd, V: SimdBase<S, Element = f32>>(simd: S, v: &[f32; 3]) -> [V; 3] {
    [V::splat(simd, v[0]), V::splat(simd, v[1]), V::splat(simd, v[2])]
}

impl<S: Simd> Splat<S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &BoxRay) -> Self {
        Self {
            origin: splat(simd, &ray.origin),
            direction: splat(simd, &ray.direction),
            reciprocal: splat(simd, &ray.reciprocal),
            offset: splat(simd, &ray.offset),
        }
    }
}

/// The distances at which the ray enters a node's boxes, as bits, and a bit for each that it enters
/// before `limit`.
///
/// Floats that are not negative have the order of their bits, and finding the greater of two
/// integers takes less time. Negative ones have the reverse order, but since 0 is among the
/// distances of entry and a box that is left at a negative one is missed, it does not matter.
#[inline(always)]
pub(super) fn enter<S: Simd>(
    simd: S,
    ray: &BoxRay,
    wide: &Splat<S>,
    node: Node<'_>,
    limit: f32,
) -> (i32x8<S>, u64) {
    #[cfg(test)]
    super::tests::count(8);
    let plane = |axis: usize, side: bool| {
        let plane = u32x8::load_array_ref(simd, node.planes(axis, side)).bitcast::<f32x8<S>>();
        plane.mul_add(wide.reciprocal[axis], wide.offset[axis]).bitcast::<i32x8<S>>()
    };
    let [x, y, z] = ray.backwards;
    let near = plane(0, x).max(plane(1, y)).max(plane(2, z).max(i32x8::splat(simd, 0)));
    let far = plane(0, !x)
        .min(plane(1, !y))
        .min(plane(2, !z).min(i32x8::splat(simd, limit.to_bits() as i32)));
    (near, near.simd_le(far).to_bitmask())
}
