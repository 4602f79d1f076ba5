//! The trees of a scene, each in a space of its own.
//!
//! Boxes and tolerances of a tree are as coarse as 2⁻¹⁹ of its space. A scene that is stretched,
//! by one small rectangle far away, say, would lose all of the rest in them: every ray would meet
//! every box. So [`clusters`] of primitives that would be lost get a space of their own,
//! and clusters within them in turn. Most scenes have none, and one tree.
//!
//! A region is the box around a cluster, and knows everything that is inside: its tree has the
//! primitives of the cluster but for those of smaller regions, and also whatever
//! [reaches](clusters::reaches) in from outside. So a ray that starts and ends in a region is
//! answered by its tree, as in a scene that has no more. A ray that leaves it goes on in the
//! region around it, and so on to that of the whole scene.
//!
//! Exact tests see the same ray in every tree and so decide by the same numbers, wherever the trees
//! are divided; [`rounding`](super::rounding) has the proof that none is left out.

mod build;
mod clusters;
mod from_afar;

use super::bvh::Bvh;
use super::layout::Wide;
use super::many::{BLOCK, in_blocks};
use super::packet::{self, Few};
use super::query::{Ends, Found, Hit, Query, Segment, unit};
use crate::geometry::{Bounds, Shape, Triangle};
use crate::lanes::{LANES, Rows};
#[cfg(test)]
use fearless_simd::Level;
use from_afar::{Line, Slabs};
use glam::DVec3;
use std::ops::Range;
use std::time::Duration;

/// The primitives of a scene in one tree or several.
pub(crate) struct Forest {
    /// That of the whole scene, and behind it those in it.
    regions: Vec<Region>,
    /// The middle of the scene; zero if there is nothing in it.
    center: DVec3,
    build_time: Duration,
}

/// A box and the tree of its space.
struct Region {
    tree: Bvh,
    /// The tree knows all that is in a slightly larger box.
    around: Slabs,
    /// The box around what is in the tree.
    filled: Slabs,
    /// The place of the region around this one.
    parent: usize,
    /// The places of the regions inside.
    children: Range<usize>,
    /// True if only regions around this one and inside of it overlap it.
    alone: bool,
    /// The number of primitives, those of regions inside included.
    primitives: usize,
}

/// The parts of an acceleration structure.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TreeStatistics {
    /// Nodes, each with up to eight boxes.
    pub nodes: usize,
    /// Leaves, each with up to four triangles.
    pub leaves: usize,
    /// Trees; more than one in a scene that is stretched.
    pub trees: usize,
    /// Memory of nodes, leaves and shapes, bytes.
    pub bytes: usize,
    /// Wall-clock time of building it.
    pub build_time: Duration,
    /// The instruction set that rays use, chosen at run time.
    pub instruction_set: &'static str,
}

impl Region {
    /// True if everything that a ray from inside to a point inside may meet is in this tree.
    #[inline(always)]
    fn is_enough(&self) -> bool {
        self.alone && self.children.is_empty()
    }

    /// Replaces the nearest hit by what the tree has that is nearer.
    fn find_nearer<'a>(&'a self, line: &Line, nearest: &mut Option<Found<'a>>) {
        let limit = limit_of(nearest);
        if let Some(entry) = self.filled.entry(line, limit) {
            self.tree.find_nearer(line, entry, limit, nearest);
        }
    }

    /// True if anything of the tree lies on a segment.
    fn is_in_the_way(&self, line: &Line, segment: &Segment) -> bool {
        self.filled
            .entry(line, segment.length)
            .is_some_and(|entry| self.tree.is_in_the_way(line, entry, segment))
    }
}

/// The distance beyond which a hit is not the nearest.
fn limit_of(nearest: &Option<Found<'_>>) -> f64 {
    nearest.as_ref().map_or(f64::INFINITY, |found| found.intersection.t)
}

impl Forest {
    /// Uses another instruction set, which this processor must have.
    #[cfg(test)]
    pub fn set_level(&mut self, level: Level) {
        self.regions.iter_mut().for_each(|region| region.tree.level = level);
    }

    /// The tree of the whole scene's space.
    #[inline(always)]
    pub(super) fn outermost(&self) -> &Bvh {
        &self.regions[0].tree
    }

