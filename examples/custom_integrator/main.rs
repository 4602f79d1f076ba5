//! An integrator of one's own beside a ready-made one: the Cornell box by path tracing, and what
//! its lamp alone does after up to three scattering events, which is not all.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;
mod one_light;

use clap::Parser;
use common::{End, MANY, exit_code, interrupt_flag};
use one_light::OneLight;
use pathspace::endpoint::LightId;
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::PathTracer;
use pathspace::render::{Budget, Progress, Render, Settings};
use pathspace::scene::World;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

/// Renders the Cornell box by an integrator of this example and by path tracing.
///
/// cargo run --release --example custom_integrator -- --samples 256 --out target
#[derive(Parser)]
struct Options {
    /// Samples per pixel
    #[arg(long, default_value_t = 64, value_parser = common::parse_count::<u32, 1, MANY>)]
    samples: u32,
    /// Largest number of scattering events of the example's integrator
    #[arg(long, default_value_t = 3)]
    max_bounces: u32,
    /// Folder for the images
    #[arg(long, default_value = "target")]
    out: PathBuf,
}

fn run(options: &Options) -> Result<End, Box<dyn Error>> {
    let interrupted = interrupt_flag();
    let scene = gallery::build("cornell-box", UVec2::splat(256))?;
    let one_light = OneLight { light: LightId(0), max_bounces: options.max_bounces };
    let settings = Settings { budget: Budget::Samples(options.samples), ..Settings::default() };
    std::fs::create_dir_all(&options.out)
        .map_err(|error| format!("directory {}: {error}", options.out.display()))?;
    let both: [&dyn Render<World>; 2] = [&one_light, &PathTracer::default()];
    for integrator in both {
        let mut go_on = |_: &Progress<'_>| match interrupted.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let rendering =
            integrator.render_with_progress(&scene.world, &*scene.camera, &settings, &mut go_on)?;
        let path = options.out.join(format!("custom_integrator-{}.png", integrator.name()));
        rendering.to_file().save(&path)?;
        say!("mean {:.4}, wrote {}", rendering.image.mean().luminance(), path.display());
        if rendering.stopped {
            return Ok(End::Interrupted);
        }
    }
    Ok(End::Done)
}

fn main() -> ExitCode {
    exit_code(run(&common::options()))
}
