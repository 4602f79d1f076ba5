//! Samples that are drawn together contribute what each of them contributes alone, to the bit and
//! in the same order.
#![allow(missing_docs, reason = "a test program")]

mod worlds;

use pathspace::endpoint::Camera;
use pathspace::film::{Contribution, FilmSample, Filter, Sample};
use pathspace::integrator::{
    Bidirectional, Caller, InstantRadiosity, Integrator, LightTracer, PathTracer, PathTracing,
    PhotonMapping, Run, Stage, UniformArea, VertexConnectionMerging,
};
use pathspace::math::Rgb;
use pathspace::path::{Counters, LightSubpaths, Roulette, Scratch, TechniqueSet};
use pathspace::sampler::{AnySampler, SampleSource, SamplerKind};
use pathspace::scene::World;
use worlds::{Result, TestScene};

/// More than scenes take at a time, and no multiple of it.
const SAMPLES: u32 = 150;

fn samples(camera: &dyn Camera, kind: SamplerKind) -> Vec<Sample<AnySampler>> {
    let (source, region, kernel) =
        (kind.source(7, 4), camera.film(), Filter::Tent.kernel().expect("valid"));
    let sample = |i: u32| {
        let pixel = i * 13 % region.pixels();
        let mut sampler = source.sampler(pixel, i % 4);
        Sample { film: FilmSample::draw(&region, pixel, &kernel, &mut sampler), sampler }
    };
    (0..SAMPLES).map(sample).collect()
}

/// The counters without the ledger, whose sums are taken in another order.
fn counts(counters: Counters) -> Counters {
    Counters { ledger: Default::default(), ..counters }
}

/// The contributions of all samples together; also checks that drawing them one by one gives the
/// same.
fn check<I: Integrator<World>>(
    scene: &TestScene,
    integrator: &I,
    kind: SamplerKind,
) -> Vec<Vec<Contribution>> {
    let (world, camera): (&World, &dyn Camera) = (&scene.world, &*scene.camera);
    let what = format!("{} in {} by {kind:?}", integrator.name(), scene.name);
    let mut run = integrator.start(Stage::new(world, camera), &Caller).expect("a run");
    if run.prepares() {
        run.begin_pass(0, &Caller).expect("memory");
    }
    let (mut one, mut many) = (Scratch::default(), Scratch::default());
    let alone: Vec<Vec<Contribution>> = samples(camera, kind)
        .into_iter()
        .map(|Sample { film, sampler }| {
            let mut contributions = Vec::new();
            run.sample(film, sampler, &mut contributions, &mut one);
            contributions
        })
        .collect();
    let mut together = vec![Vec::new(); SAMPLES as usize];
    let mut each =
        |sample: usize, contribution: &Contribution| together[sample].push(*contribution);
    run.draw(&mut samples(camera, kind), &mut each, &mut Default::default(), &mut many);
    assert_eq!(together, alone, "{what}");
    assert_eq!(counts(many.counters), counts(one.counters), "{what}");
    together
}

fn check_all<I: Integrator<World>>(integrators: &[I]) -> Result {
    for scene in worlds::all()? {
        for kind in [SamplerKind::Independent, SamplerKind::Sobol] {
            integrators.iter().for_each(|integrator| drop(check(&scene, integrator, kind)));
        }
    }
    Ok(())
}

/// Roulette that adds its constant.
const ROULETTE: Roulette = Roulette { start: 1, constant: Rgb::splat(0.01), ..Roulette::NEVER };

#[test]
fn uniform_area() -> Result {
    check_all(&[UniformArea::default()])
}

#[test]
fn path_tracing() -> Result {
    let roulette = Roulette { survival: Roulette::default().survival, ..ROULETTE };
    let plain = PathTracer::default();
    check_all(&[
        plain,
        PathTracer { mode: PathTracing::EmissionOnly, ..plain },
        PathTracer { mode: PathTracing::NextEventOnly, ..plain },
        PathTracer { roulette, ..PathTracer::up_to(5) },
    ])
}

#[test]
fn light_tracing() -> Result {
    check_all(&[
        LightTracer::default(),
        LightTracer { roulette: ROULETTE, ..LightTracer::up_to(4) },
    ])
}

#[test]
fn light_walks_that_all_samples_share() -> Result {
    let photons = PhotonMapping::default();
    check_all(&[photons, PhotonMapping { next_event: true, ..photons }])?;
    let lights = InstantRadiosity::default();
    let path_tracer = PathTracer { roulette: ROULETTE, ..PathTracer::up_to(5) };
    check_all(&[
        lights,
        InstantRadiosity { path_tracer, compensates: false, ..lights },
        // More connections than are drawn together.
        InstantRadiosity { light_walks: 700, ..lights },
    ])?;
    check_all(&[VertexConnectionMerging::default()])
}

/// They are also those of the paths that `for_each_path` shows, which draws samples one by one.
#[test]
fn bidirectional() -> Result {
    let all = TechniqueSet::BIDIRECTIONAL;
    let walks = |power| LightSubpaths::power_of_two(power).expect("few");
    let sets = [
        all,
        TechniqueSet { light_subpaths: walks(2), ..all },
        TechniqueSet { light_subpaths: walks(-2), connections: false, ..all },
    ];
    for scene in worlds::all()? {
        for (kind, techniques) in [SamplerKind::Independent, SamplerKind::Sobol]
            .into_iter()
            .flat_map(|kind| sets.map(|set| (kind, set)))
        {
            let integrator =
                Bidirectional { techniques, roulette: ROULETTE, ..Bidirectional::up_to(6) };
            let mut together = check(&scene, &integrator, kind);
            let (mut scratch, camera) = (Scratch::default(), &*scene.camera);
            for (Sample { film, mut sampler }, together) in
                samples(camera, kind).into_iter().zip(&mut together)
            {
                let mut paths: Vec<Contribution> = Vec::new();
                integrator.for_each_path(
                    Stage::new(&scene.world, camera),
                    Sample { film, sampler: &mut sampler },
                    &mut scratch,
                    |_, &contribution| paths.push(contribution),
                );
                // Paths without a connection are not last in a batch.
                paths.sort_by_key(|path| path.technique);
                together.sort_by_key(|contribution| contribution.technique);
                assert_eq!(*together, paths, "{} by {kind:?}", scene.name);
            }
        }
    }
    Ok(())
}
