//! Scenes of few primitives, which are flat or spheres: each ray is tested against all of them,
//! sixteen rays at a time, without a tree.

use super::RAYS;
use super::ball::Ball;
use super::eight::{Corners, meet_flat, meet_sphere};
use super::plane::Facet;
use super::rays::{BoxRays, Rays, eight, limited};
use crate::geometry::{Intersection, Shape, Sphere};
use crate::lanes::{Group, LANES, Rows, dispatch};
use crate::tree::bvh::Bvh;
use crate::tree::layout::FEW;
use crate::tree::query::{Ends, Hit, Query, Segment};
use crate::tree::rounding::{FAR, UP};
use crate::tree::space::Space;
use crate::tree::stack::take;
use fearless_simd::{Simd, f32x16, prelude::*, u32x16};

/// All primitives of a scene that has few.
#[derive(Debug, Default)]
pub(in crate::tree) struct Few {
    /// What is flat, in the order of the primitives' numbers.
    facets: Vec<Facet>,
    corners: Vec<Corners>,
    primitives: Vec<u32>,
    spheres: Vec<(u32, Ball, Sphere)>,
}

/// No facet.
const NONE: u32 = u32::MAX;

/// The answers of [`Bvh::closest`] for many rays in a scene of few facets; false for another one.
pub(in crate::tree) fn closest<'a>(
    bvh: &'a Bvh,
    queries: &[Query],
    hits: &mut [Option<Hit<'a>>],
) -> bool {
    let Some(few) = &bvh.few else { return false };
    for (queries, hits) in queries.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
        few.closest(bvh, &mut Rays::of(queries), hits);
    }
    true
}

/// [`closest`] of rays in columns.
pub(in crate::tree) fn closest_in_columns<'a>(
    bvh: &'a Bvh,
    few: &Few,
    rays: &[Group<6>],
    ends: &[Ends],
    hits: &mut [Option<Hit<'a>>],
) {
    let packets = rays.chunks(RAYS / LANES).zip(ends.chunks(RAYS));
    let mut rays = Rays::new();
    for ((groups, ends), hits) in packets.zip(hits.chunks_mut(RAYS)) {
        rays.fill(groups, ends);
        few.closest(bvh, &mut rays, hits);
    }
}

/// The answers of [`Bvh::is_free`] for many segments in a scene of few facets; false for another
/// one.
pub(in crate::tree) fn are_free(
    bvh: &Bvh,
    segments: &[Result<Segment, bool>],
    free: &mut [bool],
) -> bool {
    let Some(few) = &bvh.few else { return false };
    for (segments, free) in segments.chunks(RAYS).zip(free.chunks_mut(RAYS)) {
        let (mut rays, mut length, mut blocked) = (Rays::new(), [0.0; RAYS], 0);
        for (lane, segment) in segments.iter().enumerate() {
            match segment {
                Ok(segment) => {
                    rays.set(lane, segment.origin, segment.direction, segment.ends);
                    length[lane] = segment.length;
                }
                Err(free) => blocked |= u64::from(!free) << lane,
            }
        }
        blocked |= few.in_the_way(bvh, &mut rays, &length);
        enter(free, blocked);
    }
    true
}

/// [`are_free`] of segments in columns, whose lengths are in the seventh row.
pub(in crate::tree) fn are_free_in_columns<const N: usize>(
    bvh: &Bvh,
    few: &Few,
    segments: &Rows<N>,
    ends: &[Ends],
    free: &mut [bool],
) {
    let packets = segments.groups().chunks(RAYS / LANES).zip(ends.chunks(RAYS));
    let (mut rays, mut length) = (Rays::new(), [0.0; RAYS]);
    for ((groups, ends), free) in packets.zip(free.chunks_mut(RAYS)) {
        rays.fill(groups, ends);
        for (half, group) in groups.iter().enumerate().take(RAYS / LANES) {
            length.as_chunks_mut().0[half] = group[6];
        }
        enter(free, few.in_the_way(bvh, &mut rays, &length));
    }
}

/// Enters the answers, given a bit for each segment that is blocked.
fn enter(free: &mut [bool], blocked: u64) {
    for (lane, answer) in free.iter_mut().enumerate() {
        *answer = blocked >> lane & 1 == 0;
    }
}

