//! Connections of the vertices of two complete subpaths, with their weights, for many pairs at a
//! time: the vertices of the camera subpath in lanes, with one of the light subpath after the
//! other.

use super::edge::{self, Edge};
use super::mis::Side;
use super::{Plan, Subpaths, Vertex, Weighting};
use crate::bsdf::{Bsdf, LaneForm, on_same_side};
use crate::film::Technique;
use crate::lanes::dispatch;
use crate::lanes::{Group, LANES, Lane, Mask, Rows, Vector, load, splat, store};
use crate::math::Rgb;
use crate::scene::Scene;
use fearless_simd::{Level, Simd, f64x8};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Numbers of a vertex: position, normal, direction to the previous vertex, throughput, f, and what
/// weights take of its [`Side`]. All are 0 where lanes have no form for it.
const VERTEX: usize = 20;

/// Numbers of a pair: direction and geometry term of the edge, estimate, weight, state.
const PAIR: usize = 9;

/// The state of a pair that lanes have no form for.
const UNKNOWN: f64 = -1.0;
/// The state of an estimate that is black; of another one it is 1.
const BLACK: f64 = 0.0;

/// The connections between Lambertian vertices of a sample's subpaths.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// Vertices of the camera subpath from its first surface on.
    camera: Rows<VERTEX>,
    /// Those of the light subpath.
    light: Vec<[f64; VERTEX]>,
    /// Pairs, by the vertices of the light subpath.
    found: Vec<Group<PAIR>>,
    /// Groups for each of them; 0 if nothing was evaluated.
    groups: usize,
}

/// A connection that was evaluated.
pub(super) struct Pair {
    pub edge: Edge,
    /// Unweighted estimate; perhaps black.
    pub value: Rgb,
    pub weight: f64,
}

impl Pairs {
    /// Forgets the pairs of the sample before.
    #[inline]
    pub fn clear(&mut self) {
        self.groups = 0;
    }

    /// Evaluates the pairs of complete subpaths, as far as lanes can and paths of the length count.
    #[inline]
    pub fn evaluate<'s, S: Scene + ?Sized>(
        &mut self,
        level: Level,
        Plan { stage, techniques, .. }: &Plan<'s, S>,
        weighting: &Weighting,
        Subpaths { camera, light, .. }: &Subpaths<'s, S>,
    ) {
        let Some(emitter) = light.first().and_then(|start| start.light) else { return };
        let has_pairs = camera.len() > 1 && light.len() > 1 && techniques.connections;
        if !(has_pairs && weighting.has_lanes()) {
            return;
        }
        self.camera.clear();
        for t in 2..=camera.len() {
            let side = || weighting.camera_side_of(&camera[..t]);
            let (vectors, rest) = numbers(&camera[t - 1], side);
            self.camera.push(vectors, rest);
        }
        self.light.clear();
        let emitter = stage.scene.light(emitter);
        for s in 2..=light.len() {
            let side = || weighting.light_side_of(&light[..s], emitter);
            let (vectors, rest) = numbers(&light[s - 1], side);
            let mut all = [0.0; VERTEX];
            all[..15].copy_from_slice(vectors.map(|vector| vector.to_array()).as_flattened());
            all[15..].copy_from_slice(&rest);
            self.light.push(all);
        }
        self.connect(level, weighting);
    }

    #[inline(never)]
    fn connect(&mut self, level: Level, weighting: &Weighting) {
        self.groups = self.camera.groups().len();
        self.found.resize(self.light.len() * self.groups, [[UNKNOWN; LANES]; PAIR]);
        dispatch!(level, simd => connect_all(simd, weighting, self));
    }

    /// The connection of a technique, if it was evaluated.
    #[inline]
    pub fn get(&self, Technique { s, t, .. }: Technique) -> Option<Pair> {
        if self.groups == 0 || s < 2 || t < 2 {
            return None;
        }
        let (s, t) = (usize::from(s) - 2, usize::from(t) - 2);
        let group = self.found.get(s * self.groups + t / LANES)?;
        let [x, y, z, geometry, red, green, blue, weight, state] =
            std::array::from_fn(|row| group[row][t % LANES]);
        (state != UNKNOWN).then(|| Pair {
            edge: Edge { direction: DVec3::new(x, y, z), geometry },
            value: if state == BLACK { Rgb::BLACK } else { Rgb::new(red, green, blue) },
            weight,
        })
    }
}

