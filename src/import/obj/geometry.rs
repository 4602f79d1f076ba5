//! Vertices and faces of Wavefront OBJ files, as triangles.

use super::polygon::triangulate;
use super::statements::{self, Faults, words};
use crate::import::Limits;
use crate::scene::Mesh;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// In place of an index that is not given.
const NONE: u32 = u32::MAX;
/// Vertices that a position may have before they are not compared any more.
const MOST_COMPARED: usize = 64;

const NO_POSITION: &str = "a triangle has a vertex that is not there or not finite: it is left out";
const NO_UV: &str = "texture coordinates that are not there or not finite: they are 0";
const NO_NORMAL: &str = "a normal that is not there, zero or not finite: it is that of the face";

/// The vertices and triangles of a file. Numbers are those of the file, in single precision.
#[derive(Debug, Default)]
pub(crate) struct Geometry {
    pub parts: Vec<Part>,
    /// Files of materials, with the line that names them.
    pub libraries: Vec<(String, u32)>,
    pub faults: Faults,
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
}

/// The triangles of a group that have one material.
#[derive(Debug)]
pub(crate) struct Part {
    /// The latest object or group.
    pub name: Option<String>,
    pub material: Option<String>,
    /// The line of its first face.
    pub line: u32,
    triangles: Vec<Triangle>,
}

#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [Corner; 3],
    /// Faces of one group, if it is not 0, are smooth where they share a vertex.
    smoothing: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Corner {
    position: u32,
    uv: u32,
    normal: u32,
}

/// More of something than the limits admit, as a part of a sentence.
type TooMany = String;

impl Geometry {
    /// Reads a file with at most `triangles`; everything that makes no sense is left out.
    pub fn read(bytes: &[u8], triangles: u64, limits: &Limits) -> Result<Self, TooMany> {
        let mut reader = Reader {
            geometry: Self::default(),
            parts: HashMap::new(),
            name: None,
            material: None,
            part: None,
            smoothing: 0,
            corners: Vec::new(),
            triangles_left: triangles,
            most_parts: limits.elements,
        };
        statements::for_each(bytes, |line, keyword, rest| reader.statement(line, keyword, rest))?;
        let mut geometry = reader.geometry;
        geometry.check();
        Ok(geometry)
    }

    /// Takes out indices of what is not there or not finite.
    fn check(&mut self) {
        let Self { parts, faults, positions, uvs, normals, .. } = self;
        let finite = |values: &[f32]| values.iter().all(|value| value.is_finite());
        let exists = |i: u32| positions.get(i as usize).is_some_and(|p| finite(p));
        let has_uv = |i: u32| i == NONE || uvs.get(i as usize).is_some_and(|uv| finite(uv));
        let has_normal = |i: u32| {
            i == NONE || normals.get(i as usize).is_some_and(|n| finite(n) && *n != [0.0; 3])
        };
        for part in parts.iter_mut() {
            let line = part.line;
            part.triangles.retain_mut(|triangle| {
                let is_whole = triangle.corners.iter().all(|corner| exists(corner.position));
                if !is_whole {
                    faults.add(line, NO_POSITION);
                }
                for corner in &mut triangle.corners {
                    if !has_uv(corner.uv) {
                        corner.uv = NONE;
                        faults.add(line, NO_UV);
                    }
                    if !has_normal(corner.normal) {
                        corner.normal = NONE;
                        faults.add(line, NO_NORMAL);
                    }
                }
                is_whole
            });
        }
        parts.retain(|part| !part.triangles.is_empty());
    }

    /// Gives normals to corners that have none: by their smoothing group the mean of its faces
    /// there, weighted by their angles (Thürmer and Wüthrich 1998); without one that of their face,
    /// if others of the part have normals.
    pub fn shade(&mut self) {
        let Self { parts, positions, normals, .. } = self;
        let point = |corner: Corner| point(positions, corner.position);
        let across = |[a, b, c]: [Corner; 3]| {
            (point(b) - point(a)).cross(point(c) - point(a)).normalize_or_zero()
        };
        let mut sums: HashMap<(u32, u32), DVec3> = HashMap::new();
        for triangle in parts.iter().flat_map(|part| &part.triangles) {
            let Triangle { corners, smoothing } = *triangle;
            let is_smooth = |corner: &Corner| smoothing != 0 && corner.normal == NONE;
            if !corners.iter().any(is_smooth) {
                continue;
            }
            for k in 0..3 {
                let [p, q, r] = [0, 1, 2].map(|i| point(corners[(k + i) % 3]));
                let angle = (q - p).angle_between(r - p);
                if angle.is_finite() {
                    *sums.entry((corners[k].position, smoothing)).or_default() +=
                        across(corners) * angle;
                }
            }
        }
        let mut made: HashMap<(u32, u32), u32> = HashMap::new();
        let mut add = |normal: DVec3| {
            normals.push(normal.as_vec3().to_array());
            (normals.len() - 1) as u32
        };
        for part in parts {
            let has_normal = |corner: &Corner| corner.normal != NONE;
            let corners = || part.triangles.iter().flat_map(|triangle| &triangle.corners);
            if part.triangles.iter().all(|t| t.smoothing == 0) && !corners().any(has_normal) {
                continue;
            }
            for Triangle { corners, smoothing } in &mut part.triangles {
                let flat = across(*corners).try_normalize().unwrap_or(DVec3::Z);
                for corner in corners.iter_mut().filter(|corner| corner.normal == NONE) {
                    let key = (corner.position, *smoothing);
                    let smooth = sums.get(&key).and_then(|sum| sum.try_normalize());
                    corner.normal = match smooth {
                        Some(normal) => *made.entry(key).or_insert_with(|| add(normal)),
                        None => add(flat),
                    };
                }
            }
        }
    }

