//! Scenes of few primitives, which are flat or spheres: each ray is tested against all of them,
//! sixteen rays at a time, without a tree.

use super::RAYS;
use super::ball::Ball;
use super::plane::Facet;
use super::rays::{BoxRays, Rays, eight, limited};
use crate::geometry::{Intersection, Met, Shape, Sphere, largest_axis, shear_along, sheared};
use crate::lanes::{LANES, Lane, Mask, Vector};
use crate::tree::bvh::Bvh;
use crate::tree::layout::FEW;
use crate::tree::query::{Hit, Query, Segment};
use crate::tree::rounding::{FAR, UP};
use crate::tree::space::Space;
use crate::tree::stack::take;
use fearless_simd::{Simd, dispatch, f32x16, f64x8, mask64x8, prelude::*, u32x16};
use glam::DVec3;

/// All primitives of a scene that has few.
#[derive(Debug, Default)]
pub(in crate::tree) struct Few {
    /// What is flat, in the order of the primitives' numbers.
    facets: Vec<Facet>,
    corners: Vec<Corners>,
    primitives: Vec<u32>,
    spheres: Vec<(u32, Ball, Sphere)>,
}

/// Coordinates x, y, z, x, y of four corners, so that three rows in succession have any axis last.
/// The fourth corner of a triangle is its first.
#[derive(Debug)]
struct Corners {
    rows: [[f64; 4]; 5],
    is_triangle: bool,
}

impl Corners {
    fn new(corners: [DVec3; 4], is_triangle: bool) -> Self {
        let rows = [0, 1, 2, 0, 1].map(|axis| corners.map(|corner| corner[axis]));
        Self { rows, is_triangle }
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
            let (outline, third, is_triangle) = match &shapes[primitive as usize] {
                Shape::Triangle(t) => {
                    let [a, b, c] = t.vertices;
                    ([a, b, c, a], c, true)
                }
                Shape::Quad(q) => {
                    let outline = q.corners();
                    (outline, outline[3], false)
                }
                Shape::Sphere(sphere) => {
                    few.spheres.push((primitive, Ball::new(sphere, space), *sphere));
                    continue;
                }
                Shape::Disk(_) => return None,
            };
            let [a, b, c] = [outline[0], outline[1], third].map(|corner| space.place(corner));
            few.facets.push(Facet::new(a, [b - a, c - a], is_triangle));
            few.corners.push(Corners::new(outline, is_triangle));
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
}

/// No facet.
const NONE: u32 = u32::MAX;

/// The answers of [`Bvh::closest`] for many rays in a scene of few facets; false for another one.
#[inline(never)]
pub(in crate::tree) fn closest<'a>(
    bvh: &'a Bvh,
    queries: &[Query],
    hits: &mut [Option<Hit<'a>>],
) -> bool {
    let Some(few) = &bvh.few else { return false };
    dispatch!(bvh.level, simd => closest_with(simd, bvh, few, queries, hits));
    true
}

#[inline(always)]
fn closest_with<'a, S: Simd>(
    simd: S,
    bvh: &'a Bvh,
    few: &Few,
    queries: &[Query],
    hits: &mut [Option<Hit<'a>>],
) {
    for (queries, hits) in queries.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
        let mut rays = Rays::of(queries);
        closest_of_packet(simd, bvh, few, &mut rays, hits);
    }
}

