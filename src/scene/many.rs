//! Many queries at once: several rays are under way and take turns, so that while one waits for memory the others go on.
//!
//! What a ray visits does not depend on the others, so the answers are those of single queries.

use super::bvh::{Bvh, Ends, Found, Hit, Query, Segment};
use super::packet::{self, Entry, RAYS};
use super::traverse::{Any, BoxRay, Nearest, Splat, Stack, Step};
use crate::geometry::Ray;
use fearless_simd::{Simd, dispatch};
use glam::{DVec3, Vec3};

/// Rays under way at a time.
const FLIGHTS: usize = 8;

/// Cosine of the angle up to which rays from the same point, such as a camera's, visit mostly the same.
const COHERENT: f64 = 0.99;

impl Bvh {
    /// What [`closest`](Self::closest) says of many rays, each with its place in the iterator, in any order.
    #[inline]
    pub fn closest_many<'a>(&'a self, queries: impl Iterator<Item = Query>, mut found: impl FnMut(usize, Option<Hit<'a>>)) {
        self.closest_together(&mut { queries }, &mut found);
    }

    /// Compiled once, and not for every caller, for it is long: for all instruction sets.
    #[inline(never)]
    fn closest_together<'a>(&'a self, queries: &mut dyn Iterator<Item = Query>, found: &mut dyn FnMut(usize, Option<Hit<'a>>)) {
        if are_few(queries) {
            return queries.enumerate().for_each(|(index, query)| found(index, self.closest(query, |hit| hit)));
        }
        dispatch!(self.level, simd => self.closest_many_with(simd, queries, found));
    }

    #[inline(always)]
    fn closest_many_with<'a, S: Simd>(&'a self, simd: S, queries: impl Iterator<Item = Query>, found: impl FnMut(usize, Option<Hit<'a>>)) {
        if packet::pays(simd) && !self.few.is_empty() {
            packet::closest(simd, self, &self.few, queries, found);
        } else {
            take_turns::<_, NearestFlight<'_>>(simd, self, queries, found);
        }
    }

    /// What [`is_free`](Self::is_free) says of many segments, or what is known of one already, with its place in the iterator, in any order.
    #[inline]
    pub fn are_free(&self, segments: impl Iterator<Item = Result<Segment, bool>>, mut answer: impl FnMut(usize, bool)) {
        self.are_free_together(&mut { segments }, &mut answer);
    }

    #[inline(never)]
    fn are_free_together(&self, segments: &mut dyn Iterator<Item = Result<Segment, bool>>, answer: &mut dyn FnMut(usize, bool)) {
        if are_few(segments) {
            let is_free = |segment: Result<Segment, bool>| segment.map_or_else(|known| known, |segment| self.is_free(&segment));
            return segments.enumerate().for_each(|(index, segment)| answer(index, is_free(segment)));
        }
        dispatch!(self.level, simd => self.are_free_with(simd, segments, answer));
    }

    #[inline(always)]
    fn are_free_with<S: Simd>(&self, simd: S, segments: impl Iterator<Item = Result<Segment, bool>>, answer: impl FnMut(usize, bool)) {
        if packet::pays(simd) && !self.few.is_empty() {
            packet::are_free(simd, self, &self.few, segments, answer);
        } else {
            take_turns::<_, AnyFlight>(simd, self, segments, answer);
        }
    }
}

/// Whether there are so few queries that what it takes to begin would not pay.
#[inline]
fn are_few<T>(queries: &dyn Iterator<Item = T>) -> bool {
    queries.size_hint().1.is_some_and(|most| most < 4)
}

/// A query under way. Methods and not closures, which cannot be told to be compiled for the instruction set.
trait Flight<'a>: Default {
    type Query: Copy;
    type Answer;

    /// Whether a query will visit what the one before did, so that there is nothing to wait for.
    fn follows(before: &Self::Query, query: &Self::Query) -> bool;

    /// The answers to such queries, of which there are up to sixteen. They need not take turns.
    fn together<S: Simd>(
        simd: S,
        bvh: &'a Bvh,
        stack: &mut Stack<Entry>,
        queries: &[(usize, Self::Query)],
        answer: &mut impl FnMut(usize, Self::Answer),
    );

    fn start(&mut self, bvh: &'a Bvh, query: Self::Query);

    fn step<S: Simd>(&mut self, simd: S, bvh: &'a Bvh) -> Step;

    fn end(&mut self, bvh: &'a Bvh) -> Self::Answer;
}

/// Lets each query go on until it has to wait, one after the other.
#[inline(always)]
fn take_turns<'a, S: Simd, F: Flight<'a>>(
    simd: S,
    bvh: &'a Bvh,
    queries: impl Iterator<Item = F::Query>,
    mut answer: impl FnMut(usize, F::Answer),
) {
    let mut queries = queries.enumerate().fuse();
    let mut flights: [(Option<usize>, F); FLIGHTS] = Default::default();
    let mut before = None;
    let mut next = queries.next();
    let mut stack = Stack::default();
    loop {
        let mut under_way = false;
        for (slot, flight) in &mut flights {
            loop {
                let index = match *slot {
                    Some(index) => index,
                    None => {
                        let Some((index, query)) = next else { break };
                        if before.is_some_and(|before| F::follows(&before, &query)) {
                            let mut fan = [(index, query); RAYS];
                            let mut count = 0;
                            while count < RAYS
                                && let Some((index, query)) = next
                                && before.is_some_and(|before| F::follows(&before, &query))
                            {
                                fan[count] = (index, query);
                                count += 1;
                                before = Some(query);
                                next = queries.next();
                            }
                            F::together(simd, bvh, &mut stack, &fan[..count], &mut answer);
                            continue;
                        }
                        before = Some(query);
                        next = queries.next();
                        flight.start(bvh, query);
                        *slot = Some(index);
                        index
                    }
                };
                match flight.step(simd, bvh) {
                    Step::Descended => {
                        under_way = true;
                        break;
                    }
                    Step::Returned => {}
                    Step::Done => {
                        answer(index, flight.end(bvh));
                        *slot = None;
                    }
                }
            }
        }
        if !under_way {
            return;
        }
    }
}

/// A ray on its way to the nearest hit.
struct NearestFlight<'a> {
    walk: Nearest<'a>,
    stack: Stack<u64>,
    box_ray: BoxRay,
    ray: Ray,
    moved: f64,
    origin_primitive: u32,
    early: Option<Found<'a>>,
}

impl Default for NearestFlight<'_> {
    #[inline(always)]
    fn default() -> Self {
        Self {
            walk: Nearest::default(),
            stack: Stack::default(),
            box_ray: BoxRay::new(Vec3::ZERO, Vec3::ZERO),
            ray: Ray::new(DVec3::ZERO, DVec3::X),
            moved: 0.0,
            origin_primitive: 0,
            early: None,
        }
    }
}

