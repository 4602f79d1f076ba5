//! The simplest area light: one flat shape, the same radiance everywhere.

use super::solid_angle::Near;
use crate::geometry::{Shape, SurfacePoint};
use crate::math::{PerArea, Rgb, warp::square_to_triangle};
use glam::{DVec2, DVec3};

/// A rectangle or a triangle whose front emits the same radiance from all points into all
/// directions, with everything prepared that sampling it takes.
///
/// Receivers that are not near sample it uniformly by area: position, density and radiance are then
/// a few products of these numbers, which many lanes can compute at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatLight {
    /// The quad or triangle.
    pub shape: Shape,
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
        let cross = match shape {
            Shape::Quad(quad) => quad.cross(),
            Shape::Triangle(triangle) => triangle.cross(),
            Shape::Disk(_) | Shape::Sphere(_) => return None,
        };
        let (near, pdf) = (Near::of(shape)?, PerArea(1.0 / shape.area()));
        (pdf.value() > 0.0 && pdf.value().is_finite()).then_some(Self {
            shape: *shape,
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

    /// The centre and the square of the distance from it below which a receiver is near.
    #[inline]
    #[must_use]
    pub fn near_region(&self) -> (DVec3, f64) {
        (self.near.center, self.near.distance_squared)
    }

    /// The point that the unit square's `u` maps to, uniform by area.
    #[inline]
    #[must_use]
    pub fn point_at(&self, u: DVec2) -> SurfacePoint {
        let point = match &self.shape {
            Shape::Quad(quad) => quad.point_at(u.x, u.y),
            Shape::Triangle(triangle) => {
                let b = square_to_triangle(u);
                triangle.point_at(b.x, b.y)
            }
            other => other.sample_area(u),
        };
        SurfacePoint {
            // The same as before, but already known.
            geometric_normal: self.normal,
            shading_normal: self.normal,
            primitive: self.primitive,
            surface: self.surface,
            ..point
        }
    }
}
