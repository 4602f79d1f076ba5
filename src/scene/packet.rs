//! Many queries at once in a scene of few facets, on a processor with vectors of sixteen numbers: sixteen rays are tested against one facet after the other, without a tree.
//!
//! Tolerances, hits that are held back and exact tests are those of the walk through the tree, so the answers are the same.

use super::bvh::{Bvh, Ends, Found, Hit, Query, Segment};
use super::traverse::{FAR, Facets, Tested, take};
use super::wide::{Block, Candidate, LANES, Line};
use crate::geometry::{Ray, SurfacePoint};
use fearless_simd::{Simd, f32x4, f32x16, prelude::*, u32x16};
use glam::DVec3;

/// Facets up to which a tree does not pay, where it need not be walked for each ray.
pub(super) const FEW: usize = 48;

/// Rays of a packet.
const RAYS: usize = 16;

/// Whether an instruction set is one with which packets are faster than rays that take turns: one of 16 lanes.
#[inline(always)]
pub(super) fn pays<S: Simd>(_: S) -> bool {
    S::f32s::LEN == RAYS
}

/// All facets of a scene that has few.
type Few<'a> = &'a [[Line; Block::LINES]];

/// The rays of a packet in the space of the boxes, by axis. A limit that is no number is that of a lane without ray.
struct Packet {
    origin: [[f32; RAYS]; 3],
    direction: [[f32; RAYS]; 3],
    limit: [f32; RAYS],
}

impl Packet {
    #[inline(always)]
    fn new() -> Self {
        Self { origin: [[0.0; RAYS]; 3], direction: [[0.0; RAYS]; 3], limit: [f32::NAN; RAYS] }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, bvh: &Bvh, origin: DVec3, direction: DVec3, limit: f32) {
        let (origin, direction) = (bvh.place(origin), direction.as_vec3());
        for axis in 0..3 {
            (self.origin[axis][lane], self.direction[axis][lane]) = (origin[axis], direction[axis]);
        }
        self.limit[lane] = limit;
    }

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> ([f32x16<S>; 3], [f32x16<S>; 3], f32x16<S>) {
        let row = |row: &[f32; RAYS]| f32x16::load_array_ref(simd, row);
        let rows = |v: &[[f32; RAYS]; 3]| [row(&v[0]), row(&v[1]), row(&v[2])];
        (rows(&self.origin), rows(&self.direction), row(&self.limit))
    }
}

/// The facets of a block, to be taken one by one.
struct Rows {
    vectors: [[[f32; LANES]; 3]; 4],
    tolerance: [f32; LANES],
    slack: [f32; LANES],
}

impl Rows {
    #[inline(always)]
    fn new<S: Simd>(simd: S, block: Block<'_>) -> Self {
        let Facets { vertex, edge1, edge2, normal, tolerance, slack } = Facets::new(simd, block);
        let rows = |v: [f32x4<S>; 3]| [v[0].to_array(), v[1].to_array(), v[2].to_array()];
        Self { vectors: [rows(vertex), rows(edge1), rows(edge2), rows(normal)], tolerance: tolerance.to_array(), slack: slack.to_array() }
    }

    /// One of them in all lanes.
    #[inline(always)]
    fn facet<S: Simd>(&self, simd: S, lane: usize) -> Facets<f32x16<S>> {
        let splat = |row: &[f32; LANES]| f32x16::splat(simd, row[lane % LANES]);
        let [vertex, edge1, edge2, normal] = &self.vectors;
        let splats = |v: &[[f32; LANES]; 3]| [splat(&v[0]), splat(&v[1]), splat(&v[2])];
        Facets {
            vertex: splats(vertex),
            edge1: splats(edge1),
            edge2: splats(edge2),
            normal: splats(normal),
            tolerance: splat(&self.tolerance),
            slack: splat(&self.slack),
        }
    }
}

/// What [`Bvh::closest`] says of many rays.
#[inline(always)]
pub(super) fn closest<'a, S: Simd>(
    simd: S,
    bvh: &'a Bvh,
    few: Few<'a>,
    queries: impl Iterator<Item = Query>,
    mut found: impl FnMut(usize, Option<Hit<'a>>),
) {
    let mut queries = queries.enumerate().fuse();
    let mut rays = [(0, Ray::new(DVec3::ZERO, DVec3::X), 0.0); RAYS];
    let mut origins = [SurfacePoint::NONE; RAYS];
    loop {
        let (mut packet, mut count) = (Packet::new(), 0);
        while count < RAYS {
            let Some((index, query)) = queries.next() else { break };
            let Some((origin, direction, moved)) = bvh.entry(query.origin, query.direction) else {
                found(index, None);
                continue;
            };
            packet.set(count, bvh, origin, direction, FAR);
            rays[count] = (index, Ray::new(origin, direction), moved);
            origins[count] = query.origin_primitive;
            count += 1;
        }
        if count == 0 {
            return;
        }
        let (held, mut early) = nearest(simd, bvh, few, &packet, &rays, &origins);
        for (lane, (index, ray, moved)) in rays[..count].iter().enumerate() {
            let number = held[lane] as usize;
            let held = few.get(number / LANES).map(|block| Candidate { block: Block(block), lane: number % LANES });
            let decided = bvh.decide(held, early[lane].take(), ray, origins[lane]);
            found(*index, decided.map(|found| found.hit(ray, *moved)));
        }
    }
}

