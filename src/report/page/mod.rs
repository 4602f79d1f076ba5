//! The page: one HTML file with everything in it, for screens of any size and for paper.

mod csv;
mod files;
mod html;
mod left_out;
mod picture;
mod plot;
mod tables;

pub use picture::{ERROR_SCALE, error_colour, exposure, signed_error_map};
pub use plot::{Axis, error_plot};

use crate::film::Image;
use crate::report::result::{MethodImages, SNAPSHOTS, Study};
use crate::report::stats::{BIAS_SIGNIFICANCE, REFERENCE_SHARE, SIGNIFICANCE, Tail};
use html::escape;
use picture::{data_uri, shrunk};
use plot::{Measure, plot};
use std::fmt::Write;
use tables::number;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("flip.js");

/// Images of techniques are at most so wide.
const LAYER_WIDTH: u32 = 128;

/// A page under construction: every image gets a number, so that the slider can find it.
struct Page<'a> {
    study: &'a Study,
    html: String,
    /// Identifier and title of the images that can be flipped.
    images: Vec<(String, String)>,
    gain: f64,
}

impl Study {
    /// The report as one self-contained HTML page.
    #[must_use]
    pub fn page(&self) -> String {
        let mut page = Page {
            study: self,
            html: String::new(),
            images: Vec::new(),
            gain: exposure(self.reference.image()),
        };
        page.header();
        page.strip();
        page.plots();
        page.section("In numbers");
        page.html += &tables::summary(&self.report);
        page.footnotes();
        page.flip();
        page.pyramid();
        page.left_out();
        page.section("What each integrator sees");
        page.text("Mean luminance of the image by the number of scattering events, from a probe of single contributions: what an integrator cannot draw is missing from its column.");
        page.html += &tables::claims(&self.report);
        page.section("Energy ledger of the walks from the lights");
        page.text("In expectation, emitted = absorbed + escaped + truncated + rejected. Rejected flux must be 0.");
        page.html += &tables::ledger(&self.report);
        page.section("Do the integrators agree?");
        page.text(&format!(
            "Three tests for every pair of integrators that see every path, each wrong with probability {:e}: Welch's t of the image means; the worst of the blocks of 8 × 8 pixels, with Šidák's correction for their number; and the mean of t² over all blocks, which is 1 if they agree. Where rare, bright contributions make up much of the noise of one of them, blocks in which it is too dark are no evidence and are left out.",
            SIGNIFICANCE
        ));
        page.html += &tables::pairs(&self.report);
        page.reproduce();
        let title = escape(&self.report.scene.name);
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n<title>{title}: error against run time</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{}\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
            page.html
        )
    }
}

