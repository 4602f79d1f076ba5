//! Files: JSON with everything, CSV with one line per integrator, checkpoint and run, SVG plots,
//! the page.

use super::error::{ReportError, file_error};
use super::leave_out::quoted;
use super::plot::{Axis, Measure, plot};
use super::result::Report;
use super::study::Study;
use std::fmt::Write;
use std::path::Path;

impl Report {
    /// The report as JSON; docs/report.md describes the fields. Numbers that are not finite become
    /// null.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Nothing in a report can fail to be serialised: keys are texts and non-finite numbers have
        // a rule.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

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
}

impl Study {
    /// Writes `index.html`, `report.json`, `report.csv`, `left-out.csv`, `decisions.csv` and the
    /// plots `time.svg`, `samples.svg`, `rays.svg` and `smape.svg`.
    ///
    /// # Errors
    /// If the directory or a file cannot be written.
    pub fn save(&self, directory: impl AsRef<Path>) -> Result<(), ReportError> {
        let directory = directory.as_ref();
        std::fs::create_dir_all(directory).map_err(file_error(directory))?;
        let files = [
            ("index.html", self.page()),
            ("report.json", self.report.to_json()),
            ("report.csv", self.report.to_csv()),
            ("left-out.csv", self.report.left_out_to_csv()),
            ("decisions.csv", self.report.decisions_to_csv()),
            ("time.svg", plot(&self.report, Axis::Wall, Measure::RelativeMse)),
            ("samples.svg", plot(&self.report, Axis::Samples, Measure::RelativeMse)),
            ("rays.svg", plot(&self.report, Axis::Rays, Measure::RelativeMse)),
            ("smape.svg", plot(&self.report, Axis::Wall, Measure::Smape)),
        ];
        for (name, text) in files {
            let path = directory.join(name);
            std::fs::write(&path, text).map_err(file_error(&path))?;
        }
        Ok(())
    }
}
