//! Values that textures take from the vertices of a mesh.

use crate::geometry::interpolated;
use glam::{DVec2, DVec4};

/// Values at the vertices of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct VertexValues {
    pub uvs: Option<Vec<DVec2>>,
    pub other_uvs: Option<Vec<DVec2>>,
    /// Linear RGB and alpha, each 0 to 1.
    pub colors: Option<Vec<DVec4>>,
    /// Three vertices for each triangle.
    pub indices: Vec<[u32; 3]>,
}

impl VertexValues {
    /// True if there is more than one set of texture coordinates.
    pub fn has_more(&self) -> bool {
        self.other_uvs.is_some() || self.colors.is_some()
    }

    /// The texture coordinates of a triangle's corners.
    pub fn corner_uvs(&self, index: usize, other: bool) -> Option<[DVec2; 3]> {
        let uvs = self.other_uvs.as_ref().filter(|_| other).or(self.uvs.as_ref())?;
        self.indices.get(index).map(|corners| corners.map(|i| uvs[i as usize]))
    }
}

/// A place on a triangle of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VertexSite<'a> {
    pub values: &'a VertexValues,
    pub index: u32,
    pub barycentric: DVec2,
}

impl VertexSite<'_> {
    /// Texture coordinates of the first or of the other set.
    pub fn uv(&self, other: bool) -> DVec2 {
        let corners = self.values.corner_uvs(self.index as usize, other);
        corners.map_or(self.barycentric, |corners| interpolated(corners, self.barycentric))
    }

    /// The colour of the vertices, white without one.
    pub fn color(&self) -> DVec4 {
        let corners = self.values.indices.get(self.index as usize);
        let (Some(colors), Some(corners)) = (&self.values.colors, corners) else {
            return DVec4::ONE;
        };
        let [a, b, c] = corners.map(|i| colors[i as usize]);
        let DVec2 { x: u, y: v } = self.barycentric;
        a * (1.0 - u - v) + b * u + c * v
    }
}
