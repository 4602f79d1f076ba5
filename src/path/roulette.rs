//! Russian roulette (Arvo and Kirk 1990), with a constant as in Pharr, Jakob and Humphreys 2023,
//! section 2.2.4: an estimator F is replaced by
//!
//! ```text
//! F' = (F - q c) / (1 - q)   with probability 1 - q,
//!      c                     with probability q,
//! ```
//!
//! which has the same mean for every q in [0, 1) and every constant c, and the variance `V/(1-q) +
//! q/(1-q) (E[F] - c)²`. With c = 0 it is the usual rule; c near the mean of F takes the added
//! variance away.
//!
//! There is no cap on survival below 1: a walk that loses 1 % of its energy per bounce but is
//! killed with 5 % has infinite variance.

use crate::bsdf::TransportMode;
use crate::math::Rgb;
use std::ops::ControlFlow;

/// The probability of survival 1 - q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Survival {
    /// min(1, largest component of the throughput relative to the walk's start).
    Throughput,
    /// The same at every vertex; must be above the square of the albedo, or the variance is
    /// infinite.
    Fixed(f64),
    /// Never terminate.
    Always,
}

/// The rule by which walks are terminated at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Number of scattering events before roulette starts.
    pub start: u32,
    /// The probability of survival.
    pub survival: Survival,
    /// The constant c, radiance. Only camera walks use it, whose remaining estimate F is the
    /// radiance that comes in along the walk; the remaining estimate of a light walk is an image.
    pub constant: Rgb,
}

impl Default for Roulette {
    fn default() -> Self {
        Self { start: 3, survival: Survival::Throughput, constant: Rgb::BLACK }
    }
}

/// The outcome of one decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Termination {
    /// No roulette was played: q = 0.
    Continue,
    /// Survived; F becomes `(F - q c)/(1 - q)`.
    Survived {
        /// Probability of termination.
        q: f64,
    },
    /// F becomes c.
    Terminated,
}

/// The outcome of a scattering event and of the roulette behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// True if the walk goes on.
    pub goes_on: bool,
    /// The part of the constant c in the estimate: c times the throughput before roulette, times
    /// `-q / (1 - q)` if the walk survived.
    pub constant: Rgb,
    /// Probability 1 - q of surviving, if it did.
    pub survival: f64,
}

impl Scattered {
    /// The walk goes on.
    pub const ON: Self = Self { goes_on: true, constant: Rgb::BLACK, survival: 1.0 };
    /// The walk ends.
    pub const ENDED: Self = Self { goes_on: false, ..Self::ON };

    /// The decision in the form that [`Steps::scatter`](super::Steps::scatter) returns.
    #[inline]
    pub fn flow(&self) -> ControlFlow<()> {
        if self.goes_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

impl Roulette {
    /// No roulette: walks end by absorption or by a limit on bounces only.
    pub const NEVER: Self =
        Self { start: u32::MAX, survival: Survival::Always, constant: Rgb::BLACK };

    /// Decides after the given number of scattering events; `relative` is the throughput relative
    /// to the start of the walk.
    #[inline]
    pub fn decide(&self, bounces: u32, relative: f64, xi: impl FnOnce() -> f64) -> Termination {
        if bounces <= self.start {
            return Termination::Continue;
        }
        let q = match self.survival {
            Survival::Throughput => 1.0 - relative,
            Survival::Fixed(survival) => 1.0 - survival,
            Survival::Always => return Termination::Continue,
        };
        if q > 0.0 {
            if xi() < q { Termination::Terminated } else { Termination::Survived { q } }
        } else {
            Termination::Continue
        }
    }

    /// Plays after the given number of scattering events: decides whether a walk goes on, and
    /// divides its throughput by the probability of that.
    #[inline(always)]
    pub fn play(
        &self,
        mode: TransportMode,
        bounces: u32,
        relative: f64,
        throughput: &mut Rgb,
        xi: impl FnOnce() -> f64,
    ) -> Scattered {
        // ANCHOR: play
        let constant = self.constant(mode) * *throughput;
        match self.decide(bounces, relative, xi) {
            Termination::Continue => Scattered::ON,
            Termination::Survived { q } => {
                *throughput = *throughput / (1.0 - q);
                let constant = constant * (-q / (1.0 - q));
                Scattered { goes_on: true, constant, survival: 1.0 - q }
            }
            Termination::Terminated => Scattered { constant, ..Scattered::ENDED },
        }
        // ANCHOR_END: play
    }

    /// The same rule with c = 0.
    #[must_use]
    pub const fn without_constant(self) -> Self {
        Self { constant: Rgb::BLACK, ..self }
    }

    /// The constant for a walk in a transport mode.
    #[inline]
    #[must_use]
    pub fn constant(&self, mode: TransportMode) -> Rgb {
        match mode {
            TransportMode::Radiance => self.constant,
            TransportMode::Importance => Rgb::BLACK,
        }
    }

    // ANCHOR: apply
    /// A finished estimate after roulette: the formula of [this module](self), literally.
    #[must_use]
    pub fn apply(q: f64, c: f64, xi: f64, estimate: impl FnOnce() -> f64) -> f64 {
        if xi < q { c } else { (estimate() - q * c) / (1.0 - q) }
    }
    // ANCHOR_END: apply
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean stays, and the variance is V/(1-q) + q/(1-q) (E - c)².
    #[test]
    fn roulette_keeps_the_mean_and_has_the_exact_variance() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let (q, mean, variance) = (0.4, 0.5, 0.04f64);
        let half_width = (3.0 * variance).sqrt();
        for (c, expected) in [
            (0.3, 0.093_333_333_333_333_34),
            (0.0, 0.233_333_333_333_333_34),
            (0.5, 0.066_666_666_666_666_67),
        ] {
            let n = 1_000_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..n {
                let (xi, u) = (rng.random::<f64>(), rng.random::<f64>());
                let value = Roulette::apply(q, c, xi, || mean + half_width * (2.0 * u - 1.0));
                sum += value;
                squares += value * value;
            }
            let measured_mean = sum / f64::from(n);
            let measured_variance = squares / f64::from(n) - measured_mean * measured_mean;
            let standard_error = (expected / f64::from(n)).sqrt();
            assert!(
                (measured_mean - mean).abs() < 4.0 * standard_error,
                "c = {c}: {measured_mean}"
            );
            assert!(
                (measured_variance / expected - 1.0).abs() < 0.01,
                "c = {c}: {measured_variance}"
            );
        }
    }

    #[test]
    fn survival_has_no_cap_below_one() {
        let roulette = Roulette { start: 0, ..Roulette::default() };
        assert_eq!(roulette.decide(1, 1.0, || 0.0), Termination::Continue);
        assert_eq!(roulette.decide(1, 2.0, || 0.0), Termination::Continue);
        assert_eq!(roulette.decide(1, 0.75, || 0.3), Termination::Survived { q: 0.25 });
        assert_eq!(roulette.decide(1, 0.75, || 0.2), Termination::Terminated);
        assert_eq!(Roulette::NEVER.decide(10_000, 0.0, || 0.0), Termination::Continue);
    }
}
