//! Walks from one flat diffuse surface to the next, in columns: each number of all walks side by
//! side, so that eight of them go through a vertex in lanes.
//!
//! A walk comes in where a ray has met such a surface, and leaves, to be gone on with one by one,
//! where it meets anything else. What the vertices of columns have in common is that they emit
//! nothing and scatter by Lambert's law, so that steps which do the same at all such vertices
//! ([`DiffuseSteps`]) need not be asked at each.

mod lanes;

use self::lanes::{
    ABSORBED, Carried, Directions, IS_FORWARD, LensConnections, LightConnections, Met, NOT_FINITE,
    Points, STATE,
};
use super::connect::{emitter_at, lens_connection_at, next_event_at};
use super::diffuse::{BLACK, INEXACT, LIT, UNSEEN};
use super::shadow_rays::Connections;
use super::{
    Counters, Heuristic, MAX_BOUNCES, Out, Plan, RandomWalk, Roulette, SampledEndpoint, Stage,
    StartDensity, Vertex,
};
use crate::bsdf::TransportMode;
use crate::bsdf::shading::ShadedBsdf;
use crate::endpoint::{FlatLight, Light, LightId, View};
use crate::film::{Contribution, Sample, Sink, Technique};
use crate::geometry::SurfacePoint;
use crate::lanes::Rows;
use crate::math::{PerArea, PerProjected, Rgb};
use crate::sampler::{Sampler, Stream};
use crate::scene::{DIFFUSE, Diffuse, FlatHit, FlatSurfaces, Meeting, Scene};
use crate::tree::Ends;
use fearless_simd::{Level, dispatch};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// The steps of a walk at flat diffuse vertices that emit nothing, if they are these: the vertex is
/// connected to a point on a light or on the lens, as the [`Plan`] has it, and the walk goes on.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseSteps {
    /// The weights of connections to lights, of which hits are the only other technique.
    pub heuristic: Heuristic,
    /// Termination.
    pub roulette: Roulette,
    /// The number of scattering events with which a walk ends before its vertex is connected.
    pub last_connected: u32,
    /// The number with which it ends after that.
    pub last_scattered: u32,
    /// The number with which it ends on leaving.
    pub last_left: u32,
    /// The beginning of walks.
    pub begin: Begin,
}

/// The beginning of walks that advance in columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// As [`Steps::begin`](super::Steps::begin) has it.
    Shown,
    /// At the camera, where nothing is done.
    AtCamera,
    /// At a light, which is connected to the lens.
    AtLight {
        /// True if it is of use to go on from there.
        goes_on: bool,
    },
}

impl Default for DiffuseSteps {
    /// The default weights and roulette, and no limits.
    fn default() -> Self {
        Self {
            heuristic: Heuristic::default(),
            roulette: Roulette::default(),
            last_connected: u32::MAX,
            last_scattered: u32::MAX,
            last_left: u32::MAX,
            begin: Begin::Shown,
        }
    }
}

/// A walk: the sample that it belongs to, and the vertex where it has been last.
#[derive(Clone, Copy, Debug)]
struct Walk {
    sample: u32,
    at: FlatHit,
}

/// The place of a walk that begins at the camera.
const NOWHERE: FlatHit = FlatHit { primitive: SurfacePoint::NONE, u: 0.0, v: 0.0 };

/// A connection to a point on a light, which two random numbers choose.
#[derive(Clone, Copy, Debug)]
struct LightPoint<'s> {
    id: LightId,
    light: &'s FlatLight,
    /// The density of the point.
    pdf: PerArea,
    u: DVec2,
}

/// Walks between flat diffuse surfaces. All are of one mode and have scattered equally often.
#[derive(Debug, Default)]
pub(super) struct Columns<'s> {
    mode: Option<TransportMode>,
    bounces: u32,
    under_way: UnderWay,
    walks: Vec<Walk>,
    met: Met,
    carried: Carried,
    points: Points,
    lights: Vec<Option<LightPoint<'s>>>,
    light_numbers: Rows<3>,
    to_lights: LightConnections,
    to_lens: LensConnections,
    numbers: Rows<2>,
    from_lens: Rows<4>,
    emission: Rows<4>,
    from_light: Rows<9>,
    directions: Directions,
    shadow_rays: ShadowRays,
    shadow_ends: Vec<Ends>,
    free: Vec<bool>,
}

