//! Audits recorded paths: what an integrator knows about a path against the same evaluated anew
//! from the definitions.
//!
//! Bounds. Weights of one path sum to 1 within 1e-12 (measured: 1e-15). Values and weights may
//! differ from the definitions by what moving the vertices within their error bounds does to them,
//! that is, by the condition of the path: a cosine of 1e-4, an edge of 1e-6 or a lobe of width 1e-3
//! magnify the rounding of a position, and no program in f64 can do better. Besides, scenes of unit
//! size stay below 1e-9.
#![allow(missing_docs, reason = "a test program")]

mod common;
mod worlds;

use common::Random;
use glam::DVec3;
use pathspace::film::{Sample, Technique};
use pathspace::geometry::Place;
use pathspace::integrator::{Arrivals, Bidirectional, Caller, Depth, Stage};
use pathspace::path::{
    Excluded, Heuristic, LightSubpaths, PathDensities, PathRecord, Roulette, Scratch, TechniqueSet,
    Weighting,
};
use pathspace::scene::Scene;
use std::collections::BTreeSet;
use worlds::{Placement, Result, TestScene};

/// Paths per scene and heuristic; three heuristics.
const PATHS: usize = 40_000;
const SUM_TOLERANCE: f64 = 1e-12;

#[derive(Debug, Default)]
struct Audit {
    paths: usize,
    value: f64,
    weight: f64,
    sum: f64,
}

/// Draws paths and verifies each.
fn audit(
    scene: &TestScene,
    integrator: &Bidirectional,
    seed: u64,
    paths: usize,
    mut look: impl FnMut(&PathRecord, bool, Technique),
) -> Audit {
    let (mut sampler, mut random, mut scratch) =
        (Random::new(seed), Random::new(!seed), Scratch::default());
    let mut audit = Audit::default();
    let set = integrator.techniques.pruned(&scene.world.needs());
    let weighting = Weighting::new(set, integrator.heuristic);
    let stage = Stage { seed, ..Stage::new(&scene.world, &*scene.camera) };
    // The choice of lights is in every weight, scaled by what arrives or not.
    let arrivals = Arrivals::observe(stage, &Caller).filter(|_| seed % 2 == 1);
    let stage = Stage { arrival: arrivals.as_ref().map(|seen| &seen.arrival), ..stage };
    for _ in 0..100 * paths {
        if audit.paths >= paths {
            break;
        }
        let film = worlds::film_sample(&*scene.camera, &mut sampler);
        integrator.for_each_path(
            stage,
            Sample { film, sampler: &mut sampler },
            &mut scratch,
            |path, contribution| {
                let verified = path.verify(&weighting);
                let rounding = 16.0 * f64::EPSILON * path.edges() as f64;
                let what =
                    || format!("{} {path:?} {:?} {verified:?}", scene.name, path.record().dirac);
                assert!(verified.weight_sum_error <= SUM_TOLERANCE, "{}", what());
                assert!(contribution.weight > 0.0 && contribution.weight <= 1.0, "{}", what());
                // Also false for what is not a number.
                if !(verified.value_error <= rounding && verified.weight_error <= rounding) {
                    // Some displacements tell for most paths how far rounding goes, for a grazing
                    // end it takes many.
                    let is_rounding = [64, 4096].into_iter().any(|displacements| {
                        let (value, weight) =
                            worlds::sensitivity(path, &weighting, displacements, &mut random);
                        verified.value_error <= value + rounding
                            && verified.weight_error <= weight + rounding
                    });
                    assert!(is_rounding, "{}", what());
                }
                audit.paths += 1;
                audit.value = audit.value.max(verified.value_error);
                audit.weight = audit.weight.max(verified.weight_error);
                audit.sum = audit.sum.max(verified.weight_sum_error);
                look(
                    &path.record(),
                    pathspace::endpoint::Light::can_be_hit(scene.world.light(path.light())),
                    path.technique(),
                );
            },
        );
    }
    assert_eq!(scratch.counters.non_finite, 0, "{}", scene.name);
    assert!(audit.paths >= paths, "{}: only {} paths", scene.name, audit.paths);
    audit
}

