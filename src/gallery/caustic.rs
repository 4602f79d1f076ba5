//! A glass ball under a small lamp focuses light on a diffuse floor. Path tracing must hit the lamp
//! by chance behind the glass, which it can, since the lamp has an area, but rarely does. Light
//! tracing draws the caustic at once and does not see the ball.

use super::materials::{BLACK, GLASS, diffuse, emission};
use super::shapes::quadrilateral;
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::PinholeCamera;
use crate::geometry::Sphere;
use crate::math::Rgb;
use crate::scene::WorldBuilder;
use glam::{DAffine3, DVec3, UVec2};

pub(super) const DESCRIPTION: &str =
    "A glass ball under a small lamp: a caustic on a diffuse floor, seen through the ball as well.";

const LAMP: DVec3 = DVec3::new(-2.6, 4.6, -1.0);
const LAMP_RADIUS: f64 = 0.2;
const LAMP_RADIANCE: Rgb = Rgb::new(420.0, 390.0, 340.0);

pub(super) fn build(
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let black = builder.add_material("black", BLACK)?;
    let glass = builder.add_material("glass", GLASS)?;
    let floor = builder.add_material("floor", diffuse(Rgb::new(0.6, 0.58, 0.55)))?;
    let wall = builder.add_material("wall", diffuse(Rgb::new(0.3, 0.4, 0.5)))?;

    let ground =
        quadrilateral([p(-8.0, 0.0, 8.0), p(8.0, 0.0, 8.0), p(8.0, 0.0, -3.5), p(-8.0, 0.0, -3.5)]);
    builder.add_mesh("floor", &ground, DAffine3::IDENTITY, floor)?;
    let back = quadrilateral([
        p(-8.0, 0.0, -3.5),
        p(8.0, 0.0, -3.5),
        p(8.0, 7.0, -3.5),
        p(-8.0, 7.0, -3.5),
    ]);
    builder.add_mesh("back wall", &back, DAffine3::IDENTITY, wall)?;
    // Just above the floor: the two must not touch.
    builder.add_sphere("ball", Sphere::new(p(0.0, 1.01, 0.0), 1.0), glass)?;
    let lamp = builder.add_sphere("lamp", Sphere::new(LAMP, LAMP_RADIUS), black)?;
    builder.set_emission(lamp, emission(LAMP_RADIANCE))?;

    let camera =
        PinholeCamera::new(p(1.2, 3.2, 6.5), p(0.5, 0.6, 0.0), DVec3::Y, 36.0, resolution)?;
    Ok(GalleryScene {
        name: "caustic",
        description: DESCRIPTION,
        world: builder.build()?,
        camera: Box::new(camera),
        max_bounces: None,
        claims: Claims { uniform_area: false, light_tracing: false, ..Claims::ALL },
    })
}
