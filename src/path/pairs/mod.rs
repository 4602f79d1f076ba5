//! Connections of a sample's complete subpaths, with their weights, in lanes: the vertices of the
//! camera subpath with points on lights, those of the light subpath with a pinhole, and those of
//! the camera subpath with one of the light subpath after the other.
//!
//! Lanes have forms for Lambertian surfaces and flat lights; other connections stay unknown here.

mod end;
mod formulas;

use super::connect::emitter_at;
use super::diffuse::{BLACK, LIT};
use super::{Edge, Plan, SampledEndpoint, Stage, StartDensity, Subpaths, Vertex, Weighting};
use crate::endpoint::{FlatLight, Light, LightId, View};
use crate::film::Technique;
use crate::lanes::{Group, LANES, Rows, dispatch, splat, splat_halves};
use crate::math::{PerArea, Rgb};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use crate::tree::{Ends, Segment};
use fearless_simd::Level;
use glam::{DVec2, DVec3};

pub(super) use end::END;
use end::End;

/// Numbers of a point on a flat light: two that it is sampled with, its densities as the point that
/// a vertex connects to and as the start of a walk, the share of hits, and the primitive.
const EMITTER: usize = 6;

/// Numbers of a connection: direction and geometry term of the edge, estimate, weight, state;
/// origin, direction and length of the shadow ray, and the primitives at its ends.
const PAIR: usize = 18;

/// The same, and position, error bound and surface parameters of a point on a light.
const TO_EMITTER: usize = PAIR + 6;

/// The same, and the place on the film.
const TO_LENS: usize = PAIR + 2;

/// The state of a connection that lanes have no form for.
const UNKNOWN: f64 = -1.0;

/// The connections of a sample.
#[derive(Debug, Default)]
pub(super) struct Pairs<'s> {
    /// The points on lights, by the vertices of the camera subpath from its first surface on.
    emitters: Vec<Emitter<'s>>,
    /// Those that lanes have no form for.
    sampled: Vec<SampledEndpoint>,
    /// The numbers that lanes take of the others; 0 where there is none.
    flat: Rows<EMITTER>,
    /// The light subpath.
    light: Rows<END>,
    /// Connections to the points.
    to_emitters: Rows<TO_EMITTER>,
    /// Connections of the light subpath to the lens.
    to_lens: Rows<TO_LENS>,
    /// Connections to the camera subpath, by the vertices of the light subpath from its first
    /// surface on.
    inner: Vec<Group<PAIR>>,
    /// Lanes for each of them.
    width: usize,
}

/// A point on a light that a vertex connects to.
#[derive(Clone, Copy, Debug)]
enum Emitter<'s> {
    None,
    /// One of the points sampled.
    Sampled(usize),
    /// One that lanes sample.
    Flat(LightId, &'s FlatLight),
}

impl<'s> Emitter<'s> {
    fn flat(&self) -> Option<&'s FlatLight> {
        if let Self::Flat(_, light) = self { Some(light) } else { None }
    }
}

/// A connection that was evaluated.
pub(super) struct Pair {
    pub edge: Edge,
    /// Unweighted estimate; perhaps black.
    pub value: Rgb,
    pub weight: f64,
    /// The shadow ray.
    pub segment: Segment,
}

impl<'s> Pairs<'s> {
    /// Forgets the sample before.
    #[inline]
    pub fn clear(&mut self) {
        self.emitters.clear();
        self.sampled.clear();
        self.flat.clear();
        self.to_emitters.clear();
        self.to_lens.clear();
        self.inner.clear();
    }

