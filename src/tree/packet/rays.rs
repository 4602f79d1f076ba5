//! Sixteen rays side by side, in f64 and as f32 sees them.

use super::RAYS;
use crate::geometry::{Ray, SurfacePoint};
use crate::lanes::{Group, LANES, Lane, Vector};
use crate::tree::bvh::Bvh;
use crate::tree::query::{Ends, Query, is_about_unit};
use crate::tree::rounding::CLIP;
use crate::tree::stack::take;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16, prelude::*};
use glam::DVec3;

/// The rays of a packet, by axis.
pub(super) struct Rays {
    origin: [[f64; RAYS]; 3],
    direction: [[f64; RAYS]; 3],
    /// The distances that origins were moved.
    pub moved: [f64; RAYS],
    /// The primitives that they start and end on.
    pub start: [u32; RAYS],
    pub end: [u32; RAYS],
    /// A bit for each lane with a ray.
    lanes: u64,
}

/// The same in the space of the boxes.
pub(super) struct BoxRays<S: Simd> {
    pub origin: [f32x16<S>; 3],
    pub direction: [f32x16<S>; 3],
}

impl Rays {
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            origin: [[0.0; RAYS]; 3],
            direction: [[0.0; RAYS]; 3],
            moved: [0.0; RAYS],
            start: [SurfacePoint::NONE; RAYS],
            end: [SurfacePoint::NONE; RAYS],
            lanes: 0,
        }
    }

    /// Up to sixteen rays.
    #[inline(always)]
    pub fn of(queries: &[Query]) -> Self {
        let mut rays = Self::new();
        for (lane, query) in queries.iter().enumerate().take(RAYS) {
            let ends = Ends { origin: query.origin_primitive, ..Ends::FREE };
            rays.set(lane, query.origin, query.direction, ends);
        }
        rays
    }

    /// Replaces the rays by up to sixteen of columns: origins and directions are the first six rows
    /// of two groups. Their ends are given, too.
    #[inline(always)]
    pub fn fill<const N: usize>(&mut self, groups: &[Group<N>], ends: &[Ends]) {
        for (half, group) in groups.iter().enumerate().take(RAYS / LANES) {
            for axis in 0..3 {
                self.origin[axis].as_chunks_mut().0[half] = group[axis];
                self.direction[axis].as_chunks_mut().0[half] = group[3 + axis];
            }
        }
        for (lane, ends) in ends.iter().enumerate().take(RAYS) {
            (self.start[lane], self.end[lane]) = (ends.origin, ends.end);
        }
        self.moved = [0.0; RAYS];
        self.lanes = (1 << ends.len().min(RAYS)) - 1;
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, origin: DVec3, direction: DVec3, ends: Ends) {
        self.place(lane, origin, direction);
        (self.start[lane], self.end[lane]) = (ends.origin, ends.end);
        self.lanes |= 1 << lane;
    }

    #[inline(always)]
    fn place(&mut self, lane: usize, origin: DVec3, direction: DVec3) {
        for axis in 0..3 {
            (self.origin[axis][lane], self.direction[axis][lane]) = (origin[axis], direction[axis]);
        }
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> (DVec3, DVec3) {
        let at = |v: &[[f64; RAYS]; 3]| DVec3::new(v[0][lane], v[1][lane], v[2][lane]);
        (at(&self.origin), at(&self.direction))
    }

    /// A ray as the exact test needs it.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> Ray {
        let (origin, direction) = self.get(lane);
        Ray::new(origin, direction)
    }

    /// Origins and directions of the first or the second eight rays.
    #[inline(always)]
    pub fn half<S: Simd>(&self, simd: S, half: usize) -> (Vector<f64x8<S>>, Vector<f64x8<S>>) {
        (vector(simd, &self.origin, half), vector(simd, &self.direction, half))
    }

    /// Lets all rays enter the scene, and returns a bit for each that does.
    #[inline(always)]
    pub fn enter<S: Simd>(&mut self, simd: S, bvh: &Bvh) -> (u64, BoxRays<S>) {
        let mut ready = 0;
        for half in 0..2 {
            let (origin, direction) = self.half(simd, half);
            let scale = origin.x.constant(bvh.inverse_extent);
            let place = (origin - same(simd, bvh.center)) * scale;
            let Vector { x, y, z } = place.abs();
            let inside = x.simd_le(CLIP) & y.simd_le(CLIP) & z.simd_le(CLIP);
            ready |= (inside & is_about_unit(direction)).to_bitmask() << (half * LANES);
        }
        let mut entered = self.lanes & ready;
        let mut others = self.lanes & !ready;
        while others != 0 {
            let lane = take(&mut others) % RAYS;
            let (origin, direction) = self.get(lane);
            if let Some((origin, direction, moved)) = bvh.entry(origin, direction) {
                self.place(lane, origin, direction);
                self.moved[lane] = moved;
                entered |= 1 << lane;
            }
        }
        let ((low, low_direction), (high, high_direction)) =
            (self.half(simd, 0), self.half(simd, 1));
        let scale = low.x.constant(bvh.space.inverse_extent);
        let center = same(simd, bvh.space.center);
        let origin = narrow((low - center) * scale, (high - center) * scale);
        (entered, BoxRays { origin, direction: narrow(low_direction, high_direction) })
    }
}

/// Half of a row.
#[inline(always)]
pub(super) fn eight<S: Simd>(simd: S, row: &[f64; RAYS], half: usize) -> f64x8<S> {
    f64x8::load_array_ref(simd, &row.as_chunks().0[half % 2])
}

#[inline(always)]
fn vector<S: Simd>(simd: S, rows: &[[f64; RAYS]; 3], half: usize) -> Vector<f64x8<S>> {
    Vector::new(
        eight(simd, &rows[0], half),
        eight(simd, &rows[1], half),
        eight(simd, &rows[2], half),
    )
}

/// A vector in all lanes.
#[inline(always)]
fn same<S: Simd>(simd: S, v: DVec3) -> Vector<f64x8<S>> {
    Vector::new(f64x8::splat(simd, v.x), f64x8::splat(simd, v.y), f64x8::splat(simd, v.z))
}

/// The limits of rays that are there; no number for others, which hit nothing.
#[inline(always)]
pub(super) fn limited<S: Simd>(simd: S, there: u64, limit: f32x16<S>) -> f32x16<S> {
    mask32x16::from_bitmask(simd, there).select(limit, f32x16::splat(simd, f32::NAN))
}

#[inline(always)]
fn narrow<S: Simd>(low: Vector<f64x8<S>>, high: Vector<f64x8<S>>) -> [f32x16<S>; 3] {
    [low.x.narrow(high.x), low.y.narrow(high.y), low.z.narrow(high.z)]
}
