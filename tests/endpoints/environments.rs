//! Environments: constant ones and maps, with both lookups and any orientation.

use crate::{Random, assert_mean, estimate, flux, irradiance, origin_up, receiver};
use approx::assert_relative_eq;
use pathspace::endpoint::{ConstantEnvironment, Endpoint, EnvironmentMap, Light, Lookup};
use pathspace::geometry::{Bounds, SurfacePoint};
use pathspace::glam::{DMat3, DVec2, DVec3};
use pathspace::math::{Rgb, warp};
use std::f64::consts::PI;

/// A fine map of a radiance given by direction, up axis +Z.
fn map_of(height: u32, lookup: Lookup, radiance: impl Fn(DVec3) -> f64) -> EnvironmentMap {
    let width = 2 * height;
    let step = PI / f64::from(height);
    let mut pixels = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let (theta, phi) = ((f64::from(row) + 0.5) * step, (f64::from(column) + 0.5) * step);
            pixels.push(Rgb::splat(radiance(DVec3::new(
                theta.sin() * phi.sin(),
                theta.sin() * phi.cos(),
                theta.cos(),
            ))));
        }
    }
    EnvironmentMap::new(width, height, pixels, EnvironmentMap::Z_UP).unwrap().with_lookup(lookup)
}

#[test]
fn b03_cosine_power_environment() {
    for lookup in [Lookup::PiecewiseConstant, Lookup::Bilinear] {
        let entries = [(1, 2.0 / 3.0), (4, 1.0 / 3.0), (100, 2.0 / 102.0), (0, 1.0)];
        // Half of all samples are below the horizon at n = 0, where both lookups are the same.
        let count = if lookup == Lookup::Bilinear { 3 } else { 4 };
        for (n, expected) in entries.into_iter().take(count) {
            // The map itself is off by its discretisation, by n (π/512)² / 12 = 3e-4 for the
            // narrowest lobe, linearly interpolated.
            let light = map_of(if n == 0 { 8 } else { 512 }, lookup, |w| w.z.max(0.0).powi(n));
            let (e, error) =
                irradiance(&light, &origin_up(), if n == 0 { 2_000_000 } else { 200_000 });
            println!("B03 {lookup:?} n = {n}: {} ± {}", e / PI, error / PI);
            assert!(error < 1e-3 * e);
            assert!(
                (e / PI - expected).abs() < 4.0 * error / PI + 4e-4 * expected,
                "n = {n}: {}",
                e / PI
            );
        }
    }
}

#[test]
fn b05_linear_environment_at_any_orientation() {
    let light = map_of(128, Lookup::Bilinear, |w| 1.0 + 0.5 * w.z);
    let (nz, mut rng) = (0.3f64, Random::new(4));
    for _ in 0..2 {
        let phi = 2.0 * PI * rng.next();
        let s = (1.0 - nz * nz).sqrt();
        let x = receiver(DVec3::new(1.0, 2.0, 3.0), DVec3::new(s * phi.cos(), s * phi.sin(), nz));
        assert_mean("B05", irradiance(&light, &x, 2_000_000), 3.455_751_918_948_772_4, 1e-3);
    }
}

