//! Lights and cameras against exact answers: emitter sampling, emission, importance. Seeds are fixed; a mean must lie within four of
//! its standard errors, and the standard error must be below the stated fraction of the value.

use approx::{assert_abs_diff_eq, assert_relative_eq};
use pathspace::endpoint::*;
use pathspace::geometry::*;
use pathspace::glam::{DMat3, DVec2, DVec3, UVec2};
use pathspace::math::{Rgb, warp};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;

struct Random(Pcg64Mcg);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }
    fn next(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 0.5f64.powi(53)
    }
    fn next_2d(&mut self) -> DVec2 {
        DVec2::new(self.next(), self.next())
    }
}

/// Mean and standard error of a random variable.
fn estimate(n: u32, mut sample: impl FnMut() -> f64) -> (f64, f64) {
    let (mut mean, mut m2) = (0.0, 0.0);
    for i in 1..=n {
        let x = sample();
        assert!(x.is_finite(), "{x}");
        let delta = x - mean;
        mean += delta / f64::from(i);
        m2 += delta * (x - mean);
    }
    (mean, (m2 / f64::from(n - 1) / f64::from(n)).sqrt())
}

fn assert_mean(name: &str, (mean, error): (f64, f64), expected: f64, largest_relative_error: f64) {
    println!("{name}: {mean} ± {error}, expected {expected}");
    assert!((mean - expected).abs() <= 4.0 * error + 1e-12 * expected.abs(), "{name}: {mean} ± {error}, expected {expected}");
    assert!(error <= largest_relative_error * expected.abs(), "{name}: standard error {error} too large");
}

fn receiver(position: DVec3, normal: DVec3) -> SurfacePoint {
    SurfacePoint::on_surface(position, 0.0, normal)
}

/// One sample of the irradiance at a receiver, visibility ignored. Checks sample against density on the way.
fn irradiance_sample(light: &dyn Light, x: &SurfacePoint, rng: &mut Random) -> f64 {
    let Some(sample) = light.sample_from(x, rng.next(), rng.next_2d()) else {
        return 0.0;
    };
    let y = sample.point;
    assert_eq!(light.pdf_from(x, &y), sample.pdf);
    let to_light = if y.place == Place::Infinite { -y.geometric_normal } else { (y.position - x.position).normalize() };
    let r2 = if y.place == Place::Infinite { 1.0 } else { (y.position - x.position).length_squared() };
    let g = x.geometric_normal.dot(to_light).max(0.0) * y.cosine(to_light) / r2;
    light.emit(&y, -to_light).mean() * g / sample.pdf.value()
}

fn irradiance(light: &dyn Light, x: &SurfacePoint, n: u32) -> (f64, f64) {
    let mut rng = Random::new(11);
    estimate(n, || irradiance_sample(light, x, &mut rng))
}

/// The emitted flux by sampling point and direction; checks the densities on the way.
fn flux(light: &dyn Light, n: u32) -> (f64, f64) {
    let mut rng = Random::new(12);
    estimate(n, || {
        let Some(p) = light.sample_point(rng.next(), rng.next_2d()) else { return 0.0 };
        assert_eq!(p.pdf, light.point_pdf(&p.point));
        let Some(d) = light.sample_direction(&p.point, rng.next_2d()) else { return 0.0 };
        assert_eq!(d.pdf, light.direction_pdf(&d.from, d.direction));
        assert_abs_diff_eq!(d.direction.length(), 1.0, epsilon = 1e-14);
        let emitted = light.emit(&d.from, d.direction);
        assert_relative_eq!(d.weight.mean(), (emitted / d.pdf.value()).mean(), max_relative = 1e-12);
        d.weight.mean() / p.pdf.value()
    })
}

fn origin_up() -> SurfacePoint {
    receiver(DVec3::ZERO, DVec3::Z)
}

fn area_light(shape: Shape, two_sided: bool) -> AreaLight {
    AreaLight::new(vec![shape], 7, 3, Rgb::WHITE, two_sided).unwrap()
}

