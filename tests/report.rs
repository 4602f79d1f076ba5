//! The report measures what is known exactly, sees what is planted, and repeats itself to the bit.
#![allow(missing_docs, reason = "a test program")]

mod common;

use common::{DownCamera, SphereCap};
use pathspace::endpoint::{Camera, PinholeCamera};
use pathspace::film::{Contribution, FilmSample, Image, Sink, Technique};
use pathspace::geometry::{Disk, Quad};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{Bidirectional, Depth, Integrator, LightTracer, PathTracer, PathTracing, UniformArea};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, Roulette, Scratch, Survival, TechniqueSet};
use pathspace::render::{Budget, Settings};
use pathspace::report::{
    Contestant, Interval, Method, Plan, Reference, ReferencePlan, Report, ReportError, SceneInfo, Step, Study, cached_reference, study,
};
use pathspace::sampler::Sampler;
use pathspace::scene::{Emission, Material, Needs, Scene, World, WorldBuilder, gallery};
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn go_on(_: &Step<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn contestants<'a, S: Scene + ?Sized>(methods: &[(&str, &'a dyn Method<S>)]) -> Vec<Contestant<'a, S>> {
    methods.iter().map(|&(name, method)| Contestant { name: name.to_owned(), method, complete: true }).collect()
}

/// A study against a known constant.
fn against<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    methods: &[(&str, &dyn Method<S>)],
    exact: f64,
    samples: u32,
    seeds: u32,
) -> Report {
    let size = camera.film().window_size();
    let reference = Reference::exact(Image::from_fn(size.x, size.y, |_, _| Rgb::splat(exact))).unwrap();
    let plan = Plan { budget: Budget::Samples(samples), seeds, ..Plan::default() };
    let info = SceneInfo::default();
    study(scene, camera, &info, &contestants(methods), reference, &plan, &mut go_on).unwrap().report
}

/// The exact value is inside the interval of 95 %, widened to one that is left once in some thousand tests.
fn assert_inside(name: &str, interval: Interval, exact: f64) {
    let (low, high) = (interval.value - interval.low, interval.high - interval.value);
    let inside = interval.value - 2.0 * low <= exact && exact <= interval.value + 2.0 * high;
    assert!(inside, "{name}: {interval:?}, expected {exact}");
    assert!(high < 0.1 * exact, "{name}: {interval:?} is too wide to mean anything");
}

/// analytic.json B06 and F12: variances, and variance × rays, of the estimators of light from a square.
#[test]
fn variances_on_the_square_light_are_the_exact_ones() {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) }).unwrap();
    let black = builder.add_material("black", Material::Lambert { albedo: Rgb::BLACK }).unwrap();
    builder.add_disk("floor", Disk { center: DVec3::ZERO, normal: DVec3::Z, radius: 10.0 }, grey).unwrap();
    let quad = Quad { origin: DVec3::new(-1.0, -1.0, 2.0), edge_u: DVec3::Y * 2.0, edge_v: DVec3::X * 2.0 };
    let lamp = builder.add_quad("lamp", quad, black).unwrap();
    builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false }).unwrap();
    let world = builder.build().unwrap();
    let camera = PinholeCamera::new(DVec3::new(0.0, -3.0, 1.0), DVec3::ZERO, DVec3::Z, 1e-4, UVec2::new(32, 32)).unwrap();

    let one_bounce = |mode, heuristic| PathTracer { mode, heuristic, depth: Depth::exactly(1), roulette: Roulette::NEVER };
    let area = one_bounce(PathTracing::NextEventOnly, Heuristic::Balance);
    let cosine = one_bounce(PathTracing::EmissionOnly, Heuristic::Balance);
    let balance = one_bounce(PathTracing::Both, Heuristic::Balance);
    let power = one_bounce(PathTracing::Both, Heuristic::Power(2.0));
    let without_hits = TechniqueSet { emitter_sampling: true, ..TechniqueSet::NONE };
    let kernel =
        Bidirectional { techniques: without_hits, depth: Depth::exactly(1), roulette: Roulette::NEVER, heuristic: Heuristic::Balance };
    let kernel_balance = Bidirectional { techniques: TechniqueSet { emitter_hits: true, ..without_hits }, ..kernel };
    let methods: [(&str, &dyn Method<World>); 6] = [
        ("area", &area),
        ("cosine", &cosine),
        ("balance", &balance),
        ("power", &power),
        ("bidirectional area", &kernel),
        ("bidirectional balance", &kernel_balance),
    ];
    let report = against(&world, &camera, &methods, 0.119_728_235_230_386_77, 16 * 32, 16);
    let [area, cosine, balance, power] =
        [0.000_435_127_402_779_776_8, 0.045_529_267_303_810_56, 0.001_994_928_765_599_786, 0.000_482_741_474_352_731_8];
    for (method, variance) in report.methods.iter().zip([area, cosine, balance, power, area, balance]) {
        assert_inside(&method.name, method.variance_per_sample, variance);
        let per_ray = method.variance_times_rays.value / method.rays_per_sample;
        assert!((per_ray / method.variance_per_sample.value - 1.0).abs() < 1e-9, "{}", method.name);
        assert!(!method.bias.flagged && method.bias.mean.abs() < 4.0 * method.bias.mean_standard_error, "{:?}", method.bias);
        let slope = method.slope.as_ref().unwrap();
        assert!((slope.value.value + 1.0).abs() < 4.0 * slope.standard_error.max(0.01), "{}: {slope:?}", method.name);
        assert!(!method.infinite_variance, "{}: {:?}", method.name, method.tail);
        assert_eq!(method.non_finite_contributions, 0);
    }
    assert!(report.is_clean(), "{:?}", report.pairs);
    // One technique less is 4.6 times as efficient per sample.
    let speed_up = balance / area;
    let measured = report.methods[2].variance_per_sample.value / report.methods[0].variance_per_sample.value;
    assert!((measured / speed_up - 1.0).abs() < 0.1, "{measured} instead of {speed_up}");
}

