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

/// Of SEEDS images each, rendered in turn: the mean variance of a pixel times the time of its samples;
/// and the distance of the mean over all pixels from that by many photons within a small radius, which
/// is off by less than 1 %, with its standard error.
#[test]
#[ignore = "minutes"]
fn efficiency_in_the_pool() -> Result {
    let scene = gallery::build("pool", FILM)?;
    let image = |integrator: &dyn Render<World>, samples, seed| -> Result<(Vec<f64>, f64)> {
        let settings = Settings {
            budget: Budget::Samples(samples),
            seed,
            sampler: SamplerKind::Independent,
            threads: Some(1),
            ..Settings::default()
        };
        let rendering = integrator.render(&scene.world, &*scene.camera, &settings)?;
        Ok((pixels(&rendering.image).collect(), rendering.thread_time.as_secs_f64()))
    };
    let photons = |radius| PhotonMapping {
        merging: Merging { radius, ..Merging::default() },
        ..PhotonMapping::default()
    };
    let (reference, _) = image(&photons(Some(0.02)), 6000, 1)?;
    let count = reference.len() as f64;
    let level = reference.iter().sum::<f64>() / count;
    let fixed = |epsilon| Regularization::fixed(PathTracer::default(), epsilon);
    let rows: [(&str, Box<dyn Render<World>>, u32); 6] = [
        ("bidirectional", Box::new(Bidirectional::default()), 200),
        ("path", Box::new(PathTracer::default()), 300),
        ("0.1", Box::new(fixed(0.1)), 300),
        ("0.2", Box::new(fixed(0.2)), 300),
        ("0.25", Box::new(fixed(0.25)), 300),
        ("photons", Box::new(photons(None)), 50),
    ];
    let (mut images, mut times) = (vec![Vec::new(); rows.len()], vec![0.0; rows.len()]);
    for seed in 0..SEEDS {
        for (row, (_, integrator, samples)) in rows.iter().enumerate() {
            let (image, time) = image(&**integrator, *samples, seed)?;
            images[row].push(image);
            times[row] += time / SEEDS as f64;
        }
    }
    println!("method, variance x time, relative to the first, bias of the mean and its error");
    let mut first = None;
    for (((name, _, samples), images), time) in rows.iter().zip(&images).zip(times) {
        let n = images.len() as f64;
        let mean = |i: usize| images.iter().map(|image| image[i]).sum::<f64>() / n;
        let variance = |i: usize| {
            images.iter().map(|image| (image[i] - mean(i)).powi(2)).sum::<f64>() / (n - 1.0)
        };
        let noise = (0..reference.len()).map(variance).sum::<f64>() / count;
        let whole = (0..reference.len()).map(mean).sum::<f64>() / count;
        let cost = noise * time;
        let gain = *first.get_or_insert(cost) / cost;
        let bias = 100.0 * (whole / level - 1.0);
        let error = 100.0 * (noise / count / n).sqrt() / level;
        println!(
            "{name:14} {cost:10.3e} {gain:8.2} {bias:+.2} % ± {error:.2} %  ({time:.2} s for {samples})"
        );
    }
    Ok(())
}
