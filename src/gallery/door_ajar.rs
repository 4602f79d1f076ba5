//! Two rooms and a door between them that stands ajar: the lamp is in one room, the camera in the
//! other (after Veach and Guibas 1997). Nearly all that the camera sees is lit by light that was
//! scattered by the walls of the lit room and went through the slit. A walk finds the slit by
//! chance, and then all that it scatters at behind it is worth the same: the difficult case for
//! independent samples, the easy one for those that keep what they have found.
//!
//! The slit is as large a part of the dividing wall as is asked for. The lamp is brighter by what
//! the slit is narrower, so that images are about equally bright.

use super::materials::{BLACK, diffuse, emission, metal};
use super::shapes::{cuboid, prism, quadrilaterals, room};
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::PinholeCamera;
use crate::geometry::Sphere;
use crate::math::Rgb;
use crate::scene::{MaterialId, Mesh, WorldBuilder};
use glam::{DAffine3, DVec2, DVec3, UVec2};

pub(super) const DESCRIPTION: &str = "A room lit through a door ajar by the lamp of the next one, \
     after Veach: few walks find the slit.";
pub(super) const NARROW: &str = "The same with a slit that is a ten-thousandth of the wall: \
     hardly any walk finds it.";

/// Corners of both rooms together. The camera's room is in front of the wall at z = 0.
const MIN: DVec3 = DVec3::new(-2.2, 0.0, -3.0);
const MAX: DVec3 = DVec3::new(2.2, 2.5, 4.0);
const WALL_THICKNESS: f64 = 0.1;
/// The doorway along x, and its height.
const DOORWAY: [f64; 2] = [-1.5, -0.6];
const DOOR_HEIGHT: f64 = 2.05;
const LEAF_THICKNESS: f64 = 0.04;
/// Surfaces cross each other by as much where they must be tight.
const OVERLAP: f64 = 0.01;
const LAMP: DVec3 = DVec3::new(1.2, 1.8, -1.6);
const LAMP_RADIUS: f64 = 0.12;
/// Radiance times the part of the wall that the slit is.
const LAMP_RADIANCE: Rgb = Rgb::new(320.0, 265.0, 205.0);

pub(super) fn wide(resolution: UVec2, builder: WorldBuilder) -> Result<GalleryScene, GalleryError> {
    build("door-ajar", DESCRIPTION, 1e-2, resolution, builder)
}

pub(super) fn narrow(
    resolution: UVec2,
    builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    build("door-ajar-narrow", NARROW, 1e-4, resolution, builder)
}

/// The rooms with a slit that is the part `opening` of the dividing wall.
fn build(
    name: &'static str,
    description: &'static str,
    opening: f64,
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let black = builder.add_material("black", BLACK)?;
    let plaster = builder.add_material("plaster", diffuse(Rgb::new(0.78, 0.76, 0.72)))?;
    let floor = builder.add_material("floor", diffuse(Rgb::new(0.5, 0.38, 0.27)))?;
    let wood = builder.add_material("wood", diffuse(Rgb::new(0.45, 0.27, 0.15)))?;
    let oak = builder.add_material("oak", diffuse(Rgb::new(0.62, 0.47, 0.32)))?;
    let white = builder.add_material("white", diffuse(Rgb::splat(0.85)))?;
    let blue = builder.add_material("blue", diffuse(Rgb::new(0.15, 0.27, 0.5)))?;
    let red = builder.add_material("red", diffuse(Rgb::new(0.6, 0.15, 0.1)))?;
    let green = builder.add_material("green", diffuse(Rgb::new(0.2, 0.4, 0.2)))?;
    let steel = builder.add_material("steel", metal(Rgb::new(0.8, 0.8, 0.82), 0.15))?;
    let mut add = |name: &str, mesh: &Mesh, material: MaterialId| {
        builder.add_mesh(name, mesh, DAffine3::IDENTITY, material)
    };

    let names = ["floor", "ceiling", "left wall", "right wall", "back wall", "front wall"];
    let paints = [floor, plaster, plaster, blue, plaster, plaster];
    for ((name, paint), wall) in names.into_iter().zip(paints).zip(&room(MIN, MAX)) {
        add(name, wall, paint)?;
    }
    add("dividing wall", &dividing_wall(), plaster)?;
    add("door", &leaf(opening), oak)?;

    // A table with three things on it, a stool, a chest and a picture.
    let boxes = [
        ("table top", wood, p(0.2, 0.7, 1.0), p(1.7, 0.74, 1.8)),
        ("block", red, p(0.35, 0.741, 1.1), p(0.55, 1.04, 1.3)),
        ("stool", green, p(-0.55, 0.001, 1.5), p(-0.15, 0.42, 1.9)),
        ("chest", white, p(1.2, 0.001, 0.1), p(2.1, 0.55, 0.5)),
        ("picture", blue, p(0.6, 1.3, 0.001), p(1.5, 1.9, 0.03)),
    ];
    for (name, material, min, max) in boxes {
        add(name, &cuboid(min, max, false), material)?;
    }
    for (number, (x, z)) in
        [(0.25, 1.05), (0.25, 1.69), (1.59, 1.05), (1.59, 1.69)].iter().enumerate()
    {
        let leg = cuboid(p(*x, 0.001, *z), p(x + 0.06, 0.699, z + 0.06), false);
        add(&format!("table leg {number}"), &leg, wood)?;
    }
    let balls = [
        ("glossy ball", steel, p(0.95, 0.961, 1.35), 0.22),
        ("small ball", white, p(1.4, 0.871, 1.5), 0.13),
    ];
    for (name, material, center, radius) in balls {
        builder.add_sphere(name, Sphere::new(center, radius), material)?;
    }
    let lamp = builder.add_sphere("lamp", Sphere::new(LAMP, LAMP_RADIUS), black)?;
    builder.set_emission(lamp, emission(LAMP_RADIANCE / opening))?;

    let camera =
        PinholeCamera::new(p(-0.1, 1.5, 3.9), p(0.15, 0.95, 0.0), DVec3::Y, 52.0, resolution)?;
    Ok(GalleryScene {
        name,
        description,
        world: builder.build()?,
        camera: Box::new(camera),
        max_bounces: None,
        claims: Claims::ALL,
    })
}

