//! Error against cost: checkpoints, how errors fall, when they are small enough.

use super::interval::Interval;
use super::measured::{Cost, Mark, Measured, Split};
use super::metrics::Errors;
use super::reference::Reference;
use super::regression::{slope, time_to_error};
use crate::integrator::Estimator;
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
    /// Variance and squared bias from each pair of runs, in the order of seeds.
    pub pairs: Vec<Split>,
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
    /// Variance of a run, mean over pixels and channels, from the pairs: no reference is needed.
    pub variance: Interval,
    /// Squared bias of a run, mean over pixels and channels, from the pairs, the reference's own
    /// variance subtracted. One that is 0 may come out negative.
    pub squared_bias: Interval,
    /// True if the reference's own variance is too large a part of the error; curves stop here.
    pub reference_limited: bool,
    /// True if the squared bias is certainly not 0, and more than ten times the reference's own
    /// variance.
    pub bias_is_seen: bool,
}

/// The errors of the runs, or of pairs of runs, at a checkpoint.
type Values = fn(&Checkpoint) -> Vec<f64>;

/// A slope in log-log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// The measure of the error: `MSE`, `MedSE`, `variance` or `squared bias`.
    pub measure: String,
    /// Samples per pixel of the first checkpoint in the fit.
    pub from: u32,
    /// Samples per pixel of the last one.
    pub to: u32,
    /// The slope against the number of samples.
    pub value: Interval,
    /// Standard error of the slope.
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
        let split = |part: fn(&Split) -> f64| mark.splits.iter().map(part).collect::<Vec<_>>();
        let mse = interval(|e| e.mse);
        let squared_bias = Interval::of_mean(&split(|s| s.squared_bias));
        let limited = |error: f64| reference.own_mse() > REFERENCE_SHARE * error;
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
            pairs: mark.splits.clone(),
            mse,
            relative_mse: interval(|e| e.relative_mse),
            mape: interval(|e| e.mape),
            smape: interval(|e| e.smape),
            median_squared: interval(|e| e.median_squared),
            variance: Interval::of_positive(&split(|s| s.variance)),
            squared_bias,
            reference_limited: limited(mse.value),
            bias_is_seen: squared_bias.low > 0.0 && !limited(squared_bias.value),
        }
    }
}

impl Slope {
    /// The slopes of an integrator: of MSE, or of MedSE if its variance is infinite. The MSE of one
    /// that is not unbiased is the sum of two powers; then variance and squared bias have a slope
    /// each, and none if the variance is infinite.
    pub(in crate::report) fn all(
        checkpoints: &[Checkpoint],
        estimator: Estimator,
        infinite_variance: bool,
    ) -> Vec<Self> {
        let fit = |measure, usable: &dyn Fn(&&Checkpoint) -> bool, values: Values| {
            Self::fit(measure, checkpoints.iter().filter(usable).map(|c| (c.samples, values(c))))
        };
        let not_limited = |c: &&Checkpoint| !c.reference_limited;
        let slopes = match (estimator, infinite_variance) {
            (Estimator::Unbiased, false) => {
                vec![fit("MSE", &not_limited, |c| c.runs.iter().map(|e| e.mse).collect())]
            }
            (Estimator::Unbiased, true) => {
                let medians: Values = |c| c.runs.iter().map(|e| e.median_squared).collect();
                vec![fit("MedSE", &not_limited, medians)]
            }
            (_, false) => vec![
                fit("variance", &|_| true, |c| c.pairs.iter().map(|p| p.variance).collect()),
                fit("squared bias", &|c| c.bias_is_seen, |c| {
                    c.pairs.iter().map(|p| p.squared_bias).collect()
                }),
            ],
            (_, true) => Vec::new(),
        };
        slopes.into_iter().flatten().collect()
    }

    /// Weighted least squares of logarithms of error and samples for each run, or pair of runs, and
    /// the mean of their slopes: checkpoints of one run are correlated, runs are not. One run says
    /// nothing.
    fn fit(measure: &str, points: impl Iterator<Item = (u32, Vec<f64>)>) -> Option<Self> {
        let is_positive = |error: &f64| *error > 0.0 && error.is_finite();
        let usable: Vec<_> = points.filter(|(_, errors)| errors.iter().all(is_positive)).collect();
        let last = usable.last()?.0;
        let fitted: Vec<_> = usable
            .iter()
            .filter(|(samples, _)| samples.saturating_mul(1 << OCTAVES) >= last)
            .collect();
        let from = fitted.first().filter(|(samples, _)| *samples < last)?.0;
        let point = |(samples, errors): &(u32, Vec<f64>), run: usize| {
            let spread: Estimate = errors.iter().map(|error| error.ln()).collect();
            [f64::from(*samples).ln(), errors[run].ln(), 1.0 / spread.variance().max(1e-6)]
        };
        let slopes: Vec<f64> = (0..fitted[0].1.len())
            .filter_map(|run| slope(&fitted.iter().map(|p| point(p, run)).collect::<Vec<_>>()))
            .collect();
        let estimate: Estimate = slopes.iter().copied().collect();
        (estimate.count() > 1).then(|| Self {
            measure: measure.to_owned(),
            from,
            to: last,
            value: Interval::of_mean(&slopes),
            standard_error: estimate.standard_error(),
        })
    }
}

impl TimeToTarget {
    /// The time to a target of relMSE, for each run. Where the variance is infinite, or there is a
    /// bias, the error does not fall as 1/t, and nothing is extrapolated.
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
        let falls = m.estimator == Estimator::Unbiased && !m.has_infinite_variance();
        if times.is_empty() || extrapolated && !falls {
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
