//! Area lights near their receivers: points uniform in the solid angle of a rectangle or triangle.

use crate::{Random, assert_mean, estimate, irradiance, irradiance_sample, receiver};
use approx::assert_relative_eq;
use pathspace::endpoint::{AreaLight, Endpoint, Light};
use pathspace::geometry::{Quad, Shape, Sphere, SurfacePoint, Triangle};
use pathspace::glam::{DMat3, DVec2, DVec3};
use pathspace::math::Rgb;
use pathspace::math::statistics::{chi_square, sidak};
use proptest::prelude::*;
use std::f64::consts::PI;

fn light(shape: Shape) -> AreaLight {
    AreaLight::new(vec![shape], 7, 3, Rgb::WHITE, true).unwrap()
}

/// The solid angle of a triangle by Van Oosterom and Strackee 1983.
fn triangle_solid_angle(x: DVec3, vertices: [DVec3; 3]) -> f64 {
    let [a, b, c] = vertices.map(|v| v - x);
    let normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]);
    let [ra, rb, rc] = [a, b, c].map(DVec3::length);
    let denominator = ra * rb * rc + a.dot(b) * rc + b.dot(c) * ra + c.dot(a) * rb;
    2.0 * a.dot(normal).abs().atan2(denominator)
}

/// The solid angle of a rectangle from those of four rectangles with a corner at the receiver's
/// foot.
fn rectangle_solid_angle(x: DVec3, quad: &Quad) -> f64 {
    let (lu, lv) = (quad.edge_u.length(), quad.edge_v.length());
    let o = quad.origin - x;
    let h = o.dot(quad.edge_u.cross(quad.edge_v)).abs() / (lu * lv);
    let (x0, y0) = (o.dot(quad.edge_u) / lu, o.dot(quad.edge_v) / lv);
    let corner = |x: f64, y: f64| (x * y).atan2(h * (x * x + y * y + h * h).sqrt());
    corner(x0 + lu, y0 + lv) - corner(x0, y0 + lv) - corner(x0 + lu, y0) + corner(x0, y0)
}

/// The part of a shape between parameters.
fn cell(shape: &Shape, from: DVec2, to: DVec2) -> Vec<[DVec3; 3]> {
    let corners = [from, DVec2::new(to.x, from.y), to, DVec2::new(from.x, to.y)];
    match shape {
        Shape::Quad(q) => {
            let [a, b, c, d] = corners.map(|p| q.origin + q.edge_u * p.x + q.edge_v * p.y);
            vec![[a, b, c], [a, c, d]]
        }
        // From b to the side ca and along it: (1 - v) b + v ((1 - u) c + u a).
        Shape::Triangle(t) => {
            let [a, b, c] = t.vertices;
            let at = |p: DVec2| b * (1.0 - p.y) + (c * (1.0 - p.x) + a * p.x) * p.y;
            let [p, q, r, s] = corners.map(at);
            vec![[p, q, r], [p, r, s]]
        }
        _ => unreachable!(),
    }
}

/// The parameters of `cell` of a sampled point.
fn parameters(shape: &Shape, uv: DVec2) -> DVec2 {
    match shape {
        Shape::Quad(_) => uv,
        _ => {
            let (a, v) = (1.0 - uv.x - uv.y, 1.0 - uv.x);
            DVec2::new(if v > 0.0 { a / v } else { 0.0 }, v)
        }
    }
}

/// The solid angle that follows from the density at a point.
fn solid_angle(light: &AreaLight, x: &SurfacePoint, y: &SurfacePoint) -> f64 {
    let to = x.position - y.position;
    let cosine = y.geometric_normal.dot(to).abs() / to.length();
    cosine / to.length_squared() / light.pdf_from(x, y).value()
}

/// A rotation that no coordinate axis is special to.
fn tilt() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7)
}

