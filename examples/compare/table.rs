//! The table on the terminal, and the one for a text in Markdown. The page has more.

use pathspace::integrator::Estimator;
use pathspace::report::{Interval, MethodReport, Omission, Outcome, Report, Slope};

pub fn print(report: &Report) {
    let reference = &report.reference;
    println!(
        "mean luminance of the reference: {:.6} ± {:.6}\n",
        reference.mean, reference.mean_standard_error
    );
    let target = format!("time to {} [95 %]", report.setup.target);
    let headings = [
        "integrator",
        "runs × samples",
        "seconds",
        "Mrays/s",
        "rays/sample",
        "mean ± SE",
        "bias ± SE",
        "relMSE of a run [95 %]",
        "variance × time [95 %]",
        "speed-up [95 %]",
        &target,
        "slope ± SE",
        "tail",
        "non-finite",
    ];
    let rows: Vec<Vec<String>> = std::iter::once(headings.map(str::to_owned).to_vec())
        .chain(report.methods.iter().map(|m| row(m, reference.mean).to_vec()))
        .collect();
    let widths: Vec<usize> = (0..headings.len())
        .map(|i| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0))
        .collect();
    for row in rows {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .enumerate()
            .map(
                |(i, (cell, &width))| {
                    if i == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
                },
            )
            .collect();
        println!("{}", cells.join("  "));
    }
    let methods = || report.methods.iter();
    if let Some(baseline) = &report.setup.baseline {
        println!("speed-up: ratio of variance × time, over {baseline}");
    }
    if methods().any(|m| !m.complete) {
        println!("* cannot draw every path of this scene");
    }
    if methods().any(|m| m.complete && m.undecided.is_some()) {
        println!("? undecided: has met too little to tell");
    }
    if methods().any(limited) {
        println!("† limited by the reference's own error");
    }
    if methods().any(|m| m.infinite_variance) {
        println!("∗∗ infinite variance, as far as the samples show");
    }
    if methods().any(|m| m.time_to_target.is_some_and(|t| t.extrapolated)) {
        println!("‡ not reached by all runs: extrapolated as 1/t for the others");
    }
    left_out(report);
    verdicts(report);
}

/// Prints what each integrator leaves out, and why.
fn left_out(report: &Report) {
    for method in &report.methods {
        let adapts = method.decisions.iter().any(|decision| decision.pilot_samples > 0);
        match (method.left_out.is_empty(), adapts) {
            (true, false) => {}
            (true, true) => println!("{} leaves out what does not pay", method.name),
            _ => println!("{} leaves out {}", method.name, Omission::sentence(&method.left_out)),
        }
    }
    for method in &report.left_out {
        println!("{} leaves out {}", method.name, Omission::sentence(&method.left_out));
    }
}

fn row(m: &MethodReport, reference: f64) -> [String; 14] {
    let last = m.last();
    let percent =
        |bias: f64, error: f64| format!("{:+.3} % ± {:.3} %", 100.0 * bias, 100.0 * error);
    let bias = percent(m.bias.relative, m.bias.relative_standard_error);
    let of_mean = match reference {
        0.0 => "-".to_owned(),
        _ => percent(m.bias.mean / reference, m.bias.mean_standard_error / reference),
    };
    let error = last.map_or_else(String::new, |c| interval(&c.relative_mse));
    let heavy = if m.infinite_variance { " ∗∗" } else { "" };
    [
        format!("{}{}", m.name, mark(m)),
        format!("{} × {}", m.runs, m.samples_per_pixel),
        format!("{:.2}", m.total.wall),
        format!("{:.2}", m.total.rays / m.total.wall * 1e-6),
        format!("{:.2}", m.rays_per_sample),
        format!("{:.5} ± {:.5}", m.mean, m.mean_standard_error),
        match m.estimator {
            Estimator::Unbiased if m.bias.flagged => format!("{bias} (!)"),
            Estimator::Unbiased => bias,
            Estimator::Consistent => format!("{of_mean}, vanishes"),
            Estimator::Biased => format!("{of_mean}, stays"),
        },
        if limited(m) { format!("{error} †") } else { error },
        interval(&m.variance_times_wall),
        m.speed_up.map_or_else(
            || "-".to_owned(),
            |s| format!("{:.3} [{:.3}, {:.3}]", s.wall.value, s.wall.low, s.wall.high),
        ),
        m.time_to_target.map_or_else(
            || "-".to_owned(),
            |t| interval(&t.seconds) + if t.extrapolated { " ‡" } else { "" },
        ),
        slopes(m, "-", |s| format!("{:.2} ± {:.2} {}", s.value.value, s.standard_error, s.measure)),
        m.tail.map_or_else(|| "-".to_owned(), |t| format!("{:.1}{heavy}", t.index)),
        m.non_finite_contributions.to_string(),
    ]
}

