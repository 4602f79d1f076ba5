//! The stress matrix S01–S52: each row a test with an oracle, an exact answer or the same scene without stress. Rows that are tested elsewhere
//! are listed in docs/numerics.md with the reason; `cargo run --release --example stability` prints the same cases in more detail.
//!
//! Standard errors are 0.5 % or what the case states; means must lie within 4 of them, nothing may be infinite or not a number, and with the same random
//! numbers a scene of another scale, place or brightness must give the same image up to rounding.
#![allow(missing_docs, reason = "a test program")]

#[path = "../examples/stability/cases.rs"]
mod cases;
#[path = "../examples/stability/measure.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod measure;
#[path = "../examples/stability/scenes.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod scenes;
#[path = "../examples/stability/verdict.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod verdict;

use measure::{Method, Probe};
use pathspace::endpoint::{ConstantEnvironment, EnvironmentMap, PinholeCamera, PointLight};
use pathspace::film::{ChunkFilm, Contribution, Film, FilmRegion, Sink, Technique};
use pathspace::geometry::{Frame, Sphere};
use pathspace::glam::{DAffine3, DVec2, DVec3, UVec2};
use pathspace::integrator::{Bidirectional, Depth, PathTracer};
use pathspace::math::{Rgb, warp};
use pathspace::path::{Heuristic, MAX_BOUNCES, Roulette};
use pathspace::render::{Budget, Render, Settings, unattended};
use pathspace::scene::{Material, Mesh};
use scenes::{Stage, camera, footprint, furnace_box, furnace_sphere, lambert};
use std::f64::consts::PI;

/// Rays per case and integrator.
const RAYS: u64 = 1_500_000;

/// All cases of a row hold.
fn check(row: &str) {
    check_precisely(row, 1.0);
}

/// `rounding`: how far images of the same random numbers may differ.
fn check_precisely(row: &str, rounding: f64) {
    let mut lines = 0;
    for case in cases::all().iter().filter(|case| case.row == row) {
        for line in verdict::judge(case, RAYS, 11) {
            println!("{line:?}");
            assert!(line.verdict.is_good() && line.verdict != verdict::Verdict::Imprecise, "{line:?}");
            assert!(line.rounding.is_none_or(|r| r <= rounding), "{line:?}");
            lines += 1;
        }
    }
    assert!(lines > 0, "no case of {row}");
}

macro_rules! rows {
    ($($name:ident, $row:literal;)*) => {$(
        #[test]
        fn $name() {
            check($row);
        }
    )*};
}

rows! {
    stress_s03_far_camera, "S03";
    stress_s05_bright_walls, "S05";
    stress_s06_white_walls, "S06";
    stress_s08_roulette_with_one_channel, "S08";
    stress_s09_tiny_sphere_light, "S09";
    stress_s10_close_to_a_sphere_light, "S10";
    stress_s11_mirrored_instance, "S11";
    stress_s13_slivers, "S13";
    stress_s15_coincident_walls, "S15";
    stress_s16_thin_gap, "S16";
    stress_s17_corner, "S17";
    stress_s18_long_weighted_paths, "S18";
    stress_s20_roughness_to_the_mirror_limit, "S20";
    stress_s21_grazing, "S21";
    stress_s22_index_near_one, "S22";
    stress_s23_critical_angle, "S23";
    stress_s27_bent_normals_of_a_light, "S27";
    stress_s31_useless_strong_light, "S31";
    stress_s37_diffuse_and_mirror, "S37";
    stress_s40_size_of_a_light, "S40";
    stress_s48_index_of_refraction, "S48";
    stress_s52_plane_under_a_directional_light, "S52";
}

#[test]
fn stress_s01_scene_scale() {
    check_precisely("S01", 1e-9);
}

#[test]
fn stress_s02_world_offset() {
    check("S02");
}

#[test]
fn stress_s04_radiance() {
    check_precisely("S04", 1e-12);
}

#[test]
fn stress_s30_scale_under_an_environment() {
    check_precisely("S30", 1e-9);
}

/// Without roulette nothing ends a walk in white walls but the library's own limit, which is reported.
#[test]
fn stress_s06_endless_walks_are_cut_off_and_counted() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(1.0), 1.0);
    let eye = camera(DVec3::ZERO, DVec3::X, 60.0);
    for method in [Method::Emission, Method::Path, Method::Light] {
        let measured = Probe::new(&world, &eye, Depth::default()).sample(method, 10, 1);
        assert_eq!(measured.truncated_walks, 10, "{method:?}");
        assert!(measured.agrees([f64::from(MAX_BOUNCES) + 1.0; 3], 0.05), "{method:?}: {measured:?}");
    }
}

