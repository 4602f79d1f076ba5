//! The container, its JSON and the files it refers to: nothing is believed before it has been
//! checked.

use super::clear_coat;
use super::draco;
use super::instances;
use super::meshopt::{self, Packed};
use super::repair;
use crate::import::files::Files;
use crate::import::{Environment, Error, Limits, Location, Options, Warnings};
use crate::scene::Variation;
use data_url::DataUrl;
use gltf::json::validation::{Checked, Validate};
use gltf::json::{Index, Node, Root, mesh::Semantic};
use percent_encoding::percent_decode_str;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Extensions whose meaning is known here.
const KNOWN_EXTENSIONS: [&str; 15] = [
    clear_coat::EXTENSION,
    draco::EXTENSION,
    instances::EXTENSION,
    meshopt::EXTENSIONS[0],
    meshopt::EXTENSIONS[1],
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Objects of JSON for each element.
const MOST_OBJECTS: u64 = 4;

/// A valid document whose buffers have been read.
pub(super) struct Document {
    path: PathBuf,
    pub root: Root,
    pub buffers: Vec<Arc<[u8]>>,
    /// Buffer views that were compressed, or the reasons for which they still are.
    unpacked: HashMap<usize, Result<Vec<u8>, String>>,
    /// Accessors whose bytes are not in buffer views, but come from the stream of a primitive.
    pub decoded: HashMap<usize, Vec<u8>>,
    pub files: Files,
    pub limits: Limits,
    pub environment: Environment,
    pub back_faces: bool,
    pub variation: Variation,
    pub warnings: Warnings,
}

impl Document {
    /// The document in a file.
    pub fn open(path: &Path, options: &Options) -> Result<Self, Error> {
        let mut files = Files::new(path, &options.limits)?;
        let whole = Location { file: path.to_owned(), ..Location::default() };
        let bytes = files.read_path(path, whole)?;
        Self::new(path, &bytes, files, options)
    }

    /// The document in memory; errors name it by the path.
    pub fn parse(path: &Path, bytes: &[u8], options: &Options) -> Result<Self, Error> {
        let mut files = Files::none(&options.limits);
        let whole = Location { file: path.to_owned(), ..Location::default() };
        files.spend(bytes.len() as u64, whole)?;
        Self::new(path, bytes, files, options)
    }

    fn new(path: &Path, bytes: &[u8], files: Files, options: &Options) -> Result<Self, Error> {
        let limits = options.limits;
        let whole = Location { file: path.to_owned(), ..Location::default() };
        let (json, binary) = split(bytes).map_err(|reason| Error::new(whole.clone(), reason))?;
        // Each takes up to 1.3 kB, however short it is in the file.
        let objects = json.iter().filter(|byte| **byte == b'{').count() as u64;
        if objects > limits.elements.saturating_mul(MOST_OBJECTS) {
            return Err(Error::new(
                whole,
                format!(
                    "{objects} objects of JSON; the limit is {MOST_OBJECTS} times {}",
                    limits.elements
                ),
            ));
        }
        let (mut root, repairs) =
            repair::parse(json).map_err(|error| Error::caused(whole.clone(), error))?;
        let mut warnings = Warnings::new(options.strict);
        for reason in repairs {
            warnings.warn(whole.clone(), reason)?;
        }
        if root.scenes.is_empty() {
            root.scene = None;
        }
        check_extensions(&mut root, &mut warnings, &whole)?;
        check_indices(&root).map_err(|reason| Error::new(whole.clone(), reason))?;
        let elements = [
            root.nodes.len(),
            root.meshes.iter().map(|mesh| mesh.primitives.len()).sum(),
            root.materials.len(),
            root.accessors.len(),
        ];
        let elements: u64 = elements.iter().map(|&n| n as u64).sum();
        if elements > limits.elements {
            return Err(Error::new(
                whole,
                format!(
                    "{elements} nodes, primitives, materials and accessors; the limit is {}",
                    limits.elements
                ),
            ));
        }
        if root.nodes.is_empty() && !root.meshes.is_empty() {
            warnings
                .warn(whole.clone(), "it has no nodes: its meshes are shown as they are stored")?;
            let meshes = 0..root.meshes.len() as u32;
            root.nodes = meshes
                .map(|mesh| Node { mesh: Some(Index::new(mesh)), ..Node::default() })
                .collect();
        }
        let binary = binary.map(Arc::from);
        let mut document = Self {
            path: path.to_owned(),
            root,
            buffers: Vec::new(),
            unpacked: HashMap::new(),
            decoded: HashMap::new(),
            files,
            limits,
            environment: options.environment.clone(),
            back_faces: options.back_faces,
            variation: options.variation,
            warnings,
        };
        document.read_buffers(binary)?;
        document.unpack_views()?;
        if !document.root.animations.is_empty() {
            document.warnings.warn(
                document.location("animations", None),
                "animations are left out: the scene is shown at rest",
            )?;
        }
        Ok(document)
    }

    /// The place of an element in the file.
    pub fn location(&self, element: impl Into<String>, name: Option<&String>) -> Location {
        Location { file: self.path.clone(), element: element.into(), id: name.cloned(), line: None }
    }

    fn read_buffers(&mut self, binary: Option<Arc<[u8]>>) -> Result<(), Error> {
        for index in 0..self.root.buffers.len() {
            let buffer = &self.root.buffers[index];
            let (uri, length) = (buffer.uri.clone(), buffer.byte_length.0);
            let location = self.location(format!("buffer {index}"), buffer.name.as_ref());
            if meshopt::is_fallback(buffer) {
                self.buffers.push(Arc::from([]));
                continue;
            }
            let bytes: Arc<[u8]> = match (uri, &binary) {
                (Some(uri), _) => self.fetch(&uri, &location)?.into(),
                (None, Some(binary)) if index == 0 => Arc::clone(binary),
                (None, _) => {
                    return Err(Error::new(
                        location,
                        "it has no uri, and the file no binary part for it",
                    ));
                }
            };
            if (bytes.len() as u64) < length {
                return Err(Error::new(
                    location,
                    format!("it should have {length} bytes, but there are {}", bytes.len()),
                ));
            }
            self.buffers.push(bytes);
        }
        Ok(())
    }

    /// Decompresses buffer views, so that what cannot be costs only what asks for it.
    fn unpack_views(&mut self) -> Result<(), Error> {
        for index in 0..self.root.buffer_views.len() {
            let view = &self.root.buffer_views[index];
            let Some(packed) = Packed::of(view) else { continue };
            let location = self.location(format!("buffer view {index}"), view.name.as_ref());
            let unpacked = match packed {
                Ok(packed) => {
                    self.files.spend(packed.size(), location)?;
                    let end = packed.offset.checked_add(packed.length);
                    let stream = self
                        .buffers
                        .get(packed.buffer)
                        .and_then(|buffer| buffer.get(packed.offset as usize..end? as usize));
                    let unpacked = stream.map(|stream| packed.unpack(stream));
                    unpacked.unwrap_or(Err("its buffer has no such bytes")).map_err(str::to_owned)
                }
                Err(reason) => Err(reason),
            };
            self.unpacked.insert(index, unpacked);
        }
        Ok(())
    }

    /// The bytes that a URI stands for.
    pub fn fetch(&mut self, uri: &str, location: &Location) -> Result<Vec<u8>, Error> {
        let refuse = |reason: String| Error::new(location.clone(), reason);
        if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
            let data =
                DataUrl::process(uri).map_err(|error| refuse(format!("data URI: {error}")))?;
            let (bytes, _) =
                data.decode_to_vec().map_err(|error| refuse(format!("data URI: {error}")))?;
            self.files.spend(bytes.len() as u64, location.clone())?;
            return Ok(bytes);
        }
        let name = percent_decode_str(uri)
            .decode_utf8()
            .map_err(|error| Error::caused(location.clone(), error))?;
        if name.split_once(':').is_some_and(|(scheme, _)| {
            scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
        }) {
            return Err(refuse(format!(
                "{name} is not the name of a file: only files and data URIs can be read"
            )));
        }
        self.files.read(&name, location.clone()).map(|(_, bytes)| bytes)
    }

    /// The bytes of a part of a buffer.
    pub fn view(&self, index: usize, location: &Location) -> Result<&[u8], Error> {
        if let Some(unpacked) = self.unpacked.get(&index) {
            let damaged = |reason| format!("buffer view {index} cannot be decompressed: {reason}");
            return unpacked
                .as_deref()
                .map_err(|reason| Error::damaged(location.clone(), damaged(reason)));
        }
        let view = &self.root.buffer_views[index];
        let buffer = view.buffer.value();
        let (start, length) = (view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0);
        let available = self.root.buffers[buffer].byte_length.0;
        let end = start.checked_add(length).filter(|end| *end <= available);
        end.and_then(|end| self.buffers[buffer].get(start as usize..end as usize)).ok_or_else(|| {
            Error::new(
                location.clone(),
                format!("buffer view {index} has {length} bytes from {start} of buffer {buffer}, which has {available}"),
            )
        })
    }
}

