//! Scenes in the format Wavefront OBJ, with their material libraries (MTL).
//!
//! ```no_run
//! use glam::UVec2;
//! use pathspace::import::{Options, obj};
//!
//! let import = obj::load("model.obj", UVec2::new(640, 480), &Options::default())?;
//! # Ok::<(), pathspace::import::Error>(())
//! ```
//!
//! # What is read
//!
//! | statements | what becomes of them |
//! |---|---|
//! | `v`, `vt`, `vn`, `f` | triangles; polygons are divided, also those that bend inwards |
//! | `s` | faces without normals are smooth where faces of their smoothing group meet, else flat |
//! | `o`, `g`, `usemtl` | a surface for each group and material |
//! | `mtllib`, `newmtl` | one library or several, in the directory of the scene or below |
//! | `Kd`, `map_Kd` | diffuse reflectance; 0.6 if neither is given |
//! | `Ks`, `Ns`, `map_Ks`, `map_Ns` | a glossy lobe, see below |
//! | `Pr`, `Pm`, `map_Pr`, `map_Pm` | [metallic-roughness](crate::bsdf::MetallicRoughness) |
//! | `Ke`, `map_Ke` | radiance, on both sides, since files do not agree about the order of vertices |
//! | `d`, `Tr`, `map_d` | opacity: a blend with nothing; `Tr` is 1 - d |
//! | `Ni`, `illum` | index of refraction; what is diffuse, glossy, a mirror or glass |
//! | `norm`, `bump`, `map_Bump` | normal map; heights in the scene's unit of length, or, if the image has colours, a normal map, with a warning |
//! | `-o`, `-s`, `-clamp`, `-imfchan`, `-bm` | options of maps |
//!
//! `Ka` and `map_Ka` are ignored, since light transport computes what they stand for. Everything
//! else, such as lines, curves, colours of vertices and faces whose vertices are not
//! there, is left out with a warning; in strict mode it is an error.
//!
//! Images are PNG, JPEG, TGA, BMP, Radiance HDR or OpenEXR, and factors are multiplied with them.
//! Colours of 8 and 16 bits are in the transfer function of sRGB, numbers are linear: the luminance
//! unless `-imfchan` says otherwise, and for `map_d` the alpha channel if there is one.
//!
//! # Materials
//!
//! - With an illumination model of 0 or 1, or with a black `Ks`, a surface is diffuse.
//! - Otherwise `Ks` is the reflectance of a lobe of GGX, the same at all angles, of roughness
//!   α = √(2/(Ns + 2)), beside the diffuse part. Where `Kd + Ks` is more than 1 in a channel, both
//!   are divided by their largest sum, with a warning. In models 3, 5 and 8, which trace
//!   reflections, it is a mirror if there is no `Ns` or one of at least 1000.
//! - With `Pr` or `Pm`, `Kd` is the base colour; `Ks` is left out. Roughness follows from `Ns` if
//!   only metalness is given, and is 0.5 without either.
//! - Models 6 and 7 are glass of the index `Ni` (1.5 if not given), frosted if `Pr` is; opacity
//!   means nothing to them. Models 4 and 9 are as 3 and 2: they do not refract, so that only `d`
//!   lets light pass.
//!
//! # Camera and light
//!
//! The format has neither cameras nor lights. The camera sees the whole scene from the front, which
//! is +z. If no material emits, or too little, light comes from
//! [the environment](super::Options::environment).

mod geometry;
mod library;
mod material;
mod polygon;
mod statements;

#[cfg(feature = "mitsuba")]
pub(crate) use geometry::Geometry;

