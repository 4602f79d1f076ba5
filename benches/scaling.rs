//! The growth of a sample's cost with the number of lights, the length of paths and the size of the
//! image, and its fall with threads; and of variance × time with the number of lights.

#[path = "../examples/stability/variance/choice.rs"]
#[allow(dead_code, reason = "shared with an example")]
mod choice;
#[path = "../examples/stability/variance/images.rs"]
#[allow(dead_code, reason = "shared with an example")]
mod images;

use choice::Chosen;
use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use images::{Effort, Images, Price};
use pathspace::endpoint::{Camera, PinholeCamera, PointLight};
use pathspace::gallery;
use pathspace::geometry::Quad;
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer};
use pathspace::math::Rgb;
use pathspace::path::Roulette;
use pathspace::render::{Budget, Render, Settings};
use pathspace::scene::{Emission, Material, SceneError, World, WorldBuilder};
use std::time::Duration;

/// The incremental integrators.
fn integrators(
    max_bounces: u32,
    roulette: Roulette,
) -> [(&'static str, Box<dyn Render<World>>); 3] {
    [
        ("path-tracing", Box::new(PathTracer { roulette, ..PathTracer::up_to(max_bounces) })),
        ("light-tracing", Box::new(LightTracer { roulette, ..LightTracer::up_to(max_bounces) })),
        (
            "bidirectional",
            Box::new(Bidirectional { roulette, ..Bidirectional::up_to(max_bounces) }),
        ),
    ]
}

/// One sample per pixel.
fn pass(world: &World, camera: &dyn Camera, integrator: &dyn Render<World>, threads: usize) {
    let settings = Settings {
        budget: Budget::Samples(1),
        seed: 1,
        threads: Some(threads),
        ..Settings::default()
    };
    integrator.render(world, camera, &settings).expect("valid settings");
}

fn group<'c>(
    criterion: &'c mut Criterion,
    name: &str,
    samples: u32,
) -> BenchmarkGroup<'c, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group
        .throughput(Throughput::Elements(u64::from(samples)))
        .sample_size(10)
        .measurement_time(Duration::from_secs(2));
    group
}

/// The cube [-1, 1]³ with a ceiling of `side`² lamps.
fn room(side: u32) -> Result<(World, PinholeCamera), SceneError> {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) })?;
    for (i, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
        let (u, v) = [(DVec3::Y, DVec3::Z), (DVec3::Z, DVec3::X), (DVec3::X, DVec3::Y)][i];
        builder.add_quad(
            format!("wall {i} below"),
            Quad { origin: -axis - u - v, edge_u: u * 2.0, edge_v: v * 2.0 },
            grey,
        )?;
        builder.add_quad(
            format!("wall {i} above"),
            Quad { origin: axis - u - v, edge_u: v * 2.0, edge_v: u * 2.0 },
            grey,
        )?;
    }
    let step = 2.0 / f64::from(side);
    for i in 0..side * side {
        let origin =
            DVec3::new(f64::from(i % side) * step - 1.0, 0.99, f64::from(i / side) * step - 1.0);
        let lamp = Quad { origin, edge_u: DVec3::X * step * 0.5, edge_v: DVec3::Z * step * 0.5 };
        let id = builder.add_quad(format!("lamp {i}"), lamp, grey)?;
        builder.set_emission(id, Emission { radiance: Rgb::WHITE, two_sided: false })?;
    }
    let camera = PinholeCamera::new(
        DVec3::new(0.0, 0.2, 0.95),
        DVec3::ZERO,
        DVec3::Y,
        60.0,
        UVec2::splat(64),
    )
    .expect("a valid camera");
    Ok((builder.build()?, camera))
}

fn lights(criterion: &mut Criterion) {
    let mut group = group(criterion, "sample by lights", 64 * 64);
    for side in [1, 3, 10, 32, 100, 316] {
        let (world, camera) = room(side).expect("a valid scene");
        println!("{} lights: tree of {} bytes", side * side, world.tree_statistics().bytes);
        for (name, integrator) in integrators(4, Roulette::default()) {
            group.bench_function(format!("{name}/{}", side * side), |b| {
                b.iter(|| pass(&world, &camera, &*integrator, 1))
            });
        }
    }
    group.finish();
}

