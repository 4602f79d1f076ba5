//! Caustics of a point light, which path tracing cannot see without mollifiers: with those of the
//! radius ε its mean is a smooth integral over their discs, which tends to the exact answer as ε².

use crate::estimate;
use crate::quadrature::{exponent, over_disc};
use crate::scenes::{Stage, camera, fresnel, lambert, mirror};
use pathspace::endpoint::{PinholeCamera, PointLight};
use pathspace::glam::{DMat2, DVec2, DVec3};
use pathspace::integrator::{Depth, PathTracer};
use pathspace::math::Rgb;
use pathspace::scene::{Material, Regularized, World};
use std::f64::consts::PI;

const ALBEDO: f64 = 0.5;
const WATER: f64 = 1.33;

/// A floor at z = 0 under a point light of intensity 1, and something else.
fn floor_and(light: DVec3, add: impl Fn(&mut Stage)) -> World {
    let mut stage = Stage::default();
    stage.square(0.0, 100.0, true, lambert(ALBEDO));
    stage.light(PointLight::new(light, Rgb::WHITE).expect("valid"));
    add(&mut stage);
    stage.build()
}

/// Light from (0, 0, 1) by way of a mirror in the plane x = 2, looked at where it meets the floor
/// under the light (row C10).
fn wall() -> (World, PinholeCamera) {
    let world = floor_and(DVec3::Z, |stage| {
        let origin = DVec3::new(2.0, -50.0, 0.0);
        stage.quad(origin, DVec3::Z * 50.0, DVec3::Y * 100.0, mirror(0.9));
    });
    (world, camera(DVec3::new(-0.5, 0.0, 2.0), DVec3::ZERO, 1e-4))
}

/// A point light over water, and its light on the floor as seen from above (row C12).
pub fn pool() -> (World, PinholeCamera) {
    let world = floor_and(DVec3::Z * 3.0, |stage| {
        stage.square(1.0, 100.0, true, Material::Dielectric { relative_ior: WATER });
    });
    (world, camera(DVec3::Z * 4.0, DVec3::ZERO, 1e-4))
}

/// The irradiance that the wall sends to the origin. The slope towards a point is its offset over
/// its distance from the plane, so that the discs of slopes are discs on the mirror.
fn irradiance_by_wall(epsilon: f64) -> f64 {
    // On the plane: from the light and from the floor, both at a distance of 2.
    let [light, floor] = [DVec2::new(0.0, 1.0), DVec2::ZERO];
    over_disc(epsilon, |difference| {
        let place = 0.5 * (light + floor) + difference;
        let [z_light, z_floor] = [light, floor].map(|end| (end - place) / 2.0);
        let [to_light, to_floor] = [z_light, z_floor].map(|z| 1.0 + z.length_squared());
        let value = 0.9 * to_light * to_floor;
        // cos/r² at the mirror is (1 + z²)^(-3/2)/h², and the floor has a cosine of its own.
        let cosine = place.y / (2.0 * to_floor.sqrt());
        value * (to_light * to_floor).powf(-1.5) / 16.0 * cosine
    })
}

/// The slope in the air of light that has another one in the water.
fn bent(slope: DVec2) -> DVec2 {
    let scaled = slope * (WATER / (1.0 + slope.length_squared()).sqrt());
    scaled / (1.0 - scaled.length_squared()).sqrt()
}

/// The irradiance of the floor at a distance from the axis, by way of the water.
fn irradiance_by_water(distance: f64, epsilon: f64) -> f64 {
    let (light, floor) = (DVec2::ZERO, DVec2::new(distance, 0.0));
    // The light is 2 above the water, the floor 1 below it.
    let difference = |place: DVec2| 0.5 * (light - place) + bent(floor - place);
    let jacobian = |place: DVec2| {
        let along = |axis: DVec2| {
            let h = 1e-5;
            (difference(place + axis * h) - difference(place - axis * h)) / (2.0 * h)
        };
        DMat2::from_cols(along(DVec2::X), along(DVec2::Y))
    };
    over_disc(epsilon, |wanted| {
        let mut place = 0.5 * floor;
        for _ in 0..30 {
            place -= jacobian(place).inverse() * (difference(place) - wanted);
        }
        assert!(difference(place).distance(wanted) < 1e-12);
        let (z_light, z_floor) = (0.5 * (light - place), floor - place);
        let [in_air, in_water] = [z_light, z_floor].map(|z| 1.0 + z.length_squared());
        let sine = WATER * (1.0 - 1.0 / in_water).sqrt();
        let passing =
            1.0 - fresnel(in_water.sqrt().recip(), (1.0 - sine * sine).sqrt(), 1.0 / WATER);
        let value = passing * WATER * WATER * in_air * (1.0 + bent(z_floor).length_squared());
        let cosines = in_air.powf(-1.5) / 4.0 * in_water.powi(-2);
        value * cosines / jacobian(place).determinant().abs()
    })
}

