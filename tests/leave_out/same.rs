//! Contributions of pruned integrators: nothing is lost, and the rest is the same to the bit.

use super::{assert_nothing_is_lost, contributions, is_redundant, rooms, sparing_scenes, worlds};
use glam::DVec3;
use pathspace::endpoint::{Camera, ConstantEnvironment, PointLight, SpotLight};
use pathspace::geometry::Sphere;
use pathspace::integrator::{Bidirectional, LightTracer, WithNeeds};
use pathspace::math::Rgb;
use pathspace::scene::{Material, Needs, Scene, World};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rooms::{Room, lambert, v};
use worlds::{Result, TestScene};

#[test]
fn pruned_contributions_are_the_same_to_the_bit() -> Result {
    for TestScene { name, world, camera } in worlds::all()? {
        for_each_integrator!(integrator => {
            assert_nothing_is_lost(&name, &world, &*camera, &integrator, 400);
        });
    }
    for (name, world, camera, saves) in sparing_scenes() {
        let mut saved = 0;
        for_each_integrator!(integrator => {
            saved += assert_nothing_is_lost(name, &world, &camera, &integrator, 400);
        });
        assert_eq!(saved > 0, saves, "{name}: {}", world.needs());
    }
    Ok(())
}

/// A point light that a lens of finite area sees, with no surface to connect to: (1, 1) alone draws
/// it.
#[test]
fn a_point_light_is_seen_through_a_lens() {
    let mut room = Room::default();
    room.quad(
        v(-1.0, -1.0, 0.0),
        v(2.0, 0.0, 0.0),
        v(0.0, 2.0, 0.0),
        Material::Mirror { reflectance: Rgb::WHITE },
    );
    room.light(PointLight::new(v(0.0, 0.0, 1.0), Rgb::WHITE).expect("valid"));
    let (world, camera) = (room.build(), rooms::lens_camera());
    for_each_integrator!(integrator => {
        assert_nothing_is_lost("lens", &world, &camera, &integrator, 300);
    });
    let (seen, _) = contributions(&world, &camera, &LightTracer::default(), 300);
    assert!(!seen.is_empty());
}

/// A light that cannot be connected to is seen through connections to light subpaths.
#[test]
fn a_beam_lights_by_connections() {
    let mut room = Room::open(lambert(0.5, 0.5, 0.5));
    room.light(super::needs::Beam);
    let (world, camera) = (room.build(), rooms::camera());
    for_each_integrator!(integrator => {
        assert_nothing_is_lost("beam", &world, &camera, &integrator, 300);
    });
    let (seen, _) = contributions(&world, &camera, &Bidirectional::default(), 300);
    assert!(
        seen.iter().any(|c| c.technique.s >= 2 && c.technique.t >= 2)
            && seen.iter().all(|c| c.technique.s >= 2),
        "{}",
        seen.len()
    );
}

/// Random scenes of few features.
#[test]
fn nothing_is_lost_in_random_scenes() {
    let material = prop_oneof![
        2 => Just(lambert(0.6, 0.5, 0.4)),
        1 => Just(Material::Black),
        2 => Just(Material::Mirror { reflectance: Rgb::splat(0.7) }),
        1 => Just(Material::Dielectric { relative_ior: 1.5 }),
        1 => Just(Material::Null),
    ];
    let point = || (-1.0..1.0f64, -1.0..1.0f64, 0.0..2.0f64).prop_map(|(x, y, z)| v(x, y, z));
    let shape = (
        0..3u8,
        point(),
        point(),
        0.2..1.0f64,
        material,
        prop::option::weighted(0.3, any::<bool>()),
    );
    let plan = (
        prop::collection::vec(shape, 0..3),
        prop::collection::vec((0..4u8, point()), 0..2),
        any::<bool>(),
    );
    let mut runner = TestRunner::new_with_rng(
        Config { cases: 300, failure_persistence: None, ..Config::default() },
        TestRng::from_seed(RngAlgorithm::ChaCha, &[5; 32]),
    );
    let saved = std::cell::Cell::new(0);
    runner
        .run(&plan, |(shapes, lights, lens)| {
            let mut room = Room::default();
            for (kind, center, axis, size, material, glow) in shapes {
                let surface = match kind {
                    0 => room.sphere(Sphere::new(center, size), material),
                    1 => room.disk(center, axis + DVec3::splat(1.5), size, material),
                    _ => room.quad(center, v(size, 0.0, 0.1), v(0.0, size, 0.0), material),
                };
                if let Some(two_sided) = glow {
                    room.emit(surface, Rgb::new(1.0, 2.0, 3.0), two_sided);
                }
            }
            for (i, (kind, position)) in lights.into_iter().enumerate() {
                match kind {
                    0 if i == 0 => {
                        room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"))
                    }
                    1 => {
                        let spot = SpotLight::new(position, -DVec3::Z, Rgb::WHITE, 20.0, 60.0);
                        room.light(spot.expect("valid"))
                    }
                    _ => room.light(PointLight::new(position, Rgb::WHITE).expect("valid")),
                }
            }
            let Ok(world) = room.builder.build() else { return Ok(()) };
            let camera: Box<dyn Camera + Send> =
                if lens { Box::new(rooms::lens_camera()) } else { Box::new(rooms::camera()) };
            for_each_integrator!(integrator => {
                let fewer = assert_nothing_is_lost("random", &world, &*camera, &integrator, 40);
                saved.set(saved.get() + fewer);
            });
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(saved.get() > 1000, "{} rays saved: the scenes need everything", saved.get());
}

/// Every single feature that a scene claims without having it costs at most rays: the contributions
/// of all supersets are the same.
#[test]
fn supersets_of_what_is_needed_contribute_the_same() -> Result {
    let worlds = worlds::all()?.into_iter().map(|scene| (scene.name, scene.world, scene.camera));
    let sparing = sparing_scenes()
        .into_iter()
        .map(|(name, world, camera, _)| (name.to_owned(), world, Box::new(camera) as _));
    let mut differing = 0;
    for (name, world, camera) in worlds.chain(sparing) {
        let world: World = world;
        let own = world.needs();
        for need in Needs::SINGLE.into_iter().filter(|need| !own.contains(*need)) {
            let superset = own | need;
            for_each_integrator!(integrator => {
                let superset = WithNeeds { integrator, needs: superset };
                let (all, more) = contributions(&world, &*camera, &superset, 60);
                let (needed, fewer) = contributions(&world, &*camera, &integrator, 60);
                assert!(fewer.rays() <= more.rays(), "{name} and {need}: {fewer:?} {more:?}");
                differing += u32::from(fewer.rays() < more.rays());
                if is_redundant(&integrator, &world, &*camera)
                    == is_redundant(&superset, &world, &*camera)
                {
                    let (some, total) = (needed.len(), all.len());
                    assert!(needed == all, "{name} and {need}: {some} contributions of {total}");
                }
            });
        }
    }
    assert!(differing >= 5, "only {differing} supersets cost a ray: this tests nothing");
    Ok(())
}
