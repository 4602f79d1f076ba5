//! The diffuse sphere with an emissive cap: a chord ball cuts an area of exactly πr² out of a sphere,
//! so every merge has the exact mean Le f_e ρ^k at any radius up to that of the sphere, where the
//! normals of its ends begin to be too far apart.
//!
//! That is if f is the same for all directions. An opaque surface does not show light from below its
//! horizon, and a photon's may come from there, since it is at another place: of light that arrives
//! uniformly about the normal of z the share (1 - cos δ)/2 does at y, with δ the angle between the
//! normals. cos δ is uniform over a ball's cap, from 1 - r²/2R² to 1, so r²/8R² is lost.

use crate::common::{DownCamera, Random, SphereCap, film_sample};
use crate::passes::{assert_mean, over_passes};
use pathspace::film::{Contribution, Technique};
use pathspace::integrator::{
    Bidirectional, Caller, Depth, InstantRadiosity, Integrator, Merging, PathTracer, PhotonMapping,
    Run, Stage, VertexConnectionMerging,
};
use pathspace::path::{Heuristic, Roulette, TechniqueSet};

const ALBEDO: f64 = 0.5;
const FRACTION: f64 = 0.1;
const CAMERA: DownCamera = DownCamera { half_width: 0.5 };

fn scene() -> SphereCap {
    SphereCap { is_opaque: false, ..SphereCap::new(ALBEDO, FRACTION) }
}

/// Le f_e ρ^k.
fn term(bounces: u32) -> f64 {
    FRACTION * ALBEDO.powi(bounces as i32)
}

fn merging(radius: f64, light_walks: u32) -> Merging {
    Merging { light_walks: Some(light_walks), ..Merging::fixed(radius) }
}

fn weighted(found: &[Contribution]) -> f64 {
    found.iter().map(|found| found.value.g() * found.weight).sum()
}

fn vcm(depth: Depth, heuristic: Heuristic, merging: Merging) -> VertexConnectionMerging {
    let bidirectional =
        Bidirectional { depth, heuristic, roulette: Roulette::NEVER, ..Bidirectional::default() };
    VertexConnectionMerging { bidirectional, merging, correlation_aware: false }
}

#[test]
fn every_merge_alone_has_the_exact_mean() {
    let scene = scene();
    for bounces in 1..=3u32 {
        let integrator = vcm(Depth::exactly(bounces), Heuristic::Balance, merging(0.2, 10_000));
        for t in 2..=bounces as u16 + 1 {
            let technique = Technique::merge(bounces as u16 + 3 - t, t);
            let mut run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
            let alone = |found: &[Contribution]| {
                let found = found.iter().filter(|found| found.technique == technique);
                found.map(|found| found.value.g()).sum()
            };
            let moments =
                over_passes(&mut run, 500, 100, &mut Random::new(t.into()), film_sample, alone);
            assert_mean(&technique.to_string(), moments, term(bounces));
        }
    }
}

/// The cap is far above the horizon of what the camera sees, so that light which has not scattered
/// is not cut off there.
#[test]
fn an_opaque_surface_loses_what_is_below_its_horizon() {
    let scene = SphereCap::new(ALBEDO, FRACTION);
    let radius = 0.6;
    let integrator = vcm(Depth::exactly(2), Heuristic::Balance, merging(radius, 10_000));
    for (technique, loss) in [
        (Technique::merge(3, 2), radius * radius / 8.0),
        (Technique::merge(2, 3), radius * radius / 8.0),
    ] {
        let mut run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
        let alone = |found: &[Contribution]| {
            let found = found.iter().filter(|found| found.technique == technique);
            found.map(|found| found.value.g()).sum()
        };
        let moments = over_passes(&mut run, 300, 100, &mut Random::new(4), film_sample, alone);
        assert_mean(&technique.to_string(), moments, term(2) * (1.0 - loss));
    }
}

