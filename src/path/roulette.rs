//! Russian roulette in the lecture's form: an estimator F is replaced by
//!
//! ```text
//! F' = (F - q c) / (1 - q)   with probability 1 - q,
//!      c                     with probability q,
//! ```
//!
//! which has the same mean for every q in [0, 1) and every constant c, and the variance `V/(1-q) + q/(1-q) (E[F] - c)²`. With c = 0 it is the
//! usual rule; c near the mean of F takes the added variance away.
//!
//! There is no cap on survival below 1: a walk that loses 1 % of its energy per bounce but is killed with 5 % has infinite variance.

use crate::bsdf::Walk;
use crate::math::Rgb;

/// The probability of survival 1 - q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Survival {
    /// min(1, largest component of the throughput relative to the walk's start).
    Throughput,
    /// The same at every vertex; must be above the square of the albedo, or the variance is infinite.
    Fixed(f64),
    /// Never terminate.
    Always,
}

/// When and how walks are terminated at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Number of scattering events before roulette starts.
    pub start: u32,
    /// The probability of survival.
    pub survival: Survival,
    /// The constant c, radiance. Only camera walks use it, whose remaining estimate F is the radiance that comes in along the walk; the remaining
    /// estimate of a light walk is an image.
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

impl Roulette {
    /// No roulette: walks end by absorption or by a limit on bounces only.
    pub const NEVER: Self = Self { start: u32::MAX, survival: Survival::Always, constant: Rgb::BLACK };

    /// Decides after the given number of scattering events; `relative` is the throughput relative to the start of the walk.
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
        if q > 0.0 { if xi() < q { Termination::Terminated } else { Termination::Survived { q } } } else { Termination::Continue }
    }

    /// The constant for a walk.
    #[inline]
    #[must_use]
    pub fn constant(&self, walk: Walk) -> Rgb {
        match walk {
            Walk::Camera => self.constant,
            Walk::Light => Rgb::BLACK,
        }
    }

    /// Applies roulette to a finished estimate: the lecture's formula itself.
    #[must_use]
    pub fn apply(q: f64, c: f64, xi: f64, estimate: impl FnOnce() -> f64) -> f64 {
        if xi < q { c } else { (estimate() - q * c) / (1.0 - q) }
    }
}
