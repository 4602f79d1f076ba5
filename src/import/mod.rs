//! Scenes from files, one module per format: `gltf`, `mitsuba`, `obj` and `pbrt`, each behind a
//! feature of its name.
//!
//! Anything that a file asks for and the crate lacks is replaced with a [`Warning`], never
//! silently, or refused with an [`Error`] where nothing sensible is left to render; [strict
//! options](Options) make every warning an error. Files are not trusted: their size, the number of
//! items in them, and the places that they refer to are [limited](Limits).

#[cfg(any(feature = "mitsuba", feature = "pbrt"))]
mod conductors;
mod environment;
mod files;
#[cfg(any(feature = "gltf", feature = "obj"))]
mod framing;
#[cfg(feature = "gltf")]
pub mod gltf;
#[cfg(any(feature = "gltf", feature = "mitsuba", feature = "obj", feature = "pbrt"))]
mod images;
#[cfg(feature = "mitsuba")]
pub mod mitsuba;
#[cfg(feature = "obj")]
pub mod obj;
#[cfg(feature = "pbrt")]
pub mod pbrt;
#[cfg(any(feature = "mitsuba", feature = "pbrt"))]
mod ply;
#[cfg(any(feature = "mitsuba", feature = "pbrt"))]
mod spectrum;

use crate::endpoint::Camera;
use crate::film::{FilmRegion, Filter};
use crate::math::Rgb;
use crate::scene::{Variation, World};
use glam::UVec2;
use std::collections::HashMap;
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
    /// Warnings of everything that was left out or replaced, in the order of discovery; one for
    /// all places with the same reason.
    pub warnings: Vec<Warning>,
    /// Sentences on decisions by which nothing is lost.
    pub notes: Vec<String>,
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
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Makes every warning an error.
    pub strict: bool,
    /// The environment.
    pub environment: Environment,
    /// The largest size of films, in pixels, which keep the shape that the file gives them; `None`
    /// for the size that the file gives them, in formats that have one.
    pub size: Option<UVec2>,
    /// True if surfaces of glTF that are not double-sided are shown from both sides. Otherwise
    /// their backs are [culled](crate::bsdf::Culled), as the format wants, unless they transmit
    /// light.
    pub back_faces: bool,
    /// Changes to lamps and materials.
    pub variation: Variation,
    /// Limits to the size of the scene.
    pub limits: Limits,
}

impl Options {
    /// The film, or the largest one within the size that is wished for which has the shape of it,
    /// and its window.
    fn fitted(&self, region: FilmRegion) -> FilmRegion {
        let Some(size) = self.size else { return region };
        let factor = (size.as_dvec2() / region.resolution.as_dvec2()).min_element();
        let scaled = |pixels: UVec2| (pixels.as_dvec2() * factor).round().as_uvec2();
        let resolution = scaled(region.resolution).clamp(UVec2::ONE, size);
        let window_min = scaled(region.window_min).min(resolution - 1);
        let window_max = scaled(region.window_max).clamp(window_min + 1, resolution);
        FilmRegion { resolution, window_min, window_max }
    }

    /// Refuses sizes of films without pixels or with more than the limit admits.
    fn check_size(&self, file: &std::path::Path) -> Result<(), Error> {
        let Some(size) = self.size else { return Ok(()) };
        if (1..=self.limits.pixels).contains(&(u64::from(size.x) * u64::from(size.y))) {
            return Ok(());
        }
        let reason = format!("{size} pixels must be at least 1 and at most {}", self.limits.pixels);
        Err(Error::limit(Location { file: file.to_owned(), ..Location::default() }, reason))
    }
}

/// The light that comes from everywhere around a scene.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Environment {
    /// The file's own. In a format that has none it is white, of radiance 1, unless something else
    /// lights the scene: a light that is no surface, or emission that is worth the name. The
    /// decision is a warning if the environment is white, a note otherwise.
    #[default]
    Automatic,
    /// None, not even the file's own.
    None,
    /// The same radiance (W/(m² sr)) in all directions, in place of the file's own.
    Colour(Rgb),
    /// An image of latitude and longitude, of the formats that
    /// [`ImageFile::load`](crate::film::ImageFile::load) reads, in place of the file's own.
    File(PathBuf),
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
    /// The number of places that it is about; `location` is the first of them.
    pub count: u64,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.location, self.reason)?;
        if self.count > 1 { write!(f, " (× {})", Grouped(self.count)) } else { Ok(()) }
    }
}

