//! Evidence: whether an estimate has met enough for its spread to tell its error.
//!
//! The mean of rare, positive contributions x has the relative variance Σx²/(Σx)². Its inverse is
//! their *effective number*: so many of equal size would have it. Batches tell it as mean² over the
//! variance of the mean, whatever the contributions are. Where it is small, mean and variance go
//! together: who has met too little is too dark and believes too small an error. From 64 on, that
//! is a relative standard error of 1/8, a test at the level of 10⁻⁴ that an estimate is too dark or
//! too bright is wrong with a probability below 4 · 10⁻⁴ for contributions of equal or
//! exponentially distributed size; with 10 it would be 4 · 10⁻³.

use super::batches::{Batch, BatchMean};
use std::fmt;

/// The effective number of contributions from which an estimate is evidence.
pub const FEWEST_CONTRIBUTIONS: f64 = 64.0;

/// Batch means are known to this part of the largest.
const ROUNDING: f64 = 1e-9;

/// The reason for which an estimate is no evidence, neither for agreement nor against it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Undecided {
    /// It has contributed nothing in so many samples.
    Nothing {
        /// Samples of all runs and pixels.
        samples: f64,
    },
    /// It rests on fewer than [`FEWEST_CONTRIBUTIONS`].
    Few {
        /// Their effective number.
        contributions: f64,
    },
    /// It comes from a single batch, which has no spread.
    OneBatch,
}

impl Undecided {
    /// The reason why a weighted sum over the blocks of batches is no evidence; `None` if it is.
    #[must_use]
    pub fn of_sum(batches: &[Batch], weights: &[f64], pixels: usize) -> Option<Self> {
        if batches.iter().all(|batch| batch.sum(weights) == 0.0) {
            let samples = batches.iter().map(|batch| batch.samples).sum::<f64>() * pixels as f64;
            return Some(Self::Nothing { samples });
        }
        let values = batches.iter().flat_map(|batch| batch.blocks.iter().copied());
        Self::of(&BatchMean::of_sum(batches, weights), values)
    }

    /// The same of a mean that is not zero, given the values that it is made of.
    pub(super) fn of(mean: &BatchMean, values: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        // Where contributions are negative, too, a sum may be small however many there are. Batches
        // are differences, which may round below zero.
        let largest = values.clone().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        if values.clone().any(|value| value < -ROUNDING * largest) {
            return None;
        }
        let contributions = mean.effective_contributions();
        if mean.variance.is_infinite() {
            Some(Self::OneBatch)
        } else {
            (contributions < FEWEST_CONTRIBUTIONS).then_some(Self::Few { contributions })
        }
    }
}

impl BatchMean {
    /// The effective number of contributions, mean² over the variance of the mean; infinite without
    /// any spread.
    #[must_use]
    pub fn effective_contributions(&self) -> f64 {
        if self.mean == 0.0 { 0.0 } else { self.mean.powi(2) / self.variance }
    }
}

impl fmt::Display for Undecided {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing { samples } => write!(f, "contributed nothing in {samples:.0} samples"),
            Self::Few { contributions } => write!(
                f,
                "rests on some {:.0} contributions, of which at least {FEWEST_CONTRIBUTIONS} tell \
                 an error",
                contributions.ceil()
            ),
            Self::OneBatch => f.write_str("has a single batch, whose error is not known"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::student::student_t_p_value;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    const BATCHES: usize = 32;

    fn batches(values: &[f64]) -> Vec<Batch> {
        values.iter().map(|value| Batch { samples: 4.0, blocks: vec![*value, 0.0] }).collect()
    }

    /// Batches of n contributions of exponentially distributed size in all, Poisson distributed.
    fn rare(n: f64, rng: &mut Pcg64) -> Vec<Batch> {
        let mut exponential = || -(1.0 - rng.random::<f64>()).ln();
        let values: Vec<f64> = (0..BATCHES)
            .map(|_| {
                let (mut sum, mut time) = (0.0, exponential());
                while time < n / BATCHES as f64 {
                    (sum, time) = (sum + exponential(), time + exponential());
                }
                sum
            })
            .collect();
        batches(&values)
    }

    #[test]
    fn the_effective_number_is_that_of_contributions_of_equal_size() {
        let mut values = [0.0; BATCHES];
        assert_eq!(
            Undecided::of_sum(&batches(&values), &[0.5; 2], 100),
            Some(Undecided::Nothing { samples: 12_800.0 })
        );
        values[3..13].fill(2.0);
        match Undecided::of_sum(&batches(&values), &[0.5; 2], 100) {
            // The variance within batches is not there to be seen.
            Some(Undecided::Few { contributions }) => {
                assert!((contributions / 10.0 - 31.0 / 22.0).abs() < 1e-9, "{contributions}");
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(Undecided::of_sum(&batches(&[1.0; BATCHES]), &[0.5; 2], 1), None);
        assert_eq!(Undecided::of_sum(&batches(&[1.0]), &[0.5; 2], 1), Some(Undecided::OneBatch));
        values[0] = -20.0;
        assert_eq!(Undecided::of_sum(&batches(&values), &[0.5; 2], 1), None);
    }

    /// Tests of estimates that count as evidence are wrong about as often as they say, and those of
    /// the others are not.
    #[test]
    fn evidence_is_what_tells_its_error() {
        const STUDIES: u32 = 40_000;
        let mut rng = Pcg64::seed_from_u64(7);
        let mut wrong = [0; 2];
        for n in [10.0, 30.0, 60.0, 80.0, 100.0, 150.0] {
            let mut of_n = [0; 2];
            for _ in 0..STUDIES {
                let batches = rare(n, &mut rng);
                let mean = BatchMean::of_sum(&batches, &[1.0, 0.0]);
                let t = (mean.mean - n / BATCHES as f64) / mean.standard_error();
                let is_off = student_t_p_value(t, mean.freedom) < 1e-3;
                let index = usize::from(Undecided::of_sum(&batches, &[1.0, 0.0], 1).is_none());
                of_n[index] += u32::from(is_off);
            }
            wrong = [wrong[0].max(of_n[0]), wrong[1].max(of_n[1])];
        }
        let rates = wrong.map(|count| f64::from(count) / f64::from(STUDIES));
        println!("{rates:?}");
        assert!(rates[0] > 0.02 && rates[1] < 0.004, "{rates:?}");
    }
}
