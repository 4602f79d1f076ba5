//! The images: side by side at equal budgets, as error maps, and to be flipped between.

use super::picture::{ERROR_SCALE, data_uri, error_colour, exposure, signed_error_map};
use super::table::number;
use crate::film::Image;
use crate::report::result::{MethodImages, MethodReport, SNAPSHOTS, Snapshot, Study};
use maud::{Markup, html};

/// Images under construction: each gets a number, by which the slider finds it.
pub(super) struct Images<'a> {
    study: &'a Study,
    /// Titles of the images, in the order of their numbers.
    titles: Vec<String>,
    gain: f64,
}

impl<'a> Images<'a> {
    pub fn new(study: &'a Study) -> Self {
        Self { study, titles: Vec::new(), gain: exposure(study.reference.image()) }
    }

    fn figure(&mut self, image: &Image, gain: f64, title: String, caption: Markup) -> Markup {
        let id = id(self.titles.len());
        let markup = html! {
            figure {
                img id=(id) src=(data_uri(image, gain)) alt=(title)
                    width=(image.width()) height=(image.height());
                figcaption { (caption) }
            }
        };
        self.titles.push(title);
        markup
    }

    /// A column for each integrator.
    fn columns(
        &mut self,
        mut figure: impl FnMut(&mut Self, &MethodReport, &MethodImages) -> Markup,
    ) -> Vec<Markup> {
        let study = self.study;
        let columns = study.report.methods.iter().zip(&study.images);
        columns.map(|(method, images)| figure(self, method, images)).collect()
    }

    /// Rows are budgets, columns integrators; below, error maps on one scale.
    pub fn strips(&mut self) -> Markup {
        let (reference, gain) = (self.study.reference.image(), self.gain);
        let [title, text] = if self.study.report.setup.until_target {
            [
                "Images on the way to the target",
                "The first run of each integrator after 1/16, 1/4 and all of what it takes to \
                 the target error: times differ, the last images should look alike.",
            ]
        } else {
            [
                "Images at equal budgets",
                "The first run of each integrator after 1/16, 1/4 and all of its budget, which \
                 is the same for all: columns compare.",
            ]
        };
        let snapshots: Vec<Markup> =
            SNAPSHOTS.into_iter().filter_map(|part| self.snapshots(part)).collect();
        let mut all_runs = self.columns(|page, method, images| {
            let caption = html! {
                b { (method.name) }
                br; (number(method.total.wall)) " s"
                br; "relMSE " (number(method.mean_image.relative_mse))
            };
            page.figure(&images.mean, gain, format!("{}, all runs", method.name), caption)
        });
        let caption = html! { b { "reference" } };
        all_runs.push(self.figure(reference, gain, "reference".to_owned(), caption));
        let errors = self.columns(|page, method, images| {
            let map = signed_error_map(&images.mean, reference);
            let caption = html! { b { (method.name) } };
            page.figure(&map, 0.0, format!("error of {}", method.name), caption)
        });
        html! {
            h2 { (title) }
            p { (text) }
            @for row in snapshots { (row) }
            h3 { "All runs together, and the reference" }
            (strip(&all_runs))
            h3 { "Signed relative error of all runs together" }
            (scale())
            (strip(&errors))
        }
    }

    /// The first runs after a part of their budget.
    fn snapshots(&mut self, part: f64) -> Option<Markup> {
        let gain = self.gain;
        let shot =
            |images: &MethodImages| images.snapshots.iter().find(|shot| shot.part == part).cloned();
        self.study.images.iter().find_map(shot)?;
        let row = self.columns(|page, method, images| {
            let Some(shot) = snapshot(images, part) else {
                return html! {
                    figure {
                        figcaption { b { (method.name) } br; "a sample per pixel takes longer" }
                    }
                };
            };
            let caption = html! {
                b { (method.name) }
                br; (number(shot.wall)) " s, " (shot.samples) " samples"
                br; "relMSE " (number(shot.errors.relative_mse))
                ", MAPE " (number(shot.errors.mape))
            };
            let title = format!("{}, {} samples", method.name, shot.samples);
            page.figure(&shot.image, gain, title, caption)
        });
        Some(strip(&row))
    }

    /// The slider, with the first integrator and the reference chosen.
    pub fn flip(&self) -> Markup {
        let all_runs = |title: &String| title.ends_with(", all runs");
        let first = self.titles.iter().position(all_runs).unwrap_or(0);
        let second = self.titles.iter().position(|title| title == "reference").unwrap_or(0);
        let choice = |name: &str, label: &str, selected: usize| {
            html! {
                select id=(name) aria-label=(label) {
                    @for (i, title) in self.titles.iter().enumerate() {
                        option value=(id(i)) selected[i == selected] { (title) }
                    }
                }
            }
        };
        html! {
            section.screen {
                h2 { "Flip between two images" }
                div #flip {
                    div.controls {
                        (choice("flip-first", "left image", first))
                        (choice("flip-second", "right image", second))
                        button #flip-button type="button" { "flip" }
                    }
                    div.stage {
                        img #flip-a alt="";
                        img #flip-b alt="";
                        div.bar #flip-bar {}
                    }
                    input #flip-slider type="range" min="0" max="100" value="50"
                        aria-label="boundary between the images";
                }
            }
        }
    }
}

fn snapshot(images: &MethodImages, part: f64) -> Option<&Snapshot> {
    images.snapshots.iter().find(|shot| shot.part == part)
}

fn id(number: usize) -> String {
    format!("image-{number}")
}

fn strip(figures: &[Markup]) -> Markup {
    html! {
        div.strip style={ "--columns: " (figures.len().max(1)) } {
            @for figure in figures { (figure) }
        }
    }
}

/// The key to the colours of the error maps.
fn scale() -> Markup {
    let colours = Image::from_fn(256, 1, |x, _| {
        error_colour((2.0 * (f64::from(x) + 0.5) / 256.0 - 1.0) * ERROR_SCALE)
    });
    let percent = 100.0 * ERROR_SCALE;
    html! {
        div.scale {
            "too dark −" (percent) " % "
            img src=(data_uri(&colours, 0.0)) alt="scale of the error maps";
            " +" (percent) " % too bright; the same scale for all"
        }
    }
}
