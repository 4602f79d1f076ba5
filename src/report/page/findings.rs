//! The section on what single runs found out beside their images.

use super::table::{row, table};
use crate::report::result::{GuidanceReport, MethodReport, NormalizationReport, Report};
use crate::report::text::{number, percent};
use maud::{Markup, html};

pub(super) fn findings(report: &Report) -> Markup {
    html! {
        @if report.methods.iter().any(|m| !m.findings.is_empty()) {
            h2 { "What runs found out" }
            @for method in &report.methods {
                (normalizations(method))
                (guidance(method))
            }
        }
    }
}

/// A table of the runs that found something of a kind.
fn runs<F>(
    method: &MethodReport,
    found: impl Iterator<Item = (usize, F)>,
    text: &str,
    columns: [&str; 4],
    cells: impl Fn(F) -> [String; 4],
) -> Markup {
    let mut found = found.map(|(run, found)| row(run + 1, cells(found))).peekable();
    html! {
        @if found.peek().is_some() {
            h3 { (method.name) }
            p { (text) }
            (table(&method.name, "run", columns, found))
        }
    }
}

fn normalizations(method: &MethodReport) -> Markup {
    let found = method.findings.iter().enumerate();
    let found = found.filter_map(|(run, found)| Some((run, found.normalization?)));
    let text = "Markov chains tell where the image is brighter and by how much, and not how bright \
                it is. What scales them is the mean of independent samples, the candidates, at \
                some of which the chains begin. Its standard error is part of that of the run's \
                mean. Where a whole set of candidates is black, so are its passes.";
    let columns = ["scale", "standard error", "candidates", "black sets"];
    runs(method, found, text, columns, |found| {
        let NormalizationReport { mean, relative_standard_error, candidates, black } = found;
        let error = percent(relative_standard_error);
        [number(mean), error, candidates.to_string(), black.to_string()]
    })
}

fn guidance(method: &MethodReport) -> Markup {
    let found = method.findings.iter().enumerate();
    let found = found.filter_map(|(run, found)| Some((run, found.guidance?)));
    let text = "Walks that are not in the image learnt first where light comes from. Walks are \
                guided if variance × cost is expected to fall by it. Gain: over the same path \
                tracing without guiding, estimated from the walks that learnt.";
    let columns = ["guided", "expected gain", "parts of space", "samples learnt from"];
    runs(method, found, text, columns, |found| {
        let GuidanceReport { is_used, expected_gain, parts, samples } = found;
        let is_guided = if is_used { "yes" } else { "no" };
        let gain = if expected_gain > 0.0 { number(expected_gain) } else { "–".to_owned() };
        [is_guided.to_owned(), gain, parts.to_string(), samples.to_string()]
    })
}
