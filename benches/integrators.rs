//! Each integrator on the Cornell box, single-threaded: samples per second, and rays per sample.
//! Weights of recorded paths alone.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, UVec2};
use pathspace::film::{Contribution, FilmSample, Sample, Technique};
use pathspace::gallery::{self, GalleryScene};
use pathspace::integrator::{
    Bidirectional, Caller, Depth, Integrator, LightTracer, PathTracer, Run, Stage, UniformArea,
};
use pathspace::math::Rgb;
use pathspace::path::{
    Counters, Path, PathDensities, PathRecord, Roulette, Scratch, TechniqueSet, Weighting,
};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::World;
use std::hint::black_box;
use std::time::Duration;

const SIDE: u32 = 64;
const SAMPLES: u32 = SIDE * SIDE;
const MAX_BOUNCES: u32 = 7;
/// The samples under way at once, as in the driver.
const BATCH: u32 = 128;

/// One sample per pixel, so many at a time.
fn pass<I: Integrator<World>>(scene: &GalleryScene, integrator: &I, batch: u32) -> Counters {
    let (source, camera) = (Independent { seed: 1 }, &*scene.camera);
    let run = integrator.start(Stage::new(&scene.world, camera), &Caller).expect("a run");
    let (mut scratch, mut sum) = (Scratch::default(), Rgb::BLACK);
    let mut add = |_: usize, found: &Contribution| sum += found.value * found.weight;
    for first in (0..SAMPLES).step_by(batch as usize) {
        let sample = |pixel: u32| {
            let mut sampler = source.sampler(pixel, 0);
            let raster = UVec2::new(pixel % SIDE, pixel / SIDE).as_dvec2() + sampler.next_2d();
            Sample { film: FilmSample { raster, offset: DVec2::ZERO }, sampler }
        };
        let mut samples: Vec<_> = (first..first + batch).map(sample).collect();
        run.draw(&mut samples, &mut add, &mut Default::default(), &mut scratch);
    }
    black_box(sum);
    scratch.counters
}

fn integrators(criterion: &mut Criterion) {
    let scene = gallery::build("cornell-box", UVec2::splat(SIDE)).expect("a scene of the gallery");
    let depth = Depth::up_to(MAX_BOUNCES);
    let s01 = TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };
    let mut group = criterion.benchmark_group("cornell-box");
    group
        .throughput(Throughput::Elements(u64::from(SAMPLES)))
        .sample_size(20)
        .measurement_time(Duration::from_secs(5));
    let mut bench = |name: &str, run: &dyn Fn() -> Counters| {
        let counters = run();
        println!("{name}: {:.2} rays per sample", counters.rays() as f64 / f64::from(SAMPLES));
        group.bench_function(name, |bencher| bencher.iter(run));
    };
    let roulette = Roulette::default();
    let bidirectional = Bidirectional { depth, ..Bidirectional::default() };
    bench("uniform-area", &|| pass(&scene, &UniformArea { depth, roulette }, BATCH));
    bench("path-tracing", &|| pass(&scene, &PathTracer { depth, ..PathTracer::default() }, BATCH));
    bench("path-tracing/one-by-one", &|| {
        pass(&scene, &PathTracer { depth, ..PathTracer::default() }, 1)
    });
    bench("path-tracing/general-kernel", &|| {
        pass(&scene, &Bidirectional { techniques: s01, ..bidirectional }, BATCH)
    });
    bench("light-tracing", &|| pass(&scene, &LightTracer { depth, roulette }, BATCH));
    bench("light-tracing/one-by-one", &|| pass(&scene, &LightTracer { depth, roulette }, 1));
    bench("bidirectional", &|| pass(&scene, &bidirectional, BATCH));
    bench("bidirectional/one-by-one", &|| pass(&scene, &bidirectional, 1));
    group.finish();
}

/// The weight of one path of each number of vertices, drawn from the middle.
fn weights(criterion: &mut Criterion) {
    let scene = gallery::build("cornell-box", UVec2::splat(SIDE)).expect("a scene of the gallery");
    let mut group = criterion.benchmark_group("weight");
    group.measurement_time(Duration::from_secs(2));
    for vertices in [3usize, 6, 10] {
        let depth = Depth::exactly(vertices as u32 - 2);
        let integrator =
            Bidirectional { depth, roulette: Roulette::NEVER, ..Bidirectional::default() };
        let weighting = Weighting::new(integrator.techniques, integrator.heuristic);
        let measure = |path: &Path<'_, '_, World>,
                       record: &PathRecord,
                       group: &mut criterion::BenchmarkGroup<'_, _>| {
            group.bench_function(format!("{vertices} vertices"), |b| {
                b.iter(|| black_box(path).weight(&weighting))
            });
            group.bench_function(format!("{vertices} vertices, sweep alone"), |b| {
                b.iter(|| weigh(black_box(record), path.technique(), &weighting))
            });
        };
        let (source, mut scratch, mut found) = (Independent { seed: 2 }, Scratch::default(), false);
        for pixel in 0..SAMPLES {
            let mut sampler = source.sampler(pixel, 0);
            let film =
                FilmSample { raster: sampler.next_2d() * f64::from(SIDE), offset: DVec2::ZERO };
            integrator.for_each_path(
                Stage::new(&scene.world, &*scene.camera),
                Sample { film, sampler: &mut sampler },
                &mut scratch,
                |path, _| {
                    if !found && usize::from(path.technique().t) == vertices / 2 + 1 {
                        found = true;
                        measure(path, &path.record(), &mut group);
                    }
                },
            );
        }
    }
    group.finish();
}

fn weigh(record: &PathRecord, technique: Technique, weighting: &Weighting) -> f64 {
    record.weight(technique, weighting)
}

criterion_group!(benches, integrators, weights);
criterion_main!(benches);
