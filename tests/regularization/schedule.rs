//! The integrator whose radius shrinks from pass to pass.

use crate::bias::{pool, radiance_of_pool};
use crate::compare::Mean;
use crate::scenes::{Stage, lambert};
use crate::worlds::{self, Placement, Result};
use pathspace::endpoint::{Camera, PinholeCamera};
use pathspace::film::Image;
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{
    Bidirectional, Depth, Estimator, PathTracer, PhotonMapping, Regularization,
};
use pathspace::path::PathClass;
use pathspace::render::{Budget, Checkpoint, Merger, Render, Rendering, Settings, Shard, render};
use pathspace::sampler::SamplerKind;
use pathspace::scene::{Regularized, World};

fn path_tracer() -> Regularization<PathTracer> {
    Regularization::new(PathTracer::up_to(6))
}

fn settings(passes: u32, threads: usize) -> Settings {
    Settings { budget: Budget::Samples(passes), threads: Some(threads), ..Settings::default() }
}

fn bits(image: &Image) -> Vec<u64> {
    image.pixels().iter().flat_map(|p| p.0.map(f64::to_bits)).collect()
}

/// Independent samples, so that the mean over J passes is that of the radii
/// ε_i = ε_1 i^(-1/6), in closed form.
#[test]
fn r01_the_mean_of_passes_is_that_of_their_radii() -> Result {
    const PASSES: u32 = 64;
    let (world, _) = pool();
    let film = UVec2::splat(40);
    let eye = PinholeCamera::new(DVec3::Z * 4.0, DVec3::ZERO, DVec3::X, 1e-4, film)?;
    let path_tracer = PathTracer { depth: Depth::exactly(3), ..PathTracer::default() };
    let integrator = Regularization { epsilon: 0.6, ..Regularization::new(path_tracer) };
    let image = |seed| {
        let sampler = SamplerKind::Independent;
        let settings = Settings { seed, sampler, ..settings(PASSES, 1) };
        Ok(render(&world, &eye, &integrator, &settings)?.image.mean().g())
    };
    let means = (0..32).map(image).collect::<Result<Vec<f64>>>()?;
    let radius = |pass: u32| 0.6 * f64::from(pass + 1).powf(-1.0 / 6.0);
    let expected =
        (0..PASSES).map(|pass| radiance_of_pool(radius(pass))).sum::<f64>() / f64::from(PASSES);
    let (mean, first) = (Mean::of(&means), radiance_of_pool(0.6));
    let error = mean.standard_error();
    println!("{} ± {error}, expected {expected}, of the first radius {first}", mean.value);
    assert!((mean.value - expected).abs() < 4.0 * error, "{mean:?}, expected {expected}");
    assert!(error < 0.0035 * expected && expected > 1.1 * first);
    Ok(())
}

#[test]
fn threads_and_shards_do_not_matter() -> Result {
    let scene = worlds::mixtures(Placement::UNIT)?;
    let all = |threads, shard| {
        let settings = Settings { shard, keeps_checkpoint: true, ..settings(7, threads) };
        render(&scene.world, &*scene.camera, &path_tracer(), &settings)
    };
    let whole = all(1, Shard::WHOLE)?;
    for threads in [2, 7] {
        let other = all(threads, Shard::WHOLE)?;
        assert_eq!(bits(&other.image), bits(&whole.image), "{threads} threads");
        assert_eq!(other.counters, whole.counters);
    }
    let mut merger = Merger::default();
    for index in [3, 1, 2] {
        let shard = all(2, Shard::new(index, 3).expect("a shard"))?.checkpoint.expect("one");
        merger.add(&format!("{index}"), shard)?;
    }
    let merged: Checkpoint = merger.finish()?;
    assert_eq!(bits(&merged.image()), bits(&whole.image));
    assert_eq!(merged.counters(), whole.counters);
    Ok(())
}

/// With one radius it is the integrator in the regularised scene.
#[test]
fn a_fixed_radius_is_that_of_the_scene() -> Result {
    let scene = worlds::smooth_normals(Placement::UNIT)?;
    let mollified = Regularized::new(&scene.world, 0.1)?;
    let (plain, settings) = (Bidirectional::default(), settings(4, 2));
    let there = render(&mollified, &*scene.camera, &plain, &settings)?;
    let by_itself = Regularization::fixed(plain, 0.1);
    let here = render(&scene.world, &*scene.camera, &by_itself, &settings)?;
    assert_eq!(bits(&here.image), bits(&there.image));
    assert_eq!(here.counters, there.counters);
    assert_eq!(here.techniques, there.techniques);
    assert_eq!(here.notes.estimator, Estimator::Biased);
    Ok(())
}

#[test]
fn a_scene_without_dirac_lobes_is_left_alone() -> Result {
    let mut stage = Stage::default();
    stage.square(0.0, 1.0, true, lambert(0.5));
    let lamp = stage.square(1.0, 0.5, false, lambert(0.5));
    stage.glow(lamp, 1.0);
    let (world, eye) =
        (stage.build(), crate::scenes::camera(DVec3::new(0.0, 2.0, 1.0), DVec3::ZERO, 40.0));
    let eye: &dyn Camera = &eye;
    let pairs: [(&dyn Render<World>, &dyn Render<World>); 2] = [
        (&PathTracer::default(), &Regularization::new(PathTracer::default())),
        (&Bidirectional::default(), &Regularization::new(Bidirectional::default())),
    ];
    for (plain, regularized) in pairs {
        let [plain, other]: [Rendering; 2] = [
            plain.render(&world, eye, &settings(9, 2))?,
            regularized.render(&world, eye, &settings(9, 2))?,
        ];
        assert_eq!(bits(&other.image), bits(&plain.image));
        assert_eq!(other.counters, plain.counters);
        assert_eq!(other.notes, plain.notes);
        assert_eq!(other.notes.estimator, Estimator::Unbiased);
    }
    Ok(())
}

#[test]
fn what_cannot_be_rendered_is_refused() -> Result {
    let (world, eye) = pool();
    let reason = |integrator: &dyn Render<World>| {
        integrator.render(&world, &eye, &settings(1, 1)).expect_err("an error").to_string()
    };
    for epsilon in [0.0, -0.1, 1.1, f64::NAN] {
        let error = reason(&Regularization { epsilon, ..path_tracer() });
        assert!(error.contains("radius of mollifiers") && error.contains("regularized"), "{error}");
    }
    for alpha in [0.0, -1.0, 1.5, f64::NAN] {
        let error = reason(&Regularization { alpha, ..path_tracer() });
        assert!(error.contains("alpha"), "{error}");
    }
    // Its passes share photons.
    let error = reason(&Regularization::new(PhotonMapping::default()));
    assert!(error.contains("photon-mapping"), "{error}");
    Ok(())
}

/// Regularised path tracing does not miss what path tracing misses in the pool.
#[test]
fn nothing_is_missing_but_the_light_itself() -> Result {
    let (world, eye) = pool();
    let plain = render(&world, &eye, &PathTracer::default(), &settings(1, 1))?;
    let regularized = render(&world, &eye, &path_tracer(), &settings(1, 1))?;
    let classes = |rendering: &Rendering| {
        rendering.blind_spots().iter().map(|missing| missing.class).collect::<Vec<_>>()
    };
    assert!(classes(&plain).contains(&PathClass::SpecularViewOfCaustic));
    // The light itself is a point.
    assert_eq!(classes(&regularized), [PathClass::Direct]);
    assert_eq!(regularized.notes.estimator, Estimator::Consistent);
    assert_eq!(regularized.integrator, "regularized");
    Ok(())
}
