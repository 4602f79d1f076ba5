//! The files of `tests/data/mitsuba`, and scenes that are written for a test.

use glam::DVec3;
use pathspace::endpoint::Endpoint;
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Error, Import, Options, mitsuba};
use pathspace::math::Rgb;
use pathspace::scene::{Scene, World};
use std::path::{Path, PathBuf};

pub const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data/mitsuba");

/// A directory that goes away with its owner, with a copy of the data's parts.
pub struct Directory(pub PathBuf);

impl Directory {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("pathspace-{}-{name}", std::process::id()));
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

    /// Loads a scene of these elements.
    pub fn load(&self, elements: &str) -> Result<Import, Error> {
        self.load_with(elements, &Options::default())
    }

    pub fn load_with(&self, elements: &str, options: &Options) -> Result<Import, Error> {
        let text = format!("<scene version=\"3.0.0\">\n{elements}\n</scene>");
        mitsuba::load(self.write("scene.xml", text), options, [])
    }

    /// The message of the error that a scene gives.
    pub fn error(&self, elements: &str) -> String {
        self.load(elements).expect_err(elements).to_string()
    }

    /// Loads a scene with an object that is left out or replaced, which a warning says; in strict
    /// mode the same is an error.
    pub fn left_out(&self, elements: &str, expected: &str) -> Import {
        let import = self.load(elements).expect(elements);
        let is_said = import.warnings.iter().any(|warning| warning.to_string().contains(expected));
        assert!(is_said, "{elements}: {:?}", import.warnings);
        let strict = self.load_with(elements, &Options { strict: true, ..Options::default() });
        let error = strict.expect_err(elements).to_string();
        assert!(error.contains(expected) && error.contains("scene.xml"), "{elements}: {error}");
        import
    }

    /// The only warning of a scene, which is an error in strict mode.
    pub fn warning(&self, elements: &str) -> String {
        let import = self.load(elements).expect(elements);
        assert_eq!(import.warnings.len(), 1, "{elements}: {:?}", import.warnings);
        let warning = import.warnings[0].to_string();
        let strict = self.load_with(elements, &Options { strict: true, ..Options::default() });
        assert_eq!(strict.expect_err(elements).to_string(), warning);
        warning
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn load(name: &str) -> Import {
    let options = Options { strict: true, ..Options::default() };
    mitsuba::load(
        Path::new(DATA).join(name),
        &options,
        [("res".to_owned(), "16".to_owned())].into_iter().take(usize::from(
            !["thinlens.xml", "orthographic.xml", "shifted.xml"].contains(&name),
        )),
    )
    .unwrap_or_else(|error| panic!("{error}"))
}

/// The radiance that a ray from above meets on a surface of the scene, as the camera of the first
/// view would see it without light from elsewhere.
pub fn emitted_below(import: &Import, x: f64, y: f64) -> Rgb {
    emitted_from(&import.world, DVec3::new(x, y, 10.0))
}

/// The same from another height.
pub fn emitted_from(world: &World, position: DVec3) -> Rgb {
    let hit = world.intersect(&SurfacePoint::dirac(position), -DVec3::Z).expect("a surface");
    world.light_at(&hit).map_or(Rgb::BLACK, |light| world.light(light).emit(&hit, DVec3::Z))
}

pub const SENSOR: &str = "<sensor type='perspective'><float name='fov' value='40'/></sensor>";
/// An emitting square of radiance 1 at z = 0, seen from above.
pub const GLOW: &str = "<emitter type='area'><rgb name='radiance' value='1'/></emitter>";
