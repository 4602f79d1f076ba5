//! Tests of whether an integrator's mean is that of the reference.

use super::batches::BatchMean;
use super::evidence::Undecided;
use super::interval::{CONFIDENCE, Interval};
use super::measured::Measured;
use super::reference::Reference;
use crate::math::student::{student_t_p_value, student_t_quantile};
use serde::{Deserialize, Serialize};

/// Probability that any integrator without bias is flagged.
pub const BIAS_SIGNIFICANCE: f64 = 0.01;

/// Bias: the difference of an integrator's mean from the reference's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// Mean luminance minus that of the reference.
    pub mean: f64,
    /// Its standard error, that of the reference included.
    #[serde(with = "super::number")]
    pub mean_standard_error: f64,
    /// Its interval (Welch 1947).
    pub mean_interval: Interval,
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
    /// True if one of the two is significant and the integrator claims to see every path, and to be
    /// unbiased; false if it or the reference has met too little to tell ([`Undecided`]).
    pub flagged: bool,
}

impl Bias {
    /// Two tests of the luminance of batches: of sums over blocks with the first weights (the
    /// mean), and with the second (the relative bias). Flagged is what has a p-value below `limit`.
    pub(in crate::report) fn test(
        m: &Measured,
        reference: &Reference,
        weights: &[Vec<f64>; 2],
        limit: f64,
    ) -> Self {
        let [(mean, mean_p), (relative, relative_p)] = [0, 1].map(|i| {
            let (measured, expected) =
                (BatchMean::of_sum(&m.batches, &weights[i]), reference.block_sum(&weights[i]));
            let difference = measured.plus(expected, -1.0);
            let error = difference.standard_error();
            // Equal but for rounding.
            let negligible = difference.mean.abs() <= 1e-9 * expected.mean.abs();
            let p = if negligible || error.is_infinite() {
                1.0
            } else {
                student_t_p_value(difference.mean / error, difference.freedom)
            };
            (difference, p)
        });
        // Whoever missed rare, bright contributions is too dark and believes too small an error; so
        // may a rendered reference.
        let no_mean = m.has_open_mean();
        let pixels = reference.image().pixels().len();
        let of_relative = Undecided::of_sum(&m.batches, &weights[1], pixels).is_none();
        let heavy = no_mean || m.has_long_tails() || m.has_infinite_variance();
        let is_off = |bias: f64, p: f64, noisy: bool| {
            p < limit && !(noisy && (bias < 0.0 || !reference.is_exact()))
        };
        let half = student_t_quantile(1.0 - CONFIDENCE, mean.freedom) * mean.standard_error();
        Self {
            mean: mean.mean,
            mean_standard_error: mean.standard_error(),
            mean_interval: Interval {
                value: mean.mean,
                low: mean.mean - half,
                high: mean.mean + half,
            },
            mean_p_value: mean_p,
            relative: relative.mean,
            relative_standard_error: relative.standard_error(),
            relative_p_value: relative_p,
            flagged: m.is_tested()
                && m.undecided().is_none()
                && reference.undecided().is_none()
                && (is_off(mean.mean, mean_p, no_mean)
                    || (of_relative && is_off(relative.mean, relative_p, heavy))),
        }
    }
}