/// analytic.json F01, F02 and F03, on a host's own scene.
#[test]
fn variances_in_the_sphere_with_a_cap_are_the_exact_ones() {
    let (scene, camera) = (SphereCap::new(0.5, 0.1), DownCamera { half_width: 0.5 });
    for k in 1..=3 {
        let uniform = UniformArea { depth: Depth::exactly(k), roulette: Roulette::NEVER };
        let mean = 0.1 * 0.5f64.powi(k as i32);
        let report = against(&scene, &camera, &[("uniform area", &uniform)], mean, 64 * 4096, 64);
        let exact = 0.25f64.powi(k as i32) * 0.1 * 0.9;
        // A single pixel: the spread of 64 runs knows its variance to 18 %.
        let measured = report.methods[0].variance_per_sample.value;
        assert!((measured / exact - 1.0).abs() < 4.0 * (2.0 / 63.0f64).sqrt(), "k = {k}: {measured} instead of {exact}");
        assert!(!report.methods[0].bias.flagged);
    }
    let one_bounce = |mode, heuristic| PathTracer { mode, heuristic, depth: Depth::exactly(1), roulette: Roulette::NEVER };
    let next_event = one_bounce(PathTracing::NextEventOnly, Heuristic::Balance);
    let report = against(&scene, &camera, &[("next event", &next_event)], 0.05, 64, 8);
    assert!(report.methods[0].variance_per_sample.value < 1e-24 && !report.methods[0].bias.flagged);
    let (balance, power) = (one_bounce(PathTracing::Both, Heuristic::Balance), one_bounce(PathTracing::Both, Heuristic::Power(2.0)));
    let report = against(&scene, &camera, &[("balance", &balance), ("power", &power)], 0.05, 64 * 4096, 64);
    for (method, exact) in report.methods.iter().zip([0.000_185_950_413_223_140_49, 2.205_666_111_165_572e-6]) {
        let measured = method.variance_per_sample.value;
        assert!((measured / exact - 1.0).abs() < 4.0 * (2.0 / 63.0f64).sqrt(), "{}: {measured} instead of {exact}", method.name);
    }
}

/// analytic.json F04: roulette in the furnace, V = ρ² (1 - p) / ((1 - ρ)² (p - ρ²)).
#[test]
fn roulette_in_the_furnace_has_the_exact_variance() {
    let (scene, camera) = (SphereCap::new(0.5, 1.0), DownCamera { half_width: 0.5 });
    let roulette = |p| Roulette { start: 0, survival: Survival::Fixed(p), ..Roulette::default() };
    let tracer = |p| PathTracer { mode: PathTracing::EmissionOnly, roulette: roulette(p), ..PathTracer::default() };
    let (half, more) = (tracer(0.5), tracer(0.75));
    let report = against(&scene, &camera, &[("0.5", &half), ("0.75", &more)], 2.0, 64 * 4096, 64);
    for (method, exact) in report.methods.iter().zip([2.0, 0.5]) {
        let measured = method.variance_per_sample.value;
        assert!((measured / exact - 1.0).abs() < 4.0 * (2.0 / 63.0f64).sqrt(), "{}: {measured} instead of {exact}", method.name);
        assert!(!method.bias.flagged, "{:?}", method.bias);
    }
}

