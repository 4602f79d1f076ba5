//! Many queries at once: several rays are under way and take turns, so that while one waits for
//! memory the others go on. In a tree that stays in the processor's caches there is little to wait
//! for, and one goes after the other.
//!
//! What a ray visits does not depend on the others, so the answers are those of single queries.

use super::bvh::Bvh;
use super::packet::{self, RAYS};
use super::query::{Found, Hit, Query, Segment};
use super::traverse::{Any, BoxRay, Nearest, Splat, Stack, Step};
use crate::geometry::Ray;
use fearless_simd::{Simd, dispatch};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Rays under way at a time.
const FLIGHTS: usize = 8;

/// Queries that the kernel is given at a time.
const BLOCK: usize = 128;

/// Queries from which on what it takes to begin pays.
const SOME: usize = 4;

/// Lines of a tree up to which taking turns does not pay: 2 MiB. Few in tests, whose trees are to
/// be on both sides.
const CACHED: usize = if cfg!(test) { 1 << 7 } else { 1 << 15 };

/// Distance between origins, relative to half the scene's size, up to which rays into nearly the
/// same direction visit mostly the same, such as a camera's.
const CLOSE: f64 = 0.05;

/// Cosine of the angle between such directions.
const COHERENT: f64 = 0.99;

/// The same for segments, of which those to the same light need not wait either.
const COHERENT_SEGMENTS: f64 = 0.9;

// What is not to be inlined is long and compiled for all instruction sets, but not for every
// caller.
impl Bvh {
    /// Whether the tree is so large that rays wait for memory.
    pub(super) fn pays_to_take_turns(&self) -> bool {
        self.wide.lines.len() > CACHED
    }

    /// Whether two origins are so close that rays into nearly the same direction visit mostly the
    /// same.
    #[inline(always)]
    fn is_close(&self, a: DVec3, b: DVec3) -> bool {
        (b - a).abs().max_element() <= CLOSE * self.extent
    }

    /// What [`closest`](Self::closest) says of many rays, each with its place in the iterator, in
    /// order.
    #[inline]
    pub fn closest_many<'a>(
        &'a self,
        queries: impl Iterator<Item = Query>,
        mut found: impl FnMut(usize, Option<Hit<'a>>),
    ) {
        let none = Query::free(DVec3::ZERO, DVec3::ZERO);
        in_blocks(queries, none, None, |first, queries, hits| {
            self.closest_of_block(queries, hits);
            hits.iter().enumerate().for_each(|(i, hit)| found(first + i, *hit));
        });
    }

    #[inline(never)]
    fn closest_of_block<'a>(&'a self, queries: &[Query], hits: &mut [Option<Hit<'a>>]) {
        if queries.len() < SOME {
            return self.closest_one_by_one(queries, hits);
        }
        if packet::closest(self, queries, hits) {
            return;
        }
        for (part, coherent) in parts(queries, |a, b| {
            self.is_close(a.origin, b.origin) && a.direction.dot(b.direction) > COHERENT
        }) {
            let (queries, hits) = (&queries[part.clone()], &mut hits[part]);
            if coherent {
                for (queries, hits) in queries.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
                    if !packet::closest_together(self, queries, hits) {
                        self.closest_one_by_one(queries, hits);
                    }
                }
            } else if self.pays_to_take_turns() {
                take_turns::<NearestFlight<'_>>(self, queries, hits);
            } else {
                self.closest_one_by_one(queries, hits);
            }
        }
    }

    #[inline(never)]
    fn closest_one_by_one<'a>(&'a self, queries: &[Query], hits: &mut [Option<Hit<'a>>]) {
        dispatch!(self.level, simd => for (query, hit) in queries.iter().zip(hits) {
            *hit = self.closest_with(simd, *query);
        });
    }

    /// What [`is_free`](Self::is_free) says of many segments, or what is known of one already, with
    /// its place in the iterator, in order.
    #[inline]
    pub fn are_free(
        &self,
        segments: impl Iterator<Item = Result<Segment, bool>>,
        mut answer: impl FnMut(usize, bool),
    ) {
        in_blocks(segments, Err(false), false, |first, segments, free| {
            self.are_free_in_block(segments, free);
            free.iter().enumerate().for_each(|(i, free)| answer(first + i, *free));
        });
    }

    #[inline(never)]
    fn are_free_in_block(&self, segments: &[Result<Segment, bool>], free: &mut [bool]) {
        if segments.len() < SOME {
            return self.are_free_one_by_one(segments, free);
        }
        if packet::are_free(self, segments, free) {
            return;
        }
        let follows = |a: &Result<Segment, bool>, b: &Result<Segment, bool>| match (a, b) {
            (Ok(a), Ok(b)) => {
                self.is_close(a.origin, b.origin)
                    && a.direction.dot(b.direction) > COHERENT_SEGMENTS
            }
            _ => false,
        };
        for (part, coherent) in parts(segments, follows) {
            let (segments, free) = (&segments[part.clone()], &mut free[part]);
            if !coherent && self.pays_to_take_turns() {
                take_turns::<AnyFlight>(self, segments, free);
            } else {
                self.are_free_one_by_one(segments, free);
            }
        }
    }

    #[inline(never)]
    fn are_free_one_by_one(&self, segments: &[Result<Segment, bool>], free: &mut [bool]) {
        dispatch!(self.level, simd => for (segment, free) in segments.iter().zip(free) {
            *free = match segment {
                Ok(segment) => self.is_free_with(simd, segment),
                Err(known) => *known,
            };
        });
    }
}

