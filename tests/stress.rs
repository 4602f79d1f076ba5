//! The stress matrix of docs/numerics.md, S01–S57, S61, S63, S64, S75–S85: each row a test with an
//! oracle, an exact answer or the same scene without stress; `cargo run --release --example
//! stability` prints the same cases in more detail. S36 is in leave_out/adaptive.rs; S44 in
//! merging/cap.rs and analytic/furnace.rs (A12); S53 and S54 in photon_map.rs and
//! merging/limits.rs, too; S57 in merging/dirac.rs; S64 in regularization/weights.rs and lobes.rs;
//! S50 and S63 in determinism.rs and batches.rs.
//!
//! Standard errors are 0.5 % or what the case states; means must lie within 4 of them, nothing may
//! be infinite or not a number, and with the same random numbers a scene of another scale, place or
//! brightness must give the same image up to rounding.
#![allow(missing_docs, reason = "a test program")]

#[path = "../examples/stability/cases/mod.rs"]
mod cases;
#[path = "../examples/stability/measure.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod measure;
#[path = "../examples/stability/scenes.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod scenes;
#[path = "../examples/stability/variance/mod.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod variance;
#[path = "../examples/stability/verdict.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod verdict;

#[path = "stress/film.rs"]
mod film;
#[path = "stress/numbers.rs"]
mod numbers;
#[path = "stress/shared_walks.rs"]
mod shared_walks;
#[path = "stress/variance.rs"]
mod variances;
#[path = "stress/weights.rs"]
mod weights;

use measure::{Method, Probe};
use pathspace::bsdf::BsdfError;
use pathspace::endpoint::{ConstantEnvironment, EnvironmentMap};
use pathspace::geometry::{Quad, Sphere, SurfacePoint};
use pathspace::glam::{DAffine3, DVec3};
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::path::MAX_BOUNCES;
use pathspace::scene::{Material, Mesh, Scene, SceneError, WorldBuilder};
use scenes::{Stage, camera, cube, cube_mesh, footprint, furnace_sphere, lambert};
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
            assert!(
                line.verdict.is_good() && line.verdict != verdict::Verdict::Imprecise,
                "{line:?}"
            );
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
    stress_s24_refraction_of_light_walks, "S24";
    stress_s25_shading_normals, "S25";
    stress_s26_shading_normals_beyond_the_horizon, "S26";
    stress_s27_bent_normals_of_a_light, "S27";
    stress_s28_hot_pixel_of_the_sky, "S28";
    stress_s31_useless_strong_light, "S31";
    stress_s32_part_of_the_film, "S32";
    stress_s34_blocked_lens, "S34";
    stress_s37_diffuse_and_mirror, "S37";
    stress_s38_densities_forwards_and_backwards, "S38";
    stress_s40_size_of_a_light, "S40";
    stress_s41_paths_that_nobody_draws, "S41";
    stress_s42_walls_nearer_than_a_radius, "S42";
    stress_s43_grazing_photons, "S43";
    stress_s48_index_of_refraction, "S48";
    stress_s49_limits_on_bounces, "S49";
    stress_s52_plane_under_a_directional_light, "S52";
    stress_s53_radius_of_merges, "S53";
    stress_s55_thin_walls_and_veils, "S55";
    stress_s75_far_pebble, "S75";
    stress_s83_rough_interface, "S83";
    stress_s84_teapot_in_a_stadium, "S84";
    stress_s85_stadium_in_a_solar_system, "S85";
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

#[test]
fn stress_s56_scale_and_offset_of_shared_walks() {
    check_precisely("S56", 1e-9);
}

/// Walks between white walls without roulette end at nothing but the library's own limit, which is
/// reported.
#[test]
fn stress_s06_endless_walks_are_cut_off_and_counted() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(1.0), 1.0);
    let eye = camera(DVec3::ZERO, DVec3::X, 60.0);
    for method in [Method::Emission, Method::Path, Method::Light] {
        let measured = Probe::new(&world, &eye, Depth::default()).sample(method, 10, 1);
        assert_eq!(measured.truncated_subpaths, 10, "{method:?}");
        assert!(
            measured.agrees([f64::from(MAX_BOUNCES) + 1.0; 3], 0.05),
            "{method:?}: {measured:?}"
        );
    }
}

