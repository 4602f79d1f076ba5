//! Walks from one flat diffuse surface to the next, in columns: each number of all walks side by
//! side, so that eight of them go through a vertex in lanes.
//!
//! A walk comes in where a ray has met such a surface, and leaves, to be gone on with one by one,
//! where it meets anything else. What the vertices of columns have in common is that they emit
//! nothing and scatter by Lambert's law, so that steps which do the same at all such vertices
//! ([`DiffuseSteps`]) need not be asked at each.

mod begin;
mod lanes;
mod to_lens;
mod to_lights;

pub use begin::Begin;

use self::lanes::{
    ABSORBED, Carried, Directions, LensConnections, LightConnections, Met, NOT_FINITE, Points,
};
use self::to_lens::ShadowRays;
use self::to_lights::LightPoint;
use super::shadow_rays::Connections;
use super::{
    Counters, Heuristic, MAX_BOUNCES, Plan, RandomWalk, Roulette, Stage, StartDensity, Vertex,
};
use crate::bsdf::TransportMode;
use crate::bsdf::shading::ShadedBsdf;
use crate::film::{Sample, Sink};
use crate::geometry::SurfacePoint;
use crate::lanes::{Rows, dispatch};
use crate::math::{PerProjected, Rgb};
use crate::sampler::{Sampler, Stream};
use crate::scene::{DIFFUSE, Diffuse, FlatHit, FlatSurfaces, Meeting, Scene};
use crate::tree::Ends;
use fearless_simd::Level;
use glam::DVec3;
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

/// Walks between flat diffuse surfaces. All are of one mode and have scattered equally often.
#[derive(Debug, Default)]
pub(super) struct Columns<'s> {
    mode: Option<TransportMode>,
    bounces: u32,
    under_way: UnderWay,
    /// The walks at vertices, and what they have met and carry.
    walks: Vec<Walk>,
    met: Met,
    carried: Carried,
    points: Points,
    /// The points on lights that vertices are connected to, if lanes can do that: random numbers and
    /// densities, and what comes of them.
    lights: Vec<Option<LightPoint<'s>>>,
    light_numbers: Rows<3>,
    to_lights: LightConnections,
    /// The ends of the shadow rays to lights, and which shadow rays are free.
    shadow_ends: Vec<Ends>,
    free: Vec<bool>,
    to_lens: LensConnections,
    shadow_rays: ShadowRays,
    /// Random numbers of directions, or window coordinates of starts.
    numbers: Rows<2>,
    directions: Directions,
    /// Directions of starts at the camera, and whether there are any.
    from_lens: Rows<4>,
    /// Random numbers of starts at a light; their rays, places and whether there are any.
    emission: Rows<4>,
    from_light: Rows<9>,
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

/// The surroundings that walks in columns share with those that are gone on with one by one.
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
                counters.truncate(mode, throughput, self.bounces);
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
            counters.truncate(mode, Rgb::new(red, green, blue), self.bounces);
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

// Apart, so that what is compiled for all instruction sets is not so for every scene.

#[inline(never)]
fn place(level: Level, Columns { met, carried, points, .. }: &mut Columns<'_>) {
    dispatch!(level, simd => lanes::place(simd, met, carried, points));
}

#[inline(never)]
fn scatter(level: Level, columns: &mut Columns<'_>) {
    let Columns { points, carried, numbers, directions, .. } = columns;
    dispatch!(level, simd => lanes::scatter(simd, (points, carried), numbers, directions));
}
