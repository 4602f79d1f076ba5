//! An integrator under needs that it is told.

use super::{BoxedRun, Crew, Integrator, Stage, StartOnWorld, Started};
use crate::sampler::AnySampler;
use crate::scene::{Needs, Scene, World};

/// An integrator that renders a scene as if it had certain needs, in place of those that it states.
/// With [`Needs::ALL`] nothing is left out; more is always safe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WithNeeds<I> {
    /// The integrator.
    pub integrator: I,
    /// The needs in place of the scene's own.
    pub needs: Needs,
}

impl<I> WithNeeds<I> {
    /// An integrator that leaves nothing out.
    pub const fn all(integrator: I) -> Self {
        Self { integrator, needs: Needs::ALL }
    }
}

impl<S: Scene + ?Sized, I: Integrator<S>> Integrator<S> for WithNeeds<I> {
    type Run<'a>
        = I::Run<'a>
    where
        Self: 'a,
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = match I::ON_WORLD {
        Some(_) => Some(start_on_world::<S, I>),
        None => None,
    };

    fn name(&self) -> &'static str {
        self.integrator.name()
    }

    fn chooses_lights(&self) -> bool {
        self.integrator.chooses_lights()
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<I::Run<'a>> {
        self.integrator.start(Stage { needs: self.needs, ..stage }, crew)
    }
}

fn start_on_world<'a, S: Scene + ?Sized, I: Integrator<S>>(
    WithNeeds { integrator, needs }: &'a WithNeeds<I>,
    stage: Stage<'a, World>,
    crew: &dyn Crew,
) -> Started<BoxedRun<'a, World, AnySampler>> {
    let start = const { I::ON_WORLD.expect("asked for where it is") };
    start(integrator, Stage { needs: *needs, ..stage }, crew)
}
