//! The order of integrators by what the same error costs.

use super::interval::Interval;
use super::measured::{Cost, Measured};
use crate::math::statistics::Estimate;
use crate::math::student::student_t_p_value;
use serde::{Deserialize, Serialize};

/// The cost that integrators are ranked by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Price {
    /// Wall-clock time.
    Time,
    /// Rays, which do not depend on the machine.
    Rays,
}

/// The order of the integrators that draw every path, are unbiased, have a finite variance and have
/// met enough, by variance × cost: what the same error costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ranking {
    /// The cost.
    pub price: Price,
    /// The integrator for which it is the least.
    pub best: String,
    /// The others, in their order.
    pub others: Vec<Behind>,
}

/// An integrator beside the best one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Behind {
    /// Its name.
    pub name: String,
    /// Its cost of the same error over that of the best, with runs paired by seed.
    pub ratio: Interval,
    /// Two-sided p-value of the logarithm of the ratio (Student's t over the runs).
    #[serde(with = "super::number")]
    pub p_value: f64,
}

impl Ranking {
    /// The rankings by time and by rays; none without an integrator that can be ranked.
    pub(in crate::report) fn all(ranked: &[&Measured]) -> Vec<Self> {
        let by = |price, cost| Self::by(price, cost, ranked);
        by(Price::Time, |c| c.wall).into_iter().chain(by(Price::Rays, |c| c.rays)).collect()
    }

    fn by(price: Price, cost: fn(&Cost) -> f64, ranked: &[&Measured]) -> Option<Self> {
        let logarithms =
            |m: &&Measured| -> Vec<f64> { m.products(cost).into_iter().map(f64::ln).collect() };
        let mut all: Vec<(&str, Vec<f64>)> =
            ranked.iter().map(|m| (m.name.as_str(), logarithms(m))).collect();
        let mean =
            |(_, values): &(&str, Vec<f64>)| values.iter().copied().collect::<Estimate>().mean();
        all.retain(|entry| mean(entry).is_finite());
        all.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
        let (best, others) = all.split_first()?;
        let behind = |(name, values): &(&str, Vec<f64>)| {
            let ratios: Vec<f64> = values.iter().zip(&best.1).map(|(a, b)| a - b).collect();
            let log: Estimate = ratios.iter().copied().collect();
            let Interval { value, low, high } = Interval::of_mean(&ratios);
            let t = log.mean() / log.standard_error();
            Behind {
                name: (*name).to_owned(),
                ratio: Interval { value: value.exp(), low: low.exp(), high: high.exp() },
                p_value: if log.mean() == 0.0 {
                    1.0
                } else {
                    student_t_p_value(t, log.count() as f64 - 1.0)
                },
            }
        };
        Some(Self { price, best: best.0.to_owned(), others: others.iter().map(behind).collect() })
    }

    /// A lower bound of the confidence that the best is not worse than any other (Bonferroni).
    #[must_use]
    pub fn confidence(&self) -> f64 {
        let chances = self.others.iter().map(|other| 0.5 * other.p_value).sum::<f64>();
        (1.0 - chances).max(0.0)
    }
}
