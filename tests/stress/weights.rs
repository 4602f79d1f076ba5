//! Weights to the last digits, and each technique by itself.

use crate::cases::{self, Case};
use crate::measure::{Method, Probe};
use crate::scenes::{Stage, camera, lambert};
use pathspace::endpoint::LightId;
use pathspace::film::{Contribution, FilmSample, Sample, Technique};
use pathspace::geometry::{Sphere, SurfacePoint};
use pathspace::glam::{DVec2, DVec3};
use pathspace::integrator::{self, Bidirectional, Caller, Depth, Integrator, PathTracer, Run};
use pathspace::path::{Heuristic, Roulette, Scratch, TechniqueSet, Weighting};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::{Scene, World};

/// A sphere whose cap, a tenth of it, has radiance 1 and whose rest has a quarter.
fn two_lights(scale: f64) -> World {
    let mut stage = Stage::default();
    let whole = Sphere { inward: true, axis: DVec3::Z, ..Sphere::new(DVec3::ZERO, scale) };
    for (part, radiance) in
        [(Sphere { cos_max: 0.8, ..whole }, 0.25), (Sphere { cos_min: 0.8, ..whole }, 1.0)]
    {
        let part = stage.sphere(part, lambert(0.5));
        stage.glow(part, radiance);
    }
    stage.build()
}

/// The weight of a technique inside a diffuse sphere. All densities per area are 1 / (4π R²) but
/// that of the point on the light, which is r_s times as large: for k bounces and n techniques that
/// start at the light w = r_s / (1 + r_1 + n r_2), where hitting the light has r_0 = 1 (row F13 of
/// tests/data/analytic.json, for two lights). Each light's bounds contain all receivers, for which
/// its importance is then the same.
fn weight(world: &World, light: LightId, s: u16, n: u32) -> f64 {
    let area = [0.9, 0.1][light.0 as usize];
    let connected = world.pick_pmf_for(&SurfacePoint::dirac(DVec3::ZERO), light) / area;
    let started = world.pick_pmf(light) / area;
    let r = [1.0, connected, started][usize::from(s.min(2))];
    r / (1.0 + connected + f64::from(n) * started)
}

#[test]
fn stress_s18_weights_of_twenty_vertices() {
    for scale in [1e-30, 1e-6, 1.0, 1e6, 1e30] {
        let (world, eye) = (two_lights(scale), camera(DVec3::ZERO, DVec3::NEG_Z, 60.0));
        for k in [1, 2, 5, 18] {
            let techniques = TechniqueSet { lens_sampling: false, ..TechniqueSet::BIDIRECTIONAL };
            let method = Bidirectional {
                techniques,
                depth: Depth::exactly(k),
                roulette: Roulette::NEVER,
                heuristic: Heuristic::Balance,
            };
            let (mut scratch, mut paths) = (Scratch::default(), 0);
            for i in 0..200 {
                let film = FilmSample { raster: DVec2::splat(0.5), offset: DVec2::ZERO };
                method.for_each_path(
                    integrator::Stage::new(&world, &eye),
                    Sample { film, sampler: Independent { seed: 1 }.sampler(0, i) },
                    &mut scratch,
                    |path, contribution| {
                        let expected =
                            weight(&world, path.light(), contribution.technique.s, k - 1);
                        assert!(
                            (contribution.weight / expected - 1.0).abs() < 1e-12,
                            "{scale:e} {contribution:?} {expected}"
                        );
                        assert!(
                            path.verify(&Weighting::new(techniques, Heuristic::Balance))
                                .weight_sum_error
                                < 1e-12,
                            "{scale:e} {path:?}"
                        );
                        paths += 1;
                    },
                );
            }
            assert!(paths > 200 * u64::from(k), "{paths}");
        }
    }
}

