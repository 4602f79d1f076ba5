//! What is left out, what that saves, and what adapts itself decided: the section of the page.

use super::super::leave_out::{DecisionReport, EverythingReport, Omission, TechniqueDecision};
use super::super::result::{MethodReport, Report};
use super::tables::{head, interval, number};
use super::{Page, escape};
use std::fmt::Write;

/// Techniques with smaller shares of everything are not shown.
const LEAST_SHARE: f64 = 0.0005;

impl Page<'_> {
    pub(super) fn leave_out(&mut self) {
        let report = &self.study.report;
        self.section("What is left out, and what that saves");
        self.text(
            "Exactly, before the first sample: techniques and path lengths that carry no light in this scene. Beside what each integrator takes with what the scene needs stands what it takes with everything, with the same seeds and on fewer samples; for one that adapts itself that is plain bidirectional path tracing. Gain: variance × cost with everything over that with what is needed, runs paired by seed.",
        );
        self.html += &savings(report);
        for method in report.methods.iter().filter(|m| !m.decisions.is_empty()) {
            let _ = write!(self.html, "<h3>What {} decided</h3>", escape(&method.name));
            self.html += &decisions(&method.decisions);
        }
    }
}

/// One row per integrator.
fn savings(report: &Report) -> String {
    let measures = ["rays per sample", "time per sample [µs]", "variance × processor time [s]"];
    let columns: Vec<String> =
        std::iter::once("left out".to_owned())
            .chain(measures.iter().flat_map(|measure| {
                [format!("{measure}, everything"), format!("{measure}, needed")]
            }))
            .chain(["gain in processor time", "gain in rays"].map(str::to_owned))
            .collect();
    let mut html = head("integrator", columns.iter().map(String::as_str));
    for method in &report.methods {
        let _ =
            write!(html, "<tr><th scope=\"row\">{}</th>{}</tr>", escape(&method.name), row(method));
    }
    for method in &report.left_out {
        let (name, reasons) = (escape(&method.name), text(&method.left_out));
        let _ = write!(
            html,
            "<tr><th scope=\"row\">{name}</th><td class=\"text\">{reasons}</td><td colspan=\"8\">no technique is left</td></tr>"
        );
    }
    html + "</table></div>"
}

fn row(method: &MethodReport) -> String {
    let mut reasons = text(&method.left_out);
    if method.decisions.iter().any(|decision| decision.pilot_samples > 0) {
        reasons += if reasons.is_empty() {
            "what its pilot found not to pay, see below"
        } else {
            "<br>and what its pilot found not to pay, see below"
        };
    } else if reasons.is_empty() {
        reasons = "nothing: the scene rules nothing out for it".to_owned();
    }
    let all = method.everything.as_ref();
    let with =
        |cell: &dyn Fn(&EverythingReport) -> String| all.map_or_else(|| "–".to_owned(), cell);
    let gain = all.and_then(|all| all.gain);
    let unknown = if method.infinite_variance { "∗∗" } else { "–" };
    let cells = [
        with(&|all| number(all.rays_per_sample)),
        number(method.rays_per_sample),
        with(&|all| number(1e6 * all.cpu_per_sample)),
        number(1e6 * method.cpu_per_sample),
        with(&|all| interval(&all.variance_times_cpu)),
        interval(&method.variance_times_cpu),
        gain.map_or_else(|| unknown.to_owned(), |gain| interval(&gain.cpu)),
        gain.map_or_else(|| unknown.to_owned(), |gain| interval(&gain.rays)),
    ];
    format!(
        "<td class=\"text\">{reasons}</td>{}",
        cells.map(|cell| format!("<td>{cell}</td>")).concat()
    )
}

fn text(left_out: &[Omission]) -> String {
    let items: Vec<String> =
        left_out.iter().map(|o| format!("{}: {}", escape(&o.what), escape(&o.why))).collect();
    items.join("<br>")
}

/// What each run decided, and the shares of the techniques.
fn decisions(decisions: &[DecisionReport]) -> String {
    if decisions.iter().all(|decision| decision.pilot_samples == 0) {
        return "<p>No other set of techniques draws every path of this scene: there was no choice.</p>".to_owned();
    }
    let mut html = "<p>Before each run a pilot, none of whose samples are in the image, finds the set of techniques with the least variance × cost. Gain: over plain bidirectional path tracing, as the pilot predicts and as it was when the choice was run.</p>".to_owned();
    html += &head(
        "run",
        [
            "samples of the pilot",
            "sets to choose from",
            "expected gain",
            "achieved gain",
            "what it runs",
        ]
        .into_iter(),
    );
    for (run, decision) in decisions.iter().enumerate() {
        let _ = write!(
            html,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"text wide\">{}</td></tr>",
            run + 1,
            decision.pilot_samples,
            decision.candidates,
            number(decision.expected_gain),
            number(decision.achieved_gain),
            escape(&decision.techniques)
        );
    }
    html += "</table></div>";
    let mean = |share: fn(&DecisionReport) -> f64| {
        decisions.iter().map(share).sum::<f64>() / decisions.len() as f64
    };
    let _ = write!(
        html,
        "<p>Shares of the techniques in plain bidirectional path tracing, mean over the pilots. Energy: of the mean luminance. Variance: of the second moment of weighted contributions. Cost: of connections alone, without the walks, which techniques share: those from the camera are {:.1} % of the cost, those from the lights {:.1} %. Those with less than {} % of each are not shown.</p>",
        100.0 * mean(|d| d.camera_walks),
        100.0 * mean(|d| d.light_walks),
        100.0 * LEAST_SHARE
    );
    html + &shares(decisions)
}

fn shares(decisions: &[DecisionReport]) -> String {
    let mut html =
        head("(s, t)", ["scattering events", "energy", "variance", "cost", "verdict"].into_iter());
    let runs = decisions.len();
    let all = decisions.first().map_or(&[][..], |decision| &decision.shares);
    for TechniqueDecision { s, t, .. } in all {
        let same = |share: &&TechniqueDecision| (share.s, share.t) == (*s, *t);
        let found: Vec<&TechniqueDecision> =
            decisions.iter().filter_map(|decision| decision.shares.iter().find(same)).collect();
        let mean = |share: fn(&TechniqueDecision) -> f64| {
            found.iter().map(|x| share(x)).sum::<f64>() / runs as f64
        };
        let [energy, variance, cost] = [mean(|x| x.energy), mean(|x| x.variance), mean(|x| x.cost)];
        if energy.max(variance).max(cost) < LEAST_SHARE {
            continue;
        }
        let verdict = match found.iter().filter(|share| share.kept).count() {
            0 => "left out".to_owned(),
            kept if kept == runs => "kept".to_owned(),
            kept => format!("kept in {kept} of {runs} runs"),
        };
        let _ = write!(
            html,
            "<tr><th scope=\"row\">({s}, {t})</th><td>{}</td><td>{:.2} %</td><td>{:.2} %</td><td>{:.2} %</td><td>{verdict}</td></tr>",
            i32::from(*s) + i32::from(*t) - 2,
            100.0 * energy,
            100.0 * variance,
            100.0 * cost
        );
    }
    html + "</table></div>"
}
