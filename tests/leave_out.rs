//! What is left out changes nothing: pruned and unpruned integrators contribute the same to the bit where pruned techniques contribute nothing, and have the
//! same mean where the choice of a set changes weights; rays equal their closed forms; what the adaptive integrator decides is deterministic, unbiased and good.
#![allow(missing_docs, reason = "a test program")]

mod common;
#[path = "common/rooms.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod rooms;
mod worlds;

use common::{Moments, Random};
use glam::{DVec3, UVec2};
use pathspace::endpoint::{Camera, ConstantEnvironment, PinholeCamera, PointLight, SpotLight};
use pathspace::film::{Contribution, FilmSample, Sink};
use pathspace::geometry::{Disk, Place, Quad, Sphere};
use pathspace::integrator::{Adaptive, Bidirectional, Decision, Depth, Integrator, LightTracer, PathTracer, UniformArea};
use pathspace::math::Rgb;
use pathspace::path::{Counters, Family, Heuristic, LightWalks, Reason, Roulette, Scratch, TechniqueSet};
use pathspace::render::{Budget, Render, Rendering, Settings, unattended};
use pathspace::sampler::{SampleSource, Sampler, Stratified};
use pathspace::scene::{Emission, Material, Needs, Scene, SurfaceArea, WithNeeds, World, gallery};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rooms::{Room, lambert, v};
use worlds::{Result, TestScene};

const DEPTH: Depth = Depth::up_to(5);

/// All integrators on one scene, by name, as a function of a visitor; a list cannot hold them.
macro_rules! for_each_integrator {
    ($integrator:ident => $body:block) => {{
        {
            let $integrator = UniformArea { depth: DEPTH, ..UniformArea::default() };
            $body
        }
        {
            let $integrator = PathTracer { depth: DEPTH, ..PathTracer::default() };
            $body
        }
        {
            let $integrator = LightTracer { depth: DEPTH, ..LightTracer::default() };
            $body
        }
        {
            let $integrator = Bidirectional { depth: DEPTH, ..Bidirectional::default() };
            $body
        }
    }};
}

/// Contributions that are not zero and the counters of samples with numbers that depend on (stream, sample) alone.
fn contributions<S: SurfaceArea, I: Integrator<S>>(
    scene: &S,
    camera: &(dyn Camera + Send),
    integrator: &I,
    samples: u32,
) -> (Vec<Contribution>, Counters) {
    let (mut sink, mut scratch) = (Vec::new(), Scratch::default());
    let source = Stratified { seed: 7, samples_per_pixel: samples };
    for i in 0..samples {
        let mut sampler = source.sampler(0, i);
        let film = FilmSample { raster: camera.film().from_window(sampler.next_2d()), ..FilmSample::default() };
        integrator.sample(scene, camera, film, &mut sampler, &mut sink, &mut scratch);
    }
    // Points of one flat surface see each other at angles that are zero up to rounding.
    sink.retain(|c| (c.value * c.weight).max_component() > 1e-25);
    (sink, scratch.counters)
}

/// Whether the pruned integrator contributes what the unpruned one does, and with no more rays. Where a redundant technique was dropped weights differ, and so do
/// single contributions; means are compared then.
fn assert_nothing_is_lost<I>(name: &str, world: &World, camera: &(dyn Camera + Send), integrator: &I, samples: u32) -> u64
where
    I: Integrator<World> + for<'a> Integrator<WithNeeds<'a, World>>,
{
    let (pruned, fewer) = contributions(world, camera, integrator, samples);
    let (all, more) = contributions(&WithNeeds::all(world), camera, integrator, samples);
    let what = format!("{name}, {}: {}", Integrator::<World>::name(integrator), Integrator::<World>::left_out(integrator, &world.needs()));
    assert!(fewer.rays() <= more.rays() && fewer.connections <= more.connections, "{what}: {fewer:?} {more:?}");
    let redundant = Integrator::<World>::left_out(integrator, &world.needs()).families().any(|(_, reason)| reason == Reason::Redundant);
    if !redundant {
        assert!(pruned == all, "{what}: {} contributions of {}", pruned.len(), all.len());
    }
    more.rays() - fewer.rays()
}