#[test]
fn b15_single_hot_pixel() {
    let mut pixels = vec![Rgb::BLACK; 64 * 128];
    pixels[5 * 128 + 17] = Rgb::splat(1e6);
    let mut light = EnvironmentMap::new(128, 64, pixels, EnvironmentMap::Z_UP).unwrap();
    let mut rng = Random::new(13);
    assert_mean("B15", irradiance(&light, &origin_up(), 200_000), 619.134_919_642_908_2, 1e-3);
    let p = light.sample_point(0.0, rng.next_2d()).unwrap();
    assert_relative_eq!(p.pdf.value(), 1.0 / 0.000_642_598_908_256_599_6, max_relative = 1e-12);
    light.set_scene_extent(&Bounds { min: -DVec3::ONE, max: DVec3::new(1.0, 1.0, 0.0) }.into());
    // The flux through the tight disk is less than the power, which counts the whole sphere around
    // the scene.
    let (emitted, _) = flux(&light, 10_000);
    assert!(emitted > 0.0 && emitted <= light.power().mean());
    // By emission: flux through the square |x|, |y| < 1 in the plane z = 0.
    let through = estimate(400_000, || {
        let p = light.sample_point(0.0, rng.next_2d()).unwrap();
        let d = light.sample_direction(&p.point, rng.next_2d()).unwrap();
        let hit = d.from.position - d.direction * (d.from.position.z / d.direction.z);
        if hit.x.abs() < 1.0 && hit.y.abs() < 1.0 {
            d.weight.mean() / p.pdf.value() / 4.0
        } else {
            0.0
        }
    });
    assert_mean("B15 by emission", through, 619.134_919_642_908_2, 2e-3);

    // Bilinear: sampling reaches everything that interpolation reaches, with a bounded ratio.
    let light = light.with_lookup(Lookup::Bilinear);
    let blurred = irradiance(&light, &origin_up(), 1_000_000);
    let (step, n) = (PI / 64.0, 600);
    let reference: f64 = (0..n * n)
        .map(|i| {
            // Midpoint rule over the three by three pixels around the hot one.
            let theta = step * (4.0 + 3.0 * (f64::from(i / n) + 0.5) / f64::from(n));
            let phi = step * (16.0 + 3.0 * (f64::from(i % n) + 0.5) / f64::from(n));
            let w = EnvironmentMap::Z_UP
                * DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
            light.radiance(w).mean() * w.z * theta.sin() * (3.0 * step / f64::from(n)).powi(2)
        })
        .sum();
    assert_mean("B15 bilinear", blurred, reference, 1.5e-3);
}

#[test]
fn environment_maps_sample_their_own_density() {
    let mut rng = Random::new(14);
    let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let (width, height) = (12u32, 6u32);
    // Black rows at one pole and in the middle, black columns, six orders of magnitude.
    let pixels: Vec<Rgb> = (0..width * height)
        .map(|i| {
            if i / width == 0 || i / width == 3 || i % width == 4 {
                Rgb::BLACK
            } else {
                Rgb::splat(10f64.powf(6.0 * rng.next()))
            }
        })
        .collect();
    for rotation in [rotation, DMat3::IDENTITY, DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))] {
        for lookup in [Lookup::PiecewiseConstant, Lookup::Bilinear, Lookup::BilinearToPoles] {
            let map = EnvironmentMap::new(width, height, pixels.clone(), rotation)
                .unwrap()
                .with_lookup(lookup);
            // The density integrates to 1 and is positive wherever there is radiance.
            let integral = estimate(400_000, || {
                let p = SurfacePoint::infinite(DVec3::ZERO, warp::square_to_sphere(rng.next_2d()));
                let pdf = map.point_pdf(&p).value();
                assert!(pdf > 0.0 || map.emit(&p, p.geometric_normal).is_black());
                pdf * 4.0 * PI
            });
            assert_mean("map density", integral, 1.0, 0.02);
            // Counts in octants of the world against the integral of the density there.
            let n = 400_000;
            let octant = |w: DVec3| {
                usize::from(w.x > 0.0) + 2 * usize::from(w.y > 0.0) + 4 * usize::from(w.z > 0.0)
            };
            let (mut counts, mut masses) = ([0.0f64; 8], [0.0f64; 8]);
            let mut total = Rgb::BLACK;
            let mut range = [f64::INFINITY, 0.0];
            let receiver = SurfacePoint::on_surface(DVec3::ONE, 0.0, DVec3::Z);
            for _ in 0..n {
                let (u1, u2) = (rng.next(), rng.next_2d());
                let s = map.sample_point(u1, u2).unwrap();
                assert_eq!(s.pdf, map.point_pdf(&s.point));
                let w = s.point.geometric_normal;
                let (from, radiance) = map.sample_emission(&receiver, u1, u2).unwrap();
                assert_eq!(Some(from), map.sample_from(&receiver, u1, u2));
                assert_eq!(radiance, Some(map.emit(&s.point, w)));
                let both = (radiance.unwrap(), s.pdf);
                assert_eq!(map.emission_and_pdf(&receiver, &s.point, w), both);
                let one = map.emit(&s.point, s.point.geometric_normal) / s.pdf.value();
                range = [one.r().min(range[0]), one.r().max(range[1])];
                total += one / f64::from(n);
                counts[octant(s.point.geometric_normal)] += 1.0 / f64::from(n);
            }
            let grid = 600;
            for i in 0..grid * grid {
                let u = DVec2::new(f64::from(i % grid) + 0.5, f64::from(i / grid) + 0.5)
                    / f64::from(grid);
                let w = warp::square_to_sphere(u);
                masses[octant(w)] +=
                    map.point_pdf(&SurfacePoint::infinite(DVec3::ZERO, w)).value() * 4.0 * PI
                        / f64::from(grid * grid);
            }
            for (count, mass) in counts.iter().zip(&masses) {
                assert!(
                    (count - mass).abs() < 4.0 * (mass * (1.0 - mass) / f64::from(n)).sqrt() + 3e-3,
                    "{count} {mass}"
                );
            }
            // Samples estimate the same integral, all but for the rows next to the poles between
            // the pixels' centres.
            let [least, most] = range.map(|one| one / total.mean());
            let is_right = match lookup {
                Lookup::PiecewiseConstant => least > 1.0 - 1e-9 && most < 1.0 + 1e-9,
                Lookup::Bilinear => most / least <= 3.0 + 1e-9 && least > 0.5,
                // From 1/2, over a sum of at most 4/3, up to any number at a black pole.
                Lookup::BilinearToPoles => least > 0.375,
            };
            assert!(is_right, "{least} {most}");
        }
    }
}

