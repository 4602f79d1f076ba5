//! The tables of the page.

use super::html::escape;
use crate::report::result::{MethodReport, Report};
use crate::report::stats::{Checkpoint, Interval, Slope, Tail, TimeToTarget};
use std::fmt::Write;

/// Three significant digits, in scientific notation where it is shorter.
pub(super) fn number(x: f64) -> String {
    let size = x.abs();
    match size {
        _ if x.is_nan() => "–".to_owned(),
        _ if x.is_infinite() => if x > 0.0 { "∞" } else { "−∞" }.to_owned(),
        _ if size == 0.0 => "0".to_owned(),
        _ if !(0.001..100_000.0).contains(&size) => scientific(x, 2),
        _ => {
            let digits = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{x:.digits$}")
        }
    }
}

/// With a minus sign in the exponent, at which a line is not broken.
fn scientific(x: f64, digits: usize) -> String {
    format!("{x:.digits$e}").replace("e-", "e−")
}

/// The value, and below it the interval.
pub(super) fn interval(i: &Interval) -> String {
    if i.low == i.high || i.high.is_nan() {
        return number(i.value);
    }
    format!("{}<br><small>{} … {}</small>", number(i.value), number(i.low), number(i.high))
}

/// An error from which the reference's own was subtracted; nothing may be left.
fn error(i: &Interval) -> String {
    if i.value > 0.0 { interval(i) } else { "below the reference's".to_owned() }
}

fn missing<T>(value: Option<&T>, text: impl Fn(&T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), text)
}

fn tail(t: &Tail) -> String {
    if t.index.is_infinite() {
        "none".to_owned()
    } else {
        format!("{:.2} ± {:.2}", t.index, t.standard_error)
    }
}

