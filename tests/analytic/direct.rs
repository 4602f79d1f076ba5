//! B and D: one light and one surface, or two.

use crate::entry::{Entry, RARE};
use crate::measure::Method::{self, Bidirectional, Emission, Light, Path, UniformArea};
use crate::scenes::{
    Stage, camera, cube, footprint, lambert, mean_over_square, polygon_irradiance,
    sphere_irradiance, square_light,
};
use pathspace::endpoint::{
    self, ConstantEnvironment, DirectionalLight, EnvironmentMap, OrthographicCamera, PointLight,
};
use pathspace::endpoint::{DirectionSample, Endpoint, PointSample, SceneExtent};
use pathspace::geometry::{Frame, Quad, Sphere, SurfacePoint};
use pathspace::glam::{DAffine3, DVec2, DVec3, UVec2};
use pathspace::integrator::Depth;
use pathspace::math::warp::{square_to_disk, square_to_sphere};
use pathspace::math::{PerArea, PerProjected, Rgb};
use pathspace::scene::{Material, Mesh};
use std::f64::consts::PI;

const ONE: Depth = Depth::exactly(1);
const POINT: [Method; 4] = [Emission, Path, UniformArea, Bidirectional];
const FROM_INFINITY: [Method; 3] = [Emission, Path, Bidirectional];
/// Most light walks miss the little that is looked at.
const LIGHT_RAYS: u64 = 6_000_000;

fn eye(half: f64) -> pathspace::endpoint::PinholeCamera {
    footprint(DVec3::ZERO, 1.0, half)
}

#[test]
fn b01_point_light() {
    let position = 2.0 * DVec3::new(0.5, 0.0, 0.75f64.sqrt());
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(0.5));
    stage.light(PointLight::new(position, Rgb::splat(5.0)).expect("valid"));
    let world = stage.build();
    let narrow = eye(1e-6);
    let entry = Entry::new("B01", &world, &narrow, ONE).within(1e-6, 100_000);
    entry.check(&[Path, Bidirectional], "L");
    entry.check_blind(&[Emission, UniformArea]);
    let mean = mean_over_square(0.5, |x, y| {
        let d = position - DVec3::new(x, y, 0.0);
        0.5 / PI * 5.0 * d.z / d.length().powi(3)
    });
    Entry::new("B01", &world, &eye(0.5), ONE).within(RARE, LIGHT_RAYS).check_value(
        &[Light],
        "mean",
        mean,
    );
}

#[test]
fn b02_directional_light() {
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(0.5));
    stage.light(
        DirectionalLight::new(DVec3::new(0.75f64.sqrt(), 0.0, -0.5), Rgb::splat(3.0))
            .expect("valid"),
    );
    let (world, eye) = (stage.build(), eye(0.5));
    Entry::new("B02", &world, &eye, ONE).within(1e-6, 100_000).check(&[Path], "");
    Entry::new("B02", &world, &eye, ONE)
        .within(RARE, LIGHT_RAYS)
        .check(&[Light, Bidirectional], "");
}

type Radiance = fn(f64) -> f64;

/// A sky whose radiance depends on the angle from an axis: a light of the user's own.
struct Sky {
    axis: DVec3,
    radiance: Radiance,
    /// Directions are drawn in proportion to this power of the cosine, or uniformly.
    power: Option<f64>,
    center: DVec3,
    radius: f64,
}

impl Sky {
    fn new(axis: DVec3, power: Option<f64>, radiance: Radiance) -> Self {
        Self { axis, radiance, power, center: DVec3::ZERO, radius: 0.0 }
    }

    fn cosine(&self, point: &SurfacePoint) -> f64 {
        -point.geometric_normal.dot(self.axis)
    }
}

