//! The arithmetic of vertices in lanes.

use super::to_lights::LightPoint;
use crate::endpoint::{FlatLanes, FlatLight, View};
use crate::geometry::{Quad, Triangle, around, moved_towards, spanned};
use crate::lanes::{Group, LANES, Lane, Mask, Rows, Vector, load, store};
use crate::math::warp::cosine_hemisphere;
use crate::path::Heuristic;
use crate::path::diffuse::{Diffuse, INEXACT, LIT, LightPoints, Pinhole, to_pinhole};
use crate::scene::DIFFUSE;
use crate::tree::{LaneEnd, LaneSegment};
use fearless_simd::{Simd, f64x8};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// The surface of a vertex ([`FlatSurfaces::diffuse`](crate::scene::FlatSurfaces)), and the
/// parameters of the vertex.
pub(super) type Met = Rows<{ DIFFUSE + 2 }>;
/// Direction to the previous vertex, throughput, reference of roulette, survival.
pub(super) type Carried = Rows<8>;
/// Position, error bound, normal, albedo on the side that is seen.
pub(super) type Points = Rows<10>;
/// Origin, direction and length of a segment, and whether it starts at the vertex; estimate,
/// weight, state. The length is 0 unless the state is `LIT`.
pub(super) type LightConnections = Rows<13>;
/// Its rows of the last two.
pub(super) const IS_FORWARD: usize = 7;
pub(super) const STATE: usize = 12;
/// The same segment; estimate, place on the film, state.
pub(super) type LensConnections = Rows<14>;
/// Origin and direction of a ray; throughput, largest component relative to the reference, state.
pub(super) type Directions = Rows<11>;

/// The state of a walk that is absorbed.
pub(super) const ABSORBED: f64 = 0.0;
/// The state of a walk whose throughput is infinite or not a number; of one that goes on it is 1.
pub(super) const NOT_FINITE: f64 = 2.0;

/// Directions through window coordinates, and whether the lens has any there.
#[inline(always)]
pub(super) fn begin<S: Simd>(simd: S, view: &View, window: &Rows<2>, starts: &mut Rows<4>) {
    for (window, start) in window.groups().iter().zip(starts.groups_mut()) {
        let direction = view.direction_at(load(simd, window));
        let density = view.pinhole_density(direction);
        let Vector { x, y, z } = direction;
        store(start, [x, y, z, density.is_positive().indicator(x)]);
    }
}

/// The points of vertices.
#[inline(always)]
pub(super) fn place<S: Simd>(simd: S, met: &Met, carried: &Carried, points: &mut Points) {
    let vertices = met.groups().iter().zip(carried.groups());
    for ((met, carried), point) in vertices.zip(points.groups_mut()) {
        let [ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, triangle, rest @ ..] = load(simd, met);
        let [f0, f1, f2, b0, b1, b2, u, v] = rest;
        let [wx, wy, wz, ..] = load(simd, carried);
        let spans = [Vector::new(ax, ay, az), Vector::new(bx, by, bz), Vector::new(cx, cy, cz)];
        let is_triangle = triangle.is_positive();
        let one = u.constant(1.0);
        let (position, reach) = spanned(spans, [is_triangle.choose(one - u - v, one), u, v]);
        let rounding =
            is_triangle.choose(u.constant(Triangle::ROUNDING), u.constant(Quad::ROUNDING));
        let is_back = Vector::new(nx, ny, nz).dot(Vector::new(wx, wy, wz)).is_negative();
        let albedo = Vector::choose(is_back, Vector::new(b0, b1, b2), Vector::new(f0, f1, f2));
        let (Vector { x, y, z }, Vector { x: a0, y: a1, z: a2 }) = (position, albedo);
        store(point, [x, y, z, rounding * reach, nx, ny, nz, a0, a1, a2]);
    }
}

/// The vertices of a group, and their ends of shadow rays.
#[inline(always)]
fn vertices<S: Simd>(
    simd: S,
    point: &Group<10>,
    carried: &Group<8>,
) -> (Diffuse<f64x8<S>>, LaneEnd<f64x8<S>>) {
    let [px, py, pz, error, nx, ny, nz, a0, a1, a2] = load(simd, point);
    let [wx, wy, wz, t0, t1, t2, ..] = load(simd, carried);
    let (position, normal) = (Vector::new(px, py, pz), Vector::new(nx, ny, nz));
    let diffuse = Diffuse {
        position,
        normal,
        to_previous: Vector::new(wx, wy, wz),
        throughput: Vector::new(t0, t1, t2),
        albedo: Vector::new(a0, a1, a2),
    };
    (diffuse, LaneEnd { position, error, normal })
}

