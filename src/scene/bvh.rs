//! The acceleration structure: [`binary`] builds a tree over padded f32 boxes, [`Wide`] makes nodes
//! of eight boxes and blocks of four triangles of it, and exact f64 tests decide what is hit.
//!
//! Boxes and blocks live in a [`Space`] of their own, in which the scene lies in [-1, 1]³. So
//! neither the scene's scale nor its distance from the origin reaches the f32 numbers. A ray from
//! outside is first moved, in f64, to where it enters the cube around the scene; the exact tests
//! see that moved ray too, so that a far origin's rounding is the same for all primitives and opens
//! no gap between them. Since nothing that the exact test accepts is left out, the answer depends
//! neither on the tree nor on the instruction set.
//!
//! Where the f32 numbers of a block tell the corners of a triangle exactly, the exact test takes
//! them from there, which saves fetching the shape. They do for most triangles whose positions are
//! f32 numbers: vertices stay such numbers in the space, and their differences are, too, unless an
//! edge is longer than its ends' distances from a plane through the space's origin, roughly.
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
//! | T - t D | T; D times t < 3.5; its rounding; the limit's, rounded up by 5 ε | 42 ε M + 39 ε M + 4 ε M + 18 ε M = 103 ε M |
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

use super::binary;
use super::packet::FEW;
use super::query::{Found, Hit, Query, Segment, unit};
use super::space::Space;
use super::traverse::{Any, BoxRay, Nearest, Splat, Stack, Step, prefetch};
use super::wide::{self, Block, Candidate, Facet, Line, Wide};
use crate::geometry::{Bounds, Contact, Intersection, Ray, Shape, Triangle};
use fearless_simd::{Level, Simd, dispatch};
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use std::time::{Duration, Instant};

/// Rounding of f32.
pub(super) const ROUNDOFF: f32 = 0.5 * f32::EPSILON;

/// Padding of the boxes; see the module's documentation.
const PADDING: f32 = 32.0 * ROUNDOFF;

/// What a triangle's edge functions may be off by, in units of the sum of its edges' components.
pub(super) const EDGE_TOLERANCE: f64 = 64.0 * ROUNDOFF as f64;

/// What the distance to a triangle times the determinant may be off by, in units of the product of
/// its edges' lengths.
pub(super) const DISTANCE_TOLERANCE: f64 = 112.0 * ROUNDOFF as f64;

/// What either may be off by in f64.
pub(super) const TOLERANCE_F64: f64 = 1.0 / (1u64 << 39) as f64;

/// Rays are moved to a cube that is larger than the scene by this much, so that moving does not cut
/// off its boundary.
const CLIP: f64 = 1.0 + 4.0 * PADDING as f64;

/// A tree over all primitives of a scene.
pub(crate) struct Bvh {
    pub(super) wide: Wide,
    /// All facets of a scene that has few, in which all are triangles.
    pub(super) few: Vec<[Line; Block::LINES]>,
    /// All primitives, by their number.
    shapes: Vec<Shape>,
    space: Space,
    /// The middle of the scene and half its largest side.
    center: DVec3,
    pub(super) extent: f64,
    inverse_extent: f64,
    /// The instruction set that this processor has.
    pub(super) level: Level,
    build_time: Duration,
}

/// What the acceleration structure of a [`World`](super::World) consists of.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TreeStatistics {
    /// Nodes, each with up to eight boxes.
    pub nodes: usize,
    /// Leaves, each with up to four triangles.
    pub leaves: usize,
    /// Memory of nodes, leaves and shapes, bytes.
    pub bytes: usize,
    /// How long it took to build, wall-clock time.
    pub build_time: Duration,
    /// The instruction set that rays use, chosen at run time.
    pub instruction_set: &'static str,
}

/// The second half of a quad; the first one and everything else are referred to by the primitive's
/// number.
const SECOND_HALF: u32 = 1 << 31;

