//! Rays against triangles, in f32, with tolerances that let nothing slip.

use super::layout::{Block, LANES};
use super::rounding::ROUNDOFF;
use fearless_simd::{Simd, f32x4, prelude::*, u32x4};

/// Triangles, in each lane the same or another: a vertex, edges and normal, by how much edge
/// functions and distance may be off.
pub(super) struct Facets<V> {
    pub vertex: [V; 3],
    pub edge1: [V; 3],
    pub edge2: [V; 3],
    pub normal: [V; 3],
    pub tolerance: V,
    pub slack: V,
}

impl<S: Simd> Facets<f32x4<S>> {
    /// Those of a block.
    #[inline(always)]
    pub fn new(simd: S, block: Block<'_>) -> Self {
        let row = |v: &[u32; LANES]| u32x4::load_array_ref(simd, v).bitcast::<f32x4<S>>();
        let load = |v: [&[u32; LANES]; 3]| [row(v[0]), row(v[1]), row(v[2])];
        let (edge1, edge2) = (load(block.edge1()), load(block.edge2()));
        Self {
            vertex: load(block.vertex()),
            edge1,
            edge2,
            normal: cross(edge1, edge2),
            tolerance: row(block.tolerance()),
            slack: row(block.distance_tolerance()),
        }
    }
}

#[inline(always)]
fn cross<S: Simd, V: SimdFloat<S>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [
        a[1].mul_sub(b[2], a[2] * b[1]),
        a[2].mul_sub(b[0], a[0] * b[2]),
        a[0].mul_sub(b[1], a[1] * b[0]),
    ]
}

#[inline(always)]
fn dot<S: Simd, V: SimdFloat<S>>(a: [V; 3], b: [V; 3]) -> V {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// The verdict of the test in f32 on rays and triangles, in each lane one of each; see "Why no
/// triangle is missed" in [`super::rounding`].
pub(super) struct Tested<S: Simd, V: SimdBase<S>> {
    /// The triangles that the ray may hit before the limit.
    pub hits: V::Mask,
    tolerance: V,
    slack: V,
    /// The least and the greatest edge function.
    least: V,
    most: V,
    /// Positive, with the distance times it.
    determinant: V,
    t: V,
}

impl<S: Simd, V: SimdFloat<S, Element = f32>> Tested<S, V> {
    #[inline(always)]
    pub fn new(simd: S, origin: &[V; 3], direction: &[V; 3], limit: V, facets: Facets<V>) -> Self {
        let Facets { vertex, edge1, edge2, normal, tolerance, slack } = facets;
        let c = [vertex[0] - origin[0], vertex[1] - origin[1], vertex[2] - origin[2]];
        let r = cross(c, *direction);
        let determinant = dot(normal, *direction);
        let u = dot(r, edge2);
        let minus_v = dot(r, edge1);
        let w = determinant - u + minus_v;
        let v = -minus_v;
        let (least, most) = (u.min(v).min(w), u.max(v).max(w));
        let t = dot(normal, c);
        let sign = V::splat(simd, 1.0).copysign(determinant);
        let (t, determinant) = (t * sign, determinant * sign);
        let inside = least.simd_ge(-tolerance) | most.simd_le(tolerance);
        let reached = t.simd_ge(-slack) & t.simd_le(determinant.mul_add(limit, slack));
        Self { hits: inside & reached, tolerance, slack, least, most, determinant, t }
    }

    /// The triangles that the ray certainly hits somewhere.
    #[inline(always)]
    pub fn certain(&self) -> V::Mask {
        let inside = self.least.simd_gt(self.tolerance) | self.most.simd_lt(-self.tolerance);
        inside & self.t.simd_gt(self.slack)
    }

    /// The same for before the limit.
    #[inline(always)]
    pub fn certain_before(&self, limit: V) -> V::Mask {
        self.certain() & self.t.simd_lt(self.determinant * limit - self.slack)
    }

    /// Bounds on the distance to triangles that are certainly hit.
    #[inline(always)]
    pub fn interval(&self, simd: S) -> (V, V) {
        let reciprocal = V::splat(simd, 1.0) / self.determinant;
        let (near, far) = ((self.t - self.slack) * reciprocal, (self.t + self.slack) * reciprocal);
        (near * (1.0 - 6.0 * ROUNDOFF), far * (1.0 + 6.0 * ROUNDOFF))
    }
}
