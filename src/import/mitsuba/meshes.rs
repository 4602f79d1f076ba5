//! Meshes from files: Wavefront OBJ, PLY, and Mitsuba's compressed format.

use super::super::Error;
use super::Loader;
use super::document::Element;
use super::values::Object;
use crate::scene::Mesh;
use flate2::read::ZlibDecoder;
use glam::{DAffine3, DVec2, DVec3, DVec4};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::io::{Cursor, Read};

impl<'a> Loader<'a> {
    /// The mesh of a shape, in world space.
    pub(super) fn mesh_file(
        &mut self,
        object: &Object<'a>,
        to_world: &DAffine3,
        flip: bool,
    ) -> Result<Mesh, Error> {
        let element = object.element;
        let kind = element.kind();
        let face_normals = object.boolean("face_normals")?.unwrap_or(false);
        let flip_uvs = object.boolean("flip_tex_coords")?.unwrap_or(kind == "obj");
        let name =
            object.string("filename")?.ok_or_else(|| element.error("the filename is missing"))?;
        let (path, bytes) = self.files.read(name, element.location())?;
        let parsed = match kind {
            "obj" => {
                let corners = corners(&bytes);
                if corners > self.triangles_left.saturating_mul(3) {
                    return Err(element.limit(format!(
                        "{}: its {corners} corners make more triangles than the limit admits",
                        path.display()
                    )));
                }
                obj(&bytes)
            }
            "ply" => ply(&bytes, self.triangles_left),
            _ => {
                let index = object.integer("shape_index")?.unwrap_or(0);
                let most = self.files.bytes_left();
                let mut read = 0;
                let mesh = serialized(&bytes, index, most, &mut read);
                // A mesh that was cut off there has at least one byte more.
                let more = u64::from(mesh.is_err() && read == most);
                self.files.spend(read + more, element.location())?;
                mesh
            }
        };
        let mut mesh =
            parsed.map_err(|reason| element.error(format!("{}: {reason}", path.display())))?;
        let left = self.triangles_left.checked_sub(mesh.indices.len() as u64);
        self.triangles_left = left
            .ok_or_else(|| element.limit("the meshes have more triangles than the limit admits"))?;
        check(element, &mesh)?;
        if face_normals {
            mesh.normals = None;
        }
        if !self.asks_for_colors {
            mesh.colors = None;
        }
        if flip_uvs {
            mesh.uvs.iter_mut().flatten().for_each(|uv| uv.y = 1.0 - uv.y);
        }
        let mut mesh = placed(mesh, to_world, flip);
        if !face_normals && mesh.normals.is_none() {
            mesh.normals = Some(smooth_normals(&mesh));
        }
        Ok(mesh)
    }
}

/// Checks indices, before they are used.
fn check(element: &Element, mesh: &Mesh) -> Result<(), Error> {
    let count = mesh.positions.len();
    match mesh.indices.iter().flatten().find(|&&index| index as usize >= count) {
        Some(index) => {
            Err(element.error(format!("a triangle refers to vertex {index} of {count}")))
        }
        None => Ok(()),
    }
}

/// The mesh in world space. Triangles are turned so that their front is where their normals point;
/// without normals the winding is kept, so that a mirroring transform turns the mesh inside out.
pub(super) fn placed(mesh: Mesh, to_world: &DAffine3, flip: bool) -> Mesh {
    let Mesh { mut positions, mut normals, uvs, mut indices, .. } = mesh;
    positions.iter_mut().for_each(|p| *p = to_world.transform_point3(*p));
    let matrix = to_world.matrix3;
    // The cofactors: the inverse transpose times the determinant.
    let [x, y, z] = [
        matrix.y_axis.cross(matrix.z_axis),
        matrix.z_axis.cross(matrix.x_axis),
        matrix.x_axis.cross(matrix.y_axis),
    ];
    let sign = if (matrix.determinant() < 0.0) != flip { -1.0 } else { 1.0 };
    normals.iter_mut().flatten().for_each(|n| *n = (x * n.x + y * n.y + z * n.z) * sign);
    for triangle in &mut indices {
        let [a, b, c] = triangle.map(|i| i as usize);
        let outside = match &normals {
            Some(normals) => {
                let cross = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
                (normals[a] + normals[b] + normals[c]).dot(cross) >= 0.0
            }
            None => !flip,
        };
        if !outside {
            triangle.swap(1, 2);
        }
    }
    Mesh { positions, normals, uvs, indices, ..mesh }
}

