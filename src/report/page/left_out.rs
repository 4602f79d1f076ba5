//! The section on omissions, and on the decisions of integrators that adapt themselves.

use super::table::table;
use crate::report::result::{CandidateReport, DecisionReport, MethodReport, Omission, Report};
use crate::report::text::number;
use maud::{Markup, html};

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
        (table("what is left out", "integrator", ["left out"], measured.chain(idle)))
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

/// The decision of each run, and the choices that the first one had.
fn decisions(decisions: &[DecisionReport]) -> Markup {
    if decisions.iter().all(|decision| decision.pilot_samples == 0) {
        return html! {
            p { "No other set of techniques draws every path of this scene: there was no choice." }
        };
    }
    let columns = ["samples of the pilot", "sets to choose from", "expected gain", "what it runs"];
    let rows = decisions.iter().enumerate().map(|(run, decision)| {
        html! {
            tr {
                th scope="row" { (run + 1) }
                td { (decision.pilot_samples) }
                td { (decision.candidates.len()) }
                td { (number(decision.expected_gain)) }
                td.text.wide { (decision.techniques) }
            }
        }
    });
    html! {
        p {
            "Before each run a pilot, none of whose samples are in the image, finds the set of \
             techniques with the least variance × cost. Gain: over plain bidirectional path \
             tracing, as the pilot predicts."
        }
        (table("decisions", "run", columns, rows))
        p { "The sets that the first run chose from; the better ones drew more samples." }
        (candidates(&decisions[0].candidates))
    }
}

fn candidates(candidates: &[CandidateReport]) -> Markup {
    let rows = candidates.iter().map(|candidate| {
        let CandidateReport { techniques, variance, cost, samples, .. } = candidate;
        let cells = [number(*variance), number(*cost), number(variance * cost)];
        html! {
            tr {
                th scope="row" { (techniques) }
                @for cell in cells { td { (cell) } }
                td { (samples) }
            }
        }
    });
    let columns = ["variance", "cost in rays", "variance × cost", "samples"];
    table("sets of techniques", "techniques", columns, rows)
}
