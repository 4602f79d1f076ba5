//! The whole report.

use super::left_out::WithoutTechnique;
use super::method::MethodReport;
use super::pyramid::PyramidReport;
use crate::report::stats::{Layout, Pair, Ranking, Reference};
use serde::{Deserialize, Serialize};

/// Number of the JSON schema: rises when a field changes its meaning or goes away.
pub const SCHEMA: u32 = 6;

/// A whole study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the crate.
    pub version: String,
    /// The scene.
    pub scene: SceneInfo,
    /// Settings, machine and command of the study.
    pub setup: Setup,
    /// The reference.
    pub reference: ReferenceInfo,
    /// One entry per integrator, in the order given.
    pub methods: Vec<MethodReport>,
    /// Their order by time, unless clocks are left out, and by rays; empty if none can be ranked.
    pub rankings: Vec<Ranking>,
    /// Tests of whether unbiased integrators that see everything agree.
    pub pairs: Vec<Pair>,
    /// Shares of the techniques of bidirectional path tracing, if they were measured.
    pub pyramid: Option<PyramidReport>,
    /// Integrators that have no technique for the scene and were left out.
    pub left_out: Vec<WithoutTechnique>,
    /// True if the study was stopped before its end.
    pub stopped: bool,
}

/// The scene and its film.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneInfo {
    /// Its name.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Width of the film's window in pixels.
    pub width: u32,
    /// Height of the film's window in pixels.
    pub height: u32,
    /// Largest number of scattering events; `None` for no limit.
    pub max_bounces: Option<u32>,
}

/// Settings, machine and command of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// The command that makes this report again, if there is one.
    pub command: Option<String>,
    /// Independent runs of each integrator, as planned.
    pub seeds: u32,
    /// The seed that theirs are derived from.
    pub seed: u64,
    /// Budget of each integrator, all runs together, for people.
    pub budget: String,
    /// Pixel filter.
    pub filter: String,
    /// Sampler.
    pub sampler: String,
    /// Number of threads; `None` for all.
    pub threads: Option<usize>,
    /// relMSE of a run whose time is asked for.
    pub target: f64,
    /// True if runs are only as long as it takes to the target.
    pub until_target: bool,
    /// The integrator that speed-ups are relative to; `None` if no complete one has a finite
    /// variance.
    pub baseline: Option<String>,
    /// The machine; `None` in a report [without clocks](super::Study::without_clocks).
    pub machine: Option<Machine>,
    /// True if debug assertions were compiled in, which makes times meaningless.
    pub debug_build: bool,
}

/// The machine that a study ran on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Processor, as the operating system names it.
    pub processor: String,
    /// Processors that the program may use.
    pub processors: usize,
    /// Load averages over 1, 5 and 15 minutes when the study began, if the system tells.
    pub load: Option<String>,
}

/// The reference and its own error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceInfo {
    /// Its source.
    pub origin: String,
    /// True if it is taken as exact.
    pub exact: bool,
    /// Mean luminance.
    pub mean: f64,
    /// Standard error of the mean.
    pub mean_standard_error: f64,
    /// Mean over pixels and channels of its own variance, which is subtracted from MSE.
    pub own_mse: f64,
    /// The same for relMSE.
    pub own_relative_mse: f64,
    /// Paths that only integrators which merge draw, and that are missing in it, in words.
    pub missing: Vec<String>,
    /// The reason why it is no measure of a bias; `None` if it is.
    pub undecided: Option<String>,
}

impl ReferenceInfo {
    pub(in crate::report) fn of(reference: &Reference) -> Self {
        let mean = reference.block_sum(&Layout::of(reference.image()).uniform_weights());
        Self {
            origin: reference.origin().to_owned(),
            exact: reference.is_exact(),
            mean: mean.mean,
            mean_standard_error: mean.standard_error(),
            own_mse: reference.own_mse(),
            own_relative_mse: reference.own_relative_mse(),
            missing: reference.missing().to_vec(),
            undecided: reference.undecided().map(|reason| reason.to_string()),
        }
    }
}

impl Report {
    /// The report as JSON; docs/report.md describes the fields. Numbers that are not finite become
    /// null.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Nothing in a report can fail to be serialised: keys are texts and non-finite numbers have
        // a rule.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}
