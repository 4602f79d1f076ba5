//! One light: above a floor, seen directly, and seen through interfaces.

use crate::compare::{Comparison, measure};
use crate::rooms::{Room, lambert, v};
use crate::{BLACK, assert_all, everybody, from_camera, narrow, path_mode};
use glam::{DVec2, DVec3, UVec2};
use pathspace::endpoint::PinholeCamera;
use pathspace::geometry::Sphere;
use pathspace::integrator::{Depth, PathTracing, UniformArea};
use pathspace::math::Rgb;
use pathspace::scene::{Material, World};
use std::f64::consts::{FRAC_1_PI, PI};

/// A floor of albedo 0.5 at the origin and one light above; irradiance E there.
fn above_floor(case: &str, light: impl Fn(&mut Room), irradiance: f64) {
    let mut room = Room::default();
    room.disk(DVec3::ZERO, DVec3::Z, 0.3, lambert(0.5, 0.5, 0.5));
    light(&mut room);
    let mut team = from_camera(Depth::exactly(1));
    team.push((
        "next event only",
        Box::new(path_mode(PathTracing::NextEventOnly, Depth::exactly(1))),
    ));
    team.push((
        "uniform area",
        Box::new(UniformArea { depth: Depth::exactly(1), ..UniformArea::default() }),
    ));
    assert_all(
        case,
        &room.build(),
        &narrow(v(0.3, 0.0, 0.5), DVec3::ZERO),
        &team,
        [irradiance * 0.5 * FRAC_1_PI; 3],
        0.002,
    );
}

#[test]
fn b06_square_light() {
    let light = |room: &mut Room| {
        let square = room.quad(v(-1.0, -1.0, 2.0), v(0.0, 2.0, 0.0), v(2.0, 0.0, 0.0), BLACK);
        room.emit(square, Rgb::WHITE, false);
    };
    above_floor("B06", light, 0.752_274_688_454_107_5);
}

#[test]
fn b09_sphere_light() {
    let (sin, cos) = (PI / 6.0).sin_cos();
    let light = |room: &mut Room| {
        let sphere = room.sphere(Sphere::new(v(3.0 * sin, 0.0, 3.0 * cos), 1.0), BLACK);
        room.emit(sphere, Rgb::WHITE, false);
    };
    above_floor("B09", light, 0.302_299_894_039_036_3);
}

#[test]
fn b11_disk_light() {
    let light = |room: &mut Room| {
        let disk = room.disk(v(0.0, 0.0, 2.0), -DVec3::Z, 1.0, BLACK);
        room.emit(disk, Rgb::WHITE, false);
    };
    above_floor("B11", light, 0.628_318_530_717_958_6);
}

/// All paths have one edge: s = 0 and (1, 1).
#[test]
fn e03_rectangle_seen_directly() {
    let mut room = Room::default();
    let rectangle = room.quad(v(-0.25, -0.2, 2.0), v(0.0, 0.4, 0.0), v(0.5, 0.0, 0.0), BLACK);
    room.emit(rectangle, Rgb::WHITE, false);
    let camera = PinholeCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 60.0, UVec2::splat(8))
        .expect("valid camera");
    assert_all("E03", &room.build(), &camera, &everybody(Depth::up_to(0)), [0.0375; 3], 0.002);
}

/// A wall of radiance 1 at z = 2, facing down, behind what `interfaces` adds; seen from the origin
/// along z.
fn wall_behind(interfaces: impl Fn(&mut Room)) -> (World, PinholeCamera) {
    let mut room = Room::default();
    let wall = room.quad(v(-5.0, -5.0, 2.0), v(0.0, 10.0, 0.0), v(10.0, 0.0, 0.0), BLACK);
    room.emit(wall, Rgb::WHITE, false);
    interfaces(&mut room);
    (room.build(), narrow(DVec3::ZERO, DVec3::Z))
}

fn pane(room: &mut Room, z: f64, faces_up: bool, material: Material) {
    let (x, y) = (v(6.0, 0.0, 0.0), v(0.0, 6.0, 0.0));
    let (u, w) = if faces_up { (x, y) } else { (y, x) };
    room.quad(v(-3.0, -3.0, z), u, w, material);
}

#[test]
fn c03_slab() {
    let glass = Material::Dielectric { relative_ior: 1.5 };
    let (world, camera) = wall_behind(|room| {
        pane(room, 1.0, false, glass.clone());
        pane(room, 1.1, true, glass.clone());
    });
    for (depth, expected) in [
        (Depth::up_to(2), 0.9216),
        (Depth::up_to(4), 0.923_074_56),
        (Depth::default(), 0.923_076_923_076_923_1),
    ] {
        assert_all("C03", &world, &camera, &from_camera(depth), [expected; 3], 0.001);
    }
}

#[test]
fn c08_looking_out_of_a_medium() {
    // The camera is behind the interface, in the denser medium.
    let (world, camera) =
        wall_behind(|room| pane(room, 1.0, true, Material::Dielectric { relative_ior: 1.5 }));
    assert_all("C08", &world, &camera, &from_camera(Depth::up_to(1)), [2.16; 3], 0.001);
    // Radiance falls by n² the other way: (1 - R)/n².
    let (world, camera) =
        wall_behind(|room| pane(room, 1.0, false, Material::Dielectric { relative_ior: 1.5 }));
    assert_all(
        "C08, looking in",
        &world,
        &camera,
        &from_camera(Depth::up_to(1)),
        [0.96 / 2.25; 3],
        0.001,
    );
}

#[test]
fn c13_index_matched_interface() {
    let materials = [
        Material::Null,
        Material::Dielectric { relative_ior: 1.0 },
        Material::RoughDielectric { relative_ior: 1.0, alpha: DVec2::splat(0.3) },
    ];
    for material in materials {
        let (world, camera) = wall_behind(|room| {
            pane(room, 1.0, false, material.clone());
            pane(room, 1.1, true, material.clone());
        });
        for (name, integrator) in from_camera(Depth::up_to(2)) {
            let measured = measure(
                &world,
                &camera,
                (name, integrator.as_ref()),
                &Comparison { most: 4, ..Comparison::default() },
            );
            let pixels = measured.images.iter().flat_map(|image| image.pixels());
            assert!(
                pixels.into_iter().all(|p| p.0.iter().all(|c| (c - 1.0).abs() < 1e-12)),
                "{name}, {material:?}"
            );
        }
    }
}
