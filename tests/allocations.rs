//! Integrators allocate nothing per sample once their buffers have grown.
#![allow(missing_docs, reason = "a test program")]

mod common;
mod worlds;

use common::Random;
use pathspace::endpoint::Camera;
use pathspace::film::{Contribution, Sink};
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::{
    Bidirectional, Caller, Integrator, LightTracer, PathTracer, Run, Stage, UniformArea,
};
use pathspace::math::Rgb;
use pathspace::path::Scratch;
use pathspace::render::{Budget, Settings, render};
use pathspace::sampler::{SampleSource, Sampler, SamplerKind};
use pathspace::scene::{Scene, SurfaceArea, World};
use worlds::{Result, TestScene};

const SAMPLES: u32 = 2000;

#[derive(Default)]
struct Sum(Rgb);

impl Sink for Sum {
    fn add(&mut self, _sample: usize, contribution: &Contribution) {
        self.0 += contribution.value * contribution.weight;
    }
}

/// Draws the same samples twice, so that the second time every buffer has had its largest size, and
/// counts the second time.
fn count<I: Integrator<World>>(scene: &TestScene, integrator: &I) {
    let (mut scratch, mut sum) = (Scratch::default(), Sum::default());
    let camera: &dyn Camera = &*scene.camera;
    let run = integrator.start(Stage::new(&scene.world, camera), &Caller).expect("a run");
    let mut draw = |seed: u64| {
        let mut sampler = Random::new(seed);
        for _ in 0..SAMPLES {
            let film = worlds::film_sample(camera, &mut sampler);
            run.sample(film, &mut sampler, &mut sum, &mut scratch);
        }
        // The ready-made samplers as well.
        for kind in [SamplerKind::Independent, SamplerKind::Stratified, SamplerKind::Sobol] {
            let source = kind.source(seed, 16);
            for i in 0..SAMPLES / 8 {
                let mut sampler = source.sampler(i, i % 16);
                let film = worlds::film_sample(camera, &mut sampler);
                run.sample(film, &mut sampler, &mut sum, &mut scratch);
            }
        }
    };
    draw(1);
    let allocations = allocation_counter::measure(|| draw(1));
    assert_eq!(
        allocations.count_total,
        0,
        "{} in {}: {allocations:?}",
        integrator.name(),
        scene.name
    );
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

/// Nor do queries of many rays at once.
#[test]
fn rays_at_once_allocate_nothing() -> Result {
    for scene in worlds::all()? {
        let mut random = Random::new(1);
        let points: Vec<_> = (0..100)
            .map(|_| scene.world.sample_surface(random.next_1d(), random.next_2d()))
            .collect();
        let (mut hits, mut free) = (0, 0);
        let allocations = allocation_counter::measure(|| {
            scene.world.intersect_many(points.iter().map(|x| (x, x.geometric_normal)), |_, hit| {
                hits += usize::from(hit.is_some())
            });
            scene.world.visible_many(points.iter().zip(points.iter().rev()), |_, visible| {
                free += usize::from(visible)
            });
        });
        assert_eq!(
            allocations.count_total, 0,
            "{}: {hits} hits, {free} free, {allocations:?}",
            scene.name
        );
    }
    Ok(())
}

/// The film, 48 bytes, and at the end the image, 24, whatever their size and the number of samples. `docs/performance.md` states it.
#[test]
fn memory_per_pixel_does_not_grow() {
    let most = |side: u32, samples: u32| {
        let scene =
            gallery::build("cornell-box", UVec2::splat(side)).expect("a scene of the gallery");
        let settings =
            Settings { budget: Budget::Samples(samples), threads: Some(1), ..Settings::default() };
        let integrator = Bidirectional::up_to(1);
        let draw = || {
            render(&scene.world, &*scene.camera, &integrator, &settings).expect("valid settings")
        };
        allocation_counter::measure(|| drop(draw())).bytes_max as f64
    };
    // From where the image takes more than the paths of a batch, which are gone when it is made.
    for (small, large) in [(256, 512), (512, 1024)] {
        let per_pixel =
            (most(large, 1) - most(small, 1)) / f64::from(large * large - small * small);
        assert!(
            (per_pixel - 72.0).abs() < 1.0,
            "{per_pixel} bytes per pixel from {small} to {large}"
        );
    }
    // Chunks of other samples may have recorded more.
    assert!((most(256, 8) / most(256, 2) - 1.0).abs() < 0.02);
}

/// The counter itself sees allocations.
#[test]
fn the_counter_counts() {
    let allocations = allocation_counter::measure(|| drop(std::hint::black_box(vec![1u8; 100])));
    assert_eq!(allocations.count_total, 1);
}
