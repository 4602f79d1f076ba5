//! C: Fresnel's equations, and what is seen through smooth interfaces.

use crate::entry::{Entry, RARE, expected};
use crate::measure::Method::{
    self, Bidirectional, Emission, Light, Merging, Path, PhotonMap, UniformArea,
};
use crate::scenes::{Stage, camera, footprint, lambert};
use pathspace::bsdf::fresnel::{conductor, dielectric};
use pathspace::endpoint::{self, DirectionalLight, PointLight, SpotLight};
use pathspace::geometry::Sphere;
use pathspace::glam::{DVec2, DVec3};
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::path::Roulette;
use pathspace::scene::{Material, World};
use std::f64::consts::PI;

const GLASS: Material = Material::Dielectric { relative_ior: 1.5 };
const UNLIMITED: Depth = Depth { min_bounces: 0, max_bounces: None };
/// Standard error of what is decided by a coin at every interface.
const COIN: f64 = 0.0015;
const COIN_RAYS: u64 = 8_000_000;

fn assert_value(id: &str, key: &str, value: f64, tolerance: f64) {
    let expected = expected(id, key);
    assert!(
        (value - expected).abs() <= tolerance * expected.abs() + 1e-15,
        "{id} {key}: {value}, expected {expected}"
    );
}

fn reflectance(degrees: f64, relative_ior: f64) -> f64 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    dielectric(cos, sin, relative_ior).reflectance
}

#[test]
fn c01_fresnel() {
    for (key, degrees) in [("normal", 0.0), ("60deg", 60.0), ("85deg", 85.0), ("89.9deg", 89.9)] {
        assert_value("C01", key, reflectance(degrees, 1.5), 1e-6);
    }
    assert_value("C01", "inside_40deg", reflectance(40.0, 1.0 / 1.5), 1e-6);
    // Only the s polarisation is left at Brewster's angle.
    let (sin, cos) = 1.5f64.atan().sin_cos();
    let s = ((cos - 1.5 * sin) / (cos + 1.5 * sin)).powi(2);
    assert!((dielectric(cos, sin, 1.5).reflectance - 0.5 * s).abs() < 1e-16);
    let critical = expected("C01", "critical_angle_deg");
    assert!(
        reflectance(critical - 1e-6, 1.0 / 1.5) < 1.0
            && reflectance(critical + 1e-6, 1.0 / 1.5) == 1.0
    );
}

#[test]
fn c02_diffuse_fresnel() {
    let average = |relative_ior: f64| {
        // ∫ 2 μ R dμ = ∫ R d(μ²)
        let n = 400_000;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
        (0..n)
            .map(|i| dielectric(at(i).sqrt(), (1.0 - at(i)).sqrt(), relative_ior).reflectance)
            .sum::<f64>()
            / f64::from(n)
    };
    assert_value("C02", "external", average(1.5), 1e-5);
    assert_value("C02", "internal", average(1.0 / 1.5), 1e-5);
}

#[test]
fn c16_conductor() {
    assert_value("C16", "", conductor(1.0, 0.0, 0.2, 3.0), 1e-6);
}

#[test]
fn c18_near_index_match() {
    assert_value("C18", "R_n=1.000001", dielectric(1.0, 0.0, 1.000_001).reflectance, 1e-9);
    assert_value("C18", "R_n=1.0001", dielectric(1.0, 0.0, 1.0001).reflectance, 1e-9);
    let r = dielectric(1.0, 0.0, 1.0001).reflectance;
    assert_value("C18", "slab_T_n=1.0001", (1.0 - r) / (1.0 + r), 1e-12);
}

/// Panes of glass, each between two heights, and a wall of radiance 1 at z = 2 that looks down or
/// at z = -2 that looks up.
fn panes(heights: &[(f64, f64)], above: bool) -> World {
    let mut stage = Stage::default();
    for &(low, high) in heights {
        stage.square(low, 100.0, false, GLASS);
        stage.square(high, 100.0, true, GLASS);
    }
    let wall = stage.square(if above { 2.0 } else { -2.0 }, 100.0, !above, Material::Black);
    stage.glow(wall, 1.0);
    stage.build()
}

