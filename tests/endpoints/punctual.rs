//! Lights without area: point, directional and spot.

use crate::{Random, assert_mean, estimate, flux, irradiance, origin_up};
use approx::assert_relative_eq;
use pathspace::endpoint::{DirectionalLight, Endpoint, Light, PointLight, SpotLight};
use pathspace::geometry::{Bounds, SurfacePoint};
use pathspace::glam::{DVec2, DVec3};
use pathspace::math::{Rgb, warp};
use std::f64::consts::PI;

#[test]
fn b01_point_light_has_no_variance() {
    let theta = 30f64.to_radians();
    let light =
        PointLight::new(2.0 * DVec3::new(theta.sin(), 0.0, theta.cos()), Rgb::splat(5.0)).unwrap();
    assert_relative_eq!(
        irradiance(&light, &origin_up(), 2).0,
        1.082_531_754_730_548_5,
        max_relative = 1e-14
    );
    assert_mean("point light flux", flux(&light, 100), 20.0 * PI, 1e-12);
}

#[test]
fn b02_directional_light() {
    let theta = 60f64.to_radians();
    let mut light =
        DirectionalLight::new(-DVec3::new(theta.sin(), 0.0, theta.cos()) * 1e-200, Rgb::splat(3.0))
            .unwrap();
    assert!(
        light
            .sample_direction(&light.sample_point(0.0, DVec2::ZERO).unwrap().point, DVec2::ZERO)
            .is_none()
    );
    for scale in [1.0, 1e3] {
        let bounds = Bounds { min: DVec3::splat(-scale), max: DVec3::new(scale, 2.0 * scale, 0.0) };
        light.set_scene_extent(&bounds.into());
        let e = irradiance(&light, &origin_up(), 2).0;
        assert_relative_eq!(0.5 / PI * e, 0.238_732_414_637_843, max_relative = 1e-14);
        // By emission: flux through a patch of the plane, per area.
        let mut rng = Random::new(5);
        let patch = estimate(400_000, || {
            let p = light.sample_point(0.0, DVec2::ZERO).unwrap().point;
            let d = light.sample_direction(&p, rng.next_2d()).unwrap();
            let hit = d.from.position - d.direction * (d.from.position.z / d.direction.z);
            if hit.x.abs() < 0.5 * scale && hit.y.abs() < 0.5 * scale {
                d.weight.mean() / (scale * scale)
            } else {
                0.0
            }
        });
        assert_mean("B02 by emission", patch, 1.5, 0.01);
        assert_mean("directional flux", flux(&light, 100), light.power().mean(), 1e-12);
    }
}

#[test]
fn spot_directions_follow_the_intensity() {
    let light = SpotLight::new(DVec3::ZERO, DVec3::Z, Rgb::splat(1.0), 20.0, 40.0).unwrap();
    check_spot_directions(&light);
    check_spot_directions(&light.with_squared_falloff());
}

fn check_spot_directions(light: &SpotLight) {
    let (p, mut rng) = (SurfacePoint::dirac(DVec3::ZERO), Random::new(10));
    let edge = 1.0 - 40f64.to_radians().cos();
    let (bins, n, fine) = (40usize, 1_000_000, 200);
    let mut counts = vec![0.0; bins];
    for _ in 0..n {
        let d = light.sample_direction(&p, rng.next_2d()).unwrap();
        counts[(((1.0 - d.direction.z) / edge * bins as f64) as usize).min(bins - 1)] += 1.0;
    }
    let mut chi2 = 0.0;
    for (bin, count) in counts.iter().enumerate() {
        let width = edge / (bins * fine) as f64;
        let mass: f64 = (0..fine)
            .map(|i| {
                let w = warp::direction_from_one_minus_cosine(
                    ((bin * fine + i) as f64 + 0.5) * width,
                    0.1,
                );
                light.direction_pdf(&p, w).value() * 2.0 * PI * width
            })
            .sum();
        chi2 += (count - mass * f64::from(n)).powi(2) / (mass * f64::from(n));
    }
    // 39 degrees of freedom: mean 39, standard deviation 8.8.
    assert!(chi2 < 39.0 + 4.0 * 8.8, "{chi2}");
}

/// The intensity falls off linearly in the angle; what is sampled integrates to the power in closed
/// form.
#[test]
fn spots_with_linear_falloff() {
    for (inner, outer) in [(20.0, 40.0), (0.0, 60.0), (30.0, 30.0), (29.999, 30.0)] {
        let light = SpotLight::new(DVec3::ZERO, DVec3::Z, Rgb::splat(1.0), inner, outer)
            .unwrap()
            .with_linear_falloff();
        let (p, mut rng) = (SurfacePoint::dirac(DVec3::ZERO), Random::new(12));
        let at = |degrees: f64| {
            light
                .emit(&p, DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()))
                .r()
        };
        assert_relative_eq!(
            at(0.5 * (inner + outer)),
            if inner == outer { at(inner) } else { 0.5 },
            epsilon = 1e-6
        );
        let n = 4_000;
        let step = outer.to_radians() / f64::from(n);
        let integral: f64 = (0..n)
            .map(|i| (f64::from(i) + 0.5) * step)
            .map(|t| 2.0 * PI * t.sin() * at(t.to_degrees()) * step)
            .sum();
        assert_relative_eq!(light.power().r(), integral, max_relative = 1e-4);
        let sample = || {
            let sample = light.sample_direction(&p, rng.next_2d()).expect("a direction");
            assert_relative_eq!(
                light.direction_pdf(&p, sample.direction).value(),
                sample.pdf.value()
            );
            sample.weight.r()
        };
        assert_mean("linear spot", estimate(200_000, sample), light.power().r(), 0.004);
    }
}