/// The number of techniques that can draw a path: k + 2 pairs (s, t); less one since the lens is
/// never hit; less one for a light that cannot be hit; less every pair whose connecting edge has an
/// end that takes a Dirac lobe or a direction at infinity at both ends.
fn expected_techniques(record: &PathRecord, hittable: bool) -> usize {
    let k = record.points.len() - 1;
    let directional = !hittable
        && record.points[k].place == Place::Infinite
        && record.points[0].place == Place::Infinite;
    let connected = |t: usize| !record.dirac[t - 1] && !record.dirac[t];
    let lens_to_light = (hittable || record.points[0].place == Place::Area)
        && !directional
        && !(record.points[0].place == Place::Infinite
            && record.points[1].place == Place::Infinite);
    usize::from(hittable)
        + if k == 1 {
            usize::from(lens_to_light)
        } else {
            (1..=k).filter(|&t| connected(t)).count()
        }
}

#[test]
fn paths_are_what_the_definitions_say() -> Result {
    for scene in worlds::all()? {
        // Over all recorded paths of up to three edges: techniques that can draw one, and
        // techniques that did.
        let (mut able, mut seen) = (BTreeSet::new(), BTreeSet::new());
        for (seed, heuristic) in [Heuristic::Balance, Heuristic::Power(2.0), Heuristic::Power(1.5)]
            .into_iter()
            .enumerate()
        {
            let integrator =
                Bidirectional { heuristic, depth: Depth::up_to(7), ..Bidirectional::default() };
            let audit =
                audit(&scene, &integrator, seed as u64, PATHS, |record, hittable, technique| {
                    let k = record.edges();
                    let admissible: Vec<usize> = (0..=k + 1)
                        .filter(|&t| record.is_admissible(record.technique(t)))
                        .collect();
                    assert_eq!(
                        admissible.len(),
                        expected_techniques(record, hittable),
                        "{} {record:?}",
                        scene.name
                    );
                    // What can be drawn structurally has a density, whichever technique drew the
                    // path.
                    for &t in &admissible {
                        assert!(
                            record.density(t) > 0.0,
                            "{} drawn by {technique:?}, t = {t}: {record:?}",
                            scene.name
                        );
                    }
                    if k <= 3 {
                        able.extend(admissible.iter().map(|&t| (k + 1 - t, t)));
                        seen.insert((usize::from(technique.s), usize::from(technique.t)));
                    }
                });
            println!("{:15} {heuristic:?} {audit:?}", scene.name);
            assert!(audit.value < 1e-9 && audit.weight < 1e-9, "{}: {audit:?}", scene.name);
        }
        // Lamps that are too small to be hit by chance: that of the pool after two events above the
        // water, that of the chain by any way as short.
        let rare = match scene.name.as_str() {
            "pool" => BTreeSet::from([(0, 4)]),
            "mirror-chain" => BTreeSet::from([(0, 3), (0, 4)]),
            _ => BTreeSet::new(),
        };
        assert_eq!(&able - &rare, &seen - &rare, "{}", scene.name);
    }
    Ok(())
}

/// 20 vertices, whatever the size of the scene, at the origin and a thousand sizes away from it.
#[test]
fn long_paths_verify_at_every_scale() -> Result {
    for exponent in [-6, -3, 0, 3, 6] {
        for offset in [0.0, 1000.0] {
            let scale = 10f64.powi(exponent);
            let at = Placement {
                scale,
                offset: DVec3::new(offset, -0.3 * offset, 0.7 * offset) * scale,
            };
            for scene in [worlds::mixtures(at)?, worlds::glass(at)?] {
                let integrator = Bidirectional {
                    depth: Depth::exactly(18),
                    roulette: Roulette::NEVER,
                    ..Bidirectional::default()
                };
                let audit = audit(&scene, &integrator, 3, 3000, |record, _, _| {
                    assert_eq!(record.points.len(), 20)
                });
                println!("{:15} 1e{exponent} {offset} {audit:?}", scene.name);
                // Displaced by a thousand sizes, positions lose three digits more.
                let bound = if offset == 0.0 { 1e-8 } else { 1e-5 };
                assert!(
                    audit.value < bound && audit.weight < bound,
                    "{} {at:?} {audit:?}",
                    scene.name
                );
            }
        }
    }
    Ok(())
}

