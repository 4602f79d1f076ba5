//! Scenes of the pbrt renderer: version 4, and of version 3 what has a counterpart in it.
//!
//! ```no_run
//! use pathspace::import::{Options, pbrt};
//!
//! let import = pbrt::load("scene.pbrt", &Options::default())?;
//! for warning in &import.warnings {
//!     eprintln!("{warning}");
//! }
//! let camera = &import.views[0].camera;
//! # Ok::<(), pathspace::import::Error>(())
//! ```
//!
//! # What is read
//!
//! | | read | approximated, with a warning | left out, with a warning |
//! |---|---|---|---|
//! | files | `.pbrt`, `.pbrt.gz`, `Include`, `Import` | | |
//! | state | scopes, transforms, `Attribute`, `ColorSpace`, `ReverseOrientation`, instances (as copies) | media, by what `homogeneous` ones absorb | motion, lights in instances |
//! | cameras | `perspective` with lens and window, `orthographic` | `realistic`, `spherical` | |
//! | films | size, windows, `iso` and exposure as a factor of all light | | sensors |
//! | filters | `box` and `triangle` of a pixel, `gaussian` | others, by a Gaussian | |
//! | shapes | `trianglemesh`, `plymesh`, `bilinearmesh`, `sphere`, `disk` | `cylinder` and parts of spheres and disks as triangles, `loopsubdiv` as its control mesh | `curve`, displacement |
//! | materials | `diffuse`, `coateddiffuse`, `conductor`, `dielectric`, `thindielectric`, `mix`, `interface` | `coatedconductor`, `diffusetransmission`, `subsurface`, `hair`, `measured`; those of version 3 | |
//! | roughness | `remaproughness`, along u and v, textures | of a coat, by its mean | |
//! | textures | `constant`, `imagemap`, `checkerboard` of constants, `scale` and `mix` with constants | others, and mappings other than `uv`, by a mean | |
//! | bump and normal maps | `displacement`, `normalmap` | | those of the parts of a `mix` |
//! | opacity | `alpha` of shapes, but for their light | | |
//! | lights | `point`, `spot`, `distant`, `infinite`, `diffuse` of shapes, each with `scale` and `power` or `illuminance` | `goniometric`, `projection` | portals |
//! | spectra | `rgb`, `blackbody`, values and files, names of metals, glasses and light sources | dispersion, by an index | |
//!
//! An object that is malformed, degenerate or unknown, or that needs a file which is missing or
//! damaged, is left out or replaced with a warning; in strict mode it is an error. What the limits
//! do not admit is always refused.
//!
//! # Conventions
//!
//! - pbrt's coordinates are left-handed. They are kept as they are, and cameras are mirrored.
//! - RGB is what it is as light of a film without a scale, and as a reflectance. Another spectrum of
//!   a light has the luminance 1 whatever its magnitude, before `scale` and `power`; light sources
//!   by name have their chromaticity. Of the reflectances of spectra the colour under daylight
//!   (D65) is taken, of named metals what [Mitsuba's](super) have.
//! - `power` is that of each triangle or patch of a mesh, as pbrt makes a light of each; triangles of
//!   one mesh have the same radiance here. With an image of an environment, `illuminance` is what
//!   pbrt computes, with half the solid angle of its pixels.
//! - An environment in pbrt's equal-area map is resampled to latitude and longitude; its pixels are
//!   patches of one radiance, as there.
//! - A coat over a diffuse body throws light back to it, which is coloured again.
//! - `maxdepth` counts scattering events, as here, where it is 5 unless the file says otherwise; an
//!   `interface` counts here and not there.

mod cameras;
mod colours;
mod directives;
mod lights;
mod materials;
mod object;
mod shapes;
mod textures;
mod tokens;

use super::files::Files;
use super::{Error, Hints, Import, Limits, Location, Options, Warnings};
use crate::material::{Bitmap, Relief, Texture};
use crate::math::Rgb;
use crate::scene::{MaterialId, WorldBuilder};
use cameras::Setup;
use colours::ColourSpace;
use flate2::read::MultiGzDecoder;
use glam::DAffine3;
use lights::Environment;
use materials::Reference;
use object::{Object, Parameter};
use shapes::Shape;
use std::collections::HashMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use textures::Sort;

/// Reads a scene.
///
/// # Errors
/// If the file cannot be read, asks for more than the limits admit, or has neither a surface nor a
/// light; in strict mode also for everything that would be a warning.
pub fn load(path: impl AsRef<Path>, options: &Options) -> Result<Import, Error> {
    let path = path.as_ref();
    let whole = Location { file: path.to_owned(), ..Location::default() };
    options.check_size(path)?;
    let files = Files::new(path, &options.limits)?;
    let mut loader = Loader::new(path, files, options);
    let bytes = loader.files.read_path(path, whole.clone())?;
    let bytes = loader.unpacked(bytes, &whole)?;
    loader.file(path, &bytes, 0)?;
    loader.at = Place { file: Rc::new(path.to_owned()), ..Place::default() };
    loader.finish()
}

/// The place of the directive that is being read.
#[derive(Clone, Default)]
struct Place {
    file: Rc<PathBuf>,
    directive: String,
    line: Option<u32>,
}

