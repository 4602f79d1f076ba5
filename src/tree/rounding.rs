//! Tolerances of the f32 tests, with their proofs: no box and no triangle is missed that the exact
//! f64 test hits.
//!
//! # Why no box is missed
//!
//! Let ε = 2⁻²⁴ be the rounding of f32. In the space of the boxes a ray travels at most 2√3 and at
//! most 2 along any axis. A plane at x is met at `x r + c`, r being the reciprocal of the
//! direction's component and `c = -o r`. Seen as a displacement of the point at parameter t along
//! one axis, f32 adds
//!
//! | from | at most |
//! |---|---|
//! | rounding the origin o, with a component up to 1 | 1 ε |
//! | rounding the direction | 2 ε |
//! | rounding its reciprocal | 2 ε |
//! | rounding c | 1 ε |
//! | the product and the sum, or both in one (the result is within the cube) | 1 ε + 2 ε |
//! | a component below 2⁻⁶⁰ counts as ±2⁻⁶⁰ | 2⁻⁵⁸ |
//!
//! in all less than 10 ε. A large triangle may have several boxes, each around a part of it (Stich,
//! Friedrich and Dietrich 2009). The parts are cut by obvhs in f32: rounding the corners moves
//! every point by ε at most, and a point where a cut crosses an edge, `a + s (b - a)`, is off by at
//! most 4 ε in s times an edge of 2, 2 ε for the difference and 1 ε for the sum, 12 ε with the
//! corners; a cut through a part intersects boxes that are right up to that. All boxes are padded
//! by 32 ε > 10 ε + 12 ε. Hence the interval of every box that contains the hit at t contains t,
//! and its entry is below any f32 number above t: what the exact test hands back is rounded up.
//!
//! # Why no triangle is missed
//!
//! For the vertex v, edges e₁ and e₂, origin o and direction d, `c = v - o`, `r = c × d` and `n =
//! e₁ × e₂` give `U = r·e₂`, `V = -r·e₁`, `D = n·d`, `W = D - U - V`, and the distance T / D with
//! `T = n·c` (Möller and Trumbore 1997). The exact test accepts iff U, V and W have no opposite
//! signs and T / D is positive and below the limit. With the sums of components `|e|₁` and `S =
//! |e₁|₁ + |e₂|₁`, and with `M = |e₁| |e₂|` and |c| ≤ 2√3, f32 is off by at most
//!
//! | quantity | from | at most |
//! |---|---|---|
//! | c | rounding v and o, the difference | 4 ε per component |
//! | r | c; d; products and difference of up to 2√2 | 15 ε per component |
//! | U, V | r; the edge; three products of up to 2√2 abs(eᵢ) | 27 ε abs(e)₁ |
//! | n | the edges; products and difference | 4 ε M per component |
//! | D | n; d; products | 11 ε M ≤ 19 ε S |
//! | W | U, V and D; two differences | 27 ε S + 19 ε S + 13 ε S = 59 ε S |
//! | T | n; c; products | 24 ε M + 7 ε M + 11 ε M = 42 ε M |
//! | t D | D times t < 3.5; its rounding; the limit's, by 5 ε upwards | 39 ε M + 4 ε M + 18 ε M |
//! | T - t D | T; t D | 42 ε M + 61 ε M = 103 ε M |
//!
//! U, V and W are compared with ∓64 ε S, T with 0 and the limit times D up to 112 ε M, all plus
//! 2⁻³⁹ for the exact test's own rounding: its edge functions are those of coordinates up to 4 with
//! at most 16 roundings of 2⁻⁵³ each, off by less than 2⁻⁴⁴; where that is all that is left of
//! them, T - t D is off by 3 · 8 times as much. If the sign of D is not certain, |D| is below its
//! error, and so is |T - t D|. By the same bounds a triangle is certainly hit if it passes with the
//! tolerances turned inwards; the any-hit query needs no more.
//!
//! Whatever is not flat is always tested exactly.
//!
//! # Why an exact test may wait
//!
//! The nearest hit needs one exact test as a rule, when all else is done. For a triangle that is
//! certainly hit, the rows T and D of the table say that T - L D is off by at most (42 + 11 L) ε M,
//! which is below the tolerance of 112 ε M for all L < 6. So the exact distance lies between (T -
//! 112 ε M) / D and (T + 112 ε M) / D; the sum, the reciprocal of D and the product in f32, and
//! making the bounds wider by 6 ε, are another 4 ε of them. The upper bound then limits the walk as
//! an exact distance would, and the triangle is held back. Another one that is certainly nearer
//! takes its place, one that is certainly farther is dropped, and one of which neither is certain
//! is tested exactly at once. What was dropped is farther than something that is hit, and all that
//! was not dropped is compared by its exact distance, so the answer is the same.
//!
//! # Rays from afar
//!
//! A ray that comes from another space is moved to the box of this one for the tests in f32 alone;
//! the exact test takes it as it is. Let R be the largest component of `v - o`, in units of this
//! space, and u = 2⁻⁵³. The exact test sees vertices in the ray's coordinates, `x - s z` with |s| ≤
//! 1, off by u R for either component, 2 u R for s, and 2 u R for product and difference, in all
//! less than 7 u R. For what is left its [signs](crate::geometry::Triangle::intersect) are exact,
//! so it accepts nothing but what the ray passes within 7 u R of, or by chance a triangle that is
//! smaller than 4 u of its distance from the ray, whose edge functions round to 0; boxes leave that
//! out. The distance is the mean of those to the vertices and off by 7 u √3 R. The ray that was
//! moved is off by 3 u R.
//!
//! Up to R = 2²⁰ all of that is less than ε / 16, for which every tolerance above has room. From
//! farther away a walk in f64 pads all boxes by [`blur`], 16 u R, and takes whatever is in the
//! leaves that it meets for a candidate.
//!
//! The same holds for rays of a space and shapes that reach in from outside: their boxes are the
//! parts inside, padded by the blur of their most distant corner, and they are tested exactly.