/// A number with spaces between thousands.
struct Grouped(u64);

impl fmt::Display for Grouped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 1000 {
            return write!(f, "{}", self.0);
        }
        write!(f, "{} {:03}", Self(self.0 / 1000), self.0 % 1000)
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

    /// An error of compressed data, which costs no more than the object that they belong to.
    #[cfg(feature = "gltf")]
    pub(crate) fn damaged(location: Location, reason: impl Into<String>) -> Self {
        Self { source: Some(Box::new(Damaged)), ..Self::new(location, reason) }
    }

    /// True if what needs these data may be left out.
    #[cfg(feature = "gltf")]
    fn is_damage(&self) -> bool {
        self.source.as_ref().is_some_and(|source| source.is::<Damaged>())
    }

    /// True if leaving something out is no remedy.
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

/// The source of errors of compressed data.
#[cfg(feature = "gltf")]
#[derive(Debug)]
struct Damaged;

#[cfg(feature = "gltf")]
impl fmt::Display for Damaged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("compressed data are damaged")
    }
}

#[cfg(feature = "gltf")]
impl std::error::Error for Damaged {}

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

/// Collects warnings, or refuses the first one; and notes.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    strict: bool,
    list: Vec<Warning>,
    /// The place of each reason in the list.
    reasons: HashMap<String, usize>,
    notes: Vec<String>,
    /// The first thing that has, or would have brought, a surface and was left out.
    lost: Option<(Location, String)>,
}

impl Warnings {
    /// The most that are kept: what comes after would not be read.
    const MOST: usize = 1000;

    pub fn new(strict: bool) -> Self {
        Self { strict, ..Self::default() }
    }

    /// Warns, or fails in strict mode.
    pub fn warn(&mut self, location: Location, reason: impl Into<String>) -> Result<(), Error> {
        self.warn_times(location, reason, 1)
    }

    /// Warns of as many places, of which the first is given.
    pub fn warn_times(
        &mut self,
        location: Location,
        reason: impl Into<String>,
        count: u64,
    ) -> Result<(), Error> {
        let reason = reason.into();
        if self.strict {
            return Err(Error::new(location, reason));
        }
        match self.reasons.get(&reason) {
            Some(index) => self.list[*index].count += count,
            None if self.list.len() < Self::MOST => {
                self.reasons.insert(reason.clone(), self.list.len());
                self.list.push(Warning { location, reason, count });
            }
            None => {}
        }
        Ok(())
    }

    /// The result, or `None` after a warning of what is taken `instead`. In strict mode, and where
    /// a limit is exceeded, it stays an error.
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

    /// Warns of a surface that is left out, or fails in strict mode.
    pub fn lose(&mut self, location: Location, reason: impl Into<String>) -> Result<(), Error> {
        let reason = reason.into();
        self.lost.get_or_insert_with(|| (location.clone(), reason.clone()));
        self.warn(location, reason)
    }

    /// [`Self::rescue`] of what brings surfaces.
    pub fn rescue_surface<T>(
        &mut self,
        result: Result<T, Error>,
        instead: &str,
    ) -> Result<Option<T>, Error> {
        if let Err(error) = &result {
            self.lost.get_or_insert_with(|| (error.location.clone(), error.reason.clone()));
        }
        self.rescue(result, instead)
    }

    /// Refuses a world without surfaces if any was left out: its image would be of nothing.
    pub fn check_surfaces(&mut self, world: &World) -> Result<(), Error> {
        match self.lost.take().filter(|_| world.bounds().is_empty()) {
            Some((at, reason)) => Err(Error::new(at, format!("{reason}; no surface is left"))),
            None => Ok(()),
        }
    }

    /// Says a decision by which nothing is lost.
    pub fn note(&mut self, sentence: impl Into<String>) {
        self.notes.push(sentence.into());
    }

    pub fn into_lists(self) -> (Vec<Warning>, Vec<String>) {
        (self.list, self.notes)
    }
}