/// Also beyond the radius of the sphere, where the normals cut the ball off: by R²/r².
#[test]
fn photon_mapping_has_the_exact_mean_at_any_radius() {
    let scene = scene();
    for (radius, walks, share) in [
        (0.05, 20_000, 1.0),
        (0.2, 10_000, 1.0),
        (0.9999, 2000, 1.0),
        (1.5, 2000, 1.0 / 2.25),
        (1e3, 2000, 1e-6),
    ] {
        for next_event in [false, true] {
            let integrator = PhotonMapping {
                depth: Depth { min_bounces: 1, max_bounces: None },
                merging: merging(radius, walks),
                next_event,
                ..PhotonMapping::default()
            };
            let mut run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
            let moments =
                over_passes(&mut run, 200, 40, &mut Random::new(3), film_sample, weighted);
            let total = term(1) / (1.0 - ALBEDO);
            let expected =
                if next_event { term(1) + share * (total - term(1)) } else { share * total };
            assert_mean(&format!("r = {radius}, {next_event}"), moments, expected);
        }
    }
}

/// All densities are constant here, so the weighted sum has no bias either.
#[test]
fn vertex_connection_and_merging_has_the_exact_mean() {
    let scene = scene();
    for (heuristic, correlation_aware, light_walks, passes) in [
        (Heuristic::Balance, false, 1000, 700),
        (Heuristic::Power(2.0), false, 1500, 700),
        (Heuristic::Balance, true, 300, 1300),
    ] {
        let depth = Depth { min_bounces: 1, max_bounces: Some(3) };
        let integrator = VertexConnectionMerging {
            correlation_aware,
            ..vcm(depth, heuristic, merging(0.3, light_walks))
        };
        let mut run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
        let moments = over_passes(&mut run, passes, 60, &mut Random::new(5), film_sample, weighted);
        let expected = (1..=3).map(term).sum();
        assert_mean(&format!("{heuristic:?} {correlation_aware}"), moments, expected);
    }
}

/// Without the lens: of the balance heuristic f_e, 1 and h over D = f_e + k (1 + h), with h =
/// N r²/(4R²); of the power heuristic their squares.
#[test]
fn weights_are_the_exact_ones() {
    let scene = scene();
    for (walks, heuristic) in [
        (256, Heuristic::Balance),
        (100, Heuristic::Balance),
        (256, Heuristic::Power(2.0)),
        (100, Heuristic::Power(2.0)),
    ] {
        for k in 1..=3u32 {
            let mut integrator = vcm(Depth::exactly(k), heuristic, merging(0.2, walks));
            integrator.bidirectional.techniques =
                TechniqueSet { lens_sampling: false, ..TechniqueSet::BIDIRECTIONAL };
            let mut run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
            let h = f64::from(walks) * 0.01;
            let [hit, merge] = [FRACTION, h].map(|ratio| heuristic.raise(ratio));
            let sum = hit + f64::from(k) * (1.0 + merge);
            let mut seen = [0; 3];
            over_passes(&mut run, 3, 1000, &mut Random::new(6), film_sample, |found| {
                for &Contribution { technique, weight, .. } in found {
                    let (kind, expected) = match (technique.merged, technique.s) {
                        (true, _) => (2, merge / sum),
                        (_, 0) => (0, hit / sum),
                        _ => (1, 1.0 / sum),
                    };
                    assert!(
                        (weight - expected).abs() < 1e-9 * expected,
                        "{technique} {heuristic:?} N = {walks}: {weight}, expected {expected}"
                    );
                    seen[kind] += 1;
                }
                0.0
            });
            assert!(seen.iter().all(|&seen| seen > 100), "{seen:?}");
        }
    }
    // The numbers themselves, for one of each.
    let balance = |k: f64| [0.1, 1.0, 2.56].map(|n| n / (0.1 + k * 3.56));
    for (weight, expected) in balance(2.0).into_iter().zip([0.013_850_4, 0.138_504_2, 0.354_570_6])
    {
        assert!((weight - expected).abs() < 1e-6, "{weight}");
    }
}

