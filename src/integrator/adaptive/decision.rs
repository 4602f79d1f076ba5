//! The record of a decision of [`Adaptive`](super::Adaptive), and of the estimates behind it.

use crate::path::{LeftOut, TechniqueSet};
use std::fmt;

/// The choice of a set of techniques. Its [`Display`](fmt::Display) is a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The techniques that the scene rules out.
    pub left_out: LeftOut,
    /// The sets that draw every path; plain bidirectional path tracing is the last one.
    pub candidates: Vec<Candidate>,
    /// The one that is run.
    pub chosen: Candidate,
}

/// A set of techniques and what the pilot says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The techniques and the number of light subpaths.
    pub set: TechniqueSet,
    /// Variance of one sample of a pixel's luminance, mean over pixels; not a number if there was
    /// no choice.
    pub variance: f64,
    /// Cost of one sample; see [`Counters::cost`](crate::path::Counters::cost).
    pub cost: f64,
    /// Samples that these are estimated from.
    pub samples: u64,
}

impl Candidate {
    // ANCHOR: work
    /// Variance × cost: the smaller the better.
    #[must_use]
    pub fn work(&self) -> f64 {
        self.variance * self.cost
    }
    // ANCHOR_END: work
}

impl Decision {
    /// Samples of the pilot; 0 if there was no choice.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.candidates.iter().map(|candidate| candidate.samples).sum()
    }

    /// Plain bidirectional path tracing, as the pilot estimates it.
    #[must_use]
    pub fn plain(&self) -> Candidate {
        self.candidates.last().copied().unwrap_or(self.chosen)
    }

    /// Variance × cost of plain bidirectional path tracing over that of the choice; 1 if there was
    /// no choice, not a number if neither has noise.
    #[must_use]
    pub fn expected_gain(&self) -> f64 {
        if self.samples() > 0 { self.plain().work() / self.chosen.work() } else { 1.0 }
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "the scene rules out: {}\nrun: {}", self.left_out, self.chosen.set)?;
        if self.samples() == 0 {
            return write!(f, "no other set of techniques draws every path");
        }
        let (sets, gain) = (self.candidates.len(), self.expected_gain());
        writeln!(f, "pilot: {} samples, {sets} sets", self.samples())?;
        writeln!(f, "gain over plain bidirectional: expected {gain:.2}")?;
        write!(f, "{:>10} {:>8} {:>8}  techniques", "variance", "cost", "samples")?;
        for Candidate { set, variance, cost, samples } in &self.candidates {
            write!(f, "\n{variance:>10.3e} {cost:>8.2} {samples:>8}  {set}")?;
        }
        Ok(())
    }
}
