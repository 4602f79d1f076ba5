//! Sums on the film, and their order.

use crate::measure::{Method, Probe};
use crate::scenes::{Stage, camera, furnace_box, furnace_sphere, lambert};
use pathspace::endpoint::{PinholeCamera, PointLight};
use pathspace::film::{ChunkFilm, Contribution, Film, FilmRegion, Filter, Sink, Technique};
use pathspace::geometry::Sphere;
use pathspace::glam::{DVec2, DVec3, UVec2};
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer};
use pathspace::math::Rgb;
use pathspace::math::statistics::Estimate;
use pathspace::path::Roulette;
use pathspace::render::{Budget, Render, Rendering, Settings};
use pathspace::scene::{Material, World};
use std::time::Instant;

fn render(
    world: &World,
    eye: &PinholeCamera,
    integrator: &dyn Render<World>,
    settings: &Settings,
) -> Rendering {
    integrator.render(world, eye, settings).expect("renders")
}

/// Under a wide filter the pixels at the border of a constant image are as bright as those inside.
#[test]
fn stress_s33_filters_at_the_border() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &Material::Black, 1.0);
    let eye =
        PinholeCamera::new(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, UVec2::splat(6)).expect("valid");
    let is_border = |i: usize| [i % 6, i / 6].iter().any(|&c| c == 0 || c == 5);
    let integrators: [&dyn Render<World>; 3] =
        [&PathTracer::up_to(0), &LightTracer::up_to(0), &Bidirectional::up_to(0)];
    for filter in [Filter::Tent, Filter::Gaussian { standard_deviation: 1.5 }] {
        for integrator in integrators {
            let mut means = [Estimate::default(); 2];
            for seed in 0..24 {
                let settings =
                    Settings { budget: Budget::Samples(1500), seed, filter, ..Settings::default() };
                let image = render(&world, &eye, integrator, &settings).image;
                for (border, mean) in [true, false].into_iter().zip(&mut means) {
                    let pixels: Vec<f64> = image
                        .pixels()
                        .iter()
                        .enumerate()
                        .filter(|(i, _)| is_border(*i) == border)
                        .map(|(_, p)| p.g())
                        .collect();
                    mean.push(pixels.iter().sum::<f64>() / pixels.len() as f64);
                }
            }
            for mean in means {
                let error = mean.standard_error();
                assert!(
                    (mean.mean() - 1.0).abs() <= 4.0 * error + 1e-12 && error <= 0.0075,
                    "{filter:?}: {means:?}"
                );
            }
        }
    }
}

/// Values that are infinite or not a number are counted by technique, and add nothing.
#[test]
fn stress_s39_contributions_that_are_not_finite() {
    let region = FilmRegion::full(UVec2::ONE);
    let (mut film, mut chunk) = (Film::new(region).expect("a film"), ChunkFilm::new(region));
    let bad =
        [(f64::NAN, 1.0), (f64::INFINITY, 1.0), (f64::INFINITY, 0.0), (1.0, f64::NAN), (1.0, 1.0)];
    for (i, (value, weight)) in bad.into_iter().enumerate() {
        chunk.begin_samples(0..1, i as u32);
        let technique = Technique::new(i as u16 / 2, 2);
        chunk.add(
            0,
            &Contribution {
                raster: DVec2::splat(0.5),
                value: Rgb::splat(value),
                weight,
                technique,
            },
        );
    }
    chunk.finish();
    film.add(&chunk);
    let counts: Vec<u64> =
        film.non_finite().by_technique().iter().map(|(_, count)| *count).collect();
    assert_eq!((film.non_finite().count(), counts), (4, vec![2, 2]));
    assert_eq!(film.non_finite().first().map(|first| first.pass), Some(0));
    assert!(film.sums().eq([Rgb::WHITE]));
}

