//! What is left out, and what adapts itself decided: the section of the page.

use super::Page;
use super::html::escape;
use super::tables::{head, number};
use crate::report::result::{DecisionReport, MethodReport, Omission, Report, TechniqueDecision};
use std::fmt::Write;

/// Techniques with smaller shares of everything are not shown.
const LEAST_SHARE: f64 = 0.0005;

impl Page<'_> {
    pub(super) fn left_out(&mut self) {
        let report = &self.study.report;
        self.section("What is left out");
        self.text(
            "Exactly, before the first sample: techniques and path lengths that carry no light in this scene.",
        );
        self.html += &omissions(report);
        for method in report.methods.iter().filter(|m| !m.decisions.is_empty()) {
            let _ = write!(self.html, "<h3>What {} decided</h3>", escape(&method.name));
            self.html += &decisions(&method.decisions);
        }
    }
}

/// One row per integrator.
fn omissions(report: &Report) -> String {
    let mut html = head("integrator", ["left out"].into_iter());
    let measured = report.methods.iter().map(|m| (&m.name, reasons(m)));
    let idle = report
        .left_out
        .iter()
        .map(|m| (&m.name, format!("{}<br>no technique is left", text(&m.left_out))));
    for (name, reasons) in measured.chain(idle) {
        let name = escape(name);
        let _ =
            write!(html, "<tr><th scope=\"row\">{name}</th><td class=\"text\">{reasons}</td></tr>");
    }
    html + "</table></div>"
}

fn reasons(method: &MethodReport) -> String {
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
    reasons
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
