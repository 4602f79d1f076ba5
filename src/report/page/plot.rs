//! Error against cost as a log-log plot in SVG: one curve per integrator with its confidence band.
//!
//! Curves differ by colour, dashes and markers, so that they can be told apart in black and white.

use super::html::escape;
use crate::report::result::{MethodReport, Report};
use crate::report::stats::{Checkpoint, Interval};
use std::fmt::Write;

/// What a plot has on its horizontal axis, for one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Wall-clock seconds.
    Wall,
    /// Samples per pixel.
    Samples,
    /// Rays per pixel: does not depend on the machine.
    Rays,
}

impl Axis {
    fn label(self) -> &'static str {
        match self {
            Self::Wall => "wall-clock time of one run [s]",
            Self::Samples => "samples per pixel",
            Self::Rays => "rays per pixel",
        }
    }

    fn of(self, checkpoint: &Checkpoint, pixels: f64) -> f64 {
        match self {
            Self::Wall => checkpoint.cost.wall,
            Self::Samples => f64::from(checkpoint.samples),
            Self::Rays => checkpoint.cost.rays / pixels,
        }
    }
}

/// Which error is plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Measure {
    RelativeMse,
    Smape,
}

impl Measure {
    fn label(self) -> &'static str {
        match self {
            Self::RelativeMse => "relMSE",
            Self::Smape => "SMAPE",
        }
    }

    fn of(self, checkpoint: &Checkpoint) -> Interval {
        match self {
            Self::RelativeMse => checkpoint.relative_mse,
            Self::Smape => checkpoint.smape,
        }
    }
}

/// Small, so that text is legible where the plot is scaled to the width of a phone.
const WIDTH: f64 = 480.0;
/// Left, top, right, bottom of the plotting area; below it the axis and the legend.
const AREA: [f64; 4] = [66.0, 12.0, 470.0, 298.0];
/// Height of a line of the legend, and what lies between it and the plotting area.
const LEGEND: [f64; 2] = [20.0, 50.0];
/// Colours that people with any kind of colour vision can tell apart (Okabe and Ito 2008).
const COLOURS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#a0458a", "#9a6700", "#3a8fc7", "#000000"];
const DASHES: [&str; 4] = ["", "9 4", "3 3", "12 4 3 4"];

/// relMSE against a cost.
#[must_use]
pub fn error_plot(report: &Report, axis: Axis) -> String {
    plot(report, axis, Measure::RelativeMse)
}

/// Logarithmic scales of both axes.
struct Scales {
    x: [f64; 2],
    y: [f64; 2],
}

impl Scales {
    fn x(&self, value: f64) -> f64 {
        AREA[0]
            + (value.ln() - self.x[0].ln()) / (self.x[1].ln() - self.x[0].ln())
                * (AREA[2] - AREA[0])
    }

    fn y(&self, value: f64) -> f64 {
        let value = value.clamp(self.y[0], self.y[1]);
        AREA[3]
            - (value.ln() - self.y[0].ln()) / (self.y[1].ln() - self.y[0].ln())
                * (AREA[3] - AREA[1])
    }
}

/// (cost, error) of the checkpoints up to where the reference limits them.
fn curve(method: &MethodReport, axis: Axis, measure: Measure, pixels: f64) -> Vec<(f64, Interval)> {
    let usable = method.checkpoints.iter().take_while(|c| !c.reference_limited);
    let points = usable.map(|c| (axis.of(c, pixels), measure.of(c)));
    points
        .filter(|(x, y)| *x > 0.0 && x.is_finite() && y.value > 0.0 && y.value.is_finite())
        .collect()
}

