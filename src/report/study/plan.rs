//! Plans of studies and of references.

use crate::integrator::Bidirectional;
use crate::render::{Budget, Settings};
use crate::report::result::Study;
use crate::sampler::SamplerKind;
use std::fmt;

/// Budget, runs and settings of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The budget of each integrator, all its runs together: when they end, or end at the latest if
    /// `until_target`.
    pub budget: Budget,
    /// Independent runs of each integrator; at least two. A budget of time is cut into so many
    /// parts, and as many runs are made as it allows in the end. Default: 8.
    pub seeds: u32,
    /// Filter, sampler, threads, and the seed that those of the runs are derived from. Its budget
    /// and target error are not used. Default: independent samples, whose variance does not depend
    /// on how many there are, and whose passes the test of bias takes one by one.
    pub settings: Settings,
    /// relMSE of a run whose time is asked for. Default: 0.01.
    pub target: f64,
    /// True if runs are only as long as it takes to the target: the discarded run before them goes
    /// on until its error against the reference is below it, and the others get 1.25 times the
    /// samples that it took. Default: no.
    pub until_target: bool,
    /// The name of the integrator that speed-ups are relative to. Default: the first that sees
    /// everything and whose variance is finite.
    pub baseline: Option<String>,
    /// Bidirectional path tracing whose techniques are measured one by one, if wanted.
    pub pyramid: Option<Bidirectional>,
    /// The command that makes this report again, to be printed.
    pub command: Option<String>,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            budget: Budget::Samples(64),
            seeds: 8,
            settings: Settings { sampler: SamplerKind::Independent, ..Settings::default() },
            target: 0.01,
            until_target: false,
            baseline: None,
            pyramid: None,
            command: None,
        }
    }
}

/// The progress of a study.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    /// The integrator, or the work, that is under way.
    pub label: &'a str,
    /// Part of the work that is done, 0 to 1.
    pub fraction: f64,
    /// Makes the study of the finished runs.
    so_far: Option<&'a dyn Fn() -> Study>,
}

impl<'a> Step<'a> {
    /// A step on the way, or the end of a run if there is a study of the finished ones.
    pub(super) fn new(
        label: &'a str,
        fraction: f64,
        so_far: Option<&'a dyn Fn() -> Study>,
    ) -> Self {
        Self { label, fraction, so_far }
    }

    /// The study of the finished runs, as if it were stopped here, if a run has ended with this
    /// step. No clock of the study runs while it is made, which takes longer the more runs and
    /// pixels there are.
    #[must_use]
    pub fn study(&self) -> Option<Study> {
        self.so_far.map(|so_far| so_far())
    }
}

impl fmt::Debug for Step<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { label, fraction, .. } = self;
        let mut step = f.debug_struct("Step");
        step.field("label", label).field("fraction", fraction).finish_non_exhaustive()
    }
}

/// Budget, runs and settings of a rendered reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferencePlan {
    /// The budget of both halves together.
    pub budget: Budget,
    /// Runs of each half; at least two.
    pub runs: u32,
    /// Filter, sampler, threads, and the seed that its own are derived from. Its budget and target
    /// error are not used.
    pub settings: Settings,
}

/// A seed of its own for each run of each stream of renderings.
pub(super) fn run_seed(base: u64, stream: u64, run: u32) -> u64 {
    base.wrapping_add((stream + 1) << 40).wrapping_add(u64::from(run) << 20)
}
