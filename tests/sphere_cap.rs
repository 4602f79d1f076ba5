//! The diffuse sphere with an emissive cap: k bounces contribute Le f_e ρ^k to every wall point,
//! whichever technique draws the path.

mod common;

use common::{DownCamera, Moments, Random, SphereCap, film_sample};
use pathspace::film::{Contribution, Sample, Technique};
use pathspace::integrator::{
    Bidirectional, Caller, Depth, Integrator, LightTracer, PathTracer, PathTracing, Run, Stage,
    UniformArea,
};
use pathspace::path::{Heuristic, PathDensities, Roulette, Scratch, TechniqueSet, Weighting};

const ALBEDO: f64 = 0.5;
const FRACTION: f64 = 0.1;
const CAMERA: DownCamera = DownCamera { half_width: 0.5 };

fn scene() -> SphereCap {
    SphereCap::new(ALBEDO, FRACTION)
}

/// Moments of the per-sample sum of weighted contributions.
fn run<I: Integrator<SphereCap>>(integrator: &I, samples: u32, seed: u64) -> Moments {
    let scene = scene();
    let (mut sampler, mut scratch, mut moments) =
        (Random::new(seed), Scratch::default(), Moments::default());
    let mut sink: Vec<Contribution> = Vec::new();
    let run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
    for _ in 0..samples {
        sink.clear();
        let film = film_sample(&mut sampler);
        run.sample(film, &mut sampler, &mut sink, &mut scratch);
        moments.add(sink.iter().map(|c| c.value.g() * c.weight).sum());
    }
    assert_eq!(scratch.counters.non_finite, 0);
    moments
}

// ANCHOR: assert-mean
/// Asserts that |mean - expected| is within 4 standard errors, and the standard error small enough
/// to see a bias of 1 %.
fn assert_mean(name: &str, moments: Moments, expected: f64) {
    let (mean, error) = (moments.mean(), moments.standard_error());
    assert!(
        (mean - expected).abs() <= 4.0 * error + 1e-12 * expected,
        "{name}: {mean} ± {error}, expected {expected}"
    );
    assert!(
        error <= 0.0025 * expected,
        "{name}: standard error {error} of {expected} is too large to mean anything"
    );
}
// ANCHOR_END: assert-mean

#[test]
fn every_technique_alone_has_the_exact_mean() {
    for k in 1..=3u32 {
        let expected = FRACTION * ALBEDO.powi(k as i32);
        for s in 0..=k as u16 + 1 {
            let only = Technique::new(s, k as u16 + 2 - s);
            let integrator = Bidirectional {
                techniques: TechniqueSet::only(only).expect("a short path"),
                depth: Depth::exactly(k),
                roulette: Roulette::NEVER,
                ..Bidirectional::default()
            };
            let samples = match (only.s, only.t) {
                (0, _) => 1_600_000,
                (_, 1) => 2_800_000,
                _ => 1000,
            };
            assert_mean(&format!("{only:?}"), run(&integrator, samples, 17), expected);
        }
    }
}

#[test]
fn every_integrator_has_the_exact_mean() {
    let total = ALBEDO * FRACTION / (1.0 - ALBEDO);
    let samples = 1_500_000;
    assert_mean("path tracing", run(&PathTracer::default(), samples, 1), total);
    assert_mean("light tracing", run(&LightTracer::default(), samples, 2), total);
    assert_mean("bidirectional", run(&Bidirectional::default(), samples / 4, 3), total);
    let emission = PathTracer { mode: PathTracing::EmissionOnly, ..PathTracer::default() };
    assert_mean("emission only", run(&emission, 2 * samples, 4), total);
    let next_event = PathTracer { mode: PathTracing::NextEventOnly, ..PathTracer::default() };
    assert_mean("next event only", run(&next_event, samples, 5), total);
    assert_mean("uniform area", run(&UniformArea::default(), 2 * samples, 6), total);
}

#[test]
fn roulette_with_a_constant_keeps_the_mean_and_lowers_the_variance() {
    use pathspace::math::Rgb;
    let total = ALBEDO * FRACTION / (1.0 - ALBEDO);
    let with = |constant: f64| {
        let roulette = Roulette { start: 0, constant: Rgb::splat(constant), ..Roulette::default() };
        run(&PathTracer { roulette, ..PathTracer::default() }, 500_000, 7)
    };
    let (without, with) = (with(0.0), with(total / ALBEDO * 0.5));
    assert_mean("c = 0", without, total);
    assert_mean("c > 0", with, total);
    assert!(
        with.variance() < 0.5 * without.variance(),
        "{} against {}",
        with.variance(),
        without.variance()
    );
    let roulette = Roulette { start: 0, constant: Rgb::splat(0.1), ..Roulette::default() };
    assert_mean(
        "uniform area with c",
        run(&UniformArea { roulette, ..UniformArea::default() }, 3_000_000, 8),
        total,
    );
}

/// The weights of the balance heuristic for t ≥ 2: w(s = 0) = f_e / (k + f_e) and w(s ≥ 1) = 1 / (k
/// + f_e) (row F13 of tests/data/analytic.json).
#[test]
fn weights_are_the_exact_ones() {
    let scene = scene();
    let set = TechniqueSet { lens_sampling: false, ..TechniqueSet::BIDIRECTIONAL };
    let mut seen = 0;
    for k in [1, 2, 3, 8] {
        let integrator = Bidirectional {
            techniques: set,
            depth: Depth::exactly(k),
            roulette: Roulette::NEVER,
            heuristic: Heuristic::Balance,
        };
        let (mut sampler, mut scratch) = (Random::new(9), Scratch::default());
        for _ in 0..2000 {
            let film = film_sample(&mut sampler);
            integrator.for_each_path(
                Stage::new(&scene, &CAMERA),
                Sample { film, sampler: &mut sampler },
                &mut scratch,
                |path, contribution| {
                    let expected = if contribution.technique.s == 0 { FRACTION } else { 1.0 }
                        / (f64::from(k) + FRACTION);
                    assert!(
                        (contribution.weight - expected).abs() < 1e-9 * expected,
                        "{path:?}: {} {expected}",
                        contribution.weight
                    );
                    seen += 1;
                },
            );
        }
    }
    assert!(seen > 10_000);
}

