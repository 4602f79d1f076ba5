//! The ray kernel alone: closest and any hit, coherent and incoherent rays, on a ball of 327 680
//! triangles; and how the cost of a ray grows with the number of triangles.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pathspace::geometry::SurfacePoint;
use pathspace::glam::{DAffine3, DVec2, DVec3};
use pathspace::math::warp::square_to_sphere;
use pathspace::scene::{Material, Mesh, Scene, SceneError, SurfaceArea, World, WorldBuilder};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::hint::black_box;
use std::time::Duration;

const RAYS: usize = 16_384;

/// A ball of 20 · 4^level triangles.
fn world(level: u32) -> Result<World, SceneError> {
    let mut builder = WorldBuilder::new();
    let black = builder.add_material("black", Material::Black)?;
    builder.add_mesh("ball", &Mesh::icosphere(level), DAffine3::IDENTITY, black)?;
    builder.build()
}

/// A camera at (0, 0, 3) whose picture the ball fills, in scanlines.
fn coherent() -> Vec<(SurfacePoint, DVec3)> {
    let eye = SurfacePoint::dirac(DVec3::Z * 3.0);
    let side = (RAYS as f64).sqrt() as usize;
    let pixel = |i: usize| (i as f64 + 0.5) / side as f64 * 0.5 - 0.25;
    (0..RAYS)
        .map(|i| (eye, DVec3::new(pixel(i % side), pixel(i / side), -1.0).normalize()))
        .collect()
}

/// Rays from points of the surface to the inside, as after the first bounce.
fn incoherent(world: &World) -> Vec<(SurfacePoint, DVec3)> {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut pair = || DVec2::new(rng.random(), rng.random());
    let mut ray = || {
        let x = world.sample_surface(pair().x, pair());
        let d = square_to_sphere(pair());
        (x, if d.dot(x.geometric_normal) > 0.0 { -d } else { d })
    };
    (0..RAYS).map(|_| ray()).collect()
}

fn rays(criterion: &mut Criterion) {
    let world = world(7).expect("a valid scene");
    let mut group = criterion.benchmark_group("rays");
    group
        .throughput(Throughput::Elements(RAYS as u64))
        .sample_size(20)
        .measurement_time(Duration::from_secs(4));
    for (name, rays) in [("coherent", coherent()), ("incoherent", incoherent(&world))] {
        group.bench_function(format!("closest/{name}"), |b| {
            b.iter(|| {
                for (x, d) in &rays {
                    black_box(world.intersect(x, *d));
                }
            });
        });
        // Segments that end half way to what the rays hit (free) or beyond it (blocked), in turn.
        let ends: Vec<SurfacePoint> = rays
            .iter()
            .enumerate()
            .map(|(i, (x, d))| {
                let distance =
                    world.intersect(x, *d).map_or(1.0, |y| y.position.distance(x.position));
                SurfacePoint::dirac(x.position + *d * distance * if i % 2 == 0 { 0.5 } else { 1.5 })
            })
            .collect();
        group.bench_function(format!("any/{name}"), |b| {
            b.iter(|| {
                for ((x, _), y) in rays.iter().zip(&ends) {
                    black_box(world.visible(x, y));
                }
            });
        });
    }
    group.finish();
}

fn triangles(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("rays by triangles");
    group
        .throughput(Throughput::Elements(RAYS as u64))
        .sample_size(10)
        .measurement_time(Duration::from_secs(1));
    for level in [1, 3, 5, 7, 9] {
        let world = world(level).expect("a valid scene");
        let tree = world.tree_statistics();
        println!(
            "{} triangles: {} bytes, built in {:.3} s",
            world.primitive_count(),
            tree.bytes,
            tree.build_time.as_secs_f64()
        );
        let rays = incoherent(&world);
        group.bench_function(format!("closest/{}", world.primitive_count()), |b| {
            b.iter(|| {
                rays.iter().for_each(|(x, d)| {
                    black_box(world.intersect(x, *d));
                })
            });
        });
    }
    group.finish();
}

criterion_group!(benches, rays, triangles);
criterion_main!(benches);
