//! Scenes of the Mitsuba renderer: XML of scene versions 0.4 to 3, of which those before 2 get the
//! names of parameters that they have since.
//!
//! ```no_run
//! use pathspace::import::{Options, mitsuba};
//!
//! let parameters = [("spp".to_owned(), "16".to_owned())];
//! let import = mitsuba::load("scene.xml", &Options::default(), parameters)?;
//! for warning in &import.warnings {
//!     eprintln!("{warning}");
//! }
//! let camera = &import.views[0].camera;
//! # Ok::<(), pathspace::import::Error>(())
//! ```
//!
//! # What is read
//!
//! | elements | types |
//! |---|---|
//! | documents | `default`, `$parameters`, `include`, `ref`, `alias`, `path` |
//! | shapes | `obj`, `ply`, `serialized`, `rectangle`, `sphere`, `disk`, `cylinder`, `cube` |
//! | shapes made of others | `shapegroup`, `instance`, `merge` |
//! | settings of shapes | `to_world`, `flip_normals`, `face_normals`, `flip_tex_coords` |
//! | bsdfs | `diffuse`, `conductor`, `roughconductor`, `plastic`, `roughplastic`, `principled` |
//! | bsdfs that transmit light | `dielectric`, `thindielectric`, `roughdielectric`, `null` |
//! | bsdfs made of others | `twosided`, `mask`, `blendbsdf`, `normalmap`, `bumpmap` |
//! | emitters | `area`, `point`, `spot`, `directional`, `constant`, `envmap` |
//! | sensors | `perspective`, `thinlens`, `orthographic` |
//! | parts of sensors | film, crop window, reconstruction filter |
//! | textures | `bitmap`, `checkerboard` where a colour is reflected, emitted, or mixes materials, |
//! | | and as roughness of conductors and dielectrics |
//! | textures of vertices | `mesh_attribute` of the `vertex_color` of PLY files, where reflected |
//! | colours | `rgb`, `float`, `spectrum` as a value, or a list or file of wavelengths and values |
//! | colours of old versions | `srgb`, `blackbody` |
//! | spectra | `uniform`, `d65`, `srgb`, `rawconstant`, `regular`, `irregular`, `blackbody` |
//!
//! An object that is malformed, degenerate or unknown, or that needs a file which is missing or
//! damaged, is left out or replaced with a warning; in strict mode it is an error. What the limits
//! do not admit is always refused.
//!
//! # Conventions
//!
//! - Spectra become linear RGB by the CIE 1931 observer: emission as it is seen, so that a constant
//!   spectrum has the colour of the equal-energy illuminant; everything else under daylight (D65),
//!   so that constant reflectances are grey. Nothing is assumed outside of the listed wavelengths.
//! - Conductors, by name or by spectra of `eta` and `k`, reflect at normal incidence what their
//!   spectrum reflects; their indices follow from that.
//! - A shape without a material is diffuse and grey, or black if it emits.
//! - A material that is not `twosided` absorbs on its back, unless it transmits light.
//! - Which side is the front is decided by the vertex normals of a mesh. Meshes without them get
//!   normals weighted by the angles of their triangles, unless `face_normals` is set.
//! - Normal and bump maps hold for a whole surface, on both sides, and only one for each surface.
//! - Instances become surfaces of their own, within the limits on triangles; their shapes may emit.
//! - Cylinders are 256 flat strips with the normals and texture coordinates of the cylinder, inside
//!   of it by at most 7.6e-5 of its radius. So are disks that are scaled unevenly, and ellipsoids,
//!   which lie inside by up to 3.1e-4.
//! - Media inside of shapes absorb and do not scatter.
//! - Masking and shadowing of rough conductors and dielectrics are height-correlated here, and
//!   independent there: they are a little brighter here at grazing angles.
//! - A Gaussian filter has the same standard deviation, but is the pixel's box blurred. Environment
//!   maps have their pixels' centres in the middle of pixels.
//! - `max_depth` counts the edges of a path there and the scattering events here, one less.
//! - Reflectances, transmittances, opacities and weights are clamped to between 0 and 1, with a
//!   warning.
//! - Settings of integrators and samplers whose parameter has no value are left out, with a
//!   warning; anything else without its value is an error.
//! - The integrator and the sampler are [hints](super::Hints); of nested integrators the innermost
//!   one is taken. `direct` has one scattering event. With a `max_depth` of 0 nothing is seen: no
//!   emitter is read.

mod document;
mod emitters;
mod groups;
mod images;
mod integrators;
mod materials;
mod media;
mod meshes;
mod revolved;
mod sensors;
mod shapes;
mod textures;
mod values;

