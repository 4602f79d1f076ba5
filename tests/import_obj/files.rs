//! Scenes that are written for a test.

use glam::{DVec3, UVec2};
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Error, Import, Options, obj};
use pathspace::scene::{Scene, World};
use std::path::PathBuf;

/// A directory of its own for a test's files.
pub struct Directory(PathBuf);

impl Directory {
    pub fn new(name: &str) -> Self {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("obj").join(name);
        _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("writable");
        Self(path)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().expect("below the directory")).expect("writable");
        std::fs::write(&path, bytes).expect("writable");
        path
    }

    pub fn load_with(&self, text: &str, options: &Options) -> Result<Import, Error> {
        obj::load(self.write("scene.obj", text), UVec2::new(48, 32), options)
    }

    /// Loads a scene and returns its warnings, too; if there are any, strict mode refuses the file
    /// with the first one.
    pub fn load(&self, text: &str) -> (World, Vec<String>) {
        let import = self.load_with(text, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
        let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
        let strict = self.load_with(text, &Options { strict: true, ..Options::default() });
        match (strict, warnings.first()) {
            // A warning also says what is done instead.
            (Err(error), Some(warning)) => assert!(warning.starts_with(&error.to_string())),
            (strict, warning) => assert!(strict.is_ok() && warning.is_none(), "{warning:?}"),
        }
        (import.world, warnings)
    }

    /// A scene without warnings.
    pub fn world(&self, text: &str) -> World {
        let (world, warnings) = self.load(text);
        assert!(warnings.is_empty(), "{warnings:?}");
        world
    }

    /// A unit square with texture coordinates, of a material `a` with these statements.
    pub fn square(&self, statements: &str) -> (World, Vec<String>) {
        self.write("scene.mtl", format!("newmtl a\n{statements}\n"));
        self.load(&format!("mtllib scene.mtl\n{CORNERS}usemtl a\nf 1/1 2/2 3/3 4/4\n"))
    }
}

/// The unit square in the plane of x and y.
pub const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

/// The point that a ray down the z axis meets.
pub fn below(world: &World, x: f64, y: f64) -> SurfacePoint {
    let from = SurfacePoint::dirac(DVec3::new(x, y, 10.0));
    world.intersect(&from, -DVec3::Z).expect("a surface")
}

/// An image of 8 bits per channel (red, green, blue, alpha), with rows from the top, as TGA.
pub fn tga(width: u16, pixels: &[[u8; 4]]) -> Vec<u8> {
    let height = pixels.len() as u16 / width;
    let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend([width.to_le_bytes(), height.to_le_bytes()].concat());
    // 32 bits, 8 of them alpha; the first row is the upper one.
    bytes.extend([32, 0x28]);
    pixels.iter().for_each(|[r, g, b, a]| bytes.extend([b, g, r, a]));
    bytes
}