pub(super) fn plot(report: &Report, axis: Axis, measure: Measure) -> String {
    let pixels = f64::from(report.scene.width) * f64::from(report.scene.height);
    let curves: Vec<_> =
        report.methods.iter().map(|m| (m, curve(m, axis, measure, pixels))).collect();
    let points = || curves.iter().flat_map(|(_, points)| points);
    let range = |values: &mut dyn Iterator<Item = f64>, margin: f64| {
        let [low, high] = values
            .fold([f64::INFINITY, 0.0], |[low, high], v| [f64::min(low, v), f64::max(high, v)]);
        if low < high {
            [low / margin, high * margin]
        } else if high > 0.0 {
            [high / 2.0, high * 2.0]
        } else {
            [0.1, 1.0]
        }
    };
    let floor =
        if measure == Measure::RelativeMse { report.reference.own_relative_mse } else { 0.0 };
    let scales = Scales {
        x: range(&mut points().map(|p| p.0), 1.25),
        y: range(&mut points().map(|p| p.1.value), 1.6),
    };
    let mut svg = String::new();
    let labels: Vec<String> = report.methods.iter().map(label).collect();
    let height =
        AREA[3] + LEGEND[1] + LEGEND[0] * labels.len().div_ceil(legend_columns(&labels)) as f64;
    let title = format!("{} against {}", measure.label(), axis.label());
    let _ = write!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{title}" font-family="sans-serif" font-size="14"><rect width="{WIDTH}" height="{height}" fill="#fff"/>"##
    );
    grid(&mut svg, &scales);
    for (index, (_, points)) in curves.iter().enumerate() {
        band(&mut svg, &scales, points, COLOURS[index % COLOURS.len()]);
    }
    if floor > scales.y[0] && floor < scales.y[1] {
        let (y, [left, _, right, _]) = (scales.y(floor), AREA);
        let _ = write!(
            svg,
            r##"<line x1="{left}" x2="{right}" y1="{y:.1}" y2="{y:.1}" stroke="#333" stroke-dasharray="2 5"/><text x="{:.1}" y="{:.1}" fill="#333" font-size="12">the reference's own error (subtracted)</text>"##,
            left + 6.0,
            y - 5.0
        );
    }
    for (index, (_, points)) in curves.iter().enumerate() {
        line(&mut svg, &scales, points, index);
    }
    legend(&mut svg, &labels);
    let [left, top, right, bottom] = AREA;
    let _ = write!(
        svg,
        r##"<rect x="{left}" y="{top}" width="{}" height="{}" fill="none" stroke="#333"/><text x="{}" y="{}" text-anchor="middle">{}</text><text transform="translate(18 {}) rotate(-90)" text-anchor="middle">{}</text></svg>"##,
        right - left,
        bottom - top,
        0.5 * (left + right),
        bottom + 38.0,
        axis.label(),
        0.5 * (top + bottom),
        measure.label()
    );
    svg
}

fn grid(svg: &mut String, scales: &Scales) {
    let [left, top, right, bottom] = AREA;
    for [x, y] in
        ticks(scales.x).map(|v| [Some(v), None]).chain(ticks(scales.y).map(|v| [None, Some(v)]))
    {
        let Some((value, labelled)) = x.or(y) else { continue };
        let colour = if labelled { "#bbb" } else { "#e6e6e6" };
        if x.is_some() {
            let x = scales.x(value);
            let _ = write!(
                svg,
                r##"<line x1="{x:.1}" x2="{x:.1}" y1="{top}" y2="{bottom}" stroke="{colour}"/>"##
            );
            if labelled {
                let _ = write!(
                    svg,
                    r##"<text x="{x:.1}" y="{}" text-anchor="middle">{}</text>"##,
                    bottom + 18.0,
                    number(value)
                );
            }
        } else {
            let y = scales.y(value);
            let _ = write!(
                svg,
                r##"<line x1="{left}" x2="{right}" y1="{y:.1}" y2="{y:.1}" stroke="{colour}"/>"##
            );
            if labelled {
                let _ = write!(
                    svg,
                    r##"<text x="{}" y="{:.1}" text-anchor="end">{}</text>"##,
                    left - 6.0,
                    y + 5.0,
                    number(value)
                );
            }
        }
    }
}

/// Multiples of powers of ten in a range, and whether they are labelled: powers of ten, or also 2
/// and 5 times them in a short range.
fn ticks([low, high]: [f64; 2]) -> impl Iterator<Item = (f64, bool)> {
    let decades = (high / low).log10();
    let exponents = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let all = exponents.flat_map(|e| (1..10).map(move |digit| (e, digit)));
    all.map(move |(e, digit)| {
        let labelled = digit == 1 && (decades < 9.0 || e % 2 == 0)
            || decades < 1.7 && (digit == 2 || digit == 5);
        (f64::from(digit) * 10f64.powi(e), labelled)
    })
    .filter(move |(value, _)| low <= *value && *value <= high)
}