/// JSON and binary part of a file.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let word =
        |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let (version, length) = (word(4), word(8));
    if version != Some(2) {
        return Err(format!(
            "version {} of binary glTF cannot be read, only 2",
            version.map_or("?".to_owned(), |v| v.to_string())
        ));
    }
    let whole = length
        .and_then(|length| bytes.get(..length as usize))
        .ok_or("the file ends before its end")?;
    let (mut at, mut json, mut binary) = (12, None, None);
    while at < whole.len() {
        let (Some(length), Some(kind)) = (word(at), whole.get(at + 4..at + 8)) else {
            return Err("a chunk is cut off".to_owned());
        };
        let end = (at + 8)
            .checked_add(length as usize)
            .filter(|end| *end <= whole.len())
            .ok_or("a chunk is longer than the file")?;
        let chunk = &whole[at + 8..end];
        match (kind, at) {
            (b"JSON", 12) => json = Some(chunk),
            (b"BIN\0", _) if binary.is_none() => binary = Some(chunk),
            // Chunks of other kinds are to be skipped.
            _ => {}
        }
        at = end;
    }
    json.map(|json| (json, binary)).ok_or_else(|| "its first chunk is not JSON".to_owned())
}

/// Refuses unknown extensions that are required, and warns about those that are used.
fn check_extensions(
    root: &mut Root,
    warnings: &mut Warnings,
    whole: &Location,
) -> Result<(), Error> {
    let unknown = |name: &String| !KNOWN_EXTENSIONS.contains(&name.as_str());
    if let Some(name) = root.extensions_required.iter().find(|name| unknown(name)) {
        return Err(Error::new(
            whole.clone(),
            format!("the extension {name} is required, but not supported"),
        ));
    }
    for name in root.extensions_used.iter().filter(|name| unknown(name)) {
        let location =
            Location { element: "extension".to_owned(), id: Some(name.clone()), ..whole.clone() };
        warnings.warn(location, "it is not supported; the scene is shown without it")?;
    }
    // Checked here, and better than by the crate that checks the rest.
    root.extensions_required.clear();
    Ok(())
}

