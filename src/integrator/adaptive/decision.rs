//! The record of what [`Adaptive`](super::Adaptive) decided, and of what it saw.

use super::findings::{Candidate, Findings, MOST_BOUNCES, share_index};
use crate::film::Technique;
use crate::path::{LeftOut, TechniqueSet};
use std::fmt;

/// What was decided, and why. Its [`Display`](fmt::Display) is a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// What the scene rules out.
    pub left_out: LeftOut,
    /// Samples of the pilot; 0 if there was no choice.
    pub samples: u64,
    /// Shares of the cost of plain bidirectional path tracing that its camera walks and its light
    /// walks have.
    pub walk_costs: [f64; 2],
    /// Single techniques as plain bidirectional path tracing runs them, by path length and then s;
    /// those of long paths are not told apart.
    pub techniques: Vec<TechniqueRecord>,
    /// The sets that draw every path, plain bidirectional path tracing last.
    pub candidates: Vec<Candidate>,
    /// The one that is run.
    pub chosen: Candidate,
    /// Its variance and cost by running it.
    pub achieved: Option<Candidate>,
}

/// One technique.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TechniqueRecord {
    /// Which one.
    pub technique: Technique,
    /// Share of the mean luminance, weighted.
    pub energy: f64,
    /// Share of the second moment of all techniques' weighted contributions.
    pub variance: f64,
    /// Share of the cost: of its connections, without the walks, which techniques share.
    pub cost: f64,
    /// Whether it is run.
    pub kept: bool,
}

impl Decision {
    pub(super) fn only(set: TechniqueSet, left_out: LeftOut) -> Self {
        let chosen = Candidate { set, variance: f64::NAN, cost: f64::NAN };
        Self {
            left_out,
            samples: 0,
            walk_costs: [f64::NAN; 2],
            techniques: Vec::new(),
            candidates: vec![chosen],
            chosen,
            achieved: None,
        }
    }

    pub(super) fn measured(
        findings: &Findings,
        candidates: Vec<Candidate>,
        chosen: Candidate,
        achieved: Candidate,
        left_out: LeftOut,
    ) -> Self {
        let plain = candidates.last().copied().unwrap_or(chosen);
        let [energy, square] = findings
            .shares
            .iter()
            .fold([0.0; 2], |sum, share| [sum[0] + share.energy, sum[1] + share.square]);
        let part = |x: f64, of: f64| if of > 0.0 { x / of } else { 0.0 };
        let record = |technique| {
            let share = findings.shares.get(share_index(technique)?)?;
            Some(TechniqueRecord {
                technique,
                energy: part(share.energy, energy),
                variance: part(share.square, square),
                cost: part(share.cost / findings.samples.max(1) as f64, plain.cost),
                kept: chosen.set.contains(technique),
            })
        };
        let all = (0..=MOST_BOUNCES).flat_map(|bounces| {
            (0..=bounces + 1).map(move |s| Technique { s, t: bounces + 2 - s })
        });
        Self {
            left_out,
            samples: findings.samples,
            walk_costs: findings.walk_costs().map(|cost| part(cost, plain.cost)),
            techniques: all.filter(|t| plain.set.contains(*t)).filter_map(record).collect(),
            candidates,
            chosen,
            achieved: Some(achieved),
        }
    }

    /// Plain bidirectional path tracing, as the pilot estimates it.
    #[must_use]
    pub fn plain(&self) -> Candidate {
        self.candidates.last().copied().unwrap_or(self.chosen)
    }

    /// Variance × cost of plain bidirectional path tracing over that of the choice, as the pilot
    /// predicts; 1 if there was no choice, not a number if neither has noise.
    #[must_use]
    pub fn expected_gain(&self) -> f64 {
        if self.achieved.is_some() { self.plain().work() / self.chosen.work() } else { 1.0 }
    }

    /// The same with the variance and cost that the choice had when it was run, on as many samples
    /// as the pilot's.
    #[must_use]
    pub fn achieved_gain(&self) -> f64 {
        self.achieved.map_or(1.0, |achieved| self.plain().work() / achieved.work())
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "the scene rules out: {}", self.left_out)?;
        writeln!(f, "run: {}", self.chosen.set)?;
        if self.achieved.is_none() {
            return write!(f, "no other set of techniques draws every path");
        }
        let [camera, light] = self.walk_costs.map(|share| 100.0 * share);
        writeln!(
            f,
            "pilot: {} samples, {} sets; camera walks are {camera:.1} % of the cost, light walks {light:.1} %",
            self.samples,
            self.candidates.len()
        )?;
        writeln!(
            f,
            "gain over plain bidirectional: expected {:.2}, achieved {:.2}",
            self.expected_gain(),
            self.achieved_gain()
        )?;
        write!(f, "{:>8} {:>9} {:>9} {:>9}", "(s, t)", "energy", "variance", "cost")?;
        for record in
            self.techniques.iter().filter(|record| record.energy > 0.0005 || record.cost > 0.0005)
        {
            let Technique { s, t } = record.technique;
            let percent = |x: f64| format!("{:.1} %", 100.0 * x);
            let verdict = if record.kept { "kept" } else { "left out" };
            let (energy, variance, cost) =
                (percent(record.energy), percent(record.variance), percent(record.cost));
            write!(
                f,
                "\n{:>8} {energy:>9} {variance:>9} {cost:>9}  {verdict}",
                format!("({s}, {t})")
            )?;
        }
        Ok(())
    }
}