/// Scenes that need little, each with the rays that leaving out must save.
fn sparing_scenes() -> Vec<(&'static str, World, PinholeCamera, bool)> {
    let eye = |position, target| PinholeCamera::new(position, target, DVec3::Z, 50.0, UVec2::splat(8)).expect("valid");
    let mirror = Material::Mirror { reflectance: Rgb::splat(0.8) };
    let mut scenes = Vec::new();

    let mut room = Room::closed_above(lambert(0.5, 0.5, 0.5));
    room.light(PointLight::new(v(0.3, 0.2, 1.5), Rgb::WHITE).expect("valid"));
    scenes.push(("point light alone", room.build(), rooms::camera(), true));

    let mut room = Room::default();
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), mirror.clone());
    let lamp = room.sphere(Sphere::new(v(0.0, 0.0, 1.0), 0.3), Material::Black);
    room.emit(lamp, Rgb::WHITE, false);
    scenes.push(("mirror", room.build(), rooms::camera(), true));

    let mut room = Room::default();
    room.sphere(Sphere::new(v(0.0, 0.0, 0.5), 0.5), lambert(0.5, 0.6, 0.7));
    room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
    scenes.push(("ball under a sky", room.build(), rooms::camera(), true));

    let mut room = Room::default();
    room.disk(v(0.0, 0.0, 0.5), v(0.3, -1.0, 1.0), 0.8, lambert(0.5, 0.6, 0.7));
    room.light(PointLight::new(v(0.3, -1.0, 1.5), Rgb::WHITE).expect("valid"));
    scenes.push(("one disk", room.build(), rooms::camera(), true));

    // The lamp is above the rest and shines up; the camera looks down on it.
    let mut room = Room::closed_above(lambert(0.5, 0.5, 0.5));
    let lamp = room.quad(v(-0.5, -0.5, 2.5), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), lambert(0.3, 0.3, 0.3));
    room.emit(lamp, Rgb::WHITE, false);
    scenes.push(("lamp that shines away", room.build(), eye(v(0.0, -3.0, 5.0), v(0.0, 0.0, 2.5)), true));

    let mut room = Room::open(lambert(0.5, 0.5, 0.5));
    room.light(PointLight::new(v(0.0, 0.0, 1.5), Rgb::BLACK).expect("valid"));
    scenes.push(("black light", room.build(), rooms::camera(), true));
    scenes
}

#[test]
fn pruned_contributions_are_the_same_to_the_bit() -> Result {
    for TestScene { name, world, camera } in worlds::all()? {
        for_each_integrator!(integrator => { assert_nothing_is_lost(&name, &world, &*camera, &integrator, 400); });
    }
    for (name, world, camera, saves) in sparing_scenes() {
        let mut saved = 0;
        for_each_integrator!(integrator => { saved += assert_nothing_is_lost(name, &world, &camera, &integrator, 400); });
        assert_eq!(saved > 0, saves, "{name}: {}", world.needs());
    }
    Ok(())
}

