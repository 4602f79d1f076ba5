//! The limits of radius and of what is merged.

use crate::common::{Moments, Random};
use crate::worlds::{self, Result};
use glam::{DVec3, UVec2};
use pathspace::endpoint::{OrthographicCamera, SpotLight};
use pathspace::film::{Contribution, Sample};
use pathspace::geometry::Quad;
use pathspace::integrator::{
    Bidirectional, Caller, Depth, Integrator, Merging, PhotonMapping, Run, Stage,
    VertexConnectionMerging, WithNeeds,
};
use pathspace::math::Rgb;
use pathspace::path::Scratch;
use pathspace::render::{Budget, Settings, render};
use pathspace::scene::{Material, WorldBuilder};
use std::f64::consts::PI;

/// With a radius of 0, or one whose square underflows, every contribution is that of bidirectional
/// path tracing to the bit.
#[test]
fn nothing_merged_is_bidirectional_path_tracing() -> Result {
    for scene in worlds::all()? {
        let bidirectional = WithNeeds::all(Bidirectional::up_to(7));
        let stage = Stage::new(&scene.world, &*scene.camera);
        let expected = contributions(&bidirectional.start(stage, &Caller)?, &*scene.camera);
        for radius in [0.0, 1e-300, 1e-170] {
            let integrator = WithNeeds::all(VertexConnectionMerging {
                bidirectional: bidirectional.integrator,
                merging: Merging { light_walks: Some(100), ..Merging::from_radius(radius) },
                correlation_aware: false,
            });
            let mut run = integrator.start(stage, &Caller)?;
            run.begin_pass(0, &Caller)?;
            let found = contributions(&run, &*scene.camera);
            assert!(found.len() > 500, "{}", scene.name);
            assert_eq!(found, expected, "{} r = {radius}", scene.name);
        }
    }
    Ok(())
}

fn contributions<'a, R: Run<'a, pathspace::scene::World>>(
    run: &R,
    camera: &dyn pathspace::endpoint::Camera,
) -> Vec<Contribution> {
    let (mut random, mut scratch, mut found) =
        (Random::new(4), Scratch::default(), Vec::<Contribution>::new());
    for _ in 0..1500 {
        let film = worlds::film_sample(camera, &mut random);
        let sample = &mut [Sample { film, sampler: &mut random }];
        run.draw(sample, &mut found, &mut Default::default(), &mut scratch);
    }
    found
}

/// Two lamps, each on its own half of a floor, one light walk and one pixel: if the walk were drawn
/// with the numbers of the sample, the number that places the sample on the film would choose the
/// lamp below it, and the mean would be twice as large. It is ρ/π Φ/A.
#[test]
fn shared_walks_have_numbers_of_their_own() -> Result {
    let (albedo, degrees) = (0.5, 10.0f64);
    let mut builder = WorldBuilder::new();
    let floor = builder.add_material("floor", Material::Lambert { albedo: Rgb::splat(albedo) })?;
    let [origin, edge_u, edge_v] = [DVec3::new(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0];
    builder.add_quad("floor", Quad { origin, edge_u, edge_v }, floor)?;
    for (name, x) in [("left", -0.5), ("right", 0.5)] {
        let at = DVec3::new(x, 0.0, 1.0);
        let lamp = SpotLight::new(at, DVec3::NEG_Z, Rgb::WHITE, degrees, degrees)?;
        builder.add_light(name, lamp)?;
    }
    let world = builder.build()?;
    let eye = OrthographicCamera::new(DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y, 2.0, UVec2::ONE)?;
    let integrator = PhotonMapping {
        depth: Depth::exactly(1),
        merging: Merging { light_walks: Some(1), ..Merging::fixed(0.3) },
        ..PhotonMapping::default()
    };
    let flux = 2.0 * 4.0 * PI * (0.5 * degrees.to_radians()).sin().powi(2);
    let expected = albedo / PI * flux / 4.0;
    let mut moments = Moments::default();
    for seed in 0..40 {
        let settings = Settings { seed, budget: Budget::Samples(2000), ..Settings::default() };
        let rendering = render(&world, &eye, &integrator, &settings)?;
        moments.add(rendering.image.mean().g());
    }
    let (mean, error) = (moments.mean(), moments.standard_error());
    assert!((mean - expected).abs() < 4.0 * error, "{mean} ± {error}, expected {expected}");
    assert!(error < 0.02 * expected, "{error} of {expected}");
    Ok(())
}
