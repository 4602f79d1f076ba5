//! From measurements to numbers with intervals.

use super::agreement::{LARGEST_RELATIVE_ERROR, LONG_TAILS, test_pairs};
use super::batches::{Batch, BatchMean, Layout};
use super::inference::{Interval, slope, time_to_error};
use super::leave_out;
use super::method::Probe;
use super::metrics::{Errors, median_of_means};
use super::pyramid::Pyramid;
use super::reference::Reference;
use super::result::{
    Bias, Checkpoint, Cost, LedgerReport, MethodReport, ReferenceInfo, Report, SCHEMA, SceneInfo,
    Setup, Slope, SpeedUp, TimeToTarget,
};
use super::runs::Mark;
use super::study::{Plan, Snapshot};
use crate::film::{Image, NonFinite};
use crate::integrator::Decision;
use crate::math::statistics::{Estimate, sidak};
use crate::math::student::student_t_p_value;
use crate::path::{Counters, LeftOut, TechniqueSet};
use crate::render::Budget;

/// A curve stops where the reference's own variance is more than this part of the error.
pub const REFERENCE_SHARE: f64 = 0.1;
/// Probability that any integrator without bias is flagged.
pub const BIAS_SIGNIFICANCE: f64 = 0.01;
/// Slopes are fitted to the last octaves of the number of samples.
const OCTAVES: u32 = 3;

/// All that was measured of one integrator.
pub(super) struct Measured {
    pub name: String,
    pub complete: bool,
    pub techniques: TechniqueSet,
    pub left_out: LeftOut,
    pub samples: u32,
    pub marks: Vec<Mark>,
    pub finals: Vec<Image>,
    pub mean: Image,
    pub batches: Vec<Batch>,
    pub snapshots: Vec<Snapshot>,
    pub counters: Counters,
    pub non_finite: Option<NonFinite>,
    pub total: Cost,
    pub decisions: Vec<Decision>,
    pub probe: Probe,
}

impl Measured {
    /// Variance of one sample per pixel as each run shows it, mean over pixels and channels.
    fn variances(&self) -> Vec<f64> {
        let runs = self.finals.len() as f64;
        let correction = if runs > 1.0 { runs / (runs - 1.0) } else { f64::NAN };
        let spread = |image: &Image| {
            let squares = image
                .pixels()
                .iter()
                .zip(self.mean.pixels())
                .map(|(i, m)| ((*i - *m) * (*i - *m)).mean());
            squares.sum::<f64>() / image.pixels().len().max(1) as f64
        };
        self.finals
            .iter()
            .map(|image| spread(image) * correction * f64::from(self.samples))
            .collect()
    }

    /// Relative standard error of an error over the runs; 0 if there is no error, infinite for a
    /// single run.
    fn uncertainty(&self, measure: fn(&Errors) -> f64) -> f64 {
        let runs: Estimate =
            self.marks.last().map_or(&[][..], |mark| &mark.errors).iter().map(measure).collect();
        if runs.count() < 2 {
            return f64::INFINITY;
        }
        if runs.mean() > 0.0 { runs.standard_error() / runs.mean() } else { 0.0 }
    }

    /// How well its mean squared error is known.
    pub fn mse_uncertainty(&self) -> f64 {
        self.uncertainty(|e| e.mse)
    }

    /// Whether rare, large contributions make up much of the relative variance, so that even all
    /// runs together do not know it well. Then whoever missed them in a block has too small a mean
    /// *and* too small a variance there, and no test can tell that from missing light.
    pub fn has_long_tails(&self) -> bool {
        self.uncertainty(|e| e.relative_mse) > LONG_TAILS
    }

    fn has_infinite_variance(&self) -> bool {
        self.probe.tail.is_some_and(|tail| tail.is_infinite_variance())
    }

    /// A sample's variance times what a sample costs, for each run.
    fn products(&self, cost: fn(&Cost) -> f64) -> Vec<f64> {
        let costs = self.marks.last().map_or(&[][..], |mark| &mark.cost);
        self.variances()
            .iter()
            .zip(costs)
            .map(|(v, c)| v * cost(c) / f64::from(self.samples))
            .collect()
    }

