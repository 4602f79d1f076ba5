//! Polyhedra that scenes of the gallery are made of.

use crate::scene::Mesh;
use glam::DVec3;

/// A flat quadrilateral of two triangles, its corners counter-clockwise seen from the front.
pub(super) fn quadrilateral(corners: [DVec3; 4]) -> Mesh {
    quadrilaterals([corners])
}

/// Several of them as one mesh.
pub(super) fn quadrilaterals(all: impl IntoIterator<Item = [DVec3; 4]>) -> Mesh {
    let mut mesh = Mesh::default();
    for (first, corners) in (0..).step_by(4).zip(all) {
        mesh.positions.extend(corners);
        mesh.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

/// An upright prism between two heights (y). The base is given counter-clockwise seen from above:
/// in that order x turns towards -z. Open prisms have no lid.
pub(super) fn prism(base: [DVec3; 4], bottom: f64, top: f64, open: bool) -> Mesh {
    let ring = |height: f64| base.map(|corner| DVec3::new(corner.x, height, corner.z));
    let positions = [ring(bottom), ring(top)].concat();
    let mut indices = vec![[0, 2, 1], [0, 3, 2]];
    if !open {
        indices.extend([[4, 5, 6], [4, 6, 7]]);
    }
    for i in 0..4 {
        let next = (i + 1) % 4;
        indices.extend([[i, next, next + 4], [i, next + 4, i + 4]]);
    }
    Mesh { positions, indices, ..Mesh::default() }
}

/// A box with edges along the axes.
pub(super) fn cuboid(min: DVec3, max: DVec3, open: bool) -> Mesh {
    let corner = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let base =
        [corner(min.x, max.z), corner(max.x, max.z), corner(max.x, min.z), corner(min.x, min.z)];
    prism(base, min.y, max.y, open)
}

/// The inside of a box with edges along the axes, wall by wall: floor, ceiling, -x, +x, -z, +z.
pub(super) fn room(min: DVec3, max: DVec3) -> [Mesh; 6] {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let (a, b) = (min, max);
    [
        quadrilateral([p(a.x, a.y, b.z), p(b.x, a.y, b.z), p(b.x, a.y, a.z), p(a.x, a.y, a.z)]),
        quadrilateral([p(a.x, b.y, b.z), p(a.x, b.y, a.z), p(b.x, b.y, a.z), p(b.x, b.y, b.z)]),
        quadrilateral([p(a.x, a.y, b.z), p(a.x, a.y, a.z), p(a.x, b.y, a.z), p(a.x, b.y, b.z)]),
        quadrilateral([p(b.x, a.y, b.z), p(b.x, b.y, b.z), p(b.x, b.y, a.z), p(b.x, a.y, a.z)]),
        quadrilateral([p(a.x, a.y, a.z), p(b.x, a.y, a.z), p(b.x, b.y, a.z), p(a.x, b.y, a.z)]),
        quadrilateral([p(a.x, a.y, b.z), p(a.x, b.y, b.z), p(b.x, b.y, b.z), p(b.x, a.y, b.z)]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Triangle;

    /// Triangles with their centroids.
    fn triangles(mesh: &Mesh) -> impl Iterator<Item = (DVec3, DVec3)> {
        mesh.indices.iter().map(|t| {
            let vertices = t.map(|i| mesh.positions[i as usize]);
            (Triangle { vertices }.cross(), vertices.iter().sum::<DVec3>() / 3.0)
        })
    }

    #[test]
    fn boxes_face_outwards_and_rooms_inwards() {
        let (min, max) = (DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 5.0));
        let center = 0.5 * (min + max);
        for (normal, point) in triangles(&cuboid(min, max, false)) {
            assert!(normal.dot(point - center) > 0.0);
        }
        for (normal, point) in room(min, max).iter().flat_map(triangles) {
            assert!(normal.dot(point - center) < 0.0);
        }
    }
}