    /// The numbers of the trees' parts.
    pub fn statistics(&self) -> TreeStatistics {
        let mut statistics = TreeStatistics {
            nodes: 0,
            leaves: 0,
            trees: self.regions.len(),
            bytes: size_of_val(&self.outermost().shapes[..]),
            build_time: self.build_time,
            instruction_set: self.outermost().instruction_set(),
        };
        for Region { tree, .. } in &self.regions {
            let Wide { lines, nodes, blocks } = &tree.wide;
            statistics.nodes += nodes;
            statistics.leaves += blocks;
            statistics.bytes += size_of_val(&lines[..]) + tree.few.as_ref().map_or(0, Few::bytes);
        }
        statistics
    }

    /// The part of the scene that is smaller than the whole by more than a ratio, if there is one:
    /// the box of that with the most primitives, and the ratio.
    pub fn stretched(&self, most: f64) -> Option<(Bounds, f64)> {
        let ratio = |region: &Region| self.outermost().extent / region.tree.extent;
        let regions = self.regions.iter().filter(|region| ratio(region) > most);
        let region = regions.max_by_key(|region| region.primitives)?;
        Some((region.around.bounds(), ratio(region)))
    }

    /// The middle of the scene; zero if there is nothing in it.
    #[inline]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// All primitives, by their number.
    pub fn shapes(&self) -> &[Shape] {
        &self.outermost().shapes
    }

    /// The shape of a primitive.
    pub fn shape(&self, primitive: u32) -> Option<&Shape> {
        self.outermost().shapes.get(primitive as usize)
    }

    /// The triangle that was hit; `None` if it is another shape.
    #[inline(always)]
    pub fn triangle_of(&self, hit: &Hit<'_>) -> Option<Triangle> {
        match &self.regions[..] {
            [only] => only.tree.triangle_of(hit),
            _ => self.shape(hit.primitive)?.as_triangle(),
        }
    }

    /// The nearest hit, of equally near ones that with the lowest primitive, as `result` returns
    /// it. A direction that is not of unit length is made so.
    #[inline]
    pub fn closest<'a, R>(&'a self, query: Query, result: impl FnOnce(Hit<'a>) -> R) -> Option<R> {
        match &self.regions[..] {
            [only] => only.tree.closest(query, result),
            _ => self.closest_of_all(&query).map(result),
        }
    }

