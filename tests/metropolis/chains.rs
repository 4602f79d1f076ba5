//! Chains of any length, and what starves or stops them.

use crate::measure::{Effort, measure};
use crate::scenes::{camera, cap_sphere};
use pathspace::endpoint::{Camera, PinholeCamera};
use pathspace::film::{Contribution, FilmSample, Sample, Sink, Technique};
use pathspace::glam::{DVec2, DVec3};
use pathspace::integrator::{
    Bidirectional, Caller, Crew, Integrator, Metropolis, Multiplexed, Notes, PathTracer,
    PhotonMapping, Run, Stage, Started,
};
use pathspace::math::Rgb;
use pathspace::path::{Scratch, TechniqueSet};
use pathspace::render::{Budget, Progress, Render, RenderError, Settings, Shard};
use pathspace::sampler::{Independent, SampleSource, Sampler, SamplerKind};
use pathspace::scene::World;
use std::ops::ControlFlow;

/// An integrand of one number: I(u), shared between the channels by thirds of `[0, 1)`.
#[derive(Clone, Copy, Debug)]
struct Target(fn(f64) -> f64);

impl Integrator<World> for Target {
    type Run<'a> = Self;

    fn name(&self) -> &'static str {
        "target"
    }

    fn start<'a>(&'a self, _: Stage<'a, World>, _: &dyn Crew) -> Started<Self> {
        Ok(*self)
    }
}

impl<'a> Run<'a, World> for Target {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        TechniqueSet::NONE
    }

    fn notes(&self) -> Notes {
        Notes::default()
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, World>,
    ) {
        scratch.counters.samples += samples.len() as u64;
        for (i, Sample { film, sampler }) in samples.iter_mut().enumerate() {
            let u = sampler.next_1d();
            let mut value = Rgb::BLACK;
            value.0[(3.0 * u) as usize] = 3.0 * (self.0)(u);
            let technique = Technique::new(0, 2);
            sink.add(i, &Contribution { raster: film.raster, value, weight: 1.0, technique });
        }
    }
}

fn anywhere() -> (World, PinholeCamera) {
    (cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0), camera(DVec3::ZERO, DVec3::NEG_Z, 60.0))
}

/// Low nearly everywhere, with a narrow peak in the middle third.
fn peak(u: f64) -> f64 {
    0.1 + 3.7 * (-((u - 0.4) / 0.02).powi(2)).exp()
}

/// The integrals of the thirds, times 3: the tails of the peak beyond 1/3 are 1.4e-6 of it.
const PEAK: [f64; 3] = {
    let area = 3.7 * 0.02 * 1.772_453_850_905_516;
    [0.1, 0.1 + 3.0 * area, 0.1]
};

/// M01: b and the starts from the same candidates are unbiased, however few there are, and however
/// short the chains. With a b of other candidates, the mean of 4 candidates and 10 steps would be
/// two thirds of it.
#[test]
fn chains_of_any_length_are_unbiased() {
    let (world, eye) = anywhere();
    let target = Target(peak);
    for (seed, (candidates, restart)) in
        [(1, 1), (4, 10), (4, 100), (64, 10)].into_iter().enumerate()
    {
        let over = Metropolis::over(target);
        let metropolis = Metropolis { candidates: Some(candidates), restart, ..over };
        let sets = 400_000 / candidates.max(restart).max(4);
        let effort = Effort { sets, samples: 1, seed: 1 + seed as u64 };
        let measured = measure((&world, &eye), &metropolis, effort);
        let what = format!("{candidates} candidates, {restart} steps");
        measured.assert_mean(&what, PEAK, 0.05);
        let (b, error) = measured.b;
        let expected = PEAK.iter().sum::<f64>() / 3.0;
        assert!((b - expected).abs() <= 4.0 * error * expected, "{what}: {b} of {expected}");
    }
}

/// With large steps alone and one step, it is plain Monte Carlo, scaled.
#[test]
fn one_large_step_is_plain_monte_carlo() {
    let (world, eye) = anywhere();
    let over = Metropolis::over(Target(peak));
    let metropolis = Metropolis { candidates: Some(16), restart: 1, large_step: 1.0, ..over };
    let effort = Effort { sets: 200_000, samples: 4, seed: 9 };
    measure((&world, &eye), &metropolis, effort).assert_mean("large steps", PEAK, 0.01);
}