use glam::DVec3;

/// Rounding of f32, ε = 2⁻²⁴.
pub(super) const ROUNDOFF: f32 = 0.5 * f32::EPSILON;

/// Padding of the boxes: 32 ε.
pub(super) const PADDING: f32 = 32.0 * ROUNDOFF;

/// The magnitude that smaller components of a direction count as.
pub(super) const SMALLEST: f32 = 1.0 / (1u64 << 60) as f32;

/// A bound on the distance of any hit, since rays start in or at the cube [-1, 1]³.
pub(super) const FAR: f32 = 4.0;

/// The error bound of a triangle's edge functions, in units of the sum of its edges' components.
const EDGE_TOLERANCE: f64 = 64.0 * ROUNDOFF as f64;

/// The error bound of the distance to a triangle times the determinant, in units of the product of
/// its edges' lengths.
const DISTANCE_TOLERANCE: f64 = 112.0 * ROUNDOFF as f64;

/// The error bound of either in f64.
const TOLERANCE_F64: f64 = 1.0 / (1u64 << 39) as f64;

/// Rays are moved to a cube that is larger than the scene by this much, so that moving does not cut
/// off its boundary.
pub(super) const CLIP: f64 = 1.0 + 4.0 * PADDING as f64;

/// The rounding of an origin at `place` in the cube's space, which of a far one may exceed the
/// cube's margin.
#[inline(always)]
pub(super) fn uncertainty_of_place(place: DVec3) -> f64 {
    place.abs().max_element() * (8.0 * f64::EPSILON)
}

/// The distance, in units of a space, up to which rays from other spaces are tested in f32.
pub(super) const NEAR: f64 = (1u64 << 20) as f64;

/// A bound on how far the exact test may be off where coordinates relative to the ray's origin are
/// up to `distance`.
#[inline(always)]
pub(super) fn blur(distance: f64) -> f64 {
    distance * (8.0 * f64::EPSILON)
}

/// The error bounds of the edge functions of a triangle with these edges, and of its distance times
/// the determinant; rounded up.
pub(super) fn tolerances_of_triangle(edge1: DVec3, edge2: DVec3) -> [f32; 2] {
    let up = |x: f64| (x as f32).next_up();
    let size = edge1.abs().element_sum() + edge2.abs().element_sum();
    [
        up(EDGE_TOLERANCE * size + TOLERANCE_F64),
        up(DISTANCE_TOLERANCE * edge1.length() * edge2.length() + TOLERANCE_F64),
    ]
}

/// A distance, rounded up far enough to exceed the entry of every box that contains a hit there.
#[inline(always)]
pub(super) fn distance_up(t: f64) -> f32 {
    (t * (1.0 + 4.0 * f64::from(ROUNDOFF))) as f32 + f32::MIN_POSITIVE
}
