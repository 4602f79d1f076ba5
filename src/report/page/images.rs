//! The pictures: side by side, as error maps, and one at a time on a stage.

use super::picture::{ERROR_SCALE, averaged, data_uri, error_colour, exposure, signed_error_map};
use super::values::encoded;
use crate::film::Image;
use crate::report::result::{MethodImages, MethodReport, SNAPSHOTS, Snapshot, Study};
use crate::report::text::number;
use maud::{Markup, html};
use std::borrow::Cow;

/// Pixels of all pictures of a page together. Larger pictures are averaged over squares of pixels.
/// At most 12 bytes a pixel, some 8 in practice, bound the page's size.
const MOST_PIXELS: u64 = 4 << 20;

/// Pictures under construction.
pub(super) struct Images<'a> {
    study: &'a Study,
    reference: Cow<'a, Image>,
    /// Width and height of the squares of pixels that make a pixel of a picture.
    pub factor: u32,
    /// Stops of exposure, and the whole number of stops that values are scaled by.
    pub gain: f64,
    pub stops: i32,
    /// Bytes of the pictures so far.
    pub bytes: usize,
}

/// A picture that the stage can show: a row of its choice of budgets, and a name.
struct Place<'p> {
    row: &'p str,
    name: &'p str,
}

impl<'a> Images<'a> {
    pub fn new(study: &'a Study) -> Self {
        let reference = study.reference.image();
        let pixels = reference.pixels().len() as u64;
        let shots: usize = study.images.iter().map(|images| images.snapshots.len() + 2).sum();
        let all = pixels * (shots as u64 + 1);
        let factor = (1u32..).find(|f| all <= MOST_PIXELS * u64::from(*f).pow(2)).unwrap_or(1);
        let gain = exposure(reference);
        let stops = gain.round() as i32;
        Self { study, reference: fitted(reference, factor), factor, gain, stops, bytes: 0 }
    }

