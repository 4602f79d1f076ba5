//! A: closed furnaces and integrating spheres.

use crate::entry::{Entry, MOST, RARE};
use crate::measure::Method::{
    self, Bidirectional, Emission, Light, Merging, Path, PhotonMap, UniformArea, VirtualLights,
};
use crate::scenes::{Stage, camera, cap_sphere, furnace_box, furnace_sphere, lambert, mirror};
use pathspace::endpoint::{ConstantEnvironment, PinholeCamera, PointLight};
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::DVec3;
use pathspace::integrator::{Depth, InstantRadiosity, PathTracer};
use pathspace::math::Rgb;
use pathspace::path::{MAX_BOUNCES, Roulette};
use pathspace::scene::{Material, World};

/// Uniform-area sampling has no infinite variance only where there are no corners: in the sphere.
const IN_A_BOX: [Method; 4] = [Emission, Path, Light, Bidirectional];
const UNLIMITED: Depth = Depth { min_bounces: 0, max_bounces: None };

fn boxed(albedo: f64) -> (World, PinholeCamera) {
    (
        furnace_box(DVec3::ZERO, 1.0, &lambert(albedo), 1.0),
        camera(DVec3::splat(0.5), DVec3::new(1.0, 0.7, 0.4), 80.0),
    )
}

fn sphere(albedo: f64) -> (World, PinholeCamera) {
    (
        furnace_sphere(DVec3::ZERO, 1.0, &lambert(albedo), 1.0),
        camera(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 80.0),
    )
}

#[test]
fn a01_closed_furnace() {
    let (world, eye) = sphere(0.5);
    Entry::new("A01", &world, &eye, UNLIMITED).within(RARE, MOST).check(&Method::ALL, "");
    let (world, eye) = boxed(0.5);
    Entry::new("A01", &world, &eye, UNLIMITED).within(RARE, MOST).check(&IN_A_BOX, "");
}

#[test]
fn a02_truncated_furnace() {
    let (world, eye) = sphere(0.8);
    for k in [0, 1, 2, 3, 4, 8, 16, 64] {
        let entry = Entry::new("A02", &world, &eye, Depth::up_to(k)).within(RARE, MOST);
        // Connections grow with the square of the bounces.
        entry.check(if k > 16 { &Method::SINGLE[..4] } else { &Method::ALL }, &format!("k={k}"));
    }
    let (world, eye) = boxed(0.8);
    for k in [1, 3] {
        Entry::new("A02", &world, &eye, Depth::up_to(k))
            .within(RARE, MOST)
            .check(&IN_A_BOX, &format!("k={k}"));
    }
}

/// The white furnace. Without roulette every path of k bounces brings the same: no variance from
/// the camera, little from the light.
#[test]
fn a03_white_furnace() {
    let (world, eye) = sphere(0.9999);
    for k in [1000, 10_000] {
        let entry = Entry::new("A03", &world, &eye, Depth::up_to(k)).roulette(Roulette::NEVER);
        let entry = entry.within(0.002, 40 * u64::from(k));
        entry.check(&[Emission], &format!("k={k}"));
    }
    let entry = Entry::new("A03", &world, &eye, Depth::up_to(1000)).roulette(Roulette::NEVER);
    entry.check(&[Light, UniformArea], "k=1000");
    let expected = (1.0 - 0.9999f64.powi(21)) / 1e-4;
    Entry::new("A03", &world, &eye, Depth::up_to(20)).check_value(
        &[Bidirectional],
        "k=20",
        expected,
    );
    // Roulette makes the number of bounces geometric, a relative variance of 1: 10⁴ rays for one
    // sample.
    Entry::new("A03", &world, &eye, UNLIMITED).within(0.08, 3_000_000).check_value(
        &[Emission],
        "inf",
        to_the_end_of_walks(),
    );
}

/// The series up to the limit of all walks, 4 % below that without end.
fn to_the_end_of_walks() -> f64 {
    (1.0 - 0.9999f64.powi(MAX_BOUNCES as i32 + 1)) / 1e-4
}

