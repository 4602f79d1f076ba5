//! An integrator of one's own: the light of a single lamp, after one scattering event and up to a
//! few more, by next event estimation at every vertex of a walk from the camera.

use pathspace::endpoint::LightId;
use pathspace::integrator::{Crew, Depth, Integrator, SingleWalk, Stage, Started};
use pathspace::path::{Steps, TechniqueSet, Visit};
use pathspace::sampler::Sampler;
use pathspace::scene::Scene;
use std::ops::ControlFlow;

/// The settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneLight {
    /// The lamp.
    pub light: LightId,
    /// The largest number of scattering events.
    pub max_bounces: u32,
}

impl<S: Scene + ?Sized> Integrator<S> for OneLight {
    type Run<'a>
        = SingleWalk<'a, S, Self>
    where
        S: 'a;

    fn name(&self) -> &'static str {
        "one-light"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Self::Run<'a>> {
        let techniques = TechniqueSet { next_event: true, ..TechniqueSet::NONE };
        Ok(SingleWalk::new(stage, *self, techniques, Depth::up_to(self.max_bounces)))
    }
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for OneLight {
    const CONNECTS: bool = true;

    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.limit(visit.plan.depth.limit())
    }

    fn connect<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        if let Some(next) = visit.next_event().filter(|next| next.light == self.light) {
            visit.connect(&next, 1.0);
        }
    }
}
