//! Samples that are drawn together contribute what each of them contributes alone, to the bit and
//! in the same order.
#![allow(missing_docs, reason = "a test program")]

mod worlds;

use pathspace::endpoint::Camera;
use pathspace::film::{BatchSample, BatchSink, Contribution, FilmSample, Filter};
use pathspace::integrator::{
    Bidirectional, Integrator, LightTracer, PathTracer, PathTracing, UniformArea,
};
use pathspace::math::Rgb;
use pathspace::path::{Counters, LightWalks, Roulette, Scratch, TechniqueSet};
use pathspace::sampler::{AnySampler, SampleSource, SamplerKind};
use pathspace::scene::World;
use worlds::{Result, TestScene};

/// More than scenes take at a time, and no multiple of it.
const SAMPLES: u32 = 150;

/// The contributions of each sample.
struct Each(Vec<Vec<Contribution>>);

impl BatchSink for Each {
    fn add(&mut self, sample: usize, contribution: &Contribution) {
        self.0[sample].push(*contribution);
    }
}

fn samples(camera: &dyn Camera, kind: SamplerKind) -> Vec<BatchSample<AnySampler>> {
    let (source, region, kernel) =
        (kind.source(7, 4), camera.film(), Filter::Tent.kernel().expect("valid"));
    let sample = |i: u32| {
        let pixel = i * 13 % region.pixels();
        let mut sampler = source.sampler(pixel, i % 4);
        BatchSample { film: FilmSample::draw(&region, pixel, &kernel, &mut sampler), sampler }
    };
    (0..SAMPLES).map(sample).collect()
}

/// Without the ledger, whose sums are taken in another order.
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
    let (mut one, mut many) = (Scratch::default(), Scratch::default());
    let alone: Vec<Vec<Contribution>> = samples(camera, kind)
        .into_iter()
        .map(|BatchSample { film, mut sampler }| {
            let mut contributions = Vec::new();
            integrator.sample(world, camera, film, &mut sampler, &mut contributions, &mut one);
            contributions
        })
        .collect();
    let mut together = Each(vec![Vec::new(); SAMPLES as usize]);
    integrator.sample_batch(world, camera, &mut samples(camera, kind), &mut together, &mut many);
    assert_eq!(together.0, alone, "{what}");
    assert_eq!(counts(many.counters), counts(one.counters), "{what}");
    together.0
}

fn check_all<I: Integrator<World>>(integrators: &[I]) -> Result {
    for scene in worlds::all()? {
        for kind in [SamplerKind::Independent, SamplerKind::Sobol] {
            integrators.iter().for_each(|integrator| drop(check(&scene, integrator, kind)));
        }
    }
    Ok(())
}

/// Roulette that adds its constant and skips shadow rays.
const ROULETTE: Roulette =
    Roulette { start: 1, constant: Rgb::splat(0.01), shadow_threshold: 0.5, ..Roulette::NEVER };

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

/// They are also those of the paths that `for_each_path` shows, which draws samples one by one.
#[test]
fn bidirectional() -> Result {
    let all = TechniqueSet::BIDIRECTIONAL;
    let lens_first = TechniqueSet { connections: false, lens_first: true, ..all };
    let walks = |power| LightWalks::power_of_two(power).expect("few");
    let sets = [
        all,
        TechniqueSet { light_walks: walks(2), ..all },
        TechniqueSet { light_walks: walks(-2), ..lens_first },
    ];
    for scene in worlds::all()? {
        for (kind, techniques) in [SamplerKind::Independent, SamplerKind::Sobol]
            .into_iter()
            .flat_map(|kind| sets.map(|set| (kind, set)))
        {
            let integrator =
                Bidirectional { techniques, roulette: ROULETTE, ..Bidirectional::up_to(6) };
            let mut together = check(&scene, &integrator, kind);
            if techniques.lens_first {
                continue;
            }
            let (mut scratch, camera) = (Scratch::default(), &*scene.camera);
            for (BatchSample { film, mut sampler }, together) in
                samples(camera, kind).into_iter().zip(&mut together)
            {
                let mut paths: Vec<Contribution> = Vec::new();
                integrator.for_each_path(
                    &scene.world,
                    camera,
                    film,
                    &mut sampler,
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
