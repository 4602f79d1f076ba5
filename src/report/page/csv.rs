//! The numbers of a report as comma-separated values (RFC 4180), with headings. Numbers that are
//! not finite are empty, as they are null in JSON.

use crate::report::result::{Omission, Report};
use csv::WriterBuilder;
use serde::Serialize;

impl Report {
    /// Costs and errors as CSV: one line per integrator, checkpoint and run.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let rows = self.methods.iter().flat_map(|method| {
            method.checkpoints.iter().flat_map(move |point| {
                let runs = point.costs.iter().zip(&point.runs).enumerate();
                runs.map(move |(run, (cost, errors))| {
                    (&method.name, run, point.samples, cost, errors, point.reference_limited)
                })
            })
        });
        csv(
            "integrator,run,samples_per_pixel,wall_seconds,cpu_seconds,rays,scattered,\
             mse,relative_mse,mape,smape,median_squared,non_finite_pixels,reference_limited",
            rows,
        )
    }

    /// Omissions and their reasons as CSV: one line per integrator and omission.
    #[must_use]
    pub fn left_out_to_csv(&self) -> String {
        let measured = self.methods.iter().map(|m| (&m.name, &m.left_out));
        let idle = self.left_out.iter().map(|m| (&m.name, &m.left_out));
        let rows = measured.chain(idle).flat_map(|(name, left_out)| {
            left_out.iter().map(move |Omission { what, why }| (name, what, why))
        });
        csv("integrator,left_out,reason", rows)
    }

    /// The verdict on each integrator as CSV, with the reason why it is undecided if it is.
    #[must_use]
    pub fn verdicts_to_csv(&self) -> String {
        let rows = self.methods.iter().map(|m| (&m.name, m.verdict(), &m.undecided));
        csv("integrator,verdict,reason", rows)
    }

    /// The paths that integrators cannot draw as CSV: one line per integrator and class of paths.
    #[must_use]
    pub fn missing_to_csv(&self) -> String {
        let rows = self
            .methods
            .iter()
            .flat_map(|method| method.missing.iter().map(move |missing| (&method.name, missing)));
        csv("integrator,missing,drawn_by", rows)
    }

    /// The decisions of integrators that adapt themselves, as CSV: one line per integrator, run and
    /// set of techniques that it chose from.
    #[must_use]
    pub fn decisions_to_csv(&self) -> String {
        let rows = self.methods.iter().flat_map(|method| {
            method.decisions.iter().enumerate().flat_map(move |(run, decision)| {
                let candidates = decision.candidates.iter();
                candidates
                    .map(move |candidate| (&method.name, run, decision.expected_gain, candidate))
            })
        });
        csv("integrator,run,expected_gain,techniques,variance,cost,samples,chosen", rows)
    }
}

fn csv(heading: &str, rows: impl Iterator<Item = impl Serialize>) -> String {
    // Writing to memory cannot fail, and the rows of a table have as many fields as its heading.
    let mut writer = WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let _ = writer.write_record(heading.split(','));
    rows.for_each(|row| {
        let _ = writer.serialize(row);
    });
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}