/// The number of the facet that is held back for each ray of a packet, and what had to be tested early.
#[inline(always)]
fn nearest<'a, S: Simd>(
    simd: S,
    bvh: &'a Bvh,
    few: Few<'a>,
    packet: &Packet,
    rays: &[(usize, Ray, f64); RAYS],
    origins: &[u32; RAYS],
) -> ([u32; RAYS], [Option<Found<'a>>; RAYS]) {
    let (origin, direction, mut limit) = packet.load(simd);
    let origin_primitive = u32x16::load_array_ref(simd, origins);
    let mut held = u32x16::splat(simd, u32::MAX);
    let (mut held_primitive, mut held_near) = (held, f32x16::splat(simd, f32::INFINITY));
    let mut early = [const { None }; RAYS];
    for (number, block) in few.iter().enumerate() {
        let block = Block(block);
        let rows = Rows::new(simd, block);
        for lane in 0..LANES {
            let tested = Tested::new(simd, &origin, &direction, limit, rows.facet(simd, lane));
            if !tested.hits.any_true() {
                continue;
            }
            let candidate = Candidate { block, lane };
            let primitive = u32x16::splat(simd, candidate.primitive());
            let certain = tested.hits & tested.certain();
            let (near, far) = tested.interval(simd);
            let dropped = certain & (primitive.simd_eq(held_primitive) | primitive.simd_eq(origin_primitive) | near.simd_gt(limit));
            let nearer = certain & !dropped & far.simd_lt(held_near);
            held = nearer.select(u32x16::splat(simd, (number * LANES + lane) as u32), held);
            held_primitive = nearer.select(primitive, held_primitive);
            held_near = nearer.select(near, held_near);
            limit = nearer.select(limit.min(far), limit);
            let mut unclear = (tested.hits & !dropped & !nearer).to_bitmask();
            if unclear != 0 {
                let mut limits = limit.to_array();
                while unclear != 0 {
                    let lane = take(&mut unclear) % RAYS;
                    if let Some(nearer) = bvh.test_early(candidate, &rays[lane].1, origins[lane], &mut early[lane]) {
                        limits[lane] = limits[lane].min(nearer);
                    }
                }
                limit = f32x16::load_array(simd, limits);
            }
        }
    }
    (held.to_array(), early)
}

/// What [`Bvh::is_free`] says of many segments.
#[inline(always)]
pub(super) fn are_free<S: Simd>(
    simd: S,
    bvh: &Bvh,
    few: Few<'_>,
    queries: impl Iterator<Item = Result<Segment, bool>>,
    mut answer: impl FnMut(usize, bool),
) {
    let mut queries = queries.enumerate().fuse();
    let nowhere = Segment { origin: DVec3::ZERO, direction: DVec3::ZERO, length: 0.0, ends: Ends { origin: 0, end: 0 } };
    let (mut indices, mut segments) = ([0; RAYS], [nowhere; RAYS]);
    loop {
        let (mut packet, mut count) = (Packet::new(), 0);
        while count < RAYS {
            let Some((index, query)) = queries.next() else { break };
            match query.and_then(|segment| bvh.part_inside(&segment).ok_or(true)) {
                Ok(segment) => {
                    packet.set(count, bvh, segment.origin, segment.direction, bvh.round_up(segment.length).min(FAR));
                    (indices[count], segments[count]) = (index, segment);
                    count += 1;
                }
                Err(free) => answer(index, free),
            }
        }
        if count == 0 {
            return;
        }
        let free = free(simd, bvh, few, &packet, &segments, (1 << count) - 1);
        for (lane, &index) in indices[..count].iter().enumerate() {
            answer(index, free >> lane & 1 != 0);
        }
    }
}

/// Which segments of a packet, given by a bit for each, nothing lies on.
#[inline(always)]
fn free<S: Simd>(simd: S, bvh: &Bvh, few: Few<'_>, packet: &Packet, segments: &[Segment; RAYS], mut free: u64) -> u64 {
    let (origin, direction, limit) = packet.load(simd);
    let origins = u32x16::from_fn(simd, |lane| segments[lane].ends.origin);
    let ends = u32x16::from_fn(simd, |lane| segments[lane].ends.end);
    for block in few {
        let block = Block(block);
        let rows = Rows::new(simd, block);
        for lane in 0..LANES {
            let tested = Tested::new(simd, &origin, &direction, limit, rows.facet(simd, lane));
            let hits = tested.hits.to_bitmask() & free;
            if hits == 0 {
                continue;
            }
            let candidate = Candidate { block, lane };
            let primitive = u32x16::splat(simd, candidate.primitive());
            let touched = primitive.simd_eq(origins) | primitive.simd_eq(ends);
            let certain = (tested.certain_before(limit) & !touched).to_bitmask() & hits;
            free &= !certain;
            let mut unclear = hits & !certain;
            while unclear != 0 {
                let lane = take(&mut unclear) % RAYS;
                if bvh.blocks(candidate, &segments[lane]) {
                    free &= !(1 << lane);
                }
            }
            if free == 0 {
                return 0;
            }
        }
    }
    free
}