fn whole_sphere(center: DVec3, radius: f64, radiance: f64) -> AreaLight {
    AreaLight::new(vec![Shape::Sphere(Sphere::new(center, radius))], 0, 0, Rgb::splat(radiance), false).unwrap()
}

#[test]
fn b01_point_light_has_no_variance() {
    let theta = 30f64.to_radians();
    let light = PointLight::new(2.0 * DVec3::new(theta.sin(), 0.0, theta.cos()), Rgb::splat(5.0)).unwrap();
    assert_relative_eq!(irradiance(&light, &origin_up(), 2).0, 1.082_531_754_730_548_5, max_relative = 1e-14);
    assert_mean("point light flux", flux(&light, 100), 20.0 * PI, 1e-12);
}

#[test]
fn b02_directional_light() {
    let theta = 60f64.to_radians();
    let mut light = DirectionalLight::new(-DVec3::new(theta.sin(), 0.0, theta.cos()) * 1e-200, Rgb::splat(3.0)).unwrap();
    assert!(light.sample_direction(&light.sample_point(0.0, DVec2::ZERO).unwrap().point, DVec2::ZERO).is_none());
    for scale in [1.0, 1e3] {
        let bounds = Bounds { min: DVec3::splat(-scale), max: DVec3::new(scale, 2.0 * scale, 0.0) };
        light.set_scene_bounds(&bounds);
        let e = irradiance(&light, &origin_up(), 2).0;
        assert_relative_eq!(0.5 / PI * e, 0.238_732_414_637_843, max_relative = 1e-14);
        // By emission: flux through a patch of the plane, per area.
        let mut rng = Random::new(5);
        let patch = estimate(400_000, || {
            let p = light.sample_point(0.0, DVec2::ZERO).unwrap().point;
            let d = light.sample_direction(&p, rng.next_2d()).unwrap();
            let hit = d.from.position - d.direction * (d.from.position.z / d.direction.z);
            if hit.x.abs() < 0.5 * scale && hit.y.abs() < 0.5 * scale { d.weight.mean() / (scale * scale) } else { 0.0 }
        });
        assert_mean("B02 by emission", patch, 1.5, 0.01);
        assert_mean("directional flux", flux(&light, 100), light.power().mean(), 1e-12);
    }
}

