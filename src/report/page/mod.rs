//! The page: one HTML file with everything in it, for screens of any size and for paper.
//!
//! It opens with what was asked, then come the best pictures, then the rest. Each section has a
//! file: the summary of all integrators, error plots, pictures, omissions, the pyramid of
//! techniques. `view.js` and `stage.js` let pictures be zoomed, flipped and measured; without them
//! everything can be read all the same. The same numbers are written as JSON and CSV.

mod csv;
mod files;
mod findings;
mod images;
mod left_out;
mod picture;
mod plot;
mod pyramid;
mod summary;
mod table;
mod values;

pub use picture::{ERROR_SCALE, error_colour, exposure, signed_error_map};
pub use plot::{Axis, error_plot};

use crate::report::result::{Machine, Report, Study};
use crate::report::stats::{
    BIAS_SIGNIFICANCE, FEWEST_CONTRIBUTIONS, REFERENCE_SHARE, SIGNIFICANCE, Tail,
};
use crate::report::text::{number, with_error};
use images::Images;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use plot::plots;

const STYLE: &str = include_str!("style.css");
/// In a block, so that its names are its own.
const SCRIPT: &str = concat!(
    "'use strict';{\n",
    include_str!("view.js"),
    include_str!("values.js"),
    include_str!("stage.js"),
    "}"
);

/// The files of numbers that the page names.
const FILES: [&str; 6] =
    ["report.json", "report.csv", "verdicts.csv", "missing.csv", "left-out.csv", "decisions.csv"];

impl Study {
    /// The report as one self-contained HTML page.
    #[must_use]
    pub fn page(&self) -> String {
        let report = &self.report;
        let mut images = Images::new(self);
        let (best, on_the_way) = (images.best(), images.on_the_way());
        let gain = images.gain;
        let ranked = report.rankings.first().map(|ranking| &ranking.best);
        let winner = report.methods.iter().position(|m| Some(&m.name) == ranked).unwrap_or(0);
        let pyramids = report.methods.iter().zip(&self.images);
        let pyramids =
            pyramids.filter_map(|(m, images)| images.pyramid.as_ref().map(|p| (&m.name, p)));
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="color-scheme" content="light dark";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    link rel="icon" href="data:,";
                    title { (report.scene.name) ": error against run time" }
                    style { (PreEscaped(STYLE)) }
                }
                body data-gain=(gain) data-stops=(images.stops) data-factor=(images.factor)
                    data-error-scale=(ERROR_SCALE) data-first=(winner + 1) {
                    (header(report))
                    h2 { "The pictures" }
                    (images::stage())
                    (best)
                    (against_cost(report))
                    h2 { "In numbers" }
                    (summary::summary(report))
                    (footnotes())
                    (on_the_way)
                    @if let Some(pyramid) = &self.pyramid {
                        h2 { "Techniques of bidirectional path tracing" }
                        (pyramid::pyramid(pyramid, gain))
                    }
                    @for (name, pyramid) in pyramids {
                        h2 { "Techniques of " (name) }
                        (pyramid::pyramid(pyramid, gain))
                    }
                    (left_out::left_out(report))
                    (findings::findings(report))
                    (what_is_seen(report))
                    (reproduce(report, images.bytes))
                    div #readout hidden {}
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        };
        page.into_string()
    }
}

fn header(report: &Report) -> Markup {
    let scene = &report.scene;
    html! {
        h1 { (scene.name) ": error against run time" }
        div.answer {
            @for (i, answer) in report.answers().iter().enumerate() {
                p { @if i == 0 { strong { (answer) } } @else { (answer) } }
            }
        }
        div.verdict { @for verdict in report.verdicts() { p { (verdict) } } }
        p { (scene.description) }
        p {
            (scene.width) " × " (scene.height) " pixels, "
            @match scene.max_bounces {
                Some(bounces) => { "at most " (bounces) " scattering events; " }
                None => { "no limit on scattering events; " }
            }
            "independent runs of each integrator, interleaved, within " (report.setup.budget) "."
        }
        p {
            "Reference: " (report.reference.origin) ". Mean luminance "
            (with_error(report.reference.mean, report.reference.mean_standard_error)) "."
        }
    }
}