/// Shapes of size about 1 with their normal along z, and receivers near them.
fn near_pairs() -> Vec<(Shape, DVec3)> {
    let quad = |u: f64, v: f64| {
        Shape::Quad(Quad { origin: DVec3::ZERO, edge_u: DVec3::X * u, edge_v: DVec3::Y * v })
    };
    let sheared = Shape::Quad(Quad {
        origin: DVec3::ZERO,
        edge_u: DVec3::X,
        edge_v: DVec3::new(0.4, 0.9, 0.0),
    });
    let triangle = |c: DVec3| Shape::Triangle(Triangle { vertices: [DVec3::ZERO, DVec3::X, c] });
    let shapes = [
        quad(1.0, 1.0),
        quad(1.0, 0.1),
        quad(0.02, 1.0),
        sheared,
        triangle(DVec3::Y),
        triangle(DVec3::new(0.6, 0.9, 0.0)),
        triangle(DVec3::new(-0.5, 0.1, 0.0)),
        triangle(DVec3::new(0.9, 0.02, 0.0)),
    ];
    let receivers = [
        DVec3::new(0.5, 0.5, 1.0),
        DVec3::new(0.3, 0.2, 0.3),
        DVec3::new(0.4, 0.1, 0.01),
        DVec3::new(-0.2, 0.3, 0.1),
        DVec3::new(-0.2, -0.3, 0.1),
        DVec3::new(1.5, 0.4, 0.5),
        DVec3::new(0.4, 1.3, 0.2),
        DVec3::new(0.5, -0.05, 0.02),
        DVec3::new(1.2, 1.2, 0.05),
        DVec3::new(0.01, 0.01, 0.001),
        DVec3::new(0.4, 0.3, 1e-7),
    ];
    shapes.iter().flat_map(|s| receivers.map(|x| (*s, x))).collect()
}

/// The pair after a rotation and a displacement.
fn moved(shape: Shape, x: DVec3, m: DMat3, by: DVec3) -> (Shape, DVec3) {
    let shape = match shape {
        Shape::Quad(q) => Shape::Quad(Quad {
            origin: m * q.origin + by,
            edge_u: m * q.edge_u,
            edge_v: m * q.edge_v,
        }),
        Shape::Triangle(t) => {
            Shape::Triangle(Triangle { vertices: t.vertices.map(|v| m * v + by) })
        }
        _ => unreachable!(),
    };
    (shape, m * x + by)
}

#[test]
fn the_density_is_that_of_the_solid_angle() {
    let mut rng = Random::new(21);
    let mut by_solid_angle = 0;
    for (shape, x) in near_pairs() {
        let (light, x) = (light(shape), receiver(x, -DVec3::Z));
        let area = 1.0 / light.area();
        let expected = match &shape {
            Shape::Quad(q) if q.edge_u.dot(q.edge_v) == 0.0 => rectangle_solid_angle(x.position, q),
            Shape::Triangle(t) => triangle_solid_angle(x.position, t.vertices),
            _ => cell(&shape, DVec2::ZERO, DVec2::ONE)
                .into_iter()
                .map(|t| triangle_solid_angle(x.position, t))
                .sum(),
        };
        for _ in 0..20 {
            let sample = light.sample_from(&x, rng.next(), rng.next_2d()).unwrap();
            assert_eq!(light.pdf_from(&x, &sample.point), sample.pdf);
            let uv = sample.point.uv;
            let reported = match shape {
                Shape::Quad(q) => q.point_at(uv.x, uv.y),
                Shape::Triangle(t) => t.point_at(uv.x, uv.y),
                _ => unreachable!(),
            };
            assert_eq!(sample.point, SurfacePoint { primitive: 7, surface: 3, ..reported });
            if sample.pdf.value() == area {
                continue;
            }
            by_solid_angle += 1;
            assert_relative_eq!(
                solid_angle(&light, &x, &sample.point),
                expected,
                max_relative = 1e-12 + 1e-15 / expected
            );
        }
    }
    assert!(by_solid_angle >= 1400, "{by_solid_angle}");
}