    /// The meshes of the parts, and of each how many corners have no texture coordinates, which are
    /// 0 there if others have some. A mesh has normals if all of its corners have.
    pub fn meshes(&self) -> impl Iterator<Item = (&Part, Mesh, usize)> {
        let mut vertices = Vertices::new(self);
        self.parts.iter().map(move |part| {
            let (mesh, bare) = vertices.mesh(&part.triangles);
            (part, mesh, bare)
        })
    }

    /// All triangles as one mesh, with normals if all corners have some, and with texture
    /// coordinates if all corners have some.
    #[cfg(feature = "mitsuba")]
    pub fn into_mesh(self) -> Mesh {
        let triangles = || self.parts.iter().flat_map(|part| &part.triangles);
        let (mesh, bare) = Vertices::new(&self).mesh(triangles());
        Mesh { uvs: mesh.uvs.filter(|_| bare == 0), ..mesh }
    }
}

fn point(positions: &[[f32; 3]], index: u32) -> DVec3 {
    DVec3::from_array(positions[index as usize].map(f64::from))
}

/// Makes vertices of corners, one of those that are the same.
struct Vertices<'a> {
    geometry: &'a Geometry,
    /// The latest vertex of each position.
    latest: Vec<u32>,
}

impl<'a> Vertices<'a> {
    fn new(geometry: &'a Geometry) -> Self {
        Self { geometry, latest: vec![NONE; geometry.positions.len()] }
    }

    fn mesh<'b>(&mut self, triangles: impl IntoIterator<Item = &'b Triangle>) -> (Mesh, usize) {
        // The corner of each vertex, and the vertex of the same position before it.
        let mut vertices: Vec<(Corner, u32)> = Vec::new();
        let indices = triangles
            .into_iter()
            .map(|triangle| triangle.corners.map(|corner| self.vertex(&mut vertices, corner)))
            .collect();
        for (corner, _) in &vertices {
            self.latest[corner.position as usize] = NONE;
        }
        let Geometry { positions, normals, uvs, .. } = self.geometry;
        let corners = || vertices.iter().map(|(corner, _)| corner);
        let bare = corners().filter(|corner| corner.uv == NONE).count();
        let uv = |corner: &Corner| {
            uvs.get(corner.uv as usize).map_or(DVec2::ZERO, |uv| DVec2::from(uv.map(f64::from)))
        };
        let mesh = Mesh {
            positions: corners().map(|corner| point(positions, corner.position)).collect(),
            normals: corners()
                .map(|corner| {
                    Some(DVec3::from(normals.get(corner.normal as usize)?.map(f64::from)))
                })
                .collect(),
            uvs: (bare < vertices.len()).then(|| corners().map(uv).collect()),
            indices,
            ..Mesh::default()
        };
        (mesh, bare)
    }

    fn vertex(&mut self, vertices: &mut Vec<(Corner, u32)>, corner: Corner) -> u32 {
        let latest = &mut self.latest[corner.position as usize];
        let mut index = *latest;
        for _ in 0..MOST_COMPARED {
            let Some(&(other, before)) = vertices.get(index as usize) else { break };
            if other == corner {
                return index;
            }
            index = before;
        }
        vertices.push((corner, *latest));
        *latest = (vertices.len() - 1) as u32;
        *latest
    }
}

struct Reader {
    geometry: Geometry,
    /// Parts by name and material.
    parts: HashMap<(Option<String>, Option<String>), usize>,
    name: Option<String>,
    material: Option<String>,
    /// The part of these two, once it has a face.
    part: Option<usize>,
    smoothing: u32,
    /// The corners of a face.
    corners: Vec<Corner>,
    triangles_left: u64,
    most_parts: u64,
}

