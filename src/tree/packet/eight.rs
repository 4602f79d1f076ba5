//! Exact tests of eight rays at a time.

use super::RAYS;
use super::rays::Rays;
use crate::geometry::{Intersection, Met, Shape, Sphere, largest_axis, shear_along, sheared};
use crate::lanes::{LANES, Lane, Mask, Vector};
use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;
use std::borrow::Borrow;

/// Coordinates x, y, z, x, y of four corners, so that three rows in succession have any axis last.
/// The fourth corner of a triangle is its first.
#[derive(Debug)]
pub(in crate::tree) struct Corners {
    rows: [[f64; 4]; 5],
    is_triangle: bool,
}

impl Corners {
    /// Those of a flat shape with an outline.
    #[inline(always)]
    pub fn of(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Triangle(triangle) => Some(Self::of_triangle(triangle.vertices)),
            Shape::Quad(quad) => Some(Self { rows: rows(quad.corners()), is_triangle: false }),
            Shape::Sphere(_) | Shape::Disk(_) => None,
        }
    }

    #[inline(always)]
    pub fn of_triangle([a, b, c]: [DVec3; 3]) -> Self {
        Self { rows: rows([a, b, c, a]), is_triangle: true }
    }
}

#[inline(always)]
fn rows(corners: [DVec3; 4]) -> [[f64; 4]; 5] {
    [0, 1, 2, 0, 1].map(|axis| corners.map(|corner| corner[axis]))
}

/// What eight exact tests have found.
pub(super) struct Decided {
    /// A bit for each hit.
    hits: u64,
    t: [f64; LANES],
    u: [f64; LANES],
    v: [f64; LANES],
}

impl Decided {
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> Option<Intersection> {
        (self.hits >> lane & 1 != 0).then(|| Intersection {
            t: self.t[lane],
            u: self.u[lane],
            v: self.v[lane],
        })
    }
}

/// The exact tests of the first or the second eight rays, each with the flat shape that is given for
/// its lane, if any.
#[inline(always)]
pub(super) fn meet_flat<S: Simd, C: Borrow<Corners>>(
    simd: S,
    rays: &Rays,
    half: usize,
    shape: impl Fn(usize) -> Option<C>,
) -> Decided {
    let (origin, direction) = rays.half(simd, half);
    let [x, y] = largest_axis(direction);
    let (origin, direction) = (rotated(origin, [x, y]), rotated(direction, [x, y]));
    let shear = shear_along(direction);
    let (x, y) = (x.to_bitmask(), y.to_bitmask());
    let [mut rows_x, mut rows_y, mut rows_z] = [[[0.0; 4]; LANES]; 3];
    let (mut there, mut triangles) = (0u64, 0u64);
    for lane in 0..LANES {
        let Some(shape) = shape(half * LANES + lane) else { continue };
        let Corners { rows, is_triangle } = shape.borrow();
        there |= 1 << lane;
        triangles |= u64::from(*is_triangle) << lane;
        let rotation = (x >> lane & 1 | (y >> lane & 1) << 1) as usize % 3;
        rows_x[lane] = rows[rotation];
        rows_y[lane] = rows[rotation + 1];
        rows_z[lane] = rows[rotation + 2];
    }
    let x = transposed(simd, &rows_x);
    let y = transposed(simd, &rows_y);
    let z = transposed(simd, &rows_z);
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
pub(super) fn meet_sphere<S: Simd>(
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