#[test]
fn c03_slab() {
    let (through, back) = (panes(&[(0.0, 0.1)], true), panes(&[(0.0, 0.1)], false));
    for (key, world, tangent) in [
        ("T_normal", &through, 0.0),
        ("R_normal", &back, 0.0),
        ("T_60_unpolarised_tracer", &through, 3f64.sqrt()),
        ("R_60_unpolarised_tracer", &back, 3f64.sqrt()),
    ] {
        let eye = camera(DVec3::new(-tangent, 0.0, -1.0), DVec3::ZERO, 1e-4);
        let error = if key.starts_with('R') { RARE } else { COIN };
        Entry::new("C03", world, &eye, UNLIMITED)
            .within(error, COIN_RAYS)
            .check(&[Emission, Bidirectional], key);
    }
    let eye = camera(DVec3::NEG_Z, DVec3::ZERO, 1e-4);
    for m in [2, 4] {
        let entry = Entry::new("C03", &through, &eye, Depth::up_to(m)).within(COIN, COIN_RAYS);
        entry.check(&[Emission, Bidirectional], &format!("T_normal_trunc_{m}"));
    }
}

#[test]
fn c05_pile_of_plates() {
    let heights: Vec<(f64, f64)> =
        (0..10).map(|i| (0.02 * f64::from(i), 0.02 * f64::from(i) + 0.01)).collect();
    let eye = camera(DVec3::NEG_Z, DVec3::ZERO, 1e-4);
    Entry::new("C05", &panes(&heights, true), &eye, UNLIMITED)
        .within(RARE, COIN_RAYS)
        .check(&[Emission], "T");
    Entry::new("C05", &panes(&heights, false), &eye, UNLIMITED)
        .within(RARE, COIN_RAYS)
        .check_value(&[Emission], "R", expected("C05", "R"));
}

/// Walks cut off after m + 1 events carry what has not left after m of them.
#[test]
fn c07_parallel_beam_on_a_ball() {
    let mut stage = Stage::default();
    stage.sphere(Sphere::new(DVec3::ZERO, 1.0), GLASS);
    // Without anything diffuse, light tracing leaves out its walks.
    stage.sphere(Sphere::new(DVec3::splat(0.99), 1e-6), lambert(0.5));
    stage.light(DirectionalLight::new(DVec3::NEG_Z, Rgb::WHITE).expect("valid"));
    let (world, eye) = (stage.build(), camera(DVec3::Z * 5.0, DVec3::ZERO, 10.0));
    let samples = 600_000;
    let mut left = 1.0;
    for m in 1..=5u32 {
        let exits = expected("C07", &format!("exit_after_{m}"));
        left -= exits;
        let entry = Entry::new("C07", &world, &eye, Depth::up_to(m + 1)).roulette(Roulette::NEVER);
        let measured = entry.probe.sample(Light, samples, u64::from(m));
        let inside = measured.ledger.truncated.g() / samples as f64 / PI;
        // A walk hits the ball, which is part of the disk around its box, with this probability.
        let hit = PI / measured.ledger.emitted.g() * samples as f64;
        let error = (left * (1.0 - hit * left) / (hit * samples as f64)).sqrt();
        println!("C07 still inside after {m}: {inside:.6} ± {error:.1e}, expected {left:.6}");
        assert!((inside - left).abs() <= 4.0 * error, "{inside} ± {error}, expected {left}");
        assert!(error <= 2e-3);
    }
}

#[test]
fn c08_looking_out_of_a_medium() {
    let mut stage = Stage::default();
    stage.square(0.0, 10.0, true, GLASS);
    let wall = stage.square(1.0, 10.0, false, Material::Black);
    stage.glow(wall, 1.0);
    let (world, eye) = (stage.build(), camera(DVec3::NEG_Z, DVec3::ZERO, 1e-4));
    let entry = Entry::new("C08", &world, &eye, UNLIMITED).within(COIN, COIN_RAYS);
    entry.check(&[Emission, Bidirectional], "camera_inside");
    entry.check_blind(&[Light, UniformArea]);
}