/// Rows lie at equal angles from pole to pole.
#[test]
fn bilinear_lookup_reaches_the_poles() {
    let rows = [1.0, 5.0, 2.0, 8.0];
    let pixels = rows.iter().flat_map(|v| [Rgb::splat(*v); 8]).collect();
    let map = EnvironmentMap::new(8, 4, pixels, DMat3::IDENTITY)
        .unwrap()
        .with_lookup(Lookup::BilinearToPoles);
    for i in 0..=300 {
        let x = f64::from(i) / 100.0;
        let (row, t) = ((x as usize).min(2), x - f64::from((x as i32).min(2)));
        let expected = rows[row] * (1.0 - t) + rows[row + 1] * t;
        let (sin, cos) = (PI * x / 3.0).sin_cos();
        let towards = DVec3::new(0.6 * sin, cos, 0.8 * sin).normalize();
        assert_relative_eq!(map.radiance(towards).mean(), expected, max_relative = 1e-6);
    }
    let row = EnvironmentMap::new(2, 1, vec![Rgb::WHITE; 2], DMat3::IDENTITY).unwrap();
    let row = row.with_lookup(Lookup::BilinearToPoles);
    assert_eq!(row.radiance(DVec3::Y), Rgb::WHITE);
}

#[test]
fn bilinear_lookup_is_linear_between_centres() {
    let (width, height) = (8u32, 4u32);
    let mut rng = Random::new(15);
    let pixels: Vec<f64> = (0..width * height).map(|_| rng.next()).collect();
    let colours = pixels.iter().map(|v| Rgb::splat(*v)).collect();
    let map = EnvironmentMap::new(width, height, colours, DMat3::IDENTITY)
        .unwrap()
        .with_lookup(Lookup::Bilinear);
    for _ in 0..10_000 {
        let (x, y) = (f64::from(width) * rng.next(), f64::from(height) * rng.next());
        let (theta, phi) = (PI * y / f64::from(height), 2.0 * PI * x / f64::from(width));
        // Every pixel's share is a tent around its centre; columns go around, and beyond the poles
        // rows repeat.
        let tent = |distance: f64| (1.0 - distance.abs()).max(0.0);
        let (mut expected, mut shares) = (0.0, 0.0);
        for (column, row) in
            (-1..=width as i32).flat_map(|c| (-1..=height as i32).map(move |r| (c, r)))
        {
            let share = tent(x - f64::from(column) - 0.5) * tent(y - f64::from(row) - 0.5);
            let (column, row) = (column.rem_euclid(width as i32), row.clamp(0, height as i32 - 1));
            expected += share * pixels[(row * width as i32 + column) as usize];
            shares += share;
        }
        assert_relative_eq!(shares, 1.0, max_relative = 1e-12);
        let towards = DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
        assert_relative_eq!(map.radiance(towards).mean(), expected, max_relative = 1e-9);
    }
}