/// Rows are measures, columns integrators.
pub(super) fn summary(report: &Report) -> String {
    type Cell<'a> = Box<dyn Fn(&MethodReport) -> String + 'a>;
    let baseline = report.setup.baseline.as_deref().unwrap_or("the baseline");
    let last =
        |m: &MethodReport, f: fn(&Checkpoint) -> Interval| missing(m.last(), |c| error(&f(c)));
    let rows: Vec<(String, Cell<'_>)> = vec![
        ("sees every path".into(), Box::new(|m| if m.complete { "yes" } else { "no" }.into())),
        (
            "runs × samples per pixel".into(),
            Box::new(|m| format!("{} × {}", m.runs, m.samples_per_pixel)),
        ),
        ("wall time, all runs".into(), Box::new(|m| format!("{} s", number(m.total.wall)))),
        ("processor time, all runs".into(), Box::new(|m| format!("{} s", number(m.total.cpu)))),
        ("rays per sample".into(), Box::new(|m| number(m.rays_per_sample))),
        (
            "million rays per second".into(),
            Box::new(|m| number(m.total.rays / m.total.wall * 1e-6)),
        ),
        (
            "mean luminance ± SE".into(),
            Box::new(|m| format!("{:.5} ± {}", m.mean, number(m.mean_standard_error))),
        ),
        (
            "bias ± SE".into(),
            Box::new(|m| {
                let b = &m.bias;
                let flag = match (b.flagged, m.complete) {
                    (true, _) => " <span class=\"bad\">BIASED</span>",
                    (_, false) => " *",
                    _ => "",
                };
                format!(
                    "{:+.3} % ± {:.3} %{flag}",
                    100.0 * b.relative,
                    100.0 * b.relative_standard_error
                )
            }),
        ),
        ("relMSE of a run".into(), Box::new(move |m| last(m, |c| c.relative_mse) + limited(m))),
        ("MSE of a run".into(), Box::new(move |m| last(m, |c| c.mse) + limited(m))),
        ("MAPE of a run".into(), Box::new(move |m| last(m, |c| c.mape))),
        ("SMAPE of a run".into(), Box::new(move |m| last(m, |c| c.smape))),
        ("MedSE of a run".into(), Box::new(move |m| last(m, |c| c.median_squared))),
        ("relMSE of all runs, mean".into(), Box::new(|m| number(m.mean_image.relative_mse))),
        (
            "relMSE of all runs, median of means".into(),
            Box::new(|m| number(m.median_of_means.relative_mse)),
        ),
        ("variance of a sample".into(), Box::new(|m| interval(&m.variance_per_sample) + heavy(m))),
        (
            "variance × wall time [s]".into(),
            Box::new(|m| interval(&m.variance_times_wall) + heavy(m)),
        ),
        (
            "variance × processor time [s]".into(),
            Box::new(|m| interval(&m.variance_times_cpu) + heavy(m)),
        ),
        (
            format!("speed-up over {baseline}, wall time"),
            Box::new(|m| missing(m.speed_up.as_ref(), |s| interval(&s.wall))),
        ),
        (
            format!("speed-up over {baseline}, processor time"),
            Box::new(|m| missing(m.speed_up.as_ref(), |s| interval(&s.cpu))),
        ),
        (
            format!("speed-up over {baseline}, rays"),
            Box::new(|m| missing(m.speed_up.as_ref(), |s| interval(&s.rays))),
        ),
        (
            format!("time to relMSE {} [s]", number(report.setup.target)),
            Box::new(|m| {
                let mark = |t: &TimeToTarget| if t.extrapolated { " ‡" } else { "" };
                missing(m.time_to_target.as_ref(), |t| {
                    format!(
                        "{}{}<br><small>{} of {} runs</small>",
                        interval(&t.seconds),
                        mark(t),
                        t.reached,
                        m.runs
                    )
                })
            }),
        ),
        (
            "slope of the error".into(),
            Box::new(|m| {
                let text = |s: &Slope| {
                    format!(
                        "{:.3} ± {:.3}<br><small>{}, {}–{} samples</small>",
                        s.value.value, s.standard_error, s.measure, s.from, s.to
                    )
                };
                missing(m.slope.as_ref(), text)
            }),
        ),
        ("tail index ± SE".into(), Box::new(|m| missing(m.tail.as_ref(), tail) + heavy(m))),
        ("non-finite contributions".into(), Box::new(|m| count(m.non_finite_contributions))),
        ("non-finite pixels".into(), Box::new(|m| count(m.non_finite_pixels))),
    ];
    let mut html = head("", report.methods.iter().map(|m| m.name.as_str()));
    for (name, cell) in rows {
        let cells: String =
            report.methods.iter().map(|m| format!("<td>{}</td>", cell(m))).collect();
        let _ = write!(html, "<tr><th scope=\"row\">{}</th>{cells}</tr>", escape(&name));
    }
    html + "</table></div>"
}

fn limited(m: &MethodReport) -> &'static str {
    if m.last().is_some_and(|c| c.reference_limited) { " †" } else { "" }
}

fn heavy(m: &MethodReport) -> &'static str {
    if m.infinite_variance { " ∗∗" } else { "" }
}

fn count(n: u64) -> String {
    if n == 0 { "0".to_owned() } else { format!("<span class=\"bad\">{n}</span>") }
}

/// The beginning of a table, up to its rows.
pub(super) fn head<'a>(corner: &str, columns: impl Iterator<Item = &'a str>) -> String {
    let columns: String =
        columns.map(|name| format!("<th scope=\"col\">{}</th>", escape(name))).collect();
    format!("<div class=\"scroll\"><table><thead><tr><th>{corner}</th>{columns}</tr></thead>")
}

