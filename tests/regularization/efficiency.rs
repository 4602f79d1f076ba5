//! The table of docs/numerics.md: variance and time in a pool.
//!
//! `cargo test --release -p pathspace-tests --test regularization -- --ignored --nocapture pool`

use crate::worlds::Result;
use pathspace::film::Image;
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::{Bidirectional, Merging, PathTracer, PhotonMapping, Regularization};
use pathspace::render::{Budget, Render, Settings};
use pathspace::sampler::SamplerKind;
use pathspace::scene::World;

const FILM: UVec2 = UVec2::new(48, 36);
const SEEDS: u64 = 8;

fn pixels(image: &Image) -> impl Iterator<Item = f64> {
    image.pixels().iter().map(|p| p.luminance())
}

/// Of SEEDS images each: the mean variance of a pixel times the time of its samples; and the distance
/// of the mean over all pixels from that by many photons within a small radius, which is off by less
/// than 1 %, with its standard error.
#[test]
#[ignore = "minutes"]
fn efficiency_in_the_pool() -> Result {
    let scene = gallery::build("pool", FILM)?;
    let images = |integrator: &dyn Render<World>,
                  samples: u32,
                  seeds: u64|
     -> Result<(Vec<Vec<f64>>, f64)> {
        let (mut images, mut time) = (Vec::new(), 0.0);
        for seed in 0..seeds {
            let settings = Settings {
                budget: Budget::Samples(samples),
                seed,
                sampler: SamplerKind::Independent,
                threads: Some(1),
                ..Settings::default()
            };
            let rendering = integrator.render(&scene.world, &*scene.camera, &settings)?;
            time += rendering.thread_time.as_secs_f64() / seeds as f64;
            images.push(pixels(&rendering.image).collect());
        }
        Ok((images, time))
    };
    let mean_of = |images: &[Vec<f64>]| -> Vec<f64> {
        let n = images.len() as f64;
        (0..images[0].len()).map(|i| images.iter().map(|image| image[i]).sum::<f64>() / n).collect()
    };
    let photons = |radius| PhotonMapping {
        merging: Merging { radius, ..Merging::default() },
        ..PhotonMapping::default()
    };
    let (reference, _) = images(&photons(Some(0.02)), 1500, 4)?;
    let reference = mean_of(&reference);
    let level = reference.iter().sum::<f64>() / reference.len() as f64;
    let fixed = |epsilon| Regularization::fixed(PathTracer::default(), epsilon);
    let rows: [(&str, Box<dyn Render<World>>, u32); 7] = [
        ("bidirectional", Box::new(Bidirectional::default()), 200),
        ("path", Box::new(PathTracer::default()), 300),
        ("0.1", Box::new(fixed(0.1)), 300),
        ("0.2", Box::new(fixed(0.2)), 300),
        ("0.25", Box::new(fixed(0.25)), 300),
        ("0.3", Box::new(fixed(0.3)), 300),
        ("photons", Box::new(photons(None)), 50),
    ];
    println!("method, variance x time, relative to the first, bias of the mean and its error");
    let mut first = None;
    for (name, integrator, samples) in rows {
        let (images, time) = images(&*integrator, samples, SEEDS)?;
        let (mean, n) = (mean_of(&images), images.len() as f64);
        let variance = |i: usize| {
            images.iter().map(|image| (image[i] - mean[i]).powi(2)).sum::<f64>() / (n - 1.0)
        };
        let count = mean.len() as f64;
        let noise = (0..mean.len()).map(variance).sum::<f64>() / count;
        let cost = noise * time;
        let whole = mean.iter().sum::<f64>() / count;
        let gain = *first.get_or_insert(cost) / cost;
        println!(
            "{name:14} {cost:10.3e} {gain:8.2} {:+.2} % ± {:.2} %  ({time:.2} s for {samples})",
            100.0 * (whole / level - 1.0),
            100.0 * (noise / count / n).sqrt() / level,
        );
    }
    Ok(())
}
