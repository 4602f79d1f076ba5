//! Merges where the definition has its cases: beside Dirac vertices, where a surface takes both kinds
//! of lobes, and at both ends of a path.

use crate::common::Random;
use crate::worlds::{self, Placement, Result, TestScene};
use pathspace::bsdf::Lobes;
use pathspace::film::Sample;
use pathspace::integrator::{
    Bidirectional, Caller, Depth, Integrator, Merging, Run, Stage, VertexConnectionMerging,
    WithNeeds,
};
use pathspace::path::{Heuristic, PathDensities, Scratch};

const TOLERANCE: f64 = 1e-12;

/// Weights of all techniques sum to one for each of these merges, and their two ways to compute them
/// agree.
#[test]
fn stress_s57_merges_beside_dirac_vertices_and_ends() -> Result {
    let pool = pathspace::gallery::build("pool", worlds::RESOLUTION)?;
    let pool = TestScene { name: "pool".into(), world: pool.world, camera: pool.camera };
    let scenes = [worlds::mixtures(Placement::UNIT)?, worlds::glass(Placement::UNIT)?, pool];
    // Dirac towards the camera, towards the light, both; mixture; first; last.
    let mut seen = [0u32; 6];
    for (scene, heuristic) in scenes
        .iter()
        .flat_map(|scene| [Heuristic::Balance, Heuristic::Power(2.0)].map(|h| (scene, h)))
    {
        let bidirectional =
            Bidirectional { depth: Depth::up_to(7), heuristic, ..Bidirectional::default() };
        let merging = Merging { light_walks: Some(2000), ..Merging::from_radius(0.1) };
        let correlation_aware = false;
        let integrator =
            WithNeeds::all(VertexConnectionMerging { bidirectional, merging, correlation_aware });
        let mut run = integrator.start(Stage::new(&scene.world, &*scene.camera), &Caller)?;
        run.keep_subpaths();
        run.begin_pass(0, &Caller)?;
        let weighting = *run.weighting();
        let (mut sampler, mut scratch) = (Random::new(1), Scratch::default());
        for _ in 0..500 {
            let film = worlds::film_sample(&*scene.camera, &mut sampler);
            let sample = Sample { film, sampler: &mut sampler };
            run.for_each_path(
                sample,
                &mut scratch,
                |_, _| {},
                |path, contribution| {
                    let m = path.meeting();
                    let is_dirac = |i: usize| i > 0 && i < path.edges() && path.is_dirac(i);
                    let lobes =
                        path.vertex(m).bsdf.as_ref().map_or(Lobes::NONE, |bsdf| bsdf.lobes());
                    let cases = [
                        is_dirac(m - 1) && !is_dirac(m + 1),
                        is_dirac(m + 1) && !is_dirac(m - 1),
                        is_dirac(m - 1) && is_dirac(m + 1),
                        lobes.intersects(Lobes::DIRAC),
                        m == 1,
                        m + 1 == path.edges(),
                    ];
                    cases.iter().zip(&mut seen).for_each(|(is, seen)| *seen += u32::from(*is));
                    let verified = path.verify(&weighting);
                    let swept = path.weight(&weighting);
                    assert!(
                        verified.weight_sum_error <= TOLERANCE
                            && (contribution.weight - swept).abs() <= TOLERANCE
                            && (path.weight_of_sides(&weighting) - swept).abs() <= TOLERANCE,
                        "{} {path:?} {cases:?} {verified:?}",
                        scene.name
                    );
                },
            );
        }
    }
    println!("{seen:?}");
    assert!(seen.iter().all(|&seen| seen > 100), "{seen:?}");
    Ok(())
}