/// What directives leave behind for those that follow, up to the end of their scope.
#[derive(Clone)]
struct State {
    /// pbrt's current transformation.
    to_world: DAffine3,
    reverse: bool,
    material: Reference,
    light: Option<Rc<Object>>,
    /// The absorption coefficient of the medium inside of shapes.
    absorption: Rgb,
    colours: ColourSpace,
    /// What `Attribute` says of objects of each sort, in the order of [`directives::SORTS`].
    defaults: [Rc<Vec<Rc<Parameter>>>; directives::SORTS.len()],
    /// False if transforms are those at the end of the time only.
    at_start: bool,
}

/// A scene that is being put together, and everything known on the way.
struct Loader {
    files: Files,
    limits: Limits,
    warnings: Warnings,
    at: Place,
    state: State,
    scopes: Vec<(directives::Scope, State)>,
    coordinate_systems: HashMap<String, DAffine3>,
    setup: Setup,
    /// The factor of all light that the film makes.
    exposure: f64,
    hints: Hints,
    builder: WorldBuilder,
    environment: Environment,
    /// The environment and the size of films that are wished for.
    options: Options,
    textures: HashMap<(Sort, String), Texture>,
    images: HashMap<String, Bitmap>,
    default_material: Rc<Object>,
    named_materials: HashMap<String, Rc<Object>>,
    materials: HashMap<materials::Key, (Rc<Object>, MaterialId)>,
    /// The bump or normal map of the material that is being made.
    relief: Option<Relief>,
    reliefs: HashMap<MaterialId, Relief>,
    /// The object that is being defined.
    definition: Option<(String, Vec<Rc<Shape>>)>,
    definitions: HashMap<String, Rc<Vec<Rc<Shape>>>>,
    /// Shapes whose material has not been described yet, and what goes after their own transform.
    pending: Vec<(Rc<Shape>, DAffine3)>,
    /// Absorption coefficients of media by name.
    media: HashMap<String, Rgb>,
    surfaces: u64,
    lights: u64,
    elements_left: u64,
    triangles_left: u64,
    pixels_left: u64,
}

impl Loader {
    fn new(path: &Path, files: Files, options: &Options) -> Self {
        let location = Location { file: path.to_owned(), ..Location::default() };
        let default_material =
            Rc::new(Object { kind: "diffuse".to_owned(), location, ..Object::default() });
        Self {
            files,
            limits: options.limits,
            warnings: Warnings::new(options.strict),
            at: Place::default(),
            state: State {
                to_world: DAffine3::IDENTITY,
                reverse: false,
                material: Reference::Given(Rc::clone(&default_material)),
                light: None,
                absorption: Rgb::BLACK,
                colours: ColourSpace::default(),
                defaults: Default::default(),
                at_start: true,
            },
            scopes: Vec::new(),
            coordinate_systems: HashMap::new(),
            setup: Setup::default(),
            exposure: 1.0,
            hints: Hints { max_bounces: Some(5), ..Hints::default() },
            builder: WorldBuilder::varied(options.variation),
            environment: Environment::default(),
            options: options.clone(),
            textures: HashMap::new(),
            images: HashMap::new(),
            default_material,
            named_materials: HashMap::new(),
            materials: HashMap::new(),
            relief: None,
            reliefs: HashMap::new(),
            definition: None,
            definitions: HashMap::new(),
            pending: Vec::new(),
            media: HashMap::new(),
            surfaces: 0,
            lights: 0,
            elements_left: options.limits.elements,
            triangles_left: options.limits.triangles,
            pixels_left: options.limits.pixels,
        }
    }

    /// The place of the directive that is being read.
    fn location(&self) -> Location {
        Location {
            file: self.at.file.to_path_buf(),
            element: self.at.directive.clone(),
            id: None,
            line: self.at.line,
        }
    }

    /// Reads a file that the scene refers to, and unpacks it.
    fn read(&mut self, name: &str, location: &Location) -> Result<(PathBuf, Vec<u8>), Error> {
        let (path, bytes) = self.files.read(name, location.clone())?;
        Ok((path, self.unpacked(bytes, location)?))
    }

    /// The content of a file that may be compressed.
    fn unpacked(&mut self, bytes: Vec<u8>, location: &Location) -> Result<Vec<u8>, Error> {
        if !bytes.starts_with(&[0x1f, 0x8b]) {
            return Ok(bytes);
        }
        let mut unpacked = Vec::new();
        let most = self.files.bytes_left().saturating_add(1);
        let read = MultiGzDecoder::new(&bytes[..]).take(most).read_to_end(&mut unpacked);
        self.files.spend(unpacked.len() as u64, location.clone())?;
        read.map_err(|error| Error::caused(location.clone(), error))?;
        Ok(unpacked)
    }

    /// The scene, after everything has been read.
    fn finish(mut self) -> Result<Import, Error> {
        let whole = self.location();
        if !self.scopes.is_empty() {
            let reason = format!("{} scopes are not closed at the end", self.scopes.len());
            self.warnings.warn(whole.clone(), reason)?;
        }
        let at = self.at.clone();
        self.place_pending()?;
        self.at = at;
        let view = self.view()?;
        let surround = self.surround();
        self.warnings.rescue(surround, "it is left out")?;
        let builder = std::mem::take(&mut self.builder);
        let world = builder.build().map_err(|error| Error::caused(whole.clone(), error))?;
        if world.dropped_triangles() > 0 {
            let reason =
                format!("{} triangles without area are left out", world.dropped_triangles());
            self.warnings.lose(whole, reason)?;
        }
        self.warnings.check_surfaces(&world)?;
        let (warnings, notes) = self.warnings.into_lists();
        Ok(Import { world, views: vec![view], hints: self.hints, warnings, notes })
    }
}