    #[inline(never)]
    fn closest_of_all(&self, query: &Query) -> Option<Hit<'_>> {
        let home = self.home(query.origin);
        self.go_on(home, query, self.regions[home].tree.closest(*query, |hit| hit))
    }

    /// True if nothing lies on a segment. A direction that is not of unit length is made so.
    #[inline]
    pub fn is_free(&self, segment: &Segment) -> bool {
        match &self.regions[..] {
            [only] => only.tree.is_free(segment),
            _ => self.is_free_of_all(segment),
        }
    }

    #[inline(never)]
    fn is_free_of_all(&self, segment: &Segment) -> bool {
        let home = self.home(segment.origin);
        self.regions[home].tree.is_free(segment) && self.stays_free(home, segment)
    }

    /// The nearest hits of many rays, as [`closest`](Self::closest) finds them, each with its place
    /// in the iterator and the ray, in order.
    #[inline]
    pub fn closest_many<'a>(
        &'a self,
        queries: impl Iterator<Item = Query>,
        mut found: impl FnMut(usize, &Query, Option<Hit<'a>>),
    ) {
        let none = Query::free(DVec3::ZERO, DVec3::ZERO);
        in_blocks(queries, none, None, |first, queries, hits| {
            self.closest_of_block(queries, hits);
            let answers = queries.iter().zip(hits).enumerate();
            answers.for_each(|(i, (query, hit))| found(first + i, query, *hit));
        });
    }

    #[inline(never)]
    fn closest_of_block<'a>(&'a self, queries: &[Query], hits: &mut [Option<Hit<'a>>]) {
        match &self.regions[..] {
            [only] => only.tree.closest_of_block(queries, hits),
            _ => self.closest_by_home(queries, hits),
        }
    }

    #[inline(never)]
    fn closest_by_home<'a>(&'a self, queries: &[Query], hits: &mut [Option<Hit<'a>>]) {
        by_home(
            queries,
            hits,
            |query| self.home(query.origin),
            |home, queries, hits| {
                self.regions[home].tree.closest_of_block(queries, hits);
                for (query, hit) in queries.iter().zip(hits) {
                    *hit = self.go_on(home, query, *hit);
                }
            },
        );
    }

    /// The answers of [`is_free`](Self::is_free) for many segments, or the answer for one that is
    /// known already, each with its place in the iterator, in order.
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

    /// The tree and its primitives, if there is only one and they are few.
    fn few(&self) -> Option<(&Bvh, &Few)> {
        let [Region { tree, .. }] = &self.regions[..] else { return None };
        Some((tree, tree.few.as_ref()?))
    }

    /// The nearest hits of rays in columns, which are origins and directions, as
    /// [`closest_many`](Self::closest_many) finds them.
    #[inline]
    pub fn closest_in_columns<'a>(
        &'a self,
        rays: &Rows<6>,
        ends: &[Ends],
        mut found: impl FnMut(usize, Option<Hit<'a>>),
    ) {
        let (few, mut hits) = (self.few(), [None; BLOCK]);
        let mut queries = [Query::free(DVec3::ZERO, DVec3::ZERO); BLOCK];
        let blocks = rays.groups().chunks(BLOCK / LANES).zip(ends.chunks(BLOCK));
        for ((groups, ends), first) in blocks.zip((0..).step_by(BLOCK)) {
            let hits = &mut hits[..ends.len()];
            if let Some((tree, few)) = few {
                packet::closest_in_columns(tree, few, groups, ends, hits);
            } else {
                for (i, (query, ends)) in queries.iter_mut().zip(ends).enumerate() {
                    let [x, y, z, dx, dy, dz] = rays.get(first + i);
                    *query = Query {
                        origin: DVec3::new(x, y, z),
                        direction: DVec3::new(dx, dy, dz),
                        origin_primitive: ends.origin,
                    };
                }
                self.closest_of_block(&queries[..ends.len()], hits);
            }
            hits.iter().enumerate().for_each(|(i, hit)| found(first + i, *hit));
        }
    }

    /// The answers of [`is_free`](Self::is_free) for segments in columns: origins, directions and
    /// lengths are the first seven rows. One without a length is free.
    pub fn are_free_in_columns<const N: usize>(
        &self,
        segments: &Rows<N>,
        ends: &[Ends],
        free: &mut Vec<bool>,
    ) {
        free.clear();
        free.resize(ends.len(), false);
        if let Some((tree, few)) = self.few() {
            return packet::are_free_in_columns(tree, few, segments, ends, free);
        }
        let of = |(i, ends): (usize, &Ends)| {
            let row = |row| segments.number(i, row);
            let length = row(6);
            if length > 0.0 {
                let origin = DVec3::new(row(0), row(1), row(2));
                let direction = DVec3::new(row(3), row(4), row(5));
                Ok(Segment { origin, direction, length, ends: *ends })
            } else {
                Err(true)
            }
        };
        self.are_free(ends.iter().enumerate().map(of), |i, answer| free[i] = answer);
    }

    #[inline(never)]
    fn are_free_in_block(&self, segments: &[Result<Segment, bool>], free: &mut [bool]) {
        match &self.regions[..] {
            [only] => only.tree.are_free_in_block(segments, free),
            _ => self.are_free_by_home(segments, free),
        }
    }

    #[inline(never)]
    fn are_free_by_home(&self, segments: &[Result<Segment, bool>], free: &mut [bool]) {
        let home = |segment: &Result<Segment, bool>| segment.map_or(0, |s| self.home(s.origin));
        by_home(segments, free, home, |home, segments, free| {
            self.regions[home].tree.are_free_in_block(segments, free);
            for (segment, free) in segments.iter().zip(free) {
                if let (Ok(segment), true) = (segment, *free) {
                    *free = self.stays_free(home, segment);
                }
            }
        });
    }

    /// The place of a region that contains a point, and of which no region inside does. Rays from
    /// there are not moved before they are tested.
    #[inline]
    fn home(&self, origin: DVec3) -> usize {
        let mut home = 0;
        if self.regions[0].around.contains(origin) {
            let inside = |children: &Range<usize>| {
                children.clone().find(|&child| self.regions[child].around.contains(origin))
            };
            while let Some(child) = inside(&self.regions[home].children) {
                home = child;
            }
        }
        home
    }

    /// The nearest hit of a ray of which the tree at home has been asked.
    fn go_on<'a>(&'a self, home: usize, query: &Query, hit: Option<Hit<'a>>) -> Option<Hit<'a>> {
        let region = &self.regions[home];
        if home != 0
            && region.is_enough()
            && let Some(Hit { intersection, .. }) = hit
            && let Some(direction) = unit(query.direction)
            && region.around.contains_end(query.origin, direction, intersection.t)
        {
            return hit;
        }
        let (origin, direction, moved) = self.outermost().entry(query.origin, query.direction)?;
        let line = Line::new(origin, direction, query.origin_primitive);
        let mut nearest = hit.map(|hit| {
            let Hit { primitive, candidate, intersection, .. } = hit;
            Found { primitive, candidate, intersection }
        });
        let (mut at, mut done) = (home, home);
        loop {
            let region = &self.regions[at];
            for child in region.children.clone().filter(|&child| child != done) {
                self.find_nearer(child, &line, &mut nearest);
            }
            let is_near = |found: &Found<'_>| {
                region.around.contains_end(origin, direction, found.intersection.t)
            };
            if at == 0 || (region.alone && nearest.as_ref().is_some_and(is_near)) {
                break;
            }
            (at, done) = (region.parent, at);
            self.regions[at].find_nearer(&line, &mut nearest);
        }
        nearest.map(|found| found.hit(moved))
    }

    /// Replaces the nearest hit of a ray by what a region and those inside have that is nearer.
    fn find_nearer<'a>(&'a self, at: usize, line: &Line, nearest: &mut Option<Found<'a>>) {
        let region = &self.regions[at];
        if region.around.entry(line, limit_of(nearest)).is_some() {
            region.find_nearer(line, nearest);
            for child in region.children.clone() {
                self.find_nearer(child, line, nearest);
            }
        }
    }

    /// True if a segment that is free of the tree at home is so of all.
    fn stays_free(&self, home: usize, segment: &Segment) -> bool {
        let Some(segment) = self.outermost().part_inside(segment) else { return true };
        let Segment { origin, direction, length, ends } = segment;
        if home != 0
            && self.regions[home].is_enough()
            && self.regions[home].around.contains_end(origin, direction, length)
        {
            return true;
        }
        let line = Line::new(origin, direction, ends.origin);
        let (mut at, mut done) = (home, home);
        loop {
            let region = &self.regions[at];
            let mut others = region.children.clone().filter(|&child| child != done);
            if others.any(|child| self.is_in_the_way(child, &line, &segment)) {
                return false;
            }
            if at == 0 || (region.alone && region.around.contains_end(origin, direction, length)) {
                return true;
            }
            (at, done) = (region.parent, at);
            if self.regions[at].is_in_the_way(&line, &segment) {
                return false;
            }
        }
    }

    /// True if anything of a region or of those inside lies on a segment.
    fn is_in_the_way(&self, at: usize, line: &Line, segment: &Segment) -> bool {
        let region = &self.regions[at];
        region.around.entry(line, segment.length).is_some()
            && (region.is_in_the_way(line, segment)
                || region.children.clone().any(|child| self.is_in_the_way(child, line, segment)))
    }
}