/// Next events with their weights, given for each vertex the light, and two random numbers with the
/// density of the point that they lead to.
#[inline(always)]
pub(super) fn connect_to_lights<S: Simd>(
    simd: S,
    (points, carried): (&Points, &Carried),
    (lights, numbers): (&[Option<LightPoint<'_>>], &Rows<3>),
    (heuristic, has_hits, center): (Heuristic, bool, DVec3),
    found: &mut LightConnections,
) {
    let given = lights.chunks(LANES).zip(numbers.groups());
    let groups = points.groups().iter().zip(carried.groups()).zip(given);
    for (((point, carried), (lights, numbers)), found) in groups.zip(found.groups_mut()) {
        let (vertices, end) = vertices(simd, point, carried);
        let light = FlatLanes::gather(simd, lights.iter().map(|point| Some(point.as_ref()?.light)));
        let [u1, u2, pdf] = load(simd, numbers);
        let LightPoints { position, error, geometry, value, state, .. } =
            vertices.next_event(&light, [u1, u2], pdf);
        let hit = if has_hits { geometry * FRAC_1_PI } else { pdf.constant(0.0) };
        let weight = pdf.constant(1.0) / (heuristic.raise_in_lanes(hit / pdf) + 1.0);
        let on_light = LaneEnd { position, error, normal: light.normal };
        let segment = LaneSegment::between(end, on_light, center);
        let state = unless_unclear(&segment, state);
        let [ox, oy, oz, dx, dy, dz, length, is_forward] = numbers_of(&segment);
        let length = state.equals(pdf.constant(LIT)).choose(length, pdf.constant(0.0));
        let Vector { x, y, z } = value;
        store(found, [ox, oy, oz, dx, dy, dz, length, is_forward, x, y, z, weight, state]);
    }
}

/// Points of a light that are uniform by area, as vertices of the throughput 1 / density and with
/// the emitted radiance in place of an albedo; and directions from there. Given four random numbers
/// for each.
#[inline(always)]
pub(super) fn emit<S: Simd>(
    simd: S,
    light: &FlatLight,
    numbers: &Rows<4>,
    points: &mut Points,
    starts: &mut Rows<9>,
) {
    let lanes = FlatLanes::gather(simd, std::iter::once(Some(light)));
    let groups = points.groups_mut().iter_mut().zip(starts.groups_mut());
    for (numbers, (point, start)) in numbers.groups().iter().zip(groups) {
        let [u0, u1, u2, u3] = load(simd, numbers);
        let (position, error, [u, v]) = lanes.point_at([u0, u1]);
        let (Vector { x, y, z }, n, [r, g, b]) = (position, lanes.normal, lanes.radiance);
        store(point, [x, y, z, error, n.x, n.y, n.z, r, g, b]);
        let local = cosine_hemisphere([u2, u3]);
        let [tangent, bitangent] = around(n);
        let direction = tangent * local.x + bitangent * local.y + n * local.z;
        let o = moved_towards(position, error, n, direction);
        // A direction in the tangent plane may round to the other side.
        let leaves = n.dot(direction).is_positive().indicator(u);
        let Vector { x, y, z } = direction;
        store(start, [o.x, o.y, o.z, x, y, z, u, v, leaves]);
    }
}

/// Connections to a pinhole; of starts if that is what the vertices are.
#[inline(always)]
pub(super) fn connect_to_pinhole<S: Simd>(
    simd: S,
    (points, carried): (&Points, &Carried),
    (view, center, are_starts): (&View, DVec3, bool),
    found: &mut LensConnections,
) {
    let groups = points.groups().iter().zip(carried.groups());
    for ((point, carried), found) in groups.zip(found.groups_mut()) {
        let (vertices, end) = vertices(simd, point, carried);
        let Pinhole { raster, value, state } = if are_starts {
            let (radiance, LaneEnd { position, normal, .. }) = (vertices.albedo, end);
            let emits = |to_lens| normal.dot(to_lens).is_positive();
            to_pinhole(view, position, normal, vertices.throughput * radiance, emits)
        } else {
            vertices.lens_connection(view)
        };
        let zero = state.constant(0.0);
        let lens = LaneEnd {
            position: Vector::constant(view.position, zero),
            error: zero,
            normal: Vector::new(zero, zero, zero),
        };
        let segment = LaneSegment::between(end, lens, center);
        let state = unless_unclear(&segment, state);
        let [ox, oy, oz, dx, dy, dz, length, is_forward] = numbers_of(&segment);
        let ([rx, ry], Vector { x, y, z }) = (raster, value);
        store(found, [ox, oy, oz, dx, dy, dz, length, is_forward, x, y, z, rx, ry, state]);
    }
}

/// The directions in which walks go on, given two random numbers for each.
#[inline(always)]
pub(super) fn scatter<S: Simd>(
    simd: S,
    (points, carried): (&Points, &Carried),
    numbers: &Rows<2>,
    directions: &mut Directions,
) {
    let groups = points.groups().iter().zip(carried.groups()).zip(numbers.groups());
    for (((point, carried), numbers), next) in groups.zip(directions.groups_mut()) {
        let (vertices, LaneEnd { position, error, normal }) = vertices(simd, point, carried);
        let [.., reference, _] = load(simd, carried);
        let (direction, is_reflected) = vertices.reflected(load(simd, numbers));
        let origin = moved_towards(position, error, normal, direction);
        let throughput = vertices.throughput * vertices.albedo;
        let largest = throughput.x.greater(throughput.y.greater(throughput.z));
        let infinity = largest.constant(f64::INFINITY);
        let is_finite = throughput.x.abs().less(infinity)
            & throughput.y.abs().less(infinity)
            & throughput.z.abs().less(infinity);
        let state = (is_reflected & largest.is_positive()).indicator(largest);
        let state = (!is_finite & is_reflected).choose(largest.constant(NOT_FINITE), state);
        let (Vector { x, y, z }, Vector { x: dx, y: dy, z: dz }) = (origin, direction);
        let Vector { x: t0, y: t1, z: t2 } = throughput;
        store(next, [x, y, z, dx, dy, dz, t0, t1, t2, largest / reference, state]);
    }
}

/// The state of connections, which are left to others where the segment is not clear.
#[inline(always)]
fn unless_unclear<L: Lane>(segment: &LaneSegment<L>, state: L) -> L {
    let is_left = state.is_positive() & !segment.is_clear;
    is_left.choose(state.constant(INEXACT), state)
}

#[inline(always)]
fn numbers_of<L: Lane>(segment: &LaneSegment<L>) -> [L; 8] {
    let LaneSegment { origin: o, direction: d, length, is_forward, .. } = *segment;
    [o.x, o.y, o.z, d.x, d.y, d.z, length, is_forward.indicator(length)]
}