#[test]
fn what_scenes_need() {
    let needs: Vec<(&str, Needs)> = sparing_scenes().iter().map(|(name, world, ..)| (*name, world.needs())).collect();
    let of = |name: &str| needs.iter().find(|(other, _)| *other == name).expect("known").1;
    let has = |name: &str, need| of(name).contains(need);
    assert!(!has("point light alone", Needs::HITTABLE_LIGHTS) && has("point light alone", Needs::DIRAC_LIGHTS | Needs::INTERREFLECTION));
    assert!(!has("mirror", Needs::FINITE_LOBES) && !has("mirror", Needs::DIRAC_LIGHTS));
    assert_eq!(["ball under a sky", "one disk", "lamp that shines away"].map(|name| of(name).most_bounces()), [Some(1), Some(1), Some(0)]);
    assert!(!(of("black light").contains(Needs::HITTABLE_LIGHTS) || of("black light").contains(Needs::DIRAC_LIGHTS)));
    // With light inside it a ball has an inside; of two, one lights the other; and glass lets light in.
    let ball = |second: bool, lamp: bool, material: Material| {
        let mut room = Room::default();
        room.sphere(Sphere::new(DVec3::ZERO, 1.0), material);
        if second {
            room.disk(v(0.0, 0.0, 3.0), DVec3::Z, 1.0, lambert(0.5, 0.5, 0.5));
        }
        if lamp {
            room.light(PointLight::new(DVec3::ZERO, Rgb::WHITE).expect("valid"));
        }
        room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
        room.build().needs().most_bounces()
    };
    let clay = || lambert(0.5, 0.5, 0.5);
    assert_eq!(ball(false, false, clay()), Some(1));
    assert_eq!([ball(true, false, clay()), ball(false, true, clay()), ball(false, false, Material::Null)], [None; 3]);
    for (name, light, scattering) in [("cornell-box", true, None), ("smooth-mesh", true, None)] {
        let world = gallery::build(name, UVec2::ONE).expect("a scene").world;
        assert_eq!((world.needs().contains(Needs::HITTABLE_LIGHTS), world.needs().most_bounces()), (light, scattering));
    }
}

#[test]
fn reasons_are_given() {
    for (name, world, ..) in sparing_scenes() {
        let left_out = Render::<World>::left_out(&Bidirectional::default(), &world);
        let set = Render::<World>::techniques(&Bidirectional::default(), &world);
        let reason = |family| left_out.families().find(|(f, _)| *f == family).map(|(_, reason)| reason);
        match name {
            "point light alone" => assert_eq!(reason(Family::EmitterHits), Some(Reason::NoHittableLight)),
            "mirror" => {
                assert_eq!(reason(Family::Connections), Some(Reason::NoFiniteLobe));
                assert_eq!(reason(Family::LensSampling), Some(Reason::Redundant));
                assert_eq!(set, TechniqueSet { emitter_hits: true, ..TechniqueSet::NONE });
            }
            "lamp that shines away" => assert_eq!(reason(Family::EmitterSampling), Some(Reason::NoIllumination)),
            "black light" => assert_eq!((set, reason(Family::LensSampling)), (TechniqueSet::NONE, Some(Reason::NoLight))),
            _ => assert_eq!(left_out.most_bounces(), Some(1), "{name}"),
        }
        assert!(!left_out.is_empty() && !left_out.to_string().is_empty());
    }
}

/// A point light that a lens of finite area sees, with no surface to connect to: (1, 1) alone draws it.
#[test]
fn a_point_light_is_seen_through_a_lens() {
    let mut room = Room::default();
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), Material::Mirror { reflectance: Rgb::WHITE });
    room.light(PointLight::new(v(0.0, 0.0, 1.0), Rgb::WHITE).expect("valid"));
    let (world, camera) = (room.build(), rooms::lens_camera());
    for_each_integrator!(integrator => { assert_nothing_is_lost("lens", &world, &camera, &integrator, 300); });
    let (seen, _) = contributions(&world, &camera, &LightTracer::default(), 300);
    assert!(!seen.is_empty());
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
    let shape = (0..3u8, point(), point(), 0.2..1.0f64, material, prop::option::weighted(0.3, any::<bool>()));
    let plan = (prop::collection::vec(shape, 0..3), prop::collection::vec((0..4u8, point()), 0..2), any::<bool>());
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
                    0 if i == 0 => room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid")),
                    1 => room.light(SpotLight::new(position, -DVec3::Z, Rgb::WHITE, 20.0, 60.0).expect("valid")),
                    _ => room.light(PointLight::new(position, Rgb::WHITE).expect("valid")),
                }
            }
            let Ok(world) = room.builder.build() else { return Ok(()) };
            let camera: Box<dyn Camera + Send> = if lens { Box::new(rooms::lens_camera()) } else { Box::new(rooms::camera()) };
            for_each_integrator!(integrator => {
                saved.set(saved.get() + assert_nothing_is_lost("random", &world, &*camera, &integrator, 40));
            });
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(saved.get() > 1000, "{} rays saved: the scenes need everything", saved.get());
}

