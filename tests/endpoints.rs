//! Lights and cameras against exact answers: next event estimation, emission, importance. Seeds are
//! fixed; a mean must lie within four of its standard errors, and the standard error must be below
//! the stated fraction of the value.

#[path = "endpoints/area.rs"]
mod area;
#[path = "endpoints/cameras.rs"]
mod cameras;
#[path = "endpoints/environments.rs"]
mod environments;
#[path = "endpoints/near.rs"]
mod near;
#[path = "endpoints/punctual.rs"]
mod punctual;

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
    assert!(
        (mean - expected).abs() <= 4.0 * error + 1e-12 * expected.abs(),
        "{name}: {mean} ± {error}, expected {expected}"
    );
    assert!(
        error <= largest_relative_error * expected.abs(),
        "{name}: standard error {error} too large"
    );
}

fn receiver(position: DVec3, normal: DVec3) -> SurfacePoint {
    SurfacePoint::on_surface(position, 0.0, normal)
}

/// One sample of the irradiance at a receiver, visibility ignored. Checks sample against density on
/// the way.
fn irradiance_sample(light: &dyn Light, x: &SurfacePoint, rng: &mut Random) -> f64 {
    let Some(sample) = light.sample_from(x, rng.next(), rng.next_2d()) else {
        return 0.0;
    };
    let y = sample.point;
    assert_eq!(light.pdf_from(x, &y), sample.pdf);
    let to_light = if y.place == Place::Infinite {
        -y.geometric_normal
    } else {
        (y.position - x.position).normalize()
    };
    let r2 =
        if y.place == Place::Infinite { 1.0 } else { (y.position - x.position).length_squared() };
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
        assert_relative_eq!(
            d.weight.mean(),
            (emitted / d.pdf.value()).mean(),
            max_relative = 1e-12
        );
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
    AreaLight::new(
        vec![Shape::Sphere(Sphere::new(center, radius))],
        0,
        0,
        Rgb::splat(radiance),
        false,
    )
    .unwrap()
}

#[test]
fn emission_carries_the_power() {
    let quad =
        Quad { origin: DVec3::ONE, edge_u: DVec3::X * 3.0, edge_v: DVec3::new(1.0, 2.0, 0.5) };
    let disk = Disk { center: DVec3::ZERO, normal: DVec3::Z, radius: 0.25 };
    let shapes =
        vec![Shape::Quad(quad), Shape::Disk(disk), Shape::Sphere(Sphere::new(DVec3::ZERO, 0.5))];
    for two_sided in [false, true] {
        let light =
            AreaLight::new(shapes.clone(), 10, 1, Rgb::new(1.0, 2.0, 3.0), two_sided).unwrap();
        let sides = if two_sided { 2.0 } else { 1.0 };
        assert_relative_eq!(
            light.power().mean(),
            2.0 * PI * light.area() * sides,
            max_relative = 1e-14
        );
        assert_mean("area flux", flux(&light, 10_000), light.power().mean(), 1e-12);
        let mut counts = [0u32; 3];
        let mut rng = Random::new(9);
        for _ in 0..100_000 {
            counts[light.sample_point(rng.next(), rng.next_2d()).unwrap().point.primitive
                as usize
                - 10] += 1;
        }
        for (count, shape) in counts.iter().zip(&shapes) {
            let p = shape.area() / light.area();
            assert!((f64::from(*count) / 1e5 - p).abs() < 4.0 * (p * (1.0 - p) / 1e5).sqrt());
        }
    }
    let cones = [(0.0, 30.0), (20.0, 25.0), (40.0, 40.0), (1e-3, 2e-3), (0.0, 180.0)];
    for ((inner, outer), squared) in
        cones.into_iter().flat_map(|cone| [(cone, false), (cone, true)])
    {
        let light =
            SpotLight::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), Rgb::splat(2.0), inner, outer)
                .unwrap();
        let light = if squared { light.with_squared_falloff() } else { light };
        assert_mean("spot flux", flux(&light, 10_000), light.power().mean(), 1e-6);
        // Power by quadrature of the emitted intensity in v = 1 - cos θ.
        let frame = Frame::from_normal(DVec3::new(1.0, 2.0, 3.0).normalize());
        let v_max = 2.0 * (0.5 * outer.to_radians()).sin().powi(2);
        let (n, p) = (20_000, SurfacePoint::dirac(DVec3::ONE));
        let sum: f64 = (0..n)
            .map(|i| {
                let w = frame.to_world(warp::direction_from_one_minus_cosine(
                    v_max * (f64::from(i) + 0.5) / f64::from(n),
                    0.3,
                ));
                light.emit(&p, w).mean()
            })
            .sum();
        assert_relative_eq!(
            2.0 * PI * v_max * sum / f64::from(n),
            light.power().mean(),
            max_relative = 2e-4
        );
    }
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
        PinholeCamera::new(o, z, y, 40.0, r)
            .unwrap()
            .with_window(UVec2::ZERO, UVec2::new(4, 5))
            .err(),
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
        AreaLight::new(
            vec![Shape::Triangle(Triangle { vertices: [o, z, z] })],
            0,
            0,
            Rgb::WHITE,
            false,
        )
        .err(),
        AreaLight::new(vec![Shape::Sphere(Sphere::new(o, -1.0))], 0, 0, Rgb::WHITE, false).err(),
        AreaLight::new(vec![Shape::Sphere(Sphere::new(o, 1.0))], u32::MAX, 0, Rgb::WHITE, false)
            .err(),
        AreaLight::new(
            vec![Shape::Sphere(Sphere::new(o, 1.0))],
            0,
            0,
            Rgb::new(1.0, f64::INFINITY, 0.0),
            false,
        )
        .err(),
    ]
    .into_iter()
    .map(|error| error.expect("must be refused").to_string())
    .collect();
    assert!(
        refused
            .iter()
            .all(|message| message.contains(": ") && message.starts_with(char::is_lowercase))
    );
    assert_eq!(refused[0], "pinhole camera: its position and its target are the same");
}