/// An integrator whose contributions are numbers from a formula: a user's own, for any scene.
struct Synthetic<F>(F);

impl<S: Scene + ?Sized, F: Fn(&mut dyn Sampler) -> f64 + Sync> Integrator<S> for Synthetic<F> {
    fn name(&self) -> &'static str {
        "synthetic"
    }
    fn techniques(&self, _: &Needs) -> TechniqueSet {
        TechniqueSet::BIDIRECTIONAL
    }
    fn sample<'s, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        _: &'s S,
        _: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        scratch.counters.samples += 1;
        let value = Rgb::splat((self.0)(sampler));
        sink.add(&Contribution { raster: film.raster, value, weight: 1.0, technique: Technique { s: 0, t: 2 } });
    }
}

fn cornell_box(size: u32) -> gallery::GalleryScene {
    gallery::build("cornell-box", UVec2::splat(size)).unwrap()
}

/// analytic.json F06: the roulette formula with a constant c, as an integrator.
#[test]
fn roulette_with_a_constant_has_the_exact_variance() {
    let box_ = cornell_box(32);
    let roulette = |c: f64| {
        Synthetic(move |s: &mut dyn Sampler| {
            let (xi, u) = (s.next_1d(), s.next_1d());
            Roulette::apply(0.4, c, xi, || 0.5 + (3.0 * 0.04f64).sqrt() * (2.0 * u - 1.0))
        })
    };
    let (some, none, best) = (roulette(0.3), roulette(0.0), roulette(0.5));
    let report = against(&box_.world, &*box_.camera, &[("0.3", &some), ("0", &none), ("0.5", &best)], 0.5, 8 * 64, 8);
    for (method, exact) in report.methods.iter().zip([0.093_333_333_333_333_34, 0.233_333_333_333_333_34, 0.066_666_666_666_666_67]) {
        assert_inside(&method.name, method.variance_per_sample, exact);
    }
}

/// analytic.json F09: two unit squares at a right angle; the geometry term of uniform points has the tail index 3/2, and errors
/// fall as N^(-1/3).
#[test]
fn the_corner_is_recognised_as_heavy_tailed() {
    let corner = Synthetic(|s: &mut dyn Sampler| {
        let (a, b) = (s.next_2d(), s.next_2d());
        let difference = DVec3::new(a.x, a.y, 0.0) - DVec3::new(0.0, b.x, b.y);
        let r2 = difference.length_squared();
        if r2 > 0.0 { a.x * b.y / (r2 * r2) } else { 0.0 }
    });
    let box_ = cornell_box(32);
    let report = against(&box_.world, &*box_.camera, &[("corner", &corner)], 0.628_456_057_314_848_2, 8 * 1024, 8);
    let method = &report.methods[0];
    let tail = method.tail.unwrap();
    assert!((tail.index - 1.5).abs() < 4.0 * tail.standard_error && tail.standard_error < 0.15, "{tail:?}");
    assert!(method.infinite_variance && method.speed_up.is_none());
    let slope = method.slope.as_ref().unwrap();
    assert_eq!(slope.measure, "MedSE");
    assert!((slope.value.value + 2.0 / 3.0).abs() < 0.05 + 2.0 * slope.standard_error, "{slope:?}");
}

/// Scales or spoils what another integrator contributes.
struct Planted<I> {
    inner: I,
    factor: f64,
    /// A pixel whose contributions are not numbers.
    spoiled: Option<UVec2>,
}

impl<S: Scene + ?Sized, I: Integrator<S>> Integrator<S> for Planted<I> {
    fn name(&self) -> &'static str {
        "planted"
    }
    fn techniques(&self, needs: &Needs) -> TechniqueSet {
        self.inner.techniques(needs)
    }
    fn sample<'s, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        let mut contributions = Vec::<Contribution>::new();
        self.inner.sample(scene, camera, film, sampler, &mut contributions, scratch);
        for mut contribution in contributions {
            contribution.value *= self.factor;
            if self.spoiled == Some(film.raster.floor().as_uvec2()) {
                contribution.value = Rgb::new(f64::NAN, 1.0, 1.0);
            }
            sink.add(&contribution);
        }
    }
}

