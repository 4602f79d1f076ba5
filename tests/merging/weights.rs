//! Weights of merges within one sum with all connections, on every test scene.

use crate::common::Random;
use crate::worlds::{self, Result, TestScene};
use pathspace::film::{Sample, Technique};
use pathspace::gallery;
use pathspace::integrator::{
    Arrivals, Bidirectional, Caller, Depth, Integrator, Merging, Run, Stage,
    VertexConnectionMerging, WithNeeds,
};
use pathspace::path::{Excluded, Heuristic, LightSubpaths, Scratch, TechniqueSet, Verification};

const SUM_TOLERANCE: f64 = 1e-12;

/// Numbers of paths, and the largest errors.
#[derive(Debug, Default)]
struct Audit {
    connected: usize,
    merged: usize,
    value: f64,
    weight: f64,
    sum: f64,
    constant_time: f64,
}

impl Audit {
    fn look(&mut self, verified: &Verification, difference: f64) {
        // Not `max` alone, which ignores what is not a number.
        assert!(verified.worst().is_finite() && difference.is_finite());
        self.value = self.value.max(verified.value_error);
        self.weight = self.weight.max(verified.weight_error);
        self.sum = self.sum.max(verified.weight_sum_error);
        self.constant_time = self.constant_time.max(difference);
    }
}

/// Draws passes of samples until there are enough paths of both kinds.
fn audit(
    scene: &TestScene,
    integrator: VertexConnectionMerging,
    seed: u64,
    paths: usize,
) -> Result<Audit> {
    let integrator = WithNeeds::all(integrator);
    let (mut sampler, mut scratch, mut audit) =
        (Random::new(seed), Scratch::default(), Audit::default());
    let stage = Stage { seed, ..Stage::new(&scene.world, &*scene.camera) };
    let arrivals = Arrivals::observe(stage, &Caller);
    let stage = Stage { arrival: arrivals.as_ref().map(|seen| &seen.arrival), ..stage };
    let mut run = integrator.start(stage, &Caller)?;
    run.keep_subpaths();
    for pass in 0..2000 {
        if audit.connected >= paths && audit.merged >= paths {
            break;
        }
        run.begin_pass(pass, &Caller)?;
        let weighting = *run.weighting();
        let (mut connected, mut merged) = (Audit::default(), Audit::default());
        for _ in 0..200 {
            let film = worlds::film_sample(&*scene.camera, &mut sampler);
            run.for_each_path(
                Sample { film, sampler: &mut sampler },
                &mut scratch,
                |path, contribution| {
                    assert!(weighting.set().contains(contribution.technique));
                    let difference = (contribution.weight - path.weight(&weighting)).abs();
                    connected.look(&path.verify(&weighting), difference);
                    connected.connected += 1;
                },
                |path, contribution| {
                    assert!(weighting.set().contains(contribution.technique));
                    assert_eq!(contribution.technique, path.technique());
                    assert_eq!(contribution.value, path.value(&weighting));
                    let difference = (contribution.weight - path.weight(&weighting)).abs();
                    merged.look(&path.verify(&weighting), difference);
                    merged.merged += 1;
                },
            );
        }
        for part in [connected, merged] {
            audit.connected += part.connected;
            audit.merged += part.merged;
            audit.value = audit.value.max(part.value);
            audit.weight = audit.weight.max(part.weight);
            audit.sum = audit.sum.max(part.sum);
            audit.constant_time = audit.constant_time.max(part.constant_time);
        }
    }
    Ok(audit)
}

#[test]
fn weights_of_connections_and_merges_sum_to_one_on_every_scene() -> Result {
    for scene in worlds::all()? {
        let all = TechniqueSet::BIDIRECTIONAL;
        let four = LightSubpaths::power_of_two(2).unwrap_or_default();
        let excluded = [Technique::new(1, 3), Technique::merge(2, 2), Technique::merge(3, 3)];
        let excluded = excluded.into_iter().try_fold(Excluded::NONE, Excluded::with);
        let excluded = excluded.ok_or("long paths")?;
        let sets = [
            (all, Heuristic::Balance),
            (all, Heuristic::Power(2.0)),
            (TechniqueSet { lens_sampling: false, ..all }, Heuristic::Power(2.0)),
            (TechniqueSet { light_subpaths: four, next_event: false, ..all }, Heuristic::Balance),
            (TechniqueSet { excluded, ..all }, Heuristic::Power(2.0)),
        ];
        // 100 000 paths of each scene of the gallery, half of them merged, and some of what is left
        // without most merges.
        let is_shipped = gallery::NAMES.contains(&scene.name.as_str());
        let paths = if is_shipped { 12_500 } else { 1000 };
        for (seed, (techniques, heuristic)) in (0..).zip(sets) {
            let depth = Depth::up_to(7);
            let bidirectional =
                Bidirectional { techniques, heuristic, depth, ..Default::default() };
            let integrator = VertexConnectionMerging {
                bidirectional,
                merging: Merging { light_walks: Some(500), ..Merging::default() },
                correlation_aware: false,
            };
            let paths = if techniques.excluded.is_empty() { paths } else { paths / 10 };
            let audit = audit(&scene, integrator, seed, paths)?;
            println!("{:15} {audit:?}", scene.name);
            assert!(audit.connected.min(audit.merged) >= paths, "{} {audit:?}", scene.name);
            assert!(audit.sum <= SUM_TOLERANCE, "{} {audit:?}", scene.name);
            assert!(audit.constant_time <= SUM_TOLERANCE, "{} {audit:?}", scene.name);
            assert!(audit.value < 1e-9 && audit.weight < 1e-9, "{} {audit:?}", scene.name);
        }
    }
    Ok(())
}
