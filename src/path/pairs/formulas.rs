//! The formulas of connections: [`Path::connect`](crate::path::Path::connect) and
//! [`Weighting::weight`], in lanes.

use super::end::{END, End, bits};
use super::{BLACK, EMITTER, Emitter, LIT, PAIR, TO_EMITTER, TO_LENS, UNKNOWN};
use crate::endpoint::{FlatLanes, View};
use crate::geometry::SurfacePoint;
use crate::lanes::{Group, Lane, Mask, Vector, load, store};
use crate::path::mis::Side;
use crate::path::{Family, Weighting, edge};
use crate::tree::{LaneEnd, LaneSegment};
use fearless_simd::{Simd, f64x8};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Connects vertices of a camera subpath to points on flat lights.
#[inline(always)]
pub(super) fn connect_to_emitters<S: Simd>(
    simd: S,
    (weighting, center): (&Weighting, DVec3),
    camera: &Group<END>,
    emitters: &[Emitter<'_>],
    given: &Group<EMITTER>,
    found: &mut Group<TO_EMITTER>,
) {
    let y = End::new(load(simd, camera));
    let light = FlatLanes::gather(simd, emitters.iter().map(Emitter::flat));
    let [u1, u2, connection, walk, hitting, primitive] = load(simd, given);
    let (position, error, [u, v]) = light.point_at([u1, u2]);
    let ends = [y.point, LaneEnd { position, error, normal: light.normal }];
    let edge @ (direction, geometry, _) =
        between(ends, |w| y.cosine(w) * light.normal.dot(w).abs());
    let (one, onwards) = (u1.constant(1.0), u1.constant(FRAC_1_PI));
    let [red, green, blue] = light.radiance;
    let emitted = Vector::new(red, green, blue) * (one / connection);
    let hit = onwards * geometry;
    let weight = weighting.weight_of(
        Family::NextEventEstimation,
        [
            weighting.sum_of(&y.side, hit * (one / (connection / walk)), onwards),
            weighting.sum_of(&Side::of_start(connection, hitting), hit, onwards),
        ],
    );
    let is_lit = light.normal.dot(-direction).is_positive() & y.reflects(direction);
    let is_known = connection.is_positive();
    let segment = segment(ends, [y.primitive, primitive], center);
    let pair = evaluated(edge, segment, [y.scattered(), emitted], weight, [is_known, is_lit]);
    let Vector { x, y, z } = position;
    store_pair(found, pair, [x, y, z, error, u, v]);
}

/// Connects vertices of a light subpath to a pinhole.
#[inline(always)]
pub(super) fn connect_to_pinhole<S: Simd>(
    simd: S,
    (weighting, center): (&Weighting, DVec3),
    view: &View,
    light: &Group<END>,
    found: &mut Group<TO_LENS>,
) {
    let z = End::new(load(simd, light));
    let none = z.point.error.constant(0.0);
    let lens = LaneEnd {
        position: Vector::constant(view.position, none),
        error: none,
        normal: Vector::new(none, none, none),
    };
    let ends = [lens, z.point];
    let edge @ (direction, geometry, _) = between(ends, |w| z.cosine(w));
    let (raster, is_seen) = view.raster(direction);
    let density = view.pinhole_density(direction);
    let onwards = none.constant(FRAC_1_PI);
    let sums = [none, weighting.sum_of(&z.side, density * geometry, onwards)];
    let weight = weighting.weight_of(Family::LensSampling, sums);
    let states = [z.is_known(), z.reflects(-direction) & is_seen];
    let importance = Vector::new(density, density, density);
    let no_primitive = none.constant(bits(SurfacePoint::NONE));
    let segment = segment(ends, [no_primitive, z.primitive], center);
    let pair = evaluated(edge, segment, [importance, z.scattered()], weight, states);
    store_pair(found, pair, raster);
}

/// Connects vertices of a camera subpath to vertices of a light subpath.
#[inline(always)]
pub(super) fn connect_pairs<S: Simd>(
    simd: S,
    (weighting, center): (&Weighting, DVec3),
    camera: &Group<END>,
    z: &End<f64x8<S>>,
    found: &mut Group<PAIR>,
) {
    let y = End::new(load(simd, camera));
    let ends = [y.point, z.point];
    let edge @ (direction, geometry, _) = between(ends, |w| y.cosine(w) * z.cosine(w));
    let onwards = geometry.constant(FRAC_1_PI);
    let x = onwards * geometry;
    let sums = [weighting.sum_of(&y.side, x, onwards), weighting.sum_of(&z.side, x, onwards)];
    let weight = weighting.weight_of(Family::Connections, sums);
    let is_lit = y.reflects(direction) & z.reflects(-direction);
    let states = [y.is_known() & z.is_known(), is_lit];
    let segment = segment(ends, [y.primitive, z.primitive], center);
    store(found, evaluated(edge, segment, [y.scattered(), z.scattered()], weight, states));
}

/// The edges between vertices, given their cosines for the directions.
#[inline(always)]
fn between<L: Lane>(
    [a, b]: [LaneEnd<L>; 2],
    cosines: impl FnOnce(Vector<L>) -> L,
) -> (Vector<L>, L, L::Mask) {
    edge::between(a.position, b.position, cosines)
}

/// The shadow rays between vertices, with the primitives at both ends, in their order.
#[inline(always)]
fn segment<L: Lane>(
    [a, b]: [LaneEnd<L>; 2],
    primitives: [L; 2],
    center: DVec3,
) -> (LaneSegment<L>, [L; 2]) {
    let segment = LaneSegment::between(a, b, center);
    let first = segment.is_forward.choose(primitives[0], primitives[1]);
    let last = segment.is_forward.choose(primitives[1], primitives[0]);
    (segment, [first, last])
}

/// The numbers of connections, given their edges and segments, what the vertices scatter or emit,
/// the weights, and where they are known and lit.
#[inline(always)]
fn evaluated<L: Lane>(
    (direction, geometry, is_exact): (Vector<L>, L, L::Mask),
    (segment, primitives): (LaneSegment<L>, [L; 2]),
    [camera, light]: [Vector<L>; 2],
    weight: L,
    [is_known, is_lit]: [L::Mask; 2],
) -> [L; PAIR] {
    let LaneSegment { origin, direction: d, length, is_clear, .. } = segment;
    let Vector { x: red, y: green, z: blue } = camera * (light * geometry);
    let constant = |x| geometry.constant(x);
    let zero = constant(0.0);
    let is_black = !is_lit | (red.equals(zero) & green.equals(zero) & blue.equals(zero));
    let state = is_black.choose(constant(BLACK), constant(LIT));
    let is_known = is_known & is_exact & (is_black | is_clear);
    let state = is_known.choose(state, constant(UNKNOWN));
    let (Vector { x, y, z }, Vector { x: ox, y: oy, z: oz }) = (direction, origin);
    [
        x,
        y,
        z,
        geometry,
        red,
        green,
        blue,
        weight,
        state,
        ox,
        oy,
        oz,
        d.x,
        d.y,
        d.z,
        length,
        primitives[0],
        primitives[1],
    ]
}

#[inline(always)]
fn store_pair<S: Simd, const N: usize, const R: usize>(
    found: &mut Group<N>,
    pair: [f64x8<S>; PAIR],
    rest: [f64x8<S>; R],
) {
    const { assert!(PAIR + R == N, "as many numbers as rows") };
    for row in 0..PAIR {
        found[row] = pair[row].into();
    }
    for row in 0..R {
        found[PAIR + row] = rest[row].into();
    }
}
