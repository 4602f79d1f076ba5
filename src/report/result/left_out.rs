//! Omissions of integrators, and the decisions of those that adapt themselves.

use crate::integrator::{Decision, TechniqueRecord};
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
    /// Its name.
    pub name: String,
    /// All that it would have run.
    pub left_out: Vec<Omission>,
}

/// The decision of an integrator that adapts itself, before a run: [`Decision`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DecisionReport {
    /// The techniques that it ran.
    pub techniques: String,
    /// Samples of the pilot; 0 if there was no choice.
    pub pilot_samples: u64,
    /// Sets of techniques that it chose from.
    pub candidates: usize,
    /// Share of the cost of plain bidirectional path tracing that its camera walks have.
    #[serde(with = "crate::report::stats::number")]
    pub camera_walks: f64,
    /// The same of its light walks.
    #[serde(with = "crate::report::stats::number")]
    pub light_walks: f64,
    /// Variance × cost of plain bidirectional path tracing over that of the choice, as the pilot
    /// predicts.
    #[serde(with = "crate::report::stats::number")]
    pub expected_gain: f64,
    /// The same with what the choice had when it was run.
    #[serde(with = "crate::report::stats::number")]
    pub achieved_gain: f64,
    /// Shares of single techniques in plain bidirectional path tracing.
    pub shares: Vec<TechniqueDecision>,
}

/// Shares of a technique in plain bidirectional path tracing, and whether it was kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TechniqueDecision {
    /// Vertices from the light.
    pub s: u16,
    /// Vertices from the camera.
    pub t: u16,
    /// Share of the mean luminance, weighted.
    pub energy: f64,
    /// Share of the second moment of all techniques' weighted contributions.
    pub variance: f64,
    /// Share of the cost: of its connections, without the walks, which techniques share.
    pub cost: f64,
    /// True if it was run.
    pub kept: bool,
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
        let [camera_walks, light_walks] = decision.walk_costs;
        let share = |record: &TechniqueRecord| TechniqueDecision {
            s: record.technique.s,
            t: record.technique.t,
            energy: record.energy,
            variance: record.variance,
            cost: record.cost,
            kept: record.kept,
        };
        Self {
            techniques: decision.chosen.set.to_string(),
            pilot_samples: decision.samples,
            candidates: decision.candidates.len(),
            camera_walks,
            light_walks,
            expected_gain: decision.expected_gain(),
            achieved_gain: decision.achieved_gain(),
            shares: decision.techniques.iter().map(share).collect(),
        }
    }
}

impl Omission {
    /// All of them in one line, or "nothing".
    #[must_use]
    pub fn sentence(left_out: &[Self]) -> String {
        let items: Vec<String> =
            left_out.iter().map(|o| format!("{}: {}", o.what, o.why)).collect();
        if items.is_empty() { "nothing".to_owned() } else { items.join("; ") }
    }
}
