//! The way from runs to numbers with intervals.

use super::plan::Plan;
use super::runs::Runs;
use crate::math::Rgb;
use crate::math::statistics::sidak;
use crate::report::result::{
    LedgerReport, MethodReport, MissingReport, Pyramid, SharedReport, omissions,
};
use crate::report::stats::{
    BIAS_SIGNIFICANCE, BatchMean, Bias, Checkpoint, Errors, Interval, Layout, Measured, Reference,
    Slope, TimeToTarget, median_of_means,
};

/// The integrator that speed-ups are relative to: the one that the plan names, or the first, of
/// those that can have one.
pub(super) fn baseline<'a>(runs: &[&'a Runs], plan: &Plan) -> Option<&'a Measured> {
    let named = |m: &&Measured| plan.baseline.as_ref().is_none_or(|name| *name == m.name);
    rankable(runs).find(named)
}

/// Those whose variance × cost tells all of them.
pub(super) fn rankable<'a>(runs: &[&'a Runs]) -> impl Iterator<Item = &'a Measured> {
    runs.iter().map(|run| &run.measured).filter(|m| has_speed_up(m))
}

/// Variance × cost says all of an integrator if it sees everything, has no bias and has met enough;
/// what is better than an infinite one is better without limit.
fn has_speed_up(m: &Measured) -> bool {
    m.is_tested() && !m.has_infinite_variance() && m.undecided().is_none()
}

pub(super) fn methods(
    runs: &[&Runs],
    baseline: Option<&Measured>,
    reference: &Reference,
    target: f64,
) -> Vec<MethodReport> {
    let uniform = Layout::of(reference.image()).uniform_weights();
    let weights = [uniform, reference.bias_weights()];
    let tests = 2 * runs.iter().filter(|run| run.measured.is_tested()).count();
    let limit = sidak(BIAS_SIGNIFICANCE, tests);
    let bias = |run: &Runs| Bias::test(&run.measured, reference, &weights, limit);
    runs.iter().map(|run| method(run, bias(run), baseline, reference, target)).collect()
}

fn method(
    run: &Runs,
    bias: Bias,
    baseline: Option<&Measured>,
    reference: &Reference,
    target: f64,
) -> MethodReport {
    let m = &run.measured;
    let undecided = m.undecided();
    let has_curve = m.complete && undecided.is_none();
    let checkpoints: Vec<Checkpoint> =
        m.marks.iter().map(|mark| Checkpoint::of(mark, reference)).collect();
    let infinite_variance = m.has_infinite_variance();
    let speed_up = baseline.filter(|_| has_speed_up(m)).and_then(|base| m.speed_up(base));
    let slopes = Slope::all(&checkpoints, m.estimator, infinite_variance);
    let robust = median_of_means(&m.finals, (m.finals.len() / 2).max(1));
    let image = m.mean();
    let mean = BatchMean::of_sum(&m.batches, &Layout::of(&image).uniform_weights());
    let pixels = image.pixels().len() as f64;
    let rays: Vec<f64> = m.products(|c| c.rays).iter().map(|x| x / pixels).collect();
    let ledger = run.counters.ledger;
    let per_sample = |flux: Rgb| flux.luminance() / run.counters.samples.max(1) as f64;
    MethodReport {
        name: m.name.clone(),
        techniques: run.techniques.to_string(),
        left_out: omissions(&run.notes.left_out),
        decisions: run.decisions.clone(),
        findings: run.findings.clone(),
        complete: m.complete,
        missing: MissingReport::all(&run.notes.missing, m.complete),
        estimator: m.estimator,
        runs: m.finals.len() as u32,
        samples_per_pixel: m.samples,
        total: run.total,
        rays_per_sample: run.total.rays / m.all_samples(),
        cpu_per_sample: run.total.cpu / m.all_samples(),
        mean_image: Errors::of(&image, reference),
        median_of_means: robust.map(|image| Errors::of(&image, reference)).unwrap_or_default(),
        mean: mean.mean,
        mean_standard_error: mean.standard_error(),
        effective_contributions: mean.effective_contributions(),
        undecided: undecided.map(|reason| reason.to_string()),
        bias,
        variance_times_wall: Interval::of_positive(&m.products(|c| c.wall)),
        variance_times_cpu: Interval::of_positive(&m.products(|c| c.cpu)),
        variance_times_rays: Interval::of_positive(&rays),
        variance_per_sample: Interval::of_positive(&m.variances()),
        speed_up,
        time_to_target: if has_curve { TimeToTarget::of(m, target) } else { None },
        slopes: if has_curve { slopes } else { Vec::new() },
        tail: m.tail,
        infinite_variance,
        long_tails: m.has_long_tails(),
        non_finite_contributions: run.counters.non_finite,
        first_non_finite: run.first_non_finite.clone(),
        non_finite_pixels: m.errors().iter().map(|e| e.non_finite_pixels).sum(),
        ledger: LedgerReport {
            emitted: per_sample(ledger.emitted),
            absorbed: per_sample(ledger.absorbed),
            escaped: per_sample(ledger.escaped),
            truncated: per_sample(ledger.truncated),
            rejected: per_sample(ledger.rejected),
            clamped: per_sample(ledger.clamped),
        },
        shared: SharedReport {
            bytes: run.counters.shared_bytes,
            photons: run.counters.photons,
            queries: run.counters.queries,
            merges: run.counters.merges,
        },
        energy_by_bounces: run.energy_by_bounces.clone(),
        pyramid: run.pyramid.as_ref().map(Pyramid::report),
        checkpoints,
    }
}
