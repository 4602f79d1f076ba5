//! Two coarse meshes with smooth normals, a diffuse torus and a bumpy metal blob, under a
//! procedural sky with a bright sun. Shading normals that differ from the geometric ones make
//! scattering asymmetric between light and camera walks, and the light is at infinity: integrators
//! agree only if both are accounted for.

use super::materials::{diffuse, metal};
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::{EndpointError, EnvironmentMap, Lookup, PinholeCamera};
use crate::geometry::{Disk, Triangle};
use crate::math::Rgb;
use crate::scene::{Mesh, WorldBuilder};
use glam::{DAffine3, DMat3, DVec3, UVec2};
use std::f64::consts::{PI, TAU};

pub(super) const DESCRIPTION: &str =
    "Coarse meshes with smooth normals, diffuse and metal, under a sky with a sun.";

const SUN: DVec3 = DVec3::new(-0.55, 0.6, 0.58);
const SUN_RADIANCE: Rgb = Rgb::new(160.0, 140.0, 110.0);
/// Angular radius, far above the true 0.27°, so that a map of 128 × 64 pixels resolves it.
const SUN_DEGREES: f64 = 5.0;

pub(super) fn build(
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let ground = builder.add_material("ground", diffuse(Rgb::new(0.42, 0.4, 0.36)))?;
    let clay = builder.add_material("clay", diffuse(Rgb::new(0.7, 0.32, 0.2)))?;
    let gold = builder.add_material("gold", metal(Rgb::new(0.95, 0.72, 0.35), 0.25))?;

    builder.add_disk(
        "ground",
        Disk { center: DVec3::ZERO, normal: DVec3::Y, radius: 7.0 },
        ground,
    )?;
    // Both float a little, so that nothing intersects.
    builder.add_mesh(
        "torus",
        &torus(1.6, 0.5, 28, 12),
        DAffine3::from_translation(DVec3::Y * 0.52),
        clay,
    )?;
    builder.add_mesh("blob", &blob(24, 14), DAffine3::from_translation(DVec3::Y * 1.05), gold)?;
    builder.set_environment("sky", sky()?)?;

    let camera = PinholeCamera::new(
        DVec3::new(0.0, 2.5, 6.6),
        DVec3::new(0.0, 0.9, 0.0),
        DVec3::Y,
        40.0,
        resolution,
    )?;
    Ok(GalleryScene {
        name: "smooth-mesh",
        description: DESCRIPTION,
        world: builder.build()?,
        camera: Box::new(camera),
        max_bounces: None,
        claims: Claims { uniform_area: false, ..Claims::ALL },
    })
}

/// A torus around the y axis with its exact normals.
fn torus(major: f64, minor: f64, around: u32, across: u32) -> Mesh {
    let mut mesh = Mesh { normals: Some(Vec::new()), ..Mesh::default() };
    for i in 0..around {
        let (sin, cos) = libm::sincos(TAU * f64::from(i) / f64::from(around));
        let outwards = DVec3::new(cos, 0.0, -sin);
        for j in 0..across {
            let (sin, cos) = libm::sincos(TAU * f64::from(j) / f64::from(across));
            let normal = outwards * cos + DVec3::Y * sin;
            mesh.positions.push(outwards * major + normal * minor);
            mesh.normals.get_or_insert_default().push(normal);
            let (next_i, next_j) = ((i + 1) % around, (j + 1) % across);
            let corners = [
                i * across + j,
                next_i * across + j,
                next_i * across + next_j,
                i * across + next_j,
            ];
            mesh.indices.extend([
                [corners[0], corners[1], corners[2]],
                [corners[0], corners[2], corners[3]],
            ]);
        }
    }
    mesh
}

/// A sphere with bumps; each vertex has the mean normal of the triangles around it, weighted by
/// area.
fn blob(around: u32, rows: u32) -> Mesh {
    let point = |polar: f64, turn: f64| {
        let (sin, cos) = libm::sincos(polar);
        let bumps = 0.14 * sin * sin * libm::cos(5.0 * turn) * libm::sin(4.0 * polar)
            + 0.08 * libm::cos(3.0 * polar);
        DVec3::new(sin * libm::cos(turn), cos, -sin * libm::sin(turn)) * (0.85 + bumps)
    };
    let mut mesh = Mesh { positions: vec![point(0.0, 0.0), point(PI, 0.0)], ..Mesh::default() };
    let vertex = |row: u32, column: u32| match row {
        0 => 0,
        row if row == rows => 1,
        row => 2 + (row - 1) * around + column % around,
    };
    for row in 0..rows {
        for column in 0..around {
            if row > 0 {
                mesh.positions.push(point(
                    PI * f64::from(row) / f64::from(rows),
                    TAU * f64::from(column) / f64::from(around),
                ));
            }
            let [upper, lower] =
                [row, row + 1].map(|row| [vertex(row, column), vertex(row, column + 1)]);
            if row + 1 < rows {
                mesh.indices.push([upper[0], lower[0], lower[1]]);
            }
            if row > 0 {
                mesh.indices.push([upper[0], lower[1], upper[1]]);
            }
        }
    }
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.indices {
        let normal = Triangle { vertices: triangle.map(|i| mesh.positions[i as usize]) }.cross();
        for &vertex in triangle {
            normals[vertex as usize] += normal;
        }
    }
    mesh.normals = Some(normals);
    mesh
}

/// A sky that is brighter near the horizon, dark ground below it, and a sun.
fn sky() -> Result<EnvironmentMap, EndpointError> {
    let (width, height) = (128, 64);
    let sun = SUN.normalize();
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column))).map(
        |(row, column)| {
            let polar = PI * (f64::from(row) + 0.5) / f64::from(height);
            // The left edge is at -Z, a quarter to the right +X.
            let turn = TAU * (f64::from(column) + 0.5) / f64::from(width);
            let direction = DVec3::new(
                libm::sin(polar) * libm::sin(turn),
                libm::cos(polar),
                -libm::sin(polar) * libm::cos(turn),
            );
            let horizon = (1.0 - direction.y.abs()).powi(4);
            let air =
                Rgb::new(0.18, 0.32, 0.6) * (1.0 - horizon) + Rgb::new(0.75, 0.8, 0.85) * horizon;
            let dust = Rgb::new(0.3, 0.28, 0.25);
            let disk = direction.dot(sun) > libm::cos(SUN_DEGREES.to_radians());
            (if direction.y > 0.0 { air } else { dust })
                + if disk { SUN_RADIANCE } else { Rgb::BLACK }
        },
    );
    Ok(EnvironmentMap::new(width, height, pixels.collect(), DMat3::IDENTITY)?
        .with_lookup(Lookup::Bilinear))
}
