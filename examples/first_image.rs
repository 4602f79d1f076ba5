//! The library in a few lines: a ball on the ground under a lamp, path traced, saved as PNG.
//!
//! `cargo run --release --example first_image [-- FILE.png]`

use pathspace::endpoint::PinholeCamera;
use pathspace::geometry::{Disk, Sphere};
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::PathTracer;
use pathspace::math::Rgb;
use pathspace::render::{Settings, render, unattended};
use pathspace::scene::{Emission, Material, WorldBuilder};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "target/first_image.png".to_owned());

    let mut scene = WorldBuilder::new();
    let clay = scene.add_material("clay", Material::Lambert { albedo: Rgb::new(0.7, 0.35, 0.2) })?;
    scene.add_disk("ground", Disk { center: DVec3::ZERO, normal: DVec3::Y, radius: 4.0 }, clay)?;
    scene.add_sphere("ball", Sphere::new(DVec3::Y, 1.0), clay)?;
    let lamp = scene.add_sphere("lamp", Sphere::new(DVec3::new(2.0, 4.0, 2.0), 0.5), clay)?;
    scene.set_emission(lamp, Emission { radiance: Rgb::splat(30.0), two_sided: false })?;
    let world = scene.build()?;

    let camera = PinholeCamera::new(DVec3::new(0.0, 2.0, 7.0), DVec3::Y, DVec3::Y, 40.0, UVec2::new(320, 240))?;
    let rendering = render(&world, &camera, &PathTracer::default(), &Settings::default(), &mut unattended)?;
    rendering.to_file().save(&file)?;
    println!("wrote {file}");
    Ok(())
}
