//! Integrators that are not unbiased: their bias is measured and stated, beside the variance, and is
//! no fault; in one that claims to be unbiased it is.

use super::{Synthetic, contestants, cornell_box, exactly, go_on};
use pathspace::film::{Contribution, Sample, Sink, Technique};
use pathspace::glam::UVec2;
use pathspace::integrator::{
    Crew, Estimator, Integrator, IntegratorError, Notes, PathTracer, Run, Stage, Started,
};
use pathspace::math::Rgb;
use pathspace::path::{Scratch, TechniqueSet};
use pathspace::render::{Budget, Settings};
use pathspace::report::stats::slope;
use pathspace::report::{
    Contestant, Interval, Method, MethodReport, Plan, Reference, ReferencePlan, Report,
    ReportError, SceneInfo, Study, study,
};
use pathspace::sampler::Sampler;
use pathspace::scene::{Scene, World};
use rand::{RngExt, SeedableRng};

const SIZE: u32 = 32;
const SEEDS: u32 = 8;
/// The samples per pixel of a run.
const PASSES: u32 = 512;
/// Noise of a sample of the first pass that it does not share with the others of its pass.
const NOISE: f64 = 0.5;

/// A method that shares something between the samples of a pass, as photon mapping does. A sample
/// of pass i = 1, 2 … is 1, plus a bias, plus noise of its own and of the pass.
#[derive(Clone, Copy, Debug)]
struct Progressive {
    claim: Estimator,
    is_correlated: bool,
    /// The bias of pass i is the first number times i to the power of the second.
    bias: [f64; 2],
    /// True if the right half of the image has the negative bias.
    cancels: bool,
    /// The noise of a pass grows with this power of i.
    growth: f64,
    /// Noise of the first pass.
    shared: f64,
}

/// Bias² and variance fall as N^(-2/3), as those of photon mapping with a shrinking radius.
const CONSISTENT: Progressive = Progressive {
    claim: Estimator::Consistent,
    is_correlated: true,
    bias: [0.4, -1.0 / 3.0],
    cancels: false,
    growth: 1.0 / 6.0,
    shared: 0.05,
};
/// The bias stays, and cancels in the mean of the image; the variance falls as 1/N.
const BIASED: Progressive = Progressive {
    claim: Estimator::Biased,
    bias: [0.05, 0.0],
    cancels: true,
    growth: 0.0,
    ..CONSISTENT
};

impl Progressive {
    fn mean_over_passes(passes: u32, exponent: f64) -> f64 {
        (1..=passes).map(|i| f64::from(i).powf(exponent)).sum::<f64>() / f64::from(passes)
    }

    /// Absolute bias of a pixel after so many passes.
    fn bias_after(&self, passes: u32) -> f64 {
        self.bias[0] * Self::mean_over_passes(passes, self.bias[1])
    }

    /// Variance of a pixel from the noise of the first pass.
    fn variance_after(&self, passes: u32, noise: f64) -> f64 {
        noise * noise * Self::mean_over_passes(passes, 2.0 * self.growth) / f64::from(passes)
    }
}

/// Uniform noise of variance 1.
fn noise(u: f64) -> f64 {
    12f64.sqrt() * (u - 0.5)
}

struct Passes {
    settings: Progressive,
    seed: u64,
    begun: u32,
    bias: f64,
    scale: f64,
    shared: f64,
}

impl<S: Scene + ?Sized> Integrator<S> for Progressive {
    type Run<'a>
        = Passes
    where
        S: 'a;

