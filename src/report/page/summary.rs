//! The tables of all integrators: key figures, what they see, where their light went, whether they
//! agree.

use super::table::{interval, row, table};
use crate::integrator::Estimator;
use crate::report::result::{MethodReport, Report};
use crate::report::stats::{Checkpoint, Interval, Outcome};
use crate::report::text::{number, percent, percent_with_error, signed, with_error};
use maud::{Markup, Render, html};

/// Rows are measures, columns integrators.
pub(super) fn summary(report: &Report) -> Markup {
    let rows = vec![
        measure(report, "sees every path", |m| if m.complete { "yes" } else { "no" }),
        measure(report, "estimator", |m| m.estimator.to_string()),
        measure(report, "runs × samples per pixel", |m| {
            format!("{} × {}", m.runs, m.samples_per_pixel)
        }),
        measure(report, "rays per sample", |m| number(m.rays_per_sample)),
        measure(report, "mean luminance ± SE", |m| with_error(m.mean, m.mean_standard_error)),
        measure(report, "effective contributions", |m| number(m.effective_contributions)),
        measure(report, "verdict", verdict),
        measure(report, "bias ± SE", bias),
        measure(report, "bias of the mean luminance", |m| interval(&m.bias.mean_interval)),
        measure(report, "squared bias of a run", |m| {
            known(m.last(), |c| interval(&c.squared_bias))
        }),
        measure(report, "variance of a run", |m| known(m.last(), |c| interval(&c.variance))),
        measure(
            report,
            "relMSE of a run",
            |m| html! { (last(m, |c| c.relative_mse)) (limited(m)) },
        ),
        measure(report, "MSE of a run", |m| html! { (last(m, |c| c.mse)) (limited(m)) }),
        measure(report, "MAPE of a run", |m| last(m, |c| c.mape)),
        measure(report, "SMAPE of a run", |m| last(m, |c| c.smape)),
        measure(report, "MedSE of a run", |m| last(m, |c| c.median_squared)),
        measure(report, "relMSE of all runs, mean", |m| number(m.mean_image.relative_mse)),
        measure(report, "relMSE of all runs, median of means", |m| {
            number(m.median_of_means.relative_mse)
        }),
        measure(report, "variance of a sample", |m| settled(m, &m.variance_per_sample)),
        measure(report, "variance × rays per pixel", |m| settled(m, &m.variance_times_rays)),
        measure(report, &speed_up(report, "rays"), |m| known(m.speed_up, |s| interval(&s.rays))),
        measure(report, "slope of the error", slopes),
        measure(report, "tail index ± SE", |m| {
            let tail = known(m.tail, |t| {
                html! {
                    @if t.index.is_infinite() { "none" }
                    @else { (with_error(t.index, t.standard_error)) }
                }
            });
            html! { (tail) (heavy(m)) }
        }),
        measure(report, "non-finite contributions", |m| count(m.non_finite_contributions)),
        measure(report, "non-finite pixels", |m| count(m.non_finite_pixels)),
    ];
    let clocks = if report.has_clocks() { times(report) } else { Vec::new() };
    table("key figures", "", names(report), clocks.into_iter().chain(rows).chain(shared(report)))
}

/// The readings of clocks.
fn times(report: &Report) -> Vec<Markup> {
    let target = format!("time to relMSE {} [s]", report.setup.target);
    vec![
        measure(report, "wall time, all runs [s]", |m| number(m.total.wall)),
        measure(report, "processor time, all runs [s]", |m| number(m.total.cpu)),
        measure(report, "million rays per second", |m| number(m.total.rays / m.total.wall * 1e-6)),
        measure(report, "variance × wall time [s]", |m| settled(m, &m.variance_times_wall)),
        measure(report, "variance × processor time [s]", |m| settled(m, &m.variance_times_cpu)),
        measure(report, &speed_up(report, "wall time"), |m| {
            known(m.speed_up, |s| interval(&s.wall))
        }),
        measure(report, &speed_up(report, "processor time"), |m| {
            known(m.speed_up, |s| interval(&s.cpu))
        }),
        measure(report, &target, |m| {
            known(m.time_to_target, |t| {
                html! {
                    (interval(&t.seconds)) @if t.extrapolated { " ‡" }
                    br; small { (t.reached) " of " (m.runs) " runs" }
                }
            })
        }),
    ]
}

fn speed_up(report: &Report, cost: &str) -> String {
    let baseline = report.setup.baseline.as_deref().unwrap_or("the baseline");
    format!("speed-up over {baseline}, {cost}")
}

/// Maps that pixels share, and light that bounds cut off, if any integrator has such.
fn shared(report: &Report) -> Vec<Markup> {
    let any = |figure: fn(&MethodReport) -> u64| report.methods.iter().any(|m| figure(m) > 0);
    let mut rows = Vec::new();
    if any(|m| m.shared.bytes) {
        rows.push(measure(report, "largest map that pixels share", |m| match m.shared.bytes {
            0 => "–".to_owned(),
            bytes => number(bytes as f64 * 1e-6) + " MB",
        }));
    }
    if any(|m| m.shared.queries) {
        rows.push(measure(report, "photons found in a search", |m| match m.shared.queries {
            0 => "–".to_owned(),
            queries => number(m.shared.merges as f64 / queries as f64),
        }));
    }
    if report.methods.iter().any(|m| m.ledger.clamped > 0.0) {
        rows.push(measure(report, "mean luminance that is cut off", |m| number(m.ledger.clamped)));
    }
    rows
}

fn names(report: &Report) -> impl Iterator<Item = &str> {
    report.methods.iter().map(|m| m.name.as_str())
}