    /// Efficiency over that of another, with runs paired by seed.
    fn speed_up(&self, over: &Self) -> Option<SpeedUp> {
        let ratio = |cost: fn(&Cost) -> f64| {
            Interval::of_ratios(
                &over
                    .products(cost)
                    .iter()
                    .zip(self.products(cost))
                    .map(|(b, m)| b / m)
                    .collect::<Vec<_>>(),
            )
        };
        let wall = ratio(|c| c.wall)?;
        Some(SpeedUp { wall, cpu: ratio(|c| c.cpu).unwrap_or(wall), rays: ratio(|c| c.rays)? })
    }

    /// Samples of all runs and pixels.
    fn all_samples(&self) -> f64 {
        f64::from(self.samples)
            * self.finals.iter().map(|image| image.pixels().len() as f64).sum::<f64>()
    }

    fn rays_per_pixel(&self) -> Vec<f64> {
        let pixels = self.mean.pixels().len() as f64;
        self.products(|c| c.rays).iter().map(|x| x / pixels).collect()
    }
}

/// How it is measured, and on what machine; to be called before the work starts.
pub(super) fn setup(plan: &Plan) -> Setup {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let model = read("/proc/cpuinfo").and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    Setup {
        command: plan.command.clone(),
        seeds: plan.seeds,
        seed: plan.settings.seed,
        budget: match (plan.budget, plan.until_target) {
            (Budget::Samples(samples), false) => format!("{samples} samples per pixel"),
            (Budget::Time(time), false) => format!("{time:?}"),
            (Budget::Samples(samples), true) => {
                format!("what relMSE {} takes, at most {samples} samples per pixel", plan.target)
            }
            (Budget::Time(time), true) => {
                format!("what relMSE {} takes, at most {time:?}", plan.target)
            }
        },
        filter: format!("{:?}", plan.settings.filter),
        sampler: format!("{:?}", plan.settings.sampler),
        threads: plan.settings.threads,
        target: plan.target,
        until_target: plan.until_target,
        baseline: None,
        processor: model.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        processors: std::thread::available_parallelism().map_or(1, usize::from),
        load: read("/proc/loadavg")
            .map(|text| text.split_whitespace().take(3).collect::<Vec<_>>().join(" ")),
        debug_build: cfg!(debug_assertions),
    }
}

#[expect(clippy::too_many_arguments, reason = "a part of one function, split off for reading")]
pub(super) fn report(
    measured: &[Measured],
    reference: &Reference,
    scene: SceneInfo,
    setup: Setup,
    plan: &Plan,
    pyramid: Option<&Pyramid>,
    left_out: Vec<leave_out::WithoutTechnique>,
    stopped: bool,
) -> Report {
    let layout = Layout::of(reference.image());
    let uniform = layout.uniform_weights();
    let mean = reference.block_sum(&uniform);
    let weights = [uniform, reference.bias_weights()];
    let named = |m: &&Measured| plan.baseline.as_ref().is_none_or(|name| *name == m.name);
    // What is better than an infinite variance is better without limit.
    let baseline = measured.iter().filter(|m| m.complete && !m.has_infinite_variance()).find(named);
    let limit = sidak(BIAS_SIGNIFICANCE, 2 * measured.iter().filter(|m| m.complete).count());
    Report {
        schema: SCHEMA,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        scene,
        setup: Setup { baseline: baseline.map(|m| m.name.clone()), ..setup },
        reference: ReferenceInfo {
            origin: reference.origin().to_owned(),
            exact: reference.is_exact(),
            mean: mean.mean,
            mean_standard_error: mean.standard_error(),
            own_mse: reference.own_mse(),
            own_relative_mse: reference.own_relative_mse(),
        },
        methods: measured
            .iter()
            .map(|m| method(m, baseline, reference, &weights, limit, plan.target))
            .collect(),
        pairs: test_pairs(measured, layout),
        pyramid: pyramid.map(Pyramid::report),
        left_out,
        stopped,
    }
}