#[test]
fn densities_integrate_to_one() {
    // Midpoints of 400² cells: errors fall with the square of their number, until peaks narrower
    // than a cell.
    const N: usize = 400;
    for (shape, x) in near_pairs().into_iter().filter(|(_, x)| x.z >= 0.1) {
        let (shape, x) = moved(shape, x, tilt(), DVec3::new(0.3, -0.2, 0.1));
        let light = light(shape);
        let x = receiver(x, DVec3::Z);
        let at = |i: usize| (i as f64 + 0.5) / N as f64;
        let sum: f64 = (0..N * N)
            .map(|i| {
                let mut point = shape.sample_area(DVec2::new(at(i % N), at(i / N)));
                (point.primitive, point.surface) = (7, 3);
                light.pdf_from(&x, &point).value()
            })
            .sum();
        assert_relative_eq!(sum * light.area() / (N * N) as f64, 1.0, max_relative = 1e-4);
    }
}

#[test]
fn samples_fill_every_part_in_proportion_to_its_solid_angle() {
    const CELLS: usize = 8;
    const N: usize = 100_000;
    let mut rng = Random::new(22);
    for (index, (shape, x)) in near_pairs().into_iter().enumerate() {
        for m in [DMat3::IDENTITY, tilt()] {
            let (shape, x) = moved(shape, x, m, DVec3::ZERO);
            let light = light(shape);
            let x = receiver(x, DVec3::Z);
            let at = |i: usize| i as f64 / CELLS as f64;
            let expected: Vec<f64> = (0..CELLS * CELLS)
                .map(|i| {
                    let (i, j) = (i % CELLS, i / CELLS);
                    let from = DVec2::new(at(i), at(j));
                    let to = DVec2::new(at(i + 1), at(j + 1));
                    let triangles = cell(&shape, from, to).into_iter();
                    triangles.map(|t| triangle_solid_angle(x.position, t)).sum()
                })
                .collect();
            let total: f64 = expected.iter().sum();
            let mut counts = vec![0.0; CELLS * CELLS];
            let mut is_by_area = false;
            for _ in 0..N {
                let sample = light.sample_from(&x, rng.next(), rng.next_2d()).unwrap();
                is_by_area |= sample.pdf.value() == 1.0 / light.area();
                let p = parameters(&shape, sample.point.uv) * CELLS as f64;
                let [i, j] = [p.x, p.y].map(|p| (p as usize).min(CELLS - 1));
                counts[i + CELLS * j] += 1.0;
            }
            if is_by_area {
                continue;
            }
            let expected: Vec<f64> = expected.iter().map(|e| e / total * N as f64).collect();
            let p = chi_square(&counts, &expected, 10.0).p_value;
            assert!(p > sidak(1e-3, 200), "{index} {shape:?} {x:?}: {p}");
        }
    }
}

#[test]
fn columns_of_a_rectangle_have_the_share_that_chose_them() {
    let mut rng = Random::new(25);
    for (shape, x) in near_pairs() {
        let Shape::Quad(quad) = shape else { continue };
        if quad.edge_u.dot(quad.edge_v) != 0.0 {
            continue;
        }
        let (light, x) = (light(shape), receiver(x, -DVec3::Z));
        for _ in 0..20 {
            let u = rng.next_2d();
            let sample = light.sample_from(&x, 0.5, u).unwrap();
            if sample.pdf.value() == 1.0 / light.area() {
                continue;
            }
            let before = Quad { edge_u: quad.edge_u * sample.point.uv.x, ..quad };
            let share = rectangle_solid_angle(x.position, &before)
                / rectangle_solid_angle(x.position, &quad);
            // Parameters are rounded to 1e-16, which is more of the solid angle the nearer x is.
            let tolerance = 1e-11 + 1e-15 / x.position.z;
            assert_relative_eq!(share, u.x, max_relative = 0.0, epsilon = tolerance);
        }
    }
}

