//! The energy ledger of light subpaths: what lights emit is absorbed, escapes, or is cut off by a
//! limit on bounces; nothing is lost.
//!
//! Sums are compared with Student's t over independent batches, at a level of 1e-3 for the whole
//! file (Šidák), and within rounding where roulette plays no part.
#![allow(missing_docs, reason = "a test program")]

mod common;
mod worlds;

use common::{Moments, Random};
use glam::{DVec3, UVec2};
use pathspace::endpoint::{Camera, PinholeCamera, PointLight};
use pathspace::geometry::Sphere;
use pathspace::integrator::{
    Bidirectional, Caller, Depth, InstantRadiosity, Integrator, LightTracer, Merging, PathTracer,
    PhotonMapping, Run, Stage, VertexConnectionMerging, WithNeeds,
};
use pathspace::math::Rgb;
use pathspace::math::statistics::sidak;
use pathspace::path::{Counters, Ledger, Roulette, Scratch, Survival};
use pathspace::scene::{Emission, Material, World, WorldBuilder};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::f64::consts::PI;
use worlds::Result;

const BATCHES: u64 = 150;
const SAMPLES: u32 = 150;

/// The counters of independent batches, each of [`SAMPLES`] samples.
fn batches<I: Integrator<World>>(
    world: &World,
    camera: &(dyn Camera + Send),
    integrator: &I,
) -> Vec<Counters> {
    let run = integrator.start(Stage::new(world, camera), &Caller).expect("a run");
    let batch = |seed| {
        let (mut sampler, mut scratch, mut sink) =
            (Random::new(seed), Scratch::default(), Vec::new());
        for _ in 0..SAMPLES {
            sink.clear();
            let film = worlds::film_sample(camera, &mut sampler);
            run.sample(film, &mut sampler, &mut sink, &mut scratch);
        }
        assert_eq!(
            (scratch.counters.non_finite, scratch.counters.ledger.rejected),
            (0, Rgb::BLACK)
        );
        scratch.counters
    };
    (0..BATCHES).map(batch).collect()
}

/// The counters of the light walks of independent passes, of which there are [`SAMPLES`] as well.
fn passes<I: Integrator<World>>(
    world: &World,
    camera: &(dyn Camera + Send),
    integrator: &I,
) -> Vec<Counters> {
    let pass = |seed| {
        let stage = Stage { seed, ..Stage::new(world, camera) };
        let mut run = integrator.start(stage, &Caller).expect("a run");
        run.begin_pass(0, &Caller).expect("memory");
        let counters = run.take_preparation();
        assert_eq!(counters.light_subpaths, u64::from(SAMPLES));
        counters
    };
    (0..BATCHES).map(pass).collect()
}

/// One number of each batch, per sample.
fn moments(batches: &[Counters], of: impl Fn(&Ledger) -> f64) -> Moments {
    let mut moments = Moments::default();
    batches.iter().for_each(|counters| moments.add(of(&counters.ledger) / f64::from(SAMPLES)));
    moments
}

fn balance(ledger: &Ledger, channel: usize) -> f64 {
    (ledger.absorbed + ledger.escaped + ledger.truncated + ledger.rejected)[channel]
        - ledger.emitted[channel]
}

/// Number of means that are compared; an upper bound.
const COMPARISONS: usize = 300;

/// The mean is what is expected, within the quantile of Student's t and rounding, and known to 2 %
/// of `scale`.
#[track_caller]
fn assert_mean(name: &str, moments: Moments, expected: f64, scale: f64) {
    let (mean, error) = (moments.mean(), moments.standard_error());
    let student = StudentsT::new(0.0, 1.0, BATCHES as f64 - 1.0).expect("valid");
    let quantile = student.inverse_cdf(1.0 - 0.5 * sidak(1e-3, COMPARISONS));
    assert!(
        (mean - expected).abs() <= quantile * error + 1e-12 * scale,
        "{name}: {mean} ± {error}, expected {expected}"
    );
    assert!(
        error <= 0.02 * scale,
        "{name}: the standard error {error} is too large to mean anything"
    );
}

