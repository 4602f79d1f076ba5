//! The mean of a film by Markov chains, and its standard error over their independent sets.

use pathspace::endpoint::Camera;
use pathspace::film::{Contribution, FilmSample, Sample};
use pathspace::glam::DVec2;
use pathspace::integrator::{Caller, Integrator, Metropolis, Run, Stage};
use pathspace::math::statistics::Estimate;
use pathspace::path::{Counters, Scratch};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::World;

/// Sets of chains, and what each of them draws.
#[derive(Clone, Copy)]
pub struct Effort {
    pub sets: u32,
    /// Samples of a pass, one for each of up to 32 chains in turn.
    pub samples: u32,
    pub seed: u64,
}

#[derive(Debug)]
pub struct Measured {
    pub channels: [Estimate; 3],
    /// The constant b, and its relative standard error.
    pub b: (f64, f64),
    pub black: u32,
    pub counters: Counters,
}

impl Measured {
    pub fn assert_mean(&self, what: &str, expected: [f64; 3], tolerance: f64) {
        for (estimate, expected) in self.channels.iter().zip(expected) {
            let (mean, error) = (estimate.mean(), estimate.standard_error());
            println!("{what}: {mean} ± {error}, expected {expected}");
            let allowed = 4.0 * error + 1e-12 * expected;
            assert!((mean - expected).abs() <= allowed, "{what}: {mean} ± {error}: {expected}");
            assert!(error <= tolerance * expected, "{what}: {error} of {expected} is too large");
        }
    }
}

pub fn measure<I: Integrator<World>>(
    (world, camera): (&World, &dyn Camera),
    metropolis: &Metropolis<I>,
    effort: Effort,
) -> Measured {
    let Effort { sets, samples, seed } = effort;
    let stage = Stage { seed, ..Stage::new(world, camera) };
    let mut run = metropolis.start(stage, &Caller).expect("a run");
    let (source, region) = (Independent { seed }, camera.film());
    let (mut scratch, mut chunk) = (Scratch::default(), Default::default());
    let (mut channels, mut preparation) = ([Estimate::default(); 3], Counters::default());
    for set in 0..sets {
        let mut sum = [0.0; 3];
        for pass in set * metropolis.restart..(set + 1) * metropolis.restart {
            run.begin_pass(pass, &Caller).expect("memory");
            preparation += run.take_preparation();
            let sample = |i: u32| {
                let mut sampler = source.sampler(i, pass);
                let raster = region.from_window(sampler.next_2d());
                Sample { film: FilmSample { raster, offset: DVec2::ZERO }, sampler }
            };
            let mut batch: Vec<_> = (0..samples).map(sample).collect();
            let mut add = |_: usize, found: &Contribution| {
                let value = found.value * found.weight;
                sum.iter_mut().zip(value.0).for_each(|(sum, v)| *sum += v);
            };
            run.draw(&mut batch, &mut add, &mut chunk, &mut scratch);
        }
        let n = f64::from(samples * metropolis.restart);
        channels.iter_mut().zip(sum).for_each(|(channel, sum)| channel.push(sum / n));
    }
    let normalization = run.notes().normalization.expect("that of chains");
    assert_eq!(scratch.counters.samples, u64::from(sets * metropolis.restart * samples));
    scratch.counters += preparation;
    Measured {
        channels,
        b: (normalization.mean(), normalization.relative_error()),
        black: normalization.black,
        counters: scratch.counters,
    }
}