/// Mean and standard error of the image's luminance per sample.
fn mean<S: Scene, I: Integrator<S>>(scene: &S, camera: &(dyn Camera + Send), integrator: &I, samples: u32) -> Moments {
    struct Sum(f64);
    impl Sink for Sum {
        fn add(&mut self, contribution: &Contribution) {
            self.0 += contribution.value.luminance() * contribution.weight;
        }
    }
    let (mut sampler, mut scratch, mut moments) = (Random::new(3), Scratch::default(), Moments::default());
    for _ in 0..samples {
        let (film, mut sum) = (worlds::film_sample(camera, &mut sampler), Sum(0.0));
        integrator.sample(scene, camera, film, &mut sampler, &mut sum, &mut scratch);
        moments.add(sum.0);
    }
    moments
}

#[track_caller]
fn assert_same_mean(name: &str, a: Moments, b: Moments, resolution: f64) {
    let error = a.standard_error().hypot(b.standard_error());
    assert!((a.mean() - b.mean()).abs() <= 4.0 * error + 1e-12 * b.mean(), "{name}: {a:?} {b:?}");
    assert!(error <= resolution * b.mean(), "{name}: {error} of {} is too coarse", b.mean());
}

/// Dropping redundant techniques, needless light walks, or drawing another number of light walks changes weights, not means.
#[test]
fn choices_of_sets_keep_the_mean() {
    let (name, world, camera, _) = sparing_scenes().swap_remove(1);
    let bidirectional = Bidirectional { depth: DEPTH, ..Bidirectional::default() };
    assert_same_mean(
        name,
        mean(&world, &camera, &bidirectional, 30_000),
        mean(&WithNeeds::all(&world), &camera, &bidirectional, 30_000),
        0.02,
    );

    let mut room = Room::open(lambert(0.6, 0.6, 0.6));
    room.lamp(0.5, 4.0);
    let (world, camera) = (room.build(), rooms::camera());
    let reference = mean(&world, &camera, &bidirectional, 40_000);
    let sparing = TechniqueSet::BIDIRECTIONAL.without_needless_light_walks(&world.needs(), Place::Dirac);
    assert!(!sparing.has_light_walk());
    assert_same_mean("sparing", mean(&world, &camera, &Bidirectional { techniques: sparing, ..bidirectional }, 60_000), reference, 0.02);
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0)] {
        for exponent in [-2, 1] {
            for (connections, lens_first) in [(true, false), (false, false), (false, true)] {
                let light_walks = LightWalks::power_of_two(exponent).expect("small");
                let techniques = TechniqueSet { light_walks, connections, lens_first, ..TechniqueSet::BIDIRECTIONAL };
                let integrator = Bidirectional { techniques, heuristic, ..bidirectional };
                let samples = if exponent > 0 { 15_000 } else { 30_000 };
                assert_same_mean(&format!("{techniques}"), mean(&world, &camera, &integrator, samples), reference, 0.025);
            }
        }
    }
}

