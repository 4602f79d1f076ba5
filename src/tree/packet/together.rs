//! The nearest hits of rays that walk through the tree together.

use super::RAYS;
use super::eight::meet_flat;
use super::rays::{BoxRays, Rays, limited};
use crate::lanes::LANES as EIGHT;
use crate::lanes::dispatch;
use crate::tree::bvh::Bvh;
use crate::tree::facets::{Facets, Tested};
use crate::tree::layout::{Block, Candidate, Child, LANES, Node, WIDTH};
use crate::tree::query::{Found, Hit, Query};
use crate::tree::rounding::{FAR, SMALLEST};
use crate::tree::stack::{Stack, take};
use fearless_simd::{Simd, f32x4, f32x16, mask32x16, prelude::*, u32x16};

/// The answers of [`Bvh::closest`] for up to sixteen rays that visit mostly the same: they walk
/// through the tree together. Returns true if they can and it pays: not if the signs of their
/// directions differ.
#[inline(never)]
pub(in crate::tree) fn closest_together<'a>(
    bvh: &'a Bvh,
    queries: &[Query],
    hits: &mut [Option<Hit<'a>>],
) -> bool {
    queries.len() >= RAYS / 2
        && dispatch!(bvh.level, simd => {
            pays(simd) && closest_together_with(simd, bvh, queries, hits)
        })
}

#[inline(always)]
fn closest_together_with<'a, S: Simd>(
    simd: S,
    bvh: &'a Bvh,
    queries: &[Query],
    hits: &mut [Option<Hit<'a>>],
) -> bool {
    let mut rays = Rays::of(queries);
    let mut search = Search::new(simd, bvh, &mut rays);
    let Some(planes) = Planes::new(simd, &search) else { return false };
    search.walk(simd, &planes);
    search.end(simd, hits);
    true
}

/// True for an instruction set with which that is faster than rays that take turns: one of eight
/// lanes or more.
#[inline(always)]
fn pays<S: Simd>(_: S) -> bool {
    S::f32s::LEN >= EIGHT
}

/// A part of the tree that a packet has yet to visit, and the distances at which its rays enter it.
#[derive(Clone, Copy, Default)]
struct Entry {
    near: [f32; RAYS],
    child: u32,
}

/// The terms with which the rays of a packet meet planes: reciprocals of directions, minus origin
/// times them, and the axes along which all rays run downwards.
struct Planes<S: Simd> {
    reciprocal: [f32x16<S>; 3],
    offset: [f32x16<S>; 3],
    backwards: [bool; 3],
}

impl<S: Simd> Planes<S> {
    /// `None` if directions do not have the same signs. The numbers are those of a
    /// [`BoxRay`](crate::tree::boxes::BoxRay).
    #[inline(always)]
    fn new(simd: S, search: &Search<'_, '_, S>) -> Option<Self> {
        let mut planes =
            Self { reciprocal: search.direction, offset: search.origin, backwards: [false; 3] };
        let empty = !search.limit.simd_eq(search.limit);
        for axis in 0..3 {
            let d = search.direction[axis];
            let smallest = f32x16::splat(simd, SMALLEST);
            let reciprocal = f32x16::splat(simd, 1.0)
                / d.abs().simd_lt(smallest).select(smallest.copysign(d), d);
            planes.reciprocal[axis] = reciprocal;
            planes.offset[axis] = -search.origin[axis] * reciprocal;
            let backwards = reciprocal.simd_lt(0.0);
            planes.backwards[axis] = backwards.any_true();
            if backwards.any_true() && !(backwards | empty).all_true() {
                return None;
            }
        }
        Some(planes)
    }

    /// The distances at which the rays enter a box of a node, and which of them do so before their
    /// limits.
    #[inline(always)]
    fn enter(
        &self,
        simd: S,
        node: Node<'_>,
        lane: usize,
        limit: f32x16<S>,
    ) -> (f32x16<S>, mask32x16<S>) {
        let plane = |axis: usize, side: bool| {
            let plane = f32x16::splat(simd, f32::from_bits(node.planes(axis, side)[lane % WIDTH]));
            plane.mul_add(self.reciprocal[axis], self.offset[axis])
        };
        let [x, y, z] = self.backwards;
        let near = plane(0, x).max(plane(1, y)).max(plane(2, z).max(f32x16::splat(simd, 0.0)));
        let far = plane(0, !x).min(plane(1, !y)).min(plane(2, !z).min(limit));
        (near, near.simd_le(far))
    }
}