/// What each integrator sees, by number of scattering events, and what it runs.
pub(super) fn claims(report: &Report) -> String {
    let mut html = head("scattering events", report.methods.iter().map(|m| m.name.as_str()));
    let rows = report.methods.iter().map(|m| m.energy_by_bounces.len()).max().unwrap_or(0);
    for row in 0..rows {
        let more = if row + 1 == rows { " and more" } else { "" };
        let cell = |m: &MethodReport| {
            m.energy_by_bounces.get(row).map_or_else(|| "–".to_owned(), |e| number(*e))
        };
        let cells: String =
            report.methods.iter().map(|m| format!("<td>{}</td>", cell(m))).collect();
        let _ = write!(html, "<tr><th scope=\"row\">{row}{more}</th>{cells}</tr>");
    }
    let text = |f: &dyn Fn(&MethodReport) -> String| -> String {
        report
            .methods
            .iter()
            .map(|m| format!("<td class=\"text\">{}</td>", escape(&f(m))))
            .collect()
    };
    let _ = write!(
        html,
        "<tr><th scope=\"row\">techniques that it runs here</th>{}</tr>",
        text(&|m| m.techniques.clone())
    );
    let claim = |m: &MethodReport| {
        if m.complete { "every path of this scene" } else { "some paths only" }.to_owned()
    };
    let _ = write!(html, "<tr><th scope=\"row\">can draw</th>{}</tr>", text(&claim));
    html + "</table></div>"
}

/// Where the flux of the light walks went.
pub(super) fn ledger(report: &Report) -> String {
    let columns = ["emitted", "absorbed", "escaped", "truncated", "rejected", "unaccounted"];
    let walkers: Vec<&MethodReport> =
        report.methods.iter().filter(|m| m.ledger.emitted > 0.0).collect();
    if walkers.is_empty() {
        return "<p>No integrator walks from the lights.</p>".to_owned();
    }
    let mut html = head("luminance of flux per sample", columns.into_iter());
    for method in walkers {
        let l = &method.ledger;
        let rest = l.emitted - l.absorbed - l.escaped - l.truncated - l.rejected;
        let cells = [l.emitted, l.absorbed, l.escaped, l.truncated, l.rejected]
            .map(|x| format!("<td>{}</td>", number(x)))
            .concat();
        let rest = 100.0 * rest / l.emitted;
        let _ = write!(
            html,
            "<tr><th scope=\"row\">{}</th>{cells}<td>{rest:+.2} %</td></tr>",
            escape(&method.name)
        );
    }
    html + "</table></div>"
}

/// Tests of agreement.
pub(super) fn pairs(report: &Report) -> String {
    if report.pairs.is_empty() {
        return "<p>Fewer than two integrators see every path: nothing to test.</p>".to_owned();
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
    let mut html = head("pair", columns.into_iter());
    for pair in &report.pairs {
        let verdict = if pair.agrees() { "agree" } else { "<span class=\"bad\">DISAGREE</span>" };
        let _ = write!(
            html,
            "<tr><th scope=\"row\">{} – {}</th><td>{:+.2}</td><td>{:+.2}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2} ± {:.2}</td><td>{verdict}</td></tr>",
            escape(&pair.names[0]),
            escape(&pair.names[1]),
            pair.mean.t,
            pair.worst.t,
            scientific(pair.worst.p_value, 1),
            scientific(pair.worst_limit, 1),
            pair.place(),
            pair.mean_square,
            pair.mean_square_error,
        );
    }
    html + "</table></div>"
}

/// Shares of the techniques.
pub(super) fn techniques(report: &Report) -> String {
    let Some(pyramid) = &report.pyramid else { return String::new() };
    let columns = ["scattering events", "energy", "variance", "rays", "efficiency without it"];
    let mut html = head("(s, t)", columns.into_iter());
    for share in &pyramid.techniques {
        let without = if share.efficiency_without.is_nan() {
            "needed".to_owned()
        } else {
            format!("× {:.3}", share.efficiency_without)
        };
        let _ = write!(
            html,
            "<tr><th scope=\"row\">({}, {})</th><td>{}</td><td>{:.2} %</td><td>{:.2} %</td><td>{:.2} %</td><td>{without}</td></tr>",
            share.s,
            share.t,
            i32::from(share.s) + i32::from(share.t) - 2,
            100.0 * share.energy,
            100.0 * share.variance,
            100.0 * share.cost,
        );
    }
    html + "</table></div>"
}
