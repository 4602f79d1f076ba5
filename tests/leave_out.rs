//! Leaving out changes nothing: pruned and unpruned integrators contribute the same to the bit
//! where pruned techniques contribute nothing, and have the same mean where the choice of a set
//! changes weights; rays equal their closed forms; the adaptive integrator's decisions are
//! deterministic, unbiased and good.
#![allow(missing_docs, reason = "a test program")]

mod common;
#[path = "common/rooms.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod rooms;
mod worlds;

use common::{Moments, Random};
use glam::{DVec3, UVec2};
use pathspace::endpoint::{Camera, ConstantEnvironment, PinholeCamera, PointLight};
use pathspace::film::{Contribution, FilmSample};
use pathspace::geometry::Sphere;
use pathspace::integrator::{Caller, Depth, Integrator, Run, Stage, WithNeeds};
use pathspace::math::Rgb;
use pathspace::path::{Counters, LeftOut, Reason, Scratch};
use pathspace::sampler::{SampleSource, Sampler, Stratified};
use pathspace::scene::{Material, Scene, SurfaceArea, World};
use rooms::{Room, lambert, v};

const DEPTH: Depth = Depth::up_to(5);

/// All integrators on one scene, by name, as a function of a visitor; a list cannot hold them.
macro_rules! for_each_integrator {
    ($integrator:ident => $body:block) => {{
        {
            let $integrator = pathspace::integrator::UniformArea {
                depth: crate::DEPTH,
                ..pathspace::integrator::UniformArea::default()
            };
            $body
        }
        {
            let $integrator = pathspace::integrator::PathTracer {
                depth: crate::DEPTH,
                ..pathspace::integrator::PathTracer::default()
            };
            $body
        }
        {
            let $integrator = pathspace::integrator::LightTracer {
                depth: crate::DEPTH,
                ..pathspace::integrator::LightTracer::default()
            };
            $body
        }
        {
            let $integrator = pathspace::integrator::Bidirectional {
                depth: crate::DEPTH,
                ..pathspace::integrator::Bidirectional::default()
            };
            $body
        }
    }};
}

#[path = "leave_out/adaptive.rs"]
mod adaptive;
#[path = "leave_out/classes.rs"]
mod classes;
#[path = "leave_out/lens.rs"]
mod lens;
#[path = "leave_out/means.rs"]
mod means;
#[path = "leave_out/needs.rs"]
mod needs;
#[path = "leave_out/rays.rs"]
mod rays;
#[path = "leave_out/same.rs"]
mod same;

/// Contributions that are not zero and the counters of samples with numbers that depend on (stream,
/// sample) alone.
fn contributions<S: SurfaceArea, I: Integrator<S>>(
    scene: &S,
    camera: &(dyn Camera + Send),
    integrator: &I,
    samples: u32,
) -> (Vec<Contribution>, Counters) {
    contributions_with(
        &Stratified { seed: 7, samples_per_pixel: samples },
        scene,
        camera,
        integrator,
        samples,
    )
}

/// The same with the samplers of some source.
fn contributions_with<N: SampleSource, S: Scene, I: Integrator<S>>(
    source: &N,
    scene: &S,
    camera: &(dyn Camera + Send),
    integrator: &I,
    samples: u32,
) -> (Vec<Contribution>, Counters) {
    let (mut sink, mut scratch) = (Vec::new(), Scratch::default());
    let run = integrator.start(Stage::new(scene, camera), &Caller).expect("a run");
    for i in 0..samples {
        let mut sampler = source.sampler(0, i);
        let film = FilmSample {
            raster: camera.film().from_window(sampler.next_2d()),
            ..FilmSample::default()
        };
        run.sample(film, &mut sampler, &mut sink, &mut scratch);
    }
    // Points of one flat surface see each other at angles that are zero up to rounding.
    sink.retain(|c| (c.value * c.weight).max_component() > 1e-25);
    (sink, scratch.counters)
}

fn left_out<I: Integrator<World>>(
    integrator: &I,
    world: &World,
    camera: &(dyn Camera + Send),
) -> LeftOut {
    integrator.start(Stage::new(world, camera), &Caller).expect("a run").notes().left_out
}

/// True if something is left out that others draw.
fn is_redundant<I: Integrator<World>>(
    integrator: &I,
    world: &World,
    camera: &(dyn Camera + Send),
) -> bool {
    left_out(integrator, world, camera).families().any(|(_, reason)| reason == Reason::Redundant)
}

