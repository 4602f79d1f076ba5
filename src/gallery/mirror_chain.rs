//! The bench of an optics lesson: a lamp in a box with a slit sends a sheet of light over a diffuse
//! table, which mirrors that stand on it and glass lead on. Where the light has met a mirror or
//! glass before the table, no vertex can be connected to the lamp, and the large mirror behind the
//! table shows all of it a second time: such paths have Dirac lobes at both sides of their diffuse
//! vertex. Unbiased integrators must leave the table by chance in the direction from which the chain
//! brings the light; merging finds it next to photons.

use super::materials::{BLACK, GLASS, diffuse, emission};
use super::shapes::{cuboid, prism, room};
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::PinholeCamera;
use crate::geometry::{Quad, Sphere};
use crate::math::Rgb;
use crate::scene::{Material, MaterialId, Mesh, WorldBuilder};
use glam::{DAffine3, DVec2, DVec3, UVec2};

pub(super) const DESCRIPTION: &str = "A sheet of light that mirrors and glass lead over a table, \
     seen in a mirror as well: difficult for every unbiased integrator.";

/// The way of the light over the table (x and z): from the lamp to the middle of each mirror, and
/// to the end.
const WAY: [DVec2; 5] = [
    DVec2::new(-2.3, 1.5),
    DVec2::new(1.15, 1.0),
    DVec2::new(-1.2, 0.3),
    DVec2::new(1.25, -0.5),
    DVec2::new(-1.3, -1.2),
];
/// Width and height of the mirrors.
const MIRRORS: [[f64; 2]; 3] = [[0.45, 1.6], [0.6, 1.15], [0.75, 0.8]];
/// Thickness of mirrors, and how deep they stand in the table.
const THICKNESS: f64 = 0.03;
/// Radii of glass balls at the middle of the last two legs of the way.
const BALLS: [f64; 2] = [0.28, 0.18];
const LAMP_HEIGHT: f64 = 2.2;
const LAMP_SIZE: [f64; 2] = [0.06, 0.2];
const LAMP_RADIANCE: Rgb = Rgb::new(44_000.0, 41_500.0, 37_500.0);
/// Length and width of the way out of the lamp's box, and the height of its sill: most of what
/// reaches the table has met a mirror, and what fills the room went over the first one.
const WAY_OUT: [f64; 3] = [0.6, 0.06, 1.8];

pub(super) fn build(
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let black = builder.add_material("black", BLACK)?;
    let glass = builder.add_material("glass", GLASS)?;
    let white = builder.add_material("white", diffuse(Rgb::new(0.75, 0.73, 0.7)))?;
    let slate = builder.add_material("slate", diffuse(Rgb::new(0.3, 0.33, 0.38)))?;
    let silver = Material::Mirror { reflectance: Rgb::new(0.95, 0.92, 0.86) };
    let silver = builder.add_material("silver", silver)?;
    let mut add = |name: &str, mesh: &Mesh, material: MaterialId| {
        builder.add_mesh(name, mesh, DAffine3::IDENTITY, material)
    };

    let names = ["table", "ceiling", "left wall", "right wall", "back wall", "front wall"];
    let paints = [white, slate, slate, slate, slate, slate];
    let walls = room(p(-3.0, 0.0, -2.5), p(3.0, 3.6, 5.5));
    for ((name, paint), wall) in names.into_iter().zip(paints).zip(&walls) {
        add(name, wall, paint)?;
    }
    let large = cuboid(p(-2.0, 0.1, -2.3), p(2.0, 1.7, -2.25), false);
    add("large mirror", &large, silver)?;

    // Each mirror halves the angle of the way at its place.
    for (number, (way, [width, height])) in WAY.windows(3).zip(MIRRORS).enumerate() {
        let normal = (way[0] - way[1]).normalize() + (way[2] - way[1]).normalize();
        let plate = rectangle(way[1], normal, [-THICKNESS, 0.0], [-0.5 * width, 0.5 * width]);
        add(&format!("mirror {number}"), &prism(plate, -THICKNESS, height, false), silver)?;
    }
    let slab = rectangle(
        WAY[1].midpoint(WAY[2]),
        DVec2::from_angle(55f64.to_radians()),
        [-0.1, 0.1],
        [-0.25, 0.25],
    );
    add("slab", &prism(slab, 0.001, 0.3, false), glass)?;

    // The lamp looks out between the sides of its box, over the sill.
    let ahead = WAY[1] - WAY[0];
    let [length, width, sill] = WAY_OUT;
    let parts = [
        ("left of lamp", [-0.2, -0.5 * width], 2.5),
        ("under lamp", [-0.5 * width, 0.5 * width], sill),
        ("right of lamp", [0.5 * width, 0.2], 2.5),
    ];
    for (name, across, top) in parts {
        let base = rectangle(WAY[0], ahead, [-0.1, length], across);
        add(name, &prism(base, 1.0, top, false), black)?;
    }
    for (number, (leg, radius)) in WAY[2..].windows(2).zip(BALLS).enumerate() {
        let place = leg[0].midpoint(leg[1]);
        // Just above the table: the two must not touch.
        let ball = Sphere::new(p(place.x, radius + 0.001, place.y), radius);
        builder.add_sphere(format!("ball {number}"), ball, glass)?;
    }
    let [width, height] = LAMP_SIZE;
    let across = ahead.normalize().perp() * width;
    let (edge_u, edge_v) = (p(across.x, 0.0, across.y), DVec3::Y * height);
    let center = p(WAY[0].x, LAMP_HEIGHT, WAY[0].y);
    let lamp = Quad { origin: center - 0.5 * (edge_u + edge_v), edge_u, edge_v };
    let lamp = lamp.facing(center + p(ahead.x, 0.0, ahead.y));
    let lamp = builder.add_quad("lamp", lamp, black)?;
    builder.set_emission(lamp, emission(LAMP_RADIANCE))?;

    let camera =
        PinholeCamera::new(p(-0.7, 2.8, 4.9), p(0.0, 0.25, -0.3), DVec3::Y, 38.0, resolution)?;
    Ok(GalleryScene {
        name: "mirror-chain",
        description: DESCRIPTION,
        world: builder.build()?,
        camera: Box::new(camera),
        max_bounces: None,
        claims: Claims { uniform_area: false, light_tracing: false, ..Claims::ALL },
    })
}

/// A rectangle in the plane of the table (x and z) as the base of a prism, by its extents
/// along a direction and across it from a place.
fn rectangle(place: DVec2, ahead: DVec2, along: [f64; 2], across: [f64; 2]) -> [DVec3; 4] {
    let (u, v) = (ahead.normalize(), ahead.normalize().perp());
    [(1, 0), (1, 1), (0, 1), (0, 0)].map(|(i, j)| {
        let corner = place + u * along[i] + v * across[j];
        DVec3::new(corner.x, 0.0, corner.y)
    })
}
