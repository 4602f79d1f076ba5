//! The findings on one integrator.

use super::findings::FindingsReport;
use super::left_out::{DecisionReport, Omission};
use super::missing::MissingReport;
use super::pyramid::PyramidReport;
use crate::integrator::Estimator;
use crate::report::stats::{
    Bias, Checkpoint, Cost, Errors, Interval, Slope, SpeedUp, Tail, TimeToTarget,
};
use crate::report::text::with_error;
use serde::{Deserialize, Serialize};

/// The energy ledger of the light subpaths, as luminance of flux per sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LedgerReport {
    /// Flux that light subpaths started with.
    pub emitted: f64,
    /// Absorbed by surfaces.
    pub absorbed: f64,
    /// Left the scene.
    pub escaped: f64,
    /// Cut off by the limit on bounces.
    pub truncated: f64,
    /// Lost in non-finite samples.
    pub rejected: f64,
    /// Mean luminance of the image that a bound on connections cut off and that nothing else draws;
    /// no part of the balance.
    pub clamped: f64,
}

/// The light walks that all pixels of a pass share; all zero without any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SharedReport {
    /// Bytes of the largest map.
    pub bytes: u64,
    /// Vertices stored in maps, in all runs.
    pub photons: u64,
    /// Searches for what is near a vertex, in all runs.
    pub queries: u64,
    /// Photons found in reach, in all runs.
    pub merges: u64,
}

/// The names of [`Estimator`] in files.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Estimator", rename_all = "lowercase")]
enum EstimatorName {
    Unbiased,
    Consistent,
    Biased,
}

/// The findings on one integrator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodReport {
    /// Its name.
    pub name: String,
    /// The techniques that it ran; if it adapts itself, in the discarded run.
    pub techniques: String,
    /// Omissions: what the scene rules out, with reasons.
    pub left_out: Vec<Omission>,
    /// The decision before each run, in the order of seeds; empty if it does not adapt itself.
    pub decisions: Vec<DecisionReport>,
    /// The findings of each run, in the order of seeds; empty if it finds out nothing beside its
    /// image.
    pub findings: Vec<FindingsReport>,
    /// True if it claims to draw every path of the scene that bidirectional path tracing draws.
    pub complete: bool,
    /// Paths that it cannot draw.
    pub missing: Vec<MissingReport>,
    /// The kind of mean that it claims to have.
    #[serde(with = "EstimatorName")]
    pub estimator: Estimator,
    /// Runs that were finished.
    pub runs: u32,
    /// Samples per pixel of each run.
    pub samples_per_pixel: u32,
    /// Cost of all runs together.
    pub total: Cost,
    /// Rays per sample.
    pub rays_per_sample: f64,
    /// Seconds of processor time per sample.
    #[serde(with = "crate::report::stats::number")]
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
    #[serde(with = "crate::report::stats::number")]
    pub mean_standard_error: f64,
    /// The effective number of contributions that the mean rests on: so many of equal size would
    /// have its standard error.
    #[serde(with = "crate::report::stats::number")]
    pub effective_contributions: f64,
    /// The reason why the image is no evidence, neither of a bias nor of agreement, and has no
    /// slope, speed-up or time to a target; `None` if it is.
    pub undecided: Option<String>,
    /// Tests of the mean.
    pub bias: Bias,
    /// Variance of one sample per pixel, mean over pixels and channels.
    pub variance_per_sample: Interval,
    /// Variance × wall-clock time: the seconds that an image of variance 1 takes.
    pub variance_times_wall: Interval,
    /// Variance × processor time.
    pub variance_times_cpu: Interval,
    /// Variance × rays per pixel.
    pub variance_times_rays: Interval,
    /// Over the baseline; `None` for integrators that do not see everything or are not unbiased, and
    /// for infinite variance.
    pub speed_up: Option<SpeedUp>,
    /// Time until the target relMSE is reached; `None` for integrators that do not see everything,
    /// and if not all runs reached it and the variance is infinite or there is a bias.
    pub time_to_target: Option<TimeToTarget>,
    /// Slopes of the error: of MSE, or of MedSE if the variance is infinite; of variance and squared
    /// bias if the integrator is not unbiased. None if it does not see everything.
    pub slopes: Vec<Slope>,
    /// Tail of the contributions.
    pub tail: Option<Tail>,
    /// True if the tail says that the variance is infinite. Then MSE, variance and all that is made
    /// of them do not settle, and SMAPE, MedSE and median of means are the numbers to read.
    pub infinite_variance: bool,
    /// True if rare, bright contributions make up so much of the relative variance that the runs do
    /// not know it to 5 %: blocks of pixels that are too dark are then no evidence.
    pub long_tails: bool,
    /// Contributions that were infinite or not a number.
    pub non_finite_contributions: u64,
    /// The first of them, for people.
    pub first_non_finite: Option<String>,
    /// Pixels of run images that are not finite.
    pub non_finite_pixels: u64,
    /// Energy ledger of the light subpaths; all zero without any.
    pub ledger: LedgerReport,
    /// The light walks that all pixels of a pass share.
    pub shared: SharedReport,
    /// Mean luminance by number of scattering events; the last entry has all longer paths. What an
    /// integrator cannot see is missing.
    pub energy_by_bounces: Vec<f64>,
    /// Shares of its techniques, if they were measured.
    pub pyramid: Option<PyramidReport>,
}

impl MethodReport {
    /// The verdict on its mean, in a word or two.
    #[must_use]
    pub fn verdict(&self) -> &'static str {
        if !self.complete {
            "not tested"
        } else if self.undecided.is_some() {
            "undecided"
        } else if !self.is_tested() {
            "not tested"
        } else if self.bias.flagged {
            "biased"
        } else {
            "no bias seen"
        }
    }

    /// True if its mean must be that of the reference: it claims to draw every path, and to be
    /// unbiased.
    #[must_use]
    pub fn is_tested(&self) -> bool {
        self.complete && self.estimator == Estimator::Unbiased
    }

    /// The fall of the bias with N samples per pixel, as far as it was seen: half the slope of its
    /// square, with its standard error.
    #[must_use]
    pub fn fall_of_bias(&self) -> Option<String> {
        let slope = self.slope("squared bias")?;
        Some(format!("N^({})", with_error(0.5 * slope.value.value, 0.5 * slope.standard_error)))
    }

    /// The slope of a measure: `MSE`, `MedSE`, `variance` or `squared bias`.
    #[must_use]
    pub fn slope(&self, measure: &str) -> Option<&Slope> {
        self.slopes.iter().find(|slope| slope.measure == measure)
    }

    /// The last checkpoint: whole runs.
    #[must_use]
    pub fn last(&self) -> Option<&Checkpoint> {
        self.checkpoints.last()
    }
}
