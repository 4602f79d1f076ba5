//! The library in a few lines: a ball on the ground under a lamp, path traced.

#[macro_use]
mod common;

use clap::Parser;
use common::End;
use pathspace::endpoint::PinholeCamera;
use pathspace::geometry::Sphere;
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::PathTracer;
use pathspace::math::Rgb;
use pathspace::render::{Settings, render};
use pathspace::scene::{Emission, Material, WorldBuilder};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn first_image(path: &Path) -> Result<(), Box<dyn Error>> {
    let mut scene = WorldBuilder::new();
    let clay =
        scene.add_material("clay", Material::Lambert { albedo: Rgb::new(0.7, 0.35, 0.2) })?;
    scene.add_sphere("ground", Sphere::new(DVec3::new(0.0, -1000.0, 0.0), 1000.0), clay)?;
    scene.add_sphere("ball", Sphere::new(DVec3::Y, 1.0), clay)?;
    let lamp = scene.add_sphere("lamp", Sphere::new(DVec3::new(2.0, 4.0, 2.0), 0.5), clay)?;
    scene.set_emission(lamp, Emission { radiance: Rgb::splat(30.0), two_sided: false })?;
    let world = scene.build()?;

    let camera = PinholeCamera::new(
        DVec3::new(0.0, 2.0, 7.0),
        DVec3::Y,
        DVec3::Y,
        40.0,
        UVec2::new(320, 240),
    )?;
    let (integrator, settings) = (PathTracer::default(), Settings::default());
    let rendering = render(&world, &camera, &integrator, &settings)?;
    rendering.to_file().save(path)?;
    Ok(())
}

/// Renders a ball on the ground under a lamp by path tracing.
///
/// cargo run --release --example first_image -- --out target/first.png
#[derive(Parser)]
struct Options {
    /// Image file (.png, .hdr or .exr)
    #[arg(long, default_value = "target/first_image.png", value_parser = common::parse_image_path)]
    out: PathBuf,
}

fn save(options: &Options) -> Result<End, Box<dyn Error>> {
    if let Some(directory) = options.out.parent() {
        std::fs::create_dir_all(directory)
            .map_err(|error| format!("directory {}: {error}", directory.display()))?;
    }
    first_image(&options.out)?;
    say!("wrote {}", options.out.display());
    Ok(End::Done)
}

fn main() -> ExitCode {
    common::exit_code(save(&common::options()))
}
