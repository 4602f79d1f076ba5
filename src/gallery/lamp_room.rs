//! The difficult case for path tracing: a room whose two lamps cannot be connected to. One is a
//! filament inside a closed glass bulb, behind a screen; the other lies in an opaque bowl and
//! reaches the room by way of the ceiling. Path tracing finds the first one by chance alone and
//! mostly misses; light tracing and bidirectional path tracing do well.
//!
//! The screen hides the glass from the camera, and nothing else is a mirror: so light tracing, too,
//! sees every path.

use super::materials::{BLACK, GLASS, diffuse, emission};
use super::shapes::{cuboid, room};
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::PinholeCamera;
use crate::geometry::{Quad, Sphere};
use crate::math::Rgb;
use crate::scene::WorldBuilder;
use glam::{DAffine3, DVec3, UVec2};

pub(super) const DESCRIPTION: &str = "A room lit by a lamp inside a glass bulb and by one \
     in an opaque bowl: the difficult case for path tracing.";

const BULB: DVec3 = DVec3::new(-0.95, 0.85, -1.5);
const BULB_RADIUS: f64 = 0.2;
const BULB_THICKNESS: f64 = 0.01;
const FILAMENT_RADIUS: f64 = 0.03;
const FILAMENT_RADIANCE: Rgb = Rgb::new(900.0, 560.0, 280.0);
const BOWL_RADIANCE: Rgb = Rgb::new(150.0, 170.0, 200.0);

pub(super) fn build(
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let black = builder.add_material("black", BLACK)?;
    let glass = builder.add_material("glass", GLASS)?;
    let plaster = builder.add_material("plaster", diffuse(Rgb::new(0.78, 0.76, 0.72)))?;
    let wood = builder.add_material("wood", diffuse(Rgb::new(0.45, 0.29, 0.17)))?;
    let blue = builder.add_material("blue", diffuse(Rgb::new(0.2, 0.3, 0.5)))?;
    let brick = builder.add_material("brick", diffuse(Rgb::new(0.55, 0.22, 0.15)))?;

    // Walls, in metres.
    let names = ["floor", "ceiling", "left wall", "right wall", "back wall", "front wall"];
    let paints = [wood, plaster, brick, plaster, plaster, plaster];
    let walls = room(p(-2.0, 0.0, -2.5), p(2.0, 2.7, 2.5));
    for ((name, paint), wall) in names.into_iter().zip(paints).zip(&walls) {
        builder.add_mesh(name, wall, DAffine3::IDENTITY, paint)?;
    }

    // Furniture: the screen in front of the glass bulb, its pedestal, a block and a ball.
    let boxes = [
        ("screen", blue, p(-1.45, 0.001, -1.05), p(-0.35, 1.4, -1.0)),
        ("pedestal", wood, p(-1.15, 0.001, -1.7), p(-0.75, 0.6, -1.3)),
        ("block", plaster, p(0.45, 0.001, -1.2), p(1.05, 0.5, -0.6)),
    ];
    for (name, material, min, max) in boxes {
        builder.add_mesh(name, &cuboid(min, max, false), DAffine3::IDENTITY, material)?;
    }
    builder.add_sphere("ball", Sphere::new(p(0.75, 0.751, -0.9), 0.25), brick)?;

    // The glass is hollow: its inner surface has the front on the side of the air, too.
    builder.add_sphere("bulb outside", Sphere::new(BULB, BULB_RADIUS), glass)?;
    let inside = Sphere { inward: true, ..Sphere::new(BULB, BULB_RADIUS - BULB_THICKNESS) };
    builder.add_sphere("bulb inside", inside, glass)?;
    let filament = builder.add_sphere("filament", Sphere::new(BULB, FILAMENT_RADIUS), black)?;
    builder.set_emission(filament, emission(FILAMENT_RADIANCE))?;

    // The bowl is open above and higher than the camera, which cannot look into it.
    let (bowl_min, bowl_max) = (p(1.6, 1.75, -1.3), p(1.95, 2.0, -0.7));
    builder.add_mesh("bowl", &cuboid(bowl_min, bowl_max, true), DAffine3::IDENTITY, plaster)?;
    let lamp = Quad { origin: p(1.7, 1.8, -1.1), edge_u: DVec3::Z * 0.2, edge_v: DVec3::X * 0.15 };
    let lamp = builder.add_quad("bowl lamp", lamp, black)?;
    builder.set_emission(lamp, emission(BOWL_RADIANCE))?;

    let camera =
        PinholeCamera::new(p(0.0, 1.35, 2.4), p(0.0, 1.15, 0.0), DVec3::Y, 62.0, resolution)?;
    Ok(GalleryScene {
        name: "lamp-room",
        description: DESCRIPTION,
        world: builder.build()?,
        camera: Box::new(camera),
        max_bounces: None,
        claims: Claims { uniform_area: false, ..Claims::ALL },
    })
}
