//! Scenes in glTF 2.0, in Wavefront OBJ, and of the renderers Mitsuba 3 and pbrt.

use super::scenes::{AnyCamera, FileOptions, NamedScene};
use pathspace::glam::UVec2;
use pathspace::import::{Import, Options, gltf, mitsuba, obj, pbrt};
use std::error::Error;
use std::path::Path;

/// Loads a Mitsuba file, which brings its own film.
pub fn load_mitsuba(path: &Path, options: &FileOptions) -> Result<NamedScene, Box<dyn Error>> {
    let how = Options { strict: options.strict, ..Options::default() };
    named(path, mitsuba::load(path, &how, options.define.iter().cloned())?)
}

/// Loads a pbrt file, which brings its own film.
pub fn load_pbrt(path: &Path, options: &FileOptions) -> Result<NamedScene, Box<dyn Error>> {
    let how = Options { strict: options.strict, ..Options::default() };
    named(path, pbrt::load(path, &how)?)
}

/// Loads a glTF file; its cameras bring their aspect ratio.
pub fn load_gltf(
    path: &Path,
    resolution: UVec2,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    let how = Options { strict: options.strict, ..Options::default() };
    named(path, gltf::load(path, resolution, &how)?)
}

/// Loads a Wavefront OBJ file.
pub fn load_obj(
    path: &Path,
    resolution: UVec2,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    let how = Options { strict: options.strict, ..Options::default() };
    named(path, obj::load(path, resolution, &how)?)
}

/// Prints the warnings; of several cameras the first is taken.
fn named(path: &Path, import: Import) -> Result<NamedScene, Box<dyn Error>> {
    for warning in &import.warnings {
        eprintln!("warning: {warning}");
    }
    let cameras = import.views.len();
    let view = import.views.into_iter().next().ok_or("no camera")?;
    if cameras > 1 {
        eprintln!("note: {} is the first of {cameras} cameras", view.name);
    }
    let name = path
        .file_stem()
        .map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let directory = path
        .parent()
        .and_then(Path::file_name)
        .map(|directory| directory.to_string_lossy().into_owned());
    Ok(NamedScene {
        // Many files are called "scene": their directory tells what they show.
        name: directory.filter(|_| name == "scene").unwrap_or(name),
        description: format!(
            "{} with {} primitives and {} lights.",
            path.display(),
            import.world.primitive_count(),
            import.world.light_count()
        ),
        claims: None,
        world: import.world,
        camera: AnyCamera(view.camera),
        max_bounces: import.hints.max_bounces,
        filter: view.filter,
    })
}
