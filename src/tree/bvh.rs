//! The tree and its answers to a single query: the nearest hit, or whether a segment is free.

use super::boxes::{BoxRay, Splat};
use super::layout::{Candidate, Wide};
use super::packet::Few;
use super::query::{Found, Hit, Query, Segment, unit};
use super::rounding::{self, CLIP};
use super::space::Space;
use super::stack::{Stack, prefetch};
use super::traverse::{Any, Nearest, Step};
use crate::geometry::{Ray, Shape};
use crate::lanes::dispatch;
use fearless_simd::{Level, Simd};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// A tree over primitives of a scene, in one space.
pub(crate) struct Bvh {
    pub(super) wide: Wide,
    /// All primitives of a tree that has few.
    pub(super) few: Option<Few>,
    /// All primitives of the scene, by their number.
    pub(super) shapes: Arc<[Shape]>,
    pub(super) space: Space,
    /// The middle of the scene and half its largest side.
    pub(super) center: DVec3,
    pub(super) extent: f64,
    pub(super) inverse_extent: f64,
    /// The instruction set that this processor has.
    pub(super) level: Level,
}

impl Bvh {
    /// The name of the instruction set.
    pub fn instruction_set(&self) -> &'static str {
        dispatch!(self.level, simd => instruction_set(simd))
    }

    /// The nearest hit, of equally near ones that with the lowest primitive, as `result` returns
    /// it. A direction that is not of unit length is made so.
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
        Some(found.hit(moved))
    }

    /// The point at which a ray enters the scene, its direction with unit length, and the distance
    /// that the origin was moved; `None` if it does not enter or is no ray.
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

    /// True if nothing lies on a segment. A direction that is not of unit length is made so.
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

    /// A distance in the space of the boxes, rounded up beyond the entry of every box that contains
    /// a hit there.
    #[inline(always)]
    pub(super) fn round_up(&self, t: f64) -> f32 {
        rounding::distance_up(t * self.space.inverse_extent)
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
        if near > far + rounding::uncertainty_of_place(place) {
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
        f.debug_struct("Bvh").field("nodes", &self.wide.nodes).finish_non_exhaustive()
    }
}
