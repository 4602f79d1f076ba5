//! A scene by its name in the gallery, or from a file.

use super::{AnyIntegrator, imported};
use clap::Args;
use pathspace::endpoint::Camera;
use pathspace::film::Filter;
use pathspace::gallery::{self, Claims, GalleryScene};
use pathspace::glam::UVec2;
use pathspace::path::{DrawnBy, MissingPaths};
use pathspace::render::RenderError;
use pathspace::report::Method;
use pathspace::scene::World;
use std::error::Error;
use std::path::Path;

/// A scene ready to be rendered.
#[derive(Debug)]
pub struct NamedScene {
    /// Name in the gallery, or the file's name without its extension.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Surfaces, materials and lights.
    pub world: World,
    /// The camera, with the film.
    pub camera: AnyCamera,
    /// The depth to render with unless the user wants another; `None` for no limit.
    pub max_bounces: Option<u32>,
    /// The integrators that see every path, if that is known of the scene.
    pub claims: Option<Claims>,
    /// The pixel filter to render with unless the user wants another.
    pub filter: Filter,
}

impl NamedScene {
    /// The paths that an integrator's image will lack, as far as the scene has them.
    pub fn missing(
        &self,
        integrator: AnyIntegrator,
        method: &dyn Method<World>,
    ) -> Result<Vec<MissingPaths>, RenderError> {
        let mut missing = method.missing(&self.world, &*self.camera.0)?;
        if self.claims.is_some_and(|claims| integrator.sees_all(&claims)) {
            missing.retain(|paths| paths.drawn_by != DrawnBy::Connections);
        }
        Ok(missing)
    }

    /// True if an integrator that lacks these paths draws all that can be connected.
    pub fn is_complete(&self, integrator: AnyIntegrator, missing: &[MissingPaths]) -> bool {
        self.claims.is_none_or(|claims| integrator.sees_all(&claims))
            && missing.iter().all(|paths| paths.drawn_by != DrawnBy::Connections)
    }
}

/// Options of reading scene files.
#[derive(Args, Clone, Debug, Default)]
pub struct FileOptions {
    /// Refuse scene files that ask for what is not supported, instead of warning
    #[arg(long)]
    pub strict: bool,
    /// Set a parameter of a Mitsuba scene, such as spp=16; may be given several times
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse_definition)]
    pub define: Vec<(String, String)>,
}

fn parse_definition(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("a parameter looks like name=value")?;
    Ok((name.to_owned(), value.to_owned()))
}

/// A camera of any kind.
pub struct AnyCamera(pub Box<dyn Camera + Send>);

impl std::fmt::Debug for AnyCamera {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("AnyCamera").field(&self.0.film()).finish()
    }
}

impl From<GalleryScene> for NamedScene {
    fn from(scene: GalleryScene) -> Self {
        Self {
            name: scene.name.to_owned(),
            description: scene.description.to_owned(),
            world: scene.world,
            camera: AnyCamera(scene.camera),
            max_bounces: scene.max_bounces,
            claims: Some(scene.claims),
            filter: Filter::Box,
        }
    }
}

/// The scene of the gallery with this name, or the one in the file at this path: Wavefront OBJ,
/// glTF or Mitsuba XML, which brings its own film. Tells what building it warns of.
pub fn scene_or_file(
    name_or_path: &str,
    resolution: UVec2,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    let scene = load(name_or_path, resolution, options)?;
    scene.world.warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
    Ok(scene)
}

fn load(
    name_or_path: &str,
    resolution: UVec2,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    let path = Path::new(name_or_path);
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    match extension.as_ref().and_then(|extension| extension.to_str()) {
        Some("obj") => imported::load_obj(path, resolution, options),
        Some("gltf" | "glb") => imported::load_gltf(path, resolution, options),
        Some("xml") => imported::load_mitsuba(path, options),
        Some("pbrt" | "gz") => imported::load_pbrt(path, options),
        _ if path.exists() && !gallery::NAMES.contains(&name_or_path) => {
            Err(format!("{name_or_path}: only Wavefront OBJ (.obj), glTF (.gltf, .glb), Mitsuba (.xml) and pbrt (.pbrt, .pbrt.gz) files can be read").into())
        }
        _ => Ok(gallery::build(name_or_path, resolution)?.into()),
    }
}

/// The gallery as text, a line for each scene.
pub fn scene_list() -> String {
    let line =
        |name: &&str| format!("{name:<14} {}\n", gallery::description(name).unwrap_or_default());
    gallery::NAMES.iter().map(line).collect()
}
