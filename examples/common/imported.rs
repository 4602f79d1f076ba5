//! Scenes from files, by the readers that the program was built with.

use super::cargo_command;
use super::scenes::{AnyCamera, FileOptions, NamedScene, SIZE};
use pathspace::glam::UVec2;
use pathspace::import::{self, Import};
use std::error::Error;
use std::path::Path;

/// Loads a scene file by the reader for its extension, which is in lower case. Films of glTF and
/// OBJ files have the size that is wished for, or a default; files of the others bring their own.
pub fn load(
    path: &Path,
    extension: &str,
    size: Option<UVec2>,
    options: &FileOptions,
) -> Result<NamedScene, Box<dyn Error>> {
    match read(path, extension, size, options)? {
        Some(import) => named(path, import, options),
        None => Err(format!(
            "{}: this program was built without the reader of such files; `{} -- …` builds it with \
             all readers",
            path.display(),
            cargo_command(true)
        )
        .into()),
    }
}

#[cfg_attr(not(feature = "readers"), allow(unused_variables, reason = "readers take them"))]
fn read(
    path: &Path,
    extension: &str,
    size: Option<UVec2>,
    options: &FileOptions,
) -> Result<Option<Import>, import::Error> {
    let fixed = size.unwrap_or(SIZE);
    Ok(match extension {
        #[cfg(feature = "obj")]
        "obj" => Some(import::obj::load(path, fixed, &options.options(None))?),
        #[cfg(feature = "gltf")]
        "gltf" | "glb" => Some(import::gltf::load(path, fixed, &options.options(None))?),
        #[cfg(feature = "mitsuba")]
        "xml" => {
            let parameters = options.define.iter().cloned();
            Some(import::mitsuba::load(path, &options.options(size), parameters)?)
        }
        #[cfg(feature = "pbrt")]
        "pbrt" | "gz" => Some(import::pbrt::load(path, &options.options(size))?),
        _ => None,
    })
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
