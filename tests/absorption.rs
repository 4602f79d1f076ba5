//! Absorbing bodies: closed forms for every integrator, and paths evaluated anew.
#![allow(missing_docs, reason = "a test program")]

mod common;
#[path = "../examples/stability/measure.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod measure;
#[path = "../examples/stability/scenes.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod scenes;

use common::Random;
use measure::{Method, Probe};
use pathspace::endpoint::{Camera, ConstantEnvironment, PinholeCamera};
use pathspace::film::{FilmSample, Sample};
use pathspace::geometry::{Sphere, SurfacePoint};
use pathspace::glam::{DVec2, DVec3};
use pathspace::integrator::{Bidirectional, Depth};
use pathspace::math::Rgb;
use pathspace::path::{Scratch, Weighting};
use pathspace::sampler::Sampler;
use pathspace::scene::{Material, Scene, SceneError, World};
use scenes::{Stage, camera, cube, lambert};

/// Absorption, per channel.
const SIGMA: Rgb = Rgb([0.5, 1.0, 5.0]);

/// What is seen in the middle of a sphere of radius 1 whose wall of albedo 1/2 emits radiance 1,
/// with an absorber of [`SIGMA`] inside: `e^{-τ}/(1 - T/2)`, where T is the mean of the transmittance
/// over cosine-distributed chords, `(1 - e^{-2τ}(1 + 2τ))/(2τ²)`.
fn seen_in_the_middle() -> [f64; 3] {
    SIGMA.0.map(|tau| {
        let mean = (1.0 - (-2.0 * tau).exp() * (1.0 + 2.0 * tau)) / (2.0 * tau * tau);
        (-tau).exp() / (1.0 - 0.5 * mean)
    })
}

fn check(world: &World, eye: &PinholeCamera) {
    let expected = seen_in_the_middle();
    let probe = Probe::new(world, eye, Depth::default());
    for method in Method::ALL {
        let measured = probe.estimate(method, expected, [0.002, 0.004], (3_000_000, 6_000_000), 1);
        assert!(measured.relative_error(expected) < 0.004, "{method:?}: {measured:?}");
        assert!(measured.agrees(expected, 0.002), "{method:?}: {measured:?}, not {expected:?}");
    }
}

/// The wall bounds the absorber.
#[test]
fn a_furnace_full_of_absorber() {
    let mut stage = Stage::default();
    let wall = stage.sphere(Sphere::new(DVec3::ZERO, 1.0), lambert(0.5));
    stage.absorb(wall, SIGMA);
    stage.emit(wall, Rgb::WHITE, true);
    check(&stage.build(), &camera(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 80.0));
}

/// The whole furnace lies in a body that absorbs: its wall, its light and the camera know nothing
/// of it.
#[test]
fn a_furnace_inside_of_an_absorber() {
    let mut stage = Stage::default();
    let inward = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) };
    let wall = stage.sphere(inward, lambert(0.5));
    stage.glow(wall, 1.0);
    // The second lies beside it, where rays from inside cross it.
    let beside = DVec3::new(0.36, 0.48, 0.8) * 7.0;
    for body in [Sphere::new(DVec3::X, 3.0), Sphere::new(beside, 1.0)] {
        let body = stage.sphere(body, Material::Null);
        stage.absorb(body, SIGMA);
    }
    check(&stage.build(), &camera(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 80.0));
}

/// A ball of coloured glass under a uniform sky, seen along a diameter: with F of the surface and
/// `A = e^{-2σ}`, `F + (1 - F)² A / (1 - F A)`.
#[test]
fn coloured_glass_along_a_diameter() {
    let mut stage = Stage::default();
    let (glass, sigma) = (Material::Dielectric { relative_ior: 1.5 }, Rgb::new(0.0, 0.1, 0.5));
    let ball = stage.sphere(Sphere::new(DVec3::ZERO, 1.0), glass);
    stage.absorb(ball, sigma);
    stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("a sky"));
    let world = stage.build();
    let eye = camera(DVec3::X * 5.0, DVec3::ZERO, 1.0);
    let expected = sigma.0.map(|sigma| {
        let (f, a) = (0.04, (-2.0 * sigma).exp());
        f + (1.0 - f) * (1.0 - f) * a / (1.0 - f * a)
    });
    let probe = Probe { fixed: true, ..Probe::new(&world, &eye, Depth::default()) };
    for method in [Method::Emission, Method::Path, Method::Bidirectional] {
        let measured = probe.sample(method, 1_000_000, 1);
        assert!(measured.relative_error(expected) < 0.003, "{method:?}: {measured:?}");
        assert!(measured.agrees(expected, 0.0), "{method:?}: {measured:?}, not {expected:?}");
    }
}