fn method(
    m: &Measured,
    baseline: Option<&Measured>,
    reference: &Reference,
    weights: &[Vec<f64>; 2],
    limit: f64,
    target: f64,
) -> MethodReport {
    let checkpoints: Vec<Checkpoint> =
        m.marks.iter().map(|mark| checkpoint(mark, reference)).collect();
    let tail = m.probe.tail;
    let infinite_variance = m.has_infinite_variance();
    let speed_up =
        baseline.filter(|_| m.complete && !infinite_variance).and_then(|base| m.speed_up(base));
    let groups = (m.finals.len() / 2).max(1);
    let robust = median_of_means(&m.finals, groups);
    let mean = BatchMean::of_sum(&m.batches, &weights[0]);
    let ledger = m.counters.ledger;
    let per_sample = |flux: crate::math::Rgb| flux.luminance() / m.counters.samples.max(1) as f64;
    let first = m.non_finite.as_ref().and_then(NonFinite::first);
    MethodReport {
        name: m.name.clone(),
        techniques: m.techniques.to_string(),
        left_out: leave_out::omissions(&m.left_out),
        decisions: m.decisions.iter().map(leave_out::DecisionReport::from).collect(),
        complete: m.complete,
        runs: m.finals.len() as u32,
        samples_per_pixel: m.samples,
        total: m.total,
        rays_per_sample: m.total.rays / m.all_samples(),
        cpu_per_sample: m.total.cpu / m.all_samples(),
        mean_image: Errors::of(&m.mean, reference),
        median_of_means: robust.map(|image| Errors::of(&image, reference)).unwrap_or_default(),
        mean: mean.mean,
        mean_standard_error: mean.standard_error(),
        bias: bias(m, reference, weights, limit),
        variance_times_wall: Interval::of_positive(&m.products(|c| c.wall)),
        variance_times_cpu: Interval::of_positive(&m.products(|c| c.cpu)),
        variance_times_rays: Interval::of_positive(&m.rays_per_pixel()),
        variance_per_sample: Interval::of_positive(&m.variances()),
        speed_up,
        time_to_target: if m.complete {
            time_to_target(m, target, infinite_variance)
        } else {
            None
        },
        slope: if m.complete { fit_slope(&checkpoints, infinite_variance) } else { None },
        tail,
        infinite_variance,
        long_tails: m.has_long_tails(),
        non_finite_contributions: m.counters.non_finite,
        first_non_finite: first.map(|f| {
            let technique = f.contribution.technique;
            format!(
                "pixel ({}, {}), sample {}, technique ({}, {})",
                f.pixel.x, f.pixel.y, f.pass, technique.s, technique.t
            )
        }),
        non_finite_pixels: m
            .marks
            .last()
            .map_or(0, |mark| mark.errors.iter().map(|e| e.non_finite_pixels).sum()),
        ledger: LedgerReport {
            emitted: per_sample(ledger.emitted),
            absorbed: per_sample(ledger.absorbed),
            escaped: per_sample(ledger.escaped),
            truncated: per_sample(ledger.truncated),
            rejected: per_sample(ledger.rejected),
        },
        energy_by_bounces: m.probe.energy_by_bounces.clone(),
        checkpoints,
    }
}

fn checkpoint(mark: &Mark, reference: &Reference) -> Checkpoint {
    let interval = |measure: fn(&Errors) -> f64| {
        Interval::of_positive(&mark.errors.iter().map(measure).collect::<Vec<_>>())
    };
    let runs = mark.errors.len() as f64;
    let average = |cost: fn(&Cost) -> f64| mark.cost.iter().map(cost).sum::<f64>() / runs;
    let deviations = mark.deviation.pixels().iter().map(|d| (*d * *d).mean()).sum::<f64>();
    let squared_mean = deviations / mark.deviation.pixels().len().max(1) as f64 / (runs * runs);
    let variance = if runs > 1.0 {
        ((mark.squares - runs * squared_mean) / (runs - 1.0)).max(0.0)
    } else {
        f64::NAN
    };
    let mse = interval(|e| e.mse);
    Checkpoint {
        samples: mark.samples,
        cost: Cost {
            wall: average(|c| c.wall),
            cpu: average(|c| c.cpu),
            rays: average(|c| c.rays),
            scattered: average(|c| c.scattered),
        },
        costs: mark.cost.clone(),
        runs: mark.errors.clone(),
        mse,
        relative_mse: interval(|e| e.relative_mse),
        mape: interval(|e| e.mape),
        smape: interval(|e| e.smape),
        median_squared: interval(|e| e.median_squared),
        variance,
        squared_bias: squared_mean - variance / runs - reference.own_mse(),
        reference_limited: reference.own_mse() > REFERENCE_SHARE * mse.value,
    }
}

