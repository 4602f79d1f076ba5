//! Primitives compressed by `KHR_draco_mesh_compression`.

use super::document::Document;
use crate::import::{Error, Location};
use gltf::json::mesh::Primitive;

/// The name of the extension.
pub(super) const EXTENSION: &str = "KHR_draco_mesh_compression";

impl Document {
    /// Decompresses what a primitive has in one stream, so that its accessors have bytes.
    pub fn unpack_primitive(
        &mut self,
        primitive: &Primitive,
        most_triangles: u64,
        location: &Location,
    ) -> Result<(), Error> {
        let others = primitive.extensions.as_ref().map(|extensions| &extensions.others);
        let Some(extension) = others.and_then(|others| others.get(EXTENSION)) else {
            return Ok(());
        };
        let damaged = |reason: &str| Error::damaged(location.clone(), reason);
        let view = extension.get("bufferView").and_then(|view| view.as_u64());
        let view = view.filter(|view| *view < self.root.buffer_views.len() as u64);
        let view = view.ok_or_else(|| damaged("its Draco stream is in no buffer view"))?;
        let stream = self.view(view as usize, location)?;
        let id = |name: &str| extension.get("attributes")?.get(name)?.as_u64();
        let wanted = primitive.attributes.iter().filter_map(|(semantic, accessor)| {
            let gltf::json::validation::Checked::Valid(semantic) = semantic else { return None };
            Some((accessor.value(), id(&semantic.to_string())?))
        });
        let wanted: Vec<(usize, u64)> = wanted.collect();
        let indices = primitive.indices.map(|indices| indices.value());
        let unpacked = self.decode_draco(stream, &wanted, indices, most_triangles, location)?;
        let bytes = unpacked.iter().map(|(_, bytes)| bytes.len() as u64).sum();
        self.files.spend(bytes, location.clone())?;
        self.decoded.extend(unpacked);
        Ok(())
    }

    /// The bytes of accessors: those of attributes by their numbers in the stream, and indices.
    #[cfg(feature = "draco")]
    fn decode_draco(
        &self,
        stream: &[u8],
        wanted: &[(usize, u64)],
        indices: Option<usize>,
        most_triangles: u64,
        location: &Location,
    ) -> Result<Vec<(usize, Vec<u8>)>, Error> {
        use super::accessor::component_type;
        use draco_core::{DataType, DecodeLimits, DecoderBuffer, ErrorKind};
        use draco_core::{Mesh, MeshDecoder, PointIndex};
        use gltf::json::accessor::ComponentType;

        let damaged = |reason: String| Error::damaged(location.clone(), reason);
        let mut limits = DecodeLimits::default();
        limits.max_points = most_triangles.saturating_mul(3);
        limits.max_faces = most_triangles;
        limits.max_decoded_bytes = self.files.bytes_left();
        let mut mesh = Mesh::new();
        MeshDecoder::new()
            .decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh)
            .map_err(|error| match error.kind() {
            ErrorKind::LimitExceeded => Error::limit(location.clone(), error.to_string()),
            _ => damaged(format!("its Draco stream cannot be decompressed: {error}")),
        })?;
        let mut unpacked = Vec::new();
        for &(accessor, id) in wanted {
            let attribute = u32::try_from(id).ok().and_then(|id| mesh.attribute_by_unique_id(id));
            let attribute = attribute
                .ok_or_else(|| damaged(format!("its Draco stream has no attribute {id}")))?;
            let found = match attribute.data_type() {
                DataType::Int8 => ComponentType::I8,
                DataType::Uint8 => ComponentType::U8,
                DataType::Int16 => ComponentType::I16,
                DataType::Uint16 => ComponentType::U16,
                DataType::Uint32 => ComponentType::U32,
                DataType::Float32 => ComponentType::F32,
                other => return Err(damaged(format!("its Draco stream has numbers {other:?}"))),
            };
            let described = &self.root.accessors[accessor];
            let components = usize::from(attribute.num_components());
            if component_type(described) != found || multiplicity(described) != components {
                let reason = "is not what its Draco stream holds";
                return Err(damaged(format!("accessor {accessor} {reason}")));
            }
            let size = components * found.size();
            let (data, stride) = (attribute.buffer().data(), attribute.byte_stride() as usize);
            let mut bytes = Vec::with_capacity(mesh.num_points() * size);
            for point in 0..mesh.num_points() as u32 {
                let start = attribute.mapped_index(PointIndex(point)).0 as usize;
                let value = start.checked_mul(stride).and_then(|start| data.get(start..));
                let value = value.and_then(|value| value.get(..size));
                let missing = || damaged("its Draco stream lacks values".to_owned());
                bytes.extend_from_slice(value.ok_or_else(missing)?);
            }
            unpacked.push((accessor, bytes));
        }
        if let Some(accessor) = indices {
            let size = component_type(&self.root.accessors[accessor]).size();
            if mesh.num_points() as u64 > 1 << (8 * size) {
                return Err(damaged(format!("the indices of accessor {accessor} are too short")));
            }
            let corners = mesh.faces().iter().flatten();
            let bytes = corners.flat_map(|point| point.0.to_le_bytes().into_iter().take(size));
            unpacked.push((accessor, bytes.collect()));
        }
        Ok(unpacked)
    }

    #[cfg(not(feature = "draco"))]
    fn decode_draco(
        &self,
        _: &[u8],
        _: &[(usize, u64)],
        _: Option<usize>,
        _: u64,
        location: &Location,
    ) -> Result<Vec<(usize, Vec<u8>)>, Error> {
        let reason = "it is compressed by Draco: the feature `draco` reads it, and \
                      `gltf-transform copy` decompresses it";
        Err(Error::damaged(location.clone(), reason))
    }
}

/// Numbers of an element.
#[cfg(feature = "draco")]
fn multiplicity(accessor: &gltf::json::Accessor) -> usize {
    match accessor.type_ {
        gltf::json::validation::Checked::Valid(kind) => kind.multiplicity(),
        gltf::json::validation::Checked::Invalid => 0,
    }
}
