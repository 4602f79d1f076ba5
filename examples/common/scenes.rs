//! A scene by its name in the gallery, or from a file.

use super::obj;
use pathspace::endpoint::Camera;
use pathspace::glam::UVec2;
use pathspace::scene::World;
use pathspace::scene::gallery::{self, Claims, GalleryScene};
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
    /// Which integrators see every path.
    pub claims: Claims,
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
            claims: scene.claims,
        }
    }
}

/// The scene of the gallery with this name, or the one in the Wavefront OBJ file at this path. Tells what building it warns of.
pub fn scene_or_file(name_or_path: &str, resolution: UVec2) -> Result<NamedScene, Box<dyn Error>> {
    let scene = load(name_or_path, resolution)?;
    scene.world.warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
    Ok(scene)
}

fn load(name_or_path: &str, resolution: UVec2) -> Result<NamedScene, Box<dyn Error>> {
    let path = Path::new(name_or_path);
    let is_obj = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj"));
    if is_obj {
        return obj::load(path, resolution);
    }
    if path.exists() && !gallery::NAMES.contains(&name_or_path) {
        return Err(format!("{name_or_path}: only Wavefront OBJ files (.obj) can be read").into());
    }
    Ok(gallery::build(name_or_path, resolution)?.into())
}

/// The gallery as text, a line for each scene.
pub fn scene_list() -> String {
    let line = |name: &&str| format!("{name:<14} {}\n", gallery::description(name).unwrap_or_default());
    gallery::NAMES.iter().map(line).collect()
}