/// Hands out queries by the block, each block with the place of its first in the iterator and with
/// room for as many answers. What the room holds before does not matter.
#[inline(always)]
fn in_blocks<Q: Copy, A: Copy>(
    queries: impl Iterator<Item = Q>,
    no_query: Q,
    no_answer: A,
    mut ask: impl FnMut(usize, &[Q], &mut [A]),
) {
    let most = queries.size_hint().1.unwrap_or(usize::MAX);
    let mut queries = queries.fuse();
    let mut ask_all = |block: &mut [Q], answers: &mut [A]| {
        for first in (0..).step_by(block.len()) {
            let mut count = 0;
            for (place, query) in block.iter_mut().zip(&mut queries) {
                *place = query;
                count += 1;
            }
            if count > 0 {
                ask(first, &block[..count], &mut answers[..count]);
            }
            if count < block.len() {
                return;
            }
        }
    };
    with_room(most, no_query, |block| {
        with_room(most, no_answer, |answers| ask_all(block, answers))
    });
}

/// Gives `then` room on the stack for a block. To fill it takes time, which few queries would not
/// make up for.
#[inline(always)]
fn with_room<T: Copy>(most: usize, content: T, then: impl FnOnce(&mut [T])) {
    let (mut few, mut many);
    then(if most <= SOME {
        few = [content; SOME];
        &mut few
    } else {
        many = [content; BLOCK];
        &mut many
    });
}

/// The parts of some queries, and whether they are long ones in which each follows the one before.
#[inline(always)]
fn parts<Q>(
    queries: &[Q],
    follows: impl Fn(&Q, &Q) -> bool,
) -> impl Iterator<Item = (Range<usize>, bool)> {
    let mut runs = queries.chunk_by(follows).map(<[Q]>::len).peekable();
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at;
        let coherent = *runs.peek()? >= RAYS / 2;
        at += runs.next()?;
        while let Some(run) = runs.next_if(|run| !coherent && *run < RAYS / 2) {
            at += run;
        }
        Some((start..at, coherent))
    })
}

/// A query under way. Methods and not closures, which cannot be told to be compiled for the
/// instruction set.
trait Flight<'a>: Default {
    type Query: Copy;
    type Answer;

    fn start(&mut self, bvh: &'a Bvh, query: Self::Query);

    fn step<S: Simd>(&mut self, simd: S, bvh: &'a Bvh) -> Step;

    fn end(&mut self, bvh: &'a Bvh) -> Self::Answer;
}

/// Lets each query go on until it has to wait, one after the other.
#[inline(never)]
fn take_turns<'a, F: Flight<'a>>(bvh: &'a Bvh, queries: &[F::Query], answers: &mut [F::Answer]) {
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
