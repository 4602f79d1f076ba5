//! The page: one HTML file with everything in it, for screens of any size and for paper.
//!
//! Each section has a file: the summary of all integrators, error plots, images beside each other,
//! omissions, the pyramid of techniques. The same numbers are written as JSON and CSV.

mod csv;
mod files;
mod images;
mod left_out;
mod picture;
mod plot;
mod pyramid;
mod summary;
mod table;

pub use picture::{ERROR_SCALE, error_colour, exposure, signed_error_map};
pub use plot::{Axis, error_plot};

use crate::report::result::{Report, Study};
use crate::report::stats::{
    BIAS_SIGNIFICANCE, FEWEST_CONTRIBUTIONS, REFERENCE_SHARE, SIGNIFICANCE, Tail,
};
use images::Images;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use plot::plots;
use table::number;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("flip.js");

impl Study {
    /// The report as one self-contained HTML page.
    #[must_use]
    pub fn page(&self) -> String {
        let report = &self.report;
        let mut images = Images::new(self);
        let gain = exposure(self.reference.image());
        let pyramids = report.methods.iter().zip(&self.images);
        let pyramids =
            pyramids.filter_map(|(m, images)| images.pyramid.as_ref().map(|p| (&m.name, p)));
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    link rel="icon" href="data:,";
                    title { (report.scene.name) ": error against run time" }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    (header(report))
                    (images.strips())
                    (against_cost(report))
                    h2 { "In numbers" }
                    (summary::summary(report))
                    (footnotes())
                    (images.flip())
                    @if let Some(pyramid) = &self.pyramid {
                        h2 { "Techniques of bidirectional path tracing" }
                        (pyramid::pyramid(pyramid, gain))
                    }
                    @for (name, pyramid) in pyramids {
                        h2 { "Techniques of " (name) }
                        (pyramid::pyramid(pyramid, gain))
                    }
                    (left_out::left_out(report))
                    (what_is_seen(report))
                    (reproduce(report))
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
        p { (scene.description) }
        p {
            (scene.width) " × " (scene.height) " pixels, "
            @match scene.max_bounces {
                Some(bounces) => { "at most " (bounces) " scattering events; " }
                None => { "no limit on scattering events; " }
            }
            (report.setup.seeds) " independent runs for each integrator within "
            (report.setup.budget) ", interleaved."
        }
        div.verdict { @for verdict in report.verdicts() { div { (verdict) } } }
        p {
            "Reference: " (report.reference.origin) ". Mean luminance "
            (format!("{:.6}", report.reference.mean)) " ± "
            (number(report.reference.mean_standard_error)) "."
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
        p { small {
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
             with probability " (format!("{SIGNIFICANCE:e}")) ": Welch's t of the image means; the \
             worst of the blocks of 8 × 8 pixels, with Šidák's correction for their number; and \
             the mean of t² over all blocks, which is 1 if they agree. Where rare, bright \
             contributions make up much of the noise of one of them, blocks in which it is too \
             dark are no evidence and are left out."
        }
        (summary::pairs(report))
    }
}

fn reproduce(report: &Report) -> Markup {
    let setup = &report.setup;
    html! {
        h2 { "Make this page again" }
        @if let Some(command) = &setup.command { pre { (command) } }
        p {
            "Seed " (setup.seed) ", " (setup.seeds) " runs, " (setup.sampler) " sampler, "
            (setup.filter) " filter, "
            @match setup.threads { Some(n) => { (n) " threads" } None => { "all threads" } }
            ", 64-bit floats, no clamping. Measured on " (setup.processor) " with "
            (setup.processors) " processors"
            @if let Some(load) = &setup.load { "; load averages " (load) " at the start" }
            "; pathspace " (report.version) ". Seeds decide errors to the bit if the budget is in \
             samples; times differ."
        }
        p {
            "The same numbers are in report.json, report.csv, verdicts.csv, missing.csv, \
             left-out.csv and decisions.csv."
        }
    }
}
