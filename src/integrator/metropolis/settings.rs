//! The settings of Metropolis sampling, and the start.

use super::Chains;
use super::candidates::{Candidates, Normalization};
use crate::integrator::any_run::on_world;
use crate::integrator::{
    AnyIntegrator, BoxedRun, Crew, Integrator, IntegratorError, Stage, StartOnWorld, Started,
};
use crate::sampler::{AnySampler, Step};
use crate::scene::{Scene, World};

/// Metropolis sampling over an integrator whose samples depend on nothing but their numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metropolis<I> {
    /// The integrator whose samples are mutated.
    pub integrator: I,
    /// Number of candidates; `None` for as many as it takes for chains to begin at different ones,
    /// but at most one for eight mutations.
    pub candidates: Option<u32>,
    /// Passes after which chains begin anew.
    pub restart: u32,
    /// Probability of a large step, which draws all numbers anew.
    pub large_step: f64,
    /// Smallest and largest standard deviation of the displacements in a small step. That of a step
    /// is in between, its logarithm uniform.
    pub sizes: [f64; 2],
}

impl<I> Metropolis<I> {
    /// Metropolis sampling over an integrator: chains of 256 passes, with large steps of probability
    /// 0.3 and small ones of 2⁻¹² to 2⁻⁶.
    pub const fn over(integrator: I) -> Self {
        let sizes = [1.0 / 4096.0, 1.0 / 64.0];
        Self { integrator, candidates: None, restart: 256, large_step: 0.3, sizes }
    }

    /// The step that two numbers choose.
    pub(super) fn step(&self, u1: f64, u2: f64) -> Step {
        let [least, most] = self.sizes;
        if u1 < self.large_step {
            Step::Large
        } else {
            Step::Small(least * libm::pow(most / least, u2))
        }
    }

    fn check(&self) -> Result<(), String> {
        let Self { candidates, restart, large_step, sizes, .. } = *self;
        let is_in = |value: f64| value > 0.0 && value <= 1.0;
        match () {
            () if candidates == Some(0) => Err("no candidates: at least 1 is needed".to_owned()),
            () if restart == 0 => Err("chains of 0 passes: at least 1 is needed".to_owned()),
            () if !is_in(large_step) => {
                Err(format!("probability {large_step} of large steps: it must be in (0, 1]"))
            }
            () if !(sizes.into_iter().all(is_in) && sizes.is_sorted()) => {
                Err(format!("small steps of {sizes:?}: they must rise in (0, 1]"))
            }
            () => Ok(()),
        }
    }

    fn run<'a, S: Scene + ?Sized>(
        &self,
        stage: Stage<'a, S>,
        mut run: BoxedRun<'a, S, AnySampler>,
    ) -> Started<Chains<'a, S>> {
        self.check().map_err(refused)?;
        if run.prepares() {
            return Err(refused("passes that share what is made for each have no chains".into()));
        }
        let &Self { candidates, restart, large_step, sizes, .. } = self;
        let settings = Metropolis { integrator: (), candidates, restart, large_step, sizes };
        let (candidates, normalization) = (Candidates::default(), Normalization::default());
        let (set, counters) = (0, run.take_preparation());
        Ok(Chains { stage, run, settings, candidates, set, normalization, counters })
    }
}

impl<I: Default> Default for Metropolis<I> {
    fn default() -> Self {
        Self::over(I::default())
    }
}

const NAME: &str = "metropolis";

pub(super) fn refused(reason: String) -> IntegratorError {
    IntegratorError { integrator: NAME, reason }
}

impl<S: Scene + ?Sized, I: Integrator<S>> Integrator<S> for Metropolis<I> {
    type Run<'a>
        = Chains<'a, S>
    where
        Self: 'a,
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = match I::ON_WORLD {
        Some(_) => Some(start_on_world::<S, I>),
        None => None,
    };

    fn name(&self) -> &'static str {
        NAME
    }

    fn chooses_lights(&self) -> bool {
        self.integrator.chooses_lights()
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<Chains<'a, S>> {
        self.run(stage, AnyIntegrator::start(&self.integrator, stage, crew)?)
    }
}

fn start_on_world<'a, S: Scene + ?Sized, I: Integrator<S>>(
    metropolis: &'a Metropolis<I>,
    stage: Stage<'a, World>,
    crew: &dyn Crew,
) -> Started<BoxedRun<'a, World, AnySampler>> {
    let start = const { I::ON_WORLD.expect("asked for where it is") };
    Ok(on_world::chains(metropolis.run(stage, start(&metropolis.integrator, stage, crew)?)?))
}