/// Bias ± standard error of the weighted image mean over all runs sees what no single pixel shows.
#[test]
fn a_bias_of_half_a_percent_is_flagged_and_none_is_not() {
    let scene = cornell_box(48);
    let honest = Bidirectional::up_to(3);
    let planted = Planted { inner: honest, factor: 1.005, spoiled: None };
    let paths = PathTracer::up_to(3);
    let all = contestants::<World>(&[("honest", &honest), ("planted", &planted), ("path tracing", &paths)]);
    let reference = ReferencePlan { budget: Budget::Samples(512), runs: 16, settings: Settings { seed: 77, ..Settings::default() } };
    let reference = Reference::render(&scene.world, &*scene.camera, [&all[0], &all[2]], &reference, &mut go_on).unwrap();
    let plan = Plan { budget: Budget::Samples(256), seeds: 8, ..Plan::default() };
    let report = study(&scene.world, &*scene.camera, &SceneInfo::default(), &all[..2], reference, &plan, &mut go_on).unwrap().report;
    let [honest, planted] = [&report.methods[0].bias, &report.methods[1].bias];
    assert!(!honest.flagged, "{honest:?}");
    assert!(planted.flagged, "{planted:?}");
    assert!((planted.relative - 0.005).abs() < 4.0 * planted.relative_standard_error, "{planted:?}");
    assert!(planted.relative_standard_error < 0.0015 && !report.is_clean());
}

#[test]
fn a_pixel_that_is_not_a_number_is_counted() {
    let scene = cornell_box(16);
    let planted = Planted { inner: PathTracer::up_to(2), factor: 1.0, spoiled: Some(UVec2::new(3, 9)) };
    let honest = PathTracer::up_to(2);
    let report = against::<World>(&scene.world, &*scene.camera, &[("honest", &honest), ("planted", &planted)], 0.2, 16, 2);
    assert_eq!(report.methods[0].non_finite_contributions, 0);
    let planted = &report.methods[1];
    assert!(planted.non_finite_contributions > 0 && !report.is_clean());
    assert!(planted.first_non_finite.as_ref().unwrap().contains("(3, 9)"), "{planted:?}");
}

fn small_study() -> Study {
    let scene = cornell_box(24);
    let (paths, light, both) = (PathTracer::up_to(3), LightTracer::up_to(3), Bidirectional::up_to(3));
    let all = contestants::<World>(&[("path-tracing", &paths), ("light-tracing", &light), ("bidirectional", &both)]);
    let reference = ReferencePlan { budget: Budget::Samples(64), runs: 4, settings: Settings::default() };
    let reference = Reference::render(&scene.world, &*scene.camera, [&all[0], &all[2]], &reference, &mut go_on).unwrap();
    let plan = Plan {
        budget: Budget::Samples(4 * 11),
        seeds: 4,
        pyramid: Some(both),
        command: Some("make <this> \"again\"".to_owned()),
        ..Plan::default()
    };
    let info = SceneInfo { name: "cornell-box".to_owned(), max_bounces: Some(3), ..SceneInfo::default() };
    study(&scene.world, &*scene.camera, &info, &all, reference, &plan, &mut go_on).unwrap()
}

#[test]
fn the_same_seeds_give_the_same_errors_to_the_bit() {
    let [a, b] = [small_study(), small_study()];
    assert_eq!(a.reference, b.reference);
    for (a, b) in a.report.methods.iter().zip(&b.report.methods) {
        let points: Vec<u32> = a.checkpoints.iter().map(|c| c.samples).collect();
        assert_eq!(points, [1, 2, 4, 8, 11]);
        for (a, b) in a.checkpoints.iter().zip(&b.checkpoints) {
            assert_eq!((&a.runs, a.cost.rays, a.mse, a.variance), (&b.runs, b.cost.rays, b.mse, b.variance));
        }
        assert_eq!((a.bias, a.tail, a.variance_per_sample), (b.bias, b.tail, b.variance_per_sample));
    }
    assert_eq!((a.report.pairs, a.report.pyramid, a.images.len()), (b.report.pairs, b.report.pyramid, 3));
}

#[test]
fn the_pyramid_adds_up_to_the_image() {
    let study = small_study();
    let pyramid = study.pyramid.unwrap();
    assert_eq!(pyramid.layers.len(), 2 + 3 + 4 + 5);
    let energy: f64 = pyramid.layers.iter().map(|l| l.share.energy).sum();
    assert!((energy - 1.0).abs() < 1e-12, "{energy}");
    let sum = pyramid.layers.iter().map(|l| l.weighted.mean().luminance()).sum::<f64>();
    let expected = study.report.reference.mean;
    assert!((sum / expected - 1.0).abs() < 0.1, "{sum} and {expected}");
    for share in pyramid.layers.iter().map(|l| l.share) {
        assert!((-0.01..1.0).contains(&share.cost) && share.efficiency_without > 0.0, "{share:?}");
    }
}

