//! Solids, whose backs nobody sees.

use crate::scene::Mesh;
use std::collections::HashMap;

/// True if triangles bound a solid, with their fronts outside: they have no border, and the volume
/// is positive. Vertices at the same place are one.
pub(super) fn is_solid(mesh: &Mesh) -> bool {
    let mut places: HashMap<[u64; 3], usize> = HashMap::new();
    // How often an edge is walked from the lower number to the higher, less how often back.
    let mut edges: HashMap<[usize; 2], i64> = HashMap::new();
    let mut volume = 0.0;
    let numbers: Vec<usize> = mesh
        .positions
        .iter()
        .map(|position| {
            let number = places.len();
            // -0 becomes 0.
            let place = position.to_array().map(|x| (x + 0.0).to_bits());
            *places.entry(place).or_insert(number)
        })
        .collect();
    for corners in &mesh.indices {
        let corners = corners.map(|corner| corner as usize);
        if corners.iter().any(|corner| *corner >= numbers.len()) {
            return false;
        }
        let [a, b, c] = corners.map(|corner| mesh.positions[corner]);
        volume += a.dot(b.cross(c));
        let [a, b, c] = corners.map(|corner| numbers[corner]);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let step = if from < to { 1 } else { -1 };
            if from != to {
                *edges.entry([from.min(to), from.max(to)]).or_default() += step;
            }
        }
    }
    volume > 0.0 && edges.values().all(|sum| *sum == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3Swizzles};

    /// A cube with a vertex of its own for each corner of each face.
    fn cube() -> Mesh {
        let mut mesh = Mesh::default();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let mut normal = DVec3::ZERO;
                normal[axis] = side;
                let (u, v) = (normal.zxy(), normal.cross(normal.zxy()));
                let first = mesh.positions.len() as u32;
                for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    mesh.positions.push(DVec3::splat(5.0) + normal + u * x + v * y);
                }
                mesh.indices.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k: u32| first + k)));
            }
        }
        mesh
    }

    #[test]
    fn only_closed_meshes_that_face_outwards_are_solids() {
        let outwards = cube();
        let [mut inwards, mut open, mut twisted] = [(); 3].map(|()| cube());
        inwards.indices.iter_mut().for_each(|corners| corners.swap(1, 2));
        open.indices.truncate(10);
        twisted.indices[3].swap(1, 2);
        assert!(is_solid(&outwards));
        for mesh in [&inwards, &open, &twisted, &Mesh::default()] {
            assert!(!is_solid(mesh));
        }
    }
}