/// Point lights in `side` rows over a floor, a distance of 1 apart and as high; seen is the square of
/// side 1 in the middle of the floor.
fn lamps(side: u32) -> Result<(World, PinholeCamera), SceneError> {
    let mut builder = WorldBuilder::new();
    let grey = builder.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) })?;
    let half = 0.5 * f64::from(side) + 1.0;
    let floor = Quad {
        origin: DVec3::new(-half, -half, 0.0),
        edge_u: DVec3::X * (2.0 * half),
        edge_v: DVec3::Y * (2.0 * half),
    };
    builder.add_quad("floor", floor, grey)?;
    let middle = 0.5 * f64::from(side - 1);
    for i in 0..side * side {
        let (x, y) = (f64::from(i % side) - middle, f64::from(i / side) - middle);
        let lamp = PointLight::new(DVec3::new(x, y, 1.0), Rgb::WHITE).expect("a valid light");
        builder.add_light(format!("lamp {i}"), lamp)?;
    }
    let camera = PinholeCamera::new(DVec3::Z * 0.5, DVec3::ZERO, DVec3::Y, 90.0, UVec2::splat(16))
        .expect("a valid camera");
    Ok((builder.build()?, camera))
}

/// Resident memory in bytes, where the system tells it.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(1024.0 * line.trim().trim_end_matches(" kB").parse::<f64>().ok()?)
}

/// Variance × time of path tracing by the number of lamps: the world's own choice of lights, and a
/// choice by power, in turn. Prints a table.
fn light_choice(_: &mut Criterion) {
    const EFFORT: Effort = Effort { images: 32, samples_per_pixel: 16, price: Price::Time };
    println!("lamps: bytes each; µs per sample, relative variance × µs of a sample");
    // All are kept, since freed memory would be used again.
    let worlds = [1, 2, 3, 10, 32, 100, 316].map(|side| {
        let before = resident();
        (side, lamps(side).expect("a valid scene"), before.zip(resident()))
    });
    for (side, (world, camera), memory) in worlds {
        let lamps = f64::from(side * side);
        // Of few lamps it tells of the allocator.
        let bytes = memory
            .filter(|_| side >= 100)
            .map_or("?".to_owned(), |(before, after)| format!("{:.0}", (after - before) / lamps));
        let (by_power, path_tracer) = (Chosen::by_power(&world), PathTracer::up_to(1));
        let [mut own, mut power] = [Images::default(), Images::default()];
        for seed in 0..EFFORT.images {
            own.render(&world, &camera, &path_tracer, EFFORT, seed.into());
            power.render(&by_power, &camera, &path_tracer, EFFORT, seed.into());
        }
        let samples = f64::from(EFFORT.samples_per_pixel);
        let pixels = f64::from(camera.film().pixels());
        // Of a sample in place of an image: variance times n, time over n and the pixels.
        let [a, b] = [&own, &power].map(|images| {
            let time = 1e6 * images.price().value / (samples * pixels);
            let scale = 1e6 / pixels / images.mean().mean().powi(2);
            format!("{time:.2} µs, {:.3e}", images.inefficiency().value * scale)
        });
        let ratio = own.inefficiency().over(power.inefficiency());
        println!(
            "{lamps}: {bytes}; own {a}; by power {b}; ratio {:.2e} ± {:.0} %",
            ratio.value,
            100.0 * ratio.error
        );
    }
}

fn path_length(criterion: &mut Criterion) {
    let mut group = group(criterion, "sample by scattering events", 64 * 64);
    let (world, camera) = room(1).expect("a valid scene");
    for events in [1, 2, 4, 8, 16, 32] {
        for (name, integrator) in integrators(events, Roulette::NEVER) {
            group.bench_function(format!("{name}/{events}"), |b| {
                b.iter(|| pass(&world, &camera, &*integrator, 1))
            });
        }
    }
    group.finish();
}

fn resolution(criterion: &mut Criterion) {
    for side in [64, 256, 1024] {
        let mut group = group(criterion, "sample by resolution", side * side);
        let scene =
            gallery::build("cornell-box", UVec2::splat(side)).expect("a scene of the gallery");
        for (name, integrator) in &integrators(4, Roulette::default())[..2] {
            group.bench_function(format!("{name}/{side}"), |b| {
                b.iter(|| pass(&scene.world, &*scene.camera, &**integrator, 1))
            });
        }
        group.finish();
    }
}

fn threads(criterion: &mut Criterion) {
    let side = 256;
    let scene = gallery::build("cornell-box", UVec2::splat(side)).expect("a scene of the gallery");
    let mut group = group(criterion, "sample by threads", side * side);
    for (name, integrator) in integrators(4, Roulette::default()) {
        for threads in [1, 2] {
            group.bench_function(format!("{name}/{threads}"), |b| {
                b.iter(|| pass(&scene.world, &*scene.camera, &*integrator, threads))
            });
        }
    }
    group.finish();
}

criterion_group!(benches, light_choice, lights, path_length, resolution, threads);
criterion_main!(benches);
