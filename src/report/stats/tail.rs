//! The tail index of a distribution, from its largest samples.

use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The heaviness of a tail: P(X > x) ~ x^(-index).
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

    /// True if the variance of a sum of such values is infinite, as far as the sample shows: the
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
    heap: BinaryHeap<Reverse<u64>>,
    capacity: usize,
    seen: u64,
}

impl Largest {
    /// Keeps up to `capacity` numbers.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self { heap: BinaryHeap::with_capacity(capacity + 1), capacity, seen: 0 }
    }

    /// Takes a positive number; others are ignored.
    pub fn push(&mut self, x: f64) {
        if !(x > 0.0 && x.is_finite()) {
            return;
        }
        self.seen += 1;
        let bits = Reverse(x.to_bits());
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