/// Hands out queries by the place of their home, each with memory for its answer.
#[inline(always)]
fn by_home<Q: Copy, A: Copy>(
    queries: &[Q],
    answers: &mut [A],
    home: impl Fn(&Q) -> usize,
    mut ask: impl FnMut(usize, &[Q], &mut [A]),
) {
    let mut keys = [(0, 0); BLOCK];
    let keys = &mut keys[..queries.len()];
    for (index, (key, query)) in keys.iter_mut().zip(queries).enumerate() {
        *key = (home(query), index);
    }
    let Some(&(first, _)) = keys.first() else { return };
    if keys.iter().all(|&(home, _)| home == first) {
        return ask(first, queries, answers);
    }
    keys.sort_unstable();
    let (mut sorted, mut found) = ([queries[0]; BLOCK], [answers[0]; BLOCK]);
    for (query, &(_, index)) in sorted.iter_mut().zip(&*keys) {
        *query = queries[index];
    }
    let mut start = 0;
    for run in keys.chunk_by(|a, b| a.0 == b.0) {
        let range = start..start + run.len();
        start = range.end;
        ask(run[0].0, &sorted[range.clone()], &mut found[range]);
    }
    for (&(_, index), answer) in keys.iter().zip(&found) {
        answers[index] = *answer;
    }
}

impl std::fmt::Debug for Forest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let statistics = self.statistics();
        f.debug_struct("Forest")
            .field("primitives", &self.outermost().shapes.len())
            .field("trees", &statistics.trees)
            .field("nodes", &statistics.nodes)
            .finish_non_exhaustive()
    }
}