/// A closed room full of absorber with a lamp, a ball and a rough glass body of another absorber in
/// it, which has a ball inside.
fn nested() -> World {
    let mut stage = Stage::default();
    for face in cube(DVec3::splat(-1.0), 2.0) {
        stage.face(face, lambert(0.6));
    }
    let lamp = stage.sphere(Sphere::new(DVec3::new(-0.4, -0.3, 0.55), 0.35), lambert(0.2));
    stage.glow(lamp, 2.0);
    let alpha = DVec2::splat(0.4);
    let glass = Material::RoughDielectric { relative_ior: 1.3, alpha };
    let body = stage.sphere(Sphere::new(DVec3::new(0.3, 0.2, -0.4), 0.5), glass);
    stage.absorb(body, Rgb::new(0.2, 1.0, 2.0));
    stage.sphere(Sphere::new(DVec3::new(0.3, 0.2, -0.4), 0.2), lambert(0.7));
    let all = stage.sphere(Sphere::new(DVec3::ZERO, 4.0), Material::Null);
    stage.absorb(all, Rgb::new(0.3, 0.1, 0.0));
    stage.build()
}

/// To 2 %; the closed forms and the paths evaluated anew are finer.
#[test]
fn integrators_agree_on_nested_bodies() {
    let world = nested();
    let eye = camera(DVec3::new(-0.8, -0.7, 0.1), DVec3::new(0.3, 0.2, -0.3), 110.0);
    let probe = Probe::new(&world, &eye, Depth::up_to(3));
    let measured =
        [(Method::Path, 1_000_000), (Method::Bidirectional, 200_000), (Method::Light, 2_000_000)]
            .map(|(method, samples)| probe.sample(method, samples, 3));
    for (i, a) in measured.iter().enumerate() {
        for b in &measured[..i] {
            for (a, b) in a.channels.iter().zip(&b.channels) {
                let error = a.standard_error().hypot(b.standard_error());
                assert!(error < 0.005 * b.mean(), "{a:?} {b:?}");
                assert!((a.mean() - b.mean()).abs() < 4.0 * error, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn paths_are_what_the_definitions_say() {
    let world = nested();
    let eye = camera(DVec3::new(-0.8, -0.7, 0.1), DVec3::new(0.3, 0.2, -0.3), 60.0);
    let integrator = Bidirectional { depth: Depth::up_to(5), ..Default::default() };
    let weighting =
        Weighting::new(integrator.techniques.pruned(&world.needs()), integrator.heuristic);
    let stage = pathspace::integrator::Stage::new(&world, &eye);
    let (mut sampler, mut scratch, mut paths, mut dimmed) =
        (Random::new(1), Scratch::default(), 0, 0);
    while paths < 50_000 {
        let raster = eye.film().from_window(sampler.next_2d());
        let film = FilmSample { raster, offset: DVec2::ZERO };
        let sample = Sample { film, sampler: &mut sampler };
        integrator.for_each_path(stage, sample, &mut scratch, |path, _| {
            let verified = path.verify(&weighting);
            assert!(verified.worst() < 1e-7, "{path:?} {verified:?}");
            let record = path.record();
            dimmed += usize::from(record.transmittances.iter().all(|t| t.r() < 1.0));
            paths += 1;
        });
    }
    assert_eq!(dimmed, paths, "every edge lies in an absorber");
}

#[test]
fn infinity_is_dark_only_where_something_absorbs() {
    let mut stage = Stage::default();
    let ball = stage.sphere(Sphere::new(DVec3::ZERO, 1.0), Material::Null);
    stage.absorb(ball, Rgb::new(1.0, 0.0, 0.0));
    let world = stage.build();
    let inside = world.intersect(&SurfacePoint::dirac(DVec3::ZERO), DVec3::X).expect("the ball");
    let sky = SurfacePoint::infinite(DVec3::NEG_X * 2.0, DVec3::X);
    assert_eq!(world.transmittance(&inside, &sky), Rgb::new(0.0, 1.0, 1.0));
    assert_eq!(world.transmittance(&sky, &inside), Rgb::new(0.0, 1.0, 1.0));
    let beyond = SurfacePoint::infinite(DVec3::X * 2.0, DVec3::NEG_X);
    assert_eq!(world.transmittance(&inside, &beyond), Rgb::WHITE);
    assert_eq!(world.medium_at(&SurfacePoint::dirac(DVec3::ZERO)), 1);
    assert_eq!(world.medium_at(&SurfacePoint::dirac(DVec3::X * 2.0)), 0);
    assert_eq!(world.medium_at(&SurfacePoint::dirac(DVec3::new(0.36, 0.48, 0.8) * -2.0)), 0);
}

#[test]
fn bad_absorption_is_refused() {
    let mut stage = Stage::default();
    let ball = stage.sphere(Sphere::new(DVec3::ZERO, 1.0), Material::Null);
    for sigma in [-1.0, f64::NAN, f64::INFINITY] {
        let error = stage.builder.set_absorption(ball, Rgb::new(0.0, sigma, 0.0));
        let Err(SceneError::Parameter { parameter: "absorption", .. }) = error else {
            panic!("{error:?}");
        };
    }
}