/// The irradiance of a polygon of radiance 1 above the horizon (Lambert 1760).
fn polygon_irradiance(x: &SurfacePoint, corners: &[DVec3]) -> f64 {
    let n = corners.len();
    let edge = |i: usize| {
        let [p, q] = [corners[i], corners[(i + 1) % n]].map(|v| v - x.position);
        let cross = p.cross(q);
        cross.length().atan2(p.dot(q)) * x.geometric_normal.dot(cross.normalize_or_zero())
    };
    0.5 * (0..n).map(edge).sum::<f64>().abs()
}

/// Mean and standard error of the irradiance by points uniform on the area.
fn irradiance_by_area(light: &dyn Light, x: &SurfacePoint, n: u32) -> (f64, f64) {
    let mut rng = Random::new(23);
    estimate(n, || {
        let sample = light.sample_point(rng.next(), rng.next_2d()).unwrap();
        let to = sample.point.position - x.position;
        let w = to.normalize();
        let g = x.geometric_normal.dot(w).max(0.0) * sample.point.cosine(w) / to.length_squared();
        light.emit(&sample.point, -w).mean() * g / sample.pdf.value()
    })
}

#[test]
fn irradiance_near_a_light_has_a_bounded_variance() {
    let n = 100_000;
    let corners = [DVec3::ZERO, DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::X];
    let quad = Quad { origin: DVec3::ZERO, edge_u: DVec3::Y, edge_v: DVec3::X };
    let triangle = Triangle { vertices: [corners[0], corners[1], corners[3]] };
    let cases = [
        (Shape::Quad(quad), &corners[..]),
        (Shape::Triangle(triangle), &[corners[0], corners[1], corners[3]][..]),
    ];
    for (shape, corners) in cases {
        // It shines downwards.
        let light = AreaLight::new(vec![shape], 0, 0, Rgb::WHITE, false).unwrap();
        // Below it, and at its edge; with the least gains over points uniform on the area, whose
        // variance cannot be estimated any more from very near.
        for (height, least_gains) in [
            (0.3, [10.0, 1.1]),
            (0.1, [30.0, 5.0]),
            (0.01, [1e3, 200.0]),
            (1e-4, [0.0; 2]),
            (1e-7, [0.0; 2]),
        ] {
            let below = receiver(DVec3::new(0.3, 0.3, -height), DVec3::Z);
            let beside = receiver(DVec3::new(-1e-3 * height, 0.3, -height), DVec3::X);
            for (x, least_gain) in [below, beside].iter().zip(least_gains) {
                let expected = polygon_irradiance(x, corners);
                let mut rng = Random::new(24);
                let (mean, error) = estimate(n, || irradiance_sample(&light, x, &mut rng));
                assert_mean(&format!("{height} {shape:?}"), (mean, error), expected, 2.5e-3);
                let (_, by_area) = irradiance_by_area(&light, x, n);
                let gain = (by_area / error).powi(2);
                assert!(gain > least_gain, "{height} {shape:?}: {gain}");
            }
        }
    }
}

#[test]
fn each_shape_of_a_light_is_sampled_for_its_receiver() {
    let (right, up) = (DVec3::X, DVec3::Y);
    let quad = Quad { origin: DVec3::new(-0.5, -0.5, 0.3), edge_u: up, edge_v: right };
    let vertices =
        [DVec3::new(1.0, 0.0, 0.5), DVec3::new(1.0, 1.0, 0.5), DVec3::new(2.0, 0.0, 0.5)];
    let center = DVec3::new(0.0, -1.2, 1.0);
    let sphere = Sphere::new(center, 0.6);
    let shapes =
        vec![Shape::Quad(quad), Shape::Triangle(Triangle { vertices }), Shape::Sphere(sphere)];
    let light = AreaLight::new(shapes, 5, 0, Rgb::WHITE, false).unwrap();
    let x = receiver(DVec3::ZERO, DVec3::Z);
    let distance = center.length();
    let expected = polygon_irradiance(&x, &quad.corners())
        + polygon_irradiance(&x, &vertices)
        + PI * (sphere.radius / distance).powi(2) * center.z / distance;
    assert_mean("three shapes", irradiance(&light, &x, 2_000_000), expected, 2e-3);
}

