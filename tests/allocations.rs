//! Integrators allocate nothing per sample once their buffers have grown.
#![allow(missing_docs, reason = "a test program")]

mod common;
mod worlds;

use common::Random;
use pathspace::endpoint::Camera;
use pathspace::film::{Contribution, Sink};
use pathspace::integrator::{Bidirectional, Integrator, LightTracer, PathTracer, UniformArea};
use pathspace::math::Rgb;
use pathspace::path::Scratch;
use pathspace::sampler::{SampleSource, SamplerKind};
use pathspace::scene::World;
use worlds::{Result, TestScene};

const SAMPLES: u32 = 2000;

#[derive(Default)]
struct Sum(Rgb);

impl Sink for Sum {
    fn add(&mut self, contribution: &Contribution) {
        self.0 += contribution.value * contribution.weight;
    }
}

/// Draws the same samples twice, so that the second time every buffer has had its largest size, and counts the second time.
fn count<I: Integrator<World>>(scene: &TestScene, integrator: &I) {
    let (mut scratch, mut sum) = (Scratch::default(), Sum::default());
    let camera: &dyn Camera = &*scene.camera;
    let mut draw = |seed: u64| {
        let mut sampler = Random::new(seed);
        for _ in 0..SAMPLES {
            let film = worlds::film_sample(camera, &mut sampler);
            integrator.sample(&scene.world, camera, film, &mut sampler, &mut sum, &mut scratch);
        }
        // The ready-made samplers as well.
        for kind in [SamplerKind::Independent, SamplerKind::Stratified, SamplerKind::Sobol] {
            let source = kind.source(seed, 16);
            for i in 0..SAMPLES / 8 {
                let mut sampler = source.sampler(i, i % 16);
                let film = worlds::film_sample(camera, &mut sampler);
                integrator.sample(&scene.world, camera, film, &mut sampler, &mut sum, &mut scratch);
            }
        }
    };
    draw(1);
    let allocations = allocation_counter::measure(|| draw(1));
    assert_eq!(allocations.count_total, 0, "{} in {}: {allocations:?}", integrator.name(), scene.name);
    assert!(sum.0.is_finite());
}

#[test]
fn samples_allocate_nothing() -> Result {
    for scene in worlds::all()? {
        count(&scene, &UniformArea::default());
        count(&scene, &PathTracer::default());
        count(&scene, &LightTracer::default());
        count(&scene, &Bidirectional::default());
    }
    Ok(())
}

/// The counter itself sees allocations.
#[test]
fn the_counter_counts() {
    let allocations = allocation_counter::measure(|| drop(std::hint::black_box(vec![1u8; 100])));
    assert_eq!(allocations.count_total, 1);
}