/// Normals of vertices: those of their triangles, weighted by the triangles' angles there (Thürmer
/// and Wüthrich 1998).
fn smooth_normals(mesh: &Mesh) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.indices {
        let p = triangle.map(|i| mesh.positions[i as usize]);
        let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { continue };
        for i in 0..3 {
            let (a, b) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            normals[triangle[i] as usize] += normal * a.angle_between(b);
        }
    }
    // A vertex of no triangle, or of two that cancel, is never interpolated to something useful;
    // any direction will do.
    normals.iter_mut().for_each(|normal| *normal = normal.try_normalize().unwrap_or(DVec3::Z));
    normals
}

fn vectors<const N: usize>(values: &[f32]) -> Vec<[f64; N]> {
    values.as_chunks::<N>().0.iter().map(|v| v.map(f64::from)).collect()
}

/// The number of corners of all faces in an OBJ file. The parser takes much more memory for them
/// than the file; triangles have three, and other polygons fewer for each triangle that they
/// become.
fn corners(bytes: &[u8]) -> u64 {
    let faces = bytes
        .split(|byte| *byte == b'\n')
        .filter(|line| matches!(line.trim_ascii_start().first(), Some(b'f' | b'l' | b'p')));
    faces
        .map(|line| {
            line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count() as u64 - 1
        })
        .sum()
}

fn obj(bytes: &[u8]) -> Result<Mesh, String> {
    let options =
        tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, |_| {
        Ok((Vec::new(), Default::default()))
    })
    .map_err(|e| e.to_string())?;
    let mut mesh = Mesh::default();
    let all = |has: fn(&tobj::Mesh) -> bool| {
        models.iter().filter(|model| !model.mesh.indices.is_empty()).all(|model| has(&model.mesh))
    };
    let mut normals = all(|mesh| !mesh.normals.is_empty()).then(Vec::new);
    let mut uvs = all(|mesh| !mesh.texcoords.is_empty()).then(Vec::new);
    for model in models.iter().filter(|model| !model.mesh.indices.is_empty()) {
        let part = &model.mesh;
        let first =
            u32::try_from(mesh.positions.len()).map_err(|_| "there are too many vertices")?;
        mesh.positions.extend(vectors(&part.positions).into_iter().map(DVec3::from_array));
        if let Some(normals) = &mut normals {
            normals.extend(vectors(&part.normals).into_iter().map(DVec3::from_array));
        }
        if let Some(uvs) = &mut uvs {
            uvs.extend(vectors(&part.texcoords).into_iter().map(DVec2::from_array));
        }
        for triangle in part.indices.as_chunks::<3>().0 {
            let shifted = triangle.map(|i| i.checked_add(first));
            let [Some(a), Some(b), Some(c)] = shifted else {
                return Err("there are too many vertices".to_owned());
            };
            mesh.indices.push([a, b, c]);
        }
    }
    let count = mesh.positions.len();
    Ok(Mesh {
        normals: normals.filter(|n| n.len() == count && count > 0),
        uvs: uvs.filter(|uv| uv.len() == count && count > 0),
        ..mesh
    })
}

/// A vertex of a PLY file: x, y, z, nx, ny, nz, u, v, red, green, blue, and which of them the file
/// gives.
#[derive(Default)]
struct PlyVertex {
    values: [f64; 11],
    known: u16,
}

#[derive(Default)]
struct PlyFace {
    vertices: Vec<u32>,
}

struct Skipped;

