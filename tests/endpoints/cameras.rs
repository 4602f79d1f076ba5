//! Cameras: where rays project to, and importance.

use crate::{Random, area_light, assert_mean, estimate, receiver};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use pathspace::endpoint::{Camera, Endpoint, OrthographicCamera, PinholeCamera, ThinLensCamera};
use pathspace::geometry::{Place, Quad, Shape, SurfacePoint};
use pathspace::glam::{DVec2, DVec3, UVec2};
use pathspace::math::warp;
use std::f64::consts::PI;

fn cameras(resolution: UVec2, window: Option<(UVec2, UVec2)>) -> Vec<Box<dyn Camera>> {
    let [position, target, up] =
        [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-2.0, 0.5, 1.0), DVec3::new(0.1, 0.2, 5.0)];
    let mut pinhole = PinholeCamera::new(position, target, up, 40.0, resolution).unwrap();
    let mut lens = ThinLensCamera::new(position, target, up, 70.0, 0.2, 3.0, resolution).unwrap();
    let mut parallel = OrthographicCamera::new(position, target, up, 2.5, resolution).unwrap();
    if let Some((min, max)) = window {
        pinhole = pinhole.with_window(min, max).unwrap();
        lens = lens.with_window(min, max).unwrap();
        parallel = parallel.with_window(min, max).unwrap();
    }
    vec![Box::new(pinhole), Box::new(lens), Box::new(parallel)]
}

#[test]
fn rays_project_to_where_they_came_from() {
    let mut rng = Random::new(15);
    for (resolution, window) in [
        (UVec2::new(640, 480), None),
        (UVec2::new(64, 64), Some((UVec2::new(3, 5), UVec2::new(60, 7)))),
        (UVec2::new(1, 1), None),
        (UVec2::new(7, 300), Some((UVec2::new(6, 299), UVec2::new(7, 300)))),
    ] {
        for camera in cameras(resolution, window) {
            for _ in 0..1000 {
                let u = 1.2 * rng.next_2d() - 0.1;
                let p = camera.sample_point(rng.next(), rng.next_2d()).unwrap();
                let d = camera.sample_direction(&p.point, u).unwrap();
                let raster = camera.raster(&d.from, d.direction).unwrap();
                assert_abs_diff_eq!(camera.film().to_window(raster), u, epsilon = 1e-11);
                assert_eq!(p.pdf, camera.point_pdf(&p.point));
                assert_eq!(d.pdf, camera.direction_pdf(&d.from, d.direction));
                // We / (p p⊥) = 1 for every camera ray.
                assert_relative_eq!((d.weight / p.pdf.value()).mean(), 1.0, max_relative = 1e-14);
                assert_relative_eq!(
                    camera.emit(&d.from, d.direction).mean(),
                    d.weight.mean() * d.pdf.value(),
                    max_relative = 1e-14
                );
                // A receiver along the ray, connected to the same point, projects to the same
                // place.
                let x = receiver(d.from.position + d.direction * 4.0, -d.direction);
                let y = camera.facing(&p.point, &x);
                let towards = (x.position - y.position).normalize();
                let again = camera.film().to_window(camera.raster(&y, towards).unwrap());
                assert_abs_diff_eq!(again, u, epsilon = 1e-10);
                // Behind the camera nothing is recorded.
                let behind = receiver(d.from.position - d.direction * 4.0, d.direction);
                let connected = camera.sample_from(&behind, 0.5, rng.next_2d());
                let seen = connected.and_then(|s| {
                    camera.raster(&s.point, (behind.position - s.point.position).normalize())
                });
                assert!(seen.is_none());
            }
        }
    }
}

#[test]
fn image_axes_point_right_and_down() {
    let camera =
        PinholeCamera::new(DVec3::ZERO, -DVec3::Z, DVec3::Y, 90.0, UVec2::new(100, 100)).unwrap();
    let at = |w: DVec3| camera.raster(&SurfacePoint::dirac(DVec3::ZERO), w.normalize()).unwrap();
    assert_abs_diff_eq!(at(DVec3::new(1.0, 0.0, -1.0)), DVec2::new(100.0, 50.0), epsilon = 1e-12);
    assert_abs_diff_eq!(at(DVec3::new(0.0, 1.0, -1.0)), DVec2::new(50.0, 0.0), epsilon = 1e-12);
}

