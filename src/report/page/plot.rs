//! Error against cost as a log-log plot in SVG: one curve per integrator with its confidence band.
//!
//! Curves differ by colour, dashes and markers, so that they can be told apart in black and white.

use crate::integrator::Estimator;
use crate::report::result::{MethodReport, ReferenceInfo, Report};
use crate::report::stats::{Checkpoint, Interval};
use crate::report::text::number;
use maud::{Markup, html};

/// The horizontal axis of a plot: a cost of one run.
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

/// The error that is plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Measure {
    RelativeMse,
    Smape,
    /// Variance and squared bias of the integrators that are not unbiased.
    Parts,
}

impl Measure {
    fn label(self) -> &'static str {
        match self {
            Self::RelativeMse => "relMSE",
            Self::Smape => "SMAPE",
            Self::Parts => "variance and squared bias",
        }
    }

    /// Its error of the reference, which was subtracted.
    fn own(self, reference: &ReferenceInfo) -> f64 {
        match self {
            Self::RelativeMse => reference.own_relative_mse,
            Self::Smape => 0.0,
            Self::Parts => reference.own_mse,
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
    plot(report, axis, Measure::RelativeMse).into_string()
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

    /// Points of a polygon.
    fn corners(&self, points: impl Iterator<Item = (f64, f64)>) -> String {
        let corner = |(x, y)| format!("{:.1},{:.1}", self.x(x), self.y(y));
        points.map(corner).collect::<Vec<_>>().join(" ")
    }
}

/// The error at a checkpoint.
type Value = fn(&Checkpoint) -> Interval;

/// A curve with its name.
struct Curve {
    label: String,
    /// (cost, error) of checkpoints.
    points: Vec<(f64, Interval)>,
}

/// The curves of a plot, where the reference does not limit them.
fn curves(report: &Report, axis: Axis, measure: Measure) -> Vec<Curve> {
    let pixels = f64::from(report.scene.width) * f64::from(report.scene.height);
    let curve = |label, checkpoints: &mut dyn Iterator<Item = &Checkpoint>, error: Value| {
        let points = checkpoints.map(|c| (axis.of(c, pixels), error(c)));
        let is_finite = |(x, y): &(f64, Interval)| {
            *x > 0.0 && x.is_finite() && y.value > 0.0 && y.value.is_finite()
        };
        Curve { label, points: points.filter(is_finite).collect() }
    };
    let methods = report.methods.iter();
    let whole = |error: Value| {
        let known = |m: &MethodReport| {
            let usable = &mut m.checkpoints.iter().take_while(|c| !c.reference_limited);
            curve(label(m), usable, error)
        };
        methods.clone().map(known).collect()
    };
    let parts = |m: &MethodReport| {
        let all = m.checkpoints.iter();
        let seen = |c: &&Checkpoint| c.bias_is_seen;
        [
            curve(format!("{}: variance", m.name), &mut all.clone(), |c| c.variance),
            curve(format!("{}: squared bias", m.name), &mut all.filter(seen), |c| c.squared_bias),
        ]
    };
    match measure {
        Measure::RelativeMse => whole(|c| c.relative_mse),
        Measure::Smape => whole(|c| c.smape),
        Measure::Parts => {
            methods.filter(|m| m.estimator != Estimator::Unbiased).flat_map(parts).collect()
        }
    }
}

/// The plots of a study, with the names of their files.
pub(super) fn plots(report: &Report) -> Vec<(&'static str, Markup)> {
    let cost = if report.has_clocks() { Axis::Wall } else { Axis::Rays };
    let mut plots = vec![
        ("samples.svg", Axis::Samples, Measure::RelativeMse),
        ("rays.svg", Axis::Rays, Measure::RelativeMse),
        ("smape.svg", cost, Measure::Smape),
    ];
    if report.has_clocks() {
        plots.insert(0, ("time.svg", Axis::Wall, Measure::RelativeMse));
    }
    if report.methods.iter().any(|m| m.estimator != Estimator::Unbiased) {
        plots.push(("bias.svg", Axis::Samples, Measure::Parts));
    }
    let plots = plots.into_iter();
    plots.map(|(name, axis, measure)| (name, plot(report, axis, measure))).collect()
}

fn plot(report: &Report, axis: Axis, measure: Measure) -> Markup {
    let curves = curves(report, axis, measure);
    let points = || curves.iter().flat_map(|curve| &curve.points);
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
    let floor = measure.own(&report.reference);
    let scales = Scales {
        x: range(&mut points().map(|p| p.0), 1.25),
        y: range(&mut points().map(|p| p.1.value), 1.6),
    };
    let labels: Vec<&str> = curves.iter().map(|curve| curve.label.as_str()).collect();
    let height =
        AREA[3] + LEGEND[1] + LEGEND[0] * labels.len().div_ceil(legend_columns(&labels)) as f64;
    let title = format!("{} against {}", measure.label(), axis.label());
    let [left, top, right, bottom] = AREA;
    let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
    html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (WIDTH) " " (height) } role="img"
            aria-label=(title) font-family="sans-serif" font-size="14" {
            rect width=(WIDTH) height=(height) fill="#fff" {}
            (grid(&scales))
            @for (curve, colour) in curves.iter().zip(COLOURS.iter().cycle()) {
                (band(&scales, &curve.points, colour))
            }
            @if floor > scales.y[0] && floor < scales.y[1] {
                line x1=(left) x2=(right) y1=(px(scales.y(floor))) y2=(px(scales.y(floor)))
                    stroke="#333" stroke-dasharray="2 5" {}
                text x=(left + 6.0) y=(px(scales.y(floor) - 5.0)) fill="#333" font-size="12" {
                    "the reference's own error (subtracted)"
                }
            }
            @for (index, curve) in curves.iter().enumerate() {
                (line(&scales, &curve.points, index))
            }
            (legend(&labels))
            rect x=(left) y=(top) width=(right - left) height=(bottom - top)
                fill="none" stroke="#333" {}
            text x=(middle[0]) y=(bottom + 38.0) text-anchor="middle" { (axis.label()) }
            text transform={ "translate(18 " (middle[1]) ") rotate(-90)" } text-anchor="middle" {
                (measure.label())
            }
        }
    }
}