/// Checks that indices are in range and that values are among those that the format knows.
fn check_indices(root: &Root) -> Result<(), String> {
    // The crate's own check looks at these accessors before it knows that they exist.
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let positions = primitives
        .filter_map(|primitive| primitive.attributes.get(&Checked::Valid(Semantic::Positions)));
    if let Some(missing) =
        positions.map(|index| index.value()).find(|&index| index >= root.accessors.len())
    {
        return Err(format!(
            "a mesh has its positions in accessor {missing}, but there are {}",
            root.accessors.len()
        ));
    }
    let mut first = None;
    root.validate(root, gltf::json::Path::new, &mut |path, error| {
        let path = path();
        if error != gltf::json::validation::Error::Missing || !is_dispensable(path.as_str()) {
            first.get_or_insert_with(|| format!("{path}: {error}"));
        }
    });
    first.map_or(Ok(()), Err)
}

/// True for what may be missing: the bounds of positions are not used, elements of accessors
/// without a buffer view are 0, and textures without an image leave the factor.
fn is_dispensable(path: &str) -> bool {
    let bounds = [".attributes[\"POSITION\"].min", ".attributes[\"POSITION\"].max"];
    bounds.iter().any(|bound| path.ends_with(bound))
        || path.starts_with("accessors[") && path.ends_with("].bufferView")
        || path.starts_with("textures[") && path.ends_with("].source")
}