/// A constant is drawn without any variance: all proposals are accepted.
#[test]
fn a_constant_has_no_variance() {
    let (world, eye) = anywhere();
    let metropolis = Metropolis { restart: 16, ..Metropolis::over(Target(|_| 0.7)) };
    let effort = Effort { sets: 4, samples: 64, seed: 3 };
    let measured = measure((&world, &eye), &metropolis, effort);
    assert!((measured.b.0 - 0.7).abs() < 1e-12 && measured.b.1 < 1e-7, "{:?}", measured.b);
    let mean: f64 = measured.channels.iter().map(|channel| channel.mean()).sum::<f64>() / 3.0;
    assert!((mean - 0.7).abs() < 1e-12, "{mean}");
}

/// S62: what is seen through a slit of 1e-4 of the numbers, over 60 decades, and not at all.
#[test]
fn narrow_steep_and_black_targets() {
    let (world, eye) = anywhere();
    let of = (&world, &eye as &dyn Camera);
    let slit = Target(|u| if (0.5..0.5001).contains(&u) { 1e4 } else { 0.0 });
    let metropolis = Metropolis { candidates: Some(1024), restart: 4, ..Metropolis::over(slit) };
    let measured = measure(of, &metropolis, Effort { sets: 4000, samples: 32, seed: 5 });
    // Sets without a candidate in the slit are black, which the others make up for.
    assert!((3550..3680).contains(&measured.black), "{}", measured.black);
    let estimate = measured.channels[1];
    assert!((estimate.mean() - 3.0).abs() <= 4.0 * estimate.standard_error(), "{estimate:?}");
    assert!(estimate.standard_error() < 0.06 * 3.0, "{estimate:?}");

    // ∫ 10^(60 u - 30) du, nearly all of it in the last thousandth.
    let steep = Target(|u| 10f64.powf(60.0 * u - 30.0));
    let metropolis = Metropolis { candidates: Some(4096), restart: 16, ..Metropolis::over(steep) };
    let measured = measure(of, &metropolis, Effort { sets: 400, samples: 32, seed: 6 });
    let expected = 3.0 * 1e30 / (60.0 * 10f64.ln());
    let estimate = measured.channels[2];
    assert!((estimate.mean() - expected).abs() <= 4.0 * estimate.standard_error(), "{estimate:?}");
    assert!(estimate.standard_error() < 0.01 * expected, "{estimate:?}");

    let metropolis = Metropolis { candidates: Some(16), ..Metropolis::over(Target(|_| 0.0)) };
    let measured = measure(of, &metropolis, Effort { sets: 7, samples: 32, seed: 7 });
    assert_eq!((measured.black, measured.b), (7, (0.0, 0.0)));
    assert!(measured.channels.iter().all(|channel| channel.mean() == 0.0));
}

/// Values that are no numbers are no states, and are counted.
#[test]
fn no_chain_stays_where_contributions_are_not_finite() {
    let (world, eye) = anywhere();
    let target = Target(|u| match u {
        u if u < 0.01 => f64::NAN,
        u if u < 0.02 => f64::INFINITY,
        _ => 1.0,
    });
    let metropolis = Metropolis { candidates: Some(1024), restart: 16, ..Metropolis::over(target) };
    let measured = measure((&world, &eye), &metropolis, Effort { sets: 64, samples: 64, seed: 8 });
    let mean: f64 = measured.channels.iter().map(|channel| channel.mean()).sum::<f64>() / 3.0;
    let error = measured.b.1;
    assert!((mean / 0.98 - 1.0).abs() < 4.0 * error && error < 0.001, "{mean} ± {error}");
    let drawn = 64.0 * (1024.0 + 32.0 + 16.0 * 64.0);
    let lost = measured.counters.non_finite as f64 / drawn;
    assert!(lost > 0.001 && lost < 0.03, "{lost}");
}