/// Lens sampling first, in a scene where the camera sees Dirac lobes, too: the camera walk draws what is seen in them, and nothing else.
#[test]
fn lens_sampling_first_keeps_the_mean_behind_glass() {
    let mut room = Room::open(lambert(0.6, 0.6, 0.6));
    room.lamp(0.6, 4.0);
    room.sphere(Sphere::new(v(0.3, -0.5, 0.9), 0.3), Material::Mirror { reflectance: Rgb::splat(0.8) });
    let (world, camera) = (room.build(), rooms::camera());
    let bidirectional = Bidirectional { depth: DEPTH, ..Bidirectional::default() };
    let techniques = TechniqueSet { connections: false, lens_first: true, ..TechniqueSet::BIDIRECTIONAL };
    let first = Bidirectional { techniques, ..bidirectional };
    assert_same_mean("lens first", mean(&world, &camera, &first, 60_000), mean(&world, &camera, &bidirectional, 30_000), 0.02);
    let kinds = contributions(&world, &camera, &first, 2000).0;
    assert!(kinds.iter().any(|c| c.technique.t > 2) && kinds.iter().all(|c| c.technique.t != 2 || c.weight == 0.0));
    // The general kernel with weights does the same.
    let (mut sampler, mut scratch, mut worst) = (Random::new(8), Scratch::default(), 0.0f64);
    for _ in 0..500 {
        let film = worlds::film_sample(&camera, &mut sampler);
        first.for_each_path(&world, &camera, film, &mut sampler, &mut scratch, |path, _| {
            let verification = path.verify(&techniques, first.heuristic);
            worst = worst.max(verification.weight_error).max(verification.weight_sum_error);
        });
    }
    assert!(worst < 1e-9, "{worst}");
}

/// Weights sum to one whatever the number of light walks, and shadow roulette keeps the mean and saves rays.
#[test]
fn weights_with_sample_counts_are_the_definitions() {
    let scene = gallery::build("cornell-box", UVec2::splat(8)).expect("a scene");
    for exponent in [-3, 2] {
        let techniques = TechniqueSet { light_walks: LightWalks::power_of_two(exponent).expect("small"), ..TechniqueSet::BIDIRECTIONAL };
        let integrator = Bidirectional { techniques, depth: DEPTH, ..Bidirectional::default() };
        let (mut sampler, mut scratch, mut seen) = (Random::new(4), Scratch::default(), 0);
        for _ in 0..300 {
            let film = worlds::film_sample(&*scene.camera, &mut sampler);
            integrator.for_each_path(&scene.world, &*scene.camera, film, &mut sampler, &mut scratch, |path, contribution| {
                let verification = path.verify(&techniques, integrator.heuristic);
                assert!(verification.worst() < 1e-6, "{path:?} {verification:?}");
                let share = techniques.count(path.technique());
                assert_eq!(contribution.value, path.value() * (1.0 / share));
                seen += 1;
            });
        }
        assert!(seen > 300, "{seen}");
    }
}

#[test]
fn shadow_roulette_keeps_the_mean_and_saves_rays() {
    let mut room = Room::open(lambert(0.6, 0.6, 0.6));
    room.lamp(0.5, 4.0);
    let (world, camera) = (room.build(), rooms::camera());
    let roulette = |shadow_threshold| Roulette { shadow_threshold, ..Roulette::default() };
    let rays = |integrator: &dyn Fn(f64) -> (Moments, u64)| {
        let ((all, rays), (some, fewer)) = (integrator(0.0), integrator(0.5));
        assert_same_mean("shadow roulette", some, all, 0.03);
        assert!((fewer as f64) < 0.95 * rays as f64, "{fewer} of {rays}");
    };
    macro_rules! both {
        ($make:expr) => {
            rays(&|threshold| {
                let integrator = $make(threshold);
                (mean(&world, &camera, &integrator, 30_000), contributions(&world, &camera, &integrator, 2000).1.shadow_rays)
            })
        };
    }
    both!(|t| PathTracer { depth: DEPTH, roulette: roulette(t), ..PathTracer::default() });
    both!(|t| LightTracer { depth: DEPTH, roulette: roulette(t) });
    both!(|t| Bidirectional { depth: DEPTH, roulette: roulette(t), ..Bidirectional::default() });
}

