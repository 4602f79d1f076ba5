//! The table on the terminal, and the one for a text in Markdown. The page has more.

use crate::columns::{table, wrapped};
use pathspace::integrator::Estimator;
use pathspace::report::text::{number, percent_with_error, signed, with_error};
use pathspace::report::{MethodReport, Omission, Outcome, Report, Slope, SpeedUp};

pub fn print(report: &Report) {
    let say = |sentence: &str| say!("{}", wrapped(sentence));
    report.answers().iter().for_each(|answer| say(answer));
    for (headings, cells) in blocks(report) {
        let rows = report.methods.iter().map(|m| {
            let name = format!("{}{}", m.name, mark(m));
            std::iter::once(name).chain(cells(m)).collect()
        });
        let headings: Vec<&str> = std::iter::once("").chain(headings).collect();
        say!("\n{}", table(&headings, rows).trim_end());
    }
    say!();
    let methods = || report.methods.iter();
    if let Some(baseline) = &report.setup.baseline {
        say(&format!("speed-up: ratio of variance × cost, over {baseline}"));
    }
    if methods().any(|m| !m.complete) {
        say("* cannot draw every path of this scene");
    }
    if methods().any(|m| m.complete && m.undecided.is_some()) {
        say("? undecided: has met too little to tell");
    }
    if methods().any(limited) {
        say("† limited by the reference's own error");
    }
    if methods().any(|m| m.infinite_variance) {
        say("∗∗ infinite variance, as far as the samples show");
    }
    if methods().any(|m| m.time_to_target.is_some_and(|t| t.extrapolated)) {
        say("‡ not reached by all runs: extrapolated as 1/t for the others");
    }
    left_out(report);
    verdicts(report);
}

/// The cells of an integrator's row.
type Cells<'r> = Box<dyn Fn(&MethodReport) -> Vec<String> + 'r>;

/// Tables, each narrow enough for a terminal: headings, and cells below them.
fn blocks(report: &Report) -> Vec<(Vec<&'static str>, Cells<'_>)> {
    let reference = report.reference.mean;
    let clocks = report.has_clocks();
    let wall = |s: SpeedUp| s.wall.to_string();
    let mut blocks: Vec<(Vec<&str>, Cells<'_>)> = vec![
        (
            vec!["runs × samples", "seconds", "Mrays/s", "rays/sample", "not finite"],
            Box::new(|m| {
                vec![
                    format!("{} × {}", m.runs, m.samples_per_pixel),
                    number(m.total.wall),
                    number(m.total.rays / m.total.wall * 1e-6),
                    number(m.rays_per_sample),
                    m.non_finite_contributions.to_string(),
                ]
            }),
        ),
        (
            vec!["relMSE of a run [95 %]", "speed-up, rays [95 %]"],
            Box::new(|m| {
                let error = m.last().map_or_else(String::new, |c| c.relative_mse.to_string());
                let rays = m.speed_up.map_or_else(dash, |s| s.rays.to_string());
                vec![if limited(m) { format!("{error} †") } else { error }, rays]
            }),
        ),
        (
            vec!["mean luminance ± SE", "bias ± SE"],
            Box::new(move |m| vec![with_error(m.mean, m.mean_standard_error), bias(m, reference)]),
        ),
        (
            vec!["slope ± SE", "tail index"],
            Box::new(|m| {
                let slope = |s: &Slope| {
                    format!("{} {}", s.measure, with_error(s.value.value, s.standard_error))
                };
                let heavy = if m.infinite_variance { " ∗∗" } else { "" };
                let tail = m.tail.map_or_else(dash, |t| format!("{}{heavy}", number(t.index)));
                vec![slopes(m, slope), tail]
            }),
        ),
    ];
    if clocks {
        let cells: Cells<'_> = Box::new(move |m| {
            let time = m.time_to_target.map_or_else(dash, |t| {
                t.seconds.to_string() + if t.extrapolated { " ‡" } else { "" }
            });
            vec![m.speed_up.map_or_else(dash, wall), time]
        });
        blocks.insert(1, (vec!["speed-up, time [95 %]", "time to the target [s]"], cells));
    }
    blocks
}

fn dash() -> String {
    "–".to_owned()
}