/// A fine map of a radiance given by direction, up axis +Z.
fn map_of(height: u32, lookup: Lookup, radiance: impl Fn(DVec3) -> f64) -> EnvironmentMap {
    let width = 2 * height;
    let step = PI / f64::from(height);
    let mut pixels = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let (theta, phi) = ((f64::from(row) + 0.5) * step, (f64::from(column) + 0.5) * step);
            pixels.push(Rgb::splat(radiance(DVec3::new(theta.sin() * phi.sin(), theta.sin() * phi.cos(), theta.cos()))));
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
            // The map itself is off by its discretisation, by n (π/512)² / 12 = 3e-4 for the narrowest lobe, linearly interpolated.
            let light = map_of(if n == 0 { 8 } else { 512 }, lookup, |w| w.z.max(0.0).powi(n));
            let (e, error) = irradiance(&light, &origin_up(), if n == 0 { 2_000_000 } else { 200_000 });
            println!("B03 {lookup:?} n = {n}: {} ± {}", e / PI, error / PI);
            assert!(error < 1e-3 * e);
            assert!((e / PI - expected).abs() < 4.0 * error / PI + 4e-4 * expected, "n = {n}: {}", e / PI);
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
fn b06_to_b11_polygons_and_disks() {
    let square = Quad { origin: DVec3::new(-1.0, -1.0, 2.0), edge_u: DVec3::Y * 2.0, edge_v: DVec3::X * 2.0 };
    assert_mean("B06", irradiance(&area_light(Shape::Quad(square), false), &origin_up(), 400_000), 0.752_274_688_454_107_5, 1e-3);
    let [a, b, c, d] = [DVec3::ZERO, square.edge_u, square.edge_u + square.edge_v, square.edge_v].map(|e| square.origin + e);
    let triangles = [[a, b, c], [a, c, d], [a, a, d]].map(|vertices| Shape::Triangle(Triangle { vertices }));
    let pair = AreaLight::new(triangles.to_vec(), 0, 0, Rgb::WHITE, false).unwrap();
    assert_mean("B06 as triangles", irradiance(&pair, &origin_up(), 400_000), 0.752_274_688_454_107_5, 1e-3);

    let vertices = [DVec3::new(0.2, 0.1, 0.6), DVec3::new(1.4, 0.3, 1.1), DVec3::new(0.3, 1.2, 1.7)];
    let triangle = area_light(Shape::Triangle(Triangle { vertices }), true);
    let x = receiver(DVec3::ZERO, DVec3::new(0.36, -0.48, 0.8));
    assert_mean("B07", irradiance(&triangle, &x, 2_000_000), 0.093_479_235_265_640_06, 1e-3);

    let disk = Disk { center: 2.0 * DVec3::Z, normal: -DVec3::Z, radius: 1.0 };
    assert_mean("B11", irradiance(&area_light(Shape::Disk(disk), false), &origin_up(), 400_000), 0.628_318_530_717_958_6, 1e-3);
}

#[test]
fn b09_sphere_light() {
    let theta = 30f64.to_radians();
    let light = whole_sphere(3.0 * DVec3::new(theta.sin(), 0.0, theta.cos()), 1.0, 1.0);
    assert_mean("B09", irradiance(&light, &origin_up(), 1_000_000), 0.302_299_894_039_036_3, 1e-3);
    // Mirrored scene, same numbers: nothing depends on handedness.
    let mirrored = whole_sphere(3.0 * DVec3::new(-theta.sin(), 0.0, theta.cos()), 1.0, 1.0);
    assert_mean("B09 mirrored", irradiance(&mirrored, &origin_up(), 1_000_000), 0.302_299_894_039_036_3, 1e-3);
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
                assert!((e - expected).abs() < 4.0 * error + 1e-9, "{ratio} {distance}: {e} ± {error}");
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
        assert!((e - PI / (1.0 + height).powi(2)).abs() < 4.0 * error + tolerance, "height {height}: {e} ± {error}");
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
        // The receiver looks away from the sphere, or is inside of one that emits outwards only: nothing arrives.
        for _ in 0..10_000 {
            assert!(irradiance_sample(&light, &x, &mut rng) < 1e-7);
        }
    }
    // Inside of an inward sphere, and of a two-sided one, E = π whatever the position; near its wall the variance grows.
    let inward = area_light(Shape::Sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }), false);
    let both = area_light(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), true);
    for light in [&inward, &both] {
        let x = receiver(DVec3::new(0.2, -0.1, 0.3), DVec3::new(0.36, -0.48, 0.8));
        assert_mean("inside a sphere", irradiance(light, &x, 2_000_000), PI, 2e-3);
    }
}