/// Walks that have left a vertex.
#[derive(Debug, Default)]
struct UnderWay {
    walks: Vec<Walk>,
    /// Origin, direction.
    rays: Rows<6>,
    ends: Vec<Ends>,
    /// Throughput, reference of roulette, survival.
    carried: Rows<5>,
}

/// Shadow rays to the lens, and what they carry.
#[derive(Debug, Default)]
struct ShadowRays {
    /// Origin, direction, length.
    segments: Rows<7>,
    ends: Vec<Ends>,
    carried: Vec<(u32, Contribution)>,
}

/// What walks in columns share with those that are gone on with one by one.
pub(super) struct Shared<'b, 's, S: Scene + ?Sized + 's, P> {
    pub plan: &'b Plan<'s, S>,
    pub flats: FlatSurfaces<'s>,
    pub steps: DiffuseSteps,
    pub samples: &'b mut [Sample<P>],
    pub sink: &'b mut dyn Sink,
    pub connections: &'b mut Connections,
    pub counters: &'b mut Counters,
    pub level: Level,
}

impl<'s> Columns<'s> {
    /// True if no walk is under way.
    pub fn is_empty(&self) -> bool {
        self.under_way.walks.is_empty()
    }

    /// Begins the walks of all samples, if they begin as columns can.
    pub fn begin<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        shared: &mut Shared<'_, 's, S, P>,
    ) -> bool {
        let stage = &shared.plan.stage;
        let Some(view) = stage.camera.as_pinhole() else { return false };
        self.bounces = 0;
        match shared.steps.begin {
            Begin::Shown => return false,
            Begin::AtCamera => self.begin_at_camera(view, shared.level, shared.samples),
            Begin::AtLight { .. } if !shared.plan.techniques.lens_sampling => {}
            Begin::AtLight { goes_on } => {
                let Some(id) = stage.only_light() else { return false };
                let Some(light) = stage.scene.light(id).as_flat() else { return false };
                self.begin_at_light((id, light), goes_on, shared);
            }
        }
        true
    }

    fn begin_at_camera<P: Sampler>(
        &mut self,
        view: &View,
        level: Level,
        samples: &mut [Sample<P>],
    ) {
        self.mode = Some(TransportMode::Radiance);
        self.numbers.clear();
        for Sample { film, sampler } in samples.iter_mut() {
            sampler.stream(Stream::Lens);
            sampler.skip_1d();
            sampler.skip_2d();
            self.numbers.push_row(view.film.to_window(film.raster + film.offset).to_array());
        }
        self.from_lens.resize(samples.len());
        begin(level, self, view);
        for sample in 0..samples.len() {
            let [x, y, z, state] = self.from_lens.get(sample);
            if state != BLACK {
                let walk = Walk { sample: sample as u32, at: NOWHERE };
                self.under_way.push(
                    walk,
                    [view.position.x, view.position.y, view.position.z, x, y, z],
                    [1.0; 5],
                );
            }
        }
    }

    fn begin_at_light<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        (id, light): (LightId, &FlatLight),
        goes_on: bool,
        shared: &mut Shared<'_, 's, S, P>,
    ) {
        let Shared { plan: Plan { depth, .. }, level, samples, counters, .. } = shared;
        self.mode = Some(TransportMode::Importance);
        self.emission.clear();
        for Sample { sampler, .. } in samples.iter_mut() {
            sampler.stream(Stream::Emission);
            // There is no choice of a light, nor of a shape of it.
            sampler.skip_1d();
            sampler.skip_1d();
            let (u, v) = (sampler.next_2d(), sampler.next_2d());
            self.emission.push_row([u.x, u.y, v.x, v.y]);
        }
        counters.light_subpaths += samples.len() as u64;
        self.points.resize(samples.len());
        self.from_light.resize(samples.len());
        emit(*level, self, light);
        let start = Rgb::splat(1.0 / light.pdf.value());
        for sample in 0..samples.len() {
            let [.., u, v, _] = self.from_light.get(sample);
            let at = FlatHit { primitive: light.primitive, u, v };
            self.walks.push(Walk { sample: sample as u32, at });
            self.carried.push([DVec3::ZERO, DVec3::from_array(start.0)], [0.0; 2]);
        }
        if depth.contains(0) {
            self.connect_to_lens(Some(id), shared);
        }
        let throughput = light.radiance / FRAC_1_PI * start;
        let [red, green, blue] = throughput.0;
        let carried = [red, green, blue, throughput.max_component(), 1.0];
        for (k, walk) in self.walks.iter().enumerate() {
            let [ray @ .., _, _, leaves] = self.from_light.get(k);
            if leaves == 0.0 {
                continue;
            }
            shared.counters.ledger.emitted += throughput;
            if goes_on {
                self.under_way.push(*walk, ray, carried);
            } else {
                shared.counters.truncate(TransportMode::Importance, throughput);
            }
        }
        self.forget_vertices();
    }

    /// Takes over a walk that has met a flat diffuse surface. Returns true if it has.
    #[inline(always)]
    pub fn accept<S: Scene + ?Sized>(
        &mut self,
        flats: &FlatSurfaces<'_>,
        sample: usize,
        walk: &RandomWalk<'s, S>,
        point: &SurfacePoint,
    ) -> bool {
        let Some((at, surface)) = flats.diffuse_at(point) else { return false };
        (self.mode, self.bounces) = (Some(walk.mode()), walk.bounces());
        let (_, direction) = walk.ray();
        self.enter(Walk { sample: sample as u32, at }, surface, direction, walk.carried());
        true
    }

    #[inline(always)]
    fn enter(&mut self, walk: Walk, surface: Diffuse<'_>, direction: DVec3, carried: [f64; 5]) {
        let mut met = [0.0; DIFFUSE + 2];
        met[..DIFFUSE].copy_from_slice(&surface.numbers());
        (met[DIFFUSE], met[DIFFUSE + 1]) = (walk.at.u, walk.at.v);
        self.walks.push(walk);
        self.met.push_row(met);
        self.carried.push([-direction], carried);
    }

    /// Traces the rays under way. Walks that have not met a flat diffuse surface leave, with the
    /// point that they have met, if any.
    pub fn trace<S: Scene + ?Sized>(
        &mut self,
        &Stage { scene, camera, .. }: &Stage<'s, S>,
        flats: &FlatSurfaces<'_>,
        counters: &mut Counters,
        mut leave: impl FnMut(u32, RandomWalk<'s, S>, Option<SurfacePoint>) -> bool,
    ) {
        let Some(mode) = self.mode else { return };
        let mut under_way = std::mem::take(&mut self.under_way);
        let UnderWay { walks, rays, ends, carried } = &mut under_way;
        counters.closest_rays += walks.len() as u64;
        flats.meet(rays, ends, |i, met| {
            let (walk, carried) = (walks[i], carried.get(i));
            let [.., x, y, z] = rays.get(i);
            let direction = DVec3::new(x, y, z);
            let point = match met {
                Meeting::Diffuse(at, surface) => {
                    return self.enter(Walk { at, ..walk }, surface, direction, carried);
                }
                Meeting::Other(point) => Some(point),
                Meeting::Nothing => None,
            };
            let [red, green, blue, ..] = carried;
            let throughput = Rgb::new(red, green, blue);
            if point.is_none() && scene.environment().is_none() {
                return counters.escape(mode, throughput);
            }
            let (from, pdf) = match (flats.point(walk.at), camera.as_pinhole()) {
                (Some(from), _) => (from, PerProjected(FRAC_1_PI)),
                (None, Some(view)) => {
                    let lens = SurfacePoint::dirac(view.position);
                    (lens, camera.direction_pdf(&lens, direction))
                }
                (None, None) => return,
            };
            let ray = (from, direction, pdf);
            let next = RandomWalk::under_way(scene, mode, ray, carried, self.bounces);
            if !leave(walk.sample, next, point) {
                counters.escape(mode, throughput);
            }
        });
        walks.clear();
        rays.clear();
        ends.clear();
        carried.clear();
        self.under_way = under_way;
    }

    /// Connects the vertices and tests the shadow rays; then lets the walks go on.
    pub fn visit<S: Scene + ?Sized, P: Sampler>(&mut self, shared: &mut Shared<'_, 's, S, P>) {
        self.connect(shared);
        self.leave(&shared.steps, shared.samples, shared.counters);
    }

    /// Connects the vertices, and samples the directions of walks that go on.
    fn connect<S: Scene + ?Sized, P: Sampler>(&mut self, shared: &mut Shared<'_, 's, S, P>) {
        let (Some(mode), false) = (self.mode, self.walks.is_empty()) else { return };
        if self.bounces >= shared.steps.last_connected {
            return self.truncate(mode, shared.counters);
        }
        let (level, Plan { techniques, depth, .. }) = (shared.level, shared.plan);
        self.points.resize(self.walks.len());
        place(level, self);
        if depth.contains(self.bounces + 1) {
            match mode {
                TransportMode::Radiance if techniques.next_event => self.connect_to_lights(shared),
                TransportMode::Importance if techniques.lens_sampling => {
                    self.connect_to_lens(None, shared);
                }
                _ => {}
            }
        }
        if self.bounces >= shared.steps.last_scattered.min(MAX_BOUNCES) {
            return self.truncate(mode, shared.counters);
        }
        self.numbers.clear();
        for walk in &self.walks {
            let sampler = &mut shared.samples[walk.sample as usize].sampler;
            sampler.stream(match mode {
                TransportMode::Radiance => Stream::CameraVertex(self.bounces + 1),
                TransportMode::Importance => Stream::LightVertex(self.bounces + 1),
            });
            let (_, u) = sampler.next_1d_2d();
            self.numbers.push_row(u.to_array());
        }
        shared.counters.scattered += self.walks.len() as u64;
        self.directions.resize(self.walks.len());
        scatter(level, self);
    }

    fn connect_to_lights<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        shared: &mut Shared<'_, 's, S, P>,
    ) {
        self.lights.clear();
        self.light_numbers.clear();
        self.shadow_ends.clear();
        let only = shared.plan.stage.only_light();
        for k in 0..self.walks.len() {
            let light = self.sample_light(k, only, shared);
            let (u, pdf) = light.map_or((DVec2::ZERO, 1.0), |light| (light.u, light.pdf.value()));
            self.light_numbers.push_row([u.x, u.y, pdf]);
            self.lights.push(light);
        }
        self.to_lights.resize(self.walks.len());
        let has_hits = shared.plan.techniques.bsdf_sampling;
        let how = (shared.steps.heuristic, has_hits, shared.flats.forest().center());
        connect_to_lights(shared.level, self, how);
        for k in 0..self.walks.len() {
            let Some(light) = &self.lights[k] else {
                self.shadow_ends.push(Ends::FREE);
                continue;
            };
            let (state, at) = (self.to_lights.number(k, STATE), self.walks[k].at);
            let (origin, end) = match self.to_lights.number(k, IS_FORWARD) {
                0.0 => (light.light.primitive, at.primitive),
                _ => (at.primitive, light.light.primitive),
            };
            self.shadow_ends.push(Ends { origin, end });
            if state == INEXACT {
                let LightPoint { id, light, pdf, u } = *light;
                let emitter = SampledEndpoint { point: light.point_at(u), light: Some(id), pdf };
                self.connect_alone(k, &emitter, shared);
                continue;
            }
            shared.counters.connections += 1;
            shared.counters.shadow_rays += u64::from(state == LIT);
        }
        let (segments, ends, free) = (&self.to_lights, &self.shadow_ends, &mut self.free);
        shared.flats.forest().are_free_in_columns(segments, ends, free);
        let technique = Technique::new(1, self.bounces as u16 + 2);
        for (k, _) in self.free.iter().enumerate().filter(|(_, free)| **free) {
            let [.., red, green, blue, weight, state] = self.to_lights.get(k);
            if state == LIT && self.lights[k].is_some() {
                let sample = self.walks[k].sample as usize;
                let raster = shared.samples[sample].film.raster;
                let value = Rgb::new(red, green, blue);
                shared.sink.add(sample, &Contribution { raster, value, weight, technique });
            }
        }
    }

    /// Samples a point on a light for a vertex, and connects it to that if lanes cannot.
    #[inline(always)]
    fn sample_light<S: Scene + ?Sized, P: Sampler>(
        &self,
        k: usize,
        only: Option<LightId>,
        shared: &mut Shared<'_, 's, S, P>,
    ) -> Option<LightPoint<'s>> {
        let sampler = &mut shared.samples[self.walks[k].sample as usize].sampler;
        sampler.stream(Stream::NextEvent(self.bounces + 1));
        let (u0, (u1, u)) = (sampler.next_1d(), sampler.next_1d_2d());
        let [x, y, z, error, nx, ny, nz, ..] = self.points.get(k);
        let position = DVec3::new(x, y, z);
        let receiver = || SurfacePoint {
            primitive: self.walks[k].at.primitive,
            ..SurfacePoint::on_surface(position, error, DVec3::new(nx, ny, nz))
        };
        let stage = &shared.plan.stage;
        let (id, pmf) = match only {
            Some(id) => (id, 1.0),
            None => stage.pick_light_for(&receiver(), u0)?,
        };
        if let Some(light) = stage.scene.light(id).as_flat()
            && !light.is_near(position)
        {
            return Some(LightPoint { id, light, pdf: light.pdf * pmf, u });
        }
        if let Some(emitter) = emitter_at(stage, &receiver(), (id, pmf), u1, u) {
            self.connect_alone(k, &emitter, shared);
        }
        None
    }

    /// The vertex of a walk, as it is where walks are gone on with one by one.
    fn vertex<S: Scene + ?Sized>(
        &self,
        k: usize,
        scene: &'s S,
        flats: &FlatSurfaces<'_>,
    ) -> Option<Vertex<S::Bsdf<'s>>> {
        let point = flats.point(self.walks[k].at)?;
        let [x, y, z, red, green, blue, ..] = self.carried.get(k);
        Some(Vertex {
            bsdf: Some(ShadedBsdf::new(scene.bsdf(&point), &point)),
            throughput: Rgb::new(red, green, blue),
            to_previous: DVec3::new(x, y, z),
            ..Vertex::endpoint(point, None, StartDensity::default())
        })
    }

    /// Connects a vertex to a point on a light without lanes.
    #[inline(never)]
    fn connect_alone<S: Scene + ?Sized, P>(
        &self,
        k: usize,
        emitter: &SampledEndpoint,
        Shared { plan, flats, steps, samples, sink, connections, counters, .. }: &mut Shared<
            '_,
            's,
            S,
            P,
        >,
    ) {
        let Some(vertex) = self.vertex(k, plan.stage.scene, flats) else { return };
        let sample = self.walks[k].sample as usize;
        let mut out = Out { sample, sink: &mut **sink, connections };
        let Some(next) = next_event_at(plan, &vertex, emitter, &mut out, counters) else { return };
        counters.shadow_rays += 1;
        let hit = next.pdf_of_hit.value();
        let contribution = Contribution {
            raster: samples[sample].film.raster,
            value: next.value,
            weight: steps.heuristic.weight([hit / next.pdf.value()]),
            technique: Technique::new(1, self.bounces as u16 + 2),
        };
        let end = out.keep(&vertex.point);
        out.connect([end, next.end], contribution);
    }

    /// Connects the vertices to the pinhole; they are the starts of walks at a light if one is given.
    fn connect_to_lens<S: Scene + ?Sized, P: Sampler>(
        &mut self,
        start: Option<LightId>,
        shared: &mut Shared<'_, 's, S, P>,
    ) {
        let bounces = self.bounces + u32::from(start.is_none());
        let stage = &shared.plan.stage;
        let Some(view) = stage.camera.as_pinhole() else { return };
        self.to_lens.resize(self.walks.len());
        let center = shared.flats.forest().center();
        connect_to_pinhole(shared.level, self, (view, center, start.is_some()));
        let mut inexact = Vec::new();
        let ShadowRays { segments, ends, carried } = &mut self.shadow_rays;
        for (k, Walk { sample, at }) in self.walks.iter().enumerate() {
            let Sample { film, sampler } = &mut shared.samples[*sample as usize];
            sampler.stream(Stream::LensSampling(bounces));
            sampler.skip_1d();
            sampler.skip_2d();
            let [segment @ .., is_forward, red, green, blue, x, y, state] = self.to_lens.get(k);
            if state == INEXACT {
                inexact.push(k);
                continue;
            }
            if state == UNSEEN {
                continue;
            }
            let raster = DVec2::new(x, y) - film.offset;
            if stage.film.pixel_index(raster).is_none() {
                continue;
            }
            shared.counters.connections += 1;
            if state == LIT {
                let value = Rgb::new(red, green, blue);
                let technique = Technique::new(bounces as u16 + 1, 1);
                segments.push_row(segment);
                let (origin, end) = match is_forward {
                    0.0 => (SurfacePoint::NONE, at.primitive),
                    _ => (at.primitive, SurfacePoint::NONE),
                };
                ends.push(Ends { origin, end });
                carried.push((*sample, Contribution { raster, value, weight: 1.0, technique }));
            }
        }
        shared.counters.shadow_rays += ends.len() as u64;
        shared.flats.forest().are_free_in_columns(segments, ends, &mut self.free);
        let seen = carried.iter().zip(&self.free).filter(|(_, free)| **free);
        for ((sample, contribution), _) in seen {
            shared.sink.add(*sample as usize, contribution);
        }
        segments.clear();
        ends.clear();
        carried.clear();
        inexact.into_iter().for_each(|k| self.connect_to_lens_alone(k, start, view, shared));
    }

    /// Connects a vertex to the pinhole without lanes.
    #[inline(never)]
    fn connect_to_lens_alone<S: Scene + ?Sized, P>(
        &self,
        k: usize,
        start: Option<LightId>,
        view: &View,
        shared: &mut Shared<'_, 's, S, P>,
    ) {
        let Shared { plan: Plan { stage, .. }, flats, samples, sink, counters, .. } = shared;
        let Some(mut vertex) = self.vertex(k, stage.scene, flats) else { return };
        if start.is_some() {
            (vertex.bsdf, vertex.light) = (None, start);
        }
        let sample = self.walks[k].sample as usize;
        let mut out = Out { sample, sink: &mut **sink, connections: shared.connections };
        let point = SurfacePoint::dirac(view.position);
        let lens = SampledEndpoint { point, light: None, pdf: PerArea(1.0) };
        let (end, film) = (out.keep(&vertex.point), &samples[sample].film);
        let bounces = self.bounces + u32::from(start.is_none());
        let from = (&vertex, Some(end));
        let found = lens_connection_at(stage, from, bounces, film, &lens, &mut out, counters);
        if let Some(found) = found {
            out.connect(found.ends, found.contribution);
        }
    }

    /// Follows the walks into their directions, with roulette.
    fn leave<P: Sampler>(
        &mut self,
        steps: &DiffuseSteps,
        samples: &mut [Sample<P>],
        counters: &mut Counters,
    ) {
        let Some(mode) = self.mode else { return };
        self.bounces += 1;
        for (k, walk) in self.walks.iter().enumerate() {
            let [ray @ .., red, green, blue, relative, state] = self.directions.get(k);
            let mut throughput = Rgb::new(red, green, blue);
            let [_, _, _, red, green, blue, reference, survival] = self.carried.get(k);
            let before = Rgb::new(red, green, blue);
            if mode == TransportMode::Importance {
                match state {
                    ABSORBED => counters.ledger.absorbed += before,
                    NOT_FINITE => counters.ledger.rejected += before,
                    _ => counters.ledger.absorbed += before - throughput,
                }
            }
            if state == NOT_FINITE {
                counters.non_finite += 1;
            }
            if state == ABSORBED || state == NOT_FINITE {
                continue;
            }
            let xi = || samples[walk.sample as usize].sampler.next_1d();
            let scattered = steps.roulette.play(mode, self.bounces, relative, &mut throughput, xi);
            if !scattered.goes_on {
                continue;
            }
            if self.bounces >= steps.last_left {
                counters.truncate(mode, throughput);
                continue;
            }
            let [red, green, blue] = throughput.0;
            let carried = [red, green, blue, reference, survival * scattered.survival];
            self.under_way.push(*walk, ray, carried);
        }
        self.forget_vertices();
    }

    /// Ends all walks at their vertices by a limit.
    fn truncate(&mut self, mode: TransportMode, counters: &mut Counters) {
        for k in 0..self.walks.len() {
            let [_, _, _, red, green, blue, ..] = self.carried.get(k);
            counters.truncate(mode, Rgb::new(red, green, blue));
        }
        self.forget_vertices();
    }

    fn forget_vertices(&mut self) {
        self.walks.clear();
        self.met.clear();
        self.carried.clear();
    }
}

