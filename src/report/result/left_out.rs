//! Omissions of integrators, and the decisions of those that adapt themselves.

use crate::integrator::{Candidate, Decision};
use crate::path::LeftOut;
use serde::{Deserialize, Serialize};

/// Something that the scene rules out for an integrator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Omission {
    /// The technique or path length.
    pub what: String,
    /// The reason.
    pub why: String,
}

/// An integrator that has no technique for the scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WithoutTechnique {
    /// The integrator's name.
    pub name: String,
    /// All techniques that it would have run, and why not.
    pub left_out: Vec<Omission>,
}

/// The decision of an integrator that adapts itself, before a run: [`Decision`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DecisionReport {
    /// The techniques that it ran.
    pub techniques: String,
    /// Samples of the pilot; 0 if there was no choice.
    pub pilot_samples: u64,
    /// Variance × cost of plain bidirectional path tracing over that of the choice, as the pilot
    /// predicts.
    #[serde(with = "crate::report::stats::number")]
    pub expected_gain: f64,
    /// The sets of techniques that it chose from, plain bidirectional path tracing last.
    pub candidates: Vec<CandidateReport>,
}

/// A set of techniques and the pilot's estimates for it: [`Candidate`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CandidateReport {
    /// The techniques.
    pub techniques: String,
    /// Variance of one sample of a pixel's luminance, mean over pixels.
    #[serde(with = "crate::report::stats::number")]
    pub variance: f64,
    /// Cost of one sample, in rays.
    #[serde(with = "crate::report::stats::number")]
    pub cost: f64,
    /// Samples that these are estimated from.
    pub samples: u64,
    /// True of the set that was run.
    pub chosen: bool,
}

pub(in crate::report) fn omissions(left_out: &LeftOut) -> Vec<Omission> {
    left_out.items().map(|(what, why)| Omission { what, why }).collect()
}

impl WithoutTechnique {
    pub(in crate::report) fn new(name: &str, left_out: &LeftOut) -> Self {
        Self { name: name.to_owned(), left_out: omissions(left_out) }
    }
}

impl From<&Decision> for DecisionReport {
    fn from(decision: &Decision) -> Self {
        let candidate = |candidate: &Candidate| CandidateReport {
            techniques: candidate.set.to_string(),
            variance: candidate.variance,
            cost: candidate.cost,
            samples: candidate.samples,
            chosen: candidate.set == decision.chosen.set,
        };
        Self {
            techniques: decision.chosen.set.to_string(),
            pilot_samples: decision.samples(),
            expected_gain: decision.expected_gain(),
            candidates: decision.candidates.iter().map(candidate).collect(),
        }
    }
}

impl Omission {
    /// All omissions in one line, or "nothing".
    #[must_use]
    pub fn sentence(left_out: &[Self]) -> String {
        let items: Vec<String> =
            left_out.iter().map(|o| format!("{}: {}", o.what, o.why)).collect();
        if items.is_empty() { "nothing".to_owned() } else { items.join("; ") }
    }
}