#[test]
fn masked_spheres_sample_their_zone() {
    let zone = Sphere { cos_min: 0.5, axis: DVec3::X, ..Sphere::new(DVec3::new(1.0, 2.0, 3.0), 2.0) };
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

#[test]
fn emission_carries_the_power() {
    let quad = Quad { origin: DVec3::ONE, edge_u: DVec3::X * 3.0, edge_v: DVec3::new(1.0, 2.0, 0.5) };
    let disk = Disk { center: DVec3::ZERO, normal: DVec3::Z, radius: 0.25 };
    let shapes = vec![Shape::Quad(quad), Shape::Disk(disk), Shape::Sphere(Sphere::new(DVec3::ZERO, 0.5))];
    for two_sided in [false, true] {
        let light = AreaLight::new(shapes.clone(), 10, 1, Rgb::new(1.0, 2.0, 3.0), two_sided).unwrap();
        let sides = if two_sided { 2.0 } else { 1.0 };
        assert_relative_eq!(light.power().mean(), 2.0 * PI * light.area() * sides, max_relative = 1e-14);
        assert_mean("area flux", flux(&light, 10_000), light.power().mean(), 1e-12);
        let mut counts = [0u32; 3];
        let mut rng = Random::new(9);
        for _ in 0..100_000 {
            counts[light.sample_point(rng.next(), rng.next_2d()).unwrap().point.primitive as usize - 10] += 1;
        }
        for (count, shape) in counts.iter().zip(&shapes) {
            let p = shape.area() / light.area();
            assert!((f64::from(*count) / 1e5 - p).abs() < 4.0 * (p * (1.0 - p) / 1e5).sqrt());
        }
    }
    let cones = [(0.0, 30.0), (20.0, 25.0), (40.0, 40.0), (1e-3, 2e-3), (0.0, 180.0)];
    for ((inner, outer), squared) in cones.into_iter().flat_map(|cone| [(cone, false), (cone, true)]) {
        let light = SpotLight::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), Rgb::splat(2.0), inner, outer).unwrap();
        let light = if squared { light.with_squared_falloff() } else { light };
        assert_mean("spot flux", flux(&light, 10_000), light.power().mean(), 1e-6);
        // Power by quadrature of the emitted intensity in v = 1 - cos θ.
        let frame = Frame::from_normal(DVec3::new(1.0, 2.0, 3.0).normalize());
        let v_max = 2.0 * (0.5 * outer.to_radians()).sin().powi(2);
        let (n, p) = (20_000, SurfacePoint::dirac(DVec3::ONE));
        let sum: f64 = (0..n)
            .map(|i| {
                let w = frame.to_world(warp::direction_from_one_minus_cosine(v_max * (f64::from(i) + 0.5) / f64::from(n), 0.3));
                light.emit(&p, w).mean()
            })
            .sum();
        assert_relative_eq!(2.0 * PI * v_max * sum / f64::from(n), light.power().mean(), max_relative = 2e-4);
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
                let w = warp::direction_from_one_minus_cosine(((bin * fine + i) as f64 + 0.5) * width, 0.1);
                light.direction_pdf(&p, w).value() * 2.0 * PI * width
            })
            .sum();
        chi2 += (count - mass * f64::from(n)).powi(2) / (mass * f64::from(n));
    }
    // 39 degrees of freedom: mean 39, standard deviation 8.8.
    assert!(chi2 < 39.0 + 4.0 * 8.8, "{chi2}");
}