    fn name(&self) -> &'static str {
        "progressive"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Passes> {
        let seed = stage.seed;
        Ok(Passes { settings: *self, seed, begun: 0, bias: 0.0, scale: 0.0, shared: 0.0 })
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for Passes {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        TechniqueSet::BIDIRECTIONAL
    }

    fn notes(&self) -> Notes {
        let Progressive { claim: estimator, is_correlated, .. } = self.settings;
        Notes { estimator, is_correlated, ..Notes::default() }
    }

    fn learns(&self) -> bool {
        true
    }

    fn begin_pass(&mut self, pass: u32, _: &dyn Crew) -> Result<(), IntegratorError> {
        assert_eq!(self.begun, pass);
        self.begun += 1;
        let Progressive { bias, growth, shared, .. } = self.settings;
        let number = f64::from(self.begun);
        let mut random = rand_pcg::Pcg64::seed_from_u64(self.seed ^ u64::from(pass) << 10);
        self.bias = bias[0] * number.powf(bias[1]);
        self.scale = number.powf(growth);
        self.shared = shared * noise(random.random());
        Ok(())
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        assert!(self.begun > 0);
        scratch.counters.samples += samples.len() as u64;
        scratch.counters.closest_rays += samples.len() as u64;
        for (number, Sample { film, sampler }) in samples.iter_mut().enumerate() {
            let is_negative = self.settings.cancels && film.raster.x > f64::from(SIZE / 2);
            let bias = if is_negative { -self.bias } else { self.bias };
            let own = NOISE * noise(sampler.next_1d());
            let value = Rgb::splat(0.5 * (1.0 + bias + self.scale * (own + self.shared)));
            for technique in [Technique::new(0, 3), Technique::merge(2, 2)] {
                let raster = film.raster;
                sink.add(number, &Contribution { raster, value, weight: 1.0, technique });
            }
        }
    }
}

fn honest() -> impl Method<World> {
    Synthetic(|s: &mut dyn Sampler| 1.0 + NOISE * noise(s.next_1d()))
}

/// A study against the exact image, of the method and then of an honest one.
fn study_of(progressive: &Progressive, seed: u64, passes: u32) -> Study {
    study_against(exactly(1.0, UVec2::splat(SIZE)), progressive, seed, passes)
}

fn study_against(reference: Reference, progressive: &Progressive, seed: u64, passes: u32) -> Study {
    let (scene, honest) = (cornell_box(reference.image().width()), honest());
    let methods: [(&str, &dyn Method<World>); 2] =
        [("progressive", progressive), ("honest", &honest)];
    let [progressive, honest] = contestants(&methods).try_into().unwrap();
    let all = [Contestant { pyramid: true, ..progressive }, honest];
    let settings = Settings { seed, ..Plan::default().settings };
    let budget = Budget::Samples(SEEDS * passes);
    let plan = Plan { budget, seeds: SEEDS, settings, target: 1e-9, ..Plan::default() };
    let info = SceneInfo::default();
    study(&scene.world, &*scene.camera, &info, &all, reference, &plan, &mut go_on).unwrap()
}

/// Half the width of the interval that is left once in some thousand tests: of 95 % with 3 degrees
/// of freedom, times the ratio of the quantiles of Student's t.
fn assert_inside(name: &str, interval: Interval, exact: f64) {
    let [below, above] = [interval.value - interval.low, interval.high - interval.value];
    println!("{name}: {interval:?}, exact {exact:.5e}");
    assert!(below > 0.0 && above > 0.0, "{name}: {interval:?}");
    let half = 4.0 * below.max(above);
    assert!((interval.value - exact).abs() < half, "{name}: {interval:?}, expected {exact}");
}

/// All numbers that split the error are the exact ones.
fn assert_split(settings: &Progressive, method: &MethodReport) {
    for point in &method.checkpoints {
        let exact = [
            settings.bias_after(point.samples).powi(2),
            settings.variance_after(point.samples, NOISE.hypot(settings.shared)),
        ];
        assert_inside("squared bias", point.squared_bias, exact[0]);
        assert_inside("variance", point.variance, exact[1]);
        let sum = point.squared_bias.value + point.variance.value;
        assert!((sum / point.mse.value - 1.0).abs() < 1e-12);
    }
    let points: Vec<f64> = (0..4).map(|octave| f64::from(PASSES >> octave)).collect();
    let exact = |error: &dyn Fn(u32) -> f64| {
        let points = points.iter().map(|n| [n.ln(), error(*n as u32).ln(), 1.0]);
        slope(&points.collect::<Vec<_>>()).unwrap()
    };
    let squared_bias = exact(&|n| settings.bias_after(n).powi(2));
    let variance = exact(&|n| settings.variance_after(n, NOISE));
    let measures: Vec<&str> = method.slopes.iter().map(|s| s.measure.as_str()).collect();
    assert_eq!(measures, ["variance", "squared bias"]);
    for (slope, exact) in method.slopes.iter().zip([variance, squared_bias]) {
        assert_eq!((slope.from, slope.to), (PASSES / 8, PASSES));
        assert_inside(&slope.measure, slope.value, exact);
        assert!(slope.standard_error < 0.05, "{slope:?}");
    }
}

/// Its numbers are shown, and it takes part in no test and no comparison of variances.
fn assert_no_fault(report: &Report) {
    let [method, honest] = [0, 1].map(|i| &report.methods[i]);
    assert!(!method.bias.flagged && report.is_clean(), "{:?}", method.bias);
    assert!(!report.verdicts().iter().any(|v| v.starts_with("BIAS")), "{:?}", report.verdicts());
    assert!(report.pairs.is_empty() && report.setup.baseline.as_deref() == Some("honest"));
    assert!(method.speed_up.is_none() && honest.speed_up.is_some());
    // Its error does not fall as 1/t.
    assert!(method.time_to_target.is_none() && honest.time_to_target.unwrap().extrapolated);
    assert_eq!(honest.slopes[0].measure, "MSE");
}

#[test]
fn a_vanishing_bias_is_measured_and_is_no_fault() {
    let study = study_of(&CONSISTENT, 1, PASSES);
    let (report, page) = (&study.report, study.page());
    let method = &report.methods[0];
    assert_no_fault(report);
    assert_split(&CONSISTENT, method);
    let (bias, exact) = (&method.bias, CONSISTENT.bias_after(PASSES));
    assert_inside("bias", bias.mean_interval, exact);
    assert!((bias.mean - exact).abs() < 5.0 * bias.mean_standard_error);
    // Noise that pixels share stays in the mean of the image, and parts of a run with a bias of
    // their own are no batches.
    let runs = f64::from(SEEDS);
    let shared = CONSISTENT.variance_after(PASSES, CONSISTENT.shared) / runs;
    let own = CONSISTENT.variance_after(PASSES, NOISE) / runs / f64::from(SIZE * SIZE);
    let ratio = bias.mean_standard_error / (shared + own).sqrt();
    assert!((0.4..1.8).contains(&ratio), "{ratio}");
    assert_eq!(bias.mean_standard_error, method.mean_standard_error);
    let verdict =
        report.verdicts().into_iter().find(|v| v.starts_with("progressive is consistent"));
    let verdict = verdict.unwrap();
    assert!(verdict.contains("vanishes as passes are added: here as N^(-0.3"), "{verdict}");
    assert!(page.contains(&verdict) && page.contains("consistent: its bias vanishes"));
}

#[test]
fn a_bias_that_cancels_in_the_mean_is_measured_over_pixels() {
    let study = study_of(&BIASED, 1, PASSES);
    let method = &study.report.methods[0];
    assert_no_fault(&study.report);
    assert_split(&BIASED, method);
    assert!(method.bias.mean.abs() < 4.0 * method.bias.mean_standard_error, "{:?}", method.bias);
    let verdicts = study.report.verdicts();
    let verdict = verdicts.iter().find(|v| v.starts_with("progressive is biased")).unwrap();
    assert!(verdict.contains("It stays, however many passes are added: here as N^("), "{verdict}");
    assert!(study.page().contains("biased: some of its error stays"));
    let directory = std::env::temp_dir().join(format!("pathspace-bias-{}", std::process::id()));
    study.save(&directory).unwrap();
    let plot = std::fs::read_to_string(directory.join("bias.svg")).unwrap();
    assert_eq!(plot.matches("<polyline").count(), 2);
    assert!(plot.contains("progressive: variance") && plot.contains("progressive: squared bias"));
    std::fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn the_same_bias_in_an_integrator_that_claims_to_have_none_is_a_fault() {
    for planted in [CONSISTENT, Progressive { cancels: false, ..BIASED }] {
        let claim = Estimator::Unbiased;
        let report = study_of(&Progressive { claim, ..planted }, 1, PASSES / 8).report;
        assert!(report.methods[0].bias.flagged && !report.is_clean());
        assert!(report.verdicts().iter().any(|v| v.starts_with("BIAS: progressive")));
        assert!(report.pairs.iter().any(|pair| !pair.agrees()));
        assert_eq!(report.methods[0].slopes[0].measure, "MSE");
    }
}

/// Blocks of pixels that share their noise are all off at once, by as much as any error of the mean.
#[test]
fn noise_that_all_pixels_share_is_no_disagreement() {
    const STUDIES: u32 = 24;
    let claim = Estimator::Unbiased;
    let fair = Progressive { claim, bias: [0.0; 2], growth: 0.0, shared: 0.12, ..CONSISTENT };
    let (size, passes) = (2 * SIZE, PASSES / 32);
    let exact = fair.variance_after(passes, fair.shared.hypot(NOISE / f64::from(size)));
    let mut variance = 0.0;
    for seed in 0..STUDIES {
        let reference = exactly(1.0, UVec2::splat(size));
        let report = study_against(reference, &fair, u64::from(seed), passes).report;
        assert!(report.is_clean() && report.pairs.len() == 1, "{:?}", report.pairs);
        variance += report.methods[0].mean_standard_error.powi(2);
    }
    let ratio = variance / f64::from(STUDIES) / (exact / f64::from(SEEDS));
    assert!((0.6..1.4).contains(&ratio), "{ratio}");
}

/// A reference whose own variance is larger than the squared bias.
#[test]
fn the_variance_of_the_reference_is_no_bias() {
    let (scene, honest) = (cornell_box(SIZE), honest());
    let halves = contestants::<World>(&[("one", &honest), ("other", &honest)]);
    let halves = [&halves[0], &halves[1]];
    let budget = Budget::Samples(64);
    let plan = ReferencePlan { budget, runs: 16, settings: Plan::default().settings };
    let reference =
        Reference::render(&scene.world, &*scene.camera, halves, &plan, &mut go_on).unwrap();
    let own = NOISE * NOISE / 64.0;
    assert!((reference.own_mse() / own - 1.0).abs() < 0.05, "{}", reference.own_mse());
    let report = study_against(reference, &BIASED, 1, PASSES).report;
    for (method, exact) in report.methods.iter().zip([BIASED.bias_after(PASSES).powi(2), 0.0]) {
        let end = method.last().unwrap();
        assert!((end.squared_bias.value - exact).abs() < 0.15 * own, "{:?}", end.squared_bias);
        assert!(end.reference_limited && !end.bias_is_seen);
    }
    assert!(report.methods[0].slope("squared bias").is_none());
}

#[test]
fn a_reference_is_rendered_by_unbiased_integrators_only() {
    let scene = cornell_box(SIZE);
    let paths = PathTracer::up_to(2);
    let all = contestants::<World>(&[("path-tracing", &paths), ("map", &BIASED)]);
    let plan =
        ReferencePlan { budget: Budget::Samples(8), runs: 2, settings: Plan::default().settings };
    let halves = [&all[0], &all[1]];
    let reference =
        Reference::render(&scene.world, &*scene.camera, halves, &plan, &mut go_on).unwrap_err();
    assert!(matches!(&reference, ReportError::ReferenceBiased(name) if name == "map"));
}

#[test]
fn techniques_that_merge_are_layers_of_their_own() {
    let study = study_of(&CONSISTENT, 1, PASSES / 16);
    let method = &study.report.methods[0];
    let shares = &method.pyramid.as_ref().unwrap().techniques;
    let names: Vec<_> = shares.iter().map(|share| (share.s, share.t, share.merged)).collect();
    assert_eq!(names, [(0, 3, false), (2, 2, true)]);
    for share in shares {
        assert!((share.energy - 0.5).abs() < 1e-12 && (share.variance - 0.25).abs() < 1e-12);
        assert!(share.cost.is_nan() && share.efficiency_without.is_nan());
    }
    let pyramid = study.images[0].pyramid.as_ref().unwrap();
    let sum: f64 = pyramid.layers.iter().map(|layer| layer.weighted.mean().luminance()).sum();
    let is_mean = |mean: f64, passes| (mean - 1.0 - CONSISTENT.bias_after(passes)).abs() < 0.05;
    assert!(is_mean(sum, pyramid.passes), "{sum}");
    let page = study.page();
    assert!(page.contains("Techniques of progressive") && page.contains("merge (2, 2)"));
    let json = study.report.to_json();
    assert_eq!(serde_json::from_str::<Report>(&json).unwrap().to_json(), json);
    // The probe begins the passes, too.
    let energy = method.energy_by_bounces[1];
    assert!(is_mean(energy, SEEDS * PASSES / 16 / 16), "{energy}");
}
