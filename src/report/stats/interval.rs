//! Confidence intervals from few independent runs.

use crate::math::statistics::Estimate;
use crate::math::student::half_width;
use serde::{Deserialize, Serialize};

/// Probability that an interval contains the true value.
pub const CONFIDENCE: f64 = 0.95;

/// A number and the interval that contains the true one with probability [`CONFIDENCE`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The estimate.
    #[serde(with = "super::number")]
    pub value: f64,
    /// Lower end.
    #[serde(with = "super::number")]
    pub low: f64,
    /// Upper end.
    #[serde(with = "super::number")]
    pub high: f64,
}

impl Interval {
    /// t-interval of a mean over independent runs; unbounded for a single one, NaN without any.
    #[must_use]
    pub fn of_mean(values: &[f64]) -> Self {
        let estimate: Estimate = values.iter().copied().collect();
        let mean = if values.is_empty() { f64::NAN } else { estimate.mean() };
        let half = half_width(&estimate, CONFIDENCE);
        Self { value: mean, low: mean - half, high: mean + half }
    }

    /// The arithmetic mean of positive values that scatter by a factor, with a t-interval of the
    /// mean of logarithms around it. Errors, times and their products are of this kind. Values that
    /// are not positive give the interval of [`of_mean`](Self::of_mean).
    #[must_use]
    pub fn of_positive(values: &[f64]) -> Self {
        if values.is_empty() || values.iter().any(|v| !(v.is_finite() && *v > 0.0)) {
            return Self::of_mean(values);
        }
        let value = values.iter().sum::<f64>() / values.len() as f64;
        let logarithms: Estimate = values.iter().map(|v| v.ln()).collect();
        let factor = half_width(&logarithms, CONFIDENCE).exp();
        Self { value, low: value / factor, high: value * factor }
    }

    /// Geometric mean of positive ratios with the t-interval of their logarithms: for paired
    /// comparisons.
    #[must_use]
    pub fn of_ratios(ratios: &[f64]) -> Option<Self> {
        if ratios.is_empty() || ratios.iter().any(|v| !(v.is_finite() && *v > 0.0)) {
            return None;
        }
        let log = Self::of_mean(&ratios.iter().map(|r| r.ln()).collect::<Vec<_>>());
        Some(Self { value: log.value.exp(), low: log.low.exp(), high: log.high.exp() })
    }

    /// True if a value is inside.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn intervals_cover_as_often_as_they_say() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        let mut covered = 0;
        for _ in 0..2000 {
            let values: Vec<f64> =
                (0..8).map(|_| (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0).collect();
            covered += u32::from(Interval::of_mean(&values).contains(0.0));
        }
        // Binomial with 2000 trials: a standard deviation is 10.
        assert!((1860..=1940).contains(&covered), "{covered}");
        let single = Interval::of_positive(&[2.0]);
        assert_eq!((single.value, single.low, single.high), (2.0, 0.0, f64::INFINITY));
    }
}
