//! A renderer of one's own plugged in: a toy host with its own geometry, its own material and its
//! own light, rendered by three of this crate's integrators. With `--scene world` the material is
//! on a mesh of a ready-made `World`, for those who bring nothing but a BSDF.
//!
//! A host implements [`Scene`] (and [`SurfaceArea`], if it wants uniform-area sampling), [`Bsdf`]
//! for its materials and, if the ready-made lights do not suffice, [`Endpoint`] and [`Light`].
//! Integrators know nothing else about it.
//!
//! Path tracing, light tracing and bidirectional path tracing sample the same integral in different
//! ways. If their images agree, then the host's sampling, densities and values are consistent with
//! each other: comparing them is the best test of a new material or light.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;
mod host;
mod lamp;
mod material;
mod world;

use clap::{Parser, ValueEnum};
use common::{End, MANY, exit_code, interrupt_flag};
use host::ToyScene;
use pathspace::endpoint::PinholeCamera;
use pathspace::film::{Image, ImageFile};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer};
use pathspace::math::Rgb;
use pathspace::math::statistics::Estimate;
use pathspace::render::{Budget, Render, Settings};
use pathspace::scene::Scene;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

/// Whose geometry it is.
#[derive(Clone, Copy, ValueEnum)]
enum Geometry {
    /// The host's own
    Host,
    /// A ready-made world, with the host's material on a mesh
    World,
}

/// Renders a toy host's scene with three integrators and tests that their images agree.
///
/// cargo run --release --example custom_scene -- --scene world --samples 16
#[derive(Parser)]
struct Options {
    /// The scene
    #[arg(long, value_enum, default_value = "host")]
    scene: Geometry,
    /// Image file: the three images side by side (.png, .hdr or .exr)
    #[arg(long, default_value = "target/custom_scene.png", value_parser = common::parse_image_path)]
    out: PathBuf,
    /// Width and height of each image in pixels
    #[arg(long, default_value_t = 200, value_parser = common::parse_count::<u32, 1, 4096>)]
    size: u32,
    /// Samples per pixel and rendering
    #[arg(long, default_value_t = 4, value_parser = common::parse_count::<u32, 1, MANY>)]
    samples: u32,
    /// Independent renderings per integrator, from which standard errors are estimated
    #[arg(long, default_value_t = 12, value_parser = common::parse_count::<u32, 2, 1000>)]
    batches: u32,
    /// Largest number of scattering events
    #[arg(long, default_value_t = 5)]
    max_bounces: u32,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    let options: Options = common::options();
    exit_code(match options.scene {
        Geometry::Host => ToyScene::new().and_then(|scene| run(&scene, &options)),
        Geometry::World => {
            world::world().map_err(Into::into).and_then(|scene| run(&scene, &options))
        }
    })
}

/// Renders by each integrator, and tests whether they agree. An interrupt ends it with the images
/// that are done.
fn run<S: Scene>(scene: &S, options: &Options) -> Result<End, Box<dyn Error>> {
    let interrupted = interrupt_flag();
    let camera = PinholeCamera::new(
        DVec3::new(0.0, 3.0, 8.0),
        DVec3::new(0.0, 1.3, 0.0),
        DVec3::Y,
        46.0,
        UVec2::splat(options.size),
    )?;
    let depth = options.max_bounces;
    let (path, light, both) =
        (PathTracer::up_to(depth), LightTracer::up_to(depth), Bidirectional::up_to(depth));
    let integrators: [&dyn Render<S>; 3] = [&path, &light, &both];

    let mut images = Vec::new();
    let mut means: Vec<(&str, Estimate)> = Vec::new();
    'all: for (i, integrator) in integrators.into_iter().enumerate() {
        let (mut mean, mut name) = (Estimate::default(), "");
        let mut image = Image::from_fn(options.size, options.size, |_, _| Rgb::BLACK);
        for batch in 0..u64::from(options.batches) {
            if interrupted.load(Ordering::Relaxed) {
                break 'all;
            }
            // No two renderings may share random numbers, or their difference would look smaller
            // than it is.
            let seed = options.seed.wrapping_add((i as u64 * 1000 + batch) << 32);
            let settings =
                Settings { budget: Budget::Samples(options.samples), seed, ..Settings::default() };
            let rendering = integrator.render(scene, &camera, &settings)?;
            name = rendering.integrator;
            mean.push(rendering.image.mean().luminance());
            for (sum, pixel) in image.pixels_mut().iter_mut().zip(rendering.image.pixels()) {
                *sum += *pixel / f64::from(options.batches);
            }
            eprint!("\r{name}: {} of {} renderings ", batch + 1, options.batches);
        }
        say!("\r{name:<15} mean luminance {:.6} ± {:.6}", mean.mean(), mean.standard_error());
        images.push(image);
        means.push((name, mean));
    }

    let mut agree = true;
    for (i, (name, a)) in means.iter().enumerate() {
        for (other, b) in &means[i + 1..] {
            let z = (a.mean() - b.mean()) / a.standard_error().hypot(b.standard_error());
            say!("{name} - {other}: {z:+.2} standard errors");
            agree &= z.abs() < 4.0;
        }
    }
    say!("{}", if agree { "the integrators agree" } else { "THE INTEGRATORS DISAGREE" });

    let side_by_side = Image::from_fn(3 * options.size, options.size, |x, y| {
        let image = images.get((x / options.size) as usize);
        image.and_then(|image| image.get(x % options.size, y)).unwrap_or(Rgb::BLACK)
    });
    if let Some(directory) = options.out.parent() {
        std::fs::create_dir_all(directory)
            .map_err(|error| format!("directory {}: {error}", directory.display()))?;
    }
    ImageFile::from(side_by_side).save(&options.out)?;
    say!("wrote {}", options.out.display());
    Ok(match agree {
        _ if images.len() < integrators.len() => End::Interrupted,
        true => End::Done,
        false => End::Wrong,
    })
}
