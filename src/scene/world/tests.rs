//! Worlds that are built, asked, refused and shared.

use super::*;
use crate::bsdf::{Bsdf, Lobes};
use crate::endpoint::{DirectionSample, Endpoint, Light, PointSample, SceneExtent};
use crate::gallery;
use crate::geometry::{Place, Quad, Sphere};
use crate::math::warp::square_to_sphere;
use crate::math::{PerArea, PerProjected, Rgb};
use crate::scene::{Emission, Material, Scene, SceneError, SurfaceArea, WorldBuilder};
use glam::{DVec2, DVec3, UVec2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A light of a given power that is proportional to the radius of the scene.
struct Stub {
    power: f64,
    radius: f64,
}

impl Endpoint for Stub {
    fn sample_point(&self, _: f64, _: DVec2) -> Option<PointSample> {
        None
    }
    fn point_pdf(&self, _: &SurfacePoint) -> PerArea {
        PerArea::ZERO
    }
    fn sample_direction(&self, _: &SurfacePoint, _: DVec2) -> Option<DirectionSample> {
        None
    }
    fn direction_pdf(&self, _: &SurfacePoint, _: DVec3) -> PerProjected {
        PerProjected::ZERO
    }
    fn emit(&self, _: &SurfacePoint, _: DVec3) -> Rgb {
        Rgb::BLACK
    }
}

impl Light for Stub {
    fn power(&self) -> Rgb {
        Rgb::splat(self.power * self.radius)
    }
    fn can_be_hit(&self) -> bool {
        false
    }
    fn is_black(&self) -> bool {
        self.power == 0.0
    }
    fn set_scene_extent(&mut self, extent: &SceneExtent) {
        self.radius = extent.bounds().radius();
    }
}

fn stub(power: f64) -> Stub {
    Stub { power, radius: f64::NAN }
}

#[test]
fn lights_are_picked_by_power_and_found_by_name() -> Result<(), SceneError> {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) })?;
    builder.add_light("off", stub(0.0))?;
    builder.add_light("on", stub(2.0))?;
    builder.set_environment("sky", stub(1.0))?;
    assert_eq!(
        builder.set_environment("heaven", stub(1.0)),
        Err(SceneError::SecondEnvironment { name: "heaven".into() })
    );
    assert_eq!(
        builder.add_light("on", stub(1.0)),
        Err(SceneError::DuplicateName { name: "on".into() })
    );
    builder.add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), grey)?;
    let lamp = builder.add_quad(
        "lamp",
        Quad { origin: DVec3::Z * 2.0, edge_u: DVec3::Y, edge_v: DVec3::X },
        grey,
    )?;
    let power_of_others =
        3.0 * Bounds { min: DVec3::splat(-1.0), max: DVec3::new(1.0, 1.0, 2.0) }.radius();
    let radiance = Rgb::splat(power_of_others / std::f64::consts::PI);
    builder.set_emission(lamp, Emission { radiance, two_sided: false })?;
    let world = builder.build()?;

    let id = |name: &str| world.light_by_name(name).expect("added");
    assert_eq!((world.light_count(), world.environment()), (4, Some(id("sky"))));
    // By power, but for a tenth that all have alike.
    let pmf = |by_power: f64| 0.9 * by_power + 0.1 / 3.0;
    for (name, pmf) in
        [("off", 0.0), ("on", pmf(1.0 / 3.0)), ("sky", pmf(1.0 / 6.0)), ("lamp", pmf(0.5))]
    {
        approx::assert_relative_eq!(world.pick_pmf(id(name)), pmf, max_relative = 1e-12);
    }
    for i in 0..1000 {
        let (light, pmf) = world.pick_light(f64::from(i) / 1000.0).expect("there are lights");
        assert!(pmf > 0.0 && pmf == world.pick_pmf(light) && light != id("off"));
    }
    let hit = world
        .intersect(&SurfacePoint::dirac(DVec3::new(0.5, 0.5, 5.0)), -DVec3::Z)
        .expect("the lamp");
    assert_eq!((world.surface_name(&hit), world.light_at(&hit)), (Some("lamp"), Some(id("lamp"))));
    let expected = Needs::HITTABLE_LIGHTS
        | Needs::DIRAC_LIGHTS
        | Needs::CONNECTIBLE_LIGHTS
        | Needs::FINITE_LOBES
        | Needs::ENVIRONMENT
        | Needs::ILLUMINATION
        | Needs::INTERREFLECTION;
    assert_eq!(world.needs(), expected);
    Ok(())
}

#[test]
fn a_world_of_an_environment_alone_is_valid() -> Result<(), SceneError> {
    let mut builder = WorldBuilder::new();
    builder.set_environment("sky", stub(1.0))?;
    let world = builder.build()?;
    let (a, b) = (SurfacePoint::dirac(DVec3::ZERO), SurfacePoint::dirac(DVec3::X * 1e9));
    assert!(world.intersect(&a, DVec3::X).is_none());
    assert!(world.visible(&a, &b));
    assert_eq!((world.pick_light(0.5), world.total_area()), (None, 0.0));
    assert_eq!(world.bsdf(&world.sample_surface(0.5, DVec2::ZERO)).lobes(), Lobes::NONE);
    Ok(())
}

