//! Queries that take turns: each goes on until it has to wait for memory.

use super::boxes::{BoxRay, Splat};
use super::bvh::Bvh;
use super::query::{Found, Hit, Query, Segment};
use super::stack::Stack;
use super::traverse::{Any, Nearest, Step};
use crate::geometry::Ray;
use crate::lanes::dispatch;
use fearless_simd::Simd;
use glam::{DVec3, Vec3};

/// Rays under way at a time.
const FLIGHTS: usize = 8;

/// A query under way. Methods and not closures, which cannot be told to be compiled for the
/// instruction set.
pub(super) trait Flight<'a>: Default {
    type Query: Copy;
    type Answer;

    fn start(&mut self, bvh: &'a Bvh, query: Self::Query);

    fn step<S: Simd>(&mut self, simd: S, bvh: &'a Bvh) -> Step;

    fn end(&mut self, bvh: &'a Bvh) -> Self::Answer;
}

/// Lets each query go on until it has to wait, one after the other.
#[inline(never)]
pub(super) fn take_turns<'a, F: Flight<'a>>(
    bvh: &'a Bvh,
    queries: &[F::Query],
    answers: &mut [F::Answer],
) {
    dispatch!(bvh.level, simd => take_turns_with::<_, F>(simd, bvh, queries, answers));
}

#[inline(always)]
fn take_turns_with<'a, S: Simd, F: Flight<'a>>(
    simd: S,
    bvh: &'a Bvh,
    queries: &[F::Query],
    answers: &mut [F::Answer],
) {
    let mut flights: [(Option<usize>, F); FLIGHTS] = Default::default();
    let mut queries = queries.iter().enumerate();
    loop {
        let mut under_way = false;
        for (slot, flight) in &mut flights {
            loop {
                let index = match *slot {
                    Some(index) => index,
                    None => {
                        let Some((index, query)) = queries.next() else { break };
                        flight.start(bvh, *query);
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
                        answers[index] = flight.end(bvh);
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
pub(super) struct NearestFlight<'a> {
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
        let found =
            bvh.decide(self.walk.held, self.early.take(), &self.ray, self.origin_primitive)?;
        Some(found.hit(self.moved))
    }
}

/// A segment on its way to any hit.
pub(super) struct AnyFlight {
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
            segment: Segment::free(DVec3::ZERO, DVec3::ZERO, 0.0),
        }
    }
}

impl Flight<'_> for AnyFlight {
    type Query = Result<Segment, bool>;
    type Answer = bool;

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
