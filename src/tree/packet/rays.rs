//! Sixteen rays side by side, and facets to test them against one by one.

use crate::geometry::{Ray, SurfacePoint};
use crate::tree::bvh::Bvh;
use crate::tree::facets::Facets;
use crate::tree::layout::{Block, LANES};
use crate::tree::query::Query;
use crate::tree::rounding::FAR;
use fearless_simd::{Simd, f32x4, f32x16, prelude::*};
use glam::DVec3;

/// Rays of a packet.
pub(in crate::tree) const RAYS: usize = 16;

/// True for an instruction set with which packets are faster than rays that take turns: one of 16
/// lanes.
#[inline(always)]
pub(super) fn pays<S: Simd>(_: S) -> bool {
    S::f32s::LEN == RAYS
}

/// The rays of a packet in the space of the boxes, by axis. A limit that is no number is that of a
/// lane without ray.
pub(super) struct Packet {
    origin: [[f32; RAYS]; 3],
    direction: [[f32; RAYS]; 3],
    limit: [f32; RAYS],
}

impl Packet {
    #[inline(always)]
    pub fn new() -> Self {
        Self { origin: [[0.0; RAYS]; 3], direction: [[0.0; RAYS]; 3], limit: [f32::NAN; RAYS] }
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, bvh: &Bvh, origin: DVec3, direction: DVec3, limit: f32) {
        let (origin, direction) = (bvh.place(origin), direction.as_vec3());
        for axis in 0..3 {
            (self.origin[axis][lane], self.direction[axis][lane]) = (origin[axis], direction[axis]);
        }
        self.limit[lane] = limit;
    }

    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> ([f32x16<S>; 3], [f32x16<S>; 3], f32x16<S>) {
        let row = |row: &[f32; RAYS]| f32x16::load_array_ref(simd, row);
        let rows = |v: &[[f32; RAYS]; 3]| [row(&v[0]), row(&v[1]), row(&v[2])];
        (rows(&self.origin), rows(&self.direction), row(&self.limit))
    }
}

/// The rays of a packet and what else their exact tests need.
pub(super) struct Rays {
    pub packet: Packet,
    /// The rays of the exact test, and how far each was moved.
    pub rays: [(Ray, f64); RAYS],
    /// The primitives that they start on.
    pub origins: [u32; RAYS],
}

impl Rays {
    /// A packet of up to sixteen; a ray that does not enter the scene leaves its lane empty.
    #[inline(always)]
    pub fn new(bvh: &Bvh, queries: &[Query]) -> Self {
        let mut rays = Self {
            packet: Packet::new(),
            rays: [(Ray::new(DVec3::ZERO, DVec3::X), 0.0); RAYS],
            origins: [SurfacePoint::NONE; RAYS],
        };
        for (lane, query) in queries.iter().enumerate().take(RAYS) {
            if let Some((origin, direction, moved)) = bvh.entry(query.origin, query.direction) {
                rays.packet.set(lane, bvh, origin, direction, FAR);
                rays.rays[lane] = (Ray::new(origin, direction), moved);
                rays.origins[lane] = query.origin_primitive;
            }
        }
        rays
    }
}

/// The facets of a block, to be taken one by one.
pub(super) struct Rows {
    vectors: [[[f32; LANES]; 3]; 4],
    tolerance: [f32; LANES],
    slack: [f32; LANES],
}

impl Rows {
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, block: Block<'_>) -> Self {
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
    pub fn facet<S: Simd>(&self, simd: S, lane: usize) -> Facets<f32x16<S>> {
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
