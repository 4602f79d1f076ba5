//! The numbers of a report as comma-separated values.

use crate::report::result::{Omission, Report, TechniqueDecision};
use std::fmt::Write;

/// A text as a field (RFC 4180).
pub(super) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

impl Report {
    /// One line per integrator, checkpoint and run, with a heading. Names are quoted (RFC 4180).
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut csv = String::from(
            "integrator,run,samples_per_pixel,wall_seconds,cpu_seconds,rays,scattered,mse,relative_mse,mape,smape,median_squared,non_finite_pixels,reference_limited\n",
        );
        for method in &self.methods {
            let name = quoted(&method.name);
            for point in &method.checkpoints {
                for (run, (errors, cost)) in point.runs.iter().zip(&point.costs).enumerate() {
                    let _ = writeln!(
                        csv,
                        "{name},{run},{},{},{},{},{},{},{},{},{},{},{},{}",
                        point.samples,
                        cost.wall,
                        cost.cpu,
                        cost.rays,
                        cost.scattered,
                        errors.mse,
                        errors.relative_mse,
                        errors.mape,
                        errors.smape,
                        errors.median_squared,
                        errors.non_finite_pixels,
                        point.reference_limited
                    );
                }
            }
        }
        csv
    }

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