impl UnderWay {
    #[inline(always)]
    fn push(&mut self, walk: Walk, ray: [f64; 6], carried: [f64; 5]) {
        self.walks.push(walk);
        self.rays.push_row(ray);
        self.ends.push(Ends { origin: walk.at.primitive, ..Ends::FREE });
        self.carried.push_row(carried);
    }
}

// What is compiled for all instruction sets is not to be compiled for every scene, too.

#[inline(never)]
fn begin(level: Level, Columns { numbers, from_lens, .. }: &mut Columns<'_>, view: &View) {
    dispatch!(level, simd => lanes::begin(simd, view, numbers, from_lens));
}

#[inline(never)]
fn place(level: Level, Columns { met, carried, points, .. }: &mut Columns<'_>) {
    dispatch!(level, simd => lanes::place(simd, met, carried, points));
}

#[inline(never)]
fn connect_to_lights(level: Level, columns: &mut Columns<'_>, how: (Heuristic, bool, DVec3)) {
    let Columns { points, carried, lights, light_numbers, to_lights, .. } = columns;
    let vertices = (&*points, &*carried);
    dispatch!(level, simd => {
        lanes::connect_to_lights(simd, vertices, (lights, light_numbers), how, to_lights)
    });
}

#[inline(never)]
fn connect_to_pinhole(level: Level, columns: &mut Columns<'_>, how: (&View, DVec3, bool)) {
    let Columns { points, carried, to_lens, .. } = columns;
    let vertices = (&*points, &*carried);
    dispatch!(level, simd => lanes::connect_to_pinhole(simd, vertices, how, to_lens));
}

#[inline(never)]
fn emit(level: Level, columns: &mut Columns<'_>, light: &FlatLight) {
    let Columns { emission, points, from_light, .. } = columns;
    dispatch!(level, simd => lanes::emit(simd, light, emission, points, from_light));
}

#[inline(never)]
fn scatter(level: Level, columns: &mut Columns<'_>) {
    let Columns { points, carried, numbers, directions, .. } = columns;
    dispatch!(level, simd => lanes::scatter(simd, (points, carried), numbers, directions));
}