fn number(value: f64) -> String {
    if (0.001..100_000.0).contains(&value) {
        format!("{}", (value * 1e6).round() / 1e6)
    } else {
        format!("{value:.0e}")
    }
}

fn band(svg: &mut String, scales: &Scales, points: &[(f64, Interval)], colour: &str) {
    let limited: Vec<_> =
        points.iter().filter(|(_, y)| y.low > 0.0 && y.high.is_finite()).collect();
    if limited.len() < 2 {
        return;
    }
    let upper = limited.iter().map(|(x, y)| (x, y.high));
    let lower = limited.iter().rev().map(|(x, y)| (x, y.low));
    let corners: Vec<String> = upper
        .chain(lower)
        .map(|(x, y)| format!("{:.1},{:.1}", scales.x(*x), scales.y(y)))
        .collect();
    let _ = write!(
        svg,
        r##"<polygon points="{}" fill="{colour}" fill-opacity="0.18"/>"##,
        corners.join(" ")
    );
}

fn line(svg: &mut String, scales: &Scales, points: &[(f64, Interval)], index: usize) {
    let (colour, dash) = (COLOURS[index % COLOURS.len()], DASHES[index % DASHES.len()]);
    let places: Vec<(f64, f64)> =
        points.iter().map(|(x, y)| (scales.x(*x), scales.y(y.value))).collect();
    let text: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = write!(
        svg,
        r##"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>"##,
        text.join(" ")
    );
    places.iter().for_each(|(x, y)| marker(svg, *x, *y, index));
}

/// Circle, square, triangle, diamond.
fn marker(svg: &mut String, x: f64, y: f64, index: usize) {
    let colour = COLOURS[index % COLOURS.len()];
    let path = match index % 4 {
        0 => format!("M{:.1} {y:.1}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z", x - 4.0),
        1 => format!("M{:.1} {:.1}h7v7h-7z", x - 3.5, y - 3.5),
        2 => format!("M{x:.1} {:.1}l4.5 8h-9z", y - 5.0),
        _ => format!("M{x:.1} {:.1}l5 5l-5 5l-5 -5z", y - 5.0),
    };
    let fill = if (index / 4).is_multiple_of(2) { colour } else { "#fff" };
    let _ = write!(svg, r##"<path d="{path}" fill="{fill}" stroke="{colour}"/>"##);
}

/// Two if all names are short.
fn legend_columns(labels: &[String]) -> usize {
    if labels.iter().all(|label| label.chars().count() <= 26) { 2 } else { 1 }
}

fn legend(svg: &mut String, labels: &[String]) {
    let columns = legend_columns(labels);
    for (index, label) in labels.iter().enumerate() {
        let x = 10.0 + WIDTH / columns as f64 * (index % columns) as f64;
        let y = AREA[3] + LEGEND[1] + LEGEND[0] * ((index / columns) as f64 + 0.5);
        let (colour, dash) = (COLOURS[index % COLOURS.len()], DASHES[index % DASHES.len()]);
        let _ = write!(
            svg,
            r##"<line x1="{x:.1}" x2="{:.1}" y1="{y:.1}" y2="{y:.1}" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>"##,
            x + 36.0
        );
        marker(svg, x + 18.0, y, index);
        let _ = write!(
            svg,
            r##"<text x="{:.1}" y="{:.1}">{}</text>"##,
            x + 44.0,
            y + 5.0,
            escape(label)
        );
    }
}

/// The name, and how the error falls.
fn label(method: &MethodReport) -> String {
    let slope =
        method.slope.as_ref().map_or_else(String::new, |s| format!(", slope {:.2}", s.value.value));
    format!("{}{slope}", method.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        let labels: Vec<String> =
            ticks([0.8, 25.0]).filter(|(_, labelled)| *labelled).map(|(v, _)| number(v)).collect();
        assert_eq!(labels, ["1", "2", "5", "10", "20"]);
        let labels: Vec<String> =
            ticks([1e-7, 1e-2]).filter(|(_, labelled)| *labelled).map(|(v, _)| number(v)).collect();
        assert_eq!(labels, ["1e-7", "1e-6", "1e-5", "1e-4", "0.001", "0.01"]);
    }
}