use super::files::Files;
use super::framing::framing;
use super::{Environment, Error, Hints, Import, ImportedView, Limits, Location, Options, Warnings};
use crate::film::Filter;
use crate::math::Rgb;
use crate::scene::{MaterialId, Mesh, WorldBuilder};
use geometry::Part;
use glam::{DAffine3, DVec2, UVec2};
use library::Description;
use material::{Bitmaps, Look};
use statements::Faults;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Reads a scene. The film of its camera has the given resolution.
///
/// # Errors
/// If the file cannot be read, has no face that can be shown, or asks for more than the limits
/// admit; in strict mode also for everything that would be a warning.
pub fn load(path: impl AsRef<Path>, resolution: UVec2, options: &Options) -> Result<Import, Error> {
    let (path, limits) = (path.as_ref(), &options.limits);
    let whole = Location { file: path.to_owned(), ..Location::default() };
    let pixels = u64::from(resolution.x) * u64::from(resolution.y);
    if pixels == 0 || pixels > limits.pixels {
        let UVec2 { x, y } = resolution;
        let reason = format!("{x} × {y} pixels must be at least 1 and at most {}", limits.pixels);
        return Err(Error::new(whole, reason));
    }
    let mut files = Files::new(path, limits)?;
    let bytes = files.read_path(path, whole.clone())?;
    let geometry = geometry::Geometry::read(&bytes, limits.triangles, limits);
    let mut geometry = geometry.map_err(|reason| Error::limit(whole.clone(), reason))?;
    drop(bytes);
    let mut loader = Loader {
        path: path.to_owned(),
        files,
        warnings: Warnings::new(options.strict),
        builder: WorldBuilder::varied(options.variation),
        descriptions: HashMap::new(),
        materials: HashMap::new(),
        names: HashSet::new(),
        bitmaps: Bitmaps::default(),
        pixels_left: limits.pixels,
        environment: options.environment.clone(),
    };
    std::mem::take(&mut geometry.faults).warn(path, &mut loader.warnings)?;
    let mut known = HashSet::new();
    for (names, line) in &geometry.libraries {
        // Many files name their library again and again.
        if known.insert(names) {
            loader.libraries(names, *line, limits)?;
        }
    }
    geometry.shade();
    for (part, mesh, bare) in geometry.meshes() {
        loader.surface(part, mesh, bare)?;
    }
    loader.finish(resolution)
}

/// A scene that is being put together.
struct Loader {
    path: PathBuf,
    files: Files,
    warnings: Warnings,
    builder: WorldBuilder,
    descriptions: HashMap<String, Description>,
    /// Materials by name.
    materials: HashMap<Option<String>, (MaterialId, Look)>,
    /// Names of surfaces.
    names: HashSet<String>,
    bitmaps: Bitmaps,
    pixels_left: u64,
    environment: Environment,
}

impl Loader {
    fn location(&self, line: Option<u32>) -> Location {
        Location { file: self.path.clone(), line, ..Location::default() }
    }

    /// Reads the libraries of a statement: one whose name may have spaces, or several.
    fn libraries(&mut self, names: &str, line: u32, limits: &Limits) -> Result<(), Error> {
        let location = self.location(Some(line));
        let whole = self.fetch(Path::new(""), names, &location);
        if whole.is_ok() || names.split_whitespace().count() < 2 {
            return self.library(whole, names, limits);
        }
        for name in names.split_whitespace() {
            let read = self.fetch(Path::new(""), name, &location);
            self.library(read, name, limits)?;
        }
        Ok(())
    }

    fn library(
        &mut self,
        read: Result<(PathBuf, Vec<u8>), Error>,
        name: &str,
        limits: &Limits,
    ) -> Result<(), Error> {
        let read = self.warnings.rescue(read, "its materials are grey")?;
        let Some((path, bytes)) = read else { return Ok(()) };
        let left = limits.elements.saturating_sub(self.descriptions.len() as u64);
        let mut faults = Faults::default();
        let directory = Path::new(&name.replace('\\', "/")).parent().map(Path::to_owned);
        let descriptions = library::read(&bytes, &path, left, &mut faults).map_err(|reason| {
            Error::limit(Location { file: path.clone(), ..Location::default() }, reason)
        })?;
        faults.warn(&path, &mut self.warnings)?;
        for mut description in descriptions {
            description.directory = directory.clone().unwrap_or_default();
            // The first of a name counts.
            self.descriptions.entry(description.name.clone()).or_insert(description);
        }
        Ok(())
    }

    /// Reads a file that is looked for in a directory of the scene, and then in that of the scene
    /// itself. Names may be those of Windows.
    fn fetch(
        &mut self,
        directory: &Path,
        name: &str,
        location: &Location,
    ) -> Result<(PathBuf, Vec<u8>), Error> {
        let name = name.replace('\\', "/");
        if directory.as_os_str().is_empty() {
            return self.files.read(&name, location.clone());
        }
        let beside = directory.join(&name);
        let read = self.files.read(&beside.to_string_lossy(), location.clone());
        match read {
            Err(error) if !error.is_limit() => self.files.read(&name, location.clone()),
            read => read,
        }
    }

