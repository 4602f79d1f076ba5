//! Instant radiosity: the vertices of a few light walks are virtual lights for all pixels, to which
//! camera walks connect (Keller 1997). A bound g on the geometry term takes away the bright spots
//! where a virtual light is near; what it cuts off is drawn by going on (Kollig and Keller 2004).
//!
//! ```text
//! connect across edge i:    c_i Π_{j<i} (1 - c_j) · T f G f Φ / N          c = min(1, g / G)
//! reach a light:            Π_j (1 - c_j) · path tracing's estimates
//! ```
//!
//! The weights of a path sum to one whichever technique drew it, since they depend on its edges
//! alone. c is 0 where one of the two ends takes a Dirac lobe, which no connection meets, and 1 at
//! the last edge of a path whose light only light walks reach.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::merging::pixel_footprint;
use super::shared_walks::SharedWalks;
use super::{Crew, Estimator, Integrator, IntegratorError, Notes, PathTracer, Run, Stage, Started};
use crate::endpoint::Light;
use crate::film::{Contribution, Sample, Sink, Technique};
use crate::path::{Counters, Edge, Plan, Scratch, Steps, TechniqueSet, Vertex, Visit, advance};
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::ops::ControlFlow;

/// Instant radiosity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstantRadiosity {
    /// The integrator of what virtual lights do not draw, with the path lengths that count.
    pub path_tracer: PathTracer,
    /// Light walks of a pass.
    pub light_walks: u32,
    /// g, per area, above which geometry terms count as g: 0 leaves all to path tracing, infinity
    /// bounds nothing. `None` for 16 over the area that the camera sees.
    pub bound: Option<f64>,
    /// True if what the bound cuts off is drawn by going on; otherwise it is lost, and summed up in
    /// [`Ledger::clamped`](crate::path::Ledger::clamped).
    pub compensates: bool,
}

impl Default for InstantRadiosity {
    fn default() -> Self {
        let path_tracer = PathTracer::default();
        Self { path_tracer, light_walks: 64, bound: None, compensates: true }
    }
}

/// A rendering by the virtual lights of passes.
pub struct VirtualLights<'a, S: Scene + ?Sized> {
    plan: Plan<'a, S>,
    settings: InstantRadiosity,
    bound: f64,
    lights: Vec<VirtualLight<S::Bsdf<'a>>>,
    counters: Counters,
}

/// A vertex of a light subpath.
struct VirtualLight<B> {
    vertex: Vertex<B>,
    /// Number of vertices of the subpath up to here.
    s: u16,
    /// True if something else than a connection to it can draw a path behind it.
    has_rival: bool,
}

const NAME: &str = "instant-radiosity";

impl<S: Scene + ?Sized> Integrator<S> for InstantRadiosity {
    type Run<'a>
        = VirtualLights<'a, S>
    where
        S: 'a;

    fn name(&self) -> &'static str {
        NAME
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<VirtualLights<'a, S>> {
        let own = self.path_tracer.techniques();
        let techniques = TechniqueSet { connections: self.light_walks > 0, ..own };
        let plan = Plan::new(stage, techniques, self.path_tracer.depth);
        let seen = || Some(pixel_footprint(stage)?.powi(2) * f64::from(stage.film.pixels()));
        let bound = match self.bound {
            Some(bound) if bound >= 0.0 => bound,
            Some(bound) => {
                let reason = format!("the bound is {bound}, but must be 0 or positive");
                return Err(IntegratorError { integrator: NAME, reason });
            }
            None => seen().map_or(f64::INFINITY, |area| 16.0 / area),
        };
        let (lights, counters) = (Vec::new(), Counters::default());
        Ok(VirtualLights { plan, settings: *self, bound, lights, counters })
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for VirtualLights<'a, S> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.plan.techniques
    }

    fn notes(&self) -> Notes {
        let is_exact = self.settings.compensates || !self.learns() || self.bound == f64::INFINITY;
        let estimator = if is_exact { Estimator::Unbiased } else { Estimator::Biased };
        let shared_bytes = size_of_val(self.lights.as_slice()) as u64;
        Notes { left_out: self.plan.left_out, estimator, shared_bytes, ..Notes::default() }
    }

    fn learns(&self) -> bool {
        self.plan.techniques.connections
    }

    fn preparation(&self) -> Counters {
        self.counters
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        let (plan, roulette) = (&self.plan, &self.settings.path_tracer.roulette);
        let walks = SharedWalks { plan, roulette, count: self.settings.light_walks, shortest: 2 };
        let (scene, techniques) = (plan.stage.scene, plan.techniques);
        let (lights, counters) = walks.draw(pass, crew, NAME, |walk, lights| {
            let Some(light) = walk.first().and_then(|start| start.light) else { return };
            let light = scene.light(light);
            // Whether something else draws what is behind a vertex: hits, next event estimation, or
            // virtual lights across an edge between finite lobes.
            let mut is_drawn = techniques.bsdf_sampling && light.can_be_hit();
            let mut is_before_finite = techniques.next_event && light.can_be_connected();
            for (s, vertex) in (1..).zip(walk.drain(..)).skip(1) {
                let (has_rival, is_finite) = (is_drawn || is_before_finite, !vertex.dirac);
                is_drawn |= is_before_finite && is_finite;
                is_before_finite = is_finite;
                if vertex.is_connectible() {
                    lights.push(VirtualLight { vertex, s, has_rival });
                }
            }
        })?;
        self.lights = lights;
        self.counters += counters;
        self.counters.photons += self.lights.len() as u64;
        Ok(())
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        scratch.counters.samples += samples.len() as u64;
        // So many that their shadow rays do not fill the memory.
        let batch = (MOST_CONNECTIONS / self.lights.len().max(1)).max(1);
        for (number, samples) in samples.chunks_mut(batch).enumerate() {
            let sink = &mut |i: usize, found: &Contribution| sink.add(number * batch + i, found);
            advance(&self.plan, self, samples, sink, scratch);
        }
    }
}