#[test]
fn lights_without_a_proper_power_are_refused() {
    for power in [-1.0, f64::NAN, f64::INFINITY] {
        let mut builder = WorldBuilder::new();
        builder
            .add_light("bad", Stub { power, radius: 1.0 })
            .expect("power is known only when the scene is");
        builder.set_environment("sky", stub(1.0)).expect("valid");
        let black = builder.add_material("black", Material::Black).expect("valid");
        builder.add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), black).expect("valid");
        assert!(matches!(builder.build(), Err(SceneError::Parameter { parameter: "power", .. })));
    }
}

#[test]
fn worlds_are_shared_between_threads() {
    fn check<T: Send + Sync>() {}
    check::<World>();
    check::<WorldBuilder>();
}

/// Answers that come in any order, each once.
fn in_order<T>(count: usize, ask: impl FnOnce(&mut dyn FnMut(usize, T))) -> Vec<T> {
    let mut answers: Vec<Option<T>> = (0..count).map(|_| None).collect();
    ask(&mut |index, answer| {
        assert!(answers[index].replace(answer).is_none(), "{index} of {count} twice")
    });
    answers.into_iter().map(|answer| answer.expect("an answer to each")).collect()
}

/// Queries at once are answered like single ones.
#[test]
fn points_at_once_see_what_single_ones_do() {
    for name in gallery::NAMES {
        let world = gallery::build(name, UVec2::splat(8)).expect("a scene of the gallery").world;
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        let points: Vec<SurfacePoint> = (0..500)
            .map(|i| {
                let x = world.sample_surface(rng.random(), DVec2::new(rng.random(), rng.random()));
                match i % 9 {
                    0 => SurfacePoint::dirac(x.position),
                    1 => SurfacePoint { place: Place::Infinite, ..x },
                    _ => x,
                }
            })
            .collect();
        let rays: Vec<_> = points
            .iter()
            .map(|x| (x, square_to_sphere(DVec2::new(rng.random(), rng.random()))))
            .collect();
        let single: Vec<_> = rays.iter().map(|&(x, d)| world.intersect(x, d)).collect();
        assert_eq!(
            in_order(rays.len(), |answer| world.intersect_many(rays.iter().copied(), answer)),
            single,
            "{name}"
        );

        // Each with another, now and then with itself.
        let segments: Vec<_> =
            (0..points.len()).map(|i| (&points[i], &points[(i * 7) % points.len()])).collect();
        let single: Vec<_> = segments.iter().map(|(a, b)| world.visible(a, b)).collect();
        assert_eq!(
            in_order(segments.len(), |answer| world.visible_many(segments.iter().copied(), answer)),
            single,
            "{name}"
        );

        let single: Vec<_> = rays.iter().map(|&(x, d)| world.first_hit(x.position, d)).collect();
        let first = rays.iter().map(|&(x, d)| (x.position, d));
        assert_eq!(
            in_order(rays.len(), |answer| world.first_hits(first, answer)),
            single,
            "{name}"
        );
        let single: Vec<_> =
            rays.iter().map(|&(x, d)| world.is_clear(x.position, d, 1.0)).collect();
        let clear = rays.iter().map(|&(x, d)| (x.position, d, 1.0));
        assert_eq!(in_order(rays.len(), |answer| world.are_clear(clear, answer)), single, "{name}");
    }
}

/// A vertex is what a bidirectional sample keeps for each scattering event; `docs/performance.md`
/// states its size.
#[test]
fn memory_per_vertex_does_not_grow() {
    let bytes = size_of::<crate::path::Vertex<SurfaceBsdf<'static>>>();
    println!("{bytes} bytes per vertex, {} per surface point", size_of::<SurfacePoint>());
    assert!(bytes <= 400, "{bytes}");
}

/// Points of flat primitives, which are prepared, are those of the shapes.
#[test]
fn points_of_few_primitives_are_those_of_their_shapes() {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let mut found = 0;
    for name in gallery::NAMES {
        let world = gallery::build(name, UVec2::splat(8)).expect("a scene of the gallery").world;
        for _ in 0..1000 {
            let from = world.sample_surface(rng.random(), DVec2::new(rng.random(), rng.random()));
            let direction = square_to_sphere(DVec2::new(rng.random(), rng.random()));
            let Some(x) = world.intersect(&from, direction) else { continue };
            let expected = match world.shape(x.primitive).expect("its shape") {
                Shape::Quad(quad) => quad.point_at(x.uv.x, x.uv.y),
                Shape::Triangle(triangle) if x.is_flat() => triangle.point_at(x.uv.x, x.uv.y),
                _ => continue,
            };
            let surface = world.surface_of[x.primitive as usize];
            if world.surfaces[surface as usize].attributes.is_none() {
                let primitive = x.primitive;
                assert_eq!(x, SurfacePoint { primitive, surface, ..expected }, "{name}");
                found += 1;
            }
        }
    }
    assert!(found > 1000, "{found} points");
}
