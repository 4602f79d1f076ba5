//! Decisions of the adaptive integrator.

use super::common::Moments;
use super::{DEPTH, assert_same_mean, rooms, worlds};
use glam::{DVec3, UVec2};
use pathspace::endpoint::{Camera, PinholeCamera, SpotLight};
use pathspace::gallery;
use pathspace::geometry::Sphere;
use pathspace::integrator::{
    Adaptive, Bidirectional, Caller, Decision, Depth, Integrator, Run, Stage,
};
use pathspace::math::Rgb;
use pathspace::path::TechniqueSet;
use pathspace::render::{Budget, Render, Rendering, Settings};
use pathspace::sampler::SamplerKind;
use pathspace::scene::World;
use rooms::{Room, lambert, v};
use worlds::Result;

fn adapt(world: &World, camera: &dyn Camera, depth: Depth, samples: u32, seed: u64) -> Rendering {
    let settings = Settings {
        budget: Budget::Samples(samples),
        seed,
        threads: Some(1),
        ..Settings::default()
    };
    Adaptive { depth, ..Adaptive::default() }
        .render(world, camera, &settings)
        .expect("valid settings")
}

fn of_set(techniques: TechniqueSet, depth: Depth) -> Bidirectional {
    Bidirectional { techniques, depth, ..Bidirectional::default() }
}

/// The decision before a long rendering.
fn decide(world: &World, camera: &dyn Camera, depth: Depth) -> Decision {
    let stage = Stage { samples: 1 << 30, seed: 5, ..Stage::new(world, camera) };
    let adaptive = Adaptive { depth, ..Adaptive::default() };
    let decision = adaptive.start(stage, &Caller).expect("a run").notes().decision;
    decision.expect("a decision")
}