impl PropertyAccess for PlyVertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let index = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            "nx" => 3,
            "ny" => 4,
            "nz" => 5,
            "u" | "s" | "texture_u" | "texture_s" => 6,
            "v" | "t" | "texture_v" | "texture_t" => 7,
            "r" | "red" | "color_0" => 8,
            "g" | "green" | "color_1" => 9,
            "b" | "blue" | "color_2" => 10,
            _ => return PropertyAccessResult::Ignored,
        };
        let value = match property {
            Property::Float(value) => f64::from(value),
            Property::Double(value) => value,
            Property::UChar(value) if index >= 8 => f64::from(value) / 255.0,
            _ if index >= 8 => return PropertyAccessResult::Ignored,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        self.values[index] = value;
        self.known |= 1 << index;
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for PlyFace {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        match property.to_u32_list() {
            Some(vertices) => {
                self.vertices = vertices;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// The mesh of a PLY file, with triangles up to the first one too many.
fn ply(bytes: &[u8], most_triangles: u64) -> Result<Mesh, String> {
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|e| e.to_string())?;
    let mut mesh = Mesh::default();
    let (mut normals, mut uvs) = (Vec::new(), Vec::new());
    let (mut with_normals, mut with_uvs) = (true, true);
    let mut colors = Vec::new();
    for (name, definition) in &header.elements {
        // Each element takes a byte at least; more of them, or elements of nothing, would never
        // end.
        if definition.count > bytes.len()
            || (definition.properties.is_empty() && definition.count > 0)
        {
            return Err(format!("{} elements {name} do not fit into the file", definition.count));
        }
        match name.as_str() {
            "vertex" => {
                for vertex in Parser::<PlyVertex>::new()
                    .read_payload_for_element(&mut reader, definition, &header)
                    .map_err(|e| e.to_string())?
                {
                    let [x, y, z, nx, ny, nz, u, v, r, g, b] = vertex.values;
                    if vertex.known & 7 != 7 {
                        return Err("a vertex lacks x, y or z".to_owned());
                    }
                    mesh.positions.push(DVec3::new(x, y, z));
                    with_normals &= vertex.known & 0b11_1000 == 0b11_1000;
                    with_uvs &= vertex.known & 0b1100_0000 == 0b1100_0000;
                    normals.push(DVec3::new(nx, ny, nz));
                    uvs.push(DVec2::new(u, v));
                    if vertex.known >> 8 == 0b111 && r.is_finite() && g.is_finite() && b.is_finite()
                    {
                        colors.push(DVec4::new(r, g, b, 1.0));
                    }
                }
            }
            "face" => {
                for face in Parser::<PlyFace>::new()
                    .read_payload_for_element(&mut reader, definition, &header)
                    .map_err(|e| e.to_string())?
                {
                    let [first, rest @ ..] = &face.vertices[..] else {
                        return Err("a face has no vertices".to_owned());
                    };
                    mesh.indices.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
                    if mesh.indices.len() as u64 > most_triangles {
                        break;
                    }
                }
            }
            _ => {
                Parser::<Skipped>::new()
                    .read_payload_for_element(&mut reader, definition, &header)
                    .map_err(|e| e.to_string())?;
            }
        }
    }
    let any = !mesh.positions.is_empty();
    let with_colors = any && colors.len() == mesh.positions.len();
    Ok(Mesh {
        colors: with_colors.then_some(colors),
        normals: (any && with_normals).then_some(normals),
        uvs: (any && with_uvs).then_some(uvs),
        ..mesh
    })
}

/// Magic number of Mitsuba's format.
const SERIALIZED: u16 = 0x041C;

/// One mesh of a file in Mitsuba's format, versions 3 and 4. `read` becomes the number of bytes
/// that were decompressed.
///
/// Each mesh is a header and a zlib stream; at the file's end are the offsets of the meshes and
/// their number.
fn serialized(bytes: &[u8], index: i64, most_bytes: u64, read: &mut u64) -> Result<Mesh, String> {
    let end = || "the file ends too early".to_owned();
    let at = |offset: usize, length: usize| {
        bytes.get(offset..).and_then(|rest| rest.get(..length)).ok_or_else(end)
    };
    let short = |offset: usize| at(offset, 2).map(|b| u16::from_le_bytes([b[0], b[1]]));
    let number = |offset: usize, length: usize| {
        at(offset, length).map(|b| b.iter().rev().fold(0u64, |n, byte| n << 8 | u64::from(*byte)))
    };
    let (magic, version) = (short(0)?, short(2)?);
    if magic != SERIALIZED || !matches!(version, 3 | 4) {
        return Err("this is not a serialized mesh of version 3 or 4".to_owned());
    }
    let count = number(bytes.len().checked_sub(4).ok_or_else(end)?, 4)?;
    let index = u64::try_from(index)
        .ok()
        .filter(|index| *index < count)
        .ok_or_else(|| format!("there is no shape {index}; there are {count}"))?;
    let width = if version == 4 { 8 } else { 4 };
    let from_end = 4 + (count - index).saturating_mul(width);
    let entry = (bytes.len() as u64).checked_sub(from_end).ok_or_else(end)?;
    let offset = usize::try_from(number(entry as usize, width as usize)?).map_err(|_| end())?;
    if short(offset)? != SERIALIZED {
        return Err(format!("there is no mesh at the place of shape {index}"));
    }
    let stream = bytes.get(offset.saturating_add(4)..).ok_or_else(end)?;
    let mut data = Stream { reader: ZlibDecoder::new(stream).take(most_bytes), double: false };
    let mesh = data.mesh(version);
    *read = most_bytes - data.reader.limit();
    mesh
}

/// A decompressed mesh.
struct Stream<'a> {
    reader: std::io::Take<ZlibDecoder<&'a [u8]>>,
    double: bool,
}

impl Stream<'_> {
    fn mesh(&mut self, version: u16) -> Result<Mesh, String> {
        let flags = u32::from_le_bytes(self.bytes()?);
        // Files without a flag of precision are of single precision.
        self.double = flags & 0x2000 != 0;
        // The name.
        while version == 4 && self.bytes::<1>()? != [0] {}
        let (vertices, triangles) =
            (u64::from_le_bytes(self.bytes()?), u64::from_le_bytes(self.bytes()?));
        let positions = self.vectors::<3>(vertices)?.into_iter().map(DVec3::from_array).collect();
        let normals = if flags & 1 != 0 {
            Some(self.vectors::<3>(vertices)?.into_iter().map(DVec3::from_array).collect())
        } else {
            None
        };
        let uvs = if flags & 2 != 0 {
            Some(self.vectors::<2>(vertices)?.into_iter().map(DVec2::from_array).collect())
        } else {
            None
        };
        if flags & 8 != 0 {
            self.vectors::<3>(vertices)?;
        }
        if vertices > u64::from(u32::MAX) {
            return Err("there are too many vertices".to_owned());
        }
        let mut indices = Vec::new();
        for _ in 0..triangles {
            let triangle = [self.bytes()?, self.bytes()?, self.bytes()?];
            indices.push(triangle.map(u32::from_le_bytes));
        }
        Ok(Mesh { positions, normals, uvs, indices, ..Mesh::default() })
    }

    /// Vectors of a file, in memory that grows as they are read: the count alone takes none.
    fn vectors<const N: usize>(&mut self, count: u64) -> Result<Vec<[f64; N]>, String> {
        let mut vectors = Vec::new();
        for _ in 0..count {
            let mut vector = [0.0; N];
            for value in &mut vector {
                *value = if self.double {
                    f64::from_le_bytes(self.bytes()?)
                } else {
                    f64::from(f32::from_le_bytes(self.bytes()?))
                };
            }
            vectors.push(vector);
        }
        Ok(vectors)
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.reader
            .read_exact(&mut bytes)
            .map_err(|error| format!("the mesh ends too early: {error}"))?;
        Ok(bytes)
    }
}