/// The search for the nearest hits of a packet.
struct Search<'a, 'r, S: Simd> {
    bvh: &'a Bvh,
    rays: &'r Rays,
    origin: [f32x16<S>; 3],
    direction: [f32x16<S>; 3],
    origin_primitive: u32x16<S>,
    limit: f32x16<S>,
    /// The hits that are certain and yet to be tested.
    held: [Option<Candidate<'a>>; RAYS],
    held_primitive: u32x16<S>,
    held_near: f32x16<S>,
    /// The answers of tests that could not wait.
    early: [Option<Found<'a>>; RAYS],
}

impl<'a, 'r, S: Simd> Search<'a, 'r, S> {
    #[inline(always)]
    fn new(simd: S, bvh: &'a Bvh, rays: &'r mut Rays) -> Self {
        let (entered, BoxRays { origin, direction }) = rays.enter(simd, bvh);
        let limit = limited(simd, entered, f32x16::splat(simd, FAR));
        let none = u32x16::splat(simd, u32::MAX);
        Self {
            bvh,
            rays,
            origin,
            direction,
            origin_primitive: u32x16::load_array_ref(simd, &rays.start),
            limit,
            held: [None; RAYS],
            held_primitive: none,
            held_near: f32x16::splat(simd, f32::INFINITY),
            early: [const { None }; RAYS],
        }
    }

    /// Tests the facets of a block.
    #[inline(always)]
    fn test(&mut self, simd: S, block: Block<'a>) {
        let rows = Rows::new(simd, block);
        for lane in 0..LANES {
            let tested = Tested::new(
                simd,
                &self.origin,
                &self.direction,
                self.limit,
                rows.facet(simd, lane),
            );
            if !tested.hits.any_true() {
                continue;
            }
            let candidate = Candidate { block, lane };
            let primitive = u32x16::splat(simd, candidate.primitive());
            let certain = tested.hits & tested.certain();
            let (near, far) = tested.interval(simd);
            let dropped = certain
                & (primitive.simd_eq(self.held_primitive)
                    | primitive.simd_eq(self.origin_primitive)
                    | near.simd_gt(self.limit));
            let nearer = certain & !dropped & far.simd_lt(self.held_near);
            let mut to_hold = nearer.to_bitmask();
            while to_hold != 0 {
                self.held[take(&mut to_hold) % RAYS] = Some(candidate);
            }
            self.held_primitive = nearer.select(primitive, self.held_primitive);
            self.held_near = nearer.select(near, self.held_near);
            self.limit = nearer.select(self.limit.min(far), self.limit);
            let mut unclear = (tested.hits & !dropped & !nearer).to_bitmask();
            if unclear != 0 {
                let mut limits = self.limit.to_array();
                while unclear != 0 {
                    let lane = take(&mut unclear) % RAYS;
                    if let Some(nearer) = self.bvh.test_early(
                        candidate,
                        &self.rays.ray(lane),
                        self.rays.start[lane],
                        &mut self.early[lane],
                    ) {
                        limits[lane] = limits[lane].min(nearer);
                    }
                }
                self.limit = f32x16::load_array(simd, limits);
            }
        }
    }

    /// Walks through the tree, to the children that the first of the rays enters first.
    #[inline(always)]
    fn walk(&mut self, simd: S, planes: &Planes<S>) {
        let wide = &self.bvh.wide;
        let (mut stack, mut length) = (Stack::default(), 0);
        let mut next = Some(Entry::default());
        while let Some(Entry { near, child }) = next {
            let child = Child(child);
            if !f32x16::load_array_ref(simd, &near).simd_le(self.limit).any_true() {
                // All have found something nearer since.
            } else if child.is_leaf() {
                if let Some(block) = wide.block(child.line()) {
                    self.test(simd, block);
                }
            } else if let Some(node) = wide.node(child.line()) {
                let mut entries = [Entry::default(); WIDTH];
                let mut order = [0u64; WIDTH];
                let mut count = 0;
                for lane in 0..WIDTH {
                    let child = node.child(lane);
                    let (near, hits) = planes.enter(simd, node, lane, self.limit);
                    let bits = hits.to_bitmask();
                    if bits == 0 {
                        continue;
                    }
                    wide.prefetch(simd, child);
                    let near = hits.select(near, f32x16::splat(simd, f32::INFINITY)).to_array();
                    entries[count % WIDTH] = Entry { near, child: child.0 };
                    let first = near[bits.trailing_zeros() as usize % RAYS];
                    let key = u64::from(first.to_bits()) << 32 | count as u64;
                    let mut at = count;
                    count += 1;
                    while at > 0 && order[(at - 1) % WIDTH] < key {
                        order[at % WIDTH] = order[(at - 1) % WIDTH];
                        at -= 1;
                    }
                    order[at % WIDTH] = key;
                }
                stack.reserve(&mut length);
                for key in &order[..count] {
                    stack.push(&mut length, entries[*key as usize % WIDTH]);
                }
            }
            next = stack.pop(&mut length);
        }
    }

    /// Tells what was found.
    #[inline(always)]
    fn end(mut self, simd: S, hits: &mut [Option<Hit<'a>>]) {
        for (half, hits) in hits.chunks_mut(EIGHT).enumerate() {
            let decided = meet_flat(simd, self.rays, half, |lane| {
                self.held[lane].and_then(|held| self.bvh.corners_of(held))
            });
            for (k, hit) in hits.iter_mut().enumerate() {
                let lane = half * EIGHT + k;
                let late = self.held[lane].zip(decided.hit(k));
                let late =
                    late.map(|(candidate, intersection)| Found::new(candidate, intersection));
                let found = Found::nearer(late, self.early[lane].take());
                *hit = found.map(|found| found.hit(self.rays.moved[lane]));
            }
        }
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
        Self {
            vectors: [rows(vertex), rows(edge1), rows(edge2), rows(normal)],
            tolerance: tolerance.to_array(),
            slack: slack.to_array(),
        }
    }

    /// A facet of the block, in all lanes.
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
