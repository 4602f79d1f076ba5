//! The audit of one path: its numbers are the integrator's and the definitions', and what cannot be
//! found is said.
#![allow(missing_docs, reason = "a test program")]

use glam::{DVec2, DVec3, UVec2};
use pathspace::endpoint::{Camera, OrthographicCamera, PinholeCamera, ThinLensCamera};
use pathspace::film::{Contribution, FilmSample, Sample, Technique};
use pathspace::gallery;
use pathspace::integrator::{
    Audit, AuditError, AuditedPath, Bidirectional, Depth, Merging, Stage, VertexConnectionMerging,
};
use pathspace::math::Rgb;
use pathspace::path::{Excluded, Obstacle, PathDensities, Scratch, TechniqueSet};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::World;
use std::error::Error;
use std::ops::ControlFlow;

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

const SIZE: UVec2 = UVec2::splat(32);

fn audit(depth: Depth, techniques: TechniqueSet, light_walks: u32) -> Audit {
    Audit {
        integrator: VertexConnectionMerging {
            bidirectional: Bidirectional { depth, techniques, ..Bidirectional::default() },
            merging: Merging { light_walks: Some(light_walks), ..Merging::default() },
            ..VertexConnectionMerging::default()
        },
        max_samples: 100_000,
        ..Audit::default()
    }
}

fn find(
    audit: &Audit,
    world: &World,
    camera: &dyn Camera,
) -> std::result::Result<AuditedPath, AuditError> {
    let path = audit.find(world, camera, &mut || ControlFlow::Continue(()))?;
    path.ok_or(AuditError::NotFound { samples: 0 })
}

fn excluded(techniques: &[Technique]) -> Excluded {
    let all = techniques.iter().try_fold(Excluded::NONE, |set, one| set.with(*one));
    all.expect("short paths")
}

fn assert_close(a: Rgb, b: Rgb, what: &str) {
    let (error, scale) = ((a - b).map(f64::abs).max_component(), b.max_component());
    assert!(error <= 1e-6 * scale, "{what}: {a:?} {b:?}");
}

/// Weights sum to 1; the running throughputs make the contribution; the technique that drew the path
/// has the integrator's estimate and weight.
#[test]
fn numbers_are_those_of_the_integrator_and_the_definitions() -> Result {
    let all = TechniqueSet::BIDIRECTIONAL;
    let off = excluded(&[Technique::new(1, 3), Technique::merge(2, 3), Technique::merge(2, 2)]);
    let (mut merged, mut seen) = (0, 0);
    for name in gallery::NAMES {
        let scene = gallery::build(name, SIZE)?;
        for light_walks in [0, 1000] {
            for set in [all, TechniqueSet { excluded: off, ..all }] {
                for seed in 0..6 {
                    let depth = Depth { min_bounces: 1, ..Depth::up_to(4) };
                    let audit = Audit { seed, ..audit(depth, set, light_walks) };
                    let path = find(&audit, &scene.world, &scene.camera)?;
                    let record = &path.record;
                    let what = format!("{name} {light_walks} {seed} {}", path.technique);
                    let techniques: Vec<_> = path.techniques().collect();
                    let k = record.edges();
                    let merges = if light_walks > 0 { k - 1 } else { 0 };
                    assert_eq!(techniques.len(), k + 1 + merges, "{what}");
                    let sum: f64 = techniques.iter().map(|one| one.weight).sum();
                    assert!((sum - 1.0).abs() < 1e-12, "{what}: {sum}");
                    for one in &techniques {
                        assert_eq!(one.obstacle.is_none(), one.weight > 0.0, "{what} {one:?}");
                        assert_eq!(one.estimate.is_some(), one.density > 0.0, "{what} {one:?}");
                        if set.excluded.contains(one.technique) {
                            assert!(!one.is_in_set() && one.weight == 0.0, "{what} {one:?}");
                        }
                        // f = n p · f/(n p), whichever technique might have drawn it.
                        if let Some(estimate) = one.estimate {
                            let n = if one.technique.merged { f64::from(light_walks) } else { 1.0 };
                            let f = estimate * (n * one.density);
                            assert_close(f, record.contribution(), &what);
                        }
                    }
                    let drawn = techniques.iter().find(|one| one.technique == path.technique);
                    let drawn = drawn.ok_or("the technique is not among them")?;
                    let estimate = drawn.estimate.ok_or("no estimate")?;
                    assert_close(path.value * path.survival, estimate, &what);
                    assert!((path.weight - drawn.weight).abs() < 1e-6, "{what}");
                    assert!(path.verification.worst() < 1e-6, "{what} {:?}", path.verification);
                    let steps: Vec<Rgb> = record.throughputs().collect();
                    assert_eq!(steps.len(), k - 1);
                    let mut throughput = Rgb::WHITE;
                    for (i, step) in (1..).zip(&steps) {
                        let edge = record.geometry_terms[i] * record.transmittances[i];
                        throughput = throughput * record.factors[i] * edge;
                        assert_eq!(throughput, *step);
                    }
                    let first = record.geometry_terms[0] * record.transmittances[0];
                    let f = record.factors[0] * first * throughput * record.factors[k];
                    assert_eq!(f, record.contribution(), "{what}");
                    assert_eq!(path.distance.is_some(), path.technique.merged);
                    assert!(path.distance.unwrap_or(0.0) <= path.radius());
                    (merged, seen) = (merged + u32::from(path.technique.merged), seen + 1);
                }
            }
        }
    }
    println!("{merged} of {seen} merged");
    assert!(merged > 10 && merged < seen);
    Ok(())
}

