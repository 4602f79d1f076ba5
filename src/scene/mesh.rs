//! Triangle meshes as a user hands them in, and the vertex attributes that a scene keeps.

use super::error::SceneError;
use crate::geometry::{Shape, SurfacePoint, Triangle, interpolated};
use crate::material::VertexValues;
use crate::math::{has_exact_length, unit};
use glam::{DAffine3, DVec2, DVec3, DVec4};
use std::collections::HashMap;

/// An indexed triangle mesh in object space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Normals for smooth shading, one for each vertex, of any length but zero. `None`, or those of
    /// the triangles to one part in a million: flat triangles.
    pub normals: Option<Vec<DVec3>>,
    /// Texture coordinates, one for each vertex. `None`: barycentric coordinates take their place.
    pub uvs: Option<Vec<DVec2>>,
    /// A second set of texture coordinates, for textures that are
    /// [made for it](crate::material::Texture::with_other_coordinates). `None`: the first one.
    pub other_uvs: Option<Vec<DVec2>>,
    /// Colours, one for each vertex, for textures that
    /// [take them](crate::material::Texture::with_vertex_factor): linear RGB and alpha, of which
    /// what is not between 0 and 1 is cut off. `None`: white.
    pub colors: Option<Vec<DVec4>>,
    /// Directions of growing u, one for each vertex, in x, y and z, of any length; in w the sign
    /// of the bitangent `w · normal × tangent` of normal maps. `None`: those of the texture
    /// coordinates in each triangle.
    pub tangents: Option<Vec<DVec4>>,
    /// Three vertices for each triangle, counter-clockwise seen from the front.
    pub indices: Vec<[u32; 3]>,
}

/// A mesh in world space.
pub(crate) struct PlacedMesh {
    pub triangles: Vec<Shape>,
    /// Attributes of these triangles, if there are any.
    pub attributes: Option<Attributes>,
    /// Number of triangles without area, which were left out.
    pub dropped: usize,
}

/// Vertex attributes of the triangles of one surface.
#[derive(Debug)]
pub(crate) struct Attributes {
    normals: Option<Vec<DVec3>>,
    tangents: Option<Vec<DVec4>>,
    values: VertexValues,
}