#[inline(always)]
fn closest_of_packet<'a, S: Simd>(
    simd: S,
    bvh: &'a Bvh,
    few: &Few,
    rays: &mut Rays,
    hits: &mut [Option<Hit<'a>>],
) {
    let (entered, BoxRays { origin, direction }) = rays.enter(simd, bvh);
    let mut limit = limited(simd, entered, f32x16::splat(simd, FAR));
    let start = u32x16::load_array_ref(simd, &rays.start);
    let (mut held, mut held_near) = (u32x16::splat(simd, NONE), f32x16::splat(simd, f32::INFINITY));
    // A bit for each ray that may hit a facet but not certainly nearest. Their turn comes later:
    // nothing is called in this loop, so that its numbers stay in registers.
    let (mut unclear, mut any_unclear) = ([0; FEW], 0);
    for (number, (facet, primitive)) in (0..).zip(few.facets.iter().zip(&few.primitives)) {
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
        few.test_unclear(bvh, rays, &unclear, &mut early);
    }
    for (primitive, ball, sphere) in &few.spheres {
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
        let decided = few.decide(simd, rays, half, &held);
        for (k, hit) in hits.iter_mut().enumerate() {
            let lane = half * LANES + k;
            let late = (decided.hits >> k & 1 != 0).then(|| {
                let intersection =
                    Intersection { t: decided.t[k], u: decided.u[k], v: decided.v[k] };
                (few.primitives[held[lane] as usize], intersection)
            });
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

/// What eight exact tests have found.
struct Decided {
    /// A bit for each hit.
    hits: u64,
    t: [f64; LANES],
    u: [f64; LANES],
    v: [f64; LANES],
}

impl Few {
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

    /// The exact tests of eight rays, each with the facet that is held for it.
    #[inline(always)]
    fn decide<S: Simd>(&self, simd: S, rays: &Rays, half: usize, held: &[u32; RAYS]) -> Decided {
        let (origin, direction) = rays.half(simd, half);
        let [x, y] = largest_axis(direction);
        let (origin, direction) = (rotated(origin, [x, y]), rotated(direction, [x, y]));
        let shear = shear_along(direction);
        let (x, y) = (x.to_bitmask(), y.to_bitmask());
        let mut corners = [[[0.0; 4]; LANES]; 3];
        let (mut there, mut triangles) = (0u64, 0u64);
        for lane in 0..LANES {
            let number = held[half * LANES + lane];
            let Some(facet) = self.corners.get(number as usize) else { continue };
            there |= 1 << lane;
            triangles |= u64::from(facet.is_triangle) << lane;
            let rotation = (x >> lane & 1 | (y >> lane & 1) << 1) as usize % 3;
            for axis in 0..3 {
                corners[axis][lane] = facet.rows[rotation + axis];
            }
        }
        let [x, y, z] = &corners;
        let (x, y, z) = (transposed(simd, x), transposed(simd, y), transposed(simd, z));
        let a = sheared(shear, Vector::new(x[0], y[0], z[0]) - origin);
        let b = sheared(shear, Vector::new(x[1], y[1], z[1]) - origin);
        let c = sheared(shear, Vector::new(x[2], y[2], z[2]) - origin);
        let d = sheared(shear, Vector::new(x[3], y[3], z[3]) - origin);
        let is_triangle = mask64x8::from_bitmask(simd, triangles);
        let triangle = Met::triangle(a, b, c);
        let quad = triangle.first_half().or(Met::triangle(a, c, d).second_half());
        let (of_triangle, of_quad) = (triangle.hit.to_bitmask(), quad.hit.to_bitmask());
        Decided {
            hits: there & (triangles & of_triangle | !triangles & of_quad),
            t: is_triangle.select(triangle.t, quad.t).into(),
            u: is_triangle.select(triangle.u, quad.u).into(),
            v: is_triangle.select(triangle.v, quad.v).into(),
        }
    }
}

/// The components in cyclic order with the first axis last where the first is true, and with the
/// second axis last where the second is.
#[inline(always)]
fn rotated<L: Lane>(v: Vector<L>, [x, y]: [L::Mask; 2]) -> Vector<L> {
    Vector::new(
        x.choose(v.y, y.choose(v.z, v.x)),
        x.choose(v.z, y.choose(v.x, v.y)),
        x.choose(v.x, y.choose(v.y, v.z)),
    )
}

/// The exact tests of eight rays and a sphere, on which they may start, or end at their lengths: a
/// bit for each hit, and where.
#[inline(always)]
fn meet_sphere<S: Simd>(
    simd: S,
    primitive: u32,
    sphere: &Sphere,
    rays: &Rays,
    half: usize,
    length: Option<f64x8<S>>,
) -> (u64, f64x8<S>) {
    let (origin, direction) = rays.half(simd, half);
    let center = sphere.center;
    let from = Vector::new(origin.x - center.x, origin.y - center.y, origin.z - center.z);
    let (hits, mut t) = sphere.meet(from, direction);
    let mut hits = hits.to_bitmask();
    let start = touching(primitive, &rays.start, half);
    if start != 0 {
        let (again, chord) = sphere.meet_again(from, direction);
        hits = hits & !start | again.to_bitmask() & start;
        t = mask64x8::from_bitmask(simd, start).select(chord, t);
    }
    if let Some(length) = length {
        let end = touching(primitive, &rays.end, half);
        if end != 0 {
            let (before, chord) = sphere.meet_before(from, direction, length);
            hits = hits & !end | before.to_bitmask() & end & !start;
            t = mask64x8::from_bitmask(simd, end).select(chord, t);
        }
        hits &= t.simd_lt(length).to_bitmask();
    }
    (hits, t)
}

/// A bit for each of eight ends that lies on a primitive.
#[inline(always)]
fn touching(primitive: u32, ends: &[u32; RAYS], half: usize) -> u64 {
    let ends = ends[half * LANES..][..LANES].iter().enumerate();
    ends.fold(0, |bits, (k, end)| bits | u64::from(*end == primitive) << k)
}

/// Numbers of four corners in each of eight lanes, as vectors of each corner.
#[inline(always)]
fn transposed<S: Simd>(simd: S, corners: &[[f64; 4]; LANES]) -> [f64x8<S>; 4] {
    let [p, q, r, s] = corners.as_flattened().as_chunks().0 else { unreachable!() };
    let (p, q) = (f64x8::load_array_ref(simd, p), f64x8::load_array_ref(simd, q));
    let (r, s) = (f64x8::load_array_ref(simd, r), f64x8::load_array_ref(simd, s));
    let (even, odd) = (p.unzip_low(q), p.unzip_high(q));
    let (even_last, odd_last) = (r.unzip_low(s), r.unzip_high(s));
    [
        even.unzip_low(even_last),
        odd.unzip_low(odd_last),
        even.unzip_high(even_last),
        odd.unzip_high(odd_last),
    ]
}

/// The answers of [`Bvh::is_free`] for many segments in a scene of few facets; false for another
/// one.
#[inline(never)]
pub(in crate::tree) fn are_free(
    bvh: &Bvh,
    segments: &[Result<Segment, bool>],
    free: &mut [bool],
) -> bool {
    let Some(few) = &bvh.few else { return false };
    dispatch!(bvh.level, simd => are_free_with(simd, bvh, few, segments, free));
    true
}

#[inline(always)]
fn are_free_with<S: Simd>(
    simd: S,
    bvh: &Bvh,
    few: &Few,
    segments: &[Result<Segment, bool>],
    free: &mut [bool],
) {
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
        blocked |= few.in_the_way(simd, bvh, &mut rays, &length);
        for (lane, answer) in free.iter_mut().enumerate() {
            *answer = blocked >> lane & 1 == 0;
        }
    }
}

impl Few {
    /// A bit for each segment of a packet on which something lies.
    #[inline(always)]
    fn in_the_way<S: Simd>(
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
            blocked = self.test_unclear_ways(bvh, rays, length, &unclear, blocked);
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
    fn test_unclear_ways(
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
