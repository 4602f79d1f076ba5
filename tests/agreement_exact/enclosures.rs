//! Light from all around: furnaces, a cube with a bright ceiling, a bright sphere, a wedge under an
//! environment.

use crate::compare::{Comparison, measure};
use crate::rooms::{Room, lambert, v};
use crate::{BLACK, Team, assert_all, everybody, from_camera, narrow, path};
use glam::{DAffine3, DVec3, UVec2};
use pathspace::endpoint::{ConstantEnvironment, PinholeCamera};
use pathspace::film::Filter;
use pathspace::geometry::Sphere;
use pathspace::integrator::{Depth, LightTracer, UniformArea};
use pathspace::math::Rgb;
use pathspace::scene::{Material, Mesh, World};

fn inward_cube() -> Mesh {
    let positions =
        (0..8).map(|i| v(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect();
    // Counter-clockwise seen from inside.
    let quads =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, indices, ..Mesh::default() }
}

/// The unit cube whose walls all reflect and emit.
fn furnace(albedo: Rgb) -> World {
    let mut room = Room::default();
    let cube = room.mesh(&inward_cube(), DAffine3::IDENTITY, Material::Lambert { albedo });
    room.emit(cube, Rgb::WHITE, false);
    room.build()
}

fn inside() -> PinholeCamera {
    PinholeCamera::new(DVec3::splat(0.5), v(0.9, 0.6, 0.3), DVec3::Z, 60.0, UVec2::splat(8))
        .expect("valid camera")
}

#[test]
fn a01_closed_furnace() {
    let team = everybody(Depth::default())
        .into_iter()
        .filter(|(name, _)| *name != "uniform area")
        .collect();
    assert_all("A01", &furnace(Rgb::splat(0.5)), &inside(), &team, [2.0; 3], 0.003);
    // The variance of 1/r² in the corners is infinite: one digit less.
    let uniform: Team = vec![("uniform area", Box::new(UniformArea::up_to(1)))];
    assert_all("A01, one bounce", &furnace(Rgb::splat(0.5)), &inside(), &uniform, [1.5; 3], 0.01);
}

#[test]
fn a02_truncated_furnace() {
    let world = furnace(Rgb::splat(0.8));
    for (k, expected) in [(0, 1.0), (1, 1.8), (2, 2.44), (4, 3.3616)] {
        let team = everybody(Depth::up_to(k))
            .into_iter()
            .filter(|(name, _)| k == 0 || *name != "uniform area")
            .collect();
        assert_all(&format!("A02, k = {k}"), &world, &inside(), &team, [expected; 3], 0.003);
    }
}

/// Walks survive with their albedo, without a cap below 1.
#[test]
fn a03_bright_furnace() {
    let team: Team = vec![
        ("path", Box::new(path(Depth::default()))),
        ("light", Box::new(LightTracer::default())),
    ];
    assert_all("A03, albedo 0.98", &furnace(Rgb::splat(0.98)), &inside(), &team, [50.0; 3], 0.01);
}

#[test]
fn a04_coloured_furnace() {
    let team = everybody(Depth::default())
        .into_iter()
        .filter(|(name, _)| *name != "uniform area")
        .collect();
    assert_all(
        "A04",
        &furnace(Rgb::new(0.2, 0.5, 0.9)),
        &inside(),
        &team,
        [1.25, 2.0, 10.0],
        0.005,
    );
}

#[test]
fn a13_wedge_under_an_environment() {
    // The wedge's opening angle φ: a plane sees the other one under the form factor (1 + cos φ)/2,
    // so L = ρ (1 - cos φ)/(2 - ρ (1 + cos φ)). The row has the same numbers for the angle π - φ.
    for (degrees, expected) in [
        (60.0f64, 0.272_727_272_727_272_7),
        (90.0, 0.428_571_428_571_428_55),
        (120.0, 0.529_411_764_705_882_4),
    ] {
        let mut room = Room::default();
        let (sin, cos) = degrees.to_radians().sin_cos();
        let rho = || lambert(0.6, 0.6, 0.6);
        room.quad(v(0.0, -5e7, 0.0), v(1e8, 0.0, 0.0), v(0.0, 1e8, 0.0), rho());
        room.quad(v(0.0, -5e7, 0.0), v(0.0, 1e8, 0.0), v(1e8 * cos, 0.0, 1e8 * sin), rho());
        room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
        let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
        let camera = narrow(v(1.0 + 2.0 * cos, 0.3, 2.0 * sin), v(1.0, 0.0, 0.0));
        // Truncation of the half planes decays as their size to the power of -0.65: 6e-4 at 1e4,
        // measured.
        assert_all(
            &format!("A13, {degrees}°"),
            &room.build(),
            &camera,
            &from_camera(Depth::default()),
            [expected; 3],
            0.003,
        );
    }
}

#[test]
fn b19_cube_with_a_bright_ceiling() {
    let mut room = Room::default();
    let cube = inward_cube();
    let walls = Mesh {
        indices: cube.indices.iter().copied().filter(|t| t.iter().any(|&i| i < 4)).collect(),
        ..cube.clone()
    };
    let ceiling = Mesh {
        indices: cube.indices.iter().copied().filter(|t| t.iter().all(|&i| i >= 4)).collect(),
        ..cube
    };
    room.mesh(&walls, DAffine3::IDENTITY, lambert(0.5, 0.5, 0.5));
    let ceiling = room.mesh(&ceiling, DAffine3::IDENTITY, BLACK);
    room.emit(ceiling, Rgb::WHITE, false);
    let (world, camera) = (room.build(), narrow(v(0.7, 0.6, 0.4), v(0.5, 0.5, 0.0)));
    for (k, expected) in [(1, 0.119_728_235_230_386_77), (2, 0.034_688_115_736_270_76)] {
        let mut team = from_camera(Depth::exactly(k));
        if k == 1 {
            team.push((
                "uniform area",
                Box::new(UniformArea { depth: Depth::exactly(k), ..UniformArea::default() }),
            ));
        }
        assert_all(&format!("B19, {k} bounces"), &world, &camera, &team, [expected; 3], 0.003);
    }
}

/// Every filter's shifted copies sum to 1: no pixel is dark, neither at the border nor in the
/// corners.
#[test]
fn e05_constant_radiance() {
    let mut room = Room::default();
    let sphere = room.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, BLACK);
    room.emit(sphere, Rgb::WHITE, false);
    let world = room.build();
    let camera = PinholeCamera::new(v(0.1, 0.0, 0.2), DVec3::X, DVec3::Z, 50.0, UVec2::splat(8))
        .expect("valid camera");
    for filter in [Filter::Box, Filter::Tent, Filter::Gaussian { standard_deviation: 0.8 }] {
        for (name, integrator) in everybody(Depth::up_to(1)) {
            let comparison =
                Comparison { filter, target: 0.002, most: 20_000, ..Comparison::default() };
            let measured = measure(&world, &camera, (name, integrator.as_ref()), &comparison);
            measured.assert_mean([1.0; 3], 0.003);
            measured.assert_pixels(1.0);
        }
    }
}
