//! The section on omissions, and on the decisions of integrators that adapt themselves.

use super::table::{number, percent, row, table};
use crate::report::result::{DecisionReport, MethodReport, Omission, Report, TechniqueDecision};
use maud::{Markup, html};

/// Techniques with smaller shares of everything are not shown.
const LEAST_SHARE: f64 = 0.0005;

pub(super) fn left_out(report: &Report) -> Markup {
    let text = |reasons: Markup| html! { td.text { (reasons) } };
    let named = |name: &str, reasons| html! { tr { th scope="row" { (name) } (text(reasons)) } };
    let measured = report.methods.iter().map(|m| named(&m.name, reasons(m)));
    let idle = report
        .left_out
        .iter()
        .map(|m| named(&m.name, html! { (omissions(&m.left_out)) br; "no technique is left" }));
    html! {
        h2 { "What is left out" }
        p {
            "Exactly, before the first sample: techniques and path lengths that carry no light in \
             this scene."
        }
        (table("integrator", ["left out"], measured.chain(idle)))
        @for method in report.methods.iter().filter(|m| !m.decisions.is_empty()) {
            h3 { "What " (method.name) " decided" }
            (decisions(&method.decisions))
        }
    }
}

fn reasons(method: &MethodReport) -> Markup {
    let chose = method.decisions.iter().any(|decision| decision.pilot_samples > 0);
    html! {
        @match (method.left_out.is_empty(), chose) {
            (true, false) => { "nothing: the scene rules nothing out for it" }
            (true, true) => { "what its pilot found not to pay, see below" }
            (false, _) => {
                (omissions(&method.left_out))
                @if chose { br; "and what its pilot found not to pay, see below" }
            }
        }
    }
}

fn omissions(left_out: &[Omission]) -> Markup {
    html! {
        @for (i, omission) in left_out.iter().enumerate() {
            @if i > 0 { br; }
            (omission.what) ": " (omission.why)
        }
    }
}

/// The decision of each run, and the shares of the techniques.
fn decisions(decisions: &[DecisionReport]) -> Markup {
    if decisions.iter().all(|decision| decision.pilot_samples == 0) {
        return html! {
            p { "No other set of techniques draws every path of this scene: there was no choice." }
        };
    }
    let columns = [
        "samples of the pilot",
        "sets to choose from",
        "expected gain",
        "achieved gain",
        "what it runs",
    ];
    let rows = decisions.iter().enumerate().map(|(run, decision)| {
        html! {
            tr {
                th scope="row" { (run + 1) }
                td { (decision.pilot_samples) }
                td { (decision.candidates) }
                td { (number(decision.expected_gain)) }
                td { (number(decision.achieved_gain)) }
                td.text.wide { (decision.techniques) }
            }
        }
    });
    let mean = |share: fn(&DecisionReport) -> f64| {
        100.0 * decisions.iter().map(share).sum::<f64>() / decisions.len() as f64
    };
    html! {
        p {
            "Before each run a pilot, none of whose samples are in the image, finds the set of \
             techniques with the least variance × cost. Gain: over plain bidirectional path \
             tracing, as the pilot predicts and as it was when the choice was run."
        }
        (table("run", columns, rows))
        p {
            "Shares of the techniques in plain bidirectional path tracing, mean over the pilots. \
             Energy: of the mean luminance. Variance: of the second moment of weighted \
             contributions. Cost: of connections alone, without the walks, which techniques \
             share: those from the camera are " (format!("{:.1}", mean(|d| d.camera_walks)))
            " % of the cost, those from the lights " (format!("{:.1}", mean(|d| d.light_walks)))
            " %. Those with less than " (100.0 * LEAST_SHARE) " % of each are not shown."
        }
        (shares(decisions))
    }
}

fn shares(decisions: &[DecisionReport]) -> Markup {
    let runs = decisions.len();
    let all = decisions.first().map_or(&[][..], |decision| &decision.shares);
    let rows = all.iter().filter_map(|TechniqueDecision { s, t, .. }| {
        let same = |share: &&TechniqueDecision| (share.s, share.t) == (*s, *t);
        let found: Vec<&TechniqueDecision> =
            decisions.iter().filter_map(|decision| decision.shares.iter().find(same)).collect();
        let mean = |share: fn(&TechniqueDecision) -> f64| {
            found.iter().map(|x| share(x)).sum::<f64>() / runs as f64
        };
        let shares = [mean(|x| x.energy), mean(|x| x.variance), mean(|x| x.cost)];
        if shares.iter().all(|share| *share < LEAST_SHARE) {
            return None;
        }
        let verdict = match found.iter().filter(|share| share.kept).count() {
            0 => "left out".to_owned(),
            kept if kept == runs => "kept".to_owned(),
            kept => format!("kept in {kept} of {runs} runs"),
        };
        let [energy, variance, cost] = shares.map(percent);
        let bounces = (s + t).saturating_sub(2).to_string();
        Some(row(format!("({s}, {t})"), [bounces, energy, variance, cost, verdict]))
    });
    table("(s, t)", ["scattering events", "energy", "variance", "cost", "verdict"], rows)
}