impl Endpoint for Sky {
    fn sample_point(&self, _: f64, u: DVec2) -> Option<PointSample> {
        let towards = self.power.map_or_else(
            || square_to_sphere(u),
            |power| {
                let z = (1.0 - u.x).powf(1.0 / (power + 1.0));
                let (sin, cos) = (2.0 * PI * u.y).sin_cos();
                Frame::from_normal(self.axis)
                    .to_world((1.0 - z * z).sqrt() * DVec3::new(cos, sin, 0.0) + DVec3::Z * z)
            },
        );
        let point = SurfacePoint::infinite(DVec3::ZERO, -towards);
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }
    fn point_pdf(&self, point: &SurfacePoint) -> PerArea {
        let z = self.cosine(point);
        PerArea(self.power.map_or(0.25 / PI, |power| {
            if z > 0.0 { (power + 1.0) / (2.0 * PI) * z.powf(power) } else { 0.0 }
        }))
    }
    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction = point.geometric_normal;
        let frame = Frame::from_normal(direction);
        let p = square_to_disk(u) * self.radius;
        let from = SurfacePoint {
            position: self.center + frame.x * p.x + frame.y * p.y
                - direction * (1.01 * self.radius),
            ..*point
        };
        let pdf = self.direction_pdf(point, direction);
        Some(DirectionSample {
            from,
            direction,
            pdf,
            weight: self.emit(point, direction) / pdf.value(),
        })
    }
    fn direction_pdf(&self, _: &SurfacePoint, _: DVec3) -> PerProjected {
        PerProjected(1.0 / (PI * self.radius * self.radius))
    }
    fn emit(&self, point: &SurfacePoint, _: DVec3) -> Rgb {
        Rgb::splat((self.radiance)(self.cosine(point)))
    }
    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        let distance = 1.01 * (receiver.position.distance(self.center) + self.radius);
        SurfacePoint { position: receiver.position - point.geometric_normal * distance, ..*point }
    }
}

impl endpoint::Light for Sky {
    fn power(&self) -> Rgb {
        Rgb::splat(1.0)
    }
    fn can_be_hit(&self) -> bool {
        true
    }
    fn set_scene_extent(&mut self, extent: &SceneExtent) {
        let bounds = extent.bounds();
        (self.center, self.radius) = (bounds.center(), bounds.radius());
    }
}

#[test]
fn b03_cosine_power_environment() {
    let skies: [(f64, Radiance, &str); 4] = [
        (4.0, |z| z.max(0.0).powi(4), "L_horizontal"),
        (1.0, |z| z.max(0.0), "n=1"),
        (0.0, |z| if z > 0.0 { 1.0 } else { 0.0 }, "n=0"),
        (100.0, |z| z.max(0.0).powi(100), "n=100"),
    ];
    for (power, radiance, key) in skies {
        let world = |half: f64| {
            let mut stage = Stage::default();
            stage.square(0.0, half, true, lambert(1.0));
            stage.environment(Sky::new(DVec3::Z, Some(power), radiance));
            stage.build()
        };
        let view = camera(DVec3::new(0.0, -0.3, 1.0), DVec3::ZERO, 1.0);
        Entry::new("B03", &world(1e3), &view, ONE)
            .within(RARE, LIGHT_RAYS)
            .check(&FROM_INFINITY, key);
        Entry::new("B03", &world(0.5), &eye(0.5), ONE)
            .within(RARE, LIGHT_RAYS)
            .check(&[Light, Bidirectional], key);
    }
}

#[test]
fn b05_linear_environment() {
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(1.0));
    stage.environment(Sky::new(DVec3::new(0.91f64.sqrt(), 0.0, 0.3), None, |z| 1.0 + 0.5 * z));
    let (world, eye) = (stage.build(), eye(0.5));
    let entry = Entry::new("B05", &world, &eye, ONE).within(RARE, LIGHT_RAYS);
    entry.check_value(&[Emission, Path, Light, Bidirectional], "E/π", entry.expected("") / PI);
}

