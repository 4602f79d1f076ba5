//! Guided walks: the weights of all techniques hold in a scene that a field guides, and the image is
//! the same, whoever draws it, on however many threads and in whatever parts.

mod worlds;

use glam::{DVec2, DVec3, UVec2};
use pathspace::endpoint::PinholeCamera;
use pathspace::film::{FilmSample, Sample};
use pathspace::geometry::Sphere;
use pathspace::guiding::{Field, Guided};
use pathspace::integrator::{Bidirectional, Caller, Guiding, Integrator, PathTracer, Run, Stage};
use pathspace::math::Rgb;
use pathspace::math::warp::square_to_sphere;
use pathspace::path::{Heuristic, Scratch, TechniqueSet, Weighting};
use pathspace::render::{Budget, Merger, Render, Rendering, Settings, Shard, render};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::{Emission, Material, Scene, World, WorldBuilder};
use worlds::{Placement, TestScene};

/// A field in which every part of the cube [-1, 1]³ prefers directions of its own.
fn field() -> Field {
    let mut field = Field::unknown();
    let mut sampler = Independent { seed: 1 }.sampler(0, 0);
    for _ in 0..4 {
        let records: Vec<_> = (0..20_000)
            .map(|_| {
                let point = DVec3::from([0.0; 3].map(|_| 2.0 * sampler.next_1d() - 1.0));
                let w = square_to_sphere(sampler.next_2d());
                let energy = (w.dot(point) + 1.0).max(0.0).powi(4);
                // As if the BSDF hardly ever found anything, so that all is guided.
                field.record(point, w, energy, [1.0, 1e-3], 0.5).expect("a number")
            })
            .collect();
        field.learn(&records);
        field.update();
    }
    assert!(field.known() > 20);
    field
}

/// Mean and standard error of the mean pixel by a set of techniques; each path is verified by
/// `visit`.
fn mean<S: Scene>(
    scene: &S,
    TestScene { camera, .. }: &TestScene,
    techniques: TechniqueSet,
    samples: u32,
    verifies: bool,
) -> [f64; 2] {
    let (camera, techniques) = (&**camera, techniques.pruned(&scene.needs()));
    let integrator = Bidirectional { techniques, ..Bidirectional::default() };
    let weighting = Weighting::new(techniques, Heuristic::default());
    let (mut scratch, mut sums, stage) = (Scratch::default(), [0.0; 2], Stage::new(scene, camera));
    let (mut paths, mut inexact) = (0, 0);
    for i in 0..samples {
        let mut sampler = Independent { seed: 2 }.sampler(0, i);
        let raster = camera.film().from_window(sampler.next_2d());
        let film = FilmSample { raster, offset: DVec2::ZERO };
        let mut sum = 0.0;
        let sample = Sample { film, sampler };
        integrator.for_each_path(stage, sample, &mut scratch, |path, found| {
            sum += found.value.luminance() * found.weight;
            if verifies {
                let verified = path.verify(&weighting);
                assert!(verified.weight_sum_error < 1e-11, "{path:?} {verified:?}");
                paths += 1;
                inexact += u32::from(verified.worst() > 1e-6);
            }
        });
        sums = [sums[0] + sum, sums[1] + sum * sum];
    }
    assert!(!verifies || paths > 5000 && 1000 * inexact < paths, "{inexact} of {paths}");
    let n = f64::from(samples);
    let mean = sums[0] / n;
    [mean, ((sums[1] / n - mean * mean) / n).sqrt()]
}

const PATH_TRACING: TechniqueSet =
    TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };

/// Weights sum to 1, are those of the definitions, and rival densities are those of a sweep, on
/// mixtures with Dirac lobes and glass.
#[test]
fn weights_hold_in_a_guided_scene() -> worlds::Result {
    let scene = worlds::mixtures(Placement::UNIT)?;
    let field = field();
    let guided = Guided::new(&scene.world, &field, 0.5).expect("a valid α");
    mean(&guided, &scene, TechniqueSet::BIDIRECTIONAL, 3000, true);
    mean(&guided, &scene, PATH_TRACING, 5000, true);
    Ok(())
}

/// Bidirectional path tracing has the same mean with and without a guide, within 4 standard errors,
/// which would show a bias of 1 %.
#[test]
fn guided_means_are_those_of_the_scene() -> worlds::Result {
    let scene = worlds::mixtures(Placement::UNIT)?;
    let field = field();
    let guided = Guided::new(&scene.world, &field, 0.5).expect("a valid α");
    let all = [
        mean(&guided, &scene, TechniqueSet::BIDIRECTIONAL, 200_000, false),
        mean(&scene.world, &scene, TechniqueSet::BIDIRECTIONAL, 200_000, false),
    ];
    for (i, [a, error]) in all.iter().enumerate() {
        assert!(*error < 0.0025 * a, "{all:?}");
        for [b, other] in &all[..i] {
            assert!((a - b).abs() < 4.0 * error.hypot(*other), "{all:?}");
        }
    }
    Ok(())
}