impl Page<'_> {
    fn section(&mut self, title: &str) {
        let _ = write!(self.html, "\n<h2>{}</h2>", escape(title));
    }

    fn text(&mut self, text: &str) {
        let _ = write!(self.html, "<p>{}</p>", escape(text));
    }

    /// An image that the slider can show, with a caption in HTML.
    fn figure(&mut self, image: &Image, gain: f64, title: &str, caption: &str) {
        let id = format!("image-{}", self.images.len());
        let _ = write!(
            self.html,
            "<figure><img id=\"{id}\" src=\"{}\" alt=\"{}\" width=\"{}\" height=\"{}\"><figcaption>{caption}</figcaption></figure>",
            data_uri(image, gain),
            escape(title),
            image.width(),
            image.height()
        );
        self.images.push((id, title.to_owned()));
    }

    fn header(&mut self) {
        let report = &self.study.report;
        let scene = &report.scene;
        let depth = scene.max_bounces.map_or_else(
            || "no limit on scattering events".to_owned(),
            |n| format!("at most {n} scattering events"),
        );
        let verdicts: String =
            report.verdicts().iter().map(|v| format!("<div>{}</div>", escape(v))).collect();
        let _ = write!(
            self.html,
            "<h1>{}: error against run time</h1><p>{}</p><p>{} × {} pixels, {depth}; {} independent runs for each integrator within {}, interleaved.</p><div class=\"verdict\">{verdicts}</div><p>Reference: {}. Mean luminance {:.6} ± {}.</p>",
            escape(&scene.name),
            escape(&scene.description),
            scene.width,
            scene.height,
            report.setup.seeds,
            escape(&report.setup.budget),
            escape(&report.reference.origin),
            report.reference.mean,
            number(report.reference.mean_standard_error)
        );
    }

    /// Rows are budgets, columns integrators; below, error maps on one scale.
    fn strip(&mut self) {
        let (study, gain) = (self.study, self.gain);
        let reference = study.reference.image();
        self.section(if study.report.setup.until_target {
            "Images on the way to the target"
        } else {
            "Images at equal budgets"
        });
        self.text(if study.report.setup.until_target {
            "The first run of each integrator after 1/16, 1/4 and all of what it takes to the target error: times differ, the last images should look alike."
        } else {
            "The first run of each integrator after 1/16, 1/4 and all of its budget, which is the same for all: columns compare."
        });
        let columns = study.images.len().max(1);
        for part in SNAPSHOTS {
            let shot =
                |images: &MethodImages| images.snapshots.iter().position(|shot| shot.part == part);
            if study.images.iter().all(|images| shot(images).is_none()) {
                continue;
            }
            let _ = write!(self.html, "<div class=\"strip\" style=\"--columns: {columns}\">");
            for (method, images) in study.report.methods.iter().zip(&study.images) {
                let Some(shot) = shot(images).map(|index| &images.snapshots[index]) else {
                    let name = escape(&method.name);
                    let _ = write!(
                        self.html,
                        "<figure><figcaption><b>{name}</b><br>a sample per pixel takes longer</figcaption></figure>"
                    );
                    continue;
                };
                let caption = format!(
                    "<b>{}</b><br>{} s, {} samples<br>relMSE {}, MAPE {}",
                    escape(&method.name),
                    number(shot.wall),
                    shot.samples,
                    number(shot.errors.relative_mse),
                    number(shot.errors.mape)
                );
                self.figure(
                    &shot.image,
                    gain,
                    &format!("{}, {} samples", method.name, shot.samples),
                    &caption,
                );
            }
            self.html += "</div>";
        }
        self.html += "<h3>All runs together, and the reference</h3>";
        let _ = write!(self.html, "<div class=\"strip\" style=\"--columns: {}\">", columns + 1);
        for (method, images) in study.report.methods.iter().zip(&study.images) {
            let caption = format!(
                "<b>{}</b><br>{} s<br>relMSE {}",
                escape(&method.name),
                number(method.total.wall),
                number(method.mean_image.relative_mse)
            );
            self.figure(&images.mean, gain, &format!("{}, all runs", method.name), &caption);
        }
        self.figure(reference, gain, "reference", "<b>reference</b>");
        self.html += "</div><h3>Signed relative error of all runs together</h3>";
        let legend = Image::from_fn(256, 1, |x, _| {
            error_colour((2.0 * (f64::from(x) + 0.5) / 256.0 - 1.0) * ERROR_SCALE)
        });
        let percent = 100.0 * ERROR_SCALE;
        let _ = write!(
            self.html,
            "<div class=\"scale\">too dark −{percent} % <img src=\"{}\" alt=\"scale of the error maps\"> +{percent} % too bright; the same scale for all</div>",
            data_uri(&legend, 0.0)
        );
        let _ = write!(self.html, "<div class=\"strip\" style=\"--columns: {columns}\">");
        for (method, images) in study.report.methods.iter().zip(&study.images) {
            let map = signed_error_map(&images.mean, reference);
            self.figure(
                &map,
                0.0,
                &format!("error of {}", method.name),
                &format!("<b>{}</b>", escape(&method.name)),
            );
        }
        self.html += "</div>";
    }

    fn plots(&mut self) {
        let report = &self.study.report;
        self.section("Error against cost");
        self.text(
            "Mean over the runs with a band of 95 % confidence (t over seeds, of logarithms). Curves stop where the reference limits them. A slope of −1 is that of finite variance.",
        );
        self.html += "<div class=\"plots\">";
        let plots = [
            (Axis::Wall, Measure::RelativeMse),
            (Axis::Samples, Measure::RelativeMse),
            (Axis::Rays, Measure::RelativeMse),
            (Axis::Wall, Measure::Smape),
        ];
        for (axis, measure) in plots {
            let _ = write!(self.html, "<figure>{}</figure>", plot(report, axis, measure));
        }
        self.html += "</div>";
    }

    fn footnotes(&mut self) {
        let _ = write!(
            self.html,
            "<p><small>Intervals are of 95 % confidence over the runs. Errors are averaged over pixels and channels, the reference's own variance is subtracted from MSE and relMSE. \
             relMSE: (I − R)² / (R² + 0.01 mean(R)²). MAPE: |I − R| / (|R| + 0.01 mean(R)). SMAPE: |I − R| / (|I| + |R|). MedSE: median of (I − R)². \
             Bias: blocks of pixels weighted by value over variance, flagged if its p-value or that of the difference of means is below what all integrators together reach by chance with probability {} %. \
             * cannot draw every path, so it is not tested. † the reference's own variance is more than {} % of it. ‡ not reached by all runs: extrapolated for the others with an error that falls as 1/t. Reached is a target when no later checkpoint of the run is above it. \
             ∗∗ the tail index is below {}, and so is that of the largest quarter of the tail: the variance is infinite as far as the samples show. Tail index: Hill's estimate from the largest 0.1 % of what samples give to a pixel, relative to the pixel's value.</small></p>",
            100.0 * BIAS_SIGNIFICANCE,
            100.0 * REFERENCE_SHARE,
            Tail::INFINITE_VARIANCE
        );
    }

    fn flip(&mut self) {
        self.html += "\n<section class=\"screen\">";
        self.section("Flip between two images");
        let all_runs = |(_, title): &&(String, String)| title.ends_with(", all runs");
        let chosen = self
            .images
            .iter()
            .find(all_runs)
            .map_or(0, |(id, _)| self.images.iter().position(|i| i.0 == *id).unwrap_or(0));
        let reference = self.images.iter().position(|(_, title)| title == "reference").unwrap_or(0);
        let options = |selected: usize| -> String {
            let option = |(i, (id, title)): (usize, &(String, String))| {
                format!(
                    "<option value=\"{id}\"{}>{}</option>",
                    if i == selected { " selected" } else { "" },
                    escape(title)
                )
            };
            self.images.iter().enumerate().map(option).collect()
        };
        let (first, second) = (options(chosen), options(reference));
        let _ = write!(
            self.html,
            "<div id=\"flip\"><div class=\"controls\"><select id=\"flip-first\" aria-label=\"left image\">{first}</select><select id=\"flip-second\" aria-label=\"right image\">{second}</select><button id=\"flip-button\" type=\"button\">flip</button></div><div class=\"stage\"><img id=\"flip-a\" alt=\"\"><img id=\"flip-b\" alt=\"\"><div class=\"bar\" id=\"flip-bar\"></div></div><input id=\"flip-slider\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"boundary between the images\"></div></section>"
        );
    }

    fn pyramid(&mut self) {
        let Some(pyramid) = &self.study.pyramid else { return };
        self.section("Techniques of bidirectional path tracing");
        self.text(&format!(
            "Each way (s, t) to draw a path, s vertices from the light and t from the camera. Above its image as if it were alone (exposed for itself), below what multiple importance sampling keeps of it (all of these together are the image). From {} samples per pixel; {} rays per sample.",
            pyramid.passes,
            number(pyramid.rays)
        ));
        let lengths: std::collections::BTreeSet<u16> =
            pyramid.layers.iter().map(|l| l.technique.s + l.technique.t).collect();
        for length in lengths {
            let bounces = length.saturating_sub(2);
            let plural = if bounces == 1 { "" } else { "s" };
            let _ = write!(
                self.html,
                "<h3>{bounces} scattering event{plural}</h3><div class=\"layer\">"
            );
            for layer in pyramid.layers.iter().filter(|l| l.technique.s + l.technique.t == length) {
                let [unweighted, weighted] =
                    [&layer.unweighted, &layer.weighted].map(|image| shrunk(image, LAYER_WIDTH));
                let name = format!("({}, {})", layer.technique.s, layer.technique.t);
                let _ = write!(
                    self.html,
                    "<figure><img src=\"{}\" alt=\"{name} alone\"><img src=\"{}\" alt=\"{name} weighted\"><figcaption>{name}: energy {:.1} %, variance {:.1} %</figcaption></figure>",
                    data_uri(&unweighted, exposure(&unweighted)),
                    data_uri(&weighted, self.gain),
                    100.0 * layer.share.energy,
                    100.0 * layer.share.variance
                );
            }
            self.html += "</div>";
        }
        self.text(
            "Energy: share of the mean luminance. Variance: of its weighted contributions over that of all; techniques are correlated, so shares need not add up to 1. Rays: what is saved without it. Efficiency without it: 1 / (variance × rays) of the rest, with the rest's weights, over that of all; above 1 the technique does not pay. Longer paths are drawn but not shown.",
        );
        self.html += &tables::techniques(&self.study.report);
    }

    fn reproduce(&mut self) {
        let setup = &self.study.report.setup;
        self.section("Make this page again");
        if let Some(command) = &setup.command {
            let _ = write!(self.html, "<pre>{}</pre>", escape(command));
        }
        let threads =
            setup.threads.map_or_else(|| "all threads".to_owned(), |n| format!("{n} threads"));
        let load = setup
            .load
            .as_ref()
            .map_or_else(String::new, |l| format!("; load averages {l} at the start"));
        self.text(&format!(
            "Seed {}, {} runs, {} sampler, {} filter, {threads}, 64-bit floats, no clamping. Measured on {} with {} processors{load}; pathspace {}. Seeds decide errors to the bit if the budget is in samples; times differ.",
            setup.seed, setup.seeds, setup.sampler, setup.filter, setup.processor, setup.processors, self.study.report.version
        ));
        self.text(
            "The same numbers are in report.json, report.csv, left-out.csv and decisions.csv.",
        );
    }
}
