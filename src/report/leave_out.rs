//! What integrators left out, and what those decided that adapt themselves; as plain data and as
//! CSV.

use super::result::Report;
use crate::integrator::{Decision, TechniqueRecord};
use crate::path::LeftOut;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Something that the scene rules out for an integrator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Omission {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}

/// An integrator that has no technique for the scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WithoutTechnique {
    /// Its name.
    pub name: String,
    /// What it would have run.
    pub left_out: Vec<Omission>,
}

/// What an integrator that adapts itself decided before a run: [`Decision`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DecisionReport {
    /// The techniques that it ran.
    pub techniques: String,
    /// Samples of the pilot; 0 if there was no choice.
    pub pilot_samples: u64,
    /// Sets of techniques that it chose from.
    pub candidates: usize,
    /// Share of the cost of plain bidirectional path tracing that its camera walks have.
    #[serde(with = "super::number")]
    pub camera_walks: f64,
    /// The same of its light walks.
    #[serde(with = "super::number")]
    pub light_walks: f64,
    /// Variance × cost of plain bidirectional path tracing over that of the choice, as the pilot
    /// predicts.
    #[serde(with = "super::number")]
    pub expected_gain: f64,
    /// The same with what the choice had when it was run.
    #[serde(with = "super::number")]
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
    /// Whether it was run.
    pub kept: bool,
}

pub(super) fn omissions(left_out: &LeftOut) -> Vec<Omission> {
    left_out.items().map(|(what, why)| Omission { what, why }).collect()
}

impl WithoutTechnique {
    pub(super) fn new(name: &str, left_out: &LeftOut) -> Self {
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

/// A text as a field (RFC 4180).
pub(super) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
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

impl Report {
    /// What was left out and why, as CSV: one line per integrator and omission.
    #[must_use]
    pub fn left_out_to_csv(&self) -> String {
        let mut csv = String::from("integrator,left_out,reason\n");
        let measured = self.methods.iter().map(|m| (&m.name, &m.left_out));
        let idle = self.left_out.iter().map(|m| (&m.name, &m.left_out));
        for (name, left_out) in measured.chain(idle) {
            for Omission { what, why } in left_out {
                let _ = writeln!(csv, "{},{},{}", quoted(name), quoted(what), quoted(why));
            }
        }
        csv
    }

    /// The decisions of integrators that adapt themselves, as CSV: one line per integrator, run and
    /// technique.
    #[must_use]
    pub fn decisions_to_csv(&self) -> String {
        let mut csv = String::from(
            "integrator,run,techniques,expected_gain,achieved_gain,s,t,energy,variance,cost,kept\n",
        );
        for method in &self.methods {
            for (run, decision) in method.decisions.iter().enumerate() {
                for share in &decision.shares {
                    let TechniqueDecision { s, t, energy, variance, cost, kept } = share;
                    let (name, techniques) = (quoted(&method.name), quoted(&decision.techniques));
                    let [expected, achieved] = [decision.expected_gain, decision.achieved_gain];
                    let _ = writeln!(
                        csv,
                        "{name},{run},{techniques},{expected},{achieved},{s},{t},{energy},{variance},{cost},{kept}"
                    );
                }
            }
        }
        csv
    }
}