/// The same of path tracing, which has only s = 0 and s = 1.
#[test]
fn stress_s18_weights_of_path_tracing() {
    let (world, eye) = (two_lights(1.0), camera(DVec3::ZERO, DVec3::NEG_Z, 60.0));
    let method = PathTracer {
        depth: Depth::up_to(18),
        heuristic: Heuristic::Balance,
        roulette: Roulette::NEVER,
        ..PathTracer::default()
    };
    let (mut scratch, mut contributions) = (Scratch::default(), Vec::<Contribution>::new());
    let run = method.start(integrator::Stage::new(&world, &eye), &Caller).expect("a run");
    for i in 0..200 {
        let film = FilmSample { raster: DVec2::splat(0.5), offset: DVec2::ZERO };
        let sampler = Independent { seed: 1 }.sampler(0, i);
        run.sample(film, sampler, &mut contributions, &mut scratch);
    }
    for Contribution { weight: measured, technique: Technique { s, t, .. }, .. } in
        contributions.iter().filter(|c| c.technique.t > 2 || c.technique.s > 0)
    {
        let is_weight_of =
            |light| (measured / weight(&world, LightId(light), *s, 0) - 1.0).abs() < 1e-12;
        assert!(is_weight_of(0) || is_weight_of(1), "({s}, {t}): {measured}");
    }
    assert!(contributions.len() > 4000);
}

/// The densities that vertices and connections keep, against the definitions: bent and rough
/// surfaces, where forwards is not backwards.
#[test]
fn stress_s38_weights_by_definition() {
    for case in cases::all().iter().filter(|case| {
        matches!(case.row, "S25" | "S38") && case.methods.contains(&Method::Bidirectional)
    }) {
        let method = Bidirectional { depth: case.depth, ..Bidirectional::default() };
        let set = method.techniques.pruned(&case.world.needs());
        let (mut scratch, mut paths, region) = (Scratch::default(), 0, case.camera.film());
        for i in 0..1000 {
            let mut sampler = Independent { seed: 1 }.sampler(0, i);
            let film =
                FilmSample { raster: region.from_window(sampler.next_2d()), offset: DVec2::ZERO };
            method.for_each_path(
                integrator::Stage::new(&case.world, &*case.camera),
                Sample { film, sampler: &mut sampler },
                &mut scratch,
                |path, _| {
                    let verification = path.verify(&Weighting::new(set, method.heuristic));
                    assert!(
                        verification.worst() < 1e-7,
                        "{} {} {:e}: {path:?} {verification:?}",
                        case.row,
                        case.family,
                        case.value
                    );
                    paths += 1;
                },
            );
        }
        assert!(paths > 50, "{} {}: {paths}", case.row, case.family);
    }
}

/// Every technique by itself, unweighted, has the exact mean: what weights could hide. Deep bounces
/// off bent and rough surfaces.
fn each_alone(case: &Case) {
    let k = case.depth.min_bounces;
    for s in 1..=k as u16 + 1 {
        let only = Technique::new(s, k as u16 + 2 - s);
        let techniques = TechniqueSet::only(only).expect("a short path");
        let method = Bidirectional { techniques, depth: case.depth, ..Bidirectional::default() };
        let samples = if only.t == 1 { 500_000 } else { 60_000 };
        let measured = Probe::new(&case.world, &*case.camera, case.depth).run(&method, samples, 5);
        println!(
            "{} {} {:?}: {:?}, expected {:?}",
            case.row, case.value, only, measured.channels[0], case.expected[0]
        );
        assert!(
            measured.agrees(case.expected, case.tolerance),
            "{only:?}: {measured:?}, expected {:?}",
            case.expected
        );
        assert!(measured.relative_error(case.expected) < 0.03, "{only:?}: {measured:?}");
    }
}

/// The hardest case of a row with two bounces.
fn hardest(row: &str) -> Case {
    let two_bounces =
        |case: &Case| case.row == row && case.depth == Depth::exactly(2) && case.methods.len() > 1;
    cases::all().into_iter().rfind(two_bounces).expect("such a case")
}

#[test]
fn stress_s25_each_technique_alone() {
    each_alone(&hardest("S25"));
}

#[test]
fn stress_s38_each_technique_alone() {
    each_alone(&hardest("S38"));
}