#[test]
fn b06_square_light() {
    let world = square_light(0.5, DVec3::ZERO, 1.0, 1.0);
    Entry::new("B06", &world, &eye(1e-4), ONE).check(&POINT, "L");
    let lamp =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 2.0));
    let mean = mean_over_square(0.5, |x, y| {
        0.5 / PI * polygon_irradiance(DVec3::new(x, y, 0.0), DVec3::Z, &lamp)
    });
    Entry::new("B06", &world, &eye(0.5), ONE).within(RARE, LIGHT_RAYS).check_value(
        &[Light, Bidirectional],
        "mean",
        mean,
    );
}

/// Turned so that the receiver faces upwards.
#[test]
fn b07_triangle_light() {
    let frame = Frame::from_normal(DVec3::new(0.36, -0.48, 0.8));
    let corners =
        [[0.2, 0.1, 0.6], [1.4, 0.3, 1.1], [0.3, 1.2, 1.7]].map(|v| frame.to_local(DVec3::from(v)));
    let mesh = Mesh { positions: corners.to_vec(), indices: vec![[0, 1, 2]], ..Mesh::default() };
    let mut stage = Stage::default();
    stage.square(0.0, 0.4, true, lambert(1.0));
    let lamp = stage.mesh(&mesh, DAffine3::IDENTITY, Material::Black);
    stage.emit(lamp, Rgb::splat(1.0), true);
    let world = stage.build();
    let narrow = footprint(DVec3::ZERO, 0.2, 1e-5);
    let entry = Entry::new("B07", &world, &narrow, ONE).within(RARE, LIGHT_RAYS);
    entry.check_value(&POINT, "E/π", entry.expected("") / PI);
    let mean = mean_over_square(0.4, |x, y| {
        polygon_irradiance(DVec3::new(x, y, 0.0), DVec3::Z, &corners) / PI
    });
    let wide = footprint(DVec3::ZERO, 0.2, 0.4);
    Entry::new("B07", &world, &wide, ONE).within(0.01, LIGHT_RAYS).check_value(
        &[Light, Bidirectional],
        "mean",
        mean,
    );
}

#[test]
fn b09_sphere_light() {
    let sphere = Sphere::new(3.0 * DVec3::new(0.5, 0.0, 0.75f64.sqrt()), 1.0);
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(1.0));
    let lamp = stage.sphere(sphere, Material::Black);
    stage.glow(lamp, 1.0);
    let world = stage.build();
    let narrow = eye(1e-4);
    let entry = Entry::new("B09", &world, &narrow, ONE);
    entry.check_value(&POINT, "E/π", entry.expected("") / PI);
    let mean = mean_over_square(0.5, |x, y| {
        sphere_irradiance(DVec3::new(x, y, 0.0), DVec3::Z, &sphere) / PI
    });
    Entry::new("B09", &world, &eye(0.5), ONE).within(RARE, LIGHT_RAYS).check_value(
        &[Light, Bidirectional],
        "mean",
        mean,
    );
}

#[test]
fn b11_disk_light() {
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(1.0));
    let lamp = stage.disk(DVec3::Z * 2.0, DVec3::NEG_Z, 1.0, Material::Black);
    stage.glow(lamp, 1.0);
    let world = stage.build();
    let narrow = eye(1e-4);
    let entry = Entry::new("B11", &world, &narrow, ONE);
    entry.check_value(&POINT, "E/π", entry.expected("") / PI);
    // The configuration factor of a parallel disk off its axis (Howell B-13).
    let factor = |x: f64, y: f64| {
        let a2 = x * x + y * y;
        0.5 * (1.0 - (a2 + 3.0) / ((a2 + 5.0).powi(2) - 4.0 * a2).sqrt())
    };
    Entry::new("B11", &world, &eye(0.5), ONE).within(RARE, LIGHT_RAYS).check_value(
        &[Light, Bidirectional],
        "mean",
        mean_over_square(0.5, factor),
    );
}