/// The wall with the doorway: both faces, which reach beyond the rooms, and the inside of the
/// doorway. They share their vertices, so that nothing leaks.
fn dividing_wall() -> Mesh {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let xs = [MIN.x - OVERLAP, DOORWAY[0], DOORWAY[1], MAX.x + OVERLAP];
    let ys = [MIN.y - OVERLAP, DOOR_HEIGHT, MAX.y + OVERLAP];
    let (near, far) = (0.0, -WALL_THICKNESS);
    let cells = [(0, 0), (0, 1), (1, 1), (2, 0), (2, 1)];
    let faces = cells.into_iter().flat_map(|(i, j)| {
        let ([a, c], [b, d]) = ([xs[i], xs[i + 1]], [ys[j], ys[j + 1]]);
        [
            [p(a, b, near), p(c, b, near), p(c, d, near), p(a, d, near)],
            [p(c, b, far), p(a, b, far), p(a, d, far), p(c, d, far)],
        ]
    });
    let ([_, left, right, _], [bottom, top, _]) = (xs, ys);
    let inside = [
        [p(left, bottom, near), p(left, bottom, far), p(left, top, far), p(left, top, near)],
        [p(right, bottom, far), p(right, bottom, near), p(right, top, near), p(right, top, far)],
        [p(left, top, near), p(left, top, far), p(right, top, far), p(right, top, near)],
    ];
    quadrilaterals(faces.chain(inside))
}

/// The door, which opens into the camera's room. Its hinge lies in front of the wall, which it
/// enters behind the hinge.
fn leaf(opening: f64) -> Mesh {
    let hinge = DVec2::new(DOORWAY[0] - OVERLAP, 0.0);
    let width = DOORWAY[1] - hinge.x;
    // The slit is upright between the edges of leaf and doorway, and a triangle above the leaf.
    let area = opening * (MAX.x - MIN.x) * (MAX.y - MIN.y);
    let gap = area / (DOOR_HEIGHT + 0.5 * width);
    let (sin, cos) = libm::sincos(2.0 * libm::asin(0.5 * gap / width));
    let along = DVec2::new(cos, sin);
    let corner = |length: f64, thickness: f64| {
        let place = hinge + along * length + along.perp() * thickness;
        DVec3::new(place.x, 0.0, place.y)
    };
    let base = [
        corner(-OVERLAP, LEAF_THICKNESS),
        corner(width, LEAF_THICKNESS),
        corner(width, 0.0),
        corner(-OVERLAP, 0.0),
    ];
    prism(base, MIN.y - OVERLAP, DOOR_HEIGHT, false)
}
