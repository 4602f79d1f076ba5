//! The table on the terminal. The page has more.

use pathspace::report::{Interval, MethodReport, Report};

pub fn print(report: &Report) {
    let reference = &report.reference;
    println!("mean luminance of the reference: {:.6} ± {:.6}\n", reference.mean, reference.mean_standard_error);
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
        "slope ± SE",
        "tail",
        "non-finite",
    ];
    let rows: Vec<Vec<String>> =
        std::iter::once(headings.map(str::to_owned).to_vec()).chain(report.methods.iter().map(|m| row(m).to_vec())).collect();
    let widths: Vec<usize> = (0..headings.len()).map(|i| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0)).collect();
    for row in rows {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(i, (cell, &width))| if i == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") })
            .collect();
        println!("{}", cells.join("  "));
    }
    let methods = || report.methods.iter();
    if let Some(baseline) = &report.setup.baseline {
        println!("speed-up: ratio of variance × time, over {baseline}");
    }
    if methods().any(|m| !m.complete) {
        println!("* cannot draw every path of this scene: not tested");
    }
    if methods().any(limited) {
        println!("† limited by the reference's own error");
    }
    if methods().any(|m| m.infinite_variance) {
        println!("∗∗ heavy tail: variance infinite as far as the samples show; SMAPE and median of means are in the report");
    }
    report.left_out.iter().for_each(|name| println!("{name} has no technique for this scene and is left out"));
    verdicts(report);
}

fn row(m: &MethodReport) -> [String; 13] {
    let flag = if m.complete { "" } else { " *" };
    let last = m.last();
    let bias = format!("{:+.3} % ± {:.3} %", 100.0 * m.bias.relative, 100.0 * m.bias.relative_standard_error);
    let error = last.map_or_else(String::new, |c| interval(&c.relative_mse));
    let heavy = if m.infinite_variance { " ∗∗" } else { "" };
    [
        format!("{}{flag}", m.name),
        format!("{} × {}", m.runs, m.samples_per_pixel),
        format!("{:.2}", m.total.wall),
        format!("{:.2}", m.total.rays / m.total.wall * 1e-6),
        format!("{:.2}", m.rays_per_sample),
        format!("{:.5} ± {:.5}", m.mean, m.mean_standard_error),
        if m.bias.flagged { format!("{bias} (!)") } else { bias },
        if limited(m) { format!("{error} †") } else { error },
        interval(&m.variance_times_wall),
        m.speed_up.map_or_else(|| "-".to_owned(), |s| format!("{:.3} [{:.3}, {:.3}]", s.wall.value, s.wall.low, s.wall.high)),
        m.slope.as_ref().map_or_else(|| "-".to_owned(), |s| format!("{:.2} ± {:.2} {}", s.value.value, s.standard_error, s.measure)),
        m.tail.map_or_else(|| "-".to_owned(), |t| format!("{:.1}{heavy}", t.index)),
        m.non_finite_contributions.to_string(),
    ]
}

fn limited(m: &MethodReport) -> bool {
    m.last().is_some_and(|c| c.reference_limited)
}

fn interval(i: &Interval) -> String {
    if i.low < i.high { format!("{:.2e} [{:.1e}, {:.1e}]", i.value, i.low, i.high) } else { format!("{:.2e}", i.value) }
}

fn verdicts(report: &Report) {
    if report.stopped {
        println!("\nstopped before its end");
    }
    for m in report.methods.iter().filter(|m| m.bias.flagged) {
        println!("\nBIAS: {} is off by {:+.3} %", m.name, 100.0 * m.bias.relative);
    }
    if let Some(first) = report.methods.iter().find_map(|m| m.first_non_finite.as_ref()) {
        println!("\nNOT FINITE: the first at {first}");
    }
    let disagreeing: Vec<_> = report.pairs.iter().filter(|pair| !pair.agrees()).collect();
    for pair in &disagreeing {
        let [mean, worst, all] = pair.verdicts().map(|ok| if ok { "" } else { " (!)" });
        println!(
            "\nDISAGREE: {} and {}: means t = {:+.2}{mean}; worst block t = {:+.2} (p {:.1e}, limit {:.1e}){worst} at {}: {:.4} and {:.4}; mean t² {:.2} ± {:.2}{all}",
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
    match (report.pairs.len(), disagreeing.len()) {
        (0, _) => println!("\nfewer than two integrators see everything in this scene: agreement is not tested"),
        (n, 0) => {
            let noisy: Vec<&str> = report.methods.iter().filter(|m| m.complete && m.long_tails).map(|m| m.name.as_str()).collect();
            let caveat = if noisy.is_empty() { String::new() } else { format!(", as far as the noise of {} shows", noisy.join(", ")) };
            println!("\nthe integrators agree{caveat} ({n} pairs)");
        }
        _ => {}
    }
}
