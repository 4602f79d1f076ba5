//! Flat primitives with everything prepared that a point of them takes.

use crate::geometry::{Quad, Shape, SurfacePoint, Triangle, spanned};
use crate::lanes::Vector;
use crate::scene::surface::Surface;
use glam::{DVec2, DVec3};

/// The most primitives for which it pays: their memory stays in the nearest cache.
const MOST: usize = 128;

/// A triangle without vertex attributes, or a quad.
pub(super) struct Flat {
    /// Corners of a triangle, origin and edges of a quad.
    spans: [Vector<f64>; 3],
    is_triangle: bool,
    /// The rounding error of a position relative to its reach.
    rounding: f64,
    normal: DVec3,
    tangent: DVec3,
    surface: u32,
}

impl Flat {
    /// All primitives of a world of few, `None` for other shapes; nothing for many.
    pub fn prepare(
        shapes: &[Shape],
        surface_of: &[u32],
        surfaces: &[Surface],
    ) -> Vec<Option<Self>> {
        if shapes.len() > MOST {
            return Vec::new();
        }
        let prepare = |(shape, surface): (&Shape, &u32)| {
            if surfaces[*surface as usize].attributes.is_some() {
                return None;
            }
            let (spans, rounding) = match shape {
                Shape::Triangle(t) => (t.vertices, Triangle::ROUNDING),
                Shape::Quad(q) => ([q.origin, q.edge_u, q.edge_v], Quad::ROUNDING),
                Shape::Sphere(_) | Shape::Disk(_) => return None,
            };
            let SurfacePoint { geometric_normal: normal, tangent, .. } =
                shape.sample_area(DVec2::ZERO);
            Some(Self {
                spans: spans.map(Vector::from),
                is_triangle: matches!(shape, Shape::Triangle(_)),
                rounding,
                normal,
                tangent,
                surface: *surface,
            })
        };
        shapes.iter().zip(surface_of).map(prepare).collect()
    }

    /// The point with parameters u and v: that of the shape, to the bit.
    #[inline(always)]
    pub fn point_at(&self, primitive: u32, u: f64, v: f64) -> SurfacePoint {
        let first = if self.is_triangle { 1.0 - u - v } else { 1.0 };
        let (position, reach) = spanned(self.spans, [first, u, v]);
        SurfacePoint {
            primitive,
            surface: self.surface,
            tangent: self.tangent,
            uv: DVec2::new(u, v),
            ..SurfacePoint::on_surface(position.into(), self.rounding * reach, self.normal)
        }
    }
}