/// The bias, or that of the mean for one that has a bias and says so.
fn bias(m: &MethodReport, reference: f64) -> String {
    let of_mean = match reference {
        0.0 => dash(),
        _ => percent_with_error(m.bias.mean / reference, m.bias.mean_standard_error / reference),
    };
    let bias = percent_with_error(m.bias.relative, m.bias.relative_standard_error);
    match m.estimator {
        Estimator::Unbiased if m.bias.flagged => format!("{bias} (!)"),
        Estimator::Unbiased => bias,
        Estimator::Consistent => format!("{of_mean}, vanishes"),
        Estimator::Biased => format!("{of_mean}, stays"),
    }
}

/// Prints what each integrator leaves out, and why.
fn left_out(report: &Report) {
    let say = |name: &str, what: &str| say!("{}", wrapped(&format!("{name} leaves out {what}")));
    for method in &report.methods {
        let adapts = method.decisions.iter().any(|decision| decision.pilot_samples > 0);
        match (method.left_out.is_empty(), adapts) {
            (true, false) => {}
            (true, true) => say(&method.name, "what does not pay"),
            _ => say(&method.name, &Omission::sentence(&method.left_out)),
        }
    }
    for method in &report.left_out {
        say(&method.name, &Omission::sentence(&method.left_out));
    }
}

/// The slopes of the error in one line.
fn slopes(m: &MethodReport, text: impl Fn(&Slope) -> String) -> String {
    let slopes: Vec<String> = m.slopes.iter().map(text).collect();
    if slopes.is_empty() { dash() } else { slopes.join(", ") }
}

/// The mark of an integrator that is not tested.
fn mark(m: &MethodReport) -> &'static str {
    match (m.complete, &m.undecided) {
        (false, _) => " *",
        (true, Some(_)) => " ?",
        (true, None) => "",
    }
}

fn limited(m: &MethodReport) -> bool {
    m.last().is_some_and(|c| c.reference_limited)
}

fn verdicts(report: &Report) {
    report.verdicts().iter().for_each(|verdict| say!("\n{}", wrapped(verdict)));
    for pair in report.pairs.iter().filter(|pair| pair.outcome() == Outcome::Disagree) {
        let [mean, worst, all] = pair.verdicts().map(|ok| if ok { "" } else { " (!)" });
        let sentence = format!(
            "{} and {}: means t = {}{mean}; worst block t = {} (p {}, limit {}){worst} at {}: {} \
             and {}; mean t² {}{all}",
            pair.names[0],
            pair.names[1],
            signed(pair.mean.t),
            signed(pair.worst.t),
            number(pair.worst.p_value),
            number(pair.worst_limit),
            pair.place(),
            number(pair.worst_means[0]),
            number(pair.worst_means[1]),
            with_error(pair.mean_square, pair.mean_square_error)
        );
        say!("\n{}", wrapped(&sentence));
    }
}

/// The key figures of a scene as a table in Markdown, with the marks that the page has.
pub fn markdown(report: &Report) -> String {
    let mut text = format!("## {}\n\n", report.scene.name);
    text += "| integrator | samples | rays per sample | relMSE of a run | variance × time [s] \
             | speed-up, time | speed-up, rays | slope | tail index |\n";
    text += "|---|---|---|---|---|---|---|---|---|\n";
    for m in &report.methods {
        let slope = |s: &Slope| {
            let measure = match s.measure.as_str() {
                "MSE" => String::new(),
                other => format!(" ({other})"),
            };
            with_error(s.value.value, s.standard_error) + &measure
        };
        let cells = [
            format!("{}{}", m.name.replace('-', " "), mark(m)),
            format!("{} × {}", m.runs, m.samples_per_pixel),
            number(m.rays_per_sample),
            m.last().map_or_else(dash, |c| c.relative_mse.to_string())
                + if limited(m) { " †" } else { "" },
            m.variance_times_wall.to_string(),
            m.speed_up.map_or_else(dash, |s| s.wall.to_string()),
            m.speed_up.map_or_else(dash, |s| s.rays.to_string()),
            slopes(m, slope),
            m.tail.map_or_else(dash, |t| {
                number(t.index) + if m.infinite_variance { " ∗∗" } else { "" }
            }),
        ];
        text += &format!("| {} |\n", cells.join(" | "));
    }
    text
}
