//! Many queries at once: several rays are under way and take turns, so that while one waits for
//! memory the others go on. In a tree that stays in the processor's caches there is little to wait
//! for, and one goes after the other.
//!
//! The nodes that a ray visits do not depend on the others, so the answers are those of single
//! queries.

use super::bvh::Bvh;
use super::flights::{AnyFlight, NearestFlight, take_turns};
use super::packet::{self, RAYS};
use super::query::{Hit, Query, Segment};
use crate::lanes::dispatch;
use glam::DVec3;
use std::ops::Range;

/// Queries that the kernel is given at a time.
pub(super) const BLOCK: usize = 128;

/// The fewest queries for which the effort of beginning pays.
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
    /// True if the tree is so large that rays wait for memory.
    pub(super) fn pays_to_take_turns(&self) -> bool {
        self.wide.lines.len() > CACHED
    }

    /// True if two origins are so close that rays into nearly the same direction visit mostly the
    /// same.
    #[inline(always)]
    fn is_close(&self, a: DVec3, b: DVec3) -> bool {
        (b - a).abs().max_element() <= CLOSE * self.extent
    }

    /// The nearest hits of up to a block of rays, as [`closest`](Self::closest) finds them.
    #[inline(never)]
    pub(super) fn closest_of_block<'a>(&'a self, queries: &[Query], hits: &mut [Option<Hit<'a>>]) {
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

    /// The answers of [`is_free`](Self::is_free) for up to a block of segments, or the answer for
    /// one that is known already.
    #[inline(never)]
    pub(super) fn are_free_in_block(&self, segments: &[Result<Segment, bool>], free: &mut [bool]) {
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
/// memory for as many answers. The contents before do not matter.
#[inline(always)]
pub(super) fn in_blocks<Q: Copy, A: Copy>(
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

/// Gives `then` a block of memory on the stack. To fill it takes time, which few queries would not
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