use super::files::Files;
use super::{Error, Hints, Import, ImportedView, Limits, Location, Options, Warnings};
use super::{conductors, spectrum};
use crate::material::{Relief, Texture};
use crate::scene::{MaterialId, WorldBuilder};
use document::{Document, Element};
use shapes::Part;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;

/// Reads a scene. `parameters` are the values of `$name`s, which precede the `<default>`s in the
/// file.
///
/// # Errors
/// If the file or one that it includes cannot be read or is no XML of a scene, has parameters
/// without a value, asks for more than the limits admit, or has no sensor that can be used, or
/// neither a surface nor a light; in strict mode also for everything that would be a warning.
pub fn load(
    path: impl AsRef<Path>,
    options: &Options,
    parameters: impl IntoIterator<Item = (String, String)>,
) -> Result<Import, Error> {
    let path = path.as_ref();
    options.check_size(path)?;
    let parameters: BTreeMap<String, String> = parameters.into_iter().collect();
    let mut files = Files::new(path, &options.limits)?;
    let document = document::read(path, &mut files, &options.limits, &parameters)?;
    let mut loader = Loader::new(&document, files, options)?;
    for name in &document.unused_parameters {
        let location = Location { file: path.to_owned(), ..Location::default() };
        loader.warnings.warn(location, format!("no file asks for the parameter {name}"))?;
    }
    for error in &document.left_out {
        loader.warnings.lose(error.location.clone(), &*error.reason)?;
    }
    loader.scene(path)
}

/// A scene that is being put together, and everything known on the way.
struct Loader<'a> {
    document: &'a Document,
    ids: HashMap<&'a str, &'a Element>,
    /// Top-level emitters that a shape refers to.
    referenced: HashSet<*const Element>,
    files: Files,
    limits: Limits,
    /// The environment and the size of films that are wished for.
    options: Options,
    warnings: Warnings,
    builder: WorldBuilder,
    /// Names of objects, and how many have wanted each.
    names: HashMap<String, u64>,
    hints: Hints,
    /// False if the integrator sees nothing.
    sees: bool,
    materials: HashMap<*const Element, MaterialId>,
    /// The normal or bump map of the material that is being read.
    map: Option<Relief>,
    /// Those of materials that have one.
    reliefs: HashMap<MaterialId, Relief>,
    textures: HashMap<(*const Element, bool), Texture>,
    groups: HashMap<*const Element, Rc<[Part<'a>]>>,
    /// Images that have been decoded, by their names and whether they are raw.
    ahead: HashMap<(String, bool), images::Ahead>,
    /// True if a texture shows the colours of vertices.
    asks_for_colors: bool,
    triangles_left: u64,
    pixels_left: u64,
}

impl<'a> Loader<'a> {
    fn new(document: &'a Document, files: Files, options: &Options) -> Result<Self, Error> {
        let mut loader = Self {
            document,
            ids: HashMap::new(),
            referenced: HashSet::new(),
            files,
            limits: options.limits,
            options: options.clone(),
            warnings: Warnings::new(options.strict),
            builder: WorldBuilder::varied(options.variation),
            names: HashMap::new(),
            hints: Hints::default(),
            sees: true,
            materials: HashMap::new(),
            map: None,
            reliefs: HashMap::new(),
            textures: HashMap::new(),
            groups: HashMap::new(),
            ahead: HashMap::new(),
            asks_for_colors: has_mesh_attributes(&document.scene),
            triangles_left: options.limits.triangles,
            pixels_left: options.limits.pixels,
        };
        loader.find_ids(&document.scene)?;
        loader.find_references(&document.scene);
        Ok(loader)
    }

    fn find_ids(&mut self, elements: &'a [Element]) -> Result<(), Error> {
        for element in elements {
            if let Some(id) = element.id().filter(|_| element.tag != "ref") {
                match self.ids.entry(id) {
                    Entry::Vacant(entry) => drop(entry.insert(element)),
                    Entry::Occupied(_) => self.warn(
                        element,
                        format!("the id {id} occurs twice; the first one is referred to"),
                    )?,
                }
            }
            self.find_ids(&element.children)?;
        }
        Ok(())
    }

    fn find_references(&mut self, elements: &'a [Element]) {
        for element in elements {
            if let Some(target) =
                element.id().filter(|_| element.tag == "ref").and_then(|id| self.lookup(id))
            {
                self.referenced.insert(target);
            }
            self.find_references(&element.children);
        }
    }