/// The count of photons in a disc is binomial: its relative variance is (1 - q)/(N q), q = r²/4R².
#[test]
fn the_variance_of_a_query_is_that_of_a_binomial() {
    let scene = scene();
    for (walks, expected) in [(256, 0.386_718_75), (1000, 0.099), (10_000, 0.0099)] {
        let integrator = PhotonMapping {
            depth: Depth::exactly(1),
            merging: merging(0.2, walks),
            ..PhotonMapping::default()
        };
        let mut run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
        let passes = 4000;
        let moments = over_passes(&mut run, passes, 1, &mut Random::new(7), film_sample, weighted);
        let measured = moments.variance() / term(1).powi(2);
        // The variance of a sample variance, with the kurtosis of a binomial.
        let kurtosis: f64 = 2.0 + expected / 0.99;
        let error = expected * (kurtosis / f64::from(passes)).sqrt();
        assert!(
            (measured - expected).abs() < 4.0 * error && error < 0.03 * expected,
            "N = {walks}: {measured} ± {error}, expected {expected}"
        );
    }
}

/// All geometry terms are 1/4, so the bound 1/8 cuts every connection in half: a bound of 1/8
/// splits k bounces into shares of 1/2, 1/4, … by the vertex that connects, and what is left to the
/// light.
#[test]
fn virtual_lights_share_paths_by_stick_breaking() {
    let scene = scene();
    for (bounces, shares) in
        [(2u32, vec![0.5, 0.5]), (3, vec![0.5, 0.25, 0.25]), (4, vec![0.5, 0.25, 0.125, 0.125])]
    {
        for (t, share) in (2u16..).zip(shares) {
            let integrator = InstantRadiosity {
                path_tracer: PathTracer {
                    depth: Depth::exactly(bounces),
                    roulette: Roulette::NEVER,
                    ..PathTracer::default()
                },
                bound: Some(0.125),
                ..InstantRadiosity::default()
            };
            let mut run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
            // The last share is that of walks that reach the light, or connect to it.
            let is_of = |found: &&Contribution| match found.technique.s {
                0 | 1 => u32::from(t) == bounces + 1,
                _ => found.technique.t == t && u32::from(t) <= bounces,
            };
            let part = |found: &[Contribution]| {
                found.iter().filter(is_of).map(|found| found.value.g() * found.weight).sum()
            };
            let moments = over_passes(&mut run, 400, 60, &mut Random::new(8), film_sample, part);
            assert_mean(&format!("{bounces} bounces, t = {t}"), moments, share * term(bounces));
        }
    }
}

/// Row A12: clamped at half of the geometry term, two bounces are half as bright, and the other half
/// is in the ledger. With compensation, without a bound and with a bound of 0 nothing is missing.
#[test]
fn what_a_bound_cuts_off_is_drawn_or_reported() {
    let scene = scene();
    for (bound, compensates, share) in [
        (0.125, false, 0.5),
        (0.125, true, 1.0),
        (f64::INFINITY, false, 1.0),
        (f64::INFINITY, true, 1.0),
        (0.0, true, 1.0),
        (0.0, false, 0.0),
    ] {
        let integrator = InstantRadiosity {
            path_tracer: PathTracer { depth: Depth::exactly(2), ..PathTracer::default() },
            bound: Some(bound),
            compensates,
            ..InstantRadiosity::default()
        };
        let mut run = integrator.start(Stage::new(&scene, &CAMERA), &Caller).expect("a run");
        let moments = over_passes(&mut run, 400, 60, &mut Random::new(9), film_sample, weighted);
        let name = format!("bound {bound}, {compensates}");
        if share > 0.0 {
            assert_mean(&name, moments, share * term(2));
        } else {
            assert_eq!(moments.mean(), 0.0, "{name}");
        }
        let mut scratch = pathspace::path::Scratch::default();
        let (mut random, mut sink) = (Random::new(10), Vec::<Contribution>::new());
        let samples = 4000;
        for _ in 0..samples {
            let film = film_sample(&mut random);
            run.sample(film, &mut random, &mut sink, &mut scratch);
        }
        let clamped = scratch.counters.ledger.clamped.g() / f64::from(samples);
        let drawn = sink.iter().map(|found| found.value.g() * found.weight).sum::<f64>()
            / f64::from(samples);
        let missing = if compensates { 0.0 } else { 1.0 - share };
        // Of one pass, whose lights are the same for both.
        let expected = if share > 0.0 { drawn * missing / share } else { clamped };
        assert!((clamped - expected).abs() <= 1e-9 * term(2), "{name}: {clamped} of {drawn}");
        assert_eq!(clamped > 0.0, missing > 0.0, "{name}");
    }
}