#[test]
fn energy_is_conserved_in_every_scene() -> Result {
    for scene in worlds::all()? {
        for max_bounces in [None, Some(4)] {
            for roulette in
                [Roulette::NEVER, Roulette::default(), Roulette { start: 0, ..Roulette::default() }]
            {
                if max_bounces.is_none() && roulette == Roulette::NEVER {
                    // In a closed room such walks go on until the throughput underflows.
                    continue;
                }
                let integrator =
                    LightTracer { depth: Depth { min_bounces: 0, max_bounces }, roulette };
                let batches = batches(&scene.world, &*scene.camera, &integrator);
                let name = format!("{} {max_bounces:?} {roulette:?}", scene.name);
                for channel in 0..3 {
                    let emitted = moments(&batches, |l| l.emitted[channel]).mean();
                    assert!(emitted > 0.0);
                    let gap = moments(&batches, |l| balance(l, channel));
                    if roulette == Roulette::NEVER {
                        // Every walk balances.
                        assert!(
                            gap.mean().abs() <= 1e-12 * emitted,
                            "{name}: {gap:?} of {emitted}"
                        );
                    }
                    assert_mean(&name, gap, 0.0, emitted);
                }
                let truncated: u64 =
                    batches.iter().map(|counters| counters.truncated_subpaths).sum();
                // The limit is what was asked for.
                assert_eq!(truncated, 0, "{name}");
                let ended: f64 = batches.iter().map(|counters| counters.ledger.truncated.g()).sum();
                assert_eq!(ended > 0.0, max_bounces.is_some(), "{name}");
            }
        }
    }
    Ok(())
}

/// The unit sphere of albedo ρ, seen from inside.
fn sphere(albedo: f64, cos_max: f64) -> Result<(WorldBuilder, PinholeCamera)> {
    let mut builder = WorldBuilder::new();
    let wall = builder.add_material("wall", Material::Lambert { albedo: Rgb::splat(albedo) })?;
    let shape = Sphere { inward: true, cos_max, ..Sphere::new(DVec3::ZERO, 1.0) };
    builder.add_sphere("wall", shape, wall)?;
    let camera =
        PinholeCamera::new(DVec3::new(0.1, 0.2, 0.0), -DVec3::Z, DVec3::Y, 60.0, UVec2::splat(4))?;
    Ok((builder, camera))
}

/// The sphere, a cap of which emits.
fn sphere_with_a_cap(albedo: f64, fraction: f64) -> Result<(World, PinholeCamera)> {
    let cos = 1.0 - 2.0 * fraction;
    let (mut builder, camera) = sphere(albedo, cos)?;
    let wall = builder.material("wall")?;
    let cap = Sphere { inward: true, cos_min: cos, ..Sphere::new(DVec3::ZERO, 1.0) };
    let cap = builder.add_sphere("cap", cap, wall)?;
    builder.set_emission(cap, Emission { radiance: Rgb::new(1.0, 2.0, 3.0), two_sided: false })?;
    Ok((builder.build()?, camera))
}

/// After n events a closed sphere has absorbed 1 - ρⁿ of the flux π Le A that a cap of it emits
/// (row A15 of tests/data/analytic.json).
#[test]
fn a_closed_sphere_absorbs_everything() -> Result {
    let (albedo, fraction): (f64, f64) = (0.5, 0.1);
    let (world, camera) = sphere_with_a_cap(albedo, fraction)?;
    let flux = PI * 4.0 * PI * fraction;
    for (max_bounces, kept) in
        [(None, 0.0), (Some(1), albedo), (Some(2), albedo.powi(2)), (Some(5), albedo.powi(5))]
    {
        for roulette in [
            Roulette::NEVER,
            Roulette { start: 0, survival: Survival::Fixed(0.8), ..Roulette::default() },
        ] {
            if max_bounces.is_none() && roulette == Roulette::NEVER {
                continue;
            }
            let integrator = LightTracer { depth: Depth { min_bounces: 0, max_bounces }, roulette };
            let batches = batches(&world, &camera, &integrator);
            for (channel, radiance) in [1.0, 2.0, 3.0].into_iter().enumerate() {
                let expected = radiance * flux;
                let name = format!("{max_bounces:?} {roulette:?}");
                assert_mean(&name, moments(&batches, |l| l.emitted[channel]), expected, expected);
                assert_mean(&name, moments(&batches, |l| l.escaped[channel]), 0.0, expected);
                let truncated = moments(&batches, |l| l.truncated[channel]);
                let absorbed = moments(&batches, |l| l.absorbed[channel]);
                assert_mean(&name, truncated, kept * expected, expected);
                assert_mean(&name, absorbed, (1.0 - kept) * expected, expected);
            }
        }
    }
    Ok(())
}