impl Reader {
    fn statement(&mut self, line: u32, keyword: &[u8], rest: &[u8]) -> Result<(), TooMany> {
        let text = || Some(String::from_utf8_lossy(rest).trim_ascii_end().to_owned());
        let faults = &mut self.geometry.faults;
        match keyword {
            b"v" => {
                let mut words = words(rest);
                let position = vector(&mut words);
                if position.is_none() {
                    faults.add(line, "a vertex without three numbers: its faces are left out");
                }
                // One number more is a weight for curves.
                if words.count() >= 3 {
                    faults.add(line, "colours of vertices are left out");
                }
                self.geometry.positions.push(position.unwrap_or([f32::NAN; 3]));
            }
            b"vn" => {
                let normal = vector(&mut words(rest));
                self.geometry.normals.push(normal.unwrap_or_default());
            }
            b"vt" => {
                // The second one may be missing, a third one is for textures in space.
                let mut numbers = words(rest).map_while(statements::number);
                let uv = [numbers.next().unwrap_or(f32::NAN), numbers.next().unwrap_or(0.0)];
                self.geometry.uvs.push(uv);
            }
            b"f" => self.face(line, rest)?,
            b"o" | b"g" => (self.name, self.part) = (text().filter(|n| !n.is_empty()), None),
            b"usemtl" => (self.material, self.part) = (text(), None),
            b"s" => {
                let group = words(rest).next().and_then(|word| std::str::from_utf8(word).ok());
                self.smoothing = match group {
                    Some("on") => 1,
                    group => group.and_then(|group| group.parse().ok()).unwrap_or(0),
                };
            }
            b"mtllib" => self.geometry.libraries.extend(text().map(|name| (name, line))),
            b"l" | b"p" => faults.add(line, "lines and points have no area: they are left out"),
            other => {
                // A file of something else has a keyword in each line.
                let other = String::from_utf8_lossy(other.get(..16).unwrap_or(other));
                faults.add(
                    line,
                    &format!("the statement \"{other}\" is not supported, and left out"),
                );
            }
        }
        Ok(())
    }

    fn face(&mut self, line: u32, rest: &[u8]) -> Result<(), TooMany> {
        let geometry = &mut self.geometry;
        let counts = [geometry.positions.len(), geometry.uvs.len(), geometry.normals.len()];
        self.corners.clear();
        for word in words(rest) {
            let Some(corner) = corner(word, counts) else {
                geometry.faults.add(line, "a face that is not made of vertices: it is left out");
                return Ok(());
            };
            self.corners.push(corner);
            if self.corners.len() as u64 > self.triangles_left.saturating_add(2) {
                return Err("it has more triangles than the limit admits".to_owned());
            }
        }
        if self.corners.len() < 3 {
            geometry.faults.add(line, "a face of less than three vertices: it is left out");
            return Ok(());
        }
        let Some(part) = self.part(line) else {
            return Err("it has more groups and materials than the limit admits".to_owned());
        };
        self.triangles_left -= self.corners.len() as u64 - 2;
        let Geometry { parts, positions, faults, .. } = &mut self.geometry;
        let (corners, smoothing) = (&self.corners, self.smoothing);
        let triangles = &mut parts[part].triangles;
        if let [a, b, c] = corners[..] {
            triangles.push(Triangle { corners: [a, b, c], smoothing });
            return Ok(());
        }
        // Those that are not there are found later.
        let place = |corner: &Corner| {
            positions
                .get(corner.position as usize)
                .map_or(DVec3::ZERO, |_| point(positions, corner.position))
        };
        let places: Vec<DVec3> = corners.iter().map(place).collect();
        let is_right = triangulate(&places, |triangle| {
            triangles.push(Triangle { corners: triangle.map(|k| corners[k]), smoothing });
        });
        if !is_right {
            faults.add(
                line,
                "a polygon that bends inwards has too many corners: it is shown as a fan",
            );
        }
        Ok(())
    }

    /// The part that faces belong to; `None` if it is one too many.
    fn part(&mut self, line: u32) -> Option<usize> {
        if self.part.is_none() {
            let parts = &mut self.geometry.parts;
            let key = (self.name.clone(), self.material.clone());
            let number = *self.parts.entry(key).or_insert(parts.len());
            if number == parts.len() {
                if number as u64 >= self.most_parts {
                    return None;
                }
                let (name, material) = (self.name.clone(), self.material.clone());
                parts.push(Part { name, material, line, triangles: Vec::new() });
            }
            self.part = Some(number);
        }
        self.part
    }
}

fn vector<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<[f32; 3]> {
    let mut next = || statements::number(words.next()?);
    Some([next()?, next()?, next()?])
}

/// A corner v, v/vt, v//vn or v/vt/vn; `None` if it is something else. Indices count from 1, or
/// back from the latest of the `counts`.
fn corner(word: &[u8], counts: [usize; 3]) -> Option<Corner> {
    let mut indices = [NONE; 3];
    let mut parts = word.split(|byte| *byte == b'/');
    for ((index, count), k) in indices.iter_mut().zip(counts).zip(0..) {
        *index = match parts.next() {
            None | Some([]) if k > 0 => NONE,
            part => whole(part?, count)?,
        };
    }
    let [position, uv, normal] = indices;
    parts.next().is_none().then_some(Corner { position, uv, normal })
}

fn whole(digits: &[u8], count: usize) -> Option<u32> {
    let (back, digits) = match digits {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let value = digits.iter().try_fold(0u32, |value, byte| {
        let digit = byte.wrapping_sub(b'0');
        value.checked_mul(10)?.checked_add(u32::from(digit)).filter(|_| digit < 10)
    })?;
    let index =
        if back { u32::try_from(count).ok()?.checked_sub(value)? } else { value.checked_sub(1)? };
    // "-0" would be the next one.
    (index != NONE && !(back && value == 0)).then_some(index)
}
