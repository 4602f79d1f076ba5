//! What a study found, as plain data: serialised to JSON as it stands. docs/report.md describes the
//! fields.

use super::agreement::Pair;
use super::inference::{Interval, Tail};
use super::leave_out::{DecisionReport, Omission, WithoutTechnique};
use super::metrics::Errors;
use super::pyramid::PyramidReport;
use serde::{Deserialize, Serialize};

/// Number of the JSON schema: rises when a field changes its meaning or goes away.
pub const SCHEMA: u32 = 3;

/// A whole study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the crate.
    pub version: String,
    /// What was rendered.
    pub scene: SceneInfo,
    /// How it was measured.
    pub setup: Setup,
    /// What it was compared with.
    pub reference: ReferenceInfo,
    /// One entry per integrator, in the order given.
    pub methods: Vec<MethodReport>,
    /// Tests of whether integrators that see everything agree.
    pub pairs: Vec<Pair>,
    /// Shares of the techniques of bidirectional path tracing, if they were measured.
    pub pyramid: Option<PyramidReport>,
    /// Integrators that have no technique for the scene and were left out.
    pub left_out: Vec<WithoutTechnique>,
    /// Whether the study was stopped before its end.
    pub stopped: bool,
}

/// What was rendered.
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

/// How it was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// The command that makes this report again, if there is one.
    pub command: Option<String>,
    /// Independent runs of each integrator.
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
    /// Whether runs are only as long as it takes to the target.
    pub until_target: bool,
    /// The integrator that speed-ups are relative to; `None` if no complete one has a finite
    /// variance.
    pub baseline: Option<String>,
    /// Processor, as the operating system names it.
    pub processor: String,
    /// Processors that the program may use.
    pub processors: usize,
    /// Load averages over 1, 5 and 15 minutes when the study began, if the system tells.
    pub load: Option<String>,
    /// Whether debug assertions were compiled in, which makes times meaningless.
    pub debug_build: bool,
}

/// What it was compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceInfo {
    /// Where it comes from.
    pub origin: String,
    /// Whether it is taken as exact.
    pub exact: bool,
    /// Mean luminance.
    pub mean: f64,
    /// Standard error of the mean.
    pub mean_standard_error: f64,
    /// Mean over pixels and channels of its own variance, which is subtracted from MSE.
    pub own_mse: f64,
    /// The same for relMSE.
    pub own_relative_mse: f64,
}

/// What was done up to a checkpoint, mean over the runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Wall-clock seconds.
    pub wall: f64,
    /// Processor seconds of the process, all threads together.
    pub cpu: f64,
    /// Rays.
    pub rays: f64,
    /// Scattering vertices sampled.
    pub scattered: f64,
}

/// The state of the runs after a power of two of samples per pixel, or at their end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Samples per pixel.
    pub samples: u32,
    /// What it took.
    pub cost: Cost,
    /// What each run took, in the order of seeds.
    pub costs: Vec<Cost>,
    /// Errors of each run, in the order of seeds: the same to the bit whenever the seeds are.
    pub runs: Vec<Errors>,
    /// Mean squared error of a run.
    pub mse: Interval,
    /// Relative mean squared error of a run.
    pub relative_mse: Interval,
    /// Mean absolute percentage error of a run.
    pub mape: Interval,
    /// Symmetric mean absolute percentage error of a run.
    pub smape: Interval,
    /// Median squared error of a run.
    pub median_squared: Interval,
    /// Variance of a run, mean over pixels and channels, from the spread of the runs: no reference
    /// is needed.
    #[serde(with = "super::number")]
    pub variance: f64,
    /// Mean over pixels and channels of the squared bias: of the mean of the runs against the
    /// reference, both their variances subtracted.
    #[serde(with = "super::number")]
    pub squared_bias: f64,
    /// Whether the reference's own variance is too large a part of the error; curves stop here.
    pub reference_limited: bool,
}

/// Whether the mean is right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// Mean luminance minus that of the reference.
    pub mean: f64,
    /// Its standard error, that of the reference included.
    #[serde(with = "super::number")]
    pub mean_standard_error: f64,
    /// Two-sided p-value of the difference of means.
    pub mean_p_value: f64,
    /// Relative bias, 0.01 for an image that is 1 % too bright: blocks of pixels weighted by value
    /// over variance.
    pub relative: f64,
    /// Its standard error.
    #[serde(with = "super::number")]
    pub relative_standard_error: f64,
    /// Its two-sided p-value.
    pub relative_p_value: f64,
    /// Whether one of the two is significant and the integrator claims to see every path.
    pub flagged: bool,
}