/// The inside of a sphere of albedo 1/2 with an emissive cap, in which every pixel is 0.1.
fn cap_sphere(radius: f64) -> worlds::Result<TestScene> {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) })?;
    let sphere = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, radius) };
    builder.add_sphere("wall", Sphere { cos_max: 0.8, ..sphere }, grey)?;
    let cap = builder.add_sphere("cap", Sphere { cos_min: 0.8, ..sphere }, grey)?;
    builder.set_emission(cap, Emission { radiance: Rgb::WHITE, two_sided: false })?;
    let size = UVec2::splat(8);
    let camera = PinholeCamera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 53.0, size)?;
    Ok(TestScene { name: "cap".into(), world: builder.build()?, camera: Box::new(camera) })
}

fn guided() -> Guiding<PathTracer> {
    Guiding { always: true, ..Guiding::default() }
}

fn drawn(scene: &TestScene, settings: &Settings) -> worlds::Result<Rendering> {
    Ok(render(&scene.world, &*scene.camera, &guided(), settings)?)
}

/// The exact answer of a sphere of any size, by a field that was learnt there.
#[test]
fn a_learnt_field_keeps_the_exact_answer() -> worlds::Result {
    for radius in [1e-6, 1.0, 1e6] {
        let scene = cap_sphere(radius)?;
        let settings = Settings { budget: Budget::Samples(4096), ..Settings::default() };
        let rendering = drawn(&scene, &settings)?;
        let guidance = rendering.notes.guidance.expect("a finding");
        assert!(guidance.is_used && guidance.parts > 5, "{guidance}");
        assert_eq!(rendering.counters.non_finite, 0);
        let pixels = rendering.image.pixels();
        let n = pixels.len() as f64;
        let mean = pixels.iter().map(|p| p.g()).sum::<f64>() / n;
        let variance = pixels.iter().map(|p| (p.g() - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let error = (variance / n).sqrt();
        assert!((mean - 0.1).abs() < 4.0 * error && error < 0.0025 * 0.1, "{mean} ± {error}");
    }
    Ok(())
}

#[test]
fn threads_and_shards_do_not_matter() -> worlds::Result {
    let scene = worlds::mixtures(Placement::UNIT)?;
    let settings = Settings {
        budget: Budget::Samples(64),
        seed: 3,
        threads: Some(1),
        keeps_checkpoint: true,
        ..Settings::default()
    };
    let whole = drawn(&scene, &settings)?;
    assert!(whole.notes.guidance.is_some_and(|guidance| guidance.is_used));
    for threads in [2, 7] {
        let other = drawn(&scene, &Settings { threads: Some(threads), ..settings })?;
        assert_eq!(other.image, whole.image);
        assert_eq!(other.counters, whole.counters);
    }
    let mut merger = Merger::default();
    for index in 1..=3 {
        let shard = Shard::new(index, 3).expect("a shard");
        let part = drawn(&scene, &Settings { shard, ..settings })?;
        merger.add(&format!("part {index}"), part.checkpoint.expect("asked for"))?;
    }
    assert_eq!(merger.finish()?.image(), whole.image);
    Ok(())
}

/// In an open box guiding gains nothing: the image is that of the integrator to the bit.
#[test]
fn guiding_is_left_out_where_it_does_not_pay() -> worlds::Result {
    let scene = pathspace::gallery::build("cornell-box", UVec2::splat(64))?;
    let settings = Settings { budget: Budget::Samples(64), ..Settings::default() };
    let (guiding, plain) = (Guiding::<PathTracer>::default(), PathTracer::default());
    let image =
        |integrator: &dyn Render<World>| integrator.render(&scene.world, &*scene.camera, &settings);
    let guided = image(&guiding)?;
    let guidance = guided.notes.guidance.expect("a finding");
    assert!(!guidance.is_used && guidance.samples > 0 && guidance.gain < 1.0, "{guidance}");
    assert_eq!(guided.image, image(&plain)?.image);
    Ok(())
}

#[test]
fn probabilities_out_of_range_are_refused() -> worlds::Result {
    let scene = cap_sphere(1.0)?;
    for alpha in [0.0, -1.0, 1.5, f64::NAN] {
        let guiding = Guiding { alpha, ..guided() };
        let run = Integrator::start(&guiding, Stage::new(&scene.world, &*scene.camera), &Caller);
        assert!(run.map(|run| run.techniques()).is_err_and(|e| e.to_string().contains("(0, 1]")));
    }
    Ok(())
}