/// analytic.json F17 in a closed box with a lamp: never more rays than the closed forms, which hold where nothing is culled.
#[test]
fn culling_keeps_rays_below_the_closed_forms() {
    let at = worlds::Placement::UNIT;
    let mut builder = pathspace::scene::WorldBuilder::new();
    let wall = builder.add_material("wall", lambert(0.7, 0.7, 0.7)).expect("valid");
    for (i, (n, u, w)) in
        [(DVec3::X, DVec3::Y, DVec3::Z), (DVec3::Y, DVec3::Z, DVec3::X), (DVec3::Z, DVec3::X, DVec3::Y)].into_iter().enumerate()
    {
        for side in [-1.0, 1.0] {
            let (u, w) = if side < 0.0 { (u, w) } else { (w, u) };
            builder
                .add_quad(format!("{i} {side}"), Quad { origin: n * side - u - w, edge_u: u * 2.0, edge_v: w * 2.0 }, wall)
                .expect("valid");
        }
    }
    let lamp = Disk { center: at.point(0.0, 0.99, 0.0), normal: DVec3::NEG_Y, radius: 0.3 };
    let lamp = builder.add_disk("lamp", lamp, wall).expect("valid");
    builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false }).expect("valid");
    let world = builder.build().expect("valid");
    let camera = PinholeCamera::new(at.point(0.0, 0.0, 0.9), DVec3::ZERO, DVec3::Y, 60.0, UVec2::splat(8)).expect("valid");
    let roulette = Roulette::NEVER;
    for edges in [2u32, 3, 5, 10] {
        let (depth, d) = (Depth::up_to(edges - 1), f64::from(edges));
        let rays = |counters: Counters| counters.rays() as f64 / counters.samples as f64;
        let path = rays(contributions(&world, &camera, &PathTracer { depth, roulette, ..PathTracer::default() }, 500).1);
        let light = rays(contributions(&world, &camera, &LightTracer { depth, roulette }, 500).1);
        let both = rays(contributions(&world, &camera, &Bidirectional { depth, roulette, ..Bidirectional::default() }, 500).1);
        let bound = d + (d - 1.0) + 2.0 * (d - 1.0) + 0.5 * (d - 1.0) * (d - 2.0);
        assert!(path < 2.0 * d - 1.0 && path > d, "path tracing, D = {d}: {path}");
        assert!(light < 2.0 * d - 1.0 && light > d - 1.0, "light tracing, D = {d}: {light}");
        assert!(both < bound && both > 2.0 * d - 1.0, "bidirectional, D = {d}: {both} of {bound}");
    }
}

fn adapt(world: &World, camera: &dyn Camera, depth: Depth, samples: u32, seed: u64) -> Rendering {
    let settings = Settings { budget: Budget::Samples(samples), seed, threads: Some(1), ..Settings::default() };
    Adaptive { depth, ..Adaptive::default() }.render(world, camera, &settings, &mut unattended).expect("valid settings")
}

fn decide(world: &World, camera: &dyn Camera, depth: Depth, pilot: f64) -> Decision {
    let settings = Settings { budget: Budget::Samples(1), seed: 5, threads: Some(1), ..Settings::default() };
    // A pilot as for a long rendering.
    let adaptive = Adaptive { depth, pilot, ..Adaptive::default() };
    adaptive.render(world, camera, &settings, &mut unattended).expect("valid settings").decision.expect("a decision")
}

/// Variance × deterministic cost of an integrator per sample, from `seeds` images.
fn work(world: &World, camera: &dyn Camera, integrator: &dyn Render<World>, samples: u32, seeds: u64) -> f64 {
    let (mut images, mut cost) = (Vec::new(), 0.0);
    for seed in 0..seeds {
        let settings = Settings { budget: Budget::Samples(samples), seed: seed << 32, threads: Some(1), ..Settings::default() };
        let rendering = integrator.render(world, camera, &settings, &mut unattended).expect("valid settings");
        cost += rendering.counters.cost() / seeds as f64;
        images.push(rendering.image);
    }
    let pixels = images[0].pixels().len();
    let variance = |i: usize| {
        let mut moments = Moments::default();
        images.iter().for_each(|image| moments.add(image.pixels()[i].luminance()));
        moments.variance()
    };
    cost * (0..pixels).map(variance).sum::<f64>() / pixels as f64
}