/// Asserts that the pruned integrator contributes what the unpruned one does, and with no more
/// rays. Where a redundant technique was dropped weights differ, and so do single contributions;
/// means are compared then.
fn assert_nothing_is_lost<I>(
    name: &str,
    world: &World,
    camera: &(dyn Camera + Send),
    integrator: &I,
    samples: u32,
) -> u64
where
    I: Integrator<World> + Copy,
{
    let (pruned, fewer) = contributions(world, camera, integrator, samples);
    let (all, more) = contributions(world, camera, &WithNeeds::all(*integrator), samples);
    let left_out = left_out(integrator, world, camera);
    let what = format!("{name}, {}: {left_out}", integrator.name());
    assert!(
        fewer.rays() <= more.rays() && fewer.connections <= more.connections,
        "{what}: {fewer:?} {more:?}"
    );
    if !is_redundant(integrator, world, camera) {
        assert!(pruned == all, "{what}: {} contributions of {}", pruned.len(), all.len());
    }
    more.rays() - fewer.rays()
}

/// Scenes that need little, each with the rays that leaving out must save.
fn sparing_scenes() -> Vec<(&'static str, World, PinholeCamera, bool)> {
    let eye = |position, target| {
        PinholeCamera::new(position, target, DVec3::Z, 50.0, UVec2::splat(8)).expect("valid")
    };
    let mirror = Material::Mirror { reflectance: Rgb::splat(0.8) };
    let mut scenes = Vec::new();

    let mut room = Room::closed_above(lambert(0.5, 0.5, 0.5));
    room.light(PointLight::new(v(0.3, 0.2, 1.5), Rgb::WHITE).expect("valid"));
    scenes.push(("point light alone", room.build(), rooms::camera(), true));

    let mut room = Room::default();
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), mirror.clone());
    let lamp = room.sphere(Sphere::new(v(0.0, 0.0, 1.0), 0.3), Material::Black);
    room.emit(lamp, Rgb::WHITE, false);
    scenes.push(("mirror", room.build(), rooms::camera(), true));

    let mut room = Room::default();
    room.sphere(Sphere::new(v(0.0, 0.0, 0.5), 0.5), lambert(0.5, 0.6, 0.7));
    room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
    scenes.push(("ball under a sky", room.build(), rooms::camera(), true));

    let mut room = Room::default();
    room.disk(v(0.0, 0.0, 0.5), v(0.3, -1.0, 1.0), 0.8, lambert(0.5, 0.6, 0.7));
    room.light(PointLight::new(v(0.3, -1.0, 1.5), Rgb::WHITE).expect("valid"));
    scenes.push(("one disk", room.build(), rooms::camera(), true));

    // The lamp is above the rest and shines up; the camera looks down on it.
    let mut room = Room::closed_above(lambert(0.5, 0.5, 0.5));
    let lamp =
        room.quad(v(-0.5, -0.5, 2.5), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), lambert(0.3, 0.3, 0.3));
    room.emit(lamp, Rgb::WHITE, false);
    scenes.push((
        "lamp that shines away",
        room.build(),
        eye(v(0.0, -3.0, 5.0), v(0.0, 0.0, 2.5)),
        true,
    ));

    let mut room = Room::open(lambert(0.5, 0.5, 0.5));
    room.light(PointLight::new(v(0.0, 0.0, 1.5), Rgb::BLACK).expect("valid"));
    scenes.push(("black light", room.build(), rooms::camera(), true));
    scenes
}

/// Mean and standard error of the image's luminance per sample.
fn mean<S: Scene, I: Integrator<S>>(
    scene: &S,
    camera: &(dyn Camera + Send),
    integrator: &I,
    samples: u32,
) -> Moments {
    let (mut sampler, mut scratch, mut moments) =
        (Random::new(3), Scratch::default(), Moments::default());
    let run = integrator.start(Stage::new(scene, camera), &Caller).expect("a run");
    for _ in 0..samples {
        let (film, mut sum) = (worlds::film_sample(camera, &mut sampler), 0.0);
        let mut add = |_: usize, c: &Contribution| sum += c.value.luminance() * c.weight;
        run.sample(film, &mut sampler, &mut add, &mut scratch);
        moments.add(sum);
    }
    moments
}

#[track_caller]
fn assert_same_mean(name: &str, a: Moments, b: Moments, resolution: f64) {
    let error = a.standard_error().hypot(b.standard_error());
    assert!((a.mean() - b.mean()).abs() <= 4.0 * error + 1e-12 * b.mean(), "{name}: {a:?} {b:?}");
    assert!(error <= resolution * b.mean(), "{name}: {error} of {} is too coarse", b.mean());
}
