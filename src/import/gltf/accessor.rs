//! Numbers from buffers: every offset, stride and count is checked against the bytes that are
//! there.

use super::document::Document;
use crate::import::{Error, Location};
use gltf::json::Accessor;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

impl Document {
    /// An accessor of `N` numbers per element, 16 for matrices. Normalised integers are in [0, 1] or [-1, 1].
    pub fn vectors<const N: usize>(
        &self,
        index: usize,
        budget: &mut Budget,
    ) -> Result<Vec<[f64; N]>, Error> {
        let expected = match N {
            1 => Type::Scalar,
            2 => Type::Vec2,
            3 => Type::Vec3,
            4 => Type::Vec4,
            _ => Type::Mat4,
        };
        let accessor = &self.root.accessors[index];
        let (component, size) = (component_type(accessor), component_type(accessor).size());
        let decode = |bytes: &[u8]| {
            std::array::from_fn(|k| number(&bytes[k * size..], component, accessor.normalized))
        };
        self.elements(index, expected, [0.0; N], decode, budget)
    }

    /// An accessor of whole numbers.
    pub fn indices(&self, index: usize, budget: &mut Budget) -> Result<Vec<u32>, Error> {
        let accessor = &self.root.accessors[index];
        let component = component_type(accessor);
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(Error::new(
                self.accessor_location(index),
                "indices must be unsigned whole numbers",
            ));
        }
        self.elements(index, Type::Scalar, 0, |bytes| whole(bytes, component), budget)
    }

    fn elements<T: Copy>(
        &self,
        index: usize,
        expected: Type,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
        budget: &mut Budget,
    ) -> Result<Vec<T>, Error> {
        let accessor = &self.root.accessors[index];
        let location = self.accessor_location(index);
        let refuse = |reason: String| Error::new(location.clone(), reason);
        match accessor.type_ {
            Checked::Valid(kind) if kind == expected => (),
            Checked::Valid(kind) => {
                return Err(refuse(format!("{expected:?} is needed, but it is {kind:?}")));
            }
            Checked::Invalid => return Err(refuse(format!("{expected:?} is needed"))),
        }
        let size = component_type(accessor).size() * expected.multiplicity();
        if let Some(bytes) = self.decoded.get(&index) {
            let elements = bytes.chunks_exact(size);
            budget
                .spend(elements.len() as u64, false)
                .map_err(|reason| Error::limit(location.clone(), reason))?;
            return Ok(elements.map(decode).collect());
        }
        let count = accessor.count.0;
        budget
            .spend(count, accessor.buffer_view.is_none())
            .map_err(|reason| Error::limit(location.clone(), reason))?;
        let mut elements = match accessor.buffer_view {
            None => vec![zero; count as usize],
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                self.slices(view.value(), offset, count, size, &location)?.map(&decode).collect()
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let Checked::Valid(kind) = sparse.indices.component_type else {
                return Err(refuse("unknown type of sparse indices".to_owned()));
            };
            if sparse.count.0 > count {
                return Err(refuse(format!(
                    "{} sparse values for {count} elements",
                    sparse.count.0
                )));
            }
            let places = self.slices(
                sparse.indices.buffer_view.value(),
                sparse.indices.byte_offset.0,
                sparse.count.0,
                kind.0.size(),
                &location,
            )?;
            let values = self.slices(
                sparse.values.buffer_view.value(),
                sparse.values.byte_offset.0,
                sparse.count.0,
                size,
                &location,
            )?;
            for (place, value) in places.zip(values) {
                let place = whole(place, kind.0);
                let element = elements.get_mut(place as usize);
                *element.ok_or_else(|| {
                    refuse(format!("a sparse value for element {place} of {count}"))
                })? = decode(value);
            }
        }
        Ok(elements)
    }

    /// The bytes of each of `count` elements of `size` bytes.
    fn slices(
        &self,
        view: usize,
        offset: u64,
        count: u64,
        size: usize,
        location: &Location,
    ) -> Result<impl Iterator<Item = &[u8]>, Error> {
        let bytes = self.view(view, location)?;
        let stride = self.root.buffer_views[view].byte_stride.map_or(size, |stride| stride.0);
        let needed = match count.checked_sub(1) {
            None => Some(0),
            Some(before) => before
                .checked_mul(stride as u64)
                .and_then(|start| start.checked_add(offset)?.checked_add(size as u64)),
        };
        if stride < size || needed.is_none_or(|needed| needed > bytes.len() as u64) {
            let reason = format!(
                "{count} elements of {size} bytes, one each {stride} bytes from byte {offset}, do not fit in the {} bytes of buffer view {view}",
                bytes.len()
            );
            return Err(Error::new(location.clone(), reason));
        }
        Ok((0..count as usize).map(move |k| &bytes[offset as usize + k * stride..][..size]))
    }

    pub fn accessor_location(&self, index: usize) -> Location {
        self.location(format!("accessor {index}"), self.root.accessors[index].name.as_ref())
    }
}

/// The budget of numbers that may still be read.
pub(super) struct Budget {
    /// Elements of accessors.
    elements: u64,
    /// Those that are zero because no bytes stand for them.
    zeros: u64,
}

impl Budget {
    pub fn new(document: &Document) -> Self {
        // Three vertices with four attributes for each triangle.
        Self {
            elements: document.limits.triangles.saturating_mul(12),
            zeros: document.limits.elements,
        }
    }

    fn spend(&mut self, count: u64, zeros: bool) -> Result<(), String> {
        let left = if zeros { self.elements.min(self.zeros) } else { self.elements };
        if count > left {
            return Err(format!("{count} elements exceed the limits, which leave {left}"));
        }
        self.elements -= count;
        self.zeros -= if zeros { count } else { 0 };
        Ok(())
    }
}

pub(super) fn component_type(accessor: &Accessor) -> ComponentType {
    match &accessor.component_type {
        Checked::Valid(kind) => kind.0,
        // The document has been validated.
        Checked::Invalid => ComponentType::U8,
    }
}

fn whole(bytes: &[u8], kind: ComponentType) -> u32 {
    match kind {
        ComponentType::I8 | ComponentType::U8 => u32::from(bytes[0]),
        ComponentType::I16 | ComponentType::U16 => {
            u32::from(u16::from_le_bytes([bytes[0], bytes[1]]))
        }
        ComponentType::U32 | ComponentType::F32 => {
            u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
        }
    }
}

fn number(bytes: &[u8], kind: ComponentType, normalized: bool) -> f64 {
    let bits = whole(bytes, kind);
    let (value, greatest) = match kind {
        ComponentType::F32 => return f64::from(f32::from_bits(bits)),
        ComponentType::I8 => (f64::from(bits as u8 as i8), 127.0),
        ComponentType::U8 => (f64::from(bits), 255.0),
        ComponentType::I16 => (f64::from(bits as u16 as i16), 32767.0),
        ComponentType::U16 => (f64::from(bits), 65535.0),
        ComponentType::U32 => (f64::from(bits), f64::from(u32::MAX)),
    };
    if normalized { (value / greatest).max(-1.0) } else { value }
}
