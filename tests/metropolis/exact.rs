//! Exact answers A01 to A08 and A16, over path tracing, bidirectional path tracing, and one
//! technique per sample.

use crate::measure::{Effort, Measured, measure};
use crate::scenes::{Stage, camera, cap_sphere, furnace_sphere, lambert};
use pathspace::endpoint::{ConstantEnvironment, PinholeCamera};
use pathspace::geometry::Sphere;
use pathspace::glam::DVec3;
use pathspace::integrator::{Bidirectional, Depth, Metropolis, Multiplexed, PathTracer};
use pathspace::math::Rgb;
use pathspace::scene::{Material, World};

const UNLIMITED: Depth = Depth { min_bounces: 0, max_bounces: None };

/// The mean over each of the integrators, with a relative standard error of at most 0.25 %.
fn check(what: &str, of: (&World, &PinholeCamera), depth: Depth, expected: [f64; 3]) {
    check_within(what, of, depth, expected, 0.0025);
}

/// The same, but for a bound of its own on the error of one technique per sample.
fn check_within(
    what: &str,
    of: (&World, &PinholeCamera),
    depth: Depth,
    expected: [f64; 3],
    multiplexed: f64,
) {
    let path_tracer = PathTracer { depth, ..PathTracer::default() };
    let bidirectional = Bidirectional { depth, ..Bidirectional::default() };
    let effort = |seed| Effort { sets: 64, samples: 128, seed };
    let of = (of.0, of.1 as &dyn pathspace::endpoint::Camera);
    let assert = |method: &str, measured: Measured, tolerance: f64| {
        measured.assert_mean(&format!("{what}, {method}"), expected, tolerance);
        assert_eq!(measured.counters.non_finite, 0, "{what}, {method}");
    };
    let candidates = Some(4096);
    let restart = 16;
    let over = Metropolis { candidates, restart, ..Metropolis::over(path_tracer) };
    assert("path tracing", measure(of, &over, effort(1)), 0.0025);
    let over = Metropolis { candidates, restart, ..Metropolis::over(bidirectional) };
    assert("bidirectional", measure(of, &over, effort(2)), 0.0025);
    // One technique says less of b than all of them.
    let candidates = Some(1 << 16);
    let over = Multiplexed { bidirectional };
    let over = Metropolis { candidates, restart, ..Metropolis::over(over) };
    assert("multiplexed", measure(of, &over, effort(3)), multiplexed);
}

fn inside() -> PinholeCamera {
    camera(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 80.0)
}

#[test]
fn a01_closed_furnace() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(0.5), 1.0);
    check("A01", (&world, &inside()), UNLIMITED, [2.0; 3]);
}

#[test]
fn a02_truncated_furnace() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(0.8), 1.0);
    for k in [0, 1, 4] {
        let expected = (1.0 - 0.8f64.powi(k + 1)) / 0.2;
        let depth = Depth::up_to(k as u32);
        check(&format!("A02, {k}"), (&world, &inside()), depth, [expected; 3]);
    }
}

#[test]
fn a03_white_furnace_of_twenty_bounces() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(0.9999), 1.0);
    let expected = (1.0 - 0.9999f64.powi(21)) / 1e-4;
    check("A03", (&world, &inside()), Depth::up_to(20), [expected; 3]);
}

/// Up to 4 bounces: chains stay where the brightest channel is. Those of one technique keep the
/// length, too, so that red, nearly all of it of the shortest path, hangs on the number of chains.
#[test]
fn a04_coloured_furnace() {
    let wall = Material::Lambert { albedo: Rgb::new(0.2, 0.5, 0.9) };
    let world = furnace_sphere(DVec3::ZERO, 1.0, &wall, 1.0);
    let expected = [0.2f64, 0.5, 0.9].map(|albedo| (1.0 - albedo.powi(5)) / (1.0 - albedo));
    check_within("A04", (&world, &inside()), Depth::up_to(4), expected, 0.025);
}

#[test]
fn a06_sphere_in_an_environment() {
    let mut stage = Stage::default();
    stage.sphere(Sphere::new(DVec3::ZERO, 1.0), lambert(0.6));
    stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
    let eye = camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, 26.0);
    check("A06", (&stage.build(), &eye), UNLIMITED, [0.6; 3]);
}

#[test]
fn a08_sphere_with_a_cap() {
    let world = cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0);
    let down = camera(DVec3::ZERO, DVec3::NEG_Z, 53.0);
    check("A08, wall", (&world, &down), UNLIMITED, [0.1; 3]);
    for k in 1..=3 {
        let expected = 0.1 * 0.5f64.powi(k);
        let depth = Depth::exactly(k as u32);
        check(&format!("A08, bounce {k}"), (&world, &down), depth, [expected; 3]);
    }
    let up = camera(DVec3::ZERO, DVec3::Z, 40.0);
    check("A08, cap", (&world, &up), UNLIMITED, [1.1; 3]);
}

/// The constant is the mean of the image.
#[test]
fn a16_normalization() {
    let world = cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0);
    let down = camera(DVec3::ZERO, DVec3::NEG_Z, 60.0);
    let bidirectional = Bidirectional::default();
    let over =
        Metropolis { candidates: Some(4096), restart: 16, ..Metropolis::over(bidirectional) };
    let measured = measure((&world, &down), &over, Effort { sets: 64, samples: 128, seed: 4 });
    measured.assert_mean("A16", [0.1; 3], 0.0025);
    let (b, error) = measured.b;
    assert!(error > 0.0 && error < 0.0025, "{error}");
    assert!((b / 0.1 - 1.0).abs() <= 4.0 * error, "{b} ± {error}");
}
