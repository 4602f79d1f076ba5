//! The exact f64 tests that decide what is hit.

use super::bvh::Bvh;
use super::layout::Candidate;
use super::query::{Found, Hit, Segment};
use crate::geometry::{Contact, Intersection, Ray, Triangle};
use glam::DVec3;

impl Bvh {
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
        #[cfg(test)]
        super::tests::count(8);
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
}