#[test]
fn b13_wall_before_the_sky() {
    let wall =
        [[1.0, -2.0, 0.0], [1.0, 2.0, 0.0], [1.0, 2.0, 1.0], [1.0, -2.0, 1.0]].map(DVec3::from);
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(1.0));
    stage.face(Quad { origin: wall[0], edge_u: DVec3::Y * 4.0, edge_v: DVec3::Z }, Material::Black);
    stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
    let world = stage.build();
    Entry::new("B13", &world, &eye(1e-4), ONE).check(&FROM_INFINITY, "L_rho1");
    let mean = mean_over_square(0.5, |x, y| {
        1.0 - polygon_irradiance(DVec3::new(x, y, 0.0), DVec3::Z, &wall) / PI
    });
    Entry::new("B13", &world, &eye(0.5), ONE).within(RARE, LIGHT_RAYS).check_value(
        &[Light, Bidirectional],
        "mean",
        mean,
    );
}

#[test]
fn b15_hot_pixel() {
    let pixel = |i: u32| if (i / 128, i % 128) == (5, 17) { Rgb::splat(1e6) } else { Rgb::BLACK };
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(1.0));
    stage.environment(
        EnvironmentMap::new(128, 64, (0..64 * 128).map(pixel).collect(), EnvironmentMap::Z_UP)
            .expect("valid"),
    );
    let (world, eye) = (stage.build(), eye(0.5));
    Entry::new("B15", &world, &eye, ONE)
        .within(RARE, LIGHT_RAYS)
        .check(&[Path, Light, Bidirectional], "L_rho1");
}

/// Received flux by an orthographic camera that sees the receiver and nothing else: π times the
/// mean of its radiance times its film's area.
#[test]
fn b17_coaxial_disks() {
    for (emitter, receiver) in [(1.0, 0.5), (0.5, 1.0)] {
        let mut stage = Stage::default();
        stage.disk(DVec3::ZERO, DVec3::Z, receiver, lambert(1.0));
        let lamp = stage.disk(DVec3::Z * 1.5, DVec3::NEG_Z, emitter, Material::Black);
        stage.glow(lamp, 1.0);
        let world = stage.build();
        let eye =
            OrthographicCamera::new(DVec3::Z, DVec3::ZERO, DVec3::Y, 2.0 * receiver, UVec2::ONE)
                .expect("valid");
        let entry = Entry::new("B17", &world, &eye, ONE).within(RARE, LIGHT_RAYS);
        let flux = entry.expected("flux_Le1");
        entry.check_value(&Method::SINGLE, "flux", flux / (PI * 4.0 * receiver * receiver));
    }
}

#[test]
fn b18_faces_of_a_cube() {
    for (face, key) in [(5, "opposite"), (1, "adjacent")] {
        let mut stage = Stage::default();
        for (i, quad) in cube(DVec3::ZERO, 1.0).into_iter().enumerate() {
            let id = stage.face(quad, if i == 4 { lambert(1.0) } else { Material::Black });
            if i == face {
                stage.glow(id, 1.0);
            }
        }
        let world = stage.build();
        let center = DVec3::new(0.5, 0.5, 0.5);
        let eye = OrthographicCamera::new(center, center - DVec3::Z, DVec3::Y, 1.0, UVec2::ONE)
            .expect("valid");
        let entry = Entry::new("B18", &world, &eye, ONE);
        entry.check(&[Emission, Path, Light, Bidirectional], key);
        if key == "opposite" {
            entry.check(&[UniformArea], key);
        }
    }
}

