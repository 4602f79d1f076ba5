//! Scenes in glTF 2.0, in Wavefront OBJ, and of the renderers Mitsuba 3 and pbrt.

use super::scenes::{AnyCamera, FileOptions, NamedScene};
use pathspace::glam::UVec2;
use pathspace::import::{Import, gltf, mitsuba, obj, pbrt};
use std::error::Error;
use std::path::Path;

/// Loads a Mitsuba file, which brings its own film.
pub fn load_mitsuba(
    path: &Path,
    size: Option<UVec2>,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    let parameters = options.define.iter().cloned();
    named(path, mitsuba::load(path, &options.options(size), parameters)?, options)
}

/// Loads a pbrt file, which brings its own film.
pub fn load_pbrt(
    path: &Path,
    size: Option<UVec2>,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    named(path, pbrt::load(path, &options.options(size))?, options)
}

/// Loads a glTF file; its cameras bring their aspect ratio.
pub fn load_gltf(
    path: &Path,
    resolution: UVec2,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    named(path, gltf::load(path, resolution, &options.options(None))?, options)
}

/// Loads a Wavefront OBJ file.
pub fn load_obj(
    path: &Path,
    resolution: UVec2,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    named(path, obj::load(path, resolution, &options.options(None))?, options)
}

/// The scene with the camera that is wished for, or the first.
fn named(path: &Path, import: Import, options: &FileOptions) -> Result<NamedScene, Box<dyn Error>> {
    let warnings = import.warnings.iter().map(|warning| format!("warning: {warning}"));
    let notes = import.notes.iter().map(|note| format!("note: {note}"));
    let mut messages: Vec<String> = warnings.chain(notes).collect();
    let names: Vec<String> = import.views.iter().map(|view| view.name.clone()).collect();
    let chosen = match &options.view {
        None => 0,
        Some(wanted) => names
            .iter()
            .position(|name| name == wanted)
            .or_else(|| wanted.parse().ok().and_then(|n: usize| n.checked_sub(1)))
            .filter(|index| *index < names.len())
            .ok_or_else(|| format!("there is no view {wanted}, only {}", names.join(", ")))?,
    };
    if options.view.is_none() && names.len() > 1 {
        let (first, count) = (&names[0], names.len());
        messages.push(format!("note: {first} is the first of {count} cameras; --view chooses"));
    }
    let view = import.views.into_iter().nth(chosen).ok_or("no camera")?;
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
        views: names,
        messages,
    })
}