/// A point at infinity has a direction and no position: wherever it is put, the densities are those
/// of the ray that the path has, also where they depend on how far it passes from each object.
#[test]
fn points_at_infinity_have_no_position() -> Result {
    let TestScene { world, camera, .. } = worlds::pebbles(Placement::UNIT)?;
    let (mut sampler, mut scratch) = (Random::new(1), Scratch::default());
    let integrator = Bidirectional { depth: Depth::up_to(3), ..Bidirectional::default() };
    let mut paths = 0;
    for _ in 0..1000 {
        let film = worlds::film_sample(&*camera, &mut sampler);
        integrator.for_each_path(
            Stage::new(&world, &*camera),
            Sample { film, sampler: &mut sampler },
            &mut scratch,
            |path, _| {
                let record = path.record();
                let mut points = record.points.clone();
                if let [.., last] = &mut points[..]
                    && last.place == Place::Infinite
                {
                    last.position += DVec3::new(1e3, -2e3, 3e3);
                    let (stage, dirac) = (path.stage(), &record.dirac);
                    let moved = PathRecord::evaluate(stage, &points, dirac, path.light());
                    assert_eq!(moved, PathRecord { points, ..record });
                    paths += 1;
                }
            },
        );
    }
    assert!(paths > 1000, "{paths}");
    Ok(())
}

/// Weights from MIS partial sums are those of a sweep over the path, whatever the set.
#[test]
fn weights_in_constant_time_are_those_of_sweeps() -> Result {
    let all = TechniqueSet::BIDIRECTIONAL;
    let walks = |exponent| LightSubpaths::power_of_two(exponent).unwrap_or_default();
    let sets = [
        TechniqueSet { light_subpaths: walks(2), ..all },
        TechniqueSet { light_subpaths: walks(-1), ..all },
        TechniqueSet { bsdf_sampling: false, light_subpaths: walks(1), ..all },
        TechniqueSet { next_event: false, light_subpaths: walks(1), ..all },
        TechniqueSet { connections: false, light_subpaths: walks(1), ..all },
        TechniqueSet { lens_sampling: false, light_subpaths: walks(1), ..all },
        TechniqueSet {
            excluded: Excluded::NONE.with(Technique::new(2, 2)).expect("a short path"),
            ..all
        },
    ];
    for scene in worlds::all()? {
        for (seed, techniques) in sets.into_iter().enumerate() {
            for heuristic in [Heuristic::Balance, Heuristic::Power(2.0), Heuristic::Power(0.7)] {
                let integrator = Bidirectional {
                    techniques,
                    heuristic,
                    depth: Depth::up_to(7),
                    ..Bidirectional::default()
                };
                let set = techniques.pruned(&scene.world.needs());
                let (mut sampler, mut scratch) = (Random::new(seed as u64), Scratch::default());
                let mut paths = 0;
                for _ in 0..500 {
                    let film = worlds::film_sample(&*scene.camera, &mut sampler);
                    integrator.for_each_path(
                        Stage::new(&scene.world, &*scene.camera),
                        Sample { film, sampler: &mut sampler },
                        &mut scratch,
                        |path, contribution| {
                            let swept = path.weight(&Weighting::new(set, heuristic));
                            let rounding = 16.0 * f64::EPSILON * path.edges() as f64;
                            let error = (contribution.weight - swept).abs();
                            assert!(
                                error <= rounding * swept,
                                "{} {path:?} {set:?} {heuristic:?} {error:e} {swept:e}",
                                scene.name
                            );
                            paths += 1;
                        },
                    );
                }
                assert!(paths > 50, "{} {set:?}: only {paths} paths", scene.name);
            }
        }
    }
    Ok(())
}