/// The intensity falls off linearly in the angle; what is sampled integrates to the power in closed form.
#[test]
fn spots_with_linear_falloff() {
    for (inner, outer) in [(20.0, 40.0), (0.0, 60.0), (30.0, 30.0), (29.999, 30.0)] {
        let light = SpotLight::new(DVec3::ZERO, DVec3::Z, Rgb::splat(1.0), inner, outer).unwrap().with_linear_falloff();
        let (p, mut rng) = (SurfacePoint::dirac(DVec3::ZERO), Random::new(12));
        let at = |degrees: f64| light.emit(&p, DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos())).r();
        assert_relative_eq!(at(0.5 * (inner + outer)), if inner == outer { at(inner) } else { 0.5 }, epsilon = 1e-6);
        let n = 4_000;
        let step = outer.to_radians() / f64::from(n);
        let integral: f64 = (0..n).map(|i| (f64::from(i) + 0.5) * step).map(|t| 2.0 * PI * t.sin() * at(t.to_degrees()) * step).sum();
        assert_relative_eq!(light.power().r(), integral, max_relative = 1e-4);
        let sample = || {
            let sample = light.sample_direction(&p, rng.next_2d()).expect("a direction");
            assert_relative_eq!(light.direction_pdf(&p, sample.direction).value(), sample.pdf.value());
            sample.weight.r()
        };
        assert_mean("linear spot", estimate(200_000, sample), light.power().r(), 0.004);
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
    light.set_scene_bounds(&Bounds { min: -DVec3::ONE, max: DVec3::new(1.0, 1.0, 0.0) });
    // The flux through the tight disk is less than the power, which counts the whole sphere around the scene.
    let (emitted, _) = flux(&light, 10_000);
    assert!(emitted > 0.0 && emitted <= light.power().mean());
    // By emission: flux through the square |x|, |y| < 1 in the plane z = 0.
    let through = estimate(400_000, || {
        let p = light.sample_point(0.0, rng.next_2d()).unwrap();
        let d = light.sample_direction(&p.point, rng.next_2d()).unwrap();
        let hit = d.from.position - d.direction * (d.from.position.z / d.direction.z);
        if hit.x.abs() < 1.0 && hit.y.abs() < 1.0 { d.weight.mean() / p.pdf.value() / 4.0 } else { 0.0 }
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
            let w = EnvironmentMap::Z_UP * DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
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
        .map(|i| if i / width == 0 || i / width == 3 || i % width == 4 { Rgb::BLACK } else { Rgb::splat(10f64.powf(6.0 * rng.next())) })
        .collect();
    for rotation in [rotation, DMat3::IDENTITY, DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))] {
        for lookup in [Lookup::PiecewiseConstant, Lookup::Bilinear] {
            let map = EnvironmentMap::new(width, height, pixels.clone(), rotation).unwrap().with_lookup(lookup);
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
            let octant = |w: DVec3| usize::from(w.x > 0.0) + 2 * usize::from(w.y > 0.0) + 4 * usize::from(w.z > 0.0);
            let (mut counts, mut masses) = ([0.0f64; 8], [0.0f64; 8]);
            let mut total = Rgb::BLACK;
            for _ in 0..n {
                let s = map.sample_point(rng.next(), rng.next_2d()).unwrap();
                assert_eq!(s.pdf, map.point_pdf(&s.point));
                let radiance = map.emit(&s.point, s.point.geometric_normal);
                assert!(lookup == Lookup::Bilinear || !radiance.is_black());
                total += radiance / s.pdf.value() / f64::from(n);
                counts[octant(s.point.geometric_normal)] += 1.0 / f64::from(n);
            }
            let grid = 600;
            for i in 0..grid * grid {
                let u = DVec2::new(f64::from(i % grid) + 0.5, f64::from(i / grid) + 0.5) / f64::from(grid);
                let w = warp::square_to_sphere(u);
                masses[octant(w)] += map.point_pdf(&SurfacePoint::infinite(DVec3::ZERO, w)).value() * 4.0 * PI / f64::from(grid * grid);
            }
            for (count, mass) in counts.iter().zip(&masses) {
                assert!((count - mass).abs() < 4.0 * (mass * (1.0 - mass) / f64::from(n)).sqrt() + 3e-3, "{count} {mass}");
            }
            if lookup == Lookup::PiecewiseConstant {
                // Every sample estimates the same integral.
                let s = map.sample_point(0.0, DVec2::splat(0.3)).unwrap();
                let one = map.emit(&s.point, s.point.geometric_normal).mean() / s.pdf.value();
                assert_relative_eq!(total.mean(), one, max_relative = 1e-9);
            }
        }
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
    for lookup in [Lookup::PiecewiseConstant, Lookup::Bilinear] {
        let map = map.clone().with_lookup(lookup);
        for w in [DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::X] {
            assert!(map.radiance(w).is_finite() && map.point_pdf(&SurfacePoint::infinite(DVec3::ZERO, -w)).value() > 0.0);
        }
        for u in [DVec2::ZERO, DVec2::ONE, DVec2::splat(1.0 - 0.5 * f64::EPSILON), DVec2::NAN] {
            assert!(map.sample_point(0.0, u).is_some_and(|s| s.pdf.value().is_finite()));
        }
    }
    let black = EnvironmentMap::new(4, 2, vec![Rgb::BLACK; 8], DMat3::IDENTITY).unwrap();
    assert!(black.sample_point(0.5, DVec2::splat(0.5)).is_none() && black.power().is_black());
}

#[test]
fn constant_environment() {
    let mut light = ConstantEnvironment::new(Rgb::splat(2.0)).unwrap();
    assert_mean("constant environment", irradiance(&light, &origin_up(), 2_000_000), 2.0 * PI, 1e-3);
    assert_eq!(flux(&light, 2).0, 0.0);
    light.set_scene_bounds(&Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 2.0, 10.0) });
    let (emitted, _) = flux(&light, 10_000);
    assert!(emitted > 0.0 && emitted < light.power().mean());
}