impl Few {
    /// Some primitives, which are numbers of shapes in their order; `None` if they are too many, or
    /// if one is a disk.
    pub fn new(
        shapes: &[Shape],
        primitives: impl ExactSizeIterator<Item = u32>,
        space: &Space,
    ) -> Option<Self> {
        if primitives.len() == 0 || primitives.len() > FEW {
            return None;
        }
        let mut few = Self::default();
        for primitive in primitives {
            let shape = &shapes[primitive as usize];
            let (corners, is_triangle) = match shape {
                Shape::Triangle(triangle) => (triangle.vertices, true),
                Shape::Quad(quad) => {
                    let [a, b, _, d] = quad.corners();
                    ([a, b, d], false)
                }
                Shape::Sphere(sphere) => {
                    few.spheres.push((primitive, Ball::new(sphere, space), *sphere));
                    continue;
                }
                Shape::Disk(_) => return None,
            };
            let [a, b, c] = corners.map(|corner| space.place(corner));
            few.facets.push(Facet::new(a, [b - a, c - a], is_triangle));
            few.corners.extend(Corners::of(shape));
            few.primitives.push(primitive);
        }
        Some(few)
    }

    /// The memory that they take, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.facets[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.primitives[..])
            + size_of_val(&self.spheres[..])
    }

    /// Finds the nearest hits of a packet.
    #[inline(never)]
    fn closest<'a>(&self, bvh: &'a Bvh, rays: &mut Rays, hits: &mut [Option<Hit<'a>>]) {
        dispatch!(bvh.level, simd => self.closest_with(simd, bvh, rays, hits));
    }

    #[inline(always)]
    fn closest_with<'a, S: Simd>(
        &self,
        simd: S,
        bvh: &'a Bvh,
        rays: &mut Rays,
        hits: &mut [Option<Hit<'a>>],
    ) {
        let (entered, BoxRays { origin, direction }) = rays.enter(simd, bvh);
        let mut limit = limited(simd, entered, f32x16::splat(simd, FAR));
        let start = u32x16::load_array_ref(simd, &rays.start);
        let (mut held, mut held_near) =
            (u32x16::splat(simd, NONE), f32x16::splat(simd, f32::INFINITY));
        // A bit for each ray that may hit a facet but not certainly nearest. Their turn comes later:
        // nothing is called in this loop, so that its numbers stay in registers.
        let (mut unclear, mut any_unclear) = ([0; FEW], 0);
        for (number, (facet, primitive)) in (0..).zip(self.facets.iter().zip(&self.primitives)) {
            let seen = facet.meet(simd, &origin, &direction);
            // What is flat is not met again from where it is left.
            let hits = seen.hits(limit) & !u32x16::splat(simd, *primitive).simd_eq(start);
            let nearer = hits & seen.certain() & seen.far.simd_lt(held_near);
            held = nearer.select(u32x16::splat(simd, number), held);
            held_near = nearer.select(seen.near, held_near);
            limit = nearer.select(limit.min(seen.far), limit);
            let bits = (hits & !nearer).to_bitmask();
            unclear[number as usize % FEW] = bits;
            any_unclear |= bits;
        }
        let mut early: [Option<(u32, Intersection)>; RAYS] = [const { None }; RAYS];
        if any_unclear != 0 {
            self.test_unclear(bvh, rays, &unclear, &mut early);
        }
        for (primitive, ball, sphere) in &self.spheres {
            let may = ball.may_be_hit(&origin, &direction, limit).to_bitmask();
            if may == 0 {
                continue;
            }
            let mut limits = limit.to_array();
            for half in 0..2 {
                let (hits, t) = meet_sphere(simd, *primitive, sphere, rays, half, None);
                let (mut hits, t) = (hits & may >> (half * LANES), t.to_array());
                while hits != 0 {
                    let k = take(&mut hits) % LANES;
                    let (lane, t) = (half * LANES + k, t[k]);
                    if early[lane].is_none_or(|(other, found)| (t, *primitive) < (found.t, other)) {
                        early[lane] = Some((*primitive, Intersection { t, u: 0.0, v: 0.0 }));
                        limits[lane] = limits[lane].min(bvh.round_up(t));
                    }
                }
            }
            limit = f32x16::load_array(simd, limits);
        }
        let held = held.to_array();
        for (half, hits) in hits.chunks_mut(LANES).enumerate() {
            let decided = meet_flat(simd, rays, half, |lane| self.corners.get(held[lane] as usize));
            for (k, hit) in hits.iter_mut().enumerate() {
                let lane = half * LANES + k;
                let late = decided.hit(k).map(|hit| (self.primitives[held[lane] as usize], hit));
                let found = match (late, early[lane]) {
                    (Some(late), Some(early)) if (early.1.t, early.0) < (late.1.t, late.0) => {
                        Some(early)
                    }
                    (late, early) => late.or(early),
                };
                *hit = found.map(|(primitive, intersection)| Hit {
                    primitive,
                    candidate: None,
                    moved: rays.moved[lane],
                    intersection,
                });
            }
        }
    }

    /// The nearest hits of rays and facets, given by a bit for each ray. Rare.
    #[inline(never)]
    fn test_unclear(
        &self,
        bvh: &Bvh,
        rays: &Rays,
        unclear: &[u64; FEW],
        nearest: &mut [Option<(u32, Intersection)>; RAYS],
    ) {
        for (primitive, mut lanes) in self.primitives.iter().zip(*unclear) {
            while lanes != 0 {
                let lane = take(&mut lanes) % RAYS;
                let found = bvh.shapes[*primitive as usize].intersect(&rays.ray(lane));
                // Of equally near ones the first stays, whose number is the lowest.
                if let Some(found) = found
                    && nearest[lane].is_none_or(|(_, nearest)| found.t < nearest.t)
                {
                    nearest[lane] = Some((*primitive, found));
                }
            }
        }
    }

    /// A bit for each segment of a packet on which something lies.
    #[inline(never)]
    fn in_the_way(&self, bvh: &Bvh, rays: &mut Rays, length: &[f64; RAYS]) -> u64 {
        dispatch!(bvh.level, simd => self.in_the_way_with(simd, bvh, rays, length))
    }

    #[inline(always)]
    fn in_the_way_with<S: Simd>(
        &self,
        simd: S,
        bvh: &Bvh,
        rays: &mut Rays,
        length: &[f64; RAYS],
    ) -> u64 {
        let (entered, BoxRays { origin, direction }) = rays.enter(simd, bvh);
        let low = eight(simd, length, 0) - eight(simd, &rays.moved, 0);
        let high = eight(simd, length, 1) - eight(simd, &rays.moved, 1);
        // Not if it is no number either.
        let there = low.simd_gt(0.0).to_bitmask() | high.simd_gt(0.0).to_bitmask() << LANES;
        let inside = entered & there;
        let up = bvh.space.inverse_extent * UP;
        let limit =
            ((low * up).narrow(high * up) + f32::MIN_POSITIVE).min(f32x16::splat(simd, FAR));
        let limit = limited(simd, inside, limit);
        let start = u32x16::load_array_ref(simd, &rays.start);
        let end = u32x16::load_array_ref(simd, &rays.end);
        let (mut unclear, mut any_unclear, mut blocked) = ([0; FEW], 0, 0);
        for (i, (facet, primitive)) in self.facets.iter().zip(&self.primitives).enumerate() {
            let seen = facet.meet(simd, &origin, &direction);
            let number = u32x16::splat(simd, *primitive);
            // A segment meets what is flat at one of its ends nowhere else.
            let hits = seen.hits(limit) & !(number.simd_eq(start) | number.simd_eq(end));
            let certain = hits & seen.certain() & seen.far.simd_lt(limit);
            blocked |= certain.to_bitmask();
            let bits = (hits & !certain).to_bitmask();
            unclear[i % FEW] = bits;
            any_unclear |= bits;
            if blocked & inside == inside {
                return blocked;
            }
        }
        if any_unclear & !blocked != 0 {
            blocked = self.test_unclear_segments(bvh, rays, length, &unclear, blocked);
        }
        for (primitive, ball, sphere) in &self.spheres {
            let may = ball.may_be_hit(&origin, &direction, limit).to_bitmask();
            if may & !blocked == 0 {
                continue;
            }
            let (low, _) = meet_sphere(simd, *primitive, sphere, rays, 0, Some(low));
            let (high, _) = meet_sphere(simd, *primitive, sphere, rays, 1, Some(high));
            blocked |= may & (low | high << LANES);
        }
        blocked
    }

    /// The segments that are blocked by now, and those of others that facets block, given by a bit
    /// for each segment. Rare.
    #[inline(never)]
    fn test_unclear_segments(
        &self,
        bvh: &Bvh,
        rays: &Rays,
        length: &[f64; RAYS],
        unclear: &[u64; FEW],
        mut blocked: u64,
    ) -> u64 {
        for (primitive, lanes) in self.primitives.iter().zip(unclear) {
            let mut lanes = lanes & !blocked;
            while lanes != 0 {
                let lane = take(&mut lanes) % RAYS;
                let hit = bvh.shapes[*primitive as usize].intersect(&rays.ray(lane));
                let length = length[lane] - rays.moved[lane];
                blocked |= u64::from(hit.is_some_and(|hit| hit.t < length)) << lane;
            }
        }
        blocked
    }
}