/// A slope in log-log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// Of which measure.
    pub measure: String,
    /// From this number of samples per pixel.
    pub from: u32,
    /// To this one.
    pub to: u32,
    /// The slope against the number of samples.
    pub value: Interval,
    /// Standard error of the slope.
    #[serde(with = "super::number")]
    pub standard_error: f64,
}

/// When a target error is reached, in seconds of wall-clock time for one run: from then on no
/// checkpoint of the run is above it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeToTarget {
    /// The time.
    pub seconds: Interval,
    /// Runs that reached it.
    pub reached: u32,
    /// Whether other runs ended before, and their time is extrapolated with an error that falls as
    /// 1/t.
    pub extrapolated: bool,
}

/// Efficiency over that of the baseline: ratios of variance × cost with runs paired by seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedUp {
    /// In wall-clock time.
    pub wall: Interval,
    /// In processor time.
    pub cpu: Interval,
    /// In rays: does not depend on the machine.
    pub rays: Interval,
}

/// The energy ledger of the light walks, as luminance of flux per sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LedgerReport {
    /// Flux that walks started with.
    pub emitted: f64,
    /// Absorbed by surfaces.
    pub absorbed: f64,
    /// Left the scene.
    pub escaped: f64,
    /// Cut off by the limit on bounces.
    pub truncated: f64,
    /// Lost in non-finite samples.
    pub rejected: f64,
}

/// What one integrator did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodReport {
    /// Its name.
    pub name: String,
    /// The techniques that it ran; if it adapts itself, in the discarded run.
    pub techniques: String,
    /// What the scene rules out, with reasons.
    pub left_out: Vec<Omission>,
    /// What it decided in each run, in the order of seeds; empty if it does not adapt itself.
    pub decisions: Vec<DecisionReport>,
    /// Whether it claims to draw every path of the scene.
    pub complete: bool,
    /// Runs that were finished.
    pub runs: u32,
    /// Samples per pixel of each run.
    pub samples_per_pixel: u32,
    /// What all runs together took.
    pub total: Cost,
    /// Rays per sample.
    pub rays_per_sample: f64,
    /// Seconds of processor time per sample.
    pub cpu_per_sample: f64,
    /// Curves of error.
    pub checkpoints: Vec<Checkpoint>,
    /// Mean squared error and so on of the mean of all runs.
    pub mean_image: Errors,
    /// Errors of the median of means over the runs: robust against outliers.
    pub median_of_means: Errors,
    /// Mean luminance, with its standard error from batches.
    pub mean: f64,
    /// Standard error of `mean`.
    #[serde(with = "super::number")]
    pub mean_standard_error: f64,
    /// Whether the mean is right.
    pub bias: Bias,
    /// Variance of one sample per pixel, mean over pixels and channels.
    pub variance_per_sample: Interval,
    /// Variance × wall-clock time: the seconds that an image of variance 1 takes.
    pub variance_times_wall: Interval,
    /// Variance × processor time.
    pub variance_times_cpu: Interval,
    /// Variance × rays per pixel.
    pub variance_times_rays: Interval,
    /// Over the baseline; `None` for integrators that do not see everything and for infinite
    /// variance.
    pub speed_up: Option<SpeedUp>,
    /// When the target relMSE is reached; `None` for integrators that do not see everything, and if
    /// the variance is infinite and not all runs reached it.
    pub time_to_target: Option<TimeToTarget>,
    /// How the error falls: MSE, or MedSE if the variance is infinite.
    pub slope: Option<Slope>,
    /// Tail of the contributions.
    pub tail: Option<Tail>,
    /// Whether the tail says that the variance is infinite. Then MSE, variance and all that is made
    /// of them do not settle, and SMAPE, MedSE and median of means are the numbers to read.
    pub infinite_variance: bool,
    /// Whether rare, bright contributions make up so much of the relative variance that the runs do
    /// not know it to 5 %: blocks of pixels that are too dark are then no evidence.
    pub long_tails: bool,
    /// Contributions that were infinite or not a number.
    pub non_finite_contributions: u64,
    /// The first of them, for people.
    pub first_non_finite: Option<String>,
    /// Pixels of run images that are not finite.
    pub non_finite_pixels: u64,
    /// Energy ledger of the light walks; all zero without any.
    pub ledger: LedgerReport,
    /// Mean luminance by number of scattering events; the last entry has all longer paths. What an
    /// integrator cannot see is missing.
    pub energy_by_bounces: Vec<f64>,
}

impl MethodReport {
    /// The last checkpoint: whole runs.
    #[must_use]
    pub fn last(&self) -> Option<&Checkpoint> {
        self.checkpoints.last()
    }
}