/// Variance × deterministic cost of an integrator per sample, from `seeds` images.
fn work(
    world: &World,
    camera: &dyn Camera,
    integrator: &dyn Render<World>,
    samples: u32,
    seeds: u64,
) -> f64 {
    let (mut images, mut cost) = (Vec::new(), 0.0);
    for seed in 0..seeds {
        let settings = Settings {
            budget: Budget::Samples(samples),
            seed: seed << 32,
            threads: Some(1),
            // As where the decision was made; what trials cost is not the set's.
            observes_lights: false,
            // As the pilot's.
            sampler: SamplerKind::Independent,
            ..Settings::default()
        };
        let rendering = integrator.render(world, camera, &settings).expect("valid settings");
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

#[test]
fn the_same_seed_decides_the_same_on_any_number_of_threads() {
    let scene = gallery::build("cornell-box", UVec2::splat(16)).expect("a scene");
    let render = |threads| {
        let settings = Settings {
            budget: Budget::Samples(8),
            seed: 9,
            threads: Some(threads),
            ..Settings::default()
        };
        Adaptive { depth: DEPTH, ..Adaptive::default() }
            .render(&scene.world, &*scene.camera, &settings)
            .expect("valid settings")
    };
    let one = render(1);
    for threads in [2, 5] {
        let other = render(threads);
        assert_eq!(other.notes, one.notes);
        assert_eq!(
            (other.image.pixels(), other.counters, other.techniques),
            (one.image.pixels(), one.counters, one.techniques)
        );
    }
    let decision = one.notes.decision.expect("a decision");
    assert_eq!(one.techniques, decision.chosen.set);
    assert_eq!(one.counters.samples, 8 * 256);
    assert!(decision.samples() >= 512 && decision.candidates.len() > 10);
    assert!(decision.candidates.contains(&decision.chosen));
    assert_eq!(decision.plain().set, TechniqueSet::BIDIRECTIONAL);
    let text = decision.to_string();
    assert!(text.contains("gain over plain bidirectional") && text.contains("variance"), "{text}");
}

/// The pilot's estimates are what the sets are when they run.
#[test]
fn predictions_hold() {
    // Large enough that splats into the same pixel are rare, which the pilot takes for granted.
    let side = 64;
    let mut checked = 0;
    for name in ["cornell-box", "lamp-room"] {
        let scene = gallery::build(name, UVec2::splat(side)).expect("a scene");
        let decision = decide(&scene.world, &*scene.camera, DEPTH);
        for candidate in &decision.candidates {
            let set = candidate.set;
            let exponent = set.light_subpaths.count().log2();
            let has_splats = set.lens_sampling && set.next_event == set.has_camera_subpath();
            if exponent != 0.0 || !has_splats {
                continue;
            }
            let integrator = of_set(set, DEPTH);
            let measured = work(&scene.world, &*scene.camera, &integrator, 4, 8)
                / f64::from(side * side)
                * set.kernel_cost();
            let ratio = measured / candidate.work();
            println!(
                "{name}, {set}: predicted {:.4}, measured {measured:.4}, ratio {ratio:.3}",
                candidate.work()
            );
            assert!((0.8..1.25).contains(&ratio), "{name}, {set}: {ratio}");
            checked += 1;
        }
    }
    assert_eq!(checked, 5);
}

/// The image is the same whatever is decided.
#[test]
fn the_adaptive_image_is_unbiased() -> Result {
    for scene in
        [worlds::mixtures(worlds::Placement::UNIT)?, worlds::parallel(worlds::Placement::UNIT)?]
    {
        let depth = Depth::up_to(3);
        let means = |render: &dyn Fn(u64) -> Rendering| {
            let mut moments = Moments::default();
            (0..24).for_each(|seed| moments.add(render(seed << 32).image.mean().luminance()));
            moments
        };
        let adaptive = means(&|seed| adapt(&scene.world, &*scene.camera, depth, 8, seed));
        let plain = means(&|seed| {
            let settings = Settings {
                budget: Budget::Samples(8),
                seed: seed + 77,
                threads: Some(1),
                ..Settings::default()
            };
            let integrator = Bidirectional { depth, ..Bidirectional::default() };
            integrator.render(&scene.world, &*scene.camera, &settings).expect("valid settings")
        });
        assert_same_mean(&scene.name, adaptive, plain, 0.03);
    }
    Ok(())
}

/// The adaptive integrator beats plain bidirectional path tracing by at least half where light
/// walks are of no use. Measured as variance × counted cost, with the pilot's share added.
#[test]
fn useless_light_walks_are_left_out() {
    let mut furnace = Room::default();
    let wall = furnace
        .sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, lambert(0.5, 0.5, 0.5));
    furnace.emit(wall, Rgb::WHITE, false);
    let inside = PinholeCamera::new(v(0.1, 0.2, 0.3), DVec3::X, DVec3::Z, 60.0, UVec2::splat(16))
        .expect("valid");
    let mesh = gallery::build("smooth-mesh", UVec2::splat(16)).expect("a scene");
    // Small enough to be quick, large enough that splats into the same pixel are rare, which the
    // pilot takes for granted.
    let cornell = gallery::build("cornell-box", UVec2::splat(64)).expect("a scene");
    let scenes: [(&str, &World, &dyn Camera); 3] = [
        ("furnace", &furnace.build(), &inside),
        ("smooth mesh", &mesh.world, &*mesh.camera),
        ("Cornell box", &cornell.world, &*cornell.camera),
    ];
    for (name, world, camera) in scenes {
        let decision = decide(world, camera, DEPTH);
        let samples = if name == "Cornell box" { 4 } else { 16 };
        let plain = work(
            world,
            camera,
            &Bidirectional { depth: DEPTH, ..Bidirectional::default() },
            samples,
            8,
        );
        let chosen = of_set(decision.chosen.set, DEPTH);
        let chosen = work(world, camera, &chosen, samples, 8) * decision.chosen.set.kernel_cost();
        println!(
            "{name}: {}, expected {:.2}, measured {:.2}",
            decision.chosen.set,
            decision.expected_gain(),
            plain / chosen
        );
        assert!(plain >= 1.5 * 1.04 * chosen, "{name}: {} of {}", chosen, plain);
    }
}

/// Stress row S36: a narrow spot light. Neither plain nor adaptive bidirectional path tracing is
/// much worse than the best of its subsets.
#[test]
fn stress_s36_narrow_spot() {
    let mut room = Room::closed_above(lambert(0.6, 0.6, 0.6));
    room.light(
        SpotLight::new(v(0.0, 0.0, 1.8), v(0.1, 0.2, -1.0), Rgb::splat(30.0), 3.0, 4.0)
            .expect("valid"),
    );
    let (world, camera) = (room.build(), rooms::camera());
    let run = |techniques, samples| {
        let integrator = of_set(techniques, Depth::up_to(3));
        work(&world, &camera, &integrator, samples, 8)
    };
    let all = TechniqueSet::BIDIRECTIONAL;
    let subsets = [
        TechniqueSet { connections: false, lens_sampling: false, ..all },
        TechniqueSet { next_event: false, connections: false, ..all },
        TechniqueSet { connections: false, ..all },
        TechniqueSet { lens_sampling: false, ..all },
        all,
    ];
    let best = subsets.map(|set| run(set, 24)).into_iter().fold(f64::INFINITY, f64::min);
    let decision = decide(&world, &camera, Depth::up_to(3));
    let adaptive = run(decision.chosen.set, 24);
    println!("{}: {:.3} of the best subset", decision.chosen.set, adaptive / best);
    assert!(adaptive <= 1.2 * best, "{}: {adaptive} against {best}", decision.chosen.set);
}