    /// A picture whose values the page knows.
    fn figure(&mut self, image: &Image, place: &Place<'_>, caption: &Markup) -> Markup {
        let image = fitted(image, self.factor);
        let (png, values) = (data_uri(&image, self.gain), encoded(&image, self.stops));
        self.bytes += png.len() + values.len();
        let Place { row, name } = place;
        html! {
            figure {
                div.view style=(shape(&image)) {
                    img src=(png) alt={ (name) ", " (row) } data-row=(row) data-name=(name)
                        data-values=(values);
                }
                figcaption { b { (name) } (caption) }
            }
        }
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

    /// The best pictures: the reference and all runs together, and their errors on one scale.
    pub fn best(&mut self) -> Markup {
        let study = self.study;
        let text = match study.report.setup.until_target {
            true => "All runs of each integrator together: times differ, see below each picture.",
            false => "All runs of each integrator together, within the same budget.",
        };
        let place = Place { row: "all runs", name: "reference" };
        let exr = html! { br; a href="reference.exr" { "EXR" } };
        let reference = study.reference.image();
        let mut pictures = vec![self.figure(reference, &place, &exr)];
        pictures.extend(self.columns(|page, method, images| {
            let samples = u64::from(method.runs) * u64::from(method.samples_per_pixel);
            let caption = html! {
                br; (seconds(method.total.wall)) (samples) " samples"
                br; "relMSE " (number(method.mean_image.relative_mse))
                br; a href={ (study.file_name(&method.name)) ".exr" } { "EXR" }
            };
            let place = Place { row: "all runs", name: &method.name };
            page.figure(&images.mean, &place, &caption)
        }));
        let mut errors = vec![scale()];
        errors.extend(self.columns(|page, method, images| {
            let map = signed_error_map(&fitted(&images.mean, page.factor), &page.reference);
            let picture = view(&map, 0.0, &format!("signed relative error of {}", method.name));
            page.bytes += picture.0.len();
            html! { figure { (picture) figcaption { b { (method.name) } ", error" } } }
        }));
        html! {
            p { (text) }
            (strip(&pictures))
            (strip(&errors))
            @if self.factor > 1 {
                p { small {
                    "A pixel shown is the mean of " (self.factor) " × " (self.factor)
                    " pixels; the EXR files have them all."
                } }
            }
        }
    }

    /// Rows are budgets, columns integrators.
    pub fn on_the_way(&mut self) -> Markup {
        let [title, text] = if self.study.report.setup.until_target {
            [
                "On the way to the target",
                "The first run of each integrator after 1/16, 1/4 and all of what it takes to \
                 the target error: times differ, the last images should look alike.",
            ]
        } else {
            [
                "Pictures at equal budgets",
                "The first run of each integrator after 1/16, 1/4 and all of its budget, which \
                 is the same for all: columns compare.",
            ]
        };
        let rows: Vec<Markup> =
            SNAPSHOTS.into_iter().filter_map(|part| self.snapshots(part)).collect();
        html! {
            h2 { (title) }
            p { (text) }
            @for row in rows { (row) }
        }
    }

    /// The first runs after a part of their budget.
    fn snapshots(&mut self, part: f64) -> Option<Markup> {
        let shot = |images: &MethodImages| images.snapshots.iter().any(|shot| shot.part == part);
        self.study.images.iter().find(|images| shot(images))?;
        let row = if part < 1.0 { format!("1/{:.0} of a run", 1.0 / part) } else { "a run".into() };
        let pictures = self.columns(|page, method, images| {
            let Some(shot) = snapshot(images, part) else {
                return html! {
                    figure {
                        figcaption { b { (method.name) } br; "a sample per pixel takes longer" }
                    }
                };
            };
            let caption = html! {
                br; (seconds(shot.wall)) (shot.samples) " samples"
                br; "relMSE " (number(shot.errors.relative_mse))
                ", MAPE " (number(shot.errors.mape))
            };
            page.figure(&shot.image, &Place { row: &row, name: &method.name }, &caption)
        });
        Some(strip(&pictures))
    }
}

/// The stage, which the script fills; without it the pictures stand as they are.
pub(super) fn stage() -> Markup {
    html! {
        section.screen #stage aria-label="One picture at a time" hidden {
            div.view tabindex="0" role="group" aria-describedby="keys" { img alt=""; }
            div {
                div.controls #choices role="group" aria-label="picture" {}
                p #caption {}
                div.controls { label { "budget " select #row {} } }
                div.controls {
                    label {
                        "exposure "
                        input #stops type="range" min="-12" max="12" step="0.5" value="0";
                        " " output #stops-text for="stops" { "0" } " stops"
                    }
                }
                div.controls {
                    label {
                        "difference from "
                        select #against { option value="-1" { "nothing" } }
                    }
                }
                div.controls { button #whole type="button" { "reset" } }
                ul #keys {
                    li { "Click a picture; then these keys are at hand." }
                    li {
                        kbd { "1" } "–" kbd { "9" } " " kbd { "←" } " " kbd { "→" }
                        " choose a picture, " kbd { "↑" } " " kbd { "↓" } " a budget; "
                        kbd { "space" } " flips back"
                    }
                    li {
                        "wheel, pinch, " kbd { "+" } " " kbd { "-" }
                        " zoom all pictures; dragging, " kbd { "shift" } " and arrows move them"
                    }
                    li { kbd { "e" } " brighter, " kbd { "E" } " darker" }
                    li { kbd { "d" } " difference from the reference; " kbd { "0" } " resets" }
                    li { kbd { "enter" } " brings a picture from below here" }
                }
            }
        }
    }
}

/// A picture that can be looked at closely.
pub(super) fn view(image: &Image, gain: f64, title: &str) -> Markup {
    html! { div.view style=(shape(image)) { img src=(data_uri(image, gain)) alt=(title); } }
}

fn shape(image: &Image) -> String {
    format!("aspect-ratio: {} / {}", image.width(), image.height())
}

/// An image, averaged over squares of pixels if it is too large.
fn fitted(image: &Image, factor: u32) -> Cow<'_, Image> {
    match factor {
        1 => Cow::Borrowed(image),
        _ => Cow::Owned(averaged(image, factor)),
    }
}

fn snapshot(images: &MethodImages, part: f64) -> Option<&Snapshot> {
    images.snapshots.iter().find(|shot| shot.part == part)
}

/// The beginning of a caption, if the time is known.
fn seconds(wall: f64) -> String {
    if wall.is_nan() { String::new() } else { format!("{} s, ", number(wall)) }
}

fn strip(figures: &[Markup]) -> Markup {
    html! {
        div.strip style={ "--columns: " (figures.len().max(1)) } {
            @for figure in figures { (figure) }
        }
    }
}

/// The key to the colours of the error maps, in place of that of the reference.
fn scale() -> Markup {
    let colours = Image::from_fn(256, 1, |x, _| {
        error_colour((2.0 * (f64::from(x) + 0.5) / 256.0 - 1.0) * ERROR_SCALE)
    });
    let percent = 100.0 * ERROR_SCALE;
    html! {
        figure.scale {
            img src=(data_uri(&colours, 0.0)) alt="scale of the error maps";
            figcaption {
                "Signed relative error: too dark by " (percent) " %, exact, too bright by "
                (percent) " %"
            }
        }
    }
}
