//! Path tracing: a walk from the camera that collects light where it hits an emitter (s = 0) and
//! where it connects to a point sampled on one (s = 1).
//!
//! ```text
//! s = 0:  T_k Le                                    w = 1 / (1 + (p_connect / (p⊥ G))^β)
//! s = 1:  T_{k-1} f G V Le / p_connect              w = 1 / (1 + (p⊥ G / p_connect)^β)
//! ```
//!
//! with the walk's throughput T = Π f/p⊥ (Kajiya 1986; Veach 1997, section 10.2 for the weights).

use super::any_run::on_world;
use super::{Crew, Depth, Integrator, Regularization, SingleWalk, Stage, StartOnWorld, Started};
use crate::path::{Begin, DiffuseSteps, Heuristic, Plan, Roulette, Steps, TechniqueSet, Visit};
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::ops::ControlFlow;

/// The techniques of a path tracer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PathTracing {
    /// Both, with weights: sees everything but Dirac lights through Dirac lobes.
    #[default]
    Both,
    /// s = 0 alone: no light is sampled. Cannot see Dirac lights.
    EmissionOnly,
    /// s = 1 alone. Cannot see lights directly or through Dirac lobes.
    NextEventOnly,
}

/// Path tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathTracer {
    /// The techniques to run.
    pub mode: PathTracing,
    /// The path lengths that count.
    pub depth: Depth,
    /// Termination.
    pub roulette: Roulette,
    /// The weights of the two techniques.
    pub heuristic: Heuristic,
}

impl PathTracer {
    /// Path tracing with both techniques up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    pub(super) fn techniques(&self) -> TechniqueSet {
        let bsdf_sampling = self.mode != PathTracing::NextEventOnly;
        let next_event = self.mode != PathTracing::EmissionOnly;
        TechniqueSet { bsdf_sampling, next_event, ..TechniqueSet::NONE }
    }

    pub(super) fn run<S: Scene + ?Sized>(self, stage: Stage<'_, S>) -> SingleWalk<'_, S, Self> {
        SingleWalk::new(stage, self, self.techniques(), self.depth)
    }
}

impl<S: Scene + ?Sized> Integrator<S> for PathTracer {
    type Run<'a>
        = SingleWalk<'a, S, Self>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::path_tracer);
    const REGULARIZED_ON_WORLD: Option<StartOnWorld<Regularization<Self>>> =
        Some(on_world::regularized_path_tracer);

    fn name(&self) -> &'static str {
        "path-tracing"
    }

    fn chooses_lights(&self) -> bool {
        self.mode != PathTracing::EmissionOnly
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Self::Run<'a>> {
        Ok(self.run(stage))
    }
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for PathTracer {
    const CONNECTS: bool = true;

    #[inline(always)]
    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        self.hit(visit);
        visit.limit(visit.plan.depth.limit())
    }

    #[inline(always)]
    fn connect<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        self.connect_to_light(visit);
    }

    #[inline(always)]
    fn leave<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.limit(last_scattered(visit.plan))
    }

    #[inline(always)]
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        let scattered = visit.scatter(&self.roulette);
        if !scattered.constant.is_black() {
            visit.out.add(&visit.contribution(0, scattered.constant, 1.0));
        }
        scattered.flow()
    }

    fn at_diffuse(&self, plan: &Plan<'a, S>) -> Option<DiffuseSteps> {
        Some(DiffuseSteps {
            heuristic: self.heuristic,
            roulette: self.roulette,
            last_connected: plan.depth.limit(),
            last_scattered: last_scattered(plan),
            begin: Begin::AtCamera,
            ..DiffuseSteps::default()
        })
    }
}

/// The number of scattering events after which a walk goes no further: a vertex behind the last
/// connection could only count by being hit.
fn last_scattered<S: Scene + ?Sized>(Plan { techniques, depth, .. }: &Plan<'_, S>) -> u32 {
    depth.limit().saturating_sub(u32::from(!techniques.bsdf_sampling))
}

impl PathTracer {
    // ANCHOR: steps
    /// Adds what the vertex emits (s = 0).
    #[inline(always)]
    pub(super) fn hit<S: Scene + ?Sized, P>(&self, visit: &mut Visit<'_, '_, S, P>) {
        let Some((value, connect)) = visit.emitted_beside_connection() else { return };
        let hit = visit.walk.pdf().value() * visit.vertex.geometry;
        let weight = connect.map_or(1.0, |p| self.heuristic.weight([p.value() / hit]));
        visit.out.add(&visit.contribution(0, value, weight));
    }

    /// Adds the light of the point sampled on a light, if the vertex sees it (s = 1, next event
    /// estimation).
    #[inline(always)]
    pub(super) fn connect_to_light<S: Scene + ?Sized, P>(&self, visit: &mut Visit<'_, '_, S, P>) {
        let Some(next) = visit.next_event() else { return };
        let hit = next.pdf_of_hit.value();
        visit.connect(&next, self.heuristic.weight([hit / next.pdf.value()]));
    }
    // ANCHOR_END: steps
}