impl Bvh {
    /// Builds the tree; primitives are numbered in the given order.
    pub fn new(shapes: Vec<Shape>, bounds: &Bounds) -> Self {
        let start = Instant::now();
        let (center, extent) = if shapes.is_empty() {
            (DVec3::ZERO, 1.0)
        } else {
            (bounds.center(), 0.5 * (bounds.max - bounds.min).max_element())
        };
        let inverse_extent = 1.0 / extent;
        let space = Space::new(center, extent);
        let place = |p| space.place(p);
        let facet = |reference: u32| {
            let primitive = reference & !SECOND_HALF;
            let facet = match &shapes[primitive as usize] {
                Shape::Triangle(t) => {
                    let [a, b, c] = t.vertices;
                    let exact = [a, b, c]
                        .into_iter()
                        .all(|corner| space.world(place(corner), [0, 1, 2]) == corner);
                    Facet::Triangle { corners: [place(a), place(b), place(c)], exact }
                }
                Shape::Quad(q) => {
                    let [a, b, c, d] = q.corners();
                    let [second, third] = if reference == primitive { [b, c] } else { [c, d] };
                    Facet::Triangle {
                        corners: [place(a), place(second), place(third)],
                        exact: false,
                    }
                }
                Shape::Sphere(_) | Shape::Disk(_) => Facet::Opaque,
            };
            (primitive, facet)
        };
        let mut references: Vec<u32> = Vec::with_capacity(shapes.len());
        for (primitive, shape) in shapes.iter().enumerate() {
            references.push(primitive as u32);
            if matches!(shape, Shape::Quad(_)) {
                references.push(primitive as u32 | SECOND_HALF);
            }
        }
        // Every ray would test what is opaque exactly.
        let is_flat = |&reference: &u32| matches!(facet(reference).1, Facet::Triangle { .. });
        let has_few = references.len() <= FEW && references.iter().all(is_flat);
        let few = if has_few { wide::blocks(&references, facet) } else { Vec::new() };
        let mut boxes: Vec<Aabb> = references
            .iter()
            .map(|&reference| {
                let bounds = match facet(reference) {
                    (_, Facet::Triangle { corners, .. }) => Bounds::of_points(corners),
                    (primitive, Facet::Opaque) => {
                        let b = shapes[primitive as usize].bounds();
                        Bounds { min: place(b.min), max: place(b.max) }
                    }
                };
                let down = |x: f64| (x as f32).next_down();
                let up = |x: f64| (x as f32).next_up();
                let (min, max) = (bounds.min, bounds.max);
                Aabb::new(
                    Vec3A::new(down(min.x), down(min.y), down(min.z)),
                    Vec3A::new(up(max.x), up(max.y), up(max.z)),
                )
            })
            .collect();
        binary::split_large(&mut boxes, &mut references, facet);
        for b in &mut boxes {
            *b = Aabb::new(b.min - PADDING, b.max + PADDING);
        }
        let tree = binary::build(&boxes);
        drop(boxes);
        let references: Vec<u32> =
            tree.primitive_indices.iter().map(|&i| references[i as usize]).collect();
        let wide = Wide::collapse(&tree.nodes, &references, facet);
        Self {
            wide,
            few,
            shapes,
            space,
            center,
            extent,
            inverse_extent,
            level: Level::new(),
            build_time: start.elapsed(),
        }
    }

    /// Uses another instruction set, which this processor must have.
    #[cfg(test)]
    pub fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    /// What the tree consists of.
    pub fn statistics(&self) -> TreeStatistics {
        let Wide { lines, nodes, blocks } = &self.wide;
        TreeStatistics {
            nodes: *nodes,
            leaves: *blocks,
            bytes: size_of_val(&lines[..])
                + size_of_val(&self.few[..])
                + size_of_val(&self.shapes[..]),
            build_time: self.build_time,
            instruction_set: dispatch!(self.level, simd => instruction_set(simd)),
        }
    }

    /// The middle of the scene; zero if there is nothing in it.
    #[inline]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// The shape of a primitive.
    pub fn shape(&self, primitive: u32) -> Option<&Shape> {
        self.shapes.get(primitive as usize)
    }

    /// What `result` makes of the nearest hit, of equally near ones that with the lowest primitive.
    /// A direction that is not of unit length is made so.
    #[inline]
    pub fn closest<'a, R>(&'a self, query: Query, result: impl FnOnce(Hit<'a>) -> R) -> Option<R> {
        // Moving more than is needed through memory takes time.
        dispatch!(self.level, simd => self.closest_with(simd, query).map(result))
    }

