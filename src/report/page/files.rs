//! The files of a study: JSON, CSV, SVG plots, the page.

use super::plot::{Axis, Measure, plot};
use crate::report::error::{ReportError, file_error};
use crate::report::result::Study;
use std::path::Path;

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