fn bias(m: &Measured, reference: &Reference, weights: &[Vec<f64>; 2], limit: f64) -> Bias {
    let [(mean, mean_p), (relative, relative_p)] = [0, 1].map(|i| {
        let (measured, expected) =
            (BatchMean::of_sum(&m.batches, &weights[i]), reference.block_sum(&weights[i]));
        let difference = measured.plus(expected, -1.0);
        let error = difference.standard_error();
        // Equal but for rounding.
        let negligible = difference.mean.abs() <= 1e-9 * expected.mean.abs();
        let p = if negligible || error.is_infinite() {
            1.0
        } else {
            student_t_p_value(difference.mean / error, difference.freedom)
        };
        (difference, p)
    });
    // Whoever missed rare, bright contributions is too dark and believes too small an error; so may
    // a rendered reference.
    let no_mean = m.mse_uncertainty() > LARGEST_RELATIVE_ERROR;
    let heavy = no_mean || m.has_long_tails() || m.has_infinite_variance();
    let is_off = |bias: f64, p: f64, noisy: bool| {
        p < limit && !(noisy && (bias < 0.0 || !reference.is_exact()))
    };
    Bias {
        mean: mean.mean,
        mean_standard_error: mean.standard_error(),
        mean_p_value: mean_p,
        relative: relative.mean,
        relative_standard_error: relative.standard_error(),
        relative_p_value: relative_p,
        flagged: m.complete
            && (is_off(mean.mean, mean_p, no_mean) || is_off(relative.mean, relative_p, heavy)),
    }
}

/// Weighted least squares of log error over log samples for each run, and the mean of the runs'
/// slopes: checkpoints of one run are correlated, runs are not.
fn fit_slope(checkpoints: &[Checkpoint], robust: bool) -> Option<Slope> {
    let measure: fn(&Errors) -> f64 = if robust { |e| e.median_squared } else { |e| e.mse };
    let positive = |c: &&Checkpoint| {
        !c.reference_limited && c.runs.iter().all(|e| measure(e) > 0.0 && measure(e).is_finite())
    };
    let usable: Vec<&Checkpoint> = checkpoints.iter().filter(positive).collect();
    let last = usable.last()?.samples;
    let fitted: Vec<&Checkpoint> =
        usable.into_iter().filter(|c| c.samples.saturating_mul(1 << OCTAVES) >= last).collect();
    let from = fitted.first().filter(|c| c.samples < last)?.samples;
    let weights: Vec<f64> = fitted
        .iter()
        .map(|c| {
            let spread: Estimate = c.runs.iter().map(|e| measure(e).ln()).collect();
            1.0 / spread.variance().max(1e-6)
        })
        .collect();
    let points = |run: usize| -> Vec<[f64; 3]> {
        fitted
            .iter()
            .zip(&weights)
            .map(|(c, w)| [f64::from(c.samples).ln(), measure(&c.runs[run]).ln(), *w])
            .collect()
    };
    let slopes: Vec<f64> =
        (0..fitted[0].runs.len()).filter_map(|run| slope(&points(run))).collect();
    let estimate: Estimate = slopes.iter().copied().collect();
    let name = if robust { "MedSE" } else { "MSE" };
    Some(Slope {
        measure: name.to_owned(),
        from,
        to: last,
        value: Interval::of_mean(&slopes),
        standard_error: if estimate.count() > 1 { estimate.standard_error() } else { f64::NAN },
    })
}

/// Of relMSE, for each run. Where the variance is infinite the error does not fall as 1/t, and
/// nothing is extrapolated.
fn time_to_target(m: &Measured, target: f64, infinite_variance: bool) -> Option<TimeToTarget> {
    let curve = |run: usize| -> Vec<(f64, f64)> {
        m.marks.iter().map(|mark| (mark.cost[run].wall, mark.errors[run].relative_mse)).collect()
    };
    let times: Vec<_> = (0..m.finals.len()).map(|run| time_to_error(&curve(run), target)).collect();
    let reached = times.iter().filter(|time| time.is_ok()).count();
    let extrapolated = reached < times.len();
    if times.is_empty() || extrapolated && infinite_variance {
        return None;
    }
    let seconds = times
        .into_iter()
        .map(|time| time.map_or_else(|later| later, Some))
        .collect::<Option<Vec<_>>>()?;
    Some(TimeToTarget {
        seconds: Interval::of_positive(&seconds),
        reached: reached as u32,
        extrapolated,
    })
}
