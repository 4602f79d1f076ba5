//! The table as text, JSON and HTML, with a figure per family.

use crate::cases::Case;
use crate::measure::Method;
use crate::variance::{Comparison, Uncertain};
use crate::verdict::{Line, Verdict};
use pathspace::scene::Warning;
use std::fmt::{self, Write};

/// A warning from building the scene of a case.
pub struct CaseWarning<'a> {
    pub case: &'a Case,
    pub warning: &'a Warning,
}

impl fmt::Display for CaseWarning<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { case, warning } = self;
        write!(f, "{} {} {:e}: {warning}", case.row, case.family, case.value)
    }
}

/// The tables, no wider than a terminal of 80 columns. Lines of a case stand below its name.
pub fn text(lines: &[Line], comparisons: &[Comparison], warnings: &[CaseWarning<'_>]) -> String {
    let mut out = format!(
        "{:>10} {:8} {:>13} {:>13} {:>8} {:>6} {:>7} verdict\n",
        "value", "by", "expected", "measured", "± SE", "digits", "not fin"
    );
    let mut case = ("", "");
    for line in lines {
        if std::mem::replace(&mut case, (line.row, line.family)) != case {
            let _ = writeln!(out, "{} {}", line.row, line.family);
        }
        let _ = writeln!(
            out,
            "{:>10.3e} {:8} {:>13.6e} {:>13.6e} {:>8.1e} {:>6.1} {:>7} {}",
            line.value,
            line.method.key(),
            line.expected,
            line.mean,
            line.standard_error,
            line.digits(),
            line.non_finite,
            line.verdict.name()
        );
    }
    let count = |verdict: Verdict| lines.iter().filter(|line| line.verdict == verdict).count();
    let [holds, noisy, blind, fails] =
        [Verdict::Holds, Verdict::Imprecise, Verdict::Blind, Verdict::Fails].map(count);
    let _ = writeln!(
        out,
        "{} lines: {holds} hold, {noisy} noisy, {blind} blind as claimed, {fails} fail",
        lines.len()
    );
    for warning in warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    let _ = writeln!(
        out,
        "\nvariance × time over that of …\n{:>7} {:8} {:>12} {:>12} {:>12} {:>12} {:>4} verdict",
        "value", "by", "the best", "uniform", "by power", "useful alone", "off"
    );
    let mut case = ("", "");
    for comparison in comparisons {
        if std::mem::replace(&mut case, (comparison.row, comparison.family)) != case {
            let _ = writeln!(out, "{} {}", comparison.row, comparison.family);
        }
        let [best, uniform, power, alone] = ratios(comparison);
        let _ = writeln!(
            out,
            "{:>7.1e} {:8} {best:>12} {uniform:>12} {power:>12} {alone:>12} {:>4.1} {}",
            comparison.value,
            comparison.method,
            comparison.off,
            verdict(comparison)
        );
    }
    out
}

/// The ratios of a comparison, each with its standard error.
fn ratios(comparison: &Comparison) -> [String; 4] {
    let Comparison { over_best, over_uniform, over_power, over_alone, .. } = *comparison;
    [Some(over_best), Some(over_uniform), Some(over_power), over_alone].map(|ratio| {
        ratio.map_or("".to_owned(), |Uncertain { value, error }| {
            format!("{value:.1e} ± {:.0} %", 100.0 * error)
        })
    })
}

fn verdict(comparison: &Comparison) -> &'static str {
    let Comparison { is_good, over_uniform, over_alone, .. } = comparison;
    let is_noisy = over_uniform.error > 0.5 || over_alone.is_some_and(|ratio| ratio.error > 0.5);
    match (is_good, is_noisy) {
        (false, _) => "FAILS",
        (true, true) => "noisy",
        (true, false) => "holds",
    }
}

/// A number that JSON can hold.
fn number(x: f64) -> String {
    if x.is_finite() { format!("{x:e}") } else { "null".to_owned() }
}