impl Mesh {
    /// A closed approximation of the unit sphere: an icosahedron whose triangles are divided into
    /// four `levels` times, 20 · 4ⁿ triangles in all. Its vertices lie on the sphere and are
    /// shared.
    #[must_use]
    pub fn icosphere(levels: u32) -> Self {
        let golden = 0.5 * (1.0 + 5.0f64.sqrt());
        let mut positions = Vec::new();
        for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
            positions.extend(
                [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]
                    .map(DVec3::normalize),
            );
        }
        let near = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]) < 1.1;
        let mut indices = Vec::new();
        for (a, b, c) in
            (0..12).flat_map(|a| (0..a).flat_map(move |b| (0..b).map(move |c| (a, b, c))))
        {
            if near(a, b) && near(b, c) && near(c, a) {
                let [p, q, r] = [a, b, c].map(|i: u32| positions[i as usize]);
                indices.push(if (q - p).cross(r - p).dot(p) > 0.0 { [a, b, c] } else { [a, c, b] });
            }
        }
        for _ in 0..levels {
            let mut middles = HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let mut divided = Vec::with_capacity(4 * indices.len());
            for [a, b, c] in indices {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                divided.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            indices = divided;
        }
        Self { positions, indices, ..Self::default() }
    }

    /// Checks the mesh and brings it to world space.
    ///
    /// Under a mirroring transform the winding is reversed, so that the front side stays the image
    /// of the front side.
    pub(crate) fn place(&self, name: &str, transform: &DAffine3) -> Result<PlacedMesh, SceneError> {
        let linear = transform.matrix3;
        // The determinant of the matrix with its scale taken out, so that neither tiny nor huge
        // scales pass for singular ones.
        let scale = [linear.x_axis, linear.y_axis, linear.z_axis]
            .iter()
            .fold(0.0f64, |s, axis| s.max(axis.abs().max_element()));
        let unscaled = linear * (1.0 / scale);
        let determinant = unscaled.determinant();
        if !(transform.is_finite() && scale > 0.0 && determinant.is_finite() && determinant != 0.0)
        {
            return Err(SceneError::SingularTransform { object: name.to_owned() });
        }
        let normal_matrix = unscaled.inverse().transpose();
        if !normal_matrix.is_finite() {
            return Err(SceneError::SingularTransform { object: name.to_owned() });
        }
        self.check_counts(name)?;
        let fits = |p: &DVec3| p.abs().cmple(DVec3::splat(SceneError::MAX_COORDINATE)).all();
        let positions = self.map_vertices(name, "position", &self.positions, |p| {
            Some(transform.transform_point3(p)).filter(fits)
        })?;
        let normals = match &self.normals {
            Some(normals) => Some(
                self.map_vertices(name, "normal", normals, |n| unit(normal_matrix * unit(n)?))?,
            ),
            None => None,
        };
        for uvs in [&self.uvs, &self.other_uvs].into_iter().flatten() {
            self.map_vertices(name, "texture coordinate", uvs, |uv| uv.is_finite().then_some(uv))?;
        }
        let colors = match &self.colors {
            Some(colors) => Some(self.map_vertices(name, "colour", colors, |color| {
                color.is_finite().then(|| color.clamp(DVec4::ZERO, DVec4::ONE))
            })?),
            None => None,
        };
        let mirrored = determinant < 0.0;
        let tangents = match &self.tangents {
            Some(tangents) => Some(self.map_vertices(name, "tangent", tangents, |t| {
                let side = if mirrored { -t.w } else { t.w };
                let tangent = (unscaled * t.truncate()).extend(side);
                tangent.is_finite().then_some(tangent)
            })?),
            None => None,
        };
        let (mut triangles, mut indices) =
            (Vec::with_capacity(self.indices.len()), Vec::with_capacity(self.indices.len()));
        for &[a, b, c] in &self.indices {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            let triangle = Triangle { vertices: corners.map(|i| positions[i as usize]) };
            if has_exact_length(triangle.cross()) {
                triangles.push(Shape::Triangle(triangle));
                indices.push(corners);
            }
        }
        let dropped = self.indices.len() - triangles.len();
        let normals = normals.filter(|normals| !are_flat(normals, &triangles, &indices));
        let (uvs, other_uvs) = (self.uvs.clone(), self.other_uvs.clone());
        let values = VertexValues { uvs, other_uvs, colors, indices };
        let has_attributes =
            normals.is_some() || tangents.is_some() || values.uvs.is_some() || values.has_more();
        let attributes = has_attributes.then_some(Attributes { normals, tangents, values });
        Ok(PlacedMesh { triangles, attributes, dropped })
    }

    fn check_counts(&self, name: &str) -> Result<(), SceneError> {
        let expected = self.positions.len();
        let counts = [
            ("normal", self.normals.as_ref().map(Vec::len)),
            ("texture coordinate", self.uvs.as_ref().map(Vec::len)),
            ("texture coordinate", self.other_uvs.as_ref().map(Vec::len)),
            ("colour", self.colors.as_ref().map(Vec::len)),
            ("tangent", self.tangents.as_ref().map(Vec::len)),
        ];
        for (attribute, found) in counts {
            if let Some(found) = found.filter(|&found| found != expected) {
                return Err(SceneError::AttributeCount {
                    object: name.to_owned(),
                    attribute,
                    found,
                    expected,
                });
            }
        }
        for (triangle, indices) in self.indices.iter().enumerate() {
            if let Some(&index) = indices.iter().find(|&&i| i as usize >= expected) {
                return Err(SceneError::IndexOutOfRange {
                    object: name.to_owned(),
                    triangle,
                    index,
                    vertices: expected,
                });
            }
        }
        Ok(())
    }

    fn map_vertices<T: Copy>(
        &self,
        name: &str,
        attribute: &'static str,
        values: &[T],
        f: impl Fn(T) -> Option<T>,
    ) -> Result<Vec<T>, SceneError> {
        let refuse = |vertex| SceneError::Vertex {
            object: name.to_owned(),
            attribute,
            vertex,
            reason: if attribute == "normal" {
                "zero, infinite or not a number"
            } else {
                "infinite, not a number or too large"
            },
        };
        values
            .iter()
            .enumerate()
            .map(|(vertex, &value)| f(value).ok_or_else(|| refuse(vertex)))
            .collect()
    }
}

/// The sine of the angle up to which a vertex normal is that of its triangle: files have normals in
/// single precision.
const FLAT: f64 = 1e-6;