/// The radiance that the camera above the pool sees.
pub fn radiance_of_pool(epsilon: f64) -> f64 {
    let passing = 1.0 - fresnel(1.0, 1.0, WATER);
    over_disc(epsilon, |slope| {
        let sine = slope.length() / (1.0 + slope.length_squared()).sqrt() / WATER;
        let distance = sine / (1.0 - sine * sine).sqrt();
        let squeeze = 1.0 / (WATER * WATER * (1.0 + slope.length_squared()));
        passing * squeeze * ALBEDO / PI * irradiance_by_water(distance, epsilon)
    })
}

/// The exponent of a bias, and that of the largest radii alone.
fn assert_quadratic(name: &str, exact: f64, mean: impl Fn(f64) -> f64) {
    let radii = [0.01, 0.02, 0.05, 0.1, 0.2];
    let bias = radii.map(|epsilon| (epsilon, (mean(epsilon) / exact - 1.0).abs()));
    let (slope, error) = exponent(&bias);
    println!("{name}: {bias:?}, exponent {slope:.4} ± {error:.4}");
    assert!((slope - 2.0).abs() < 0.1 && error < 0.02, "{name}: {slope} ± {error}");
    assert!(bias[0].1 < 1e-3 && bias[4].1 > 1e-4, "{name}: {bias:?}");
}

#[test]
fn r01_the_bias_of_caustics_falls_as_the_square_of_the_radius() {
    assert_quadratic("mirror", 0.012_840_121_325_452_92, irradiance_by_wall);
    assert_quadratic("water", 0.129_401_973_980_281_64, |e| irradiance_by_water(0.0, e));
    assert_quadratic("pool", 0.011_409_261_685_856_768, radiance_of_pool);
}

/// Path tracing with a relative standard error, at most, that 4 of them would show a bias by.
fn check(
    (world, eye): &(World, PinholeCamera),
    bounces: u32,
    radii: [(f64, u32, f64); 2],
    expected: impl Fn(f64) -> f64,
) {
    let path_tracer = PathTracer { depth: Depth::exactly(bounces), ..PathTracer::default() };
    assert_eq!(estimate((world, eye), &path_tracer, 20_000, 1).mean(), 0.0);
    for (epsilon, samples, target) in radii {
        let scene = Regularized::new(world, epsilon).expect("a valid radius");
        let measured = estimate((&scene, eye), &path_tracer, samples, 1);
        let (expected, error) = (expected(epsilon), measured.standard_error());
        let z = (measured.mean() - expected) / error;
        println!(
            "{epsilon} {:.8} expected {expected:.8} z {z:.2} {:.2e}",
            measured.mean(),
            error / expected
        );
        assert!(z.abs() < 4.0, "{epsilon}: {} is {z} errors off {expected}", measured.mean());
        assert!(error < target * expected, "{error} of {expected} sees too little");
    }
}

#[test]
fn r01_path_tracing_sees_the_caustic_of_a_mirror() {
    // Larger discs would reach below the floor.
    let radii = [(0.45, 6_000_000, 0.005), (0.3, 6_000_000, 0.0075)];
    check(&wall(), 2, radii, |epsilon| ALBEDO / PI * irradiance_by_wall(epsilon));
}

#[test]
fn r01_path_tracing_sees_the_floor_of_a_pool() {
    check(&pool(), 3, [(0.6, 1_900_000, 0.0025), (0.2, 2_000_000, 0.0075)], radiance_of_pool);
}
