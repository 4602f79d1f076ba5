//! Measured numbers against closed forms: meters seen by every integrator that can, and standard
//! errors that keep what they promise. Tolerances are in the standard errors of the measurement
//! itself, which are small enough for a bias of 1 % to fail.
#![allow(missing_docs, reason = "a test program")]

use glam::{DMat3, DVec2, DVec3, UVec2};
use pathspace::endpoint::{
    Camera, DirectionSample, Endpoint, EnvironmentMap, FunctionEnvironment, IrradianceMeter, Light,
    PinholeCamera, PointLight, PointSample, RadianceMeter,
};
use pathspace::geometry::{Bounds, Disk, Facing, Quad, Sphere, SurfacePoint};
use pathspace::integrator::{
    Adaptive, Bidirectional, InstantRadiosity, LightTracer, PathTracer, PhotonMapping, UniformArea,
    VertexConnectionMerging,
};
use pathspace::math::{PerArea, PerProjected, Rgb};
use pathspace::path::{Family, Reason};
use pathspace::render::{Budget, Measurement, Render, Settings, measure};
use pathspace::sampler::SamplerKind;
use pathspace::scene::{
    Emission, Material, MaterialId, Scene, SceneError, SurfaceId, World, WorldBuilder,
};
use std::f64::consts::PI;
use std::sync::Arc;

type Result<T = ()> = std::result::Result<T, Box<dyn std::error::Error>>;

/// An integrator, and the bias that it may have at so few passes: of those that merge.
type Team = Vec<(Box<dyn Render<World>>, f64)>;

fn team() -> Team {
    let unbiased: [Box<dyn Render<World>>; 6] = [
        Box::new(PathTracer::default()),
        Box::new(LightTracer::default()),
        Box::new(Bidirectional::default()),
        Box::new(UniformArea::default()),
        Box::new(InstantRadiosity::default()),
        Box::new(Adaptive::default()),
    ];
    let merging: [Box<dyn Render<World>>; 2] =
        [Box::new(PhotonMapping::default()), Box::new(VertexConnectionMerging::default())];
    let unbiased = unbiased.into_iter().map(|integrator| (integrator, 0.0));
    unbiased.chain(merging.into_iter().map(|integrator| (integrator, 0.004))).collect()
}

fn settings(samples: u32, seed: u64) -> Settings {
    Settings { budget: Budget::Samples(samples), seed, ..Settings::default() }
}

/// Within 4 standard errors, of which one is at most 0.25 %; for photons along a single ray 5 %, since
/// all samples of a pass see the same few photons.
#[track_caller]
fn assert_is(measured: &Measurement, expected: f64, bias: f64, name: &str) {
    let most = if name == "photon-mapping along a ray" { 0.05 } else { 0.0025 };
    let (mean, error) = (measured.mean().g(), measured.standard_error().g());
    assert!(measured.blind_spots().is_empty(), "{name}: {:?}", measured.blind_spots());
    let allowed = 4.0 * error + (bias + 1e-9) * expected;
    assert!((mean - expected).abs() <= allowed, "{name}: {mean} ± {error}, expected {expected}");
    assert!(error <= most * expected, "{name}: {error} of {expected} says nothing");
}

fn grey(builder: &mut WorldBuilder, albedo: f64) -> Result<MaterialId> {
    Ok(builder.add_material("grey", Material::Lambert { albedo: albedo.into() })?)
}

/// A lamp of radiance 3 above a meter at the origin, which looks upwards.
fn lamp(add: impl FnOnce(&mut WorldBuilder, MaterialId) -> Result) -> Result<World> {
    let mut builder = WorldBuilder::new();
    let black = builder.add_material("black", Material::Black)?;
    add(&mut builder, black)?;
    // Lights at infinity need something to shine on; the meter does not see it.
    let hidden = Disk { center: -DVec3::Z, normal: DVec3::Z, radius: 0.1 };
    builder.add_disk("hidden", hidden, black)?;
    Ok(builder.build()?)
}