/// Numbers of either sign and of all magnitudes from 1e-13 to 1, or 0.
fn any_magnitude() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        (-13.0..0.0f64, any::<bool>()).prop_map(|(e, s)| if s {
            10f64.powf(e)
        } else {
            -10f64.powf(e)
        }),
        -3.0..3.0f64,
    ]
}

fn any_vector() -> impl Strategy<Value = DVec3> {
    [any_magnitude(), any_magnitude(), any_magnitude()].prop_map(DVec3::from_array)
}

fn any_unit() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(1.0 - 0.5 * f64::EPSILON), Just(f64::MIN_POSITIVE), 0.0..1.0f64]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..<_>::default() })]

    #[test]
    fn s74_extremes_have_points_with_a_density(
        edges in [any_vector(), any_vector()],
        is_rectangle in any::<bool>(),
        is_quad in any::<bool>(),
        origin in any_vector(),
        // Where the receiver is: at parameters of the plane, and this far from it.
        (u, v) in (
            prop_oneof![Just(0.0), Just(0.5), Just(1.0), any_magnitude()],
            prop_oneof![Just(0.0), Just(0.5), Just(1.0), any_magnitude()],
        ),
        height in any_magnitude(),
        distance in prop_oneof![Just(1.0), Just(1e9)],
        exponent in prop_oneof![Just(0), Just(-45), Just(45)],
        error in prop_oneof![Just(0.0), Just(1e-15)],
        two_sided in any::<bool>(),
        numbers in [any_unit(), any_unit()],
    ) {
        let scale = 10f64.powi(exponent);
        let edge_u = edges[0] * scale;
        let mut edge_v = edges[1] * scale;
        if is_rectangle {
            edge_v = edge_u.any_orthogonal_vector() * edges[1].length();
        }
        let origin = origin * scale;
        let shape = if is_quad {
            Shape::Quad(Quad { origin, edge_u, edge_v })
        } else {
            Shape::Triangle(Triangle { vertices: [origin, origin + edge_u, origin + edge_v] })
        };
        let normal = edge_u.cross(edge_v).normalize_or_zero();
        let position = origin + edge_u * u + edge_v * v + normal * (height * distance * scale);
        let x = SurfacePoint { error: error * scale, ..receiver(position, DVec3::Z) };
        let Ok(light) = AreaLight::new(vec![shape], 0, 0, Rgb::WHITE, two_sided) else {
            return Ok(());
        };
        if let Some(sample) = light.sample_from(&x, 0.5, DVec2::from_array(numbers)) {
            let pdf = sample.pdf.value();
            prop_assert!(pdf > 0.0 && pdf.is_finite(), "{pdf}");
            prop_assert_eq!(light.pdf_from(&x, &sample.point), sample.pdf);
            prop_assert!(sample.point.position.is_finite());
            let uv = sample.point.uv;
            prop_assert!(uv.min_element() >= 0.0 && uv.max_element() <= 1.0, "{uv}");
            prop_assert!(is_quad || uv.element_sum() <= 1.0 + f64::EPSILON, "{uv}");
            // What an estimate of irradiance divides by is no smaller than what it has.
            let to = x.position - sample.point.position;
            let g = sample.point.geometric_normal.dot(to).abs() / to.length().powi(3);
            let estimate = g / pdf;
            prop_assert!(pdf == light.point_pdf(&sample.point).value() || estimate < 6.3);
        } else {
            prop_assert!(false, "no point");
        }
    }
}