    /// The element of an id or of an alias of one.
    fn lookup(&self, id: &str) -> Option<&'a Element> {
        let mut id = id;
        // An alias may stand for an alias.
        for _ in 0..self.limits.depth {
            match self.document.aliases.get(id) {
                Some(other) if !self.ids.contains_key(id) => id = other,
                _ => break,
            }
        }
        self.ids.get(id).copied()
    }

    /// The element itself, or what a `<ref>` refers to.
    fn resolved(&self, element: &'a Element) -> Result<&'a Element, Error> {
        if element.tag != "ref" {
            return Ok(element);
        }
        let id = element.required("id")?;
        self.lookup(id).ok_or_else(|| element.error(format!("there is no object with the id {id}")))
    }

    /// A name that nothing else has: the id, or kind and line.
    fn name(&mut self, element: &Element) -> String {
        let base = element.id().map_or_else(
            || format!("{} {} in line {}", element.kind(), element.tag, element.line()),
            str::to_owned,
        );
        self.unique_name(base)
    }

    fn unique_name(&mut self, base: String) -> String {
        let mut number = self.names.get(&base).copied().unwrap_or(0);
        // Another object may have the name "base (2)" for its id.
        let name = loop {
            number += 1;
            let name = if number == 1 { base.clone() } else { format!("{base} ({number})") };
            if number == 1 || !self.names.contains_key(&name) {
                break name;
            }
        };
        self.names.insert(base, number);
        self.names.entry(name.clone()).or_insert(1);
        name
    }

    fn warn(&mut self, element: &Element, reason: impl Into<String>) -> Result<(), Error> {
        self.warnings.warn(element.location(), reason)
    }

    fn scene(mut self, path: &Path) -> Result<Import, Error> {
        let mut sensors = Vec::new();
        // Whether emitters are read depends on it.
        for element in self.document.scene.iter().filter(|element| element.tag == "integrator") {
            let read = self.integrator(element, 0);
            self.warnings.rescue(read, "all light is taken")?;
        }
        self.decode_ahead();
        for element in &self.document.scene {
            match element.tag.as_str() {
                "integrator" => {}
                "shape" => {
                    let read = self.shape(element);
                    self.warnings.rescue_surface(read, "it is left out")?;
                }
                "emitter" if self.sees => {
                    let read = self.emitter(element);
                    self.warnings.rescue(read, "it is left out")?;
                }
                "sensor" => sensors.push(element),
                // Read where they are referred to, if at all.
                "emitter" | "bsdf" | "texture" | "spectrum" | "rgb" | "float" | "medium"
                | "phase" | "volume" => {}
                other => self.warn(element, format!("{other} is not known, and left out"))?,
            }
        }
        let whole = || Location { file: path.to_owned(), ..Location::default() };
        if sensors.is_empty() {
            let left_out = self.document.left_out.last();
            let why = left_out.map_or_else(String::new, |error| format!(" (left out: {error})"));
            return Err(Error::new(whole(), format!("the scene has no sensor{why}")));
        }
        let mut views = Vec::new();
        let mut clips = Vec::new();
        for sensor in sensors {
            let read = self.sensor(sensor, views.len());
            if let Some((view, clip)) = self.warnings.rescue(read, "it is left out")? {
                views.push(view);
                clips.push(clip);
            }
        }
        if views.is_empty() {
            let last = self.warnings.into_lists().0.pop();
            let why = last.map_or_else(String::new, |warning| warning.to_string());
            return Err(Error::new(whole(), format!("no sensor can be used: {why}")));
        }
        let mut builder = std::mem::take(&mut self.builder);
        if let Some(environment) = self.options.environment.light()? {
            let name = self.unique_name("environment".to_owned());
            let added = builder.set_environment(name, environment);
            added.map_err(|error| Error::caused(whole(), error))?;
        }
        let world = builder.build().map_err(|error| Error::caused(whole(), error))?;
        for clip in clips {
            clip.check(world.bounds(), &mut self.warnings)?;
        }
        if world.dropped_triangles() > 0 {
            self.warnings.lose(
                whole(),
                format!("{} triangles without area are left out", world.dropped_triangles()),
            )?;
        }
        self.warnings.check_surfaces(&world)?;
        if world.light_count() == 0 {
            self.warnings.note("it has no light: the image is black");
        }
        let (warnings, notes) = self.warnings.into_lists();
        Ok(Import { world, views, hints: self.hints, warnings, notes })
    }
}

fn has_mesh_attributes(elements: &[Element]) -> bool {
    elements
        .iter()
        .any(|element| element.kind() == "mesh_attribute" || has_mesh_attributes(&element.children))
}