#[test]
fn b19_cube_with_a_bright_ceiling() {
    let mut stage = Stage::default();
    let faces = cube(DVec3::ZERO, 1.0);
    for (i, quad) in faces.into_iter().enumerate() {
        let id = stage.face(quad, if i == 5 { Material::Black } else { lambert(0.5) });
        if i == 5 {
            stage.glow(id, 1.0);
        }
    }
    let world = stage.build();
    let point = DVec3::new(0.5, 0.5, 0.0);
    let narrow = footprint(point, 0.5, 1e-4);
    Entry::new("B19", &world, &narrow, ONE).check(&POINT, "L_1bounce");
    Entry::new("B19", &world, &narrow, Depth::exactly(2))
        .check(&[Emission, Path, Bidirectional], "L_2bounce");

    let ceiling =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
    let direct = |x: DVec3, n: DVec3| polygon_irradiance(x, n, &ceiling);
    let on_floor = |x: f64, y: f64| point + DVec3::new(x, y, 0.0);
    let wide = footprint(point, 0.5, 0.2);
    let mean = mean_over_square(0.2, |x, y| 0.5 / PI * direct(on_floor(x, y), DVec3::Z));
    Entry::new("B19", &world, &wide, ONE).within(RARE, LIGHT_RAYS).check_value(
        &[Light, Bidirectional],
        "mean, 1",
        mean,
    );

    // What the walls receive is smooth but at the ceiling's edge; the midpoint rule's error is
    // below 1e-5.
    let steps = 200;
    let mut lit = Vec::new();
    for wall in &faces[..4] {
        let normal = wall.edge_u.cross(wall.edge_v);
        for i in 0..steps * steps {
            let at = |j: i32| (f64::from(j) + 0.5) / f64::from(steps);
            let y = wall.origin + wall.edge_u * at(i % steps) + wall.edge_v * at(i / steps);
            lit.push((y, normal, 0.5 / PI * direct(y, normal) / f64::from(steps * steps)));
        }
    }
    let second = |x: DVec3| -> f64 {
        let transfer = |&(y, normal, power): &(DVec3, DVec3, f64)| {
            let d = y - x;
            power * d.z * -normal.dot(d) / d.length_squared().powi(2)
        };
        0.5 / PI * lit.iter().map(transfer).sum::<f64>()
    };
    let entry = Entry::new("B19", &world, &wide, Depth::exactly(2));
    assert!((second(point) / entry.expected("L_2bounce") - 1.0).abs() < 1e-4, "{}", second(point));
    let mean = mean_over_square(0.2, |x, y| second(on_floor(x, y)));
    entry.within(RARE, LIGHT_RAYS).check_value(&[Light, Bidirectional], "mean, 2", mean);
}

#[test]
fn b20_tiny_far_sphere() {
    let sphere = Sphere::new(DVec3::Z * 1e6, 1e-6);
    let world = |half: f64| {
        let mut stage = Stage::default();
        stage.square(0.0, half, true, lambert(1.0));
        let lamp = stage.sphere(sphere, Material::Black);
        stage.glow(lamp, 1e24);
        stage.build()
    };
    let near = world(1.0);
    let narrow = eye(1e-6);
    let entry = Entry::new("B20", &near, &narrow, ONE).within(1e-6, 100_000);
    entry.check_value(&[Path, Bidirectional], "E/π", entry.expected("E") / PI);
    // Light tracing hits a floor that is as large as the light is far.
    let mean = mean_over_square(5e5, |x, y| {
        1e24 * sphere_irradiance(DVec3::new(x, y, 0.0), DVec3::Z, &sphere) / PI
    });
    let wide = footprint(DVec3::ZERO, 5e5, 5e5);
    Entry::new("B20", &world(5e5), &wide, ONE).within(RARE, LIGHT_RAYS).check_value(
        &[Light],
        "mean",
        mean,
    );
}

#[test]
fn d01_white_furnace_of_ggx() {
    for alpha in [0.1, 0.3, 0.5, 1.0] {
        let mut stage = Stage::default();
        stage.square(
            0.0,
            10.0,
            true,
            Material::RoughMirror { reflectance: Rgb::WHITE, alpha: DVec2::splat(alpha) },
        );
        stage.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
        let world = stage.build();
        for mu in [1.0f64, 0.5, 0.1] {
            let eye = camera(DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu), DVec3::ZERO, 1e-3);
            let entry = Entry::new("D01", &world, &eye, ONE);
            entry.check(&FROM_INFINITY, &format!("corr,alpha={alpha:?},mu={mu:?}"));
        }
    }
}
