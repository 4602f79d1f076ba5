//! The files of `tests/data/gltf`, which its `make.py` wrote, as they are and with parts replaced.

use glam::{DVec3, UVec2};
use pathspace::endpoint::Camera;
use pathspace::film::Image;
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Error, Import, Options, gltf};
use pathspace::render::{Budget, Render, Settings};
use pathspace::scene::{Scene, World};
use std::path::{Path, PathBuf};

pub const SQUARE: UVec2 = UVec2::splat(16);

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/gltf").join(name)
}

pub fn load(name: &str, resolution: UVec2) -> Import {
    gltf::load(data(name), resolution, &Options { strict: true, ..Options::default() })
        .unwrap_or_else(|error| panic!("{error}"))
}

pub fn render(
    world: &World,
    camera: &dyn Camera,
    integrator: &dyn Render<World>,
    samples: u32,
) -> Image {
    let settings = Settings { budget: Budget::Samples(samples), seed: 7, ..Settings::default() };
    let rendering = integrator.render(world, camera, &settings).expect("valid settings");
    assert_eq!(rendering.counters.non_finite, 0);
    rendering.image
}

/// The point that a ray from a point meets.
pub fn seen(world: &World, from: DVec3, direction: DVec3) -> SurfacePoint {
    world.intersect(&SurfacePoint::dirac(from), direction.normalize()).expect("aimed at a surface")
}

/// A directory of its own for a test's files.
pub fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gltf").join(name);
    std::fs::create_dir_all(&path).expect("writable");
    path
}

pub fn load_bytes(name: &str, bytes: &[u8], options: &Options) -> Result<Import, Error> {
    let path = directory(name).join("scene.gltf");
    std::fs::write(&path, bytes).expect("writable");
    gltf::load(path, SQUARE, options)
}

pub fn load_text(name: &str, text: &str, options: &Options) -> Result<Import, Error> {
    load_bytes(name, text.as_bytes(), options)
}

/// The box with a part replaced, given as a path of keys.
pub fn altered(file: &str, pointer: &str, value: serde_json::Value) -> String {
    let source = std::fs::read_to_string(data(file)).expect("readable");
    let mut document: serde_json::Value = serde_json::from_str(&source).expect("valid");
    let (parent, key) = pointer.rsplit_once('/').expect("a path");
    let parent = document.pointer_mut(parent).unwrap_or_else(|| panic!("no {parent}"));
    match parent {
        serde_json::Value::Array(list) => list[key.parse::<usize>().expect("an index")] = value,
        _ => parent[key] = value,
    }
    document.to_string()
}

/// The number as a file in single precision holds it.
pub fn single(x: f64) -> f64 {
    f64::from(x as f32)
}