#[test]
fn environment_map_orientation_and_poles() {
    let pixels: Vec<Rgb> = (0..8).map(|i| Rgb::splat(f64::from(i) + 1.0)).collect();
    let map = EnvironmentMap::new(4, 2, pixels, DMat3::IDENTITY).unwrap();
    // The left edge is at -Z; columns run to the right, through +X.
    assert_eq!(map.radiance(DVec3::new(0.1, 0.5, -1.0).normalize()).r(), 1.0);
    assert_eq!(map.radiance(DVec3::new(1.0, 0.5, 0.1).normalize()).r(), 2.0);
    assert_eq!(map.radiance(DVec3::new(-0.1, -0.5, -1.0).normalize()).r(), 8.0);
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| EnvironmentMap::Z_UP * a);
    assert_eq!((x, y, z), (DVec3::X, DVec3::Z, DVec3::NEG_Y));
    for lookup in [Lookup::PiecewiseConstant, Lookup::Bilinear, Lookup::BilinearToPoles] {
        let map = map.clone().with_lookup(lookup);
        for w in [DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::X] {
            assert!(
                map.radiance(w).is_finite()
                    && map.point_pdf(&SurfacePoint::infinite(DVec3::ZERO, -w)).value() > 0.0
            );
        }
        for u in [DVec2::ZERO, DVec2::ONE, DVec2::splat(1.0 - 0.5 * f64::EPSILON), DVec2::NAN] {
            assert!(map.sample_point(0.0, u).is_some_and(|s| s.pdf.value().is_finite()));
        }
    }
    let black = EnvironmentMap::new(4, 2, vec![Rgb::BLACK; 8], DMat3::IDENTITY).unwrap();
    assert!(black.sample_point(0.5, DVec2::splat(0.5)).is_none() && black.power().is_black());
}

/// The first number alone chooses the azimuth, so numbers that are stratified are so over azimuths,
/// though the brightest azimuth is another one in each row.
#[test]
fn environment_maps_choose_the_azimuth_first() {
    let pixels = [1.0, 5.0, 5.0, 1.0].map(Rgb::splat).to_vec();
    let map = EnvironmentMap::new(2, 2, pixels, DMat3::IDENTITY).unwrap();
    for (i, j) in (0..10).flat_map(|i| (0..10).map(move |j| (i, j))) {
        let u = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / 10.0;
        let towards = -map.sample_point(0.5, u).unwrap().point.geometric_normal;
        let azimuth = towards.x.atan2(-towards.z).rem_euclid(2.0 * PI);
        assert_relative_eq!(azimuth, 2.0 * PI * u.x, max_relative = 1e-12);
    }
}

#[test]
fn constant_environment() {
    let mut light = ConstantEnvironment::new(Rgb::splat(2.0)).unwrap();
    assert_mean(
        "constant environment",
        irradiance(&light, &origin_up(), 2_000_000),
        2.0 * PI,
        1e-3,
    );
    assert_eq!(flux(&light, 2).0, 0.0);
    light.set_scene_extent(&Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 2.0, 10.0) }.into());
    let (emitted, _) = flux(&light, 10_000);
    assert!(emitted > 0.0 && emitted < light.power().mean());
}