#[test]
fn stress_s07_albedo_outside_of_0_to_1() {
    for bad in [-1e-300, 1.0f64.next_up(), 2.0, f64::NAN, f64::INFINITY] {
        for channel in 0..3 {
            let mut albedo = [0.5; 3];
            albedo[channel] = bad;
            let refused =
                WorldBuilder::new().add_material("wall", Material::Lambert { albedo: Rgb(albedo) });
            let Err(SceneError::Material { name, reason }) = refused else {
                panic!("{bad} is accepted: {refused:?}")
            };
            assert!(name == "wall" && matches!(reason, BsdfError::Reflectance(_)), "{reason:?}");
        }
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
            let positions =
                (0..1000).map(|i| DVec3::new(0.0, 0.0, f64::from(i) / 1000.0)).collect();
            let indices = (0..998)
                .map(|i| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i, i, i + 1] })
                .chain([[0, 1, 0]])
                .collect();
            // One proper triangle out of sight, so that the mesh is a surface.
            let mut mesh = Mesh { positions, indices, ..Mesh::default() };
            mesh.positions.extend([
                DVec3::new(0.0, 0.0, 1.9),
                DVec3::new(0.001, 0.0, 1.9),
                DVec3::new(0.0, 0.001, 1.9),
            ]);
            mesh.indices.push([1000, 1001, 1002]);
            let id = stage.mesh(&mesh, DAffine3::IDENTITY, Material::Black);
            stage.glow(id, 1.0);
        }
        let world = stage.build();
        assert_eq!(world.dropped_triangles(), if slivers { 999 } else { 0 });
        let eye = footprint(DVec3::new(0.4, 0.4, 0.0), 0.5, 0.1);
        let probe = Probe::new(&world, &eye, Depth::exactly(1));
        probe.estimate(Method::Path, [0.11; 3], [0.001, 0.001], (RAYS, RAYS), 3)
    };
    let (without, with) = (render(false).channels[0], render(true).channels[0]);
    let error = without.standard_error().hypot(with.standard_error());
    assert!(
        (without.mean() - with.mean()).abs() < 4.0 * error && error < 0.002 * without.mean(),
        "{without:?} {with:?}"
    );
}