fn a03_in_full(method: Method) {
    let (world, eye) = sphere(0.9999);
    let entry = Entry::new("A03", &world, &eye, UNLIMITED).within(0.002, 5_000_000_000);
    entry.check_value(&[method], "inf", to_the_end_of_walks());
}

#[test]
#[ignore = "3e9 rays"]
fn a03_white_furnace_in_full_from_the_camera() {
    a03_in_full(Emission);
}

#[test]
#[ignore = "3e9 rays"]
fn a03_white_furnace_in_full_from_the_light() {
    a03_in_full(Light);
}

#[test]
fn a04_coloured_furnace() {
    let wall = Material::Lambert { albedo: Rgb::new(0.2, 0.5, 0.9) };
    let world = furnace_sphere(DVec3::ZERO, 1.0, &wall, 1.0);
    let (_, eye) = sphere(0.5);
    let entry = Entry::new("A04", &world, &eye, UNLIMITED).within(RARE, MOST);
    entry.check_rgb(&Method::ALL, "RGB", ["R", "G", "B"].map(|key| entry.expected(key)));
}

#[test]
fn a06_sphere_in_an_environment() {
    let mut stage = Stage::default();
    stage.sphere(Sphere::new(DVec3::ZERO, 1.0), lambert(0.6));
    stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
    let (world, eye) = (stage.build(), camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, 26.0));
    let entry = Entry::new("A06", &world, &eye, UNLIMITED).within(RARE, MOST);
    entry.check(&IN_A_BOX, "");
    entry.check_blind(&[UniformArea]);
}

#[test]
fn a08_sphere_with_a_cap() {
    let world = cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0);
    let down = camera(DVec3::ZERO, DVec3::NEG_Z, 53.0);
    Entry::new("A08", &world, &down, UNLIMITED).within(RARE, MOST).check(&Method::ALL, "wall");
    for k in 1..=3 {
        Entry::new("A08", &world, &down, Depth::exactly(k))
            .within(0.02, MOST)
            .check(&Method::ALL, &format!("bounce_{k}"));
    }
    let up = camera(DVec3::ZERO, DVec3::Z, 40.0);
    Entry::new("A08", &world, &up, UNLIMITED).within(RARE, MOST).check(&Method::ALL, "cap");
}

#[test]
fn a10_point_light_in_a_sphere_with_a_port() {
    let mut stage = Stage::default();
    stage.sphere(
        Sphere { inward: true, cos_max: 0.9, axis: DVec3::Z, ..Sphere::new(DVec3::ZERO, 1.0) },
        lambert(0.9),
    );
    stage.light(PointLight::new(DVec3::ZERO, Rgb::WHITE).expect("valid"));
    let (world, eye) = (stage.build(), camera(DVec3::new(0.1, 0.0, 0.3), DVec3::NEG_Z, 60.0));
    let entry = Entry::new("A10", &world, &eye, UNLIMITED).within(RARE, MOST);
    entry.check(&[Path, Light, Bidirectional, PhotonMap, Merging, VirtualLights], "wall_radiance");
    entry.check_blind(&[Emission, UniformArea]);
}

/// Two half planes that meet at an angle, whose supplement is given: at 0 they are one and reflect
/// ρ of the sky.
fn wedge(degrees: f64) -> World {
    let mut stage = Stage::default();
    let (sin, cos) = (180.0 - degrees).to_radians().sin_cos();
    let side = DVec3::new(cos, 0.0, sin);
    let along = DVec3::Y * 2e4;
    let corner = DVec3::new(0.0, -1e4, 0.0);
    stage.face(Quad { origin: corner, edge_u: DVec3::X * 1e4, edge_v: along }, lambert(0.6));
    stage.face(Quad { origin: corner, edge_u: along, edge_v: side * 1e4 }, lambert(0.6));
    stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
    stage.build()
}

/// The camera looks at a point of one plane at distance 1 from the edge. The angle of the entry's
/// formula is the supplement of the opening.
#[test]
fn a13_wedge() {
    for degrees in [60.0f64, 90.0, 120.0] {
        let (world, eye) = (wedge(degrees), camera(DVec3::new(1.0, 0.0, 0.5), DVec3::X, 1e-3));
        Entry::new("A13", &world, &eye, UNLIMITED)
            .within(RARE, MOST)
            .check(&[Emission, Path, Bidirectional], &format!("{degrees}deg"));
    }
}

