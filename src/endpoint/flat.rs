//! The simplest area light: one flat shape, the same radiance everywhere.

use super::solid_angle::Near;
use crate::geometry::{NormalOrigin, Place, Quad, Shape, SurfacePoint, Triangle, spanned};
use crate::lanes::{LANES, Lane, Mask, Vector, load, splat};
use crate::math::{PerArea, Rgb, warp};
use fearless_simd::{Simd, f64x8};
use glam::{DVec2, DVec3};

/// A quad or a triangle whose front emits the same radiance from all points into all directions,
/// with everything prepared that sampling it takes.
///
/// Receivers that are not near sample it uniformly by area: position, density and radiance are then
/// a few products of these numbers, which many lanes can compute at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatLight {
    /// Origin and edges of a quad, corners of a triangle.
    spans: [DVec3; 3],
    is_triangle: bool,
    /// Unit normal, on the side that emits.
    pub normal: DVec3,
    /// Its number as the scene's intersections report it.
    pub primitive: u32,
    /// The number of its surface.
    pub surface: u32,
    /// Emitted radiance, W/(m² sr).
    pub radiance: Rgb,
    /// Density of a point that is uniform on the area.
    pub pdf: PerArea,
    near: Near,
}

impl FlatLight {
    /// `None` if the shape is neither a quad nor a triangle, or has no area.
    #[must_use]
    pub fn new(shape: &Shape, primitive: u32, surface: u32, radiance: Rgb) -> Option<Self> {
        let (spans, cross) = match shape {
            Shape::Quad(quad) => ([quad.origin, quad.edge_u, quad.edge_v], quad.cross()),
            Shape::Triangle(triangle) => (triangle.vertices, triangle.cross()),
            Shape::Disk(_) | Shape::Sphere(_) => return None,
        };
        let (near, pdf) = (Near::of(shape)?, PerArea(1.0 / shape.area()));
        (pdf.value() > 0.0 && pdf.value().is_finite()).then_some(Self {
            spans,
            is_triangle: matches!(shape, Shape::Triangle(_)),
            normal: cross.normalize(),
            primitive,
            surface,
            radiance,
            pdf,
            near,
        })
    }

    /// True if a receiver there may sample it by solid angle instead of by area: if its centre is
    /// nearer than its size.
    #[inline]
    #[must_use]
    pub fn is_near(&self, receiver: DVec3) -> bool {
        self.near.holds(receiver)
    }

    /// The point that the unit square's `u` maps to, uniform by area.
    #[inline]
    #[must_use]
    pub fn point_at(&self, u: DVec2) -> SurfacePoint {
        let light = FlatLanes::new(self.numbers());
        let (position, error, [u, v]) = light.point_at(u.to_array());
        self.point(position.into(), error, DVec2::new(u, v))
    }

    /// A point of it, of which lanes have found what varies.
    #[inline(always)]
    pub(crate) fn point(&self, position: DVec3, error: f64, uv: DVec2) -> SurfacePoint {
        let [a, b, _] = self.spans;
        SurfacePoint {
            position,
            error,
            geometric_normal: self.normal,
            shading_normal: self.normal,
            normal_origin: NormalOrigin::Shape,
            tangent: if self.is_triangle { b - a } else { b },
            uv,
            place: Place::Area,
            medium: 0,
            primitive: self.primitive,
            surface: self.surface,
        }
    }

    /// The numbers that [`FlatLanes::new`] takes.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [f64; FLAT] {
        let ([a, b, c], n, l) = (self.spans, self.normal, self.radiance.0);
        let is_triangle = f64::from(u8::from(self.is_triangle));
        [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, n.x, n.y, n.z, l[0], l[1], l[2], is_triangle]
    }
}

/// Numbers of a [`FlatLight`] in lanes.
const FLAT: usize = 16;

/// A [`FlatLight`] in each lane.
pub(crate) struct FlatLanes<L: Lane> {
    spans: [Vector<L>; 3],
    is_triangle: L::Mask,
    pub normal: Vector<L>,
    pub radiance: [L; 3],
}

impl<S: Simd> FlatLanes<f64x8<S>> {
    /// Up to eight lights.
    #[inline(always)]
    pub fn gather<'a>(
        simd: S,
        lights: impl Iterator<Item = Option<&'a FlatLight>> + Clone,
    ) -> Self {
        let mut there = lights.clone().flatten();
        if let Some(first) = there.next()
            && there.all(|light| std::ptr::eq(light, first))
        {
            return Self::new(splat(simd, &first.numbers()));
        }
        let mut numbers = [[0.0; LANES]; FLAT];
        for (lane, light) in lights.enumerate().take(LANES) {
            let Some(light) = light else { continue };
            for (row, number) in numbers.iter_mut().zip(light.numbers()) {
                row[lane] = number;
            }
        }
        Self::new(load(simd, &numbers))
    }
}

impl<L: Lane> FlatLanes<L> {
    #[inline(always)]
    pub fn new(numbers: [L; FLAT]) -> Self {
        let [ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, red, green, blue, is_triangle] =
            numbers;
        Self {
            spans: [Vector::new(ax, ay, az), Vector::new(bx, by, bz), Vector::new(cx, cy, cz)],
            is_triangle: is_triangle.is_positive(),
            normal: Vector::new(nx, ny, nz),
            radiance: [red, green, blue],
        }
    }

    /// Points uniform by area: positions, their error bounds, surface parameters.
    #[inline(always)]
    pub fn point_at(&self, u: [L; 2]) -> (Vector<L>, L, [L; 2]) {
        let barycentric = warp::triangle(u);
        let choose = |yes, no| self.is_triangle.choose(yes, no);
        let [u, v] = [choose(barycentric[0], u[0]), choose(barycentric[1], u[1])];
        let one = u.constant(1.0);
        let (position, reach) = spanned(self.spans, [choose(one - u - v, one), u, v]);
        let rounding = choose(u.constant(Triangle::ROUNDING), u.constant(Quad::ROUNDING));
        (position, rounding * reach, [u, v])
    }
}