/// The same weights with light tracing on: the lens technique adds (q / p_cam(x_1)) / f_e.
#[test]
fn the_lens_technique_has_the_exact_weight() {
    let scene = scene();
    let integrator = Bidirectional {
        depth: Depth::exactly(2),
        roulette: Roulette::NEVER,
        heuristic: Heuristic::Balance,
        ..Bidirectional::default()
    };
    let (mut sampler, mut scratch) = (Random::new(10), Scratch::default());
    let mut seen = 0;
    for _ in 0..2000 {
        let film = film_sample(&mut sampler);
        integrator.for_each_path(
            Stage::new(&scene, &CAMERA),
            Sample { film, sampler: &mut sampler },
            &mut scratch,
            |path, contribution| {
                let x1 = path.vertex(1).point.position;
                let cos_camera = -x1.normalize().z;
                let area = 4.0 * CAMERA.half_width * CAMERA.half_width;
                // The sphere has radius 1 and the pinhole is in its centre: cosine 1 and distance 1
                // at x_1.
                let p_camera = 1.0 / (area * cos_camera.powi(3));
                let q = 1.0 / (4.0 * std::f64::consts::PI);
                let lens = q / p_camera;
                let expected = match contribution.technique {
                    Technique { s: 0, .. } => FRACTION,
                    Technique { t: 1, .. } => lens,
                    _ => 1.0,
                } / (2.0 + FRACTION + lens);
                assert!(
                    (contribution.weight - expected).abs() < 1e-9,
                    "{path:?}: {} {expected}",
                    contribution.weight
                );
                seen += 1;
            },
        );
    }
    assert!(seen > 4000);
}

#[test]
fn paths_verify_against_the_definitions() {
    let scene = scene();
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0), Heuristic::Power(1.5)] {
        let integrator =
            Bidirectional { depth: Depth::up_to(8), heuristic, ..Bidirectional::default() };
        let (mut sampler, mut scratch) = (Random::new(11), Scratch::default());
        let mut seen = 0;
        for _ in 0..5000 {
            let film = film_sample(&mut sampler);
            integrator.for_each_path(
                Stage::new(&scene, &CAMERA),
                Sample { film, sampler: &mut sampler },
                &mut scratch,
                |path, contribution| {
                    let verification =
                        path.verify(&Weighting::new(integrator.techniques, heuristic));
                    assert!(verification.weight_sum_error < 1e-12, "{path:?} {verification:?}");
                    assert!(
                        verification.worst() < 1e-7,
                        "{path:?} {contribution:?} {verification:?}"
                    );
                    seen += 1;
                },
            );
        }
        assert!(seen > 50_000, "{seen}");
    }
}

/// The techniques of a path with k edges: k + 2 pairs (s, t), one less because the lens is never
/// hit (row F11 of tests/data/analytic.json).
#[test]
fn a_path_with_k_edges_has_k_plus_one_techniques() {
    let scene = scene();
    let integrator = Bidirectional { depth: Depth::up_to(4), ..Bidirectional::default() };
    let (mut sampler, mut scratch) = (Random::new(12), Scratch::default());
    for _ in 0..100 {
        let film = film_sample(&mut sampler);
        integrator.for_each_path(
            Stage::new(&scene, &CAMERA),
            Sample { film, sampler: &mut sampler },
            &mut scratch,
            |path, _| {
                let record = path.record();
                let k = record.edges();
                assert_eq!(
                    (0..=k + 1).filter(|&t| record.is_admissible(record.technique(t))).count(),
                    k + 1
                );
            },
        );
    }
}

/// The exact variances of next event estimation and of both weighted sums (rows F02 and F03 of
/// tests/data/analytic.json).
#[test]
fn variances_are_the_exact_ones() {
    let one_bounce = |mode, heuristic| PathTracer {
        mode,
        heuristic,
        depth: Depth::exactly(1),
        roulette: Roulette::NEVER,
    };
    let next_event = run(&one_bounce(PathTracing::NextEventOnly, Heuristic::Balance), 1000, 13);
    assert!((next_event.mean() - 0.05).abs() < 1e-12 && next_event.variance() < 1e-24);
    for (heuristic, variance) in [
        (Heuristic::Balance, 0.000_185_950_413_223_140_49),
        (Heuristic::Power(2.0), 2.205_666_111_165_572e-6),
    ] {
        let measured = run(&one_bounce(PathTracing::Both, heuristic), 400_000, 14);
        assert!(
            (measured.variance() / variance - 1.0).abs() < 0.02,
            "{heuristic:?}: {}",
            measured.variance()
        );
        assert!((measured.mean() - 0.05).abs() < 4.0 * measured.standard_error());
    }
    // Uniform-area sampling: a Bernoulli variable, (ρ^k Le)² f_e (1 - f_e).
    for k in 1..=3 {
        let uniform = UniformArea { depth: Depth::exactly(k), roulette: Roulette::NEVER };
        let expected = ALBEDO.powi(2 * k as i32) * FRACTION * (1.0 - FRACTION);
        let measured = run(&uniform, 400_000, 15);
        assert!(
            (measured.variance() / expected - 1.0).abs() < 0.02,
            "k = {k}: {}",
            measured.variance()
        );
    }
}