#[test]
fn e01_pinhole_importance() {
    let camera =
        PinholeCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0, UVec2::new(64, 64)).unwrap();
    let p = camera.sample_point(0.5, DVec2::ZERO).unwrap().point;
    // At a Dirac position importance is per solid angle: We cos θ.
    let we = |w: DVec3| camera.emit(&p, w).mean() / w.z;
    assert_relative_eq!(we(DVec3::Z), 0.25, max_relative = 1e-14);
    assert_relative_eq!(we(DVec3::ONE.normalize()), 2.25, max_relative = 1e-14);
    assert!(camera.emit(&p, -DVec3::Z).is_black() && camera.emit(&p, DVec3::X).is_black());

    // ∫ We over the window's directions, by quadrature on the sphere's cube face: dσ = cos³ θ dA.
    for window in [None, Some((UVec2::new(10, 20), UVec2::new(30, 64)))] {
        let camera = window.map_or(camera, |(min, max)| camera.with_window(min, max).unwrap());
        let n = 512;
        let mut sum = 0.0;
        for i in 0..n * n {
            let plane = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n)
                * 2.0
                - 1.0;
            let w = plane.extend(1.0).normalize();
            if camera.film().pixel_index(camera.raster(&p, w).unwrap()).is_some() {
                sum += camera.emit(&p, w).mean() * w.z.powi(3) * (2.0 / f64::from(n)).powi(2);
            }
        }
        assert_relative_eq!(sum, 1.0, max_relative = 1e-9);
    }
}

#[test]
fn e02_thin_lens_importance() {
    let film = UVec2::new(64, 64);
    let camera =
        ThinLensCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0, 0.1, 2.0, film).unwrap();
    let lens = camera.sample_point(0.5, DVec2::splat(0.3)).unwrap().point;
    assert_eq!((lens.place, lens.geometric_normal), (Place::Area, DVec3::Z));
    assert_relative_eq!(
        camera.emit(&lens, DVec3::Z).mean(),
        7.957_747_154_594_767,
        max_relative = 1e-14
    );
    // ∫ We dσ⊥ dA over lens and window, sampling directions uniformly on the sphere.
    let mut rng = Random::new(16);
    let integral = estimate(4_000_000, || {
        let p = camera.sample_point(rng.next(), rng.next_2d()).unwrap();
        let w = warp::square_to_sphere(rng.next_2d());
        match camera.raster(&p.point, w).and_then(|r| camera.film().pixel_index(r)) {
            Some(_) => camera.emit(&p.point, w).mean() * w.z / p.pdf.value() * 4.0 * PI,
            None => 0.0,
        }
    });
    assert_mean("E02", integral, 1.0, 2e-3);
}

#[test]
fn e03_rectangle_seen_directly() {
    // A rectangle facing the camera fills (0.5/2)(0.4/2) of the film plane; counted from the camera
    // and by connecting the light.
    let camera =
        PinholeCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 60.0, UVec2::new(32, 32)).unwrap();
    let quad = Quad {
        origin: DVec3::new(-0.25, -0.2, 2.0),
        edge_u: DVec3::Y * 0.4,
        edge_v: DVec3::X * 0.5,
    };
    let light = area_light(Shape::Quad(quad), false);
    let mut rng = Random::new(17);
    let from_light = estimate(100_000, || {
        let y = light.sample_point(rng.next(), rng.next_2d()).unwrap();
        let x = camera.sample_from(&y.point, rng.next(), rng.next_2d()).unwrap();
        let to_light = (y.point.position - x.point.position).normalize();
        let g = y.point.cosine(to_light) / (y.point.position - x.point.position).length_squared();
        let value = light.emit(&y.point, -to_light) * camera.emit(&x.point, to_light);
        value.mean() * g / (y.pdf.value() * x.pdf.value())
    });
    assert_mean("E03 from the light", from_light, 0.0375, 1e-3);
}

#[test]
fn orthographic_importance() {
    let camera =
        OrthographicCamera::new(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, 2.0, UVec2::new(20, 10))
            .unwrap();
    let p = camera.sample_point(0.0, DVec2::ZERO).unwrap();
    assert_eq!(
        (p.point.place, p.point.geometric_normal, p.pdf.value()),
        (Place::Infinite, -DVec3::Z, 1.0)
    );
    // The film is 4 by 2 world units.
    assert_relative_eq!(
        camera.direction_pdf(&p.point, -DVec3::Z).value(),
        1.0 / 8.0,
        max_relative = 1e-15
    );
    let x = camera.facing(&p.point, &receiver(DVec3::new(2.0, 1.0, -3.0), DVec3::Z));
    assert_eq!(x.position, DVec3::new(2.0, 1.0, 5.0));
    assert_abs_diff_eq!(
        camera.raster(&x, -DVec3::Z).unwrap(),
        DVec2::new(20.0, 0.0),
        epsilon = 1e-12
    );
}