pub fn json(lines: &[Line], comparisons: &[Comparison], warnings: &[CaseWarning<'_>]) -> String {
    let entry = |line: &Line| {
        format!(
            "{{\"row\": \"{}\", \"case\": \"{}\", \"value\": {}, \"integrator\": \"{}\", \"expected\": {}, \"measured\": {}, \
             \"standard_error\": {}, \"relative_deviation\": {}, \"difference_to_unstressed\": {}, \"digits\": {:.2}, \"samples\": {}, \
             \"non_finite\": {}, \"verdict\": \"{}\"}}",
            line.row,
            line.family,
            number(line.value),
            line.method.key(),
            number(line.expected),
            number(line.mean),
            number(line.standard_error),
            number(line.deviation),
            line.rounding.map_or("null".to_owned(), number),
            line.digits(),
            line.samples,
            line.non_finite,
            line.verdict.name()
        )
    };
    let list = |items: Vec<String>| format!("[\n    {}\n  ]", items.join(",\n    "));
    let ratio = |Uncertain { value, error }: Uncertain| {
        format!("{{\"ratio\": {}, \"relative_error\": {}}}", number(value), number(error))
    };
    let comparison = |it: &Comparison| {
        format!(
            "{{\"row\": \"{}\", \"case\": \"{}\", \"value\": {}, \"integrator\": \"{}\", \"over_best\": {}, \
             \"over_uniform\": {}, \"over_power\": {}, \"over_alone\": {}, \"off\": {}, \"verdict\": \"{}\"}}",
            it.row,
            it.family,
            number(it.value),
            it.method,
            ratio(it.over_best),
            ratio(it.over_uniform),
            ratio(it.over_power),
            it.over_alone.map_or("null".to_owned(), ratio),
            number(it.off),
            verdict(it)
        )
    };
    let warnings = warnings.iter().map(|warning| format!("{:?}", warning.to_string())).collect();
    format!(
        "{{\n  \"lines\": {},\n  \"comparisons\": {},\n  \"warnings\": {}\n}}\n",
        list(lines.iter().map(entry).collect()),
        list(comparisons.iter().map(comparison).collect()),
        list(warnings)
    )
}

const COLORS: [&str; 8] =
    ["#888888", "#1f77b4", "#9467bd", "#ff7f0e", "#2ca02c", "#d62728", "#8c564b", "#17becf"];

/// The names of the families in order.
fn families(lines: &[Line]) -> Vec<&'static str> {
    let mut names: Vec<&str> = Vec::new();
    for line in lines {
        if !names.contains(&line.family) {
            names.push(line.family);
        }
    }
    names
}

/// The error of a line in a figure: rounding where it can be told from noise, else the distance
/// from the answer.
fn error(line: &Line) -> f64 {
    line.rounding.unwrap_or(line.deviation).max(1e-16)
}

/// Relative error against the stress, log-log; `None` if there are fewer than three positive
/// values.
fn figure(lines: &[&Line]) -> Option<String> {
    let mut values: Vec<f64> =
        lines.iter().map(|line| line.value).filter(|value| *value > 0.0).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    if values.len() < 3 {
        return None;
    }
    let (width, height, left, bottom) = (460.0, 240.0, 50.0, 30.0);
    let (low, high) = (values[0].log10(), values[values.len() - 1].log10());
    let x =
        |value: f64| left + (value.log10() - low) / (high - low).max(1e-12) * (width - left - 10.0);
    let y = |error: f64| (-error.log10().min(0.0)) / 16.0 * (height - bottom - 10.0) + 10.0;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" role=\"img\" aria-label=\"relative error\">"
    );
    for decade in (0..=16).step_by(4) {
        let at = y(10f64.powi(-decade));
        let _ = write!(
            svg,
            "<line x1=\"{left}\" x2=\"{width}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>"
        );
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">1e-{decade}</text>",
            left - 4.0,
            at + 4.0
        );
    }
    for value in [values[0], values[values.len() / 2], values[values.len() - 1]] {
        let _ = write!(
            svg,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{value:.0e}</text>",
            x(value).clamp(60.0, 435.0),
            height - 8.0
        );
    }
    for (method, color) in Method::ALL.into_iter().zip(COLORS) {
        let mut points: Vec<&&Line> =
            lines.iter().filter(|line| line.method == method && line.value > 0.0).collect();
        points.sort_by(|a, b| a.value.total_cmp(&b.value));
        let path: Vec<String> = points
            .iter()
            .map(|line| format!("{:.1},{:.1}", x(line.value), y(error(line))))
            .collect();
        let _ = write!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.5\"/>",
            path.join(" ")
        );
        for point in &path {
            if let Some((cx, cy)) = point.split_once(',') {
                let _ = write!(svg, "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"2.5\" fill=\"{color}\"/>");
            }
        }
    }
    svg.push_str("</svg>");
    Some(svg)
}

