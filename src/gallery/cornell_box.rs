//! The Cornell box from its published measurements (Cornell University Program of Computer
//! Graphics, "Cornell Box Data", 1998; room and blocks in mm, the slightly irregular walls
//! included, camera of 35 mm focal length behind a film of 25 mm). Diffuse surfaces of every
//! orientation and one area light: what every integrator sees and renders well.
//!
//! The data's spectra are replaced by linear RGB: reflectances and emission are those with which
//! Mitsuba 3 describes its Cornell box (white, red and green walls, white blocks), so that images
//! can be compared. The lamp hangs 0.5 mm below the ceiling, in which the data has a hole, and
//! reflects nothing.

use super::materials::{BLACK, diffuse, emission};
use super::shapes::{prism, quadrilateral};
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::PinholeCamera;
use crate::geometry::Quad;
use crate::math::Rgb;
use crate::scene::WorldBuilder;
use glam::{DAffine3, DVec3, UVec2};

pub(super) const DESCRIPTION: &str = "The Cornell box from its published measurements: \
     diffuse, one area light, seen by every integrator.";

const WHITE: Rgb = Rgb::new(0.885809, 0.698859, 0.666422);
const RED: Rgb = Rgb::new(0.570068, 0.0430135, 0.0443706);
const GREEN: Rgb = Rgb::new(0.105421, 0.37798, 0.076425);
const RADIANCE: Rgb = Rgb::new(18.387, 13.9873, 6.75357);
const LAMP_HEIGHT: f64 = 548.3;

pub(super) fn build(
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let black = builder.add_material("black", BLACK)?;
    let white = builder.add_material("white", diffuse(WHITE))?;
    let red = builder.add_material("red", diffuse(RED))?;
    let green = builder.add_material("green", diffuse(GREEN))?;

    let walls = [
        (
            "floor",
            white,
            [p(552.8, 0.0, 0.0), p(0.0, 0.0, 0.0), p(0.0, 0.0, 559.2), p(549.6, 0.0, 559.2)],
        ),
        (
            "ceiling",
            white,
            [
                p(556.0, 548.8, 0.0),
                p(556.0, 548.8, 559.2),
                p(0.0, 548.8, 559.2),
                p(0.0, 548.8, 0.0),
            ],
        ),
        (
            "back wall",
            white,
            [
                p(549.6, 0.0, 559.2),
                p(0.0, 0.0, 559.2),
                p(0.0, 548.8, 559.2),
                p(556.0, 548.8, 559.2),
            ],
        ),
        (
            "right wall",
            green,
            [p(0.0, 0.0, 559.2), p(0.0, 0.0, 0.0), p(0.0, 548.8, 0.0), p(0.0, 548.8, 559.2)],
        ),
        (
            "left wall",
            red,
            [
                p(552.8, 0.0, 0.0),
                p(549.6, 0.0, 559.2),
                p(556.0, 548.8, 559.2),
                p(556.0, 548.8, 0.0),
            ],
        ),
    ];
    for (name, material, corners) in walls {
        builder.add_mesh(name, &quadrilateral(corners), DAffine3::IDENTITY, material)?;
    }

    let corner = |x: f64, z: f64| p(x, 0.0, z);
    let blocks = [
        (
            "short block",
            165.0,
            [corner(130.0, 65.0), corner(82.0, 225.0), corner(240.0, 272.0), corner(290.0, 114.0)],
        ),
        (
            "tall block",
            330.0,
            [
                corner(423.0, 247.0),
                corner(265.0, 296.0),
                corner(314.0, 456.0),
                corner(472.0, 406.0),
            ],
        ),
    ];
    for (name, height, base) in blocks {
        // Without a bottom, which would lie in the floor.
        let mut block = prism(base, 0.0, height, false);
        block.indices.drain(..2);
        builder.add_mesh(name, &block, DAffine3::IDENTITY, white)?;
    }

    let lamp = Quad {
        origin: p(343.0, LAMP_HEIGHT, 227.0),
        edge_u: DVec3::Z * 105.0,
        edge_v: DVec3::X * -130.0,
    };
    let lamp = builder.add_quad("lamp", lamp, black)?;
    builder.set_emission(lamp, emission(RADIANCE))?;

    let fov = 2.0 * libm::atan(0.025f64 / (2.0 * 0.035)).to_degrees();
    let camera = PinholeCamera::new(
        p(278.0, 273.0, -800.0),
        p(278.0, 273.0, 0.0),
        DVec3::Y,
        fov,
        resolution,
    )?;
    Ok(GalleryScene {
        name: "cornell-box",
        description: DESCRIPTION,
        world: builder.build()?,
        camera: Box::new(camera),
        max_bounces: None,
        claims: Claims::ALL,
    })
}