    #[inline(always)]
    pub(super) fn closest_with<S: Simd>(&self, simd: S, query: Query) -> Option<Hit<'_>> {
        let (origin, direction, moved) = self.entry(query.origin, query.direction)?;
        let box_ray = self.box_ray(origin, direction);
        let wide = Splat::new(simd, &box_ray);
        let ray = Ray::new(origin, direction);
        let (mut walk, mut stack, mut early) = (Nearest::default(), Stack::default(), None);
        while self.step_to_nearest(
            simd,
            &box_ray,
            &wide,
            &mut walk,
            &mut stack,
            &ray,
            query.origin_primitive,
            &mut early,
        ) != Step::Done
        {}
        let found = self.decide(walk.held, early, &ray, query.origin_primitive)?;
        Some(found.hit(&ray, moved))
    }

    /// Where a ray enters the scene, its direction with unit length, and by how much the origin was
    /// moved; `None` if it does not enter or is no ray.
    #[inline(always)]
    pub(super) fn entry(&self, origin: DVec3, direction: DVec3) -> Option<(DVec3, DVec3, f64)> {
        let direction = unit(direction)?;
        let (origin, moved) = self.clip(origin, direction)?;
        Some((origin, direction, moved))
    }

    /// A point in the space of the boxes.
    #[inline(always)]
    pub(super) fn place(&self, p: DVec3) -> Vec3 {
        self.space.place(p).as_vec3()
    }

    #[inline(always)]
    pub(super) fn box_ray(&self, origin: DVec3, direction: DVec3) -> BoxRay {
        BoxRay::new(self.place(origin), direction.as_vec3())
    }

    /// Visits one node or leaf. What had to be tested early goes to `early` if it is nearer.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub(super) fn step_to_nearest<'a, S: Simd>(
        &'a self,
        simd: S,
        box_ray: &BoxRay,
        wide: &Splat<S>,
        walk: &mut Nearest<'a>,
        stack: &mut Stack<u64>,
        ray: &Ray,
        origin_primitive: u32,
        early: &mut Option<Found<'a>>,
    ) -> Step {
        let test = |candidate| self.test_early(candidate, ray, origin_primitive, early);
        let prepare = |candidate: Candidate<'a>| {
            if !candidate.is_exact() {
                prefetch(simd, self.shapes.as_ptr().wrapping_add(candidate.primitive() as usize));
            }
        };
        self.wide.step_to_nearest(simd, box_ray, wide, walk, stack, origin_primitive, prepare, test)
    }

    /// The nearer one of what was held back and what was tested early.
    #[inline(always)]
    pub(super) fn decide<'a>(
        &self,
        held: Option<Candidate<'a>>,
        early: Option<Found<'a>>,
        ray: &Ray,
        origin_primitive: u32,
    ) -> Option<Found<'a>> {
        match (held.and_then(|held| self.find(held, ray, origin_primitive)), early) {
            (Some(held), Some(early)) if early.is_nearer(&held) => Some(early),
            (held, early) => held.or(early),
        }
    }

    /// The exact test of what may be the nearest hit.
    #[inline(always)]
    fn find<'a>(
        &self,
        candidate: Candidate<'a>,
        ray: &Ray,
        origin_primitive: u32,
    ) -> Option<Found<'a>> {
        let contact =
            if candidate.primitive() == origin_primitive { Contact::Origin } else { Contact::None };
        let intersection = self.intersect(candidate, ray, contact)?;
        Some(Found { candidate, intersection })
    }

    /// Replaces the nearest hit if this one is nearer, and returns the limit from then on. Rare,
    /// and so not a part of the walk.
    #[inline(never)]
    pub(super) fn test_early<'a>(
        &self,
        candidate: Candidate<'a>,
        ray: &Ray,
        origin_primitive: u32,
        nearest: &mut Option<Found<'a>>,
    ) -> Option<f32> {
        let found = self.find(candidate, ray, origin_primitive)?;
        if nearest.as_ref().is_some_and(|nearest| !found.is_nearer(nearest)) {
            return None;
        }
        let limit = self.round_up(found.intersection.t);
        *nearest = Some(found);
        Some(limit)
    }

    /// The exact test.
    #[inline(always)]
    fn intersect(
        &self,
        candidate: Candidate<'_>,
        ray: &Ray,
        contact: Contact,
    ) -> Option<Intersection> {
        if !candidate.is_exact() {
            return self.shapes[candidate.primitive() as usize].intersect_apart_from(ray, contact);
        }
        if contact != Contact::None {
            return None;
        }
        ray.meet(self.corners(candidate, ray.axes()))
    }

    /// The corners of a triangle that is exact, with coordinates in the given order.
    #[inline(always)]
    fn corners(&self, candidate: Candidate<'_>, axes: [usize; 3]) -> [DVec3; 3] {
        let [a, b, c] = candidate.corners(axes);
        [self.space.world(a, axes), self.space.world(b, axes), self.space.world(c, axes)]
    }

    /// The triangle that was hit; `None` if it is another shape.
    #[inline(always)]
    pub fn triangle_of(&self, hit: &Hit<'_>) -> Option<Triangle> {
        if hit.candidate.is_exact() {
            return Some(Triangle { vertices: self.corners(hit.candidate, [0, 1, 2]) });
        }
        self.shapes[hit.primitive as usize].as_triangle()
    }

    /// Whether nothing lies on a segment. A direction that is not of unit length is made so.
    #[inline]
    pub fn is_free(&self, segment: &Segment) -> bool {
        dispatch!(self.level, simd => self.is_free_with(simd, segment))
    }

    #[inline(always)]
    pub(super) fn is_free_with<S: Simd>(&self, simd: S, segment: &Segment) -> bool {
        let Some(segment) = self.part_inside(segment) else { return true };
        let box_ray = self.box_ray(segment.origin, segment.direction);
        let wide = Splat::new(simd, &box_ray);
        let (mut walk, mut stack) = (self.walk_to_any(&segment), Stack::default());
        while self.step_to_any(simd, &box_ray, &wide, &mut walk, &mut stack, &segment) != Step::Done
        {
        }
        !walk.hit
    }

    /// The part of a segment inside of the scene, with a direction of unit length; `None` if there
    /// is none.
    #[inline(always)]
    pub(super) fn part_inside(&self, segment: &Segment) -> Option<Segment> {
        let (origin, direction, moved) = self.entry(segment.origin, segment.direction)?;
        let length = segment.length - moved;
        // Not if it is no number either.
        (length > 0.0).then_some(Segment { origin, direction, length, ends: segment.ends })
    }

    /// The walk along a segment inside of the scene.
    #[inline(always)]
    pub(super) fn walk_to_any(&self, segment: &Segment) -> Any {
        Any::new(self.round_up(segment.length))
    }

    /// Visits one node or leaf.
    #[inline(always)]
    pub(super) fn step_to_any<S: Simd>(
        &self,
        simd: S,
        box_ray: &BoxRay,
        wide: &Splat<S>,
        walk: &mut Any,
        stack: &mut Stack<u32>,
        segment: &Segment,
    ) -> Step {
        let blocks = |candidate: Candidate<'_>, certain: bool| {
            let primitive = candidate.primitive();
            if certain && primitive != segment.ends.origin && primitive != segment.ends.end {
                return true;
            }
            self.blocks(candidate, segment)
        };
        self.wide.step_to_any(simd, box_ray, wide, walk, stack, blocks)
    }

    /// The exact test of what may be in the way. Rare, and so not a part of the walk.
    #[inline(never)]
    pub(super) fn blocks(&self, candidate: Candidate<'_>, segment: &Segment) -> bool {
        let &Segment { origin, direction, length, ends } = segment;
        let primitive = candidate.primitive();
        let contact = match (primitive == ends.origin, primitive == ends.end) {
            (false, false) => Contact::None,
            (true, false) => Contact::Origin,
            (false, true) => Contact::End(length),
            (true, true) => Contact::Both,
        };
        self.intersect(candidate, &Ray::new(origin, direction), contact)
            .is_some_and(|hit| hit.t < length)
    }

    /// A distance in the space of the boxes, rounded up far enough to exceed the entry of every box
    /// that contains a hit there.
    #[inline(always)]
    pub(super) fn round_up(&self, t: f64) -> f32 {
        (t * self.space.inverse_extent * (1.0 + 4.0 * f64::from(ROUNDOFF))) as f32
            + f32::MIN_POSITIVE
    }

    /// The origin, moved to where the ray enters the scene, and by how much it was moved; `None` if
    /// the ray does not enter, or is no ray.
    #[inline(always)]
    fn clip(&self, origin: DVec3, direction: DVec3) -> Option<(DVec3, f64)> {
        let place = (origin - self.center) * self.inverse_extent;
        let inside = place.x.abs() <= CLIP && place.y.abs() <= CLIP && place.z.abs() <= CLIP;
        if inside { Some((origin, 0.0)) } else { self.enter(origin, place, direction) }
    }

    /// The same for an origin outside of the scene, whose place in the cube around the scene is
    /// given.
    #[inline(never)]
    fn enter(&self, origin: DVec3, place: DVec3, direction: DVec3) -> Option<(DVec3, f64)> {
        if !place.is_finite() {
            return None;
        }
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let inverse = 1.0 / direction[axis];
            let (a, b) = ((-CLIP - place[axis]) * inverse, (CLIP - place[axis]) * inverse);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        // A far origin is known to its own rounding only, which may exceed the cube's margin.
        let uncertainty = place.abs().max_element() * (8.0 * f64::EPSILON);
        if near > far + uncertainty {
            return None;
        }
        let moved = near * self.extent;
        Some((origin + direction * moved, moved))
    }
}

/// The last part of an instruction set's type name.
fn instruction_set<S: Simd>(_: S) -> &'static str {
    std::any::type_name::<S>().rsplit("::").next().unwrap_or_default()
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh")
            .field("primitives", &self.shapes.len())
            .field("nodes", &self.wide.nodes)
            .finish_non_exhaustive()
    }
}
