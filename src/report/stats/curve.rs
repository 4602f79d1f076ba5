//! Error against cost: checkpoints, how errors fall, when they are small enough.

use super::interval::Interval;
use super::measured::{Cost, Mark, Measured};
use super::metrics::Errors;
use super::reference::Reference;
use super::regression::{slope, time_to_error};
use crate::math::statistics::Estimate;
use serde::{Deserialize, Serialize};

/// A curve stops where the reference's own variance is more than this part of the error.
pub const REFERENCE_SHARE: f64 = 0.1;
/// Slopes are fitted to the last octaves of the number of samples.
const OCTAVES: u32 = 3;

/// The state of the runs after a power of two of samples per pixel, or at their end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Samples per pixel.
    pub samples: u32,
    /// Cost, mean over the runs.
    pub cost: Cost,
    /// Cost of each run, in the order of seeds.
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
    /// True if the reference's own variance is too large a part of the error; curves stop here.
    pub reference_limited: bool,
}

/// A slope in log-log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// The measure of the error.
    pub measure: String,
    /// Samples per pixel of the first checkpoint in the fit.
    pub from: u32,
    /// Samples per pixel of the last one.
    pub to: u32,
    /// The slope against the number of samples.
    pub value: Interval,
    /// Standard error of the slope.
    #[serde(with = "super::number")]
    pub standard_error: f64,
}

/// Wall-clock time of one run until a target error is reached: from then on no checkpoint of the
/// run is above it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeToTarget {
    /// The time.
    pub seconds: Interval,
    /// Runs that reached it.
    pub reached: u32,
    /// True if other runs ended before, and their time is extrapolated with an error that falls as
    /// 1/t.
    pub extrapolated: bool,
}

impl Checkpoint {
    pub(in crate::report) fn of(mark: &Mark, reference: &Reference) -> Self {
        let interval = |measure: fn(&Errors) -> f64| {
            Interval::of_positive(&mark.errors.iter().map(measure).collect::<Vec<_>>())
        };
        let runs = mark.errors.len() as f64;
        let average = |cost: fn(&Cost) -> f64| mark.costs.iter().map(cost).sum::<f64>() / runs;
        let deviations = mark.deviation.pixels().iter().map(|d| (*d * *d).mean()).sum::<f64>();
        let squared_mean = deviations / mark.deviation.pixels().len().max(1) as f64 / (runs * runs);
        let variance = if runs > 1.0 {
            ((mark.squares - runs * squared_mean) / (runs - 1.0)).max(0.0)
        } else {
            f64::NAN
        };
        let mse = interval(|e| e.mse);
        Self {
            samples: mark.samples,
            cost: Cost {
                wall: average(|c| c.wall),
                cpu: average(|c| c.cpu),
                rays: average(|c| c.rays),
                scattered: average(|c| c.scattered),
            },
            costs: mark.costs.clone(),
            runs: mark.errors.clone(),
            mse,
            relative_mse: interval(|e| e.relative_mse),
            mape: interval(|e| e.mape),
            smape: interval(|e| e.smape),
            median_squared: interval(|e| e.median_squared),
            variance,
            squared_bias: squared_mean - variance / runs - reference.own_mse(),
            reference_limited: reference.own_mse() > REFERENCE_SHARE * mse.value,
        }
    }
}

impl Slope {
    /// Weighted least squares of log error over log samples for each run, and the mean of the runs'
    /// slopes: checkpoints of one run are correlated, runs are not. `robust` fits MedSE, else MSE.
    pub(in crate::report) fn fit(checkpoints: &[Checkpoint], robust: bool) -> Option<Self> {
        let measure: fn(&Errors) -> f64 = if robust { |e| e.median_squared } else { |e| e.mse };
        let positive = |c: &&Checkpoint| {
            !c.reference_limited
                && c.runs.iter().all(|e| measure(e) > 0.0 && measure(e).is_finite())
        };
        let usable: Vec<&Checkpoint> = checkpoints.iter().filter(positive).collect();
        let last = usable.last()?.samples;
        let fitted: Vec<&Checkpoint> =
            usable.into_iter().filter(|c| c.samples.saturating_mul(1 << OCTAVES) >= last).collect();
        let from = fitted.first().filter(|c| c.samples < last)?.samples;
        let weights: Vec<f64> = fitted
            .iter()
            .map(|c| {
                let spread: Estimate = c.runs.iter().map(|e| measure(e).ln()).collect();
                1.0 / spread.variance().max(1e-6)
            })
            .collect();
        let points = |run: usize| -> Vec<[f64; 3]> {
            fitted
                .iter()
                .zip(&weights)
                .map(|(c, w)| [f64::from(c.samples).ln(), measure(&c.runs[run]).ln(), *w])
                .collect()
        };
        let slopes: Vec<f64> =
            (0..fitted[0].runs.len()).filter_map(|run| slope(&points(run))).collect();
        let estimate: Estimate = slopes.iter().copied().collect();
        let name = if robust { "MedSE" } else { "MSE" };
        Some(Self {
            measure: name.to_owned(),
            from,
            to: last,
            value: Interval::of_mean(&slopes),
            standard_error: if estimate.count() > 1 { estimate.standard_error() } else { f64::NAN },
        })
    }
}

impl TimeToTarget {
    /// The time to a target of relMSE, for each run. Where the variance is infinite the error does
    /// not fall as 1/t, and nothing is extrapolated.
    pub(in crate::report) fn of(m: &Measured, target: f64) -> Option<Self> {
        let curve = |run: usize| -> Vec<(f64, f64)> {
            m.marks
                .iter()
                .map(|mark| (mark.costs[run].wall, mark.errors[run].relative_mse))
                .collect()
        };
        let times: Vec<_> =
            (0..m.finals.len()).map(|run| time_to_error(&curve(run), target)).collect();
        let reached = times.iter().filter(|time| time.is_ok()).count();
        let extrapolated = reached < times.len();
        if times.is_empty() || extrapolated && m.has_infinite_variance() {
            return None;
        }
        let seconds = times
            .into_iter()
            .map(|time| time.map_or_else(|later| later, Some))
            .collect::<Option<Vec<_>>>()?;
        Some(Self {
            seconds: Interval::of_positive(&seconds),
            reached: reached as u32,
            extrapolated,
        })
    }
}
