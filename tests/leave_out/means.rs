//! Choices that change weights keep the mean.

use super::common::Random;
use super::{DEPTH, assert_same_mean, mean, rooms, sparing_scenes, worlds};
use glam::UVec2;
use pathspace::film::Sample;
use pathspace::gallery;
use pathspace::geometry::Place;
use pathspace::integrator::{Bidirectional, Stage, WithNeeds};
use pathspace::path::{Heuristic, LightSubpaths, Scratch, TechniqueSet, Weighting};
use pathspace::scene::Scene;
use rooms::{Room, lambert};

/// Dropping redundant techniques, needless light subpaths, or drawing another number of them
/// changes weights, not means.
#[test]
fn choices_of_sets_keep_the_mean() {
    let (name, world, camera, _) = sparing_scenes().swap_remove(1);
    let bidirectional = Bidirectional { depth: DEPTH, ..Bidirectional::default() };
    assert_same_mean(
        name,
        mean(&world, &camera, &bidirectional, 30_000),
        mean(&world, &camera, &WithNeeds::all(bidirectional), 30_000),
        0.02,
    );

    let mut room = Room::open(lambert(0.6, 0.6, 0.6));
    room.lamp(0.5, 4.0);
    let (world, camera) = (room.build(), rooms::camera());
    let reference = mean(&world, &camera, &bidirectional, 40_000);
    let sparing = TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };
    assert!(sparing.is_complete(&world.needs(), Place::Dirac));
    assert_same_mean(
        "sparing",
        mean(&world, &camera, &Bidirectional { techniques: sparing, ..bidirectional }, 60_000),
        reference,
        0.02,
    );
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0)] {
        for exponent in [-2, 1] {
            for connections in [true, false] {
                let light_subpaths = LightSubpaths::power_of_two(exponent).expect("small");
                let techniques =
                    TechniqueSet { light_subpaths, connections, ..TechniqueSet::BIDIRECTIONAL };
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

/// Weights sum to one whatever the number of light subpaths.
#[test]
fn weights_with_sample_counts_are_the_definitions() {
    let scene = gallery::build("cornell-box", UVec2::splat(8)).expect("a scene");
    for exponent in [-3, 2] {
        let techniques = TechniqueSet {
            light_subpaths: LightSubpaths::power_of_two(exponent).expect("small"),
            ..TechniqueSet::BIDIRECTIONAL
        };
        let integrator = Bidirectional { techniques, depth: DEPTH, ..Bidirectional::default() };
        let (mut sampler, mut scratch, mut seen) = (Random::new(4), Scratch::default(), 0);
        for _ in 0..300 {
            let film = worlds::film_sample(&*scene.camera, &mut sampler);
            integrator.for_each_path(
                Stage::new(&scene.world, &*scene.camera),
                Sample { film, sampler: &mut sampler },
                &mut scratch,
                |path, contribution| {
                    let verification =
                        path.verify(&Weighting::new(techniques, integrator.heuristic));
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
