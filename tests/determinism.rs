//! The same settings give the same image and the same counters to the bit, whatever the number of
//! threads.
#![allow(missing_docs, reason = "a test program")]

mod worlds;

use pathspace::endpoint::Camera;
use pathspace::film::Filter;
use pathspace::integrator::{
    Bidirectional, Depth, InstantRadiosity, LightTracer, Metropolis, Multiplexed, PathTracer,
    PhotonMapping, Regularization, UniformArea, VertexConnectionMerging,
};
use pathspace::path::{Counters, Ledger};
use pathspace::render::{Budget, Progress, Render, Rendering, Settings, render_with_source};
use pathspace::sampler::{Independent, IndependentSampler, SampleSource, SamplerKind};
use pathspace::scene::World;
use std::ops::ControlFlow;
use worlds::{Placement, Result, TestScene};

const THREADS: [usize; 4] = [1, 2, 7, 64];
const SAMPLERS: [SamplerKind; 3] =
    [SamplerKind::Independent, SamplerKind::Stratified, SamplerKind::Sobol];
const FILTERS: [Filter; 3] =
    [Filter::Box, Filter::Tent, Filter::Gaussian { standard_deviation: 0.5 }];

fn integrators() -> Vec<Box<dyn Render<World>>> {
    let depth = Depth::default();
    let path_tracer = PathTracer { depth, ..PathTracer::default() };
    let bidirectional = Bidirectional { depth, ..Bidirectional::default() };
    vec![
        Box::new(UniformArea { depth, ..UniformArea::default() }),
        Box::new(path_tracer),
        Box::new(LightTracer { depth, ..LightTracer::default() }),
        Box::new(bidirectional),
        Box::new(PhotonMapping { depth, ..PhotonMapping::default() }),
        Box::new(PhotonMapping { depth, next_event: true, ..PhotonMapping::default() }),
        Box::new(InstantRadiosity { path_tracer, ..InstantRadiosity::default() }),
        Box::new(InstantRadiosity { path_tracer, compensates: false, ..Default::default() }),
        Box::new(VertexConnectionMerging { bidirectional, ..Default::default() }),
        Box::new(Multiplexed { bidirectional }),
        Box::new(Metropolis {
            candidates: Some(64),
            restart: 2,
            ..Metropolis::over(bidirectional)
        }),
        Box::new(Regularization::new(bidirectional)),
    ]
}

/// Everything that a rendering computed, as bits.
fn bits(rendering: &Rendering) -> Vec<u64> {
    let Counters {
        samples,
        light_subpaths,
        closest_rays,
        shadow_rays,
        scattered,
        connections,
        photons,
        queries,
        merges,
        shared_bytes,
        non_finite,
        truncated_subpaths,
        ledger,
    } = rendering.counters;
    let Ledger { emitted, absorbed, escaped, truncated, rejected, clamped } = ledger;
    let flux = [emitted, absorbed, escaped, truncated, rejected, clamped];
    let pixels = rendering.image.pixels().iter().chain(&flux).flat_map(|p| p.0.map(f64::to_bits));
    pixels
        .chain([
            samples,
            light_subpaths,
            closest_rays,
            shadow_rays,
            scattered,
            connections,
            photons,
            queries,
            merges,
            shared_bytes,
            non_finite,
            truncated_subpaths,
        ])
        .collect()
}

fn run(
    scene: &TestScene,
    integrator: &dyn Render<World>,
    settings: &Settings,
) -> Result<Rendering> {
    Ok(integrator.render(&scene.world, &*scene.camera, settings)?)
}

/// A scene with area lights, a sphere light, Dirac lobes and roulette, and one with light at
/// infinity.
fn scenes() -> Result<[TestScene; 2]> {
    Ok([worlds::mixtures(Placement::UNIT)?, worlds::parallel(Placement::UNIT)?])
}

#[test]
fn the_number_of_threads_does_not_matter() -> Result {
    for scene in scenes()? {
        for integrator in integrators() {
            for sampler in SAMPLERS {
                for filter in FILTERS {
                    let settings = |threads, seed| Settings {
                        budget: Budget::Samples(4),
                        seed,
                        threads: Some(threads),
                        filter,
                        sampler,
                        ..Settings::default()
                    };
                    let reference = run(&scene, &*integrator, &settings(1, 5))?;
                    for threads in THREADS {
                        let other = run(&scene, &*integrator, &settings(threads, 5))?;
                        let what = format!(
                            "{} {} {sampler:?} {filter:?} {threads} threads",
                            scene.name, reference.integrator
                        );
                        assert_eq!(bits(&other), bits(&reference), "{what}");
                    }
                    let reseeded = run(&scene, &*integrator, &settings(2, 6))?;
                    assert_ne!(
                        bits(&reseeded),
                        bits(&reference),
                        "the seed must matter: {}",
                        reference.integrator
                    );
                    assert!(reference.image.mean().is_finite() && reference.counters.rays() > 0);
                }
            }
        }
    }
    Ok(())
}

#[test]
fn a_stopped_rendering_is_the_shorter_one() -> Result {
    let [scene, _] = scenes()?;
    for integrator in integrators() {
        for sampler in [SamplerKind::Independent, SamplerKind::Sobol] {
            let base = Settings { sampler, filter: Filter::Tent, ..Settings::default() };
            for threads in THREADS {
                let settings =
                    Settings { budget: Budget::Samples(9), threads: Some(threads), ..base };
                let mut stop = |p: &Progress<'_>| {
                    if p.passes == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                };
                let stopped = integrator.render_with_progress(
                    &scene.world,
                    &*scene.camera,
                    &settings,
                    &mut stop,
                )?;
                assert!(stopped.stopped && stopped.samples_per_pixel == 3);
                let shorter =
                    run(&scene, &*integrator, &Settings { budget: Budget::Samples(3), ..base })?;
                assert_eq!(
                    bits(&stopped),
                    bits(&shorter),
                    "{} {sampler:?} {threads} threads",
                    stopped.integrator
                );
            }
        }
    }
    Ok(())
}

/// A source of the user's own: the numbers of another, with pixels and passes exchanged.
struct Swapped(Independent);

impl SampleSource for Swapped {
    type Sampler = IndependentSampler;

    fn sampler(&self, pixel: u32, pass: u32) -> IndependentSampler {
        self.0.sampler(pass, pixel)
    }
}

#[test]
fn a_source_of_the_users_own_is_as_deterministic() -> Result {
    let [scene, _] = scenes()?;
    let source = Swapped(Independent { seed: 5 });
    let integrator = Bidirectional::default();
    let camera: &dyn Camera = &*scene.camera;
    let render = |threads| {
        let settings =
            Settings { budget: Budget::Samples(6), threads: Some(threads), ..Settings::default() };
        let mut go_on = |_: &Progress<'_>| ControlFlow::Continue(());
        render_with_source(&source, &scene.world, camera, &integrator, &settings, &mut go_on)
    };
    let reference = bits(&render(1)?);
    for threads in THREADS {
        assert_eq!(bits(&render(threads)?), reference, "{threads} threads");
    }
    let settings = Settings { budget: Budget::Samples(6), seed: 5, ..Settings::default() };
    assert_ne!(bits(&run(&scene, &integrator, &settings)?), reference, "the source must matter");
    Ok(())
}
