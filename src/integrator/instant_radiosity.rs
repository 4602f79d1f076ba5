//! Instant radiosity: the vertices of a few light walks are virtual lights for all pixels, to which
//! camera walks connect (Keller 1997). A bound g on the geometry term takes away the bright spots
//! where a virtual light is near; what it cuts off is drawn by going on (Kollig and Keller 2004).
//!
//! ```text
//! connect across edge i:    c_i Π_{j<i} (1 - c_j) · T f G f Φ / N          c = min(1, g / G)
//! reach a light:            Π_j (1 - c_j) · path tracing's estimates
//! ```
//!
//! The weights of a path sum to one, since they depend on its edges alone: c is 0 where an end takes
//! a Dirac lobe, which no connection meets, and 1 at the last edge if only light walks go on.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::any_run::on_world;
use super::shared::VirtualLights;
use super::{
    Crew, Integrator, IntegratorError, Notes, PathTracer, Run, Stage, StartOnWorld, Started,
};
use crate::film::{Sample, Sink};
use crate::path::{Counters, Plan, Scratch, Steps, TechniqueSet, Visit};
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
        Self { path_tracer: PathTracer::default(), light_walks: 64, bound: None, compensates: true }
    }
}

/// A rendering by the virtual lights of passes.
pub struct VirtualLightPasses<'a, S: Scene + ?Sized> {
    plan: Plan<'a, S>,
    path_tracer: PathTracer,
    lights: VirtualLights<'a, S>,
}

const NAME: &str = "instant-radiosity";

impl<S: Scene + ?Sized> Integrator<S> for InstantRadiosity {
    type Run<'a>
        = VirtualLightPasses<'a, S>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::instant_radiosity);

    fn name(&self) -> &'static str {
        NAME
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Self::Run<'a>> {
        let own = self.path_tracer.techniques();
        let techniques = TechniqueSet { connections: self.light_walks > 0, ..own };
        let plan = Plan::new(stage, techniques, self.path_tracer.depth);
        let lights = VirtualLights::new(stage, NAME, self)?;
        Ok(VirtualLightPasses { plan, path_tracer: self.path_tracer, lights })
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for VirtualLightPasses<'a, S> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.plan.techniques
    }

    fn notes(&self) -> Notes {
        self.lights.notes(&self.plan)
    }

    fn prepares(&self) -> bool {
        self.plan.techniques.connections
    }

    fn take_preparation(&mut self) -> Counters {
        std::mem::take(&mut self.lights.counters)
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        self.lights.begin_pass(pass, crew, (&self.plan, &self.path_tracer.roulette))
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        scratch.counters.samples += samples.len() as u64;
        self.lights.advance(&self.plan, self, samples, sink, scratch);
    }
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for VirtualLightPasses<'a, S> {
    const CONNECTS: bool = true;

    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        self.path_tracer.hit(visit);
        visit.limit(self.plan.depth.limit())
    }

    fn samples_point<P>(&self, visit: &Visit<'_, 'a, S, P>) -> bool {
        self.lights.rest(visit) > 0.0
    }

    fn connect<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        let before = visit.walk.weight;
        visit.walk.weight = self.lights.rest(visit);
        if visit.walk.weight > 0.0 {
            self.path_tracer.connect_to_light(visit);
            self.lights.connect(visit);
        }
        visit.walk.weight = before;
    }

    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        let rest = self.lights.rest(visit);
        visit.scatter(&self.path_tracer.roulette.without_constant()).flow()?;
        if !visit.vertex.dirac {
            visit.walk.weight = rest;
        }
        if visit.walk.weight > 0.0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}
