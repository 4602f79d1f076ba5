//! The files of a study: JSON, CSV, SVG plots, images, the page.

use super::picture::exposure;
use super::plot::plots;
use crate::film::{Image, ImageFile, replace_file};
use crate::report::error::{ReportError, file_error};
use crate::report::result::Study;
use std::path::Path;

impl Study {
    /// Writes `index.html`, `report.json`, `report.csv`, `verdicts.csv`, `missing.csv`,
    /// `left-out.csv`, `decisions.csv`, the plots `time.svg`, `samples.svg`, `rays.svg`,
    /// `smape.svg` and, if an integrator is not unbiased, `bias.svg`; and, as `.png` and `.exr`,
    /// `reference` and the mean of all runs of each integrator under its
    /// [`file_name`](Self::file_name).
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
        let image = |image: &Image, name: &str, origin: [&str; 2]| {
            let mut file = ImageFile::from(image.clone());
            file.exposure = exposure(self.reference.image());
            let texts = [["scene", &report.scene.name], origin];
            // An attribute cannot have a NUL.
            let texts = texts.map(|[key, text]| (key.to_owned(), text.replace('\0', " ")));
            file.metadata.extend(texts);
            ["png", "exr"]
                .into_iter()
                .try_for_each(|format| file.save(directory.join(format!("{name}.{format}"))))
        };
        image(self.reference.image(), "reference", ["reference", self.reference.origin()])?;
        for (method, images) in report.methods.iter().zip(&self.images) {
            let origin = ["techniques", method.techniques.as_str()];
            image(&images.mean, &self.file_name(&method.name), origin)?;
        }
        Ok(())
    }

    /// The name, without its ending, of the files of an integrator's image: its own name with `-`
    /// in place of what file names had better not have, and a number if another file has it
    /// already.
    #[must_use]
    pub fn file_name(&self, method: &str) -> String {
        let plain = |name: &str| -> String {
            let keep = |c: char| if c.is_alphanumeric() || c == '_' { c } else { '-' };
            name.chars().map(keep).collect()
        };
        let own = plain(method);
        let names = self.report.methods.iter().map(|m| m.name.as_str());
        let place = names.clone().position(|name| name == method).unwrap_or(0);
        let is_taken = own.is_empty()
            || own == "reference"
            || names.take(place).any(|name| plain(name).eq_ignore_ascii_case(&own));
        if is_taken { format!("{own}-{place}") } else { own }
    }
}
