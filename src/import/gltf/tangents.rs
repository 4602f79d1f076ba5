//! Tangents for normal maps, where a mesh has none: those of MikkTSpace, in which maps are baked.

use crate::scene::Mesh;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DAffine2, DVec2, DVec3, DVec4};
use std::collections::HashMap;

/// The mesh with tangents for textures that are looked up at `to_uv` of its texture coordinates, or
/// of the `other` ones. Vertices whose triangles disagree become several.
pub(super) fn with_tangents(mesh: Mesh, other: bool, to_uv: DAffine2) -> Mesh {
    let uvs = if other { &mesh.other_uvs } else { &mesh.uvs };
    let count = mesh.positions.len();
    let fits = |corners: &[u32; 3]| corners.iter().all(|&i| (i as usize) < count);
    let are_complete = [
        mesh.normals.as_ref().map(Vec::len),
        mesh.uvs.as_ref().map(Vec::len),
        mesh.other_uvs.as_ref().map(Vec::len),
    ]
    .into_iter()
    .flatten()
    .all(|n| n == count);
    if !(mesh.indices.iter().all(fits) && are_complete) {
        // It will be refused.
        return mesh;
    }
    let scale = mesh.positions.iter().fold(0.0f64, |scale, p| scale.max(p.abs().max_element()));
    let mut corners = Corners {
        mesh: &mesh,
        uvs: uvs.as_deref(),
        to_uv,
        scale: if scale > 0.0 { 1.0 / scale } else { 1.0 },
        tangents: vec![[DVec4::ZERO; 3]; mesh.indices.len()],
    };
    // There are no errors.
    if generate_tangents(&mut corners).is_err() {
        return mesh;
    }
    let tangents = corners.tangents;
    split(mesh, &tangents)
}

/// A mesh with a vertex for each pair of a vertex and a tangent.
fn split(mesh: Mesh, tangents: &[[DVec4; 3]]) -> Mesh {
    let mut vertices = HashMap::new();
    let mut sources = Vec::new();
    let mut of_vertices = Vec::new();
    let mut vertex = |source: u32, tangent: DVec4| {
        *vertices.entry((source, tangent.to_array().map(f64::to_bits))).or_insert_with(|| {
            sources.push(source as usize);
            of_vertices.push(tangent);
            of_vertices.len() as u32 - 1
        })
    };
    let corners = mesh.indices.iter().zip(tangents);
    let indices = corners
        .map(|(&[a, b, c], &[s, t, u])| [vertex(a, s), vertex(b, t), vertex(c, u)])
        .collect();
    Mesh {
        positions: sources.iter().map(|&i| mesh.positions[i]).collect(),
        normals: mesh.normals.map(|normals| sources.iter().map(|&i| normals[i]).collect()),
        uvs: mesh.uvs.map(|uvs| sources.iter().map(|&i| uvs[i]).collect()),
        other_uvs: mesh.other_uvs.map(|uvs| sources.iter().map(|&i| uvs[i]).collect()),
        colors: mesh.colors.map(|colors| sources.iter().map(|&i| colors[i]).collect()),
        tangents: Some(of_vertices),
        indices,
    }
}

/// The corners of triangles, with what is found out about them.
struct Corners<'a> {
    mesh: &'a Mesh,
    uvs: Option<&'a [DVec2]>,
    to_uv: DAffine2,
    /// Brings positions into the range of f32.
    scale: f64,
    tangents: Vec<[DVec4; 3]>,
}

impl Corners<'_> {
    fn index(&self, face: usize, corner: usize) -> usize {
        self.mesh.indices[face][corner] as usize
    }
}

/// Zero in place of what f32 does not hold.
fn single<const N: usize>(vector: [f64; N]) -> [f32; N] {
    vector.map(|value| if (value as f32).is_finite() { value as f32 } else { 0.0 })
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.indices.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        single((self.mesh.positions[self.index(face, corner)] * self.scale).to_array())
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let normal = match &self.mesh.normals {
            Some(normals) => normals[self.index(face, corner)],
            None => {
                let [p, q, r] =
                    [0, 1, 2].map(|k| self.mesh.positions[self.index(face, k)] * self.scale);
                (q - p).cross(r - p)
            }
        };
        single(normal.normalize_or_zero().to_array())
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.uvs.map_or(DVec2::ZERO, |uvs| uvs[self.index(face, corner)]);
        // The convention has v upwards, and files have it downwards.
        let DVec2 { x, y } = self.to_uv.transform_point2(uv);
        single([x, 1.0 - y])
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let Some(space) = space else { return };
        let [x, y, z] = space.tangent().map(f64::from);
        let tangent = DVec3::new(x, y, z);
        if tangent.is_finite() {
            let side = if space.is_orientation_preserving() { 1.0 } else { -1.0 };
            self.tangents[face][corner] = tangent.extend(side);
        }
    }
}
