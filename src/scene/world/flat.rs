//! Flat primitives with everything prepared that a point of them takes.

use super::World;
use crate::geometry::{Intersection, Quad, Shape, SurfacePoint, Triangle, spanned};
use crate::lanes::{Rows, Vector};
use crate::material::Finish;
use crate::math::Rgb;
use crate::scene::mesh::Attributes;
use crate::scene::surface::Surface;
use crate::tree::{Ends, Forest, Hit, Query};
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
/// on, if it changes neither these nor lights.
#[derive(Clone, Copy)]
pub struct FlatSurfaces<'a>(pub(super) &'a World);

/// A place on something flat.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlatHit {
    pub primitive: u32,
    pub u: f64,
    pub v: f64,
}

/// The outcome of a ray.
pub(crate) enum Meeting<'f> {
    Nothing,
    Diffuse(FlatHit, Diffuse<'f>),
    Other(SurfacePoint),
}

/// A flat diffuse surface.
#[derive(Clone, Copy)]
pub(crate) struct Diffuse<'f> {
    flat: &'f Flat,
    albedos: &'f [Rgb; 2],
}

impl Diffuse<'_> {
    /// The numbers that lanes read.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [f64; DIFFUSE] {
        let Flat { spans: [a, b, c], normal: n, is_triangle, .. } = self.flat;
        let is_triangle = f64::from(u8::from(*is_triangle));
        let [Rgb([f0, f1, f2]), Rgb([b0, b1, b2])] = *self.albedos;
        [
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
        ]
    }
}

impl FlatSurfaces<'_> {
    /// The rays between surfaces.
    #[inline(always)]
    pub(crate) fn forest(&self) -> &Forest {
        &self.0.forest
    }

    /// True if all lights are flat, so that lanes can sample them.
    pub(crate) fn has_flat_lights(&self) -> bool {
        self.0.has_flat_lights
    }

    /// The outcomes of rays in columns, in their order.
    #[inline(always)]
    pub(crate) fn meet(&self, rays: &Rows<6>, ends: &[Ends], mut met: impl FnMut(usize, Meeting)) {
        let Self(world) = self;
        world.forest.closest_in_columns(rays, ends, |i, hit| {
            let computed;
            let flat = match hit.map(|hit| world.flat.get(hit.primitive as usize)) {
                Some(Some(flat)) => flat,
                Some(None) => {
                    computed = hit.and_then(|hit| world.flat_at(&hit));
                    &computed
                }
                None => &None,
            };
            // One call, so that it is inlined.
            met(
                i,
                match (hit, flat.as_ref().and_then(Flat::as_diffuse)) {
                    (
                        Some(Hit { primitive, intersection: Intersection { u, v, .. }, .. }),
                        Some(surface),
                    ) => Meeting::Diffuse(FlatHit { primitive, u, v }, surface),
                    (Some(hit), None) => world.other(&rays.get(i), &hit),
                    (None, _) => Meeting::Nothing,
                },
            );
        });
    }

    /// The point at a place on something flat.
    pub(crate) fn point(&self, FlatHit { primitive, u, v }: FlatHit) -> Option<SurfacePoint> {
        let Self(world) = self;
        let x = match world.forest.shape(primitive)? {
            Shape::Triangle(triangle) => triangle.point_at(u, v),
            Shape::Quad(quad) => quad.point_at(u, v),
            Shape::Sphere(_) | Shape::Disk(_) => return None,
        };
        Some(world.complete(primitive, world.forest.shape(primitive)?.as_triangle(), x))
    }

    /// The place and the surface of a point, if that is flat and diffuse and the point tells its
    /// place.
    #[inline(always)]
    pub(crate) fn diffuse_at(&self, x: &SurfacePoint) -> Option<(FlatHit, Diffuse<'_>)> {
        let flat = self.0.flat.get(x.primitive as usize)?.as_ref()?;
        let at = FlatHit { primitive: x.primitive, u: x.uv.x, v: x.uv.y };
        if flat.has_uvs { None } else { Some((at, flat.as_diffuse()?)) }
    }
}

impl World {
    /// The outcome of a ray that has met nothing flat and diffuse.
    #[inline(never)]
    fn other(&self, &[x, y, z, dx, dy, dz]: &[f64; 6], hit: &Hit<'_>) -> Meeting<'static> {
        let ray = Query::free(DVec3::new(x, y, z), DVec3::new(dx, dy, dz));
        self.point_of(&ray, hit).map_or(Meeting::Nothing, Meeting::Other)
    }

    /// The flat primitive that was hit, if it is one.
    fn flat_at(&self, hit: &Hit<'_>) -> Option<Flat> {
        let surface = *self.surface_of.get(hit.primitive as usize)?;
        let shape = match self.forest.triangle_of(hit) {
            Some(triangle) => Shape::Triangle(triangle),
            None => *self.forest.shape(hit.primitive)?,
        };
        Flat::new(&shape, surface, &self.surfaces, &self.materials)
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
        let new =
            |(shape, surface): (&Shape, &u32)| Self::new(shape, *surface, surfaces, materials);
        shapes.iter().zip(surface_of).map(new).collect()
    }

    /// A primitive of a surface; `None` if it is not flat.
    #[inline]
    fn new(
        shape: &Shape,
        surface: u32,
        surfaces: &[Surface],
        materials: &[Finish],
    ) -> Option<Self> {
        let Surface { attributes, relief, light, material, .. } = &surfaces[surface as usize];
        if relief.is_some() || attributes.as_ref().is_some_and(Attributes::is_smooth) {
            return None;
        }
        let (spans, x, rounding) = match shape {
            Shape::Triangle(t) => (t.vertices, t.point_at(0.0, 0.0), Triangle::ROUNDING),
            Shape::Quad(q) => {
                ([q.origin, q.edge_u, q.edge_v], q.point_at(0.0, 0.0), Quad::ROUNDING)
            }
            Shape::Sphere(_) | Shape::Disk(_) => return None,
        };
        Some(Self {
            spans: spans.map(Vector::from),
            is_triangle: matches!(shape, Shape::Triangle(_)),
            rounding,
            normal: x.geometric_normal,
            tangent: x.tangent,
            surface,
            has_uvs: attributes.is_some(),
            diffuse: materials[material.0 as usize].diffuse().filter(|_| light.is_none()),
        })
    }

    #[inline(always)]
    fn as_diffuse(&self) -> Option<Diffuse<'_>> {
        Some(Diffuse { flat: self, albedos: self.diffuse.as_ref()? })
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