const RADIANCE: f64 = 3.0;
const EMISSION: Emission = Emission { radiance: Rgb::splat(RADIANCE), two_sided: false };

/// Configuration factors of a differential area to a disk, a sphere and a rectangle (Howell,
/// Mengüç, Daun and Siegel 2021, appendix C: B-12 for h = 0, B-41, B-4).
#[test]
fn irradiance_of_lamps_is_their_configuration_factor() -> Result {
    let h = 1.5;
    let disk = lamp(|builder, black| {
        let disk = Disk { center: DVec3::Z * h, normal: -DVec3::Z, radius: 0.8 };
        let lamp = builder.add_disk("lamp", disk, black)?;
        Ok(builder.set_emission(lamp, EMISSION)?)
    })?;
    let sphere = lamp(|builder, black| {
        // Where the meter sees it under 60°.
        let center = DVec3::new(3f64.sqrt(), 0.0, 1.0);
        let lamp = builder.add_sphere("lamp", Sphere::new(center, 0.5), black)?;
        Ok(builder.set_emission(lamp, EMISSION)?)
    })?;
    let (a, b) = (1.2 / h, 0.7 / h);
    let quad = lamp(|builder, black| {
        let (edge_u, edge_v) = (DVec3::X * a * h, DVec3::Y * b * h);
        let quad = Quad { origin: DVec3::Z * h, edge_u, edge_v }.facing(DVec3::ZERO);
        let lamp = builder.add_quad("lamp", quad, black)?;
        Ok(builder.set_emission(lamp, EMISSION)?)
    })?;
    let half = |a: f64, b: f64| {
        let root = (1.0 + a * a).sqrt();
        a / root * (b / root).atan()
    };
    let factors =
        [0.8 * 0.8 / (h * h + 0.8 * 0.8), 0.25 / 4.0 * 0.5, (half(a, b) + half(b, a)) / (2.0 * PI)];
    let meter = IrradianceMeter::new(DVec3::ZERO, DVec3::Z * 2.0)?;
    for ((name, world), factor) in
        [("disk", disk), ("sphere", sphere), ("quad", quad)].into_iter().zip(factors)
    {
        for (integrator, bias) in team() {
            let measured = measure(&world, &meter, &*integrator, &settings(256, 1))?;
            let name = format!("{} {name}", integrator.name());
            assert_is(&measured, PI * RADIANCE * factor, bias, &name);
        }
    }
    Ok(())
}

/// `E = Φ cos θ/(4π d²)`. A walk from the meter does not meet a point light, which is said.
#[test]
fn irradiance_of_a_point_light_is_the_inverse_square_law() -> Result {
    let (flux, position) = (20.0, DVec3::new(1.0, -0.5, 2.0));
    let world = lamp(|builder, _| {
        let light = PointLight::new(position, Rgb::splat(flux / (4.0 * PI)))?;
        Ok(builder.add_light("bulb", light)?)
    })?;
    let d2 = position.length_squared();
    let expected = flux / (4.0 * PI * d2) * (position.z / d2.sqrt());
    let meter = IrradianceMeter::new(DVec3::ZERO, DVec3::Z)?;
    for (integrator, bias) in team() {
        let measured = measure(&world, &meter, &*integrator, &settings(16, 2))?;
        let before = integrator.blind_spots(&world, &meter)?;
        assert_eq!(before, measured.blind_spots());
        match integrator.name() {
            "light-tracing" | "bidirectional" | "adaptive" | "vcm" => {
                assert_is(&measured, expected, bias, integrator.name());
            }
            name => {
                let said: Vec<String> = before.iter().map(ToString::to_string).collect();
                let direct = "the point light \"bulb\" seen directly through the lens";
                assert!(said.iter().any(|said| said.starts_with(direct)), "{name}: {said:?}");
                assert!(measured.mean().is_black(), "{name}");
            }
        }
    }
    Ok(())
}