/// The path that is shown is one that the integrator adds to its image for the same numbers, and no
/// candidate is brighter.
#[test]
fn the_path_is_one_that_the_integrator_draws() -> Result {
    let scene = gallery::build("cornell-box", SIZE)?;
    let (pixel, depth) = (UVec2::new(9, 20), Depth::exactly(2));
    let settings = Audit { pixel: Some(pixel), ..audit(depth, TechniqueSet::BIDIRECTIONAL, 0) };
    let path = find(&settings, &scene.world, &scene.camera)?;
    assert_eq!(path.raster.as_uvec2(), pixel);
    let integrator = settings.integrator.bidirectional;
    let mut scratch = Scratch::default();
    let (mut is_drawn, mut brightest) = (false, 0.0f64);
    for sample in 0..=path.sample {
        let mut sampler = Independent { seed: settings.seed }.sampler(sample, 0);
        let raster = pixel.as_dvec2() + sampler.next_2d();
        let film = FilmSample { raster, offset: DVec2::ZERO };
        let sample_of_film = Sample { film, sampler: &mut sampler };
        let stage = Stage { seed: settings.seed, ..Stage::new(&scene.world, &scene.camera) };
        integrator.for_each_path(stage, sample_of_film, &mut scratch, |_, found| {
            let Contribution { raster, value, weight, technique } = *found;
            if raster.as_uvec2() == pixel {
                brightest = brightest.max((value * weight).luminance());
            }
            let is_same = (raster, value, weight, technique)
                == (path.raster, path.value, path.weight, path.technique);
            is_drawn |= sample == path.sample && is_same;
        });
    }
    assert!(is_drawn);
    assert_eq!((path.value * path.weight).luminance(), brightest);
    let first = find(&Audit { candidates: 1, ..settings }, &scene.world, &scene.camera)?;
    assert!(first.sample <= path.sample);
    assert!((first.value * first.weight).luminance() <= brightest);
    Ok(())
}