/// Samples drawn one by one and together give the same, to the bit and in the same order.
#[test]
fn batches_do_not_matter() {
    let (world, eye) = anywhere();
    let metropolis = Metropolis { restart: 2, ..Metropolis::over(Bidirectional::default()) };
    let drawn = |batch: usize| {
        let stage = Stage::new(&world, &eye);
        let mut run = metropolis.start(stage, &Caller).expect("a run");
        let (mut scratch, mut chunk) = (Scratch::default(), Default::default());
        let mut found: Vec<Contribution> = Vec::new();
        for pass in 0..5 {
            run.begin_pass(pass, &Caller).expect("memory");
            let sample = |i| {
                let mut sampler = Independent { seed: 2 }.sampler(i, pass);
                let raster = eye.film().from_window(sampler.next_2d());
                Sample { film: FilmSample { raster, offset: DVec2::ZERO }, sampler }
            };
            let mut samples: Vec<_> = (0..128).map(sample).collect();
            for samples in samples.chunks_mut(batch) {
                let mut sorted = vec![Vec::new(); samples.len()];
                let mut add = |i: usize, c: &Contribution| sorted[i].push(*c);
                run.draw(samples, &mut add, &mut chunk, &mut scratch);
                found.extend(sorted.into_iter().flatten());
            }
        }
        found
    };
    let together = drawn(128);
    assert!(together.len() > 1000);
    for batch in [1, 7, 50] {
        assert!(drawn(batch) == together, "{batch}");
    }
}

/// The same bits for any number of threads, and after a rest.
#[test]
fn threads_and_rests_do_not_matter() {
    let scene = pathspace::gallery::build("cornell-box", pathspace::glam::UVec2::new(24, 20))
        .expect("a scene");
    let (world, eye) = (&scene.world, &*scene.camera);
    let bidirectional = Bidirectional::up_to(4);
    let over = Metropolis::over(bidirectional);
    let methods: [&dyn Render<World>; 3] = [
        &Metropolis { restart: 3, ..over },
        &Metropolis { restart: 2, ..Metropolis::over(PathTracer::up_to(4)) },
        &Metropolis { restart: 4, ..Metropolis::over(Multiplexed { bidirectional }) },
    ];
    for method in methods {
        let settings = |threads: usize, samples: u32| Settings {
            threads: Some(threads),
            budget: Budget::Samples(samples),
            sampler: SamplerKind::Sobol,
            keeps_checkpoint: true,
            seed: 11,
            ..Settings::default()
        };
        let whole = method.render(world, eye, &settings(1, 7)).expect("valid");
        for threads in [2, 7, 64] {
            let other = method.render(world, eye, &settings(threads, 7)).expect("valid");
            assert!(other.image == whole.image, "{threads} threads");
        }
        let mut pause = |progress: &Progress<'_>| match progress.passes {
            4 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let part = method.render_with_progress(world, eye, &settings(2, 7), &mut pause);
        let checkpoint = part.expect("valid").checkpoint.expect("kept");
        let rest = method
            .resume(checkpoint, world, eye, &settings(3, 7), &mut |_| ControlFlow::Continue(()))
            .expect("valid");
        assert!(rest.image == whole.image, "after a rest");
        let shard = Settings { shard: Shard::new(1, 2).expect("valid"), ..settings(1, 7) };
        let refused = method.render(world, eye, &shard);
        assert!(matches!(refused, Err(RenderError::ShardOfLearner { .. })));
    }
}

/// Settings that make no chain are refused with a reason, as is what keeps its samples' numbers from
/// telling all.
#[test]
fn what_makes_no_chain_is_refused() {
    let (world, eye) = anywhere();
    let over = Metropolis::over(PathTracer::default());
    let faulty = [
        (Metropolis { candidates: Some(0), ..over }, "candidates"),
        (Metropolis { restart: 0, ..over }, "chains of 0 passes"),
        (Metropolis { large_step: 0.0, ..over }, "probability 0 of large steps"),
        (Metropolis { large_step: f64::NAN, ..over }, "NaN"),
        (Metropolis { sizes: [-1.0, 1.0], ..over }, "small steps of [-1.0, 1.0]"),
        (Metropolis { sizes: [0.5, 0.4], ..over }, "small steps of [0.5, 0.4]"),
    ];
    let reason = |result: Result<_, pathspace::integrator::IntegratorError>| match result {
        Err(error) => error.to_string(),
        Ok(()) => String::new(),
    };
    for (metropolis, expected) in faulty {
        let stage = Stage::new(&world, &eye);
        let reason = reason(metropolis.start(stage, &Caller).map(drop));
        assert!(reason.starts_with("metropolis: ") && reason.contains(expected), "{reason}");
    }
    let photons = Metropolis::over(PhotonMapping::default());
    let reason = reason(photons.start(Stage::new(&world, &eye), &Caller).map(drop));
    assert!(reason.contains("share"), "{reason}");
}