/// A coordinate to a tenth of a pixel.
fn px(x: f64) -> String {
    format!("{x:.1}")
}

fn grid(scales: &Scales) -> Markup {
    let [left, top, right, bottom] = AREA;
    let colour = |labelled| if labelled { "#bbb" } else { "#e6e6e6" };
    html! {
        @for (value, labelled) in ticks(scales.x) {
            @let x = scales.x(value);
            line x1=(px(x)) x2=(px(x)) y1=(top) y2=(bottom) stroke=(colour(labelled)) {}
            @if labelled {
                text x=(px(x)) y=(bottom + 18.0) text-anchor="middle" { (round(value)) }
            }
        }
        @for (value, labelled) in ticks(scales.y) {
            @let y = scales.y(value);
            line x1=(left) x2=(right) y1=(px(y)) y2=(px(y)) stroke=(colour(labelled)) {}
            @if labelled {
                text x=(left - 6.0) y=(px(y + 5.0)) text-anchor="end" { (round(value)) }
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

/// A round number, which needs no digit but its first.
fn round(value: f64) -> String {
    if (0.001..100_000.0).contains(&value) {
        format!("{}", (value * 1e6).round() / 1e6)
    } else {
        format!("{value:.0e}")
    }
}

fn band(scales: &Scales, points: &[(f64, Interval)], colour: &str) -> Markup {
    let limited = || points.iter().filter(|(_, y)| y.low > 0.0 && y.high.is_finite());
    let upper = limited().map(|(x, y)| (*x, y.high));
    let lower = limited().rev().map(|(x, y)| (*x, y.low));
    html! {
        @if limited().count() > 1 {
            polygon points=(scales.corners(upper.chain(lower))) fill=(colour) fill-opacity="0.18" {}
        }
    }
}

fn line(scales: &Scales, points: &[(f64, Interval)], index: usize) -> Markup {
    let (colour, dash) = (COLOURS[index % COLOURS.len()], DASHES[index % DASHES.len()]);
    let places = || points.iter().map(|(x, y)| (*x, y.value));
    html! {
        polyline points=(scales.corners(places())) fill="none" stroke=(colour) stroke-width="2"
            stroke-dasharray=(dash) {}
        @for (x, y) in places() { (marker(scales.x(x), scales.y(y), index)) }
    }
}

/// Circle, square, triangle, diamond.
fn marker(x: f64, y: f64, index: usize) -> Markup {
    let colour = COLOURS[index % COLOURS.len()];
    let path = match index % 4 {
        0 => format!("M{:.1} {y:.1}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z", x - 4.0),
        1 => format!("M{:.1} {:.1}h7v7h-7z", x - 3.5, y - 3.5),
        2 => format!("M{x:.1} {:.1}l4.5 8h-9z", y - 5.0),
        _ => format!("M{x:.1} {:.1}l5 5l-5 5l-5 -5z", y - 5.0),
    };
    let fill = if (index / 4).is_multiple_of(2) { colour } else { "#fff" };
    html! { path d=(path) fill=(fill) stroke=(colour) {} }
}

/// Two if all names are short.
fn legend_columns(labels: &[&str]) -> usize {
    if labels.iter().all(|label| label.chars().count() <= 26) { 2 } else { 1 }
}

fn legend(labels: &[&str]) -> Markup {
    let columns = legend_columns(labels);
    let place = |index: usize| {
        let x = 10.0 + WIDTH / columns as f64 * (index % columns) as f64;
        (x, AREA[3] + LEGEND[1] + LEGEND[0] * ((index / columns) as f64 + 0.5))
    };
    html! {
        @for (index, label) in labels.iter().enumerate() {
            @let (x, y) = place(index);
            @let colour = COLOURS[index % COLOURS.len()];
            line x1=(px(x)) x2=(px(x + 36.0)) y1=(px(y)) y2=(px(y)) stroke=(colour)
                stroke-width="2" stroke-dasharray=(DASHES[index % DASHES.len()]) {}
            (marker(x + 18.0, y, index))
            text x=(px(x + 44.0)) y=(px(y + 5.0)) { (label) }
        }
    }
}

/// The name, and how the error falls.
fn label(method: &MethodReport) -> String {
    let is_whole = method.estimator == Estimator::Unbiased;
    let slopes = method.slopes.iter().map(|slope| {
        let of = if is_whole { "slope" } else { &slope.measure };
        format!(", {of} {}", number(slope.value.value))
    });
    format!("{}{}", method.name, slopes.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        let labels: Vec<String> =
            ticks([0.8, 25.0]).filter(|(_, labelled)| *labelled).map(|(v, _)| round(v)).collect();
        assert_eq!(labels, ["1", "2", "5", "10", "20"]);
        let labels: Vec<String> =
            ticks([1e-7, 1e-2]).filter(|(_, labelled)| *labelled).map(|(v, _)| round(v)).collect();
        assert_eq!(labels, ["1e-7", "1e-6", "1e-5", "1e-4", "0.001", "0.01"]);
    }
}
