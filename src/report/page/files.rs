//! The files of a study: JSON, CSV, SVG plots, the page.

use super::plot::plots;
use crate::film::replace_file;
use crate::report::error::{ReportError, file_error};
use crate::report::result::Study;
use std::path::Path;

impl Study {
    /// Writes `index.html`, `report.json`, `report.csv`, `verdicts.csv`, `missing.csv`,
    /// `left-out.csv`, `decisions.csv` and the plots `time.svg`, `samples.svg`, `rays.svg`, `smape.svg` and, if an integrator is not
    /// unbiased, `bias.svg`.
    ///
    /// # Errors
    /// If the directory or a file cannot be written.
    pub fn save(&self, directory: impl AsRef<Path>) -> Result<(), ReportError> {
        let (directory, report) = (directory.as_ref(), &self.report);
        std::fs::create_dir_all(directory).map_err(file_error(directory))?;
        let texts = [
            ("index.html", self.page()),
            ("report.json", report.to_json()),
            ("report.csv", report.to_csv()),
            ("verdicts.csv", report.verdicts_to_csv()),
            ("missing.csv", report.missing_to_csv()),
            ("left-out.csv", report.left_out_to_csv()),
            ("decisions.csv", report.decisions_to_csv()),
        ];
        let plots = plots(report).into_iter().map(|(name, plot)| (name, plot.into_string()));
        for (name, text) in texts.into_iter().chain(plots) {
            let path = directory.join(name);
            replace_file(&path, text.as_bytes()).map_err(file_error(&path))?;
        }
        Ok(())
    }
}
