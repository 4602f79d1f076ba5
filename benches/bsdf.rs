//! Cost of sampling and evaluating each scattering model, and surfaces of a world.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{DVec2, DVec3};
use pathspace::bsdf::fresnel::Reflectance;
use pathspace::bsdf::{
    Bsdf, BsdfError, Conductor, Dielectric, Ggx, Lambert, Mixture, Model, Null, RoughConductor,
    RoughDielectric, TransportMode,
};
use pathspace::geometry::{Quad, SurfacePoint};
use pathspace::material::Texture;
use pathspace::math::Rgb;
use pathspace::scene::{Material, Scene, SceneError, World, WorldBuilder};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::hint::black_box;

type Named = (&'static str, Box<dyn Bsdf>);

fn models() -> Result<Vec<Named>, BsdfError> {
    let (eta, k) = (Rgb::new(0.2, 0.4, 1.4), Rgb::new(3.9, 2.5, 1.6));
    let lambert = Lambert::new(Rgb::splat(0.5))?;
    let rough = RoughConductor::new(Reflectance::conductor(eta, k)?, Ggx::isotropic(0.3)?);
    Ok(vec![
        ("null", Box::new(Null)),
        ("lambert", Box::new(lambert)),
        ("conductor", Box::new(Conductor::new(eta, k)?)),
        ("dielectric", Box::new(Dielectric::new(1.5)?)),
        ("rough_conductor", Box::new(rough)),
        ("rough_dielectric", Box::new(RoughDielectric::new(1.5, Ggx::isotropic(0.3)?)?)),
        (
            "mixture",
            Box::new(Mixture::<Model, 2>::new([lambert.into(), rough.into()], [0.5, 0.5])?),
        ),
    ])
}

/// Scattering events with random numbers for them, the same for all models.
fn events() -> Vec<(DVec3, f64, DVec2)> {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let event = |_| {
        let (z, azimuth): (f64, f64) = (rng.random(), std::f64::consts::TAU * rng.random::<f64>());
        let radius = ((1.0 - z) * (1.0 + z)).sqrt();
        (
            DVec3::new(radius * azimuth.cos(), radius * azimuth.sin(), z),
            rng.random(),
            DVec2::new(rng.random(), rng.random()),
        )
    };
    (0..1024).map(event).collect()
}

fn bsdfs(criterion: &mut Criterion) {
    let events = events();
    for (name, model) in models().unwrap_or_default() {
        let mut group = criterion.benchmark_group(name);
        let mut cycle = events.iter().cycle();
        group.bench_function("sample", |bencher| {
            bencher.iter(|| {
                let &(fixed, u1, u2) = cycle.next()?;
                black_box(&model).sample(fixed, TransportMode::Radiance, u1, u2)
            });
        });
        let sampled = |&(fixed, u1, u2): &(DVec3, f64, DVec2)| {
            model.sample(fixed, TransportMode::Radiance, u1, u2).map(|sample| (fixed, sample.next))
        };
        let pairs: Vec<(DVec3, DVec3)> = events.iter().filter_map(sampled).collect();
        let mut cycle = pairs.iter().cycle();
        group.bench_function("eval", |bencher| {
            bencher.iter(|| cycle.next().map(|&(fixed, next)| black_box(&model).eval(next, fixed)));
        });
        group.bench_function("pdf", |bencher| {
            bencher.iter(|| {
                cycle.next().map(|&(fixed, next)| {
                    black_box(&model).pdf(fixed, next, TransportMode::Radiance)
                })
            });
        });
        group.finish();
    }
}

/// A quad of each kind of material in a world, for [`vertices`].
fn surfaces() -> Result<World, SceneError> {
    let board = || Texture::checkerboard(Rgb::splat(0.7), Rgb::splat(0.2));
    let rough = Material::RoughMirror { reflectance: Rgb::splat(0.9), alpha: DVec2::splat(0.3) };
    let lambert = |albedo| Material::Lambert { albedo: Rgb::splat(albedo) };
    let mut builder = WorldBuilder::new();
    for (k, (name, material)) in [
        ("lambert", lambert(0.5)),
        ("one-sided lambert", lambert(0.5).one_sided()),
        ("textured lambert", lambert(1.0).tinted(board()).one_sided()),
        ("one-sided rough mirror", rough.clone().one_sided()),
        ("textured rough mirror", rough.tinted(board()).one_sided()),
    ]
    .into_iter()
    .enumerate()
    {
        let material = builder.add_material(name, material)?;
        let origin = DVec3::X * (2.0 * k as f64);
        builder.add_quad(name, Quad { origin, edge_u: DVec3::X, edge_v: DVec3::Y }, material)?;
    }
    builder.build()
}

/// What a path asks at a vertex of a world: the BSDF of the point, f for a light, a new direction
/// and its density for the light's.
fn vertices(criterion: &mut Criterion) {
    let Ok(world) = surfaces() else { return };
    let (mut group, events) = (criterion.benchmark_group("vertex"), events());
    for id in 0..world.surface_count() as u32 {
        let Some(shape) = world.shape(id) else { continue };
        let point = |u2| SurfacePoint { primitive: id, surface: id, ..shape.sample_area(u2) };
        let all: Vec<_> =
            events.iter().map(|&(fixed, u1, u2)| (point(u2), fixed, u1, u2)).collect();
        let mut cycle = all.iter().zip(all.iter().skip(1)).cycle();
        let name = world.surface_name(&all[0].0).unwrap_or_default().to_owned();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let ((x, fixed, u1, u2), (_, light, ..)) = cycle.next()?;
                let bsdf = black_box(&world).bsdf(x);
                let value = bsdf.eval(*light, *fixed);
                let pdf = bsdf.pdf(*fixed, *light, TransportMode::Radiance);
                Some((value, pdf, bsdf.sample(*fixed, TransportMode::Radiance, *u1, *u2)))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, bsdfs, vertices);
criterion_main!(benches);