/// `E = π L` under a uniform sky, `E = 2/3 π` under one of radiance cos θ, whatever is told of it.
#[test]
fn irradiance_of_skies() -> Result {
    type Set = fn(&mut WorldBuilder) -> Result;
    let skies: [(&str, Set, f64); 4] = [
        ("one", |b| Ok(b.set_environment("sky", FunctionEnvironment::new(|_| 1.0.into())?)?), PI),
        (
            "cosine",
            |b| Ok(b.set_environment("sky", FunctionEnvironment::new(|w| w.z.abs().into())?)?),
            2.0 / 3.0 * PI,
        ),
        (
            "cosine, sampled uniformly",
            |b| {
                let sky = FunctionEnvironment::new(|w| w.z.abs().into())?.uniformly_sampled();
                Ok(b.set_environment("sky", sky)?)
            },
            2.0 / 3.0 * PI,
        ),
        (
            "map",
            |b| {
                let map = EnvironmentMap::new(1, 1, vec![Rgb::WHITE], DMat3::IDENTITY)?;
                Ok(b.set_environment("sky", map)?)
            },
            PI,
        ),
    ];
    let meter = IrradianceMeter::new(DVec3::new(0.2, 0.1, 0.0), DVec3::Z)?;
    for (name, set, expected) in skies {
        let world = lamp(|builder, _| set(builder))?;
        for (integrator, bias) in team() {
            let measured = measure(&world, &meter, &*integrator, &settings(256, 3))?;
            assert_is(&measured, expected, bias, &format!("{} {name}", integrator.name()));
        }
    }
    Ok(())
}

/// A closed room of albedo ρ whose walls emit L: the radiance is L/(1 - ρ) everywhere, also where
/// the meter lies on a wall.
#[test]
fn meters_in_a_furnace() -> Result {
    let (albedo, radiance) = (0.5, 2.0);
    let furnace = |add: &dyn Fn(&mut WorldBuilder, MaterialId) -> Result<SurfaceId>| {
        let mut builder = WorldBuilder::new();
        let wall = grey(&mut builder, albedo)?;
        let walls = add(&mut builder, wall)?;
        builder.set_emission(walls, Emission { radiance: radiance.into(), two_sided: false })?;
        Ok::<_, Box<dyn std::error::Error>>(builder.build()?)
    };
    let sphere =
        furnace(&|b, wall| Ok(b.add_sphere("walls", Sphere::inward(DVec3::ZERO, 1.0), wall)?))?;
    let room = Bounds { min: -DVec3::ONE, max: DVec3::ONE };
    let room = furnace(&|b, wall| Ok(b.add_box("walls", room, Facing::Inward, wall)?))?;
    let expected = radiance / (1.0 - albedo);
    let inside = IrradianceMeter::new(DVec3::new(0.3, -0.2, 0.1), DVec3::new(1.0, 2.0, 3.0))?;
    let downwards = sphere.intersect(&SurfacePoint::dirac(DVec3::ZERO), -DVec3::Z);
    let on_wall = IrradianceMeter::at(&downwards.ok_or("a wall")?, DVec3::Z);
    let on_floor = IrradianceMeter::new(DVec3::new(0.3, -0.2, -1.0), DVec3::Z)?;
    let ray = RadianceMeter::new(DVec3::new(0.3, -0.2, 0.1), DVec3::new(-1.0, 2.0, -3.0))?;
    for (integrator, bias) in team() {
        // In an edge of the room, points that are uniform by area or virtual lights come too near to
        // each other, and the disk of a search for photons reaches out of the wall.
        let avoids_edges =
            matches!(integrator.name(), "uniform-area" | "instant-radiosity" | "photon-mapping");
        for (name, world, meter, expected) in [
            ("inside", &sphere, &inside as &dyn Camera, PI * expected),
            ("on a wall", &sphere, &on_wall, PI * expected),
            ("on a floor", &room, &on_floor, PI * expected),
            ("along a ray", &sphere, &ray, expected),
        ] {
            let sees = match name {
                "on a floor" => !avoids_edges,
                "along a ray" => integrator.name() != "light-tracing",
                _ => true,
            };
            if sees {
                let measured = measure(world, meter, &*integrator, &settings(256, 4))?;
                assert_is(&measured, expected, bias, &format!("{} {name}", integrator.name()));
            }
        }
    }
    Ok(())
}

