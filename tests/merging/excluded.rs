//! Techniques that are switched off one by one, merges among them.

use crate::common::{Moments, Random};
use crate::passes::over_passes;
use crate::worlds::Result;
use glam::{DVec2, DVec3, UVec2};
use pathspace::endpoint::PinholeCamera;
use pathspace::film::{Contribution, FilmSample, Technique};
use pathspace::geometry::{Bounds, Facing, Quad};
use pathspace::integrator::{
    Bidirectional, Caller, Depth, Integrator, Merging, Stage, VertexConnectionMerging, WithNeeds,
};
use pathspace::math::Rgb;
use pathspace::path::{Excluded, Heuristic, TechniqueSet};
use pathspace::sampler::Sampler;
use pathspace::scene::{Emission, Material, World, WorldBuilder};
use std::collections::BTreeMap;

const RADIUS: f64 = 0.03;
const LIGHT_WALKS: u32 = 4000;

/// A room of side 2, its lamp a square in the ceiling, and the middle of its floor: flat, and far
/// from every edge for the radius.
fn room() -> Result<(World, PinholeCamera)> {
    let mut builder = WorldBuilder::new();
    let wall = Material::Lambert { albedo: Rgb::splat(0.6) };
    let wall = builder.add_material("wall", wall)?;
    let bounds = Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE };
    builder.add_box("room", bounds, Facing::Inward, wall)?;
    let (origin, edge_u, edge_v) = (DVec3::new(-0.4, -0.4, 0.99), DVec3::Y * 0.8, DVec3::X * 0.8);
    let lamp = builder.add_quad("lamp", Quad { origin, edge_u, edge_v }, wall)?;
    builder.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false })?;
    let eye = DVec3::new(0.0, -0.8, 0.5);
    let eye = PinholeCamera::new(eye, DVec3::NEG_Z, DVec3::Z, 20.0, UVec2::ONE)?;
    Ok((builder.build()?, eye))
}

/// The means over passes of what is drawn, and of each technique's part of it.
fn measure(
    (world, eye): &(World, PinholeCamera),
    techniques: TechniqueSet,
    light_walks: u32,
    (passes, samples): (u32, u32),
) -> Result<(Moments, BTreeMap<Technique, f64>)> {
    let bidirectional = Bidirectional {
        techniques,
        depth: Depth { min_bounces: 1, ..Depth::up_to(3) },
        heuristic: Heuristic::Balance,
        ..Bidirectional::default()
    };
    let merging = Merging { light_walks: Some(light_walks), ..Merging::fixed(RADIUS) };
    let integrator = WithNeeds::all(VertexConnectionMerging {
        bidirectional,
        merging,
        ..VertexConnectionMerging::default()
    });
    let mut run = integrator.start(Stage { seed: 5, ..Stage::new(world, eye) }, &Caller)?;
    let film = |random: &mut Random| FilmSample { raster: random.next_2d(), offset: DVec2::ZERO };
    let mut parts = BTreeMap::new();
    let total = |found: &[Contribution]| {
        let weighted = |one: &Contribution| one.value.g() * one.weight;
        found.iter().for_each(|one| *parts.entry(one.technique).or_default() += weighted(one));
        found.iter().map(weighted).sum()
    };
    let moments = over_passes(&mut run, passes, samples, &mut Random::new(5), film, total);
    let number = f64::from(passes) * f64::from(samples);
    parts.values_mut().for_each(|part| *part /= number);
    Ok((moments, parts))
}

/// Without two merges and a connection the rest shares their weight: the mean is that of
/// bidirectional path tracing, to 1 % with four standard errors.
#[test]
fn the_mean_stays_without_merges_and_connections() -> Result {
    let room = room()?;
    let off = [Technique::new(1, 3), Technique::merge(2, 2), Technique::merge(3, 2)];
    let excluded = off.into_iter().try_fold(Excluded::NONE, Excluded::with).ok_or("long paths")?;
    let all = TechniqueSet::BIDIRECTIONAL;
    let (expected, parts) = measure(&room, all, 0, (400, 400))?;
    assert!(parts.keys().all(|technique| !technique.merged));
    let (_, parts) = measure(&room, all, LIGHT_WALKS, (20, 100))?;
    let sum: f64 = parts.values().sum();
    // Weights that still counted them would lose much of the mean.
    let share = off.map(|technique| parts.get(&technique).unwrap_or(&0.0) / sum);
    println!("off: {share:.3?}");
    assert!(share.iter().all(|share| *share > 0.03), "{share:?}");
    let (moments, parts) =
        measure(&room, TechniqueSet { excluded, ..all }, LIGHT_WALKS, (400, 100))?;
    assert!(off.iter().all(|technique| !parts.contains_key(technique)), "{parts:?}");
    assert!(parts.contains_key(&Technique::merge(2, 3)), "{parts:?}");
    let error = moments.standard_error().hypot(expected.standard_error());
    let (mean, expected) = (moments.mean(), expected.mean());
    println!("{mean} ± {error}, expected {expected}");
    assert!(error <= 0.0025 * expected, "the standard error {error} is too large");
    assert!((mean - expected).abs() <= 4.0 * error, "{mean} ± {error}, expected {expected}");
    Ok(())
}