/// What a set's kernel costs over the general one, which counts do not know: the dedicated ones are cheaper.
fn kernel(set: &TechniqueSet) -> f64 {
    if set.lens_first || !set.has_camera_walk() || !set.has_light_walk() { 0.8 } else { 1.0 }
}

#[test]
fn the_same_seed_decides_the_same_on_any_number_of_threads() {
    let scene = gallery::build("cornell-box", UVec2::splat(16)).expect("a scene");
    let render = |threads| {
        let settings = Settings { budget: Budget::Samples(8), seed: 9, threads: Some(threads), ..Settings::default() };
        Adaptive { depth: DEPTH, ..Adaptive::default() }
            .render(&scene.world, &*scene.camera, &settings, &mut unattended)
            .expect("valid settings")
    };
    let one = render(1);
    for threads in [2, 5] {
        let other = render(threads);
        assert_eq!(other.decision, one.decision);
        assert_eq!((other.image.pixels(), other.counters, other.techniques), (one.image.pixels(), one.counters, one.techniques));
    }
    let decision = one.decision.expect("a decision");
    assert_eq!(one.techniques, decision.chosen.set);
    assert_eq!(one.counters.samples, 8 * 256);
    assert!(decision.samples >= 512 && decision.candidates.len() > 20);
    let shares = |f: &dyn Fn(&pathspace::integrator::TechniqueRecord) -> f64| decision.techniques.iter().map(f).sum::<f64>();
    approx::assert_relative_eq!(shares(&|r| r.energy), 1.0, max_relative = 0.01);
    approx::assert_relative_eq!(shares(&|r| r.variance), 1.0, max_relative = 1e-9);
    let text = decision.to_string();
    assert!(text.contains("gain over plain bidirectional") && text.contains("left out") && text.contains("kept"), "{text}");
}

/// What the pilot predicts for sets that it did not run is what they are when they run.
#[test]
fn predictions_hold() {
    let side = 32;
    let scene = gallery::build("cornell-box", UVec2::splat(side)).expect("a scene");
    let decision = decide(&scene.world, &*scene.camera, DEPTH, 500.0);
    let mut checked = 0;
    for candidate in &decision.candidates {
        let set = candidate.set;
        let exponent = set.light_walks.count().log2();
        let plain = exponent == 0.0 && set.emitter_sampling && set.lens_sampling;
        if !(plain || (exponent == 1.0 && set.emitter_sampling && set.lens_first) || !set.has_camera_walk()) {
            continue;
        }
        let samples = if exponent > 0.0 { 4 } else { 8 };
        let integrator = Adaptive { depth: DEPTH, techniques: Some(set), ..Adaptive::default() };
        let measured = work(&scene.world, &*scene.camera, &integrator, samples, 8) / f64::from(side * side) * kernel(&set);
        let ratio = measured / candidate.work();
        println!("{set}: predicted {:.4}, measured {measured:.4}, ratio {ratio:.3}", candidate.work());
        assert!((0.7..1.4).contains(&ratio), "{set}: {ratio}");
        checked += 1;
    }
    assert!(checked >= 4, "{checked}");
}