/// True if all vertex normals are those of the triangles, on either side.
fn are_flat(normals: &[DVec3], triangles: &[Shape], indices: &[[u32; 3]]) -> bool {
    triangles.iter().zip(indices).all(|(triangle, corners)| {
        let of_triangle = triangle.as_triangle().map_or(DVec3::ZERO, |t| t.cross().normalize());
        corners.iter().all(|&i| normals[i as usize].cross(of_triangle).length() < FLAT)
    })
}

/// The fields of a [`SurfacePoint`] that vertex attributes replace.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shading {
    pub normal: DVec3,
    pub tangent: DVec3,
    pub uv: DVec2,
}

impl Shading {
    #[inline(always)]
    pub fn of(x: &SurfacePoint) -> Self {
        Self { normal: x.shading_normal, tangent: x.tangent, uv: x.uv }
    }
}

impl Attributes {
    /// True if shading normals differ from those of the triangles.
    pub fn is_smooth(&self) -> bool {
        self.normals.is_some()
    }

    /// The texture coordinates of each triangle's corners, if there are any.
    pub fn corner_uvs(&self) -> Option<Vec<[DVec2; 3]>> {
        let uvs = self.values.uvs.as_ref()?;
        Some(self.values.indices.iter().map(|corners| corners.map(|i| uvs[i as usize])).collect())
    }

    /// The shading of a point of a triangle of this surface by the attributes; without them it is
    /// `flat`, its uv barycentric.
    ///
    /// A shading normal on the back of its triangle is negated, so that both normals always agree
    /// about the side.
    pub fn at(&self, index: usize, triangle: Triangle, flat: Shading) -> Shading {
        let Some(&indices) = self.values.indices.get(index) else { return flat };
        let [a, b, c] = indices.map(|i| i as usize);
        let mut x = flat;
        if let Some(n) = &self.normals {
            let (u, v) = (flat.uv.x, flat.uv.y);
            let sum = n[a] * (1.0 - u - v) + n[b] * u + n[c] * v;
            let normal = unit(sum).unwrap_or(flat.normal);
            x.normal = if normal.dot(flat.normal) < 0.0 { -normal } else { normal };
        }
        if let Some(uv) = &self.values.uvs {
            x.uv = interpolated([uv[a], uv[b], uv[c]], flat.uv);
            let [p, q, r] = triangle.vertices;
            let (d1, d2) = (uv[b] - uv[a], uv[c] - uv[a]);
            // Solves for dp/du; only its direction matters, so the determinant's sign is enough.
            let tangent = ((q - p) * d2.y - (r - p) * d1.y) * d1.perp_dot(d2).signum();
            x.tangent =
                if d1.perp_dot(d2) != 0.0 && tangent.is_finite() { tangent } else { flat.tangent };
        }
        if let Some(t) = &self.tangents {
            let [t, u, v] = [a, b, c].map(|i| t[i].truncate());
            let tangent = t * (1.0 - flat.uv.x - flat.uv.y) + u * flat.uv.x + v * flat.uv.y;
            x.tangent = if tangent == DVec3::ZERO { x.tangent } else { tangent };
        }
        x
    }

    /// Values that textures take from the vertices.
    pub fn values(&self) -> &VertexValues {
        &self.values
    }

    /// The derivatives of the position by u and v, those of the other set if wanted, on a triangle
    /// of this surface; not finite where its texture coordinates are on a line.
    pub fn partials(&self, index: usize, triangle: Triangle, other: bool) -> [DVec3; 2] {
        let [p, q, r] = triangle.vertices;
        let (e1, e2) = (q - p, r - p);
        let Some([a, b, c]) = self.values.corner_uvs(index, other) else { return [e1, e2] };
        let (d1, d2) = (b - a, c - a);
        [e1 * d2.y - e2 * d1.y, e2 * d1.x - e1 * d2.x].map(|edge| edge / d1.perp_dot(d2))
    }

    /// The sign of the bitangent on a triangle of this surface, if tangents tell it.
    pub fn handedness(&self, index: usize) -> Option<f64> {
        let [corner, _, _] = *self.values.indices.get(index)?;
        let side = self.tangents.as_ref()?[corner as usize].w;
        (side != 0.0).then(|| side.signum())
    }
}

#[cfg(test)]
mod tests;