    /// Samples the points on lights that the vertices of a complete camera subpath connect to, and
    /// evaluates the connections, as far as lanes can.
    #[inline]
    pub fn sample_emitters<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        level: Level,
        plan: &Plan<'s, S>,
        weighting: &Weighting,
        Subpaths { camera, camera_ends, .. }: &mut Subpaths<'s, S>,
        sampler: &mut P,
    ) {
        let center = center(&plan.stage, weighting);
        let (mut has_flat, mut has_surface) = (false, false);
        camera_ends.clear();
        for t in 2..=camera.len() {
            let vertex = &camera[t - 1];
            let lambert = center.and_then(|_| end::lambert(vertex));
            has_surface |= lambert.is_some();
            let side = || weighting.camera_side_of(&camera[..t]);
            let (vectors, rest) = end::of_surface(vertex, lambert, side);
            camera_ends.push(vectors, rest);
            let (mut emitter, mut numbers) = (Emitter::None, [0.0; EMITTER]);
            if vertex.is_connectible() && plan.draws(Technique::new(1, t as u16)) {
                sampler.stream(Stream::NextEvent(t as u32 - 1));
                let is_lambert = lambert.is_some();
                (emitter, numbers) = self.emitter_for(plan, weighting, vertex, is_lambert, sampler);
            }
            has_flat |= matches!(emitter, Emitter::Flat(..));
            self.emitters.push(emitter);
            self.flat.push([], numbers);
        }
        if !has_surface {
            return camera_ends.clear();
        }
        if camera.len() <= 1 + LANES / 2 {
            camera_ends.repeat();
        }
        if let Some(center) = center.filter(|_| has_flat) {
            self.connect_to_emitters(level, (weighting, center), camera_ends);
        }
    }

    /// Chooses a light for a vertex and samples a point on it, or leaves that to lanes, with the
    /// numbers that they take.
    #[inline(always)]
    fn emitter_for<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        Plan { stage, .. }: &Plan<'s, S>,
        weighting: &Weighting,
        Vertex { point, .. }: &Vertex<S::Bsdf<'s>>,
        is_lambert: bool,
        sampler: &mut P,
    ) -> (Emitter<'s>, [f64; EMITTER]) {
        // All numbers are drawn first, so that later dimensions do not depend on the outcome.
        let (u0, (u1, u2)) = (sampler.next_1d(), sampler.next_1d_2d());
        let none = (Emitter::None, [0.0; EMITTER]);
        let Some((id, pmf)) = stage.pick_light_for(point, u0) else { return none };
        let light = stage.scene.light(id);
        let is_far = |flat: &&FlatLight| is_lambert && !flat.is_near(point.position);
        if let Some(flat) = light.as_flat().filter(is_far) {
            let [connection, walk] = [pmf, stage.pick_pmf(id)].map(|pmf| flat.pdf.value() * pmf);
            if connection > 0.0 {
                let hitting = weighting.hitting(light);
                let primitive = end::bits(flat.primitive);
                let numbers = [u2.x, u2.y, connection, walk, hitting, primitive];
                return (Emitter::Flat(id, flat), numbers);
            }
        }
        let Some(emitter) = emitter_at(stage, point, (id, pmf), u1, u2) else { return none };
        self.sampled.push(emitter);
        (Emitter::Sampled(self.sampled.len() - 1), none.1)
    }

    #[inline(never)]
    fn connect_to_emitters(&mut self, level: Level, how: (&Weighting, DVec3), camera: &Rows<END>) {
        let Self { emitters, flat, to_emitters, .. } = self;
        to_emitters.resize(emitters.len());
        dispatch!(level, simd => {
            let groups = emitters.chunks(LANES).zip(flat.groups()).zip(camera.groups());
            for (((emitters, flat), camera), found) in groups.zip(to_emitters.groups_mut()) {
                formulas::connect_to_emitters(simd, how, camera, emitters, flat, found);
            }
        });
    }

    /// Evaluates the connections of two complete subpaths, and those of the light subpath to the
    /// lens, as far as lanes can.
    #[inline]
    pub fn connect_subpaths<S: Scene + ?Sized>(
        &mut self,
        level: Level,
        Plan { stage, techniques, .. }: &Plan<'s, S>,
        weighting: &Weighting,
        Subpaths { camera, light, camera_ends, .. }: &Subpaths<'s, S>,
    ) {
        let Some(emitter) = light.first().and_then(|start| start.light) else { return };
        let Some(center) = center(stage, weighting).filter(|_| !camera.is_empty()) else { return };
        let emitter = stage.scene.light(emitter);
        // Lanes know of no media.
        let flat = emitter.as_flat().filter(|_| light[0].point.medium == 0);
        let mut has_surface = false;
        self.light.clear();
        for s in 1..=light.len() {
            let side = || weighting.light_side_of(&light[..s], emitter);
            let vertex = &light[s - 1];
            let lambert = if s > 1 { end::lambert(vertex) } else { None };
            has_surface |= lambert.is_some();
            let (vectors, rest) = match s {
                1 => end::of_start(vertex, flat, side),
                _ => end::of_surface(vertex, lambert, side),
            };
            self.light.push(vectors, rest);
        }
        let has_ends = has_surface || flat.is_some();
        let pinhole = stage.camera.as_pinhole().filter(|_| techniques.lens_sampling && has_ends);
        let camera = Some(camera_ends).filter(|_| techniques.connections && has_surface);
        if pinhole.is_some() || camera.is_some() {
            self.connect(level, (weighting, center), camera, pinhole);
        }
    }

    #[inline(never)]
    fn connect(
        &mut self,
        level: Level,
        how: (&Weighting, DVec3),
        camera: Option<&Rows<END>>,
        pinhole: Option<&View>,
    ) {
        let Self { light, to_lens, inner, width, .. } = self;
        let ends = camera.map_or(0, Rows::len);
        // So few that two vertices of the light subpath share the lanes.
        let is_narrow = ends <= LANES / 2;
        *width = if is_narrow { LANES / 2 } else { ends.next_multiple_of(LANES) };
        let surfaces = if ends > 0 { light.len() - 1 } else { 0 };
        inner.resize((surfaces * *width).div_ceil(LANES), [[UNKNOWN; LANES]; PAIR]);
        if pinhole.is_some() {
            to_lens.resize(light.len());
        }
        let camera = camera.map_or(&[][..], Rows::groups);
        dispatch!(level, simd => {
            if let Some(view) = pinhole {
                for (light, found) in light.groups().iter().zip(to_lens.groups_mut()) {
                    formulas::connect_to_pinhole(simd, how, view, light, found);
                }
            }
            let groups = inner.chunks_mut(camera.len().max(1));
            for (found, s) in groups.zip((1..).step_by(if is_narrow { 2 } else { 1 })) {
                let z = if is_narrow {
                    let other = (s + 1).min(light.len() - 1);
                    splat_halves(simd, [&light.get(s), &light.get(other)])
                } else {
                    splat(simd, &light.get(s))
                };
                let z = End::new(z);
                for (camera, found) in camera.iter().zip(found) {
                    formulas::connect_pairs(simd, how, camera, &z, found);
                }
            }
        });
    }

    /// The connection of a technique, if it was evaluated.
    #[inline(always)]
    pub fn get(&self, Technique { s, t, .. }: Technique) -> Option<Pair> {
        match (usize::from(s), usize::from(t)) {
            (0, _) => None,
            (s, 1) => pair(self.to_lens.groups(), s - 1),
            (1, t) => pair(self.to_emitters.groups(), t - 2),
            (s, t) => pair(&self.inner, (s - 2) * self.width + t - 2),
        }
    }

    /// The place on the film of the lens connection of a light subpath with s vertices that was
    /// evaluated.
    #[inline]
    pub fn raster(&self, s: u16) -> DVec2 {
        let [.., x, y] = self.to_lens.get(usize::from(s) - 1);
        DVec2::new(x, y)
    }

    /// The point that a camera subpath with t vertices connects to, as a vertex.
    #[inline(always)]
    pub fn emitter<S: Scene + ?Sized>(
        &self,
        stage: &Stage<'s, S>,
        t: u16,
    ) -> Option<Vertex<S::Bsdf<'s>>> {
        let i = usize::from(t) - 2;
        let (light, flat) = match self.emitters.get(i)? {
            Emitter::None => return None,
            Emitter::Sampled(k) => return Some(self.sampled[*k].vertex(stage)),
            Emitter::Flat(light, flat) => (*light, flat),
        };
        let [.., x, y, z, error, u, v] = self.to_emitters.get(i);
        let point = flat.point(DVec3::new(x, y, z), error, DVec2::new(u, v));
        let [_, _, connection, walk, ..] = self.flat.get(i);
        let start = StartDensity { walk: PerArea(walk), connection: PerArea(connection) };
        Some(Vertex {
            throughput: Rgb::splat(1.0 / connection),
            ..Vertex::endpoint(point, Some(light), start)
        })
    }
}

/// A connection, if it was evaluated.
#[inline(always)]
fn pair<const N: usize>(groups: &[Group<N>], i: usize) -> Option<Pair> {
    let group = groups.get(i / LANES)?;
    let number = |row: usize| group[row][i % LANES];
    let vector = |row: usize| DVec3::new(number(row), number(row + 1), number(row + 2));
    let state = number(8);
    if state == UNKNOWN {
        return None;
    }
    let primitive = |row| number(row).to_bits() as u32;
    let ends = Ends { origin: primitive(16), end: primitive(17) };
    Some(Pair {
        edge: Edge { direction: vector(0), geometry: number(3) },
        value: if state == BLACK { Rgb::BLACK } else { Rgb(vector(4).to_array()) },
        weight: number(7),
        segment: Segment { origin: vector(9), direction: vector(12), length: number(15), ends },
    })
}

/// The centre of the scene, which shadow rays in lanes refer to, if anything goes in lanes.
#[inline]
fn center<S: Scene + ?Sized>(stage: &Stage<'_, S>, weighting: &Weighting) -> Option<DVec3> {
    let flats = stage.scene.flat_surfaces();
    weighting.has_lanes().then(|| flats.map_or(DVec3::ZERO, |flats| flats.forest().center()))
}
