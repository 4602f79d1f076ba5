//! What few independent runs say: confidence intervals, slopes, times, tails.

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
    /// t-interval of a mean over independent runs; unbounded for a single one.
    #[must_use]
    pub fn of_mean(values: &[f64]) -> Self {
        let estimate: Estimate = values.iter().copied().collect();
        let half = half_width(&estimate, CONFIDENCE);
        Self { value: estimate.mean(), low: estimate.mean() - half, high: estimate.mean() + half }
    }

    /// For positive values that scatter by a factor: the arithmetic mean, with a t-interval of the
    /// mean of logarithms around it. Errors, times and their products are of this kind. Values that
    /// are not positive give the interval of [`of_mean`](Self::of_mean).
    #[must_use]
    pub fn of_positive(values: &[f64]) -> Self {
        if values.iter().any(|v| !(v.is_finite() && *v > 0.0)) {
            return Self::of_mean(values);
        }
        let value = values.iter().sum::<f64>() / values.len().max(1) as f64;
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

    /// Whether a value is inside.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

/// Weighted least-squares slope of y over x (points `[x, y, weight]`); `None` without two different
/// x.
#[must_use]
pub fn slope(points: &[[f64; 3]]) -> Option<f64> {
    let weight: f64 = points.iter().map(|p| p[2]).sum();
    let mean = |k: usize| points.iter().map(|p| p[2] * p[k]).sum::<f64>() / weight;
    let (x, y) = (mean(0), mean(1));
    let xx: f64 = points.iter().map(|p| p[2] * (p[0] - x).powi(2)).sum();
    let xy: f64 = points.iter().map(|p| p[2] * (p[0] - x) * (p[1] - y)).sum();
    let slope = xy / xx;
    (xx > 0.0 && slope.is_finite()).then_some(slope)
}

/// When a curve of (time, error) comes down to `target` to stay there: the crossing after which no
/// point is above it, by interpolation in log-log. `Err` if its last point is above, with the time
/// at which it would get there if it went on falling as 1/t.
#[must_use = "says when the error is reached"]
pub fn time_to_error(curve: &[(f64, f64)], target: f64) -> Result<f64, Option<f64>> {
    let Some(above) = curve.iter().rposition(|(_, error)| error.is_nan() || *error > target) else {
        return curve.first().map(|(time, _)| *time).ok_or(None);
    };
    let (before, error) = curve[above];
    match curve.get(above + 1) {
        // An error from which that of the reference was subtracted may be negative, and one of an
        // image with a NaN is infinite.
        Some(&(time, reached)) if reached > 0.0 && error.is_finite() && before > 0.0 => {
            let part = (error / target).ln() / (error / reached).ln();
            Ok(before * (time / before).powf(part))
        }
        Some((time, _)) => Ok(*time),
        None => Err(Some(before * error / target).filter(|time| time.is_finite())),
    }
}

/// How heavy a tail is: P(X > x) ~ x^(-index).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tail {
    /// Hill's estimate; infinite if the largest values are all equal.
    #[serde(with = "super::number")]
    pub index: f64,
    /// Its standard error, index / √k.
    #[serde(with = "super::number")]
    pub standard_error: f64,
    /// k: the number of largest values it comes from.
    pub count: u64,
    /// The estimate from the largest quarter of these. A power law has the same index there; a
    /// range that is wide but bounded has a larger one.
    #[serde(with = "super::number")]
    pub extreme_index: f64,
}

impl Tail {
    /// Below this index the variance is taken for infinite. Hill's estimate comes from finite
    /// samples and is biased upwards, so the limit is above 2.
    pub const INFINITE_VARIANCE: f64 = 2.2;
    /// Fewer values than this say nothing.
    const FEWEST: usize = 32;

    /// Hill's estimate (1975) `k / Σ ln(x_i / x_{k+1})` from values in descending order; the last
    /// of them is x_{k+1}. `None` if there are too few.
    #[must_use]
    pub fn hill(descending: &[f64]) -> Option<Self> {
        let (&threshold, largest) = descending.split_last()?;
        if largest.len() < Self::FEWEST || threshold.is_nan() || threshold <= 0.0 {
            return None;
        }
        let index = |largest: &[f64], threshold: f64| {
            // Values that are equal but for rounding have no tail.
            let sum: f64 = largest.iter().map(|x| (x / threshold).ln()).filter(|l| *l > 1e-9).sum();
            // An empty sum is -0.
            largest.len() as f64 / sum.abs()
        };
        let quarter = largest.len() / 4;
        let (all, extreme_index) =
            (index(largest, threshold), index(&largest[..quarter], largest[quarter]));
        let standard_error = all / (largest.len() as f64).sqrt();
        Some(Self { index: all, standard_error, count: largest.len() as u64, extreme_index })
    }