/// The light of a lamp that a floor scatters along a ray: the integrators agree with `ρ/π E`, whose weights
/// would be wrong with the technique t = 1 among them.
#[test]
fn radiance_along_a_ray_is_seen_by_all_but_light_walks() -> Result {
    let (albedo, h) = (0.6, 1.5);
    let mut builder = WorldBuilder::new();
    let floor = grey(&mut builder, albedo)?;
    let ground = Disk { center: DVec3::ZERO, normal: DVec3::Z, radius: 4.0 };
    builder.add_disk("floor", ground, floor)?;
    let black = builder.add_material("black", Material::Black)?;
    let disk = Disk { center: DVec3::Z * h, normal: -DVec3::Z, radius: 0.8 };
    let lamp = builder.add_disk("lamp", disk, black)?;
    builder.set_emission(lamp, EMISSION)?;
    let world = builder.build()?;
    let expected = albedo * RADIANCE * 0.8 * 0.8 / (h * h + 0.8 * 0.8);
    let meter = RadianceMeter::new(DVec3::new(2.0, 0.0, 1.0), DVec3::new(-2.0, 0.0, -1.0))?;
    for (integrator, bias) in team() {
        let rendering = integrator.render(&world, &meter, &settings(1, 5))?;
        if integrator.name() == "light-tracing" {
            assert!(rendering.image.mean().is_black());
            assert!(!rendering.blind_spots().is_empty());
            let mut left_out = rendering.notes.left_out.families();
            assert_eq!(left_out.next(), Some((Family::LensSampling, Reason::UnconnectibleLens)));
            continue;
        }
        assert!(!rendering.techniques.lens_sampling);
        let samples = if integrator.name() == "uniform-area" { 2048 } else { 256 };
        let measured = measure(&world, &meter, &*integrator, &settings(samples, 5))?;
        assert_is(&measured, expected, bias, &format!("{} along a ray", integrator.name()));
    }
    Ok(())
}

/// Intervals of 90 % contain the expected value that often, although samples are Sobol' points:
/// 300 measurements, within 4 standard errors of their number.
#[test]
fn standard_errors_are_honest_for_every_sampler() -> Result {
    let (h, radius) = (1.5, 0.8);
    let world = lamp(|builder, black| {
        let disk = Disk { center: DVec3::Z * h, normal: -DVec3::Z, radius };
        let lamp = builder.add_disk("lamp", disk, black)?;
        Ok(builder.set_emission(lamp, EMISSION)?)
    })?;
    let expected = PI * RADIANCE * radius * radius / (h * h + radius * radius);
    let meter = IrradianceMeter::new(DVec3::ZERO, DVec3::Z)?;
    let integrator = PathTracer::up_to(0);
    let mut variances = Vec::new();
    for sampler in [SamplerKind::Independent, SamplerKind::Stratified, SamplerKind::Sobol] {
        let (mut kept, mut variance) = (0.0, 0.0);
        for seed in 0..300 {
            let settings = Settings { sampler, threads: Some(1), ..settings(32, seed) };
            let measured = measure(&world, &meter, &integrator, &settings)?;
            let distance = (measured.mean().g() - expected).abs();
            kept += f64::from(u8::from(distance <= measured.half_width(0.9).g()));
            variance += measured.variance().g() / 300.0;
            assert_eq!(measured.samples, 32 * 1024);
        }
        let error = (300.0 * 0.9 * 0.1f64).sqrt();
        assert!((kept - 270.0).abs() <= 4.0 * error, "{sampler:?}: {kept} of 300");
        variances.push(variance);
    }
    // Few pixels see an edge of the lamp, and in those points of Sobol' are spread better.
    assert!(variances[2] < 0.95 * variances[0], "{variances:?}");
    Ok(())
}