/// Rays at the vertices and edges of closed meshes, and one rounding step beside them: none leaves.
/// More shapes in watertight.rs.
#[test]
fn stress_s14_rays_through_edges_and_vertices() {
    let mut cube = cube_mesh();
    cube.positions.iter_mut().for_each(|p| *p = 2.0 * *p - 1.0);
    for mesh in [cube, Mesh::icosphere(3)] {
        let mut stage = Stage::default();
        stage.mesh(&mesh, DAffine3::IDENTITY, lambert(0.5));
        let world = stage.build();
        for from in [DVec3::ZERO, DVec3::new(0.3, -0.2, 0.1)] {
            let origin = SurfacePoint::dirac(from);
            for [a, b, c] in &mesh.indices {
                let [a, b, c] = [a, b, c].map(|&i| mesh.positions[i as usize]);
                for (p, q) in [(a, b), (b, c), (c, a)] {
                    for i in 0..=64 {
                        let at = p.lerp(q, f64::from(i) / 64.0) - from;
                        for aim in [
                            at,
                            DVec3::new(at.x.next_up(), at.y, at.z),
                            DVec3::new(at.x, at.y.next_down(), at.z),
                        ] {
                            assert!(
                                world.intersect(&origin, aim.normalize()).is_some(),
                                "from {from} towards {aim}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// All of the sky black but a row at a pole; then all of it.
#[test]
fn stress_s29_black_rows_and_poles() {
    for (row, cosines) in [
        (Some(0), (1.0, (PI / 8.0).cos())),
        (Some(3), ((3.0 * PI / 8.0).cos(), 0.0)),
        (None, (0.0, 0.0)),
    ] {
        let pixel = |i: u32| if Some(i / 4) == row { Rgb::WHITE } else { Rgb::BLACK };
        let mut stage = Stage::default();
        stage.square(0.0, 0.5, true, lambert(1.0));
        stage.environment(
            EnvironmentMap::new(4, 8, (0..32).map(pixel).collect(), EnvironmentMap::Z_UP)
                .expect("valid"),
        );
        let (world, eye) = (stage.build(), footprint(DVec3::ZERO, 1.0, 0.5));
        let (near, far): (f64, f64) = cosines;
        // ∫ cos dσ / π over the row
        let expected = near * near - far * far;
        for method in [Method::Emission, Method::Path, Method::Bidirectional, Method::Light] {
            let measured = Probe::new(&world, &eye, Depth::exactly(1)).estimate(
                method,
                [expected; 3],
                [0.005, 0.005],
                (RAYS, RAYS),
                4,
            );
            assert_eq!(measured.non_finite, 0);
            assert!(
                measured.agrees([expected; 3], 1e-9),
                "{row:?} {method:?} {expected}: {measured:?}"
            );
            assert!(
                measured.relative_error([expected; 3]) <= 0.02,
                "{row:?} {method:?}: {measured:?}"
            );
        }
    }
}

/// A room that the sky gets into by a window, and a pebble far away: light tracing finds what path
/// tracing does without the pebble, and with hardly more variance than without.
#[test]
fn stress_s75_room_with_a_window() {
    let render = |distance: Option<f64>, method, samples| {
        let mut stage = Stage::default();
        let [faces @ .., ceiling] = cube(DVec3::splat(-1.0), 2.0);
        for face in faces {
            stage.face(face, lambert(0.5));
        }
        // The ceiling but for a quarter of it.
        let half = Quad { edge_u: 0.5 * ceiling.edge_u, ..ceiling };
        stage.face(half, lambert(0.5));
        let quarter = Quad { origin: half.origin + half.edge_u, ..half };
        stage.face(Quad { edge_v: 0.5 * half.edge_v, ..quarter }, lambert(0.5));
        stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
        if let Some(distance) = distance {
            let at = DVec3::new(-0.48, 0.6, 0.64) * distance;
            stage.sphere(Sphere::new(at, 0.1), lambert(0.5));
        }
        let (world, eye) = (stage.build(), camera(DVec3::new(0.0, 0.0, 0.9), DVec3::ZERO, 70.0));
        let channels =
            Probe::new(&world, &eye, Depth::up_to(3)).sample(method, samples, 5).channels;
        (channels[0].mean(), channels[0].standard_error(), channels[0].variance())
    };
    let (truth, error, _) = render(None, Method::Path, 1_000_000);
    let (.., without) = render(None, Method::Light, 4_000_000);
    for distance in [1e3, 1e6] {
        let (mean, own_error, with) = render(Some(distance), Method::Light, 4_000_000);
        let error = error.hypot(own_error);
        assert!(error < 0.006 * truth, "{error} of {truth}");
        assert!((mean - truth).abs() < 4.0 * error, "{distance:e}: {mean} ± {error}, {truth}");
        // An eighth of the rays passes the pebble's disk; the variance is known to a few percent.
        println!("{distance:e}: variance {with} of {without}");
        assert!(with < 1.3 * without, "{distance:e}: {with} of {without}");
    }
}

/// A scene that is a single point to the light, and one with no surface at all.
#[test]
fn stress_s30_environment_alone() {
    let mut stage = Stage::default();
    stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
    let (world, eye) = (stage.build(), camera(DVec3::ZERO, DVec3::X, 60.0));
    for method in [Method::Emission, Method::Path, Method::Bidirectional] {
        let measured = Probe::new(&world, &eye, Depth::default()).sample(method, 10_000, 2);
        assert!(
            measured.non_finite == 0 && measured.agrees([1.0; 3], 1e-12),
            "{method:?}: {measured:?}"
        );
    }
}