/// The image is the same whatever is decided.
#[test]
fn the_adaptive_image_is_unbiased() -> Result {
    for scene in [worlds::mixtures(worlds::Placement::UNIT)?, worlds::parallel(worlds::Placement::UNIT)?] {
        let depth = Depth::up_to(3);
        let means = |render: &dyn Fn(u64) -> Rendering| {
            let mut moments = Moments::default();
            (0..24).for_each(|seed| moments.add(render(seed << 32).image.mean().luminance()));
            moments
        };
        let adaptive = means(&|seed| adapt(&scene.world, &*scene.camera, depth, 8, seed));
        let plain = means(&|seed| {
            let settings = Settings { budget: Budget::Samples(8), seed: seed + 77, threads: Some(1), ..Settings::default() };
            let integrator = Bidirectional { depth, ..Bidirectional::default() };
            integrator.render(&scene.world, &*scene.camera, &settings, &mut unattended).expect("valid settings")
        });
        assert_same_mean(&scene.name, adaptive, plain, 0.03);
    }
    Ok(())
}

/// Where light walks are of no use, the adaptive integrator beats plain bidirectional path tracing by at least half. Measured as variance × counted cost, with the
/// pilot's share added.
#[test]
fn useless_light_walks_are_left_out() {
    let mut furnace = Room::default();
    let wall = furnace.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, lambert(0.5, 0.5, 0.5));
    furnace.emit(wall, Rgb::WHITE, false);
    let inside = PinholeCamera::new(v(0.1, 0.2, 0.3), DVec3::X, DVec3::Z, 60.0, UVec2::splat(16)).expect("valid");
    let mesh = gallery::build("smooth-mesh", UVec2::splat(16)).expect("a scene");
    let cornell = gallery::build("cornell-box", UVec2::splat(16)).expect("a scene");
    let scenes: [(&str, &World, &dyn Camera); 3] = [
        ("furnace", &furnace.build(), &inside),
        ("smooth mesh", &mesh.world, &*mesh.camera),
        ("Cornell box", &cornell.world, &*cornell.camera),
    ];
    for (name, world, camera) in scenes {
        let decision = decide(world, camera, DEPTH, 100.0);
        let plain = work(world, camera, &Bidirectional { depth: DEPTH, ..Bidirectional::default() }, 16, 8);
        let chosen = Adaptive { depth: DEPTH, techniques: Some(decision.chosen.set), ..Adaptive::default() };
        let chosen = work(world, camera, &chosen, 16, 8) * kernel(&decision.chosen.set);
        println!("{name}: {}, expected {:.2}, measured {:.2}", decision.chosen.set, decision.expected_gain(), plain / chosen);
        assert!(plain >= 1.5 * 1.04 * chosen, "{name}: {} of {}", chosen, plain);
    }
}

/// Stress row S36: a narrow spot light. Neither plain nor adaptive bidirectional path tracing is much worse than the best of its subsets.
#[test]
fn stress_s36_narrow_spot() {
    let mut room = Room::closed_above(lambert(0.6, 0.6, 0.6));
    room.light(SpotLight::new(v(0.0, 0.0, 1.8), v(0.1, 0.2, -1.0), Rgb::splat(30.0), 3.0, 4.0).expect("valid"));
    let (world, camera) = (room.build(), rooms::camera());
    let run = |techniques, samples| {
        let integrator = Adaptive { depth: Depth::up_to(3), techniques: Some(techniques), ..Adaptive::default() };
        work(&world, &camera, &integrator, samples, 8)
    };
    let all = TechniqueSet::BIDIRECTIONAL;
    let subsets = [
        TechniqueSet { connections: false, lens_sampling: false, ..all },
        TechniqueSet { emitter_sampling: false, connections: false, ..all },
        TechniqueSet { connections: false, ..all },
        TechniqueSet { lens_sampling: false, ..all },
        all,
    ];
    let best = subsets.map(|set| run(set, 24)).into_iter().fold(f64::INFINITY, f64::min);
    let decision = decide(&world, &camera, Depth::up_to(3), 100.0);
    let adaptive = run(decision.chosen.set, 24);
    println!("{}: {:.3} of the best subset", decision.chosen.set, adaptive / best);
    assert!(adaptive <= 1.2 * best, "{}: {adaptive} against {best}", decision.chosen.set);
}