/// A pixel and a window are those of the image.
#[test]
fn windows_and_pixels_are_those_of_the_image() -> Result {
    let scene = pathspace::gallery::build("cornell-box", UVec2::splat(8))?;
    let integrator = PathTracer::up_to(3);
    let camera = scene.camera;
    let image = integrator.render(&scene.world, &camera, &settings(8192, 6))?.image;
    let measured = measure(&scene.world, &camera, &integrator, &settings(8192, 7))?;
    let z = (measured.mean().g() - image.mean().g()) / measured.standard_error().g();
    // The image has about the same error.
    assert!(z.abs() < 4.0 * 2f64.sqrt(), "{z}");
    assert!(measured.standard_error().g() < 0.0025 * measured.mean().g());

    let mut builder = WorldBuilder::new();
    let black = builder.add_material("black", Material::Black)?;
    let disk = Disk { center: DVec3::ZERO, normal: DVec3::Z, radius: 0.4 };
    let lamp = builder.add_disk("lamp", disk, black)?;
    builder.set_emission(lamp, EMISSION)?;
    let world = builder.build()?;
    let eye = PinholeCamera::new(DVec3::Z * 3.0, DVec3::ZERO, DVec3::Y, 30.0, UVec2::splat(8))?;
    let image = integrator.render(&world, &eye, &settings(4096, 8))?.image;
    for (x, y) in [(2, 2), (2, 3), (4, 4)] {
        let pixel = UVec2::new(x, y);
        let eye = eye.with_window(pixel, pixel + 1)?;
        let measured = measure(&world, &eye, &integrator, &settings(65_536, 9))?;
        let expected = image.get(x, y).expect("a pixel").g();
        let error = measured.standard_error().g();
        // The image has an error of its own.
        assert!((measured.mean().g() - expected).abs() <= 4.0 * error + 2e-3 * RADIANCE);
        assert!(error <= 0.0025 * RADIANCE, "{error}");
    }
    Ok(())
}

/// A pointer to a camera is the same camera.
#[test]
fn cameras_behind_pointers_render_the_same() -> Result {
    let scene = pathspace::gallery::build("cornell-box", UVec2::splat(12))?;
    let view = (DVec3::new(2.78, 2.73, -8.0), DVec3::new(2.78, 2.73, 2.8));
    let eye = PinholeCamera::new(view.0, view.1, DVec3::Y, 39.0, UVec2::splat(12))?;
    let integrator = Bidirectional::up_to(3);
    let image = |camera: &dyn Camera| {
        assert!(camera.as_pinhole().is_some());
        integrator.render(&scene.world, camera, &settings(2, 10)).map(|rendering| rendering.image)
    };
    let expected = image(&eye)?;
    assert!(!expected.mean().is_black());
    let boxed: Box<dyn Camera> = Box::new(eye);
    for camera in [&boxed as &dyn Camera, &&eye, &Arc::new(eye), &Box::new(&eye)] {
        assert_eq!(image(camera)?, expected);
    }
    Ok(())
}

