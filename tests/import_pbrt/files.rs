//! The files of `tests/data/pbrt`, and scenes that are written for a test.

use glam::{DVec2, DVec3};
use pathspace::endpoint::{Camera, Endpoint, LightId};
use pathspace::film::Image;
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Error, Import, Options, pbrt};
use pathspace::integrator::{Depth, PathTracer};
use pathspace::math::Rgb;
use pathspace::render::{Budget, Render, Settings};
use pathspace::scene::{Scene, World};
use std::path::{Path, PathBuf};

pub const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data/pbrt");

/// A directory that goes away with its owner, with a copy of the data's parts.
pub struct Directory(pub PathBuf);

impl Directory {
    pub fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("pathspace-pbrt-{}-{name}", std::process::id()));
        std::fs::create_dir_all(path.join("parts")).expect("a temporary directory");
        for entry in std::fs::read_dir(Path::new(DATA).join("parts")).expect("test data").flatten()
        {
            std::fs::copy(entry.path(), path.join("parts").join(entry.file_name()))
                .expect("a copy");
        }
        Self(path)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).expect("a temporary file");
        path
    }

    pub fn load_with(&self, text: &str, options: &Options) -> Result<Import, Error> {
        pbrt::load(self.write("scene.pbrt", text), options)
    }

    /// Loads a scene without warnings.
    pub fn load(&self, text: &str) -> Import {
        let strict = Options { strict: true, ..Options::default() };
        self.load_with(text, &strict).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    /// Loads a scene with an object that is left out or replaced, which a warning says; in strict
    /// mode the same is an error.
    pub fn left_out(&self, text: &str, expected: &str) -> Import {
        let import = self.load_with(text, &Options::default()).expect(text);
        let is_said = import.warnings.iter().any(|warning| warning.to_string().contains(expected));
        assert!(is_said, "{text}: {:?}", import.warnings);
        let strict = self.load_with(text, &Options { strict: true, ..Options::default() });
        let error = strict.expect_err(text).to_string();
        assert!(error.contains("scene.pbrt"), "{text}: {error}");
        import
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What a camera says that has one pixel and sees a small part of the plane z = 0 around the origin
/// from above.
pub const PROBE: &str = "Film \"rgb\" \"integer xresolution\" 1 \"integer yresolution\" 1\n\
    LookAt 0 0 5  0 0 0  0 1 0\n\
    Camera \"orthographic\" \"float screenwindow\" [-1e-4 1e-4 -1e-4 1e-4]\n\
    PixelFilter \"box\"\nWorldBegin\n";

/// A large square at z = 0 that faces up.
pub const FLOOR: &str = "Shape \"bilinearmesh\" \"point3 P\" [-9 -9 0  9 -9 0  -9 9 0  9 9 0]\n";

pub fn render(import: &Import, samples: u32) -> Image {
    let depth = Depth::up_to(import.hints.max_bounces.expect("every file has a depth"));
    let settings = Settings { budget: Budget::Samples(samples), seed: 7, ..Settings::default() };
    let path = PathTracer { depth, ..PathTracer::default() };
    let camera = &*import.views[0].camera;
    let rendering = path.render(&import.world, camera, &settings).expect("valid settings");
    assert_eq!(rendering.counters.non_finite, 0);
    rendering.image
}

/// The point that a ray from a point meets.
pub fn seen(world: &World, from: DVec3, direction: DVec3) -> SurfacePoint {
    world.intersect(&SurfacePoint::dirac(from), direction.normalize()).expect("aimed at a surface")
}

/// The radiance that is emitted towards a point from what is seen in a direction.
pub fn emitted(world: &World, from: DVec3, direction: DVec3) -> Rgb {
    let towards = direction.normalize();
    match world.intersect(&SurfacePoint::dirac(from), towards) {
        Some(hit) => {
            world.light_at(&hit).map_or(Rgb::BLACK, |light| world.light(light).emit(&hit, -towards))
        }
        None => {
            let point = SurfacePoint::infinite(DVec3::ZERO, -towards);
            let light = world.environment();
            light.map_or(Rgb::BLACK, |light| world.light(light).emit(&point, -towards))
        }
    }
}

/// What the first light, which has a position, emits in a direction.
pub fn intensity(world: &World, direction: DVec3) -> (DVec3, Rgb) {
    let light = world.light(LightId(0));
    let point = light.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
    (point.position, light.emit(&point, direction.normalize()))
}

/// The place on the film, in pixels, where a camera that is a point sees something.
pub fn raster(camera: &dyn Camera, target: DVec3) -> DVec2 {
    let point = camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
    camera.raster(&point, (target - point.position).normalize()).expect("in front of the camera")
}
