//! Choices that change weights keep the mean.

use super::common::{Moments, Random};
use super::{DEPTH, assert_same_mean, contributions, mean, rooms, sparing_scenes, worlds};
use glam::UVec2;
use pathspace::gallery;
use pathspace::geometry::{Place, Sphere};
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, LightWalks, Roulette, Scratch, TechniqueSet};
use pathspace::scene::{Material, Scene, WithNeeds};
use rooms::{Room, lambert, v};

/// Dropping redundant techniques, needless light walks, or drawing another number of light walks
/// changes weights, not means.
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
    let sparing =
        TechniqueSet::BIDIRECTIONAL.without_needless_light_walks(&world.needs(), Place::Dirac);
    assert!(!sparing.has_light_walk());
    assert_same_mean(
        "sparing",
        mean(&world, &camera, &Bidirectional { techniques: sparing, ..bidirectional }, 60_000),
        reference,
        0.02,
    );
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0)] {
        for exponent in [-2, 1] {
            for (connections, lens_first) in [(true, false), (false, false), (false, true)] {
                let light_walks = LightWalks::power_of_two(exponent).expect("small");
                let techniques = TechniqueSet {
                    light_walks,
                    connections,
                    lens_first,
                    ..TechniqueSet::BIDIRECTIONAL
                };
                let integrator = Bidirectional { techniques, heuristic, ..bidirectional };
                let samples = if exponent > 0 { 15_000 } else { 30_000 };
                assert_same_mean(
                    &format!("{techniques}"),
                    mean(&world, &camera, &integrator, samples),
                    reference,
                    0.025,
                );
            }
        }
    }
}

/// Lens sampling first, in a scene where the camera sees Dirac lobes, too: the camera walk draws
/// what is seen in them, and nothing else.
#[test]
fn lens_sampling_first_keeps_the_mean_behind_glass() {
    let mut room = Room::open(lambert(0.6, 0.6, 0.6));
    room.lamp(0.6, 4.0);
    room.sphere(
        Sphere::new(v(0.3, -0.5, 0.9), 0.3),
        Material::Mirror { reflectance: Rgb::splat(0.8) },
    );
    let (world, camera) = (room.build(), rooms::camera());
    let bidirectional = Bidirectional { depth: DEPTH, ..Bidirectional::default() };
    let techniques =
        TechniqueSet { connections: false, lens_first: true, ..TechniqueSet::BIDIRECTIONAL };
    let first = Bidirectional { techniques, ..bidirectional };
    assert_same_mean(
        "lens first",
        mean(&world, &camera, &first, 60_000),
        mean(&world, &camera, &bidirectional, 30_000),
        0.02,
    );
    let kinds = contributions(&world, &camera, &first, 2000).0;
    assert!(
        kinds.iter().any(|c| c.technique.t > 2)
            && kinds.iter().all(|c| c.technique.t != 2 || c.weight == 0.0)
    );
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

/// Weights sum to one whatever the number of light walks, and shadow roulette keeps the mean and
/// saves rays.
#[test]
fn weights_with_sample_counts_are_the_definitions() {
    let scene = gallery::build("cornell-box", UVec2::splat(8)).expect("a scene");
    for exponent in [-3, 2] {
        let techniques = TechniqueSet {
            light_walks: LightWalks::power_of_two(exponent).expect("small"),
            ..TechniqueSet::BIDIRECTIONAL
        };
        let integrator = Bidirectional { techniques, depth: DEPTH, ..Bidirectional::default() };
        let (mut sampler, mut scratch, mut seen) = (Random::new(4), Scratch::default(), 0);
        for _ in 0..300 {
            let film = worlds::film_sample(&*scene.camera, &mut sampler);
            integrator.for_each_path(
                &scene.world,
                &*scene.camera,
                film,
                &mut sampler,
                &mut scratch,
                |path, contribution| {
                    let verification = path.verify(&techniques, integrator.heuristic);
                    assert!(verification.worst() < 1e-6, "{path:?} {verification:?}");
                    let share = techniques.count(path.technique());
                    assert_eq!(contribution.value, path.value() * (1.0 / share));
                    seen += 1;
                },
            );
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
                (
                    mean(&world, &camera, &integrator, 30_000),
                    contributions(&world, &camera, &integrator, 2000).1.shadow_rays,
                )
            })
        };
    }
    both!(|t| PathTracer { depth: DEPTH, roulette: roulette(t), ..PathTracer::default() });
    both!(|t| LightTracer { depth: DEPTH, roulette: roulette(t) });
    both!(|t| Bidirectional { depth: DEPTH, roulette: roulette(t), ..Bidirectional::default() });
}
