//! Surfaces of revolution as triangles with exact normals and Mitsuba's texture coordinates.
//!
//! All vertices lie on the surface. Triangles lie inside of it by at most 1 - cos(π/256) = 7.6e-5
//! of the radius around the axis, and by 3.1e-4 of it along the meridians of a sphere.

use crate::geometry::{Disk, Sphere};
use crate::scene::Mesh;
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Parts of a full turn.
const SEGMENTS: u32 = 256;
/// Parts of a meridian.
const RINGS: u32 = 64;
/// Most triangles of a surface.
pub(super) const MOST_TRIANGLES: usize = (2 * SEGMENTS * RINGS) as usize;

/// A cylinder without its ends; u goes around it and v along its axis.
pub(super) fn cylinder(from: DVec3, axis: DVec3, radius: f64) -> Mesh {
    let (x, y) = axis.normalize().any_orthonormal_pair();
    let matrix3 = DMat3::from_cols(x * radius, y * radius, axis);
    let ring = |z: f64| (DVec2::new(1.0, z), DVec2::X);
    transformed(revolved(&[ring(0.0), ring(1.0)]), DAffine3 { matrix3, translation: from })
}

/// A disk; u goes from its centre to its rim and v around it.
pub(super) fn disk(disk: &Disk) -> Mesh {
    let (x, y) = disk.normal.any_orthonormal_pair();
    let matrix3 = DMat3::from_cols(x, y, disk.normal) * disk.radius;
    let ring = |r: f64| (DVec2::new(r, 0.0), DVec2::Y);
    let mut mesh = revolved(&[ring(1.0), ring(0.0)]);
    mesh.uvs.iter_mut().flatten().for_each(|uv| *uv = DVec2::new(1.0 - uv.y, uv.x));
    transformed(mesh, DAffine3 { matrix3, translation: disk.center })
}

/// A whole sphere; u goes around its axis and v from its pole to the other one.
pub(super) fn sphere(sphere: &Sphere) -> Mesh {
    let (x, y) = sphere.axis.any_orthonormal_pair();
    let matrix3 = DMat3::from_cols(x, y, sphere.axis) * sphere.radius;
    let profile: Vec<(DVec2, DVec2)> = (0..=RINGS)
        .map(|k| {
            let (sin, cos) = libm::sincos(PI * f64::from(k) / f64::from(RINGS));
            let point = DVec2::new(if k % RINGS == 0 { 0.0 } else { sin }, cos);
            (point, point)
        })
        .collect();
    let mut mesh = revolved(&profile);
    if sphere.inward {
        mesh.normals.iter_mut().flatten().for_each(|normal| *normal = -*normal);
    } else {
        mesh.indices.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    transformed(mesh, DAffine3 { matrix3, translation: sphere.center })
}

/// The surface that a profile sweeps around z: distances from the axis with heights, and normals
/// with the same two components. The front is on the right of the profile.
fn revolved(profile: &[(DVec2, DVec2)]) -> Mesh {
    let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    for (k, (point, normal)) in profile.iter().enumerate() {
        for j in 0..=SEGMENTS {
            let (sin, cos) = libm::sincos(TAU * f64::from(j % SEGMENTS) / f64::from(SEGMENTS));
            let swept = |p: &DVec2| DVec3::new(p.x * cos, p.x * sin, p.y);
            positions.push(swept(point));
            normals.push(swept(normal));
            let along = k as f64 / (profile.len() - 1) as f64;
            uvs.push(DVec2::new(f64::from(j) / f64::from(SEGMENTS), along));
        }
    }
    let mut indices = Vec::new();
    for (k, ends) in (0..).zip(profile.windows(2)) {
        for j in 0..SEGMENTS {
            let a = k * (SEGMENTS + 1) + j;
            let (b, c, d) = (a + 1, a + SEGMENTS + 2, a + SEGMENTS + 1);
            // At a pole one of the two has no area.
            indices.extend((ends[0].0.x > 0.0).then_some([a, b, c]));
            indices.extend((ends[1].0.x > 0.0).then_some([a, c, d]));
        }
    }
    Mesh { positions, normals: Some(normals), uvs: Some(uvs), indices, ..Mesh::default() }
}

/// The image under a rotation with a scale along and one across the axis.
fn transformed(mut mesh: Mesh, transform: DAffine3) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p = transform.transform_point3(*p));
    mesh.normals.iter_mut().flatten().for_each(|n| *n = transform.transform_vector3(*n));
    mesh
}
