//! Flat primitives with everything prepared that a point of them takes.

use super::World;
use crate::geometry::{Quad, Shape, SurfacePoint, Triangle, spanned};
use crate::lanes::Vector;
use crate::material::Finish;
use crate::math::Rgb;
use crate::scene::mesh::Attributes;
use crate::scene::surface::Surface;
use crate::tree::{FlatHit, Forest};
use glam::{DVec2, DVec3};
use std::fmt;

/// The most primitives for which it pays: their memory stays in the nearest cache.
const MOST: usize = 128;

/// A triangle without vertex normals, or a quad.
pub(super) struct Flat {
    /// Corners of a triangle, origin and edges of a quad.
    spans: [Vector<f64>; 3],
    is_triangle: bool,
    /// The rounding error of a position relative to its reach.
    rounding: f64,
    normal: DVec3,
    tangent: DVec3,
    surface: u32,
    /// True if a point's surface parameters are not those of the shape.
    has_uvs: bool,
    /// The albedos of front and back, if it emits nothing and reflects by Lambert's law, the same
    /// everywhere.
    diffuse: Option<[Rgb; 2]>,
}

/// Numbers of a flat diffuse surface.
pub(crate) const DIFFUSE: usize = 19;

/// The flat diffuse surfaces of a [`World`](super::World) and the rays between them: what walks in
/// columns ask for instead of surface points and BSDFs. A scene that is made of a world hands them
/// on, if it changes neither surfaces nor lights.
#[derive(Clone, Copy)]
pub struct FlatSurfaces<'a>(pub(super) &'a World);

impl<'a> FlatSurfaces<'a> {
    /// The rays between surfaces.
    #[inline(always)]
    pub(crate) fn forest(&self) -> &'a Forest {
        &self.0.forest
    }

    /// The point that a ray has hit, if it is on something flat.
    #[inline(always)]
    pub(crate) fn point(&self, FlatHit { primitive, u, v }: FlatHit) -> Option<SurfacePoint> {
        let flat = self.0.flat.get(primitive as usize)?.as_ref()?;
        flat.point_at(primitive, u, v).or_else(|| {
            let triangle = self.0.forest.shape(primitive)?.as_triangle()?;
            Some(self.0.complete(primitive, Some(triangle), triangle.point_at(u, v)))
        })
    }

    /// The hit of a ray that has met a point, if the point tells.
    #[inline(always)]
    pub(crate) fn hit(&self, point: &SurfacePoint) -> Option<FlatHit> {
        let flat = self.0.flat.get(point.primitive as usize)?.as_ref()?;
        let hit = FlatHit { primitive: point.primitive, u: point.uv.x, v: point.uv.y };
        (!flat.has_uvs).then_some(hit)
    }

    /// The numbers of a primitive, if it is flat and diffuse.
    #[inline(always)]
    pub(crate) fn diffuse(&self, primitive: u32) -> Option<[f64; DIFFUSE]> {
        let Flat { spans: [a, b, c], normal: n, is_triangle, diffuse, .. } =
            self.0.flat.get(primitive as usize)?.as_ref()?;
        let [front, back] = diffuse.as_ref()?;
        let is_triangle = f64::from(u8::from(*is_triangle));
        let ([f0, f1, f2], [b0, b1, b2]) = (front.0, back.0);
        Some([
            a.x,
            a.y,
            a.z,
            b.x,
            b.y,
            b.z,
            c.x,
            c.y,
            c.z,
            n.x,
            n.y,
            n.z,
            is_triangle,
            f0,
            f1,
            f2,
            b0,
            b1,
            b2,
        ])
    }
}

impl fmt::Debug for FlatSurfaces<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FlatSurfaces")
            .field("primitives", &self.0.flat.len())
            .finish_non_exhaustive()
    }
}

impl Flat {
    /// All primitives of a world of few, `None` for other shapes; nothing for many.
    pub fn prepare(
        shapes: &[Shape],
        surface_of: &[u32],
        surfaces: &[Surface],
        materials: &[Finish],
    ) -> Vec<Option<Self>> {
        if shapes.len() > MOST {
            return Vec::new();
        }
        let prepare = |(shape, surface): (&Shape, &u32)| {
            let Surface { attributes, light, material, .. } = &surfaces[*surface as usize];
            if attributes.as_ref().is_some_and(Attributes::is_smooth) {
                return None;
            }
            let diffuse = materials[material.0 as usize].diffuse().filter(|_| light.is_none());
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
                has_uvs: attributes.is_some(),
                diffuse,
            })
        };
        shapes.iter().zip(surface_of).map(prepare).collect()
    }

    /// The point with parameters u and v: that of the shape, to the bit. `None` if vertices have
    /// parameters of their own.
    #[inline(always)]
    pub fn point_at(&self, primitive: u32, u: f64, v: f64) -> Option<SurfacePoint> {
        if self.has_uvs {
            return None;
        }
        let first = if self.is_triangle { 1.0 - u - v } else { 1.0 };
        let (position, reach) = spanned(self.spans, [first, u, v]);
        Some(SurfacePoint {
            primitive,
            surface: self.surface,
            tangent: self.tangent,
            uv: DVec2::new(u, v),
            ..SurfacePoint::on_surface(position.into(), self.rounding * reach, self.normal)
        })
    }
}