    /// Whether the variance of a sum of such values is infinite, as far as the sample shows: the
    /// index says so, and so does that of the largest quarter within its standard error.
    #[must_use]
    pub fn is_infinite_variance(&self) -> bool {
        let lowest = self.extreme_index * (1.0 - 2.0 / (self.count as f64).sqrt());
        self.index < Self::INFINITE_VARIANCE && lowest < Self::INFINITE_VARIANCE
    }
}

/// Keeps the largest of many numbers.
#[derive(Clone, Debug)]
pub struct Largest {
    /// A heap whose root is the smallest; numbers are positive, so their bits are ordered as they
    /// are.
    heap: std::collections::BinaryHeap<std::cmp::Reverse<u64>>,
    capacity: usize,
    seen: u64,
}

impl Largest {
    /// Keeps up to `capacity` numbers.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self { heap: std::collections::BinaryHeap::with_capacity(capacity + 1), capacity, seen: 0 }
    }

    /// Takes a positive number; others are ignored.
    pub fn push(&mut self, x: f64) {
        if !(x > 0.0 && x.is_finite()) {
            return;
        }
        self.seen += 1;
        let bits = std::cmp::Reverse(x.to_bits());
        if self.heap.len() < self.capacity {
            self.heap.push(bits);
        } else if let Some(mut smallest) = self.heap.peek_mut()
            && bits.0 > smallest.0
        {
            *smallest = bits;
        }
    }

    /// The tail of the largest 0.1 % of the numbers, at least 64 of them and at most as many as are
    /// kept. `None` if that were more than 1 % of the numbers: so few say nothing of the tail.
    #[must_use]
    pub fn tail(&self) -> Option<Tail> {
        let mut values: Vec<f64> = self.heap.iter().map(|bits| f64::from_bits(bits.0)).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        let count = (self.seen / 1000).max(64);
        if count * 100 > self.seen {
            return None;
        }
        let count = usize::try_from(count).unwrap_or(usize::MAX - 1);
        Tail::hill(&values[..values.len().min(count + 1)])
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

    #[test]
    fn slope_of_a_power_law() {
        let points: Vec<[f64; 3]> =
            (1..6).map(|i| [f64::from(i), 3.0 - 0.75 * f64::from(i), f64::from(i)]).collect();
        assert!((slope(&points).unwrap() + 0.75).abs() < 1e-12);
        assert!(slope(&points[..1]).is_none());
    }

    #[test]
    fn time_to_an_error() {
        let curve = [(1.0, 1.0), (2.0, 0.5), (4.0, 0.25)];
        assert!((time_to_error(&curve, 0.4).unwrap() - 2.5).abs() < 1e-12);
        assert!((time_to_error(&curve, 0.1).unwrap_err().unwrap() - 10.0).abs() < 1e-12);
        assert_eq!(time_to_error(&curve, 2.0), Ok(1.0));
        assert_eq!(time_to_error(&[], 2.0), Err(None));
        // A curve that rises again has not reached it before.
        assert!(
            (time_to_error(&[(1.0, 0.1), (2.0, 1.0), (4.0, 0.25)], 0.5).unwrap() - 8f64.sqrt())
                .abs()
                < 1e-12
        );
        assert_eq!(time_to_error(&[(1.0, 1.0), (2.0, -0.1)], 0.5), Ok(2.0));
        assert_eq!(time_to_error(&[(1.0, f64::INFINITY), (2.0, 0.1)], 0.5), Ok(2.0));
        assert_eq!(time_to_error(&[(1.0, 0.1), (2.0, f64::INFINITY)], 0.5), Err(None));
    }

    #[test]
    fn hill_finds_the_index_of_a_power_law() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        for index in [1.5, 3.0] {
            let mut largest = Largest::new(4096);
            (0..1_000_000)
                .for_each(|_| largest.push((1.0 - rng.random::<f64>()).powf(-1.0 / index)));
            let tail = largest.tail().unwrap();
            assert_eq!(tail.count, 1000);
            assert!((tail.index - index).abs() < 4.0 * tail.standard_error, "{tail:?}");
            assert!((tail.extreme_index - index).abs() < 8.0 * tail.standard_error, "{tail:?}");
            assert_eq!(tail.is_infinite_variance(), index < 2.0);
        }
        // A power law up to a bound that is reached: 1 in a thousand is above 1000^(1/1.5) = 100.
        let mut bounded = Largest::new(4096);
        (0..1_000_000)
            .for_each(|_| bounded.push((1.0 - rng.random::<f64>()).powf(-1.0 / 1.5).min(300.0)));
        let tail = bounded.tail().unwrap();
        assert!(
            tail.index < 2.2 && tail.extreme_index > 4.0 && !tail.is_infinite_variance(),
            "{tail:?}"
        );
        let mut equal = Largest::new(100);
        (0..10_000).for_each(|_| equal.push(3.0));
        assert_eq!(equal.tail().unwrap().index, f64::INFINITY);
        assert!(Largest::new(10).tail().is_none());
    }
}