#[test]
fn what_cannot_be_found_has_a_reason() -> Result {
    let scene = gallery::build("cornell-box", SIZE)?;
    let (all, (world, camera)) = (TechniqueSet::BIDIRECTIONAL, (&scene.world, &scene.camera));
    let off = TechniqueSet { excluded: excluded(&[Technique::new(1, 3)]), ..all };
    let plain = audit(Depth::exactly(2), off, 0);
    let by = |s, t| Audit { technique: Some(Technique::new(s, t)), ..plain };
    let merging = |s, t| Audit { technique: Some(Technique::merge(s, t)), ..plain };
    let mut refused = plain;
    refused.integrator.merging = Merging { light_walks: Some(10), ..Merging::fixed(f64::NAN) };
    let cases = [
        (Audit { pixel: Some(UVec2::new(3, 32)), ..plain }, "pixel 3,32 is not on the film"),
        (by(4, 0), "there is no technique (4, 0)"),
        (merging(1, 4), "there is no technique merge (1, 4)"),
        (by(u16::MAX, u16::MAX), "technique (65535, 65535) draws paths with 65533 bounces"),
        (by(2, 3), "draws paths with 3 bounces, which do not count"),
        (by(1, 3), "technique (1, 3) draws nothing here: it is switched off"),
        (merging(2, 3), "draws nothing here: the integrator does not have it"),
        (Audit { max_samples: 0, ..plain }, "no path that fits in 0 samples"),
        (refused, "the radius is NaN"),
    ];
    for (audit, expected) in cases {
        let error = find(&audit, world, camera).map(|path| path.technique).expect_err(expected);
        assert!(error.to_string().contains(expected), "{error}");
    }
    let stopped = plain.find(world, camera, &mut || ControlFlow::Break(()))?;
    assert!(stopped.is_none());
    // What a mirror and a lamp without extent leave of the techniques.
    let reasons = |name, technique: Technique, bounces| -> Result<Vec<(Technique, Obstacle)>> {
        let scene = gallery::build(name, SIZE)?;
        let audit = audit(Depth::exactly(bounces), all, 100);
        let audit = Audit { technique: Some(technique), ..audit };
        let path = find(&audit, &scene.world, &scene.camera)?;
        Ok(path.techniques().filter_map(|one| Some((one.technique, one.obstacle?))).collect())
    };
    let reasons = reasons("pool", Technique::merge(3, 3), 3)?;
    println!("{reasons:?}");
    assert!(reasons.iter().any(|(_, reason)| matches!(reason, Obstacle::Dirac(_))));
    Ok(())
}

/// A camera sees a point of a ray where the ray is recorded, and nothing behind itself.
#[test]
fn points_are_seen_where_their_rays_are_recorded() -> Result {
    let (eye, target, size) = (DVec3::new(1.0, -3.0, 2.0), DVec3::ZERO, UVec2::new(40, 30));
    let (up, fov) = (DVec3::Z, 50.0);
    let pinhole = PinholeCamera::new(eye, target, up, fov, size)?.mirrored();
    let lens = ThinLensCamera::new(eye, target, up, fov, 0.2, 3.0, size)?;
    let parallel = OrthographicCamera::new(eye, target, up, 3.0, size)?;
    let cameras: [&dyn Camera; 3] = [&pinhole, &lens, &parallel];
    for camera in cameras {
        let middle = camera.sample_point(0.5, DVec2::splat(0.5)).ok_or("no lens")?.point;
        for (i, distance) in (0..100).zip([0.1, 3.0, 50.0].into_iter().cycle()) {
            let u = DVec2::new(0.1 * f64::from(i % 10), 0.01 * f64::from(i)) * 1.2 - 0.1;
            let ray = camera.sample_direction(&middle, u).ok_or("no ray")?;
            let at = |t: f64| ray.from.position + t * ray.direction;
            let raster = camera.project(at(distance)).ok_or("not seen")?;
            let expected = camera.film().from_window(u);
            assert!(raster.distance(expected) < 1e-9, "{raster} {expected}");
            assert_eq!(camera.project(at(-1.0)), None);
        }
        assert_eq!(camera.project(eye), None);
        assert_eq!(camera.project(DVec3::NAN), None);
    }
    let scene = gallery::build("cornell-box", SIZE)?;
    let by = Audit {
        technique: Some(Technique::new(1, 3)),
        ..audit(Depth::exactly(2), TechniqueSet::BIDIRECTIONAL, 0)
    };
    let path = find(&by, &scene.world, &scene.camera)?;
    let first = scene.camera.project(path.record.points[1].position).ok_or("not seen")?;
    assert!(first.distance(path.raster) < 1e-9);
    Ok(())
}
