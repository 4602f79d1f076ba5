//! The section on what single runs found out beside their images.

use super::table::{row, table};
use crate::report::result::{FindingsReport, GuidanceReport, NormalizationReport, Report};
use crate::report::text::{number, percent};
use maud::{Markup, html};

const CHAINS: &str = "Markov chains tell where the image is brighter and by how much, and not how \
                      bright it is. What scales them is the mean of independent samples, the \
                      candidates, at some of which the chains begin. Its standard error is part \
                      of that of the run's mean. Where a whole set of candidates is black, so are \
                      its passes.";
const GUIDING: &str = "Walks that are not in the image learnt first where light comes from. Walks \
                       are guided if variance × cost is expected to fall by it. Gain: over the \
                       same path tracing without guiding, estimated from the walks that learnt.";

pub(super) fn findings(report: &Report) -> Markup {
    html! {
        @if report.methods.iter().any(|m| !m.findings.is_empty()) {
            h2 { "What runs found out" }
            (runs(
                report,
                ("The scale of Markov chains", CHAINS),
                ["scale", "standard error", "candidates", "black sets"],
                |found| found.normalization.as_ref().map(normalization),
            ))
            (runs(
                report,
                ("Guiding", GUIDING),
                ["guided", "expected gain", "parts of space", "samples learnt from"],
                |found| found.guidance.as_ref().map(guidance),
            ))
        }
    }
}

/// A table of all runs that found something of a kind.
fn runs(
    report: &Report,
    (kind, text): (&str, &str),
    columns: [&str; 4],
    cells: fn(&FindingsReport) -> Option<[String; 4]>,
) -> Markup {
    let all = report.methods.iter().flat_map(|method| {
        let runs = (1..).zip(&method.findings);
        runs.filter_map(move |(run, found)| {
            Some(row(format!("{}, {run}", method.name), cells(found)?))
        })
    });
    let mut all = all.peekable();
    html! {
        @if all.peek().is_some() {
            h3 { (kind) }
            p { (text) }
            (table(kind, "integrator, run", columns, all))
        }
    }
}

fn normalization(found: &NormalizationReport) -> [String; 4] {
    let NormalizationReport { mean, relative_standard_error, candidates, black } = found;
    let error = percent(*relative_standard_error);
    [number(*mean), error, candidates.to_string(), black.to_string()]
}

fn guidance(found: &GuidanceReport) -> [String; 4] {
    let GuidanceReport { is_used, expected_gain, parts, samples } = found;
    let is_guided = if *is_used { "yes" } else { "no" };
    let gain = if *expected_gain > 0.0 { number(*expected_gain) } else { "–".to_owned() };
    [is_guided.to_owned(), gain, parts.to_string(), samples.to_string()]
}
