//! Meshes from files: Wavefront OBJ, PLY, and Mitsuba's compressed format.

use super::super::obj::Geometry;
use super::super::{Error, ply};
use super::Loader;
use super::document::Element;
use super::values::Object;
use crate::scene::Mesh;
use flate2::read::ZlibDecoder;
use glam::{DAffine3, DVec2, DVec3};
use std::io::Read;

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
                let read = Geometry::read(&bytes, self.triangles_left, &self.limits);
                let limit = |reason| element.limit(format!("{}: {reason}", path.display()));
                let mut geometry = read.map_err(limit)?;
                std::mem::take(&mut geometry.faults).warn(&path, &mut self.warnings)?;
                Ok(geometry.into_mesh())
            }
            "ply" => ply::mesh(&bytes, self.triangles_left),
            _ => {
                let index = object.integer("shape_index")?.unwrap_or(0);
                let most = self.files.bytes_left();
                let mut read = 0;
                let mesh = serialized(&bytes, index, self.triangles_left, most, &mut read);
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

/// Magic number of Mitsuba's format.
const SERIALIZED: u16 = 0x041C;
/// Longest name of a mesh.
const LONGEST_NAME: usize = 1 << 16;

/// One mesh of a file in Mitsuba's format, versions 3 and 4, with triangles up to the first one too
/// many. `read` becomes the number of bytes that were decompressed, or of those that a mesh too
/// large would have taken.
///
/// Each mesh is a header and a zlib stream; at the file's end are the offsets of the meshes and
/// their number.
fn serialized(
    bytes: &[u8],
    index: i64,
    most_triangles: u64,
    most_bytes: u64,
    read: &mut u64,
) -> Result<Mesh, String> {
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
    let mesh = data.mesh(version, most_triangles);
    *read = most_bytes - data.reader.limit();
    mesh
}

/// A decompressed mesh.
struct Stream<'a> {
    reader: std::io::Take<ZlibDecoder<&'a [u8]>>,
    double: bool,
}

impl Stream<'_> {
    fn mesh(&mut self, version: u16, most_triangles: u64) -> Result<Mesh, String> {
        let flags = u32::from_le_bytes(self.bytes()?);
        // Files without a flag of precision are of single precision.
        self.double = flags & 0x2000 != 0;
        if version == 4 {
            let mut name = (0..LONGEST_NAME).map(|_| self.bytes::<1>());
            name.find(|byte| !matches!(byte, Ok([byte]) if *byte != 0))
                .ok_or("the mesh has a name that does not end")??;
        }
        let (vertices, triangles) =
            (u64::from_le_bytes(self.bytes()?), u64::from_le_bytes(self.bytes()?));
        // A small file may hold gigabytes: better not begun than cut off.
        let vectors = 3 + [(1, 3), (2, 2), (8, 3)]
            .map(|(flag, n)| u64::from(flags & flag != 0) * n)
            .iter()
            .sum::<u64>();
        let number = if self.double { 8 } else { 4 };
        let size = vertices.saturating_mul(vectors * number);
        if size.saturating_add(triangles.saturating_mul(12)) > self.reader.limit() {
            self.reader.set_limit(0);
            return Err("the mesh has more bytes than the limit admits".to_owned());
        }
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
        for _ in 0..triangles.min(most_triangles.saturating_add(1)) {
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