/// Connections of samples that are drawn together.
const MOST_CONNECTIONS: usize = 1 << 14;

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for VirtualLights<'a, S> {
    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        self.settings.path_tracer.hit(visit);
        visit.limit(self.plan.depth.limit())?;
        let before = visit.walk.weight;
        visit.walk.weight = self.rest(visit);
        if visit.walk.weight > 0.0 {
            self.settings.path_tracer.connect(visit);
            self.connect_virtual_lights(visit);
        }
        visit.walk.weight = before;
        ControlFlow::Continue(())
    }

    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        let rest = self.rest(visit);
        visit.scatter(&self.settings.path_tracer.roulette.without_constant()).flow()?;
        if !visit.vertex.dirac {
            visit.walk.weight = rest;
        }
        if visit.walk.weight > 0.0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

impl<'a, S: Scene + ?Sized + 'a> VirtualLights<'a, S> {
    /// c of an edge between surfaces that take finite lobes.
    fn share(&self, geometry: f64) -> f64 {
        if geometry > self.bound { self.bound / geometry } else { 1.0 }
    }

    /// The weight of what is drawn by finite lobes of a vertex: that of the walk, less what virtual
    /// lights draw across the edge that led there.
    fn rest<P>(&self, Visit { walk, vertex, .. }: &Visit<'_, 'a, S, P>) -> f64 {
        match walk.is_from_connectible() && self.plan.techniques.connections {
            false => walk.weight,
            true if !self.settings.compensates => 0.0,
            true => walk.weight * (1.0 - self.share(vertex.geometry)),
        }
    }

    fn connect_virtual_lights<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        let (y, scene) = (&*visit.vertex, self.plan.stage.scene);
        let Some(bsdf) = y.bsdf.as_ref().filter(|_| y.is_connectible()) else { return };
        for VirtualLight { vertex: z, s, has_rival } in &self.lights {
            let technique = Technique::new(*s, visit.walk.bounces() as u16 + 2);
            let (Some(edge), Some(light)) = (Edge::between(&y.point, &z.point), &z.bsdf) else {
                continue;
            };
            if !self.plan.depth.contains(technique.bounces().into()) {
                continue;
            }
            visit.counters.connections += 1;
            let f = bsdf.eval(edge.direction, y.to_previous);
            let radiance = light.eval(z.to_previous, -edge.direction) * z.throughput;
            let scale = edge.geometry / f64::from(self.settings.light_walks);
            let value = y.throughput * f * (scale * radiance);
            if value.is_black() {
                continue;
            }
            let is_bounded = *has_rival || !self.settings.compensates;
            let share = if is_bounded { self.share(edge.geometry) } else { 1.0 };
            if !self.settings.compensates && share < 1.0 && scene.visible(&y.point, &z.point) {
                visit.counters.ledger.clamped += value * (visit.walk.weight * (1.0 - share));
            }
            visit.counters.shadow_rays += 1;
            let far = visit.out.keep(&z.point);
            visit.out.connect([visit.end, far], visit.contribution(*s, value, share));
        }
    }
}
