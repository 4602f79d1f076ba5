//! An integrator of one's own beside a ready-made one: the Cornell box by path tracing, and what
//! its lamp alone does after up to three scattering events, which is not all.

#[path = "../common/mod.rs"]
mod common;
mod one_light;

use clap::Parser;
use one_light::OneLight;
use pathspace::endpoint::LightId;
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::PathTracer;
use pathspace::render::{Budget, Render, Settings};
use pathspace::scene::World;
use std::error::Error;
use std::path::PathBuf;

/// Renders the Cornell box by an integrator of this example and by path tracing.
#[derive(Parser)]
struct Options {
    /// Samples per pixel
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Largest number of scattering events of the example's integrator
    #[arg(long, default_value_t = 3)]
    max_bounces: u32,
    /// Folder for the images
    #[arg(long, default_value = "target")]
    out: PathBuf,
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let scene = gallery::build("cornell-box", UVec2::splat(256))?;
    let one_light = OneLight { light: LightId(0), max_bounces: options.max_bounces };
    let settings = Settings { budget: Budget::Samples(options.samples), ..Settings::default() };
    std::fs::create_dir_all(&options.out)?;
    let both: [&dyn Render<World>; 2] = [&one_light, &PathTracer::default()];
    for integrator in both {
        let rendering = integrator.render(&scene.world, &*scene.camera, &settings)?;
        let path = options.out.join(format!("custom_integrator-{}.png", integrator.name()));
        rendering.to_file().save(&path)?;
        println!("mean {:.4}, wrote {}", rendering.image.mean().luminance(), path.display());
    }
    Ok(())
}

fn main() {
    if let Err(error) = run(&Options::parse()) {
        eprintln!("error: {error}");
        std::process::exit(2);
    }
}
