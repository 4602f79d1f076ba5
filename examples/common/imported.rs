//! Scenes in glTF 2.0, in Wavefront OBJ, and of the renderers Mitsuba 3 and pbrt.

use super::scenes::{AnyCamera, FileOptions, NamedScene, SIZE};
use pathspace::glam::UVec2;
use pathspace::import::{self, Import};
use std::error::Error;
use std::path::Path;

/// Loads a scene file by the reader for its extension, which is in lower case; `None` if there is
/// none. Films of glTF and OBJ files have the size that is wished for, or a default; files of the
/// others bring their own.
pub fn load(
    path: &Path,
    extension: &str,
    size: Option<UVec2>,
    options: &FileOptions,
) -> Option<Result<NamedScene, Box<dyn Error>>> {
    let (fixed, plain) = (size.unwrap_or(SIZE), options.options(None));
    let import = match extension {
        "obj" => import::obj::load(path, fixed, &plain),
        "gltf" | "glb" => import::gltf::load(path, fixed, &plain),
        "xml" => {
            import::mitsuba::load(path, &options.options(size), options.define.iter().cloned())
        }
        "pbrt" | "gz" => import::pbrt::load(path, &options.options(size)),
        _ => return None,
    };
    Some(import.map_err(Box::from).and_then(|import| named(path, import, options)))
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
