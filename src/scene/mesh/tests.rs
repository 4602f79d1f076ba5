//! Meshes that are placed, refused and divided.

use super::*;
use approx::assert_relative_eq;

#[test]
fn icospheres_are_closed_and_face_outwards() {
    for levels in 0..4 {
        let mesh = Mesh::icosphere(levels);
        assert_eq!(mesh.indices.len(), 20 << (2 * levels));
        // Euler's formula for a closed surface without holes: V - E + F = 2 with E = 3 F / 2.
        assert_eq!(2 * mesh.positions.len(), mesh.indices.len() + 4);
        let placed = mesh.place("ball", &DAffine3::IDENTITY).expect("valid");
        for shape in &placed.triangles {
            let Shape::Triangle(t) = shape else { unreachable!() };
            assert!(t.cross().dot(t.vertices[0]) > 0.0);
        }
    }
}

/// Normals that are those of the triangles up to single precision are left out, on either side;
/// others, and texture coordinates, are kept.
#[test]
fn normals_of_flat_meshes_are_left_out() {
    let n = DVec3::new(0.2, -0.3, 1.0).normalize();
    let (u, v) = n.any_orthonormal_pair();
    let mesh = |normal: DVec3| Mesh {
        positions: vec![u, v, -u - v],
        normals: Some(vec![n.as_vec3().as_dvec3(), normal, n]),
        uvs: Some(vec![DVec2::X, DVec2::Y, DVec2::ONE]),
        indices: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    for (normal, is_smooth) in
        [(n, false), (-n, false), (n + 1e-7 * u, false), (n + 1e-5 * u, true)]
    {
        let placed = mesh(normal).place("thing", &DAffine3::IDENTITY).expect("valid");
        let attributes = placed.attributes.expect("texture coordinates");
        assert_eq!(attributes.is_smooth(), is_smooth, "{normal}");
        assert!(attributes.corner_uvs().is_some());
    }
}

#[test]
fn attributes_follow_the_vertices_through_a_mirror() {
    let mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: Some(vec![
            DVec3::new(0.1, 0.0, 1.0),
            DVec3::new(0.5, 0.0, 1.0),
            DVec3::new(0.0, 0.5, 1.0),
        ]),
        uvs: Some(vec![DVec2::new(0.2, 0.3), DVec2::new(0.6, 0.3), DVec2::new(0.2, 0.9)]),
        indices: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    for mirror in [1.0, -1.0] {
        let placed = mesh
            .place("thing", &DAffine3::from_scale(DVec3::new(mirror, 1.0, 1.0)))
            .expect("valid");
        let (shape, attributes) = (&placed.triangles[0], placed.attributes.expect("given"));
        let ray = crate::geometry::Ray::new(DVec3::new(0.25 * mirror, 0.5, 1.0), -DVec3::Z);
        let flat = shape.point_at_hit(&ray, &shape.intersect(&ray).expect("aimed at it"));
        assert_eq!(flat.geometric_normal, DVec3::Z);
        let x = attributes.at(0, shape.as_triangle().expect("one"), Shading::of(&flat));
        assert_relative_eq!(x.uv, DVec2::new(0.3, 0.6), epsilon = 1e-15);
        assert_relative_eq!(x.tangent.normalize(), DVec3::X * mirror, epsilon = 1e-15);
        assert!(x.normal.x * mirror > 0.0 && x.normal.is_normalized());
    }
}

#[test]
fn shading_normals_stay_on_the_side_of_the_geometric_one() {
    let mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: Some(vec![-DVec3::Z, DVec3::Z, DVec3::new(0.6, 0.0, -0.8)]),
        indices: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let placed = mesh.place("thing", &DAffine3::IDENTITY).expect("valid");
    let (triangle, attributes) =
        (placed.triangles[0].as_triangle().expect("one"), placed.attributes.expect("given"));
    for (u, v, expected) in
        [(0.0, 0.0, DVec3::Z), (0.5, 0.0, DVec3::Z), (0.0, 1.0, DVec3::new(-0.6, 0.0, 0.8))]
    {
        let x = attributes.at(0, triangle, Shading::of(&triangle.point_at(u, v)));
        assert_relative_eq!(x.normal, expected, epsilon = 1e-15);
    }
}
