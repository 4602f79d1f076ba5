//! Scenes from files, one module per format: `gltf` and `mitsuba`, each behind a feature of its
//! name.
//!
//! Anything that a file asks for and the crate lacks is replaced with a [`Warning`], never
//! silently, or refused with an [`Error`] where nothing sensible is left to render; [strict
//! options](Options) make every warning an error. Files are not trusted: their size, the number of
//! items in them, and the places that they refer to are [limited](Limits).

#[cfg_attr(not(feature = "mitsuba"), allow(dead_code, reason = "one format uses all of it"))]
mod files;
#[cfg(feature = "gltf")]
pub mod gltf;
#[cfg(any(feature = "gltf", feature = "mitsuba"))]
mod images;
#[cfg(feature = "mitsuba")]
pub mod mitsuba;

use crate::endpoint::Camera;
use crate::film::Filter;
use crate::scene::World;
use std::fmt;
use std::path::PathBuf;

/// A scene from a file, ready to be rendered.
#[derive(Debug)]
#[non_exhaustive]
pub struct Import {
    /// Surfaces, materials and lights.
    pub world: World,
    /// The cameras in the file's order, with film size and crop window; at least one.
    pub views: Vec<ImportedView>,
    /// The file's settings of the rendering.
    pub hints: Hints,
    /// Warnings of everything that was left out or replaced, in the order of discovery.
    pub warnings: Vec<Warning>,
}

/// A camera of a file.
#[non_exhaustive]
pub struct ImportedView {
    /// The name in the file; "camera" and a number if it has none.
    pub name: String,
    /// The camera, with resolution and window.
    pub camera: Box<dyn Camera + Send>,
    /// The pixel filter.
    pub filter: Filter,
}

impl fmt::Debug for ImportedView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ImportedView")
            .field("name", &self.name)
            .field("film", &self.camera.film())
            .finish_non_exhaustive()
    }
}

/// Settings of the rendering that a file asks for; free to be ignored.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Hints {
    /// Largest number of scattering events; `None` if the file does not say, or asks for all.
    pub max_bounces: Option<u32>,
    /// Samples per pixel.
    pub samples_per_pixel: Option<u32>,
    /// The integrator that the file names.
    pub integrator: Option<String>,
    /// The sampler that the file names.
    pub sampler: Option<String>,
}

/// Options of reading a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Makes every warning an error.
    pub strict: bool,
    /// Limits to the size of the scene.
    pub limits: Limits,
}

/// Limits to the size of a scene; a file that asks for more is refused.
///
/// The defaults admit large scenes on a desktop computer. All of them together keep a reader below
/// about 15 GB: a triangle takes about 0.6 kB while its world is built, a pixel of an image 24
/// bytes, an element of a glTF file up to 5 kB, and files are read whole. Who reads files of
/// strangers on a smaller machine lowers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Bytes of all files together, each time one is read, also after decompression.
    pub bytes: u64,
    /// Elements of all files together, each time one is included.
    pub elements: u64,
    /// Files that include each other in a chain, and references to references.
    pub depth: u32,
    /// Triangles of all meshes together.
    pub triangles: u64,
    /// Pixels of all images together, and of a film.
    pub pixels: u64,
    /// Characters of all values together that parameters have been put into.
    pub expansion: u64,
    /// True if a file may refer to files that are not below the directory of the scene.
    pub outside_files: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            bytes: 1 << 30,
            elements: 1_000_000,
            depth: 16,
            triangles: 10_000_000,
            pixels: 1 << 27,
            expansion: 1 << 24,
            outside_files: false,
        }
    }
}

/// A place in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Location {
    /// The file.
    pub file: PathBuf,
    /// Kind of the element, "bsdf of type plastic" for instance.
    pub element: String,
    /// The id or name, if it has one.
    pub id: Option<String>,
    /// The line, if the format has lines.
    pub line: Option<u32>,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if !self.element.is_empty() {
            write!(f, ": {}", self.element)?;
        }
        self.id.as_ref().map_or(Ok(()), |id| write!(f, " \"{id}\""))
    }
}

/// Something that a file asks for and that was left out or replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Warning {
    /// The place in the file that it is about.
    pub location: Location,
    /// A sentence on what is missing, and what is done instead.
    pub reason: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.location, self.reason)
    }
}

/// The reason for which a file was refused.
#[derive(Debug)]
#[non_exhaustive]
pub struct Error {
    /// The place in the file that it is about.
    pub location: Location,
    /// A sentence on what is wrong.
    pub reason: String,
    /// The error of another part of the crate, or of another crate, that is behind it.
    pub source: Option<Box<dyn std::error::Error + Send + Sync>>,
}

impl Error {
    /// An error without another one behind it.
    pub(crate) fn new(location: Location, reason: impl Into<String>) -> Self {
        Self { location, reason: reason.into(), source: None }
    }

    /// An error of a file that asks for more than a limit admits.
    pub(crate) fn limit(location: Location, reason: impl Into<String>) -> Self {
        Self { source: Some(Box::new(LimitExceeded)), ..Self::new(location, reason) }
    }

    /// True if leaving something out is no remedy.
    #[cfg(feature = "mitsuba")]
    fn is_limit(&self) -> bool {
        self.source.as_ref().is_some_and(|source| source.is::<LimitExceeded>())
    }

    /// An error that another one has caused; its message becomes part of the reason.
    pub(crate) fn caused(
        location: Location,
        source: impl std::error::Error + Send + Sync + 'static,
    ) -> Self {
        Self { location, reason: source.to_string(), source: Some(Box::new(source)) }
    }
}

/// The source of errors of files that ask for more than a limit admits.
#[derive(Debug)]
struct LimitExceeded;

impl fmt::Display for LimitExceeded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a limit of the options is exceeded")
    }
}

impl std::error::Error for LimitExceeded {}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.location, self.reason)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.source.as_deref().map(|source| source as _)
    }
}

/// Collects warnings, or refuses the first one.
#[cfg(any(feature = "gltf", feature = "mitsuba"))]
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    strict: bool,
    list: Vec<Warning>,
}

#[cfg(any(feature = "gltf", feature = "mitsuba"))]
impl Warnings {
    /// The most that are kept: what comes after would not be read.
    const MOST: usize = 1000;

    pub fn new(strict: bool) -> Self {
        Self { strict, list: Vec::new() }
    }

    /// Warns, or fails in strict mode.
    pub fn warn(&mut self, location: Location, reason: impl Into<String>) -> Result<(), Error> {
        let reason = reason.into();
        if self.strict {
            return Err(Error::new(location, reason));
        }
        if self.list.len() < Self::MOST {
            self.list.push(Warning { location, reason });
        }
        Ok(())
    }

    /// The result, or `None` after a warning of what is taken `instead`. In strict mode, and where
    /// a limit is exceeded, it stays an error.
    #[cfg(feature = "mitsuba")]
    pub fn rescue<T>(
        &mut self,
        result: Result<T, Error>,
        instead: &str,
    ) -> Result<Option<T>, Error> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(error) if self.strict || error.is_limit() => Err(error),
            Err(error) => {
                self.warn(error.location, format!("{}; {instead}", error.reason))?;
                Ok(None)
            }
        }
    }

    pub fn into_list(self) -> Vec<Warning> {
        self.list
    }
}
