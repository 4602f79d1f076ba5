//! Photon maps: building one, and searching it for photons on a sphere and in a single cell.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, DVec3};
use pathspace::geometry::SurfacePoint;
use pathspace::math::{Rgb, warp::square_to_sphere};
use pathspace::photon_map::{Photon, PhotonMap};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::hint::black_box;

const QUERIES: usize = 200_000;

fn on_sphere(rng: &mut Pcg64Mcg) -> DVec3 {
    square_to_sphere(DVec2::new(rng.random(), rng.random()))
}

fn photon(position: DVec3, normal: DVec3) -> Photon {
    Photon { position, normal, to_previous: normal, flux: Rgb::WHITE, s: 2 }
}

/// The photons near a point: how many, and their flux.
fn gather<'a>(map: &PhotonMap, points: impl IntoIterator<Item = &'a SurfacePoint>) -> (u64, Rgb) {
    let (mut found, mut flux) = (0, Rgb::BLACK);
    for point in points {
        map.within(point, |photon| {
            found += 1;
            flux += photon.flux * photon.to_previous.z;
        });
    }
    (found, flux)
}

/// Random points of the unit sphere, as photons and as the points to search around.
fn sphere(criterion: &mut Criterion) {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let points: Vec<SurfacePoint> = (0..QUERIES)
        .map(|_| on_sphere(&mut rng))
        .map(|normal| SurfacePoint::on_surface(normal, 0.0, normal))
        .collect();
    let mut group = criterion.benchmark_group("sphere");
    group.sample_size(10);
    for count in [100_000u32, 1_000_000] {
        let photons: Vec<Photon> =
            (0..count).map(|_| on_sphere(&mut rng)).map(|normal| photon(normal, normal)).collect();
        for mean in [1.0, 10.0, 100.0] {
            // A ball of radius r around a point of the unit sphere has r²/4 of its area.
            let radius = (4.0 * mean / f64::from(count)).sqrt();
            let build = |photons| PhotonMap::build(photons, radius).expect("enough memory");
            group.throughput(Throughput::Elements(u64::from(count)));
            group.bench_function(format!("build/{count}/{mean} found"), |bencher| {
                bencher.iter_batched(|| photons.clone(), build, BatchSize::PerIteration);
            });
            let map = build(photons.clone());
            println!("{} found on average", gather(&map, &points).0 as f64 / QUERIES as f64);
            group.throughput(Throughput::Elements(QUERIES as u64));
            group.bench_function(format!("query/{count}/{mean} found"), |bencher| {
                bencher.iter(|| gather(black_box(&map), &points));
            });
        }
    }
    group.finish();
}

/// One ball that finds every photon.
fn one_cell(criterion: &mut Criterion) {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let mut group = criterion.benchmark_group("one cell");
    group.sample_size(10);
    for count in [100_000u32, 1_000_000, 10_000_000] {
        let in_cube = DVec3::new(0.5, 1.0, 1.0);
        let photons: Vec<Photon> = (0..count)
            .map(|_| photon(in_cube * DVec3::from_array(rng.random()), DVec3::Z))
            .collect();
        let map = PhotonMap::build(photons, 1.0).expect("enough memory");
        let centre = SurfacePoint::on_surface(0.5 * in_cube, 0.0, DVec3::Z);
        assert_eq!(gather(&map, [&centre]).0, u64::from(count));
        group.throughput(Throughput::Elements(u64::from(count)));
        group.bench_function(format!("query/{count}"), |bencher| {
            bencher.iter(|| gather(black_box(&map), [&centre]));
        });
    }
    group.finish();
}

criterion_group!(benches, sphere, one_cell);
criterion_main!(benches);