fn cameras(resolution: UVec2, window: Option<(UVec2, UVec2)>) -> Vec<Box<dyn Camera>> {
    let [position, target, up] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-2.0, 0.5, 1.0), DVec3::new(0.1, 0.2, 5.0)];
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
                assert_relative_eq!(camera.emit(&d.from, d.direction).mean(), d.weight.mean() * d.pdf.value(), max_relative = 1e-14);
                // A receiver along the ray, connected to the same point, projects to the same place.
                let x = receiver(d.from.position + d.direction * 4.0, -d.direction);
                let y = camera.facing(&p.point, &x);
                let towards = (x.position - y.position).normalize();
                let again = camera.film().to_window(camera.raster(&y, towards).unwrap());
                assert_abs_diff_eq!(again, u, epsilon = 1e-10);
                // Behind the camera nothing is recorded.
                let behind = receiver(d.from.position - d.direction * 4.0, d.direction);
                let connected = camera.sample_from(&behind, 0.5, rng.next_2d());
                let seen = connected.and_then(|s| camera.raster(&s.point, (behind.position - s.point.position).normalize()));
                assert!(seen.is_none());
            }
        }
    }
}

#[test]
fn image_axes_point_right_and_down() {
    let camera = PinholeCamera::new(DVec3::ZERO, -DVec3::Z, DVec3::Y, 90.0, UVec2::new(100, 100)).unwrap();
    let at = |w: DVec3| camera.raster(&SurfacePoint::dirac(DVec3::ZERO), w.normalize()).unwrap();
    assert_abs_diff_eq!(at(DVec3::new(1.0, 0.0, -1.0)), DVec2::new(100.0, 50.0), epsilon = 1e-12);
    assert_abs_diff_eq!(at(DVec3::new(0.0, 1.0, -1.0)), DVec2::new(50.0, 0.0), epsilon = 1e-12);
}

#[test]
fn e01_pinhole_importance() {
    let camera = PinholeCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0, UVec2::new(64, 64)).unwrap();
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
            let plane = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n) * 2.0 - 1.0;
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
    let camera = ThinLensCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0, 0.1, 2.0, film).unwrap();
    let lens = camera.sample_point(0.5, DVec2::splat(0.3)).unwrap().point;
    assert_eq!((lens.place, lens.geometric_normal), (Place::Area, DVec3::Z));
    assert_relative_eq!(camera.emit(&lens, DVec3::Z).mean(), 7.957_747_154_594_767, max_relative = 1e-14);
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
    // A rectangle facing the camera fills (0.5/2)(0.4/2) of the film plane; counted from the camera and by connecting the light.
    let camera = PinholeCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 60.0, UVec2::new(32, 32)).unwrap();
    let quad = Quad { origin: DVec3::new(-0.25, -0.2, 2.0), edge_u: DVec3::Y * 0.4, edge_v: DVec3::X * 0.5 };
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
    let camera = OrthographicCamera::new(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, 2.0, UVec2::new(20, 10)).unwrap();
    let p = camera.sample_point(0.0, DVec2::ZERO).unwrap();
    assert_eq!((p.point.place, p.point.geometric_normal, p.pdf.value()), (Place::Infinite, -DVec3::Z, 1.0));
    // The film is 4 by 2 world units.
    assert_relative_eq!(camera.direction_pdf(&p.point, -DVec3::Z).value(), 1.0 / 8.0, max_relative = 1e-15);
    let x = camera.facing(&p.point, &receiver(DVec3::new(2.0, 1.0, -3.0), DVec3::Z));
    assert_eq!(x.position, DVec3::new(2.0, 1.0, 5.0));
    assert_abs_diff_eq!(camera.raster(&x, -DVec3::Z).unwrap(), DVec2::new(20.0, 0.0), epsilon = 1e-12);
}