fn against_cost(report: &Report) -> Markup {
    html! {
        h2 { "Error against cost" }
        p {
            "Mean over the runs with a band of 95 % confidence (t over seeds, of logarithms). \
             Curves stop where the reference limits them. A slope of −1 is that of finite variance \
             without bias; with a bias, variance and squared bias fall each on its own."
        }
        div.plots {
            @for (_, plot) in plots(report) { figure { (plot) } }
        }
    }
}

fn footnotes() -> Markup {
    html! {
        p.notes { small {
            "Intervals are of 95 % confidence over the runs. Errors are averaged over pixels and \
             channels, the reference's own variance is subtracted from MSE and relMSE. \
             relMSE: (I − R)² / (R² + 0.01 mean(R)²). MAPE: |I − R| / (|R| + 0.01 mean(R)). \
             SMAPE: |I − R| / (|I| + |R|). MedSE: median of (I − R)². \
             Variance and squared bias of a run are means over pixels and channels, from pairs of \
             runs with the deviations d = I − R: of (d₁ − d₂)² / 2 and of d₁ d₂. MSE is their sum. \
             Bias: blocks of pixels weighted by value over variance, flagged if its p-value or \
             that of the difference of means is below what all integrators together reach by \
             chance with probability " (100.0 * BIAS_SIGNIFICANCE) " %, for integrators that are \
             called unbiased. \
             * cannot draw every path, so it is not tested. \
             ? undecided: its mean rests on fewer effective contributions, mean² over the \
             variance of the mean, than " (FEWEST_CONTRIBUTIONS) ", which tell no error. \
             § consistent: its variance falls slower than 1/N, so that this number holds for runs \
             of this length. Speed-ups are of unbiased integrators only: variance × cost leaves \
             out a bias. \
             † the reference's own variance is more than " (100.0 * REFERENCE_SHARE) " % of it. \
             ‡ not reached by all runs: extrapolated for the others with an error that falls as \
             1/t. Reached is a target when no later checkpoint of the run is above it. \
             ∗∗ the tail index is below " (Tail::INFINITE_VARIANCE) ", and so is that of the \
             largest quarter of the tail: the variance is infinite as far as the samples show. \
             Tail index: Hill's estimate from the largest 0.1 % of what samples give to a pixel, \
             relative to the pixel's value."
        } }
    }
}

/// The sections on paths seen, energy and agreement.
fn what_is_seen(report: &Report) -> Markup {
    html! {
        h2 { "What each integrator sees" }
        p {
            "Mean luminance of the image by the number of scattering events, from a probe of \
             single contributions: what an integrator cannot draw is missing from its column."
        }
        (summary::claims(report))
        h2 { "Energy ledger of the walks from the lights" }
        p {
            "In expectation, emitted = absorbed + escaped + truncated + rejected. Rejected flux \
             must be 0."
        }
        (summary::ledger(report))
        h2 { "Do the integrators agree?" }
        p {
            "Three tests for every pair of unbiased integrators that see every path, each wrong \
             with probability " (number(SIGNIFICANCE)) ": Welch's t of the image means; the \
             worst of the blocks of 8 × 8 pixels, with Šidák's correction for their number; and \
             the mean of t² over all blocks, which is 1 if they agree. Where rare, bright \
             contributions make up much of the noise of one of them, blocks in which it is too \
             dark are no evidence and are left out."
        }
        (summary::pairs(report))
    }
}

fn reproduce(report: &Report, pictures: usize) -> Markup {
    let setup = &report.setup;
    html! {
        h2 { "Make this page again" }
        @if let Some(command) = &setup.command { pre { (command) } }
        p {
            "Seed " (setup.seed) ", " (setup.seeds) " runs, " (setup.sampler) " sampler, "
            (setup.filter) " filter, "
            @match setup.threads { Some(n) => { (n) " threads" } None => { "all threads" } }
            ", 64-bit floats, no clamping"
            @if let Some(Machine { processor, processors, load }) = &setup.machine {
                ". Measured on " (processor) " with " (processors) " processors"
                @if let Some(load) = load { "; load averages " (load) " at the start" }
            }
            "; pathspace " (report.version) ". Seeds decide errors to the bit if the budget is in \
             samples; times differ."
        }
        p {
            "The same numbers, with all digits, are in "
            @for name in FILES { a href=(name) { (name) } ", " }
            "the pictures as 32-bit floats in the EXR files. Those in this page take "
            (number(pictures as f64 * 1e-6))
            " MB of it: 8-bit PNG, and half floats for values and exposure."
        }
    }
}