#[test]
fn reports_are_written_and_read() {
    let study = small_study();
    let json = study.report.to_json();
    let report: Report = serde_json::from_str(&json).unwrap();
    assert_eq!(report.to_json(), json);
    let csv = study.report.to_csv();
    assert_eq!(csv.lines().count(), 1 + 3 * 5 * 4);
    assert!(csv.lines().all(|line| line.split(',').count() == 14));
    let page = study.page();
    assert!(page.contains("make &lt;this&gt; &quot;again&quot;") && !page.contains("NaN"));
    // Self-contained: the only addresses are names of formats.
    assert!(!page.replace("http://www.w3.org/2000/svg", "").contains("http"));
    let directory = std::env::temp_dir().join(format!("pathspace-report-{}", std::process::id()));
    study.save(&directory).unwrap();
    for name in ["index.html", "report.json", "report.csv", "time.svg", "samples.svg", "rays.svg", "smape.svg"] {
        assert!(directory.join(name).metadata().unwrap().len() > 500, "{name}");
    }
    std::fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn references_are_cached_and_changes_are_noticed() {
    let directory = std::env::temp_dir().join(format!("pathspace-references-{}", std::process::id()));
    let scene = cornell_box(16);
    let render = |depth: u32| {
        let (paths, both) = (PathTracer::up_to(depth), Bidirectional::up_to(depth));
        let all = contestants::<World>(&[("bidirectional", &both), ("path-tracing", &paths)]);
        let plan = ReferencePlan { budget: Budget::Samples(8), runs: 2, settings: Settings::default() };
        let mut passes = 0;
        let mut count = |_: &Step<'_>| {
            passes += 1;
            ControlFlow::Continue(())
        };
        let halves = [&all[0], &all[1]];
        let reference = cached_reference(&directory, "cornell box", &scene.world, &*scene.camera, halves, &plan, &mut count).unwrap();
        (reference, passes)
    };
    let (first, passes) = render(2);
    assert_eq!(passes, 8);
    assert_eq!(render(2), (first.clone(), 0));
    let (other, passes) = render(3);
    assert!(passes == 8 && other != first);
    std::fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn a_study_that_is_stopped_still_reports() {
    let scene = cornell_box(16);
    let paths = PathTracer::up_to(2);
    let all = contestants::<World>(&[("path-tracing", &paths)]);
    let reference = Reference::exact(Image::from_fn(16, 16, |_, _| Rgb::splat(0.2))).unwrap();
    let plan = Plan { budget: Budget::Samples(64), ..Plan::default() };
    for passes in [0, 3, 20] {
        let mut left = passes;
        let mut stop = |_: &Step<'_>| {
            left -= 1;
            if left < 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let info = SceneInfo::default();
        let study = study(&scene.world, &*scene.camera, &info, &all, reference.clone(), &plan, &mut stop).unwrap();
        assert!(study.report.stopped);
        assert_eq!(study.report.methods.first().map(|m| m.runs), (passes == 20).then_some(2));
        assert!(study.page().contains("Stopped before its end"));
        assert!(!study.report.to_json().is_empty());
    }
}

#[test]
fn bad_plans_are_refused_by_name() {
    let scene = cornell_box(16);
    let paths = PathTracer::up_to(2);
    let run = |names: [&str; 2], size: u32, seeds: u32| {
        let all = contestants::<World>(&[(names[0], &paths), (names[1], &paths)]);
        let reference = Reference::exact(Image::from_fn(size, 16, |_, _| Rgb::WHITE)).unwrap();
        let plan = Plan { seeds, budget: Budget::Samples(4), ..Plan::default() };
        study(&scene.world, &*scene.camera, &SceneInfo::default(), &all, reference, &plan, &mut go_on).map(|_| ())
    };
    assert!(matches!(run(["a", "b"], 16, 1), Err(ReportError::TooFewSeeds(1))));
    assert!(run(["a", "a"], 16, 2).unwrap_err().to_string().contains("\"a\""));
    assert!(matches!(run(["a", "b"], 15, 2), Err(ReportError::ReferenceSize([15, 16], [16, 16]))));
    assert!(run(["a", "b"], 16, 2).is_ok());
    assert!(Reference::exact(Image::from_fn(2, 2, |_, _| Rgb::splat(PI / 0.0))).is_err());
    assert!(Reference::exact(Image::from_fn(0, 2, |_, _| Rgb::WHITE)).is_err());
    assert!(Reference::load("no-such-file.exr").unwrap_err().to_string().contains("no-such-file"));
}
