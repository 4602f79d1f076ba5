//! Closed furnaces of mirrors: bias as ε², by which the weights of single reflections differ from 1.

use crate::estimate;
use crate::quadrature::exponent;
use crate::scenes::{camera, furnace_box, mirror};
use pathspace::glam::DVec3;
use pathspace::integrator::{Depth, PathTracer, PathTracing};
use pathspace::math::Rgb;
use pathspace::path::Roulette;
use pathspace::scene::{Material, Regularized};

const ALBEDO: f64 = 0.5;
const RADII: [f64; 3] = [0.1, 0.2, 0.4];

/// The exponent of the bias of a box of radiance 1 and of the albedo 1/2, with its standard error.
fn check(id: &str, wall: &Material, samples: u32) {
    let bounces = 20;
    let world = furnace_box(DVec3::ZERO, 1.0, wall, 1.0);
    let eye = camera(DVec3::splat(0.5), DVec3::new(1.0, 0.7, 0.4), 80.0);
    let exact = (1.0 - ALBEDO.powi(bounces as i32 + 1)) / (1.0 - ALBEDO);
    let path_tracer = PathTracer {
        mode: PathTracing::EmissionOnly,
        depth: Depth::up_to(bounces),
        roulette: Roulette::NEVER,
        ..PathTracer::default()
    };
    let plain = estimate((&world, &eye), &path_tracer, 1000, 1).mean();
    assert!((plain / exact - 1.0).abs() < 1e-9, "{id}: {plain}");
    let (mut bias, mut variance) = (Vec::new(), 0.0);
    for (epsilon, weight) in RADII.into_iter().zip([-1.0, 0.0, 1.0]) {
        let scene = Regularized::new(&world, epsilon).expect("a valid radius");
        let measured = estimate((&scene, &eye), &path_tracer, samples, 1);
        let (off, error) = (exact - measured.mean(), measured.standard_error());
        println!("{id} {epsilon}: {off:.3e} ± {error:.1e}");
        assert!(error < 0.06 * off, "{id}: {off} ± {error} has no sign of a bias");
        bias.push((epsilon, off / exact));
        // Of three equidistant logarithms the ends alone decide the slope.
        variance += (weight * error / off / 4f64.ln()).powi(2);
    }
    let (slope, error) = (exponent(&bias).0, variance.sqrt());
    println!("{id}: exponent {slope:.3} ± {error:.3}");
    assert!((slope - 2.0).abs() < 0.1 && error < 0.05, "{id}: {slope} ± {error}");
}

#[test]
fn a14_a_box_of_mirrors() {
    check("A14", &mirror(ALBEDO), 300_000);
}

#[test]
fn a05_a_box_of_mirrors_that_are_diffuse_as_well() {
    let diffuse = Material::Lambert { albedo: Rgb::splat(ALBEDO) };
    let components = Box::new([diffuse, mirror(ALBEDO)]);
    check("A05", &Material::Mixture { components, weights: [0.5, 0.5] }, 300_000);
}