/// A bound on geometry terms cuts off half of a sphere's second bounce, which is lost, or drawn by
/// going on.
#[test]
fn a12_bound_of_virtual_lights() {
    let world = cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0);
    let eye = camera(DVec3::ZERO, DVec3::NEG_Z, 53.0);
    let entry = Entry::new("A12", &world, &eye, Depth::exactly(2));
    let clamped = entry.expected("bounce_2_clamped");
    for (compensates, expected) in [(false, clamped), (true, 2.0 * clamped)] {
        let path_tracer = PathTracer { depth: entry.probe.depth, ..PathTracer::default() };
        let bound = Some(0.125);
        let integrator = InstantRadiosity { path_tracer, bound, compensates, light_walks: 64 };
        let measured = entry.probe.run(&integrator, 200_000, 1);
        println!("A12 {compensates}: {:?}, expected {expected}", measured.channels[1]);
        assert!(measured.agrees([expected; 3], entry.tolerance()), "{measured:?}");
        assert!(measured.relative_error([expected; 3]) <= entry.error, "{measured:?}");
    }
}

/// Virtual lights on 1e4 × 1e4, with a bound that leaves what is nearer than some 1e3 to path
/// tracing.
#[test]
fn a13_wedge_by_virtual_lights() {
    for degrees in [60.0f64, 90.0, 120.0] {
        let (world, eye) = (wedge(degrees), camera(DVec3::new(1.0, 0.0, 0.5), DVec3::X, 1e-3));
        let entry = Entry::new("A13", &world, &eye, UNLIMITED);
        let expected = entry.expected(&format!("{degrees}deg"));
        let integrator = |compensates| InstantRadiosity {
            bound: Some(1e-7),
            compensates,
            ..InstantRadiosity::default()
        };
        let measured = entry.probe.run(&integrator(true), 200_000, 1);
        println!("A13 {degrees}deg IR: {:?}, expected {expected}", measured.channels[1]);
        assert!(measured.agrees([expected; 3], entry.tolerance()), "{measured:?}");
        assert!(measured.relative_error([expected; 3]) <= RARE, "{measured:?}");
        // The light of one bounce is left.
        let dark = entry.probe.run(&integrator(false), 20_000, 1).channels[1];
        assert!(dark.mean() + 4.0 * dark.standard_error() < 0.9 * expected, "{dark:?}");
    }
}

#[test]
fn a14_mirrors() {
    let parallel = |lower: bool| {
        let mut stage = Stage::default();
        for (z, up) in [(0.0, true), (1.0, false)] {
            let plane = stage.square(z, 1.0, up, mirror(0.8));
            if up == lower {
                stage.glow(plane, 1.0);
            }
        }
        stage.build()
    };
    let eye = camera(DVec3::new(0.1, 0.2, 0.5), DVec3::new(0.1, 0.2, 0.0), 1e-6);
    // 0.8³⁰⁰ is below the rounding of the sum.
    let deep = Depth::up_to(300);
    for (lower, key) in [(true, "hit_emissive_first"), (false, "hit_plain_first")] {
        Entry::new("A14", &parallel(lower), &eye, deep)
            .roulette(Roulette::NEVER)
            .check(&[Emission], key);
    }
    for k in [2, 4, 10] {
        let world = parallel(true);
        Entry::new("A14", &world, &eye, Depth::up_to(k))
            .roulette(Roulette::NEVER)
            .check(&[Emission], &format!("truncated_k={k}"));
    }
    let world = furnace_box(DVec3::ZERO, 1.0, &mirror(0.8), 1.0);
    let eye = camera(DVec3::splat(0.5), DVec3::new(1.0, 0.7, 0.4), 80.0);
    Entry::new("A14", &world, &eye, deep)
        .roulette(Roulette::NEVER)
        .check(&[Emission], "closed_mirror_box");
    let reflected = Depth { min_bounces: 1, max_bounces: Some(20) };
    Entry::new("A14", &world, &eye, reflected).check_blind(&[Light, UniformArea]);
}