impl<'a> Flight<'a> for NearestFlight<'a> {
    type Query = Query;
    type Answer = Option<Hit<'a>>;

    #[inline(always)]
    fn follows(before: &Query, query: &Query) -> bool {
        query.origin == before.origin && query.direction.dot(before.direction) > COHERENT
    }

    #[inline(always)]
    fn together<S: Simd>(
        simd: S,
        bvh: &'a Bvh,
        stack: &mut Stack<Entry>,
        queries: &[(usize, Query)],
        answer: &mut impl FnMut(usize, Option<Hit<'a>>),
    ) {
        if packet::pays(simd)
            && let Ok(queries) = queries.try_into()
            && packet::closest_together(simd, bvh, queries, stack, answer).is_some()
        {
            return;
        }
        for &(index, query) in queries {
            answer(index, bvh.closest_with(simd, query));
        }
    }

    #[inline(always)]
    fn start(&mut self, bvh: &'a Bvh, Query { origin, direction, origin_primitive }: Query) {
        let Some((origin, direction, moved)) = bvh.entry(origin, direction) else {
            self.walk = Nearest::ended();
            return;
        };
        self.walk = Nearest::default();
        self.box_ray = bvh.box_ray(origin, direction);
        self.ray = Ray::new(origin, direction);
        (self.moved, self.origin_primitive) = (moved, origin_primitive);
    }

    #[inline(always)]
    fn step<S: Simd>(&mut self, simd: S, bvh: &'a Bvh) -> Step {
        let Self { walk, stack, box_ray, ray, origin_primitive, early, .. } = self;
        let wide = Splat::new(simd, box_ray);
        bvh.step_to_nearest(simd, box_ray, &wide, walk, stack, ray, *origin_primitive, early)
    }

    #[inline(always)]
    fn end(&mut self, bvh: &'a Bvh) -> Option<Hit<'a>> {
        let found = bvh.decide(self.walk.held, self.early.take(), &self.ray, self.origin_primitive)?;
        Some(found.hit(&self.ray, self.moved))
    }
}

/// A segment on its way to any hit.
struct AnyFlight {
    walk: Any,
    stack: Stack<u32>,
    box_ray: BoxRay,
    segment: Segment,
}

impl Default for AnyFlight {
    #[inline(always)]
    fn default() -> Self {
        Self {
            walk: Any::ended(false),
            stack: Stack::default(),
            box_ray: BoxRay::new(Vec3::ZERO, Vec3::ZERO),
            segment: Segment { origin: DVec3::ZERO, direction: DVec3::ZERO, length: 0.0, ends: Ends { origin: 0, end: 0 } },
        }
    }
}

impl Flight<'_> for AnyFlight {
    type Query = Result<Segment, bool>;
    type Answer = bool;

    #[inline(always)]
    fn follows(_: &Self::Query, _: &Self::Query) -> bool {
        false
    }

    #[inline(always)]
    fn together<S: Simd>(simd: S, bvh: &Bvh, _: &mut Stack<Entry>, queries: &[(usize, Self::Query)], answer: &mut impl FnMut(usize, bool)) {
        for &(index, query) in queries {
            answer(index, query.map_or_else(|free| free, |segment| bvh.is_free_with(simd, &segment)));
        }
    }

    #[inline(always)]
    fn start(&mut self, bvh: &Bvh, query: Self::Query) {
        match query.and_then(|segment| bvh.part_inside(&segment).ok_or(true)) {
            Ok(segment) => {
                self.walk = bvh.walk_to_any(&segment);
                self.box_ray = bvh.box_ray(segment.origin, segment.direction);
                self.segment = segment;
            }
            Err(free) => self.walk = Any::ended(!free),
        }
    }

    #[inline(always)]
    fn step<S: Simd>(&mut self, simd: S, bvh: &Bvh) -> Step {
        let Self { walk, stack, box_ray, segment } = self;
        let wide = Splat::new(simd, box_ray);
        bvh.step_to_any(simd, box_ray, &wide, walk, stack, segment)
    }

    #[inline(always)]
    fn end(&mut self, _: &Bvh) -> bool {
        !self.walk.hit
    }
}