#[test]
fn stress_s12_triangles_without_area() {
    let render = |slivers: bool| {
        let mut stage = Stage::default();
        stage.square(0.0, 1.0, true, lambert(0.5));
        let lamp = stage.square(2.0, 1.0, false, Material::Black);
        stage.glow(lamp, 1.0);
        if slivers {
            let positions = (0..1000).map(|i| DVec3::new(0.0, 0.0, f64::from(i) / 1000.0)).collect();
            let indices = (0..998).map(|i| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i, i, i + 1] }).chain([[0, 1, 0]]).collect();
            // One proper triangle out of sight, so that the mesh is a surface.
            let mut mesh = Mesh { positions, indices, ..Mesh::default() };
            mesh.positions.extend([DVec3::new(0.0, 0.0, 1.9), DVec3::new(0.001, 0.0, 1.9), DVec3::new(0.0, 0.001, 1.9)]);
            mesh.indices.push([1000, 1001, 1002]);
            let id = stage.mesh(&mesh, DAffine3::IDENTITY, Material::Black);
            stage.glow(id, 1.0);
        }
        let world = stage.world();
        assert_eq!(world.dropped_triangles(), if slivers { 999 } else { 0 });
        let eye = footprint(DVec3::new(0.4, 0.4, 0.0), 0.5, 0.1);
        let probe = Probe::new(&world, &eye, Depth::exactly(1));
        probe.estimate(Method::Path, [0.11; 3], [0.001, 0.001], (RAYS, RAYS), 3)
    };
    let (without, with) = (render(false).channels[0], render(true).channels[0]);
    let error = without.standard_error().hypot(with.standard_error());
    assert!((without.mean() - with.mean()).abs() < 4.0 * error && error < 0.002 * without.mean(), "{without:?} {with:?}");
}

/// Two techniques whose densities are as far apart as numbers allow.
#[test]
fn stress_s19_weights_of_extreme_densities() {
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0), Heuristic::Power(1.5)] {
        for (ratio, weight) in [(0.0, 1.0), (1e-300, 1.0), (1.0, 0.5), (1e300, 0.0), (f64::INFINITY, 0.0)] {
            let w: f64 = heuristic.weight([ratio]);
            assert!((w - weight).abs() < 1e-200, "{heuristic:?} {ratio}: {w}");
        }
    }
}

/// All of the sky black but a row at a pole; then all of it.
#[test]
fn stress_s29_black_rows_and_poles() {
    for (row, cosines) in [(Some(0), (1.0, (PI / 8.0).cos())), (Some(3), ((3.0 * PI / 8.0).cos(), 0.0)), (None, (0.0, 0.0))] {
        let pixel = |i: u32| if Some(i / 4) == row { Rgb::WHITE } else { Rgb::BLACK };
        let mut stage = Stage::default();
        stage.square(0.0, 0.5, true, lambert(1.0));
        stage.environment(EnvironmentMap::new(4, 8, (0..32).map(pixel).collect(), EnvironmentMap::Z_UP).expect("valid"));
        let (world, eye) = (stage.world(), footprint(DVec3::ZERO, 1.0, 0.5));
        let (near, far): (f64, f64) = cosines;
        // ∫ cos dσ / π over the row
        let expected = near * near - far * far;
        for method in [Method::Emission, Method::Path, Method::Bidirectional, Method::Light] {
            let measured = Probe::new(&world, &eye, Depth::exactly(1)).estimate(method, [expected; 3], [0.005, 0.005], (RAYS, RAYS), 4);
            assert_eq!(measured.non_finite, 0);
            assert!(measured.agrees([expected; 3], 1e-9), "{row:?} {method:?} {expected}: {measured:?}");
            assert!(measured.relative_error([expected; 3]) <= 0.02, "{row:?} {method:?}: {measured:?}");
        }
    }
}

/// No firefly: the pixels of a smoothly lit wall are alike.
#[test]
fn stress_s35_no_fireflies_from_a_point_light() {
    let mut stage = Stage::default();
    stage.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, lambert(0.9));
    stage.light(PointLight::new(DVec3::ZERO, Rgb::WHITE).expect("valid"));
    let world = stage.world();
    let eye = PinholeCamera::new(DVec3::new(0.1, 0.0, 0.3), DVec3::NEG_Z, DVec3::Y, 60.0, UVec2::splat(24)).expect("valid");
    let settings = Settings { budget: Budget::Samples(64), seed: 5, ..Settings::default() };
    let integrator = Bidirectional { roulette: Roulette { start: 10, ..Roulette::default() }, ..Bidirectional::default() };
    let rendering = integrator.render(&world, &eye, &settings, &mut unattended).expect("renders");
    let (mean, largest) = (rendering.image.mean().g(), rendering.image.pixels().iter().map(|p| p.g()).fold(0.0, f64::max));
    assert!(rendering.counters.non_finite == 0 && largest / mean < 3.0, "{largest} of {mean}");
}

