//! Regularisation: mollified lobes, their bias in closed form, and an integrator with a radius that
//! shrinks.
#![allow(missing_docs, reason = "a test program")]

mod common;
#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod compare;
#[path = "../examples/stability/scenes.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod scenes;
mod worlds;

#[path = "regularization/agreement.rs"]
mod agreement;
#[path = "regularization/bias.rs"]
mod bias;
#[path = "regularization/efficiency.rs"]
mod efficiency;
#[path = "regularization/furnaces.rs"]
mod furnaces;
#[path = "regularization/lobes.rs"]
mod lobes;
#[path = "bsdf/models.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod models;
#[path = "regularization/quadrature.rs"]
mod quadrature;
#[path = "regularization/schedule.rs"]
mod schedule;
#[path = "regularization/weights.rs"]
mod weights;

use pathspace::endpoint::Camera;
use pathspace::film::{Contribution, FilmSample};
use pathspace::glam::DVec2;
use pathspace::integrator::{Caller, Integrator, Run, Stage};
use pathspace::math::statistics::Estimate;
use pathspace::path::Scratch;
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::Scene;

/// The mean of samples over the film, which must all be finite.
fn estimate<S: Scene>(
    (scene, camera): (&S, &dyn Camera),
    integrator: &impl Integrator<S>,
    samples: u32,
    seed: u64,
) -> Estimate {
    let (mut scratch, mut estimate) = (Scratch::default(), Estimate::default());
    let run =
        integrator.start(Stage { seed, ..Stage::new(scene, camera) }, &Caller).expect("a run");
    let mut found: Vec<Contribution> = Vec::new();
    for number in 0..samples {
        let mut sampler = Independent { seed }.sampler(number >> 20, number & 0xf_ffff);
        let film = FilmSample {
            raster: camera.film().from_window(sampler.next_2d()),
            offset: DVec2::ZERO,
        };
        run.sample(film, sampler, &mut found, &mut scratch);
        estimate.push(found.drain(..).map(|found| found.value.g() * found.weight).sum());
    }
    assert_eq!(scratch.counters.non_finite, 0);
    estimate
}