pub fn html(lines: &[Line], comparisons: &[Comparison], warnings: &[CaseWarning<'_>]) -> String {
    let mut out = String::from(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Stability report</title>\n<style>\
         body{font:14px sans-serif;max-width:1000px;margin:2em auto;padding:0 1em}table{border-collapse:collapse;width:100%}\
         td,th{padding:2px 8px;text-align:right;border-bottom:1px solid #eee}td:nth-child(2),th:nth-child(2){text-align:left}\
         text{font-size:10px}.FAILS{background:#fbb}.noisy{color:#777}.blind{color:#777}</style>\n<h1>Stability report</h1>\n\
         <p>Scenes with exact answers under stress. A figure shows the relative difference to the scene without stress under the same random \
         numbers where there is such a scene, and else the distance from the exact answer, most of which is noise.</p>\n<p>",
    );
    for (method, color) in Method::ALL.into_iter().zip(COLORS) {
        let _ = write!(out, "<b style=\"color:{color}\">■</b> {} &nbsp; ", method.key());
    }
    out.push_str("</p>\n");
    for family in families(lines) {
        let of_family: Vec<&Line> = lines.iter().filter(|line| line.family == family).collect();
        let _ = write!(
            out,
            "<h2>{} {family}</h2>\n{}\n<table><tr>",
            of_family[0].row,
            figure(&of_family).unwrap_or_default()
        );
        for heading in [
            "value",
            "integrator",
            "expected",
            "measured",
            "± SE",
            "to unstressed",
            "digits",
            "not finite",
            "verdict",
        ] {
            let _ = write!(out, "<th>{heading}</th>");
        }
        out.push_str("</tr>\n");
        for line in of_family {
            let rounding = line.rounding.map_or(String::new(), |r| format!("{r:.1e}"));
            let _ = writeln!(
                out,
                "<tr class=\"{}\"><td>{:e}</td><td>{}</td><td>{:.6e}</td><td>{:.6e}</td><td>{:.1e}</td><td>{rounding}</td><td>{:.1}</td>\
                 <td>{}</td><td>{}</td></tr>",
                line.verdict.name(),
                line.value,
                line.method.key(),
                line.expected,
                line.mean,
                line.standard_error,
                line.digits(),
                line.non_finite,
                line.verdict.name()
            );
        }
        out.push_str("</table>\n");
    }
    out.push_str(
        "<h2>Variance × time</h2>\n<p>Of the world's own choice of lights, over that of the best of all methods and choices, \
         and of the same integrator with another choice or with the useful lights alone.</p>\n\
         <table><tr><th>row</th><th>case</th><th>value</th><th>integrator</th><th>the best</th><th>uniform</th><th>by power</th>\
         <th>useful alone</th><th>verdict</th></tr>\n",
    );
    for comparison in comparisons {
        let Comparison { row, family, value, method, .. } = comparison;
        let verdict = verdict(comparison);
        let _ = write!(
            out,
            "<tr class=\"{verdict}\"><td>{row}</td><td>{family}</td><td>{value:e}</td><td>{method}</td>"
        );
        for ratio in ratios(comparison) {
            let _ = write!(out, "<td>{ratio}</td>");
        }
        let _ = writeln!(out, "<td>{verdict}</td></tr>");
    }
    out.push_str("</table>\n");
    out.push_str("<h2>Warnings at scene build</h2>\n<ul>\n");
    for warning in warnings {
        let _ = writeln!(out, "<li>{warning}</li>");
    }
    out.push_str("</ul>\n</html>\n");
    out
}