    /// Adds a part of the file.
    fn surface(&mut self, part: &Part, mut mesh: Mesh, bare: usize) -> Result<(), Error> {
        let location = Location {
            element: "group".to_owned(),
            id: part.name.clone(),
            ..self.location(Some(part.line))
        };
        let (id, look) = self.material(part.material.as_ref(), &location)?;
        if look.is_textured && bare > 0 {
            let reason = format!("{bare} of its vertices lack texture coordinates: they are 0");
            self.warnings.warn(location.clone(), reason)?;
            mesh.uvs.get_or_insert_with(|| vec![DVec2::ZERO; mesh.positions.len()]);
        }
        // Images have v downwards.
        mesh.uvs.iter_mut().flatten().for_each(|uv| uv.y = 1.0 - uv.y);
        let caused = |error| Error::caused(location.clone(), error);
        let name = self.unique_name(part);
        let added = self.builder.add_mesh(name, &mesh, DAffine3::IDENTITY, id);
        let Some(surface) = self.warnings.rescue(added.map_err(caused), "it is left out")? else {
            return Ok(());
        };
        if let Some(relief) = look.relief {
            self.builder.set_relief(surface, relief).map_err(caused)?;
        }
        if let Some(radiance) = look.emission {
            let emits = self.builder.set_textured_emission(surface, radiance, true);
            self.warnings.rescue(emits.map_err(caused), "it emits nothing")?;
        }
        Ok(())
    }

    /// The material of a name, or the one of faces that name none.
    fn material(
        &mut self,
        name: Option<&String>,
        location: &Location,
    ) -> Result<(MaterialId, Look), Error> {
        let key = name.cloned();
        if let Some(known) = self.materials.get(&key) {
            return Ok(known.clone());
        }
        let look = match name.and_then(|name| self.descriptions.get(name)).cloned() {
            Some(description) => {
                let look = self.look(&description);
                self.warnings.rescue(look, "it is grey")?
            }
            None => {
                if let Some(name) = name {
                    let reason = format!("there is no material {name}: it is grey");
                    self.warnings.warn(location.clone(), reason)?;
                }
                None
            }
        };
        let mut look = look.unwrap_or_else(Look::plain);
        let title = name.map_or("without material".to_owned(), |name| format!("material {name}"));
        let mut added = self.builder.add_material(title.clone(), look.material.clone());
        if let Err(error) = &added {
            let reason = format!("{error}; it is grey");
            self.warnings.warn(location.clone(), reason)?;
            look.material = Look::plain().material;
            added = self.builder.add_material(title, look.material.clone());
        }
        let id = added.map_err(|error| Error::caused(location.clone(), error))?;
        Ok(self.materials.entry(key).or_insert((id, look)).clone())
    }

    /// The name of the group, or one that no other surface has.
    fn unique_name(&mut self, part: &Part) -> String {
        let base = part.name.as_ref().or(part.material.as_ref());
        let base = base.map_or_else(|| format!("faces from line {}", part.line), Clone::clone);
        let mut name = base.clone();
        while !self.names.insert(name.clone()) {
            name = format!("{base} (line {}, {})", part.line, self.names.len());
        }
        name
    }

    fn finish(mut self, resolution: UVec2) -> Result<Import, Error> {
        let whole = self.location(None);
        let caused = |error: &dyn std::error::Error| Error::new(whole.clone(), error.to_string());
        let mut name = "environment".to_owned();
        while self.names.contains(&name) {
            name.push('_');
        }
        if self.environment == Environment::Automatic && !self.builder.has_emission() {
            // No file of this format could say something else.
            self.warnings.note("nothing emits: it is shown in a white environment");
            self.environment = Environment::Colour(Rgb::WHITE);
        }
        let warnings = &mut self.warnings;
        let (world, why_white) = self.environment.surround(self.builder, name, &whole, warnings)?;
        // The format has no lights, so that nothing is missing.
        why_white.into_iter().for_each(|sentence| warnings.note(sentence));
        if world.bounds().is_empty() {
            return Err(Error::new(whole, "it has no face that can be shown"));
        }
        let camera = framing(world.bounds(), resolution).map_err(|error| caused(&error))?;
        let view = ImportedView {
            name: "whole scene".to_owned(),
            camera: Box::new(camera),
            filter: Filter::default(),
        };
        let (warnings, notes) = self.warnings.into_lists();
        Ok(Import { world, views: vec![view], hints: Hints::default(), warnings, notes })
    }
}