/// The vectors among the numbers of a vertex, and the others.
#[inline]
fn numbers<B: Bsdf>(
    vertex: &Vertex<B>,
    side: impl FnOnce() -> Side<f64>,
) -> ([DVec3; 5], [f64; 5]) {
    let Some(LaneForm::Lambert(lambert)) = vertex.lane_form() else { return Default::default() };
    let colours = [vertex.throughput, lambert.albedo() * FRAC_1_PI];
    let [throughput, f] = colours.map(|colour| DVec3::from_array(colour.0));
    let x = &vertex.point;
    let vectors = [x.position, x.geometric_normal, vertex.to_previous, throughput, f];
    (vectors, side().numbers())
}

/// A Lambertian vertex in each lane.
struct Lambertian<L> {
    position: Vector<L>,
    normal: Vector<L>,
    to_previous: Vector<L>,
    throughput: Vector<L>,
    f: Vector<L>,
    side: Side<L>,
}

impl<L: Lane> Lambertian<L> {
    #[inline(always)]
    fn new(numbers: [L; VERTEX]) -> Self {
        let vector = |i: usize| Vector::new(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
        Self {
            position: vector(0),
            normal: vector(1),
            to_previous: vector(2),
            throughput: vector(3),
            f: vector(4),
            side: Side::new([numbers[15], numbers[16], numbers[17], numbers[18], numbers[19]]),
        }
    }

    /// True where it reflects between the previous vertex and a direction.
    #[inline(always)]
    fn reflects(&self, direction: Vector<L>) -> L::Mask {
        on_same_side(self.normal.dot(direction), self.normal.dot(self.to_previous))
    }
}

#[inline(always)]
fn connect_all<S: Simd>(simd: S, weighting: &Weighting, pairs: &mut Pairs) {
    for (light, found) in pairs.light.iter().zip(pairs.found.chunks_mut(pairs.groups)) {
        let z = Lambertian::new(splat(simd, light));
        for (camera, found) in pairs.camera.groups().iter().zip(found) {
            connect(weighting, &Lambertian::new(load(simd, camera)), &z, found);
        }
    }
}

/// [`Path::connect`](super::Path::connect) and [`Weighting::weight`], in lanes.
#[inline(always)]
fn connect<S: Simd>(
    weighting: &Weighting,
    y: &Lambertian<f64x8<S>>,
    z: &Lambertian<f64x8<S>>,
    found: &mut Group<PAIR>,
) {
    let (direction, geometry, is_exact) =
        edge::between(y.position, z.position, |w| y.normal.dot(w).abs() * z.normal.dot(w).abs());
    let from_light = (z.f * z.throughput) * geometry;
    let Vector { x: red, y: green, z: blue } = (y.throughput * y.f) * from_light;
    let (zero, onwards) = (red.constant(0.0), red.constant(FRAC_1_PI));
    let is_black = red.equals(zero) & green.equals(zero) & blue.equals(zero);
    let reflects = y.reflects(direction) & z.reflects(-direction);
    let x = onwards * geometry;
    let weight = weighting.weight_of_connection([(&y.side, x, onwards), (&z.side, x, onwards)]);
    // A normal of length 0 is no vertex.
    let is_known =
        y.normal.length_squared().is_positive() & z.normal.length_squared().is_positive();
    let state = (reflects & !is_black).indicator(zero);
    let state = (is_known & is_exact).choose(state, zero.constant(UNKNOWN));
    let Vector { x, y, z } = direction;
    store(found, [x, y, z, geometry, red, green, blue, weight, state]);
}
