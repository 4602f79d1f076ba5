//! Light tracing: a walk from a light, every vertex of which is connected to the lens (t = 1), the
//! reverse of path tracing.
//!
//! ```text
//! T_s f G V We / p_lens         with T = Le / (p_light p⊥) · Π f/p⊥
//! ```
//!
//! The importance We is normalised over the whole film and recorded where the connection meets it
//! (Dutré and Willems 1994; Veach 1997, section 10.3.4). It sees caustics that path tracing cannot,
//! and nothing that a Dirac lobe shows to the camera.

use super::any_run::on_world;
use super::{Crew, Depth, Integrator, SingleWalk, Stage, StartOnWorld, Started};
use crate::path::{
    Begin, DiffuseSteps, Plan, RandomWalk, Roulette, Site, Steps, TechniqueSet, Visit,
    sample_lens_connection,
};
use crate::sampler::Sampler;
use crate::scene::{Needs, Scene};
use std::ops::ControlFlow;

/// Light tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightTracer {
    /// The path lengths that count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
}

impl LightTracer {
    /// Light tracing up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    pub(super) fn run<S: Scene + ?Sized>(self, stage: Stage<'_, S>) -> SingleWalk<'_, S, Self> {
        let techniques = TechniqueSet { lens_sampling: true, ..TechniqueSet::NONE };
        SingleWalk::new(stage, self, techniques, self.depth)
    }
}

impl<S: Scene + ?Sized> Integrator<S> for LightTracer {
    type Run<'a>
        = SingleWalk<'a, S, Self>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::light_tracer);

    fn name(&self) -> &'static str {
        "light-tracing"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Self::Run<'a>> {
        Ok(self.run(stage))
    }
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for LightTracer {
    const CONNECTS: bool = true;

    #[inline(always)]
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        let Site { plan: Plan { stage, techniques, depth, .. }, sample, out, counters, .. } = site;
        if !techniques.lens_sampling {
            return None;
        }
        let (walk, start) = RandomWalk::from_light(stage, &mut sample.sampler, counters)?;
        let from = (&start, None);
        if depth.contains(0)
            && let Some(found) = sample_lens_connection(stage, from, 0, sample, out, counters)
        {
            out.connect(found.ends, found.contribution);
        }
        walk?.if_useful(goes_on(site.plan), counters)
    }

    #[inline(always)]
    // ANCHOR: steps
    fn connect<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        if let Some(found) = visit.lens_connection() {
            visit.out.connect(found.ends, found.contribution);
        }
    }

    #[inline(always)]
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.scatter(&self.roulette).flow()?;
        visit.limit(visit.plan.depth.limit())
    }
    // ANCHOR_END: steps

    fn at_diffuse(&self, plan: &Plan<'a, S>) -> Option<DiffuseSteps> {
        Some(DiffuseSteps {
            roulette: self.roulette,
            last_left: plan.depth.limit(),
            begin: Begin::AtLight { goes_on: goes_on(plan) },
            ..DiffuseSteps::default()
        })
    }
}

/// False if a walk would be for nothing, without a vertex that could be connected.
fn goes_on<S: Scene + ?Sized>(Plan { stage, depth, .. }: &Plan<'_, S>) -> bool {
    depth.limit() > 0 && stage.needs.contains(Needs::FINITE_LOBES)
}
