//! Intersections that are known, and where rounding would break naive ones.

use super::*;
use approx::assert_relative_eq;

fn ray(origin: [f64; 3], towards: [f64; 3]) -> Ray {
    let (o, t) = (DVec3::from(origin), DVec3::from(towards));
    Ray::new(o, (t - o).normalize())
}

#[test]
fn triangle_parameters_belong_to_the_second_and_third_vertex() {
    let t = Triangle { vertices: [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 3.0] };
    for (o, side) in [([0.5, 0.6, 4.0], "front"), ([0.5, 0.6, -4.0], "back")] {
        let hit = t.intersect(&ray(o, [0.5, 0.6, 0.0])).expect(side);
        assert_relative_eq!(hit.t, 4.0);
        assert_relative_eq!(hit.u, 0.25);
        assert_relative_eq!(hit.v, 0.2);
    }
    assert!(t.intersect(&ray([0.5, 0.6, 4.0], [0.5, 0.6, 5.0])).is_none());
    assert!(t.intersect(&ray([2.0, 2.0, 4.0], [2.0, 2.0, 0.0])).is_none());
}

#[test]
fn quad_parameters_are_those_of_its_point() {
    let q = Quad {
        origin: DVec3::new(1.0, 2.0, 3.0),
        edge_u: DVec3::new(2.0, 0.5, 0.0),
        edge_v: DVec3::new(0.0, 1.0, 2.0),
    };
    for (u, v) in [(0.1, 0.7), (0.7, 0.1), (0.5, 0.5), (0.9, 0.95)] {
        let p = q.point_at(u, v);
        let ray = ray([4.0, -3.0, 2.0], p.position.into());
        let hit = Shape::Quad(q).intersect(&ray).expect("aimed at the quad");
        assert_relative_eq!(hit.u, u, max_relative = 1e-14);
        assert_relative_eq!(hit.v, v, max_relative = 1e-14);
        assert_relative_eq!(ray.at(hit.t), p.position, max_relative = 1e-14);
    }
    assert!(q.intersect(&ray([4.0, -3.0, 2.0], q.point_at(1.1, 0.5).position.into())).is_none());
    assert!(q.intersect(&ray([4.0, -3.0, 2.0], q.point_at(0.5, -0.1).position.into())).is_none());
}

#[test]
fn disk_hits_end_at_its_rim_and_lie_in_its_plane() {
    let d = Disk {
        center: DVec3::new(1.0, 2.0, 3.0),
        normal: DVec3::new(1.0, 2.0, 2.0) / 3.0,
        radius: 0.5,
    };
    let frame = crate::geometry::Frame::from_normal(d.normal);
    let origin = [9.0, 7.0, -3.0];
    for (r, hits) in [(0.0, true), (0.499, true), (0.501, false)] {
        let target = d.center + frame.x * (0.6 * r) + frame.y * (0.8 * r);
        let ray = ray(origin, target.into());
        let hit = Shape::Disk(d).intersect(&ray);
        assert_eq!(hit.is_some(), hits);
        if let Some(hit) = hit {
            let p = Shape::Disk(d).point_at_hit(&ray, &hit);
            assert_relative_eq!(p.position, target, epsilon = 1e-14);
            assert!(
                (p.position - d.center).dot(d.normal).abs()
                    <= p.error * d.normal.abs().element_sum()
            );
            assert_relative_eq!(p.uv, DVec2::new(0.6 * r + 0.5, 0.8 * r + 0.5), epsilon = 1e-13);
        }
    }
}

#[test]
fn rays_without_direction_hit_nothing() {
    let shapes = [
        Shape::Triangle(Triangle {
            vertices: [
                DVec3::new(-1.0, -1.0, 1.0),
                DVec3::new(1.0, -1.0, 1.0),
                DVec3::new(0.0, 1.0, 1.0),
            ],
        }),
        Shape::Sphere(crate::geometry::Sphere::new(DVec3::ZERO, 1.0)),
        Shape::Disk(Disk { center: DVec3::Z, normal: DVec3::Z, radius: 1.0 }),
        Shape::Quad(Quad {
            origin: DVec3::new(-1.0, -1.0, 1.0),
            edge_u: DVec3::X * 2.0,
            edge_v: DVec3::Y * 2.0,
        }),
    ];
    for shape in shapes {
        for (o, d) in [
            (DVec3::ZERO, DVec3::ZERO),
            (DVec3::NAN, DVec3::Z),
            (DVec3::ZERO, DVec3::NAN),
            (DVec3::INFINITY, DVec3::Z),
        ] {
            assert_eq!(shape.intersect(&Ray::new(o, d)), None, "{shape:?} {o} {d}");
        }
    }
}