#[test]
fn constructors_refuse_what_makes_no_sense() {
    let r = UVec2::new(4, 4);
    let [o, z, y] = [DVec3::ZERO, DVec3::Z, DVec3::Y];
    let refused: Vec<String> = [
        PinholeCamera::new(z, z, y, 40.0, r).err(),
        PinholeCamera::new(o, z, z, 40.0, r).err(),
        PinholeCamera::new(o, z, o, 40.0, r).err(),
        PinholeCamera::new(o, z, y, 0.0, r).err(),
        PinholeCamera::new(o, z, y, 180.0, r).err(),
        PinholeCamera::new(o, z, y, f64::NAN, r).err(),
        PinholeCamera::new(DVec3::NAN, z, y, 40.0, r).err(),
        PinholeCamera::new(o, DVec3::INFINITY, y, 40.0, r).err(),
        PinholeCamera::new(o, z, y, 40.0, UVec2::new(0, 4)).err(),
        PinholeCamera::new(o, z, y, 40.0, UVec2::splat(1 << 17)).err(),
        PinholeCamera::new(o, z, y, 40.0, r).unwrap().with_window(UVec2::ZERO, UVec2::new(4, 5)).err(),
        PinholeCamera::new(o, z, y, 40.0, r).unwrap().with_window(UVec2::ONE, UVec2::ONE).err(),
        ThinLensCamera::new(o, z, y, 40.0, 0.0, 1.0, r).err(),
        ThinLensCamera::new(o, z, y, 40.0, 0.1, -1.0, r).err(),
        OrthographicCamera::new(o, z, y, 0.0, r).err(),
        PointLight::new(o, Rgb::splat(-1.0)).err(),
        PointLight::new(DVec3::NAN, Rgb::WHITE).err(),
        SpotLight::new(o, o, Rgb::WHITE, 10.0, 20.0).err(),
        SpotLight::new(o, z, Rgb::WHITE, 30.0, 20.0).err(),
        SpotLight::new(o, z, Rgb::WHITE, 0.0, 0.0).err(),
        DirectionalLight::new(o, Rgb::WHITE).err(),
        ConstantEnvironment::new(Rgb::splat(f64::NAN)).err(),
        EnvironmentMap::new(2, 2, vec![Rgb::WHITE; 3], DMat3::IDENTITY).err(),
        EnvironmentMap::new(0, 0, vec![], DMat3::IDENTITY).err(),
        EnvironmentMap::new(1, 1, vec![Rgb::splat(-1.0)], DMat3::IDENTITY).err(),
        EnvironmentMap::new(1, 1, vec![Rgb::WHITE], DMat3::IDENTITY * 2.0).err(),
        EnvironmentMap::new(1, 1, vec![Rgb::WHITE], DMat3::NAN).err(),
        AreaLight::new(vec![], 0, 0, Rgb::WHITE, false).err(),
        AreaLight::new(vec![Shape::Triangle(Triangle { vertices: [o, z, z] })], 0, 0, Rgb::WHITE, false).err(),
        AreaLight::new(vec![Shape::Sphere(Sphere::new(o, -1.0))], 0, 0, Rgb::WHITE, false).err(),
        AreaLight::new(vec![Shape::Sphere(Sphere::new(o, 1.0))], u32::MAX, 0, Rgb::WHITE, false).err(),
        AreaLight::new(vec![Shape::Sphere(Sphere::new(o, 1.0))], 0, 0, Rgb::new(1.0, f64::INFINITY, 0.0), false).err(),
    ]
    .into_iter()
    .map(|error| error.expect("must be refused").to_string())
    .collect();
    assert!(refused.iter().all(|message| message.contains(": ") && message.starts_with(char::is_lowercase)));
    assert_eq!(refused[0], "pinhole camera: its position and its target are the same");
}