/// The same of light walks that pixels share. They end a bounce earlier, at the vertex that a camera
/// walk merges with, or two where it connects to it.
#[test]
fn shared_light_walks_have_the_same_ledger() -> Result {
    let (albedo, fraction): (f64, f64) = (0.5, 0.1);
    let (world, camera) = sphere_with_a_cap(albedo, fraction)?;
    let flux = 2.0 * PI * 4.0 * PI * fraction;
    let fixed = Roulette { start: 0, survival: Survival::Fixed(0.8), ..Roulette::default() };
    for (max_bounces, roulette) in [(None, fixed), (Some(2), fixed), (Some(2), Roulette::NEVER)] {
        let depth = Depth { min_bounces: 0, max_bounces };
        let merging = Merging { light_walks: Some(SAMPLES), ..Merging::fixed(0.1) };
        let photon_mapping = PhotonMapping { depth, roulette, merging, next_event: false };
        let bidirectional = Bidirectional { depth, roulette, ..Bidirectional::default() };
        let vcm = VertexConnectionMerging { bidirectional, merging, correlation_aware: false };
        let path_tracer = PathTracer { depth, roulette, ..PathTracer::default() };
        let virtual_lights =
            InstantRadiosity { path_tracer, light_walks: SAMPLES, ..InstantRadiosity::default() };
        let kept = |shortest: i32| max_bounces.map_or(0.0, |n| albedo.powi(n as i32 - shortest));
        for (name, passes, kept) in [
            ("photon mapping", passes(&world, &camera, &photon_mapping), kept(1)),
            // Merges are left out where connections draw all.
            ("merging", passes(&world, &camera, &WithNeeds::all(vcm)), kept(1)),
            ("virtual lights", passes(&world, &camera, &virtual_lights), kept(2)),
        ] {
            let name = format!("{name} {max_bounces:?} {roulette:?}");
            assert_mean(&name, moments(&passes, |l| l.emitted.g()), flux, flux);
            assert_mean(&name, moments(&passes, |l| l.truncated.g()), kept * flux, flux);
            assert_mean(&name, moments(&passes, |l| l.absorbed.g()), (1.0 - kept) * flux, flux);
        }
    }
    Ok(())
}

/// A port of area fraction f in an integrating sphere around a point source lets `f/(1 - ρ(1 - f))`
/// of what the first wall hits leave, beside what goes straight out (row A10 of
/// tests/data/analytic.json).
#[test]
fn an_integrating_sphere_lets_the_exact_flux_out() -> Result {
    let (albedo, port): (f64, f64) = (0.9, 0.05);
    let (mut builder, camera) = sphere(albedo, 1.0 - 2.0 * port)?;
    builder.add_light("lamp", PointLight::new(DVec3::ZERO, Rgb::WHITE)?)?;
    let world = builder.build()?;
    let flux = 4.0 * PI;
    let direct = port * flux;
    // Every bounce off a sphere is uniform on the whole sphere, whatever came before.
    let multiple = 1.0 - albedo * (1.0 - port);
    let reflected = (1.0 - port) * flux * albedo * port / multiple;
    let absorbed = (1.0 - port) * flux * (1.0 - albedo) / multiple;
    for roulette in [
        Roulette::default(),
        Roulette { start: 0, survival: Survival::Fixed(0.95), ..Roulette::default() },
    ] {
        let light_tracer = LightTracer { depth: Depth::default(), roulette };
        let bidirectional = Bidirectional { roulette, ..Bidirectional::default() };
        for batches in
            [batches(&world, &camera, &light_tracer), batches(&world, &camera, &bidirectional)]
        {
            assert_mean("emitted", moments(&batches, |l| l.emitted.g()), flux, flux);
            assert_mean("escaped", moments(&batches, |l| l.escaped.g()), direct + reflected, flux);
            assert_mean("absorbed", moments(&batches, |l| l.absorbed.g()), absorbed, flux);
        }
    }
    Ok(())
}