/// The light of C11 and C12: as much of a point light above as meets what is looked at.
fn light_above() -> SpotLight {
    SpotLight::new(DVec3::Z * 3.0, DVec3::NEG_Z, Rgb::WHITE, 4.0, 4.5).expect("valid")
}

/// Floor, slab, light; the floor is a disk.
fn slab() -> World {
    let mut stage = Stage::default();
    stage.disk(DVec3::ZERO, DVec3::Z, 0.1, lambert(0.5));
    stage.square(1.0, 10.0, false, GLASS);
    stage.square(2.0, 10.0, true, GLASS);
    stage.light(light_above());
    stage.build()
}

/// The film is the square around the disk.
#[test]
fn c11_caustic_of_a_slab() {
    let (world, eye) = (slab(), footprint(DVec3::ZERO, 0.5, 0.1));
    let entry = Entry::new("C11", &world, &eye, UNLIMITED).within(RARE, 30_000_000);
    let expected = 0.5 / PI * entry.expected("E_mean_disc") * PI / 4.0;
    entry.check_value(&[Light, Bidirectional], "mean", expected);
    entry.check_blind(&[Emission, Path, UniformArea]);
    // Photons are missing at the border of the disk, and none around its middle.
    let eye = footprint(DVec3::ZERO, 0.5, 1e-4);
    let entry = Entry::new("C11", &world, &eye, UNLIMITED).within(RARE, 30_000_000).radius(0.03);
    let expected = 0.5 / PI * entry.expected("E_axis");
    entry.check_value(&[PhotonMap, Merging], "axis", expected);
}

/// Floor and water under a light. Looked at from z = 4 straight down, what the light on the floor
/// sends back has scattered three times.
fn pool(light: impl endpoint::Light + Send + 'static) -> World {
    let mut stage = Stage::default();
    stage.square(0.0, 100.0, true, lambert(0.5));
    stage.square(1.0, 100.0, true, Material::Dielectric { relative_ior: 1.33 });
    stage.light(light);
    stage.build()
}

#[test]
fn c12_nobody_sees_a_point_light_on_the_floor_of_a_pool() {
    let everywhere = pool(PointLight::new(DVec3::Z * 3.0, Rgb::WHITE).expect("valid"));
    for (world, degrees) in [(everywhere, 20.0), (pool(light_above()), 0.1)] {
        let eye = camera(DVec3::Z * 4.0, DVec3::ZERO, degrees);
        Entry::new("C12", &world, &eye, UNLIMITED).check_blind(&Method::SINGLE);
    }
}

#[test]
fn c12_photons_show_a_point_light_on_the_floor_of_a_pool() {
    let (world, eye) = (pool(light_above()), camera(DVec3::Z * 4.0, DVec3::ZERO, 0.1));
    Entry::new("C12", &world, &eye, Depth::exactly(3))
        .check(&[PhotonMap, Merging], "L_camera_single_diffuse");
}

#[test]
fn c13_invisible_interface() {
    for material in [
        Material::Dielectric { relative_ior: 1.0 },
        Material::RoughDielectric { relative_ior: 1.0, alpha: DVec2::splat(0.3) },
        Material::Null,
    ] {
        let mut stage = Stage::default();
        stage.sphere(Sphere::new(DVec3::ZERO, 0.5), material);
        let wall = stage.square(1.0, 10.0, false, Material::Black);
        stage.glow(wall, 1.0);
        let (world, eye) = (stage.build(), camera(DVec3::NEG_Z, DVec3::ZERO, 30.0));
        Entry::new("C13", &world, &eye, UNLIMITED)
            .within(1e-12, 100_000)
            .check(&[Emission, Bidirectional], "L");
    }
}
