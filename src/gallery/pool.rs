//! A basin of water under a small lamp, seen from above: a web of caustics on its floor. Light
//! reaches what is in the water, and the camera sees it, through the surface alone, which is
//! smooth. Neither end of such a path can be connected to, and what is left to unbiased integrators
//! is to leave the floor by chance in the direction that the water bends to the lamp.

use super::materials::{BLACK, diffuse, emission};
use super::shapes::room;
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::PinholeCamera;
use crate::geometry::Sphere;
use crate::material::Texture;
use crate::math::Rgb;
use crate::scene::{Material, Mesh, WorldBuilder};
use glam::{DAffine3, DVec2, DVec3, UVec2};

pub(super) const DESCRIPTION: &str = "Water over a tiled floor, under a small lamp: caustics seen \
     through what makes them, difficult for every unbiased integrator.";

const WATER: Material = Material::Dielectric { relative_ior: 1.33 };
const DEPTH: f64 = 1.0;
/// Number of tiles along a side of the floor.
const TILES: f64 = 10.0;
/// Height of the deck above the water.
const RIM: f64 = 0.12;
/// Wave vectors along x and z, amplitude and phase: slopes of up to 1/2, and crests that focus
/// light at about the depth of the floor.
const WAVES: [(DVec2, f64, f64); 4] = [
    (DVec2::new(12.0, 4.0), 0.011, 0.4),
    (DVec2::new(2.0, 14.0), 0.01, 2.1),
    (DVec2::new(-12.0, 11.0), 0.007, 4.0),
    (DVec2::new(17.0, 14.0), 0.004, 5.3),
];
const LAMP: DVec3 = DVec3::new(-0.8, 2.0, 1.45);
const LAMP_RADIUS: f64 = 0.05;
const LAMP_RADIANCE: Rgb = Rgb::new(3600.0, 3300.0, 2700.0);

pub(super) fn build(
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let black = builder.add_material("black", BLACK)?;
    let water = builder.add_material("water", WATER)?;
    let tiles = Texture::checkerboard(Rgb::new(0.35, 0.55, 0.6), Rgb::new(0.18, 0.42, 0.52));
    let tiles = builder.add_material("tiles", diffuse(Rgb::WHITE).tinted(tiles))?;
    let plaster = builder.add_material("plaster", diffuse(Rgb::new(0.5, 0.58, 0.6)))?;
    let stone = builder.add_material("stone", diffuse(Rgb::new(0.13, 0.12, 0.1)))?;
    let red = builder.add_material("red", diffuse(Rgb::new(0.6, 0.12, 0.08)))?;

    let [floor, _, walls @ ..] = room(p(-1.0, -DEPTH, -1.0), p(1.0, RIM, 1.0));
    // The board repeats after two tiles.
    let uvs = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|uv| 0.5 * TILES * uv);
    builder.add_mesh(
        "floor",
        &Mesh { uvs: Some(uvs.to_vec()), ..floor },
        DAffine3::IDENTITY,
        tiles,
    )?;
    for (name, wall) in ["left wall", "right wall", "back wall", "front wall"].iter().zip(&walls) {
        builder.add_mesh(*name, wall, DAffine3::IDENTITY, plaster)?;
    }
    builder.add_mesh("deck", &deck(), DAffine3::IDENTITY, stone)?;
    builder.add_mesh("water", &waves(1.05, 84), DAffine3::IDENTITY, water)?;
    builder.add_sphere("ball", Sphere::new(p(0.4, 0.05, -0.4), 0.16), red)?;
    let lamp = builder.add_sphere("lamp", Sphere::new(LAMP, LAMP_RADIUS), black)?;
    builder.set_emission(lamp, emission(LAMP_RADIANCE))?;

    let camera =
        PinholeCamera::new(p(0.0, 3.2, 1.7), p(0.0, -0.3, -0.02), DVec3::Y, 32.0, resolution)?;
    Ok(GalleryScene {
        name: "pool",
        description: DESCRIPTION,
        world: builder.build()?,
        camera: Box::new(camera),
        max_bounces: None,
        claims: Claims { uniform_area: false, light_tracing: false, ..Claims::ALL },
    })
}

/// The surroundings of the basin, at the height of its rim and with the corners of its walls.
fn deck() -> Mesh {
    let ring = |half: f64| {
        [(-half, half), (half, half), (half, -half), (-half, -half)]
            .map(|(x, z)| DVec3::new(x, RIM, z))
    };
    let indices = (0..4u32).flat_map(|i| {
        let next = (i + 1) % 4;
        [[i, i + 4, next + 4], [i, next + 4, next]]
    });
    Mesh {
        positions: [ring(1.0), ring(3.0)].concat(),
        indices: indices.collect(),
        ..Mesh::default()
    }
}

/// The surface of the water over a square of 2 `half`, with the exact normals of the waves. It ends
/// behind the walls, which cut it off under the deck.
fn waves(half: f64, cells: u32) -> Mesh {
    let mut mesh = Mesh { normals: Some(Vec::new()), ..Mesh::default() };
    let at = |i: u32| half * (2.0 * f64::from(i) / f64::from(cells) - 1.0);
    for (row, column) in (0..=cells).flat_map(|row| (0..=cells).map(move |column| (row, column))) {
        let place = DVec2::new(at(column), at(row));
        let (mut height, mut slope) = (0.0, DVec2::ZERO);
        for (wave, amplitude, phase) in WAVES {
            let (sin, cos) = libm::sincos(wave.dot(place) + phase);
            height += amplitude * sin;
            slope += wave * (amplitude * cos);
        }
        mesh.positions.push(DVec3::new(place.x, height, place.y));
        mesh.normals.get_or_insert_default().push(DVec3::new(-slope.x, 1.0, -slope.y));
        if row < cells && column < cells {
            let (here, below) = (row * (cells + 1) + column, (row + 1) * (cells + 1) + column);
            mesh.indices.extend([[here, below, below + 1], [here, below + 1, here + 1]]);
        }
    }
    mesh
}