/// 2²⁶ equal contributions, at which a sum in f32 stands still.
#[test]
fn stress_s45_film_of_many_samples() {
    let region = FilmRegion::full(UVec2::ONE);
    let mut film = Film::new(region).expect("a film");
    let mut chunk = ChunkFilm::new(region);
    let one = Contribution { raster: DVec2::splat(0.5), value: Rgb::WHITE, weight: 1.0, technique: Technique { s: 0, t: 2 } };
    for pass in 0..64 {
        chunk.clear();
        for i in 0..1 << 20 {
            chunk.begin_sample(0, pass << 20 | i);
            chunk.add(&one);
        }
        chunk.finish();
        film.merge(&chunk);
    }
    assert_eq!(film.sums(), [Rgb::splat((1u64 << 26) as f64)]);
    assert_eq!(film.image(1 << 26).mean(), Rgb::WHITE);
}

/// Warps at the ends of [0, 1).
#[test]
fn stress_s46_ends_of_the_unit_interval() {
    let last = 1.0f64.next_down();
    for u in [0.0, f64::MIN_POSITIVE, f64::EPSILON, 0.5, last] {
        for v in [0.0, f64::EPSILON, 0.5, last] {
            let u = DVec2::new(u, v);
            for w in [warp::square_to_sphere(u), warp::square_to_cosine_hemisphere(u)] {
                assert!((w.length() - 1.0).abs() < 1e-15, "{u} {w}");
            }
            assert!(warp::square_to_cosine_hemisphere(u).z >= 0.0);
            assert!(warp::square_to_disk(u).length() <= 1.0 + 1e-15);
        }
    }
}

#[test]
fn stress_s47_frames() {
    let check = |n: DVec3| {
        let Frame { x, y, z } = Frame::from_normal(n);
        let errors = [x.dot(y), y.dot(z), z.dot(x), x.length() - 1.0, y.length() - 1.0, x.cross(y).dot(z) - 1.0];
        assert!(errors.iter().all(|e| e.abs() < 4.0 * f64::EPSILON), "{n} {errors:?}");
    };
    for i in 0..1_000_000u32 {
        // Golden-ratio points, all the way to both poles.
        let (u, v) = ((f64::from(i) + 0.5) / 1e6, (f64::from(i) * 0.618_033_988_749_894_9).fract());
        check(warp::square_to_sphere(DVec2::new(u, v)).normalize());
    }
    for tiny in [0.0, 1e-300, 1e-160, 1e-16, 1e-8, 1e-4] {
        for sign in [1.0, -1.0] {
            check(DVec3::new(tiny, -tiny, sign).normalize());
            check(DVec3::new(1.0, tiny, sign * tiny).normalize());
        }
    }
}

/// Radiance near the smallest normal number costs no more than radiance of 1: denormals are rare, and the images are alike.
#[test]
fn stress_s51_denormals() {
    let render = |radiance: f64| {
        let world = furnace_box(DVec3::ZERO, 1.0, &lambert(0.5), radiance);
        let eye = camera(DVec3::splat(0.5), DVec3::X, 60.0);
        let mut probe = Probe::new(&world, &eye, Depth::up_to(20));
        probe.roulette = Roulette::NEVER;
        let mut time = f64::INFINITY;
        let mut mean = 0.0;
        // The least of several: other work on the machine only ever adds.
        for _ in 0..5 {
            let start = std::time::Instant::now();
            mean = probe.sample(Method::Path, 4000, 6).channels[0].mean();
            time = time.min(start.elapsed().as_secs_f64());
        }
        (mean, time)
    };
    let ((one, time), (tiny, denormal_time)) = (render(1.0), render(1e-306));
    println!("time ratio {:.3}", denormal_time / time);
    assert!((tiny / 1e-306 / one - 1.0).abs() < 1e-9, "{tiny} {one}");
}

/// A scene that is a single point to the light, and one with no surface at all.
#[test]
fn stress_s30_environment_alone() {
    let mut stage = Stage::default();
    stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
    let (world, eye) = (stage.world(), camera(DVec3::ZERO, DVec3::X, 60.0));
    for method in [Method::Emission, Method::Path, Method::Bidirectional] {
        let measured = Probe::new(&world, &eye, Depth::default()).sample(method, 10_000, 2);
        assert!(measured.non_finite == 0 && measured.agrees([1.0; 3], 1e-12), "{method:?}: {measured:?}");
    }
    assert_eq!(PathTracer::default().depth, Depth::default());
}