/// The slopes of the error in one line, or what there is without any.
fn slopes(m: &MethodReport, none: &str, text: impl Fn(&Slope) -> String) -> String {
    let slopes: Vec<String> = m.slopes.iter().map(text).collect();
    if slopes.is_empty() { none.to_owned() } else { slopes.join(", ") }
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

fn interval(i: &Interval) -> String {
    if i.low < i.high {
        format!("{:.2e} [{:.1e}, {:.1e}]", i.value, i.low, i.high)
    } else {
        format!("{:.2e}", i.value)
    }
}

fn verdicts(report: &Report) {
    report.verdicts().iter().for_each(|verdict| println!("\n{verdict}"));
    for pair in report.pairs.iter().filter(|pair| pair.outcome() == Outcome::Disagree) {
        let [mean, worst, all] = pair.verdicts().map(|ok| if ok { "" } else { " (!)" });
        println!(
            "\n{} and {}: means t = {:+.2}{mean}; worst block t = {:+.2} (p {:.1e}, limit \
             {:.1e}){worst} at {}: {:.4} and {:.4}; mean t² {:.2} ± {:.2}{all}",
            pair.names[0],
            pair.names[1],
            pair.mean.t,
            pair.worst.t,
            pair.worst.p_value,
            pair.worst_limit,
            pair.place(),
            pair.worst_means[0],
            pair.worst_means[1],
            pair.mean_square,
            pair.mean_square_error
        );
    }
}

/// The key figures of a scene as a table in Markdown, with the marks that the page has.
pub fn markdown(report: &Report) -> String {
    let mut text = format!("## {}\n\n", report.scene.name);
    text += "| integrator | samples | rays per sample | relMSE of a run | variance × time [s] \
             | speed-up, time | speed-up, rays | slope | tail index |\n";
    text += "|---|---|---|---|---|---|---|---|---|\n";
    let figure = |i: &Interval| {
        if i.low < i.high {
            format!("{} ({} … {})", digits(i.value), digits(i.low), digits(i.high))
        } else {
            digits(i.value)
        }
    };
    let dash = || "–".to_owned();
    for m in &report.methods {
        let slope = |s: &Slope| {
            let measure = match s.measure.as_str() {
                "MSE" => String::new(),
                other => format!(" ({other})"),
            };
            format!("{:.2} ± {:.2}{measure}", s.value.value, s.standard_error)
        };
        let cells = [
            format!("{}{}", m.name.replace('-', " "), mark(m)),
            format!("{} × {}", m.runs, m.samples_per_pixel),
            digits(m.rays_per_sample),
            m.last().map_or_else(dash, |c| figure(&c.relative_mse))
                + if limited(m) { " †" } else { "" },
            figure(&m.variance_times_wall),
            m.speed_up.map_or_else(dash, |s| figure(&s.wall)),
            m.speed_up.map_or_else(dash, |s| figure(&s.rays)),
            slopes(m, "–", slope),
            m.tail.map_or_else(dash, |t| {
                digits(t.index) + if m.infinite_variance { " ∗∗" } else { "" }
            }),
        ];
        text += &format!("| {} |\n", cells.join(" | "));
    }
    text
}

/// Three significant digits.
fn digits(x: f64) -> String {
    if !x.is_finite() || x == 0.0 {
        return x.to_string();
    }
    let exponent = x.abs().log10().floor() as i32;
    if (-4..5).contains(&exponent) {
        format!("{x:.*}", (2 - exponent).clamp(0, 6) as usize)
    } else {
        format!("{x:.2e}")
    }
}
