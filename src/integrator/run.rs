//! Settings that start a run, and the run that draws: the two traits of an integrator.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::{Crew, Decision, Guidance, Normalization, Regularization, StartOnWorld};
use crate::film::{FilmSample, Sample, Sink};
use crate::path::{
    Counters, Depth, LeftOut, MissingPaths, Plan, Scratch, Stage, Steps, TechniqueSet, advance,
};
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::fmt;

/// A way to estimate the image, as plain settings. Open for users to implement.
///
/// Its debug output holds all settings: by it, a rendering that goes on from a
/// [`Checkpoint`](crate::render::Checkpoint) knows them again.
pub trait Integrator<S: Scene + ?Sized>: fmt::Debug + Sync + Sized {
    /// One rendering by these settings.
    type Run<'a>: Run<'a, S>
    where
        Self: 'a,
        S: 'a;

    /// The start on a [`World`](crate::scene::World) that was compiled with this crate, for the
    /// built-in integrators: who renders a world with one of them need not compile it again.
    #[doc(hidden)]
    const ON_WORLD: Option<StartOnWorld<Self>> = None;

    /// The same of its [`Regularization`].
    #[doc(hidden)]
    const REGULARIZED_ON_WORLD: Option<StartOnWorld<Regularization<Self>>> = None;

    /// The name in the field's terms, such as `path-tracing`.
    fn name(&self) -> &'static str;

    /// True if it chooses lights, so that it is worth while to see first which of them
    /// [arrive](super::Arrivals).
    fn chooses_lights(&self) -> bool {
        true
    }

    /// Begins a rendering: leaves out what the stage does not need, and prepares what all passes
    /// share.
    ///
    /// # Errors
    /// If the settings do not fit the stage, or there is not enough memory.
    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<Self::Run<'a>>;
}

/// One rendering by an integrator: it owns whatever lives from pass to pass.
///
/// A pass draws one sample per pixel, in chunks of consecutive pixels that threads draw at the same
/// time. Every integrator normalises alike: with N samples spread evenly over the window of P
/// pixels, a pixel's value is `P/N` times the sum of the contributions that fall in it.
pub trait Run<'a, S: Scene + ?Sized + 'a>: Sync {
    /// The state that a chunk keeps from pass to pass, such as a Markov chain, or records to learn
    /// from; `()` for most. It is kept only in a run that [`learns`](Self::learns).
    type Chunk: Default + Send;

    /// The techniques that draw paths.
    fn techniques(&self) -> TechniqueSet;

    /// The run's notes on its estimate.
    fn notes(&self) -> Notes {
        Notes::default()
    }

    /// True if passes are prepared: the driver calls [`begin_pass`](Self::begin_pass) before each,
    /// and threads wait for each other. If not, they go on with the next pass.
    fn prepares(&self) -> bool {
        self.learns()
    }

    /// True if passes depend on those before them: the driver calls [`collect`](Self::collect) after
    /// each. Such a run has to draw all passes, from the first one on; the passes of others can be
    /// drawn alone, by any machine.
    fn learns(&self) -> bool {
        false
    }

    /// Prepares a pass, while nobody draws; passes are numbered from 0. What it makes depends on the
    /// pass alone, if the run does not learn.
    ///
    /// # Errors
    /// If there is not enough memory.
    fn begin_pass(&mut self, _pass: u32, _crew: &dyn Crew) -> Result<(), IntegratorError> {
        Ok(())
    }

    /// Draws samples. The contributions of each are the same whichever others are drawn with it,
    /// and come in the same order; those of different samples may mix.
    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        chunk: &mut Self::Chunk,
        scratch: &mut Scratch<'a, S>,
    );

    /// Learns from a chunk after a pass, in the order of the chunks.
    fn collect(&mut self, _chunk: &mut Self::Chunk) {}

    /// Counts of the work beside drawing samples, by [`Integrator::start`] and `begin_pass`, since
    /// it was asked for last.
    fn take_preparation(&mut self) -> Counters {
        Counters::default()
    }

    /// Draws one sample alone, in a chunk of its own.
    fn sample<P: Sampler>(
        &self,
        film: FilmSample,
        sampler: P,
        sink: &mut dyn Sink,
        scratch: &mut Scratch<'a, S>,
    ) {
        self.draw(&mut [Sample { film, sampler }], sink, &mut Self::Chunk::default(), scratch);
    }
}

/// A run, or the reason why there is none.
pub type Started<R> = Result<R, IntegratorError>;

/// A run whose samples are one walk each, as the [`Steps`] of its settings say, and that keeps
/// nothing from pass to pass: all that a path tracer or a light tracer takes.
#[derive(Debug)]
pub struct SingleWalk<'a, S: Scene + ?Sized, I> {
    plan: Plan<'a, S>,
    settings: I,
}

impl<'a, S: Scene + ?Sized, I> SingleWalk<'a, S, I> {
    /// A run of techniques and path lengths, less what the stage does not need.
    pub fn new(stage: Stage<'a, S>, settings: I, techniques: TechniqueSet, depth: Depth) -> Self {
        Self { plan: Plan::new(stage, techniques, depth), settings }
    }
}

impl<'a, S: Scene + ?Sized + 'a, I: Steps<'a, S> + Sync> Run<'a, S> for SingleWalk<'a, S, I> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.plan.techniques
    }

    fn notes(&self) -> Notes {
        Notes::of(&self.plan)
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        scratch.counters.samples += samples.len() as u64;
        advance(&self.plan, &self.settings, samples, sink, scratch);
    }
}

/// The notes of a run on its estimate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// The techniques left out on this stage, each with the reason.
    pub left_out: LeftOut,
    /// The paths that the techniques cannot draw, as far as the scene has them.
    pub missing: Vec<MissingPaths>,
    /// The choice of what to run, if there was one.
    pub decision: Option<Decision>,
    /// The findings about guiding, if it was asked for.
    pub guidance: Option<Guidance>,
    /// The kind of the estimator: unbiased, consistent or biased.
    pub estimator: Estimator,
    /// True if samples depend on one another, as those do that share light walks: then the variance
    /// of single ones says nothing of that of their mean.
    pub is_correlated: bool,
    /// Number of passes in a row whose errors depend on one another, as those of one set of Markov
    /// chains do; 0 if passes are independent.
    pub dependent_passes: u32,
    /// The constant that Markov chains are scaled with, as far as it is known.
    pub normalization: Option<Normalization>,
}

impl Notes {
    /// The notes of an unbiased run whose samples are independent.
    #[must_use]
    pub fn of<S: Scene + ?Sized>(plan: &Plan<'_, S>) -> Self {
        Self { left_out: plan.left_out, missing: plan.missing(), ..Self::default() }
    }
}

/// The mean of an estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// The image, after any number of passes.
    #[default]
    Unbiased,
    /// Not the image, but it tends to it as passes are added.
    Consistent,
    /// Not the image, after any number of passes.
    Biased,
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unbiased => "unbiased",
            Self::Consistent => "consistent: its bias vanishes as passes are added",
            Self::Biased => "biased: some of its error stays",
        })
    }
}

/// The reason why an integrator cannot render a stage.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{integrator}: {reason}")]
pub struct IntegratorError {
    /// The integrator's name.
    pub integrator: &'static str,
    /// The reason, in words.
    pub reason: String,
}