/// A row with a cell for each integrator.
fn measure<R: Render>(report: &Report, name: &str, cell: impl Fn(&MethodReport) -> R) -> Markup {
    row(name, report.methods.iter().map(cell))
}

fn bias(m: &MethodReport) -> Markup {
    let b = &m.bias;
    html! {
        (percent_with_error(b.relative, b.relative_standard_error))
        @if b.flagged { " " span.bad { "BIASED" } }
        @else if !m.complete { " *" }
        @else if m.undecided.is_some() { " ?" }
    }
}

fn verdict(m: &MethodReport) -> Markup {
    html! {
        @if m.bias.flagged { span.bad { (m.verdict()) } } @else { (m.verdict()) }
    }
}

fn slopes(m: &MethodReport) -> Markup {
    html! {
        @if m.slopes.is_empty() { "–" }
        @for (i, s) in m.slopes.iter().enumerate() {
            @if i > 0 { br; }
            (with_error(s.value.value, s.standard_error))
            br; small { (s.measure) ", " (s.from) "–" (s.to) " samples" }
        }
    }
}

/// An error at the last checkpoint, from which the reference's own was subtracted; nothing may be
/// left.
fn last(m: &MethodReport, measure: fn(&Checkpoint) -> Interval) -> Markup {
    known(m.last().map(measure), |error| {
        html! {
            @if error.value > 0.0 { (interval(&error)) } @else { "below the reference's" }
        }
    })
}

fn known<T>(value: Option<T>, text: impl Fn(T) -> Markup) -> Markup {
    value.map_or_else(|| html! { "–" }, text)
}

fn limited(m: &MethodReport) -> &'static str {
    if m.last().is_some_and(|c| c.reference_limited) { " †" } else { "" }
}

fn heavy(m: &MethodReport) -> &'static str {
    if m.infinite_variance { " ∗∗" } else { "" }
}

/// A number that does not settle if the variance is infinite, or does not fall as 1/N.
fn settled(m: &MethodReport, value: &Interval) -> Markup {
    let grows = m.estimator == Estimator::Consistent;
    html! { (interval(value)) (heavy(m)) @if grows { " §" } }
}

fn count(n: u64) -> Markup {
    html! { @if n == 0 { "0" } @else { span.bad { (n) } } }
}

/// Energy by number of scattering events, and the techniques of each integrator.
pub(super) fn claims(report: &Report) -> Markup {
    let lengths = report.methods.iter().map(|m| m.energy_by_bounces.len()).max().unwrap_or(0);
    let seen = (0..lengths).map(|bounces| {
        let more = if bounces + 1 == lengths { " and more" } else { "" };
        measure(report, &format!("{bounces}{more}"), |m| {
            m.energy_by_bounces.get(bounces).map_or_else(|| "–".to_owned(), |e| number(*e))
        })
    });
    let texts = |name: &str, text: fn(&MethodReport) -> Markup| {
        html! {
            tr { th scope="row" { (name) } @for m in &report.methods { td.text { (text(m)) } } }
        }
    };
    let claim = |m: &MethodReport| {
        html! {
            @match (m.complete, m.missing.is_empty()) {
                (true, true) => { "nothing that this scene has" }
                (false, true) => { "some paths" }
                _ => {
                    @for (i, paths) in m.missing.iter().enumerate() {
                        @if i > 0 { br; }
                        (paths.what)
                    }
                }
            }
        }
    };
    let techniques = |m: &MethodReport| html! { (m.techniques) };
    let claims = [texts("techniques that it runs here", techniques), texts("cannot draw", claim)];
    table("energy by scattering events", "scattering events", names(report), seen.chain(claims))
}

/// The table of the energy ledgers of the light subpaths.
pub(super) fn ledger(report: &Report) -> Markup {
    let walkers = || report.methods.iter().filter(|m| m.ledger.emitted > 0.0);
    if walkers().next().is_none() {
        return html! { p { "No integrator walks from the lights." } };
    }
    let rows = walkers().map(|m| {
        let l = &m.ledger;
        let rest = l.emitted - l.absorbed - l.escaped - l.truncated - l.rejected;
        let [emitted, absorbed, escaped, truncated, rejected] =
            [l.emitted, l.absorbed, l.escaped, l.truncated, l.rejected].map(number);
        let rest = percent(rest / l.emitted);
        row(&m.name, [emitted, absorbed, escaped, truncated, rejected, rest])
    });
    let columns = ["emitted", "absorbed", "escaped", "truncated", "rejected", "unaccounted"];
    table("energy ledger", "luminance of flux per sample", columns, rows)
}

/// Tests of agreement.
pub(super) fn pairs(report: &Report) -> Markup {
    if report.pairs.is_empty() {
        return html! { p { "Fewer than two unbiased integrators see every path: nothing to test." } };
    }
    let columns = [
        "t of the means",
        "worst block: t",
        "p",
        "limit",
        "where",
        "all blocks: mean t²",
        "verdict",
    ];
    let rows = report.pairs.iter().map(|pair| {
        let figures = [
            signed(pair.mean.t),
            signed(pair.worst.t),
            number(pair.worst.p_value),
            number(pair.worst_limit),
            pair.place(),
            with_error(pair.mean_square, pair.mean_square_error),
        ];
        let verdict = html! {
            @match pair.outcome() {
                Outcome::Agree => { "agree" }
                Outcome::Undecided => { "undecided" }
                Outcome::Disagree => { span.bad { "DISAGREE" } }
            }
            @if pair.undecided_blocks > 0 {
                br; small { (pair.undecided_blocks) " blocks undecided" }
            }
        };
        row(pair.names.join(" – "), figures.iter().map(Render::render).chain([verdict]))
    });
    table("agreement of pairs", "pair", columns, rows)
}