/// A light of a host's own that forgot its power is found when the scene is built; one that is black
/// is not.
#[test]
fn a_light_that_shines_without_power_is_refused() -> Result {
    struct Forgetful(PointLight, bool);
    impl Endpoint for Forgetful {
        fn sample_point(&self, u1: f64, u2: DVec2) -> Option<PointSample> {
            self.0.sample_point(u1, u2)
        }
        fn point_pdf(&self, point: &SurfacePoint) -> PerArea {
            self.0.point_pdf(point)
        }
        fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
            // One that can only be connected to is found, too.
            if self.1 { self.0.sample_direction(point, u) } else { None }
        }
        fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected {
            self.0.direction_pdf(point, direction)
        }
        fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
            self.0.emit(point, direction)
        }
    }
    impl Light for Forgetful {
        fn power(&self) -> Rgb {
            Rgb::BLACK
        }
        fn can_be_hit(&self) -> bool {
            false
        }
    }
    for (intensity, leaves) in [(1.0, true), (1.0, false), (0.0, true)] {
        let mut builder = WorldBuilder::new();
        let wall = grey(&mut builder, 0.5)?;
        builder.add_sphere("wall", Sphere::inward(DVec3::ZERO, 2.0), wall)?;
        let light = PointLight::new(DVec3::X, Rgb::splat(intensity))?;
        builder.add_light("forgetful", Forgetful(light, leaves))?;
        match builder.build() {
            Err(SceneError::PowerlessLight { name }) => {
                assert_eq!((name.as_str(), intensity), ("forgetful", 1.0));
            }
            built => assert!(built.is_ok() && intensity == 0.0),
        }
    }
    Ok(())
}

/// A function of direction and the map of its pixels light a scene alike, by every integrator.
#[test]
fn a_function_lights_a_scene_as_a_map_does() -> Result {
    let (width, height) = (64, 32);
    let pixel =
        |row: f64, column: f64| Rgb::from(0.2 + row / 32.0 + f64::from(column < 16.0) * 4.0);
    let world = |set: &dyn Fn(&mut WorldBuilder) -> Result| -> Result<World> {
        let mut builder = WorldBuilder::new();
        let clay = grey(&mut builder, 0.6)?;
        let ground = Disk { center: DVec3::ZERO, normal: DVec3::Y, radius: 2.0 };
        builder.add_disk("ground", ground, clay)?;
        builder.add_sphere("ball", Sphere::new(DVec3::Y, 0.7), clay)?;
        set(&mut builder)?;
        Ok(builder.build()?)
    };
    let pixels = (0..width * height)
        .map(|i| pixel(f64::from(i / width), f64::from(i % width)))
        .collect::<Vec<_>>();
    let map = world(&|b| {
        let map = EnvironmentMap::new(width, height, pixels.clone(), DMat3::IDENTITY)?;
        Ok(b.set_environment("sky", map)?)
    })?;
    // The image's left edge is at -Z, and +X a quarter of its width further right.
    let sky = move |w: DVec3| {
        let row = (w.y.clamp(-1.0, 1.0).acos() / PI * 32.0).floor().min(31.0);
        let column = (w.x.atan2(-w.z).rem_euclid(2.0 * PI) / (2.0 * PI) * 64.0).floor();
        pixel(row, column.min(63.0))
    };
    let function = world(&|b| Ok(b.set_environment("sky", FunctionEnvironment::new(sky)?)?))?;
    let meter = IrradianceMeter::new(DVec3::new(1.2, 0.3, 0.4), DVec3::new(1.0, 1.0, 0.0))?;
    let reference = measure(&map, &meter, &PathTracer::up_to(3), &settings(1024, 11))?;
    for integrator in [
        &PathTracer::up_to(3) as &dyn Render<World>,
        &LightTracer::up_to(3),
        &Bidirectional::up_to(3),
    ] {
        let measured = measure(&function, &meter, integrator, &settings(1024, 12))?;
        let [a, b] = [&reference, &measured].map(|m| (m.mean().g(), m.standard_error().g()));
        let name = integrator.name();
        assert!((a.0 - b.0).abs() <= 4.0 * a.1.hypot(b.1), "{name}: {a:?} {b:?}");
        assert!(b.1 <= 0.0025 * b.0, "{name}: {b:?}");
    }
    Ok(())
}
