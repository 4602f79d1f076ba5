//! Path guiding (Müller, Gross and Novák 2017): walks that are not in the image teach a
//! [`Field`] where light comes from, and an integrator renders in the scene that it
//! [guides](Guided).
//!
//! The image is unbiased, whatever was learnt. Where guiding does not pay, or the budget is too small
//! to find out, the integrator renders the scene itself, and learning ends as soon as that is known:
//! from the variance that both have, estimated from the same walks, and their counted costs.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

mod training;

use super::any_run::on_world;
use super::viewed::{draw, look};
use super::{
    Bidirectional, Crew, Integrator, IntegratorError, Notes, PathTracer, PathTracing, Run, Stage,
    StartOnWorld, Started,
};
use crate::film::{Sample, Sink};
use crate::guiding::{Field, Guided};
use crate::path::{Counters, Ledger, Scratch, TechniqueSet};
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::fmt;
use training::Training;

/// An integrator whose camera walks are guided where that pays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guiding<I> {
    /// The integrator; one whose samples share nothing.
    pub integrator: I,
    /// α, the probability with which a walk goes on by the BSDF and not by what was learnt, in
    /// (0, 1].
    pub alpha: f64,
    /// True if walks are guided whether that pays or not.
    pub always: bool,
}

impl<I> Guiding<I> {
    /// An integrator that is guided half of the time.
    pub const fn new(integrator: I) -> Self {
        Self { integrator, alpha: 0.5, always: false }
    }
}

impl<I: Default> Default for Guiding<I> {
    fn default() -> Self {
        Self::new(I::default())
    }
}

/// An integrator whose camera walks can be guided.
pub trait Guidable: Sized {
    /// The start of the guided integrator on a world that was compiled with this crate.
    #[doc(hidden)]
    const ON_WORLD: Option<StartOnWorld<Guiding<Self>>> = None;

    /// The path tracing that learns for it: with the same path lengths and roulette.
    fn teacher(&self) -> PathTracer;
}

impl Guidable for PathTracer {
    const ON_WORLD: Option<StartOnWorld<Guiding<Self>>> = Some(on_world::guided_path_tracer);

    fn teacher(&self) -> PathTracer {
        PathTracer { roulette: self.roulette.without_constant(), ..*self }
    }
}

impl Guidable for Bidirectional {
    fn teacher(&self) -> PathTracer {
        let Self { depth, roulette, heuristic, .. } = *self;
        let roulette = roulette.without_constant();
        PathTracer { mode: PathTracing::Both, depth, roulette, heuristic }
    }
}

/// The findings of [`Guiding`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guidance {
    /// Samples that were learnt from.
    pub samples: u64,
    /// Parts of space for which directions are known.
    pub parts: usize,
    /// Variance × cost without guiding over that with it, as path tracing has it; 0 if it is not
    /// known.
    pub gain: f64,
    /// True if walks are guided.
    pub is_used: bool,
}

impl fmt::Display for Guidance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { samples, parts, gain, is_used } = self;
        let is_guided = if *is_used { "guided" } else { "not guided" };
        write!(
            f,
            "{is_guided}: expected gain {gain:.2}, {parts} parts learnt from {samples} samples"
        )
    }
}

/// A rendering in what was learnt, or in the scene itself.
pub struct GuidedRun<'a, S: Scene + ?Sized + 'a, I: Integrator<S>> {
    integrator: &'a I,
    stage: Stage<'a, S>,
    alpha: f64,
    choice: Choice<I::Run<'a>>,
    techniques: TechniqueSet,
    notes: Notes,
    counters: Counters,
}

enum Choice<R> {
    Guided(Field),
    Plain(R),
}

impl<S: Scene + ?Sized, I> Integrator<S> for Guiding<I>
where
    I: Guidable + Integrator<S> + for<'v> Integrator<Guided<'v, S>>,
{
    type Run<'a>
        = GuidedRun<'a, S, I>
    where
        Self: 'a,
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = <I as Guidable>::ON_WORLD;

    fn name(&self) -> &'static str {
        "guided"
    }

    fn chooses_lights(&self) -> bool {
        <I as Integrator<S>>::chooses_lights(&self.integrator)
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<Self::Run<'a>> {
        let Self { integrator, alpha, .. } = self;
        let unknown = Field::unknown();
        let guided = Guided::new(stage.scene, &unknown, *alpha).ok_or_else(|| IntegratorError {
            integrator: Integrator::<S>::name(self),
            reason: format!("the probability {alpha} of going on by the BSDF is not in (0, 1]"),
        })?;
        let (techniques, notes) = look(integrator, stage.viewed(&guided, stage.needs), crew)?;
        let mut training = Training::new(integrator.teacher(), *alpha, stage, crew);
        let guidance = training.run(self.always);
        let choice = if guidance.is_used {
            Choice::Guided(training.field)
        } else {
            Choice::Plain(Integrator::<S>::start(integrator, stage, crew)?)
        };
        // Neither its energy nor its samples are the image's.
        let counters = training.counters;
        let counters =
            Counters { samples: 0, truncated_subpaths: 0, ledger: Ledger::default(), ..counters };
        let notes = Notes { guidance: Some(guidance), ..notes };
        Ok(GuidedRun { integrator, stage, alpha: *alpha, choice, techniques, notes, counters })
    }
}

impl<'a, S: Scene + ?Sized + 'a, I> Run<'a, S> for GuidedRun<'a, S, I>
where
    I: Integrator<S> + for<'v> Integrator<Guided<'v, S>>,
{
    type Chunk = <<I as Integrator<S>>::Run<'a> as Run<'a, S>>::Chunk;

    fn techniques(&self) -> TechniqueSet {
        self.techniques
    }

    fn notes(&self) -> Notes {
        self.notes.clone()
    }

    fn take_preparation(&mut self) -> Counters {
        std::mem::take(&mut self.counters)
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        chunk: &mut Self::Chunk,
        scratch: &mut Scratch<'a, S>,
    ) {
        let Self { integrator, stage, alpha, .. } = self;
        match &self.choice {
            Choice::Plain(run) => run.draw(samples, sink, chunk, scratch),
            Choice::Guided(field) => {
                let Some(scene) = Guided::new(stage.scene, field, *alpha) else { return };
                let stage = stage.viewed(&scene, stage.needs);
                draw(*integrator, stage, samples, sink, &mut scratch.counters);
            }
        }
    }
}
