//! Area lights: polygons, disks and spheres, from far, near and inside.

use crate::{
    Random, area_light, assert_mean, irradiance, irradiance_sample, origin_up, receiver,
    whole_sphere,
};
use approx::assert_relative_eq;
use pathspace::endpoint::{AreaLight, Endpoint};
use pathspace::geometry::{Disk, Place, Quad, Shape, Sphere, Triangle};
use pathspace::glam::{DVec2, DVec3};
use pathspace::math::Rgb;
use std::f64::consts::PI;

#[test]
fn b06_to_b11_polygons_and_disks() {
    let square = Quad {
        origin: DVec3::new(-1.0, -1.0, 2.0),
        edge_u: DVec3::Y * 2.0,
        edge_v: DVec3::X * 2.0,
    };
    assert_mean(
        "B06",
        irradiance(&area_light(Shape::Quad(square), false), &origin_up(), 400_000),
        0.752_274_688_454_107_5,
        1e-3,
    );
    let [a, b, c, d] = [DVec3::ZERO, square.edge_u, square.edge_u + square.edge_v, square.edge_v]
        .map(|e| square.origin + e);
    let triangles =
        [[a, b, c], [a, c, d], [a, a, d]].map(|vertices| Shape::Triangle(Triangle { vertices }));
    let pair = AreaLight::new(triangles.to_vec(), 0, 0, Rgb::WHITE, false).unwrap();
    assert_mean(
        "B06 as triangles",
        irradiance(&pair, &origin_up(), 400_000),
        0.752_274_688_454_107_5,
        1e-3,
    );

    let vertices =
        [DVec3::new(0.2, 0.1, 0.6), DVec3::new(1.4, 0.3, 1.1), DVec3::new(0.3, 1.2, 1.7)];
    let triangle = area_light(Shape::Triangle(Triangle { vertices }), true);
    let x = receiver(DVec3::ZERO, DVec3::new(0.36, -0.48, 0.8));
    assert_mean("B07", irradiance(&triangle, &x, 2_000_000), 0.093_479_235_265_640_06, 1e-3);

    let disk = Disk { center: 2.0 * DVec3::Z, normal: -DVec3::Z, radius: 1.0 };
    assert_mean(
        "B11",
        irradiance(&area_light(Shape::Disk(disk), false), &origin_up(), 400_000),
        0.628_318_530_717_958_6,
        1e-3,
    );
}

#[test]
fn b09_sphere_light() {
    let theta = 30f64.to_radians();
    let light = whole_sphere(3.0 * DVec3::new(theta.sin(), 0.0, theta.cos()), 1.0, 1.0);
    assert_mean("B09", irradiance(&light, &origin_up(), 1_000_000), 0.302_299_894_039_036_3, 1e-3);
    // Mirrored scene, same numbers: nothing depends on handedness.
    let mirrored = whole_sphere(3.0 * DVec3::new(-theta.sin(), 0.0, theta.cos()), 1.0, 1.0);
    assert_mean(
        "B09 mirrored",
        irradiance(&mirrored, &origin_up(), 1_000_000),
        0.302_299_894_039_036_3,
        1e-3,
    );
}

#[test]
fn b20_tiny_far_spheres() {
    for exponent in [-3, -6, -9, -12, -100] {
        let ratio = 10f64.powi(exponent);
        for distance in [1.0, 1e6, 1e-6] {
            for center in [DVec3::ZERO, DVec3::new(3.0, -2.0, 1.0)] {
                let to_light = DVec3::new(0.0, 0.6, 0.8);
                let light = whole_sphere(center, ratio * distance, ratio.powi(-2));
                let x = receiver(center - to_light * distance, to_light);
                let (e, error) = irradiance(&light, &x, 2000);
                let expected = PI;
                assert!(
                    (e - expected).abs() < 4.0 * error + 1e-9,
                    "{ratio} {distance}: {e} ± {error}"
                );
                assert!(error < 1e-3 * expected);
            }
        }
    }
    // The entry itself, to its 1e-6.
    let light = whole_sphere(DVec3::Z * 1e6, 1e-6, 1e24);
    assert_relative_eq!(irradiance(&light, &origin_up(), 1000).0, PI, max_relative = 1e-12);
}

#[test]
fn spheres_from_very_near() {
    // The receiver faces the centre, so E = π (r/d)² at any distance.
    for height in [1e-1, 1e-3, 1e-6, 1e-9, 1e-12] {
        let light = whole_sphere(DVec3::ZERO, 1.0, 1.0);
        let x = receiver(DVec3::new(0.0, 0.6, 0.8) * (1.0 + height), -DVec3::new(0.0, 0.6, 0.8));
        let (e, error) = irradiance(&light, &x, 400_000);
        println!("height {height}: {e} ± {error}");
        let tolerance = if height < 1e-9 { 1e-3 } else { 1e-6 };
        assert!(
            (e - PI / (1.0 + height).powi(2)).abs() < 4.0 * error + tolerance,
            "height {height}: {e} ± {error}"
        );
    }
}

#[test]
fn one_predicate_decides_which_side_of_a_sphere_a_receiver_is_on() {
    let light = whole_sphere(DVec3::ZERO, 1.0, 1.0);
    let mut rng = Random::new(6);
    for z in [1.0 + 4e-15, 1f64.next_up(), 1.0, 1f64.next_down(), 0.5, 0.0] {
        let x = receiver(DVec3::Z * z, DVec3::Z);
        for u in [DVec2::ZERO, DVec2::splat(1.0 - 0.5 * f64::EPSILON)] {
            if let Some(s) = light.sample_from(&x, 0.5, u) {
                assert_eq!(s.pdf, light.pdf_from(&x, &s.point));
            }
        }
        // The receiver looks away from the sphere, or is inside of one that emits outwards only:
        // nothing arrives.
        for _ in 0..10_000 {
            assert!(irradiance_sample(&light, &x, &mut rng) < 1e-7);
        }
    }
    // Inside of an inward sphere, and of a two-sided one, E = π whatever the position; near its
    // wall the variance grows.
    let inward =
        area_light(Shape::Sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }), false);
    let both = area_light(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), true);
    for light in [&inward, &both] {
        let x = receiver(DVec3::new(0.2, -0.1, 0.3), DVec3::new(0.36, -0.48, 0.8));
        assert_mean("inside a sphere", irradiance(light, &x, 2_000_000), PI, 2e-3);
    }
}

#[test]
fn masked_spheres_sample_their_zone() {
    let zone =
        Sphere { cos_min: 0.5, axis: DVec3::X, ..Sphere::new(DVec3::new(1.0, 2.0, 3.0), 2.0) };
    let light = area_light(Shape::Sphere(zone), false);
    assert_relative_eq!(light.area(), 4.0 * PI, max_relative = 1e-14);
    let mut rng = Random::new(8);
    let far = receiver(DVec3::new(50.0, 0.0, 0.0), -DVec3::X);
    for _ in 0..1000 {
        let p = light.sample_from(&far, rng.next(), rng.next_2d()).unwrap().point;
        let outward = (p.position - zone.center) / zone.radius;
        assert!(outward.x >= 0.5 - 1e-12 && (outward.length() - 1.0).abs() < 1e-14);
        assert_eq!((p.primitive, p.surface, p.place), (7, 3, Place::Area));
    }
}