/// Bitwise the same image from any number of threads. More of it in determinism.rs.
#[test]
fn stress_s50_number_of_threads() {
    let world = furnace_box(DVec3::ZERO, 1.0, &lambert(0.5), 1.0);
    let eye = PinholeCamera::new(DVec3::splat(0.5), DVec3::X, DVec3::Z, 60.0, UVec2::splat(32))
        .expect("valid");
    let integrators: [&dyn Render<World>; 3] =
        [&PathTracer::default(), &LightTracer::default(), &Bidirectional::default()];
    for integrator in integrators {
        let image = |threads| {
            let settings = Settings {
                budget: Budget::Samples(4),
                threads: Some(threads),
                ..Settings::default()
            };
            let pixels = render(&world, &eye, integrator, &settings).image;
            pixels.pixels().iter().flat_map(|p| p.0.map(f64::to_bits)).collect::<Vec<u64>>()
        };
        let alone = image(1);
        for threads in [2, 7, 64] {
            assert_eq!(image(threads), alone, "{threads} threads");
        }
    }
}

/// No firefly: the pixels of a smoothly lit wall are alike.
#[test]
fn stress_s35_no_fireflies_from_a_point_light() {
    let mut stage = Stage::default();
    stage.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, lambert(0.9));
    stage.light(PointLight::new(DVec3::ZERO, Rgb::WHITE).expect("valid"));
    let world = stage.build();
    let eye = PinholeCamera::new(
        DVec3::new(0.1, 0.0, 0.3),
        DVec3::NEG_Z,
        DVec3::Y,
        60.0,
        UVec2::splat(24),
    )
    .expect("valid");
    let settings = Settings { budget: Budget::Samples(64), seed: 5, ..Settings::default() };
    let integrator = Bidirectional {
        roulette: Roulette { start: 10, ..Roulette::default() },
        ..Bidirectional::default()
    };
    let rendering = render(&world, &eye, &integrator, &settings);
    let (mean, largest) = (
        rendering.image.mean().g(),
        rendering.image.pixels().iter().map(|p| p.g()).fold(0.0, f64::max),
    );
    assert!(rendering.counters.non_finite == 0 && largest / mean < 3.0, "{largest} of {mean}");
}

/// 2²⁶ equal contributions, at which a sum in f32 stands still.
#[test]
fn stress_s45_film_of_many_samples() {
    let region = FilmRegion::full(UVec2::ONE);
    let mut film = Film::new(region).expect("a film");
    let mut chunk = ChunkFilm::new(region);
    let one = Contribution {
        raster: DVec2::splat(0.5),
        value: Rgb::WHITE,
        weight: 1.0,
        technique: Technique::new(0, 2),
    };
    for pass in 0..64 {
        chunk.clear();
        for i in 0..1 << 20 {
            chunk.begin_samples(0..1, pass << 20 | i);
            chunk.add(0, &one);
        }
        chunk.finish();
        film.add(&chunk);
    }
    assert!(film.sums().eq([Rgb::splat((1u64 << 26) as f64)]));
    assert_eq!(film.image(1 << 26).mean(), Rgb::WHITE);
}

/// An image of denormal values costs less than twice as much as at radiance 1 (a third more was
/// measured), and it is the same.
#[test]
fn stress_s51_denormals() {
    let eye = camera(DVec3::splat(0.5), DVec3::X, 60.0);
    let worlds =
        [1.0, 1e-306].map(|radiance| furnace_box(DVec3::ZERO, 1.0, &lambert(0.5), radiance));
    let (mut times, mut means) = ([f64::INFINITY; 2], [0.0; 2]);
    // The least of several, in turn: other work on the machine only ever adds.
    for round in 0..30 {
        for (i, world) in worlds.iter().enumerate() {
            let probe =
                Probe { roulette: Roulette::NEVER, ..Probe::new(world, &eye, Depth::up_to(20)) };
            let start = Instant::now();
            means[i] = probe.sample(Method::Path, 2000, 6).channels[0].mean();
            times[i] = times[i].min(start.elapsed().as_secs_f64());
        }
        if round >= 4 && times[1] < 1.1 * times[0] {
            break;
        }
    }
    let ratio = times[1] / times[0];
    println!("time ratio {ratio:.3}");
    assert!(ratio < 2.0, "{times:?}");
    assert!((means[1] / 1e-306 / means[0] - 1.0).abs() < 1e-9, "{means:?}");
}
