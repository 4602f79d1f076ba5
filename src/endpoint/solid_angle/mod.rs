//! Points of one shape, uniform in the solid angle under which a receiver sees it.
//!
//! Next event estimation divides by the density of its point, and the geometry term has `cos θ' /
//! r²` of the light's side. A density per area leaves both in the estimate, and near the light its
//! variance grows without bound; per solid angle, `p_A = p_σ cos θ' / r²`, they cancel and the
//! estimate is at most the radiance times the solid angle.
//!
//! [`Subtended::new`] is the one predicate that decides between solid angle and area, for samples
//! and for densities.

mod rectangle;
mod sphere_cone;
mod triangle;

use crate::geometry::{Place, Quad, Shape, SurfacePoint, Triangle};
use crate::math::{PerArea, PerSolidAngle};
use glam::{DVec2, DVec3};
use rectangle::SphericalRectangle;
use sphere_cone::SphereCone;
use triangle::SphericalTriangle;

/// A flat shape is near if the square of the distance to its centre is less than this many times
/// that of its size, the diagonal of a rectangle or the longest edge of a right triangle.
///
/// Farther away the variance of uniform area is at most a quarter of the square of the mean. A
/// solid angle leaves a third of that, which counts for less than its time beside what else varies
/// in a path.
const NEAR: f64 = 1.0;

/// Solid angles below this are left to uniform area: as differences of angles they have fewer than
/// 12 digits. A near shape has one only if the receiver sees it edge-on or if it is a sliver.
const LEAST_SOLID_ANGLE: f64 = 1e-4;

/// The region of the receivers that are near a flat shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Near {
    pub center: DVec3,
    /// The square of the distance from the centre below which a receiver is near.
    pub distance_squared: f64,
}

impl Near {
    /// `None` if the shape has no such region.
    pub(super) fn of(shape: &Shape) -> Option<Self> {
        let (center, size_squared) = match shape {
            Shape::Quad(quad) => (
                quad.origin + 0.5 * (quad.edge_u + quad.edge_v),
                quad.edge_u.length_squared() + quad.edge_v.length_squared(),
            ),
            Shape::Triangle(Triangle { vertices: [a, b, c] }) => {
                let edges = [*b - *a, *c - *b, *a - *c];
                // The sum of the squares of the edges is twice that of the size.
                let sum = edges.map(DVec3::length_squared).iter().sum::<f64>();
                ((*a + *b + *c) / 3.0, 0.5 * sum)
            }
            Shape::Disk(_) | Shape::Sphere(_) => return None,
        };
        Some(Self { center, distance_squared: NEAR * size_squared })
    }

    #[inline]
    pub(super) fn holds(&self, receiver: DVec3) -> bool {
        (self.center - receiver).length_squared() < self.distance_squared
    }
}

/// A shape as a receiver sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subtended<'s> {
    receiver: DVec3,
    solid_angle: f64,
    outline: Outline<'s>,
}

#[derive(Clone, Copy, Debug)]
enum Outline<'s> {
    Circle(SphereCone<'s>),
    Rectangle(SphericalRectangle<'s>),
    Triangle(&'s Triangle, SphericalTriangle),
    /// The two halves of a parallelogram, the first one without its last corner.
    Parallelogram(&'s Quad, [SphericalTriangle; 2]),
}

impl<'s> Subtended<'s> {
    /// `None` where points are uniform on the area instead: on disks, on what is far away in units
    /// of its size, seen edge-on or from behind.
    #[inline]
    pub(super) fn new(shape: &'s Shape, receiver: &SurfacePoint, two_sided: bool) -> Option<Self> {
        match shape {
            _ if receiver.place == Place::Infinite => None,
            Shape::Sphere(sphere) => {
                let cone = SphereCone::new(sphere, receiver)?;
                let outline = Outline::Circle(cone);
                Some(Self { receiver: receiver.position, solid_angle: cone.solid_angle(), outline })
            }
            _ => Self::of_near(shape, receiver, two_sided),
        }
    }

    /// The same of a flat shape.
    #[inline(never)]
    fn of_near(shape: &'s Shape, receiver: &SurfacePoint, two_sided: bool) -> Option<Self> {
        if !Near::of(shape)?.holds(receiver.position) {
            return None;
        }
        match shape {
            Shape::Quad(quad) => Self::of_quad(quad, receiver, two_sided),
            Shape::Triangle(triangle) => Self::of_triangle(triangle, receiver, two_sided),
            Shape::Disk(_) | Shape::Sphere(_) => None,
        }
    }

    fn of_quad(quad: &'s Quad, receiver: &SurfacePoint, two_sided: bool) -> Option<Self> {
        let origin = quad.origin - receiver.position;
        let (u, v, cross) = (quad.edge_u, quad.edge_v, quad.cross());
        let size = u.abs().max(v.abs()).max_element();
        let volume = visible_volume(origin.dot(cross), cross, size, receiver, two_sided)?;
        if let Some(rectangle) = SphericalRectangle::new(quad, origin) {
            return Self::of_flat(receiver, rectangle.solid_angle(), Outline::Rectangle(rectangle));
        }
        let [b, c, d] = [origin + u, origin + u + v, origin + v];
        let half = |corners| SphericalTriangle::new(corners, volume);
        let halves = [half([origin, b, c])?, half([origin, c, d])?];
        let solid_angle = halves.iter().map(SphericalTriangle::solid_angle).sum();
        Self::of_flat(receiver, solid_angle, Outline::Parallelogram(quad, halves))
    }

    fn of_triangle(
        triangle: &'s Triangle,
        receiver: &SurfacePoint,
        two_sided: bool,
    ) -> Option<Self> {
        let [a, b, c] = triangle.vertices.map(|vertex| vertex - receiver.position);
        let cross = triangle.cross();
        let size = (b - a).abs().max((c - a).abs()).max_element();
        let volume = visible_volume(a.dot(cross), cross, size, receiver, two_sided)?;
        let seen = SphericalTriangle::new([a, b, c], volume)?;
        Self::of_flat(receiver, seen.solid_angle(), Outline::Triangle(triangle, seen))
    }

    fn of_flat(receiver: &SurfacePoint, solid_angle: f64, outline: Outline<'s>) -> Option<Self> {
        let receiver = receiver.position;
        (solid_angle > LEAST_SOLID_ANGLE).then_some(Self { receiver, solid_angle, outline })
    }

    /// The point that the unit square's `u` maps to; primitive and surface ids are left to the
    /// caller, and on a sphere uv and tangent too, unless they are asked for.
    #[inline]
    pub(super) fn sample(&self, u: DVec2, with_uv: bool) -> SurfacePoint {
        match &self.outline {
            Outline::Circle(cone) => cone.sample(u, with_uv),
            Outline::Rectangle(rectangle) => rectangle.sample(u),
            Outline::Triangle(triangle, seen) => {
                let [_, b, c] = seen.sample(u);
                triangle.point_at(b, c)
            }
            Outline::Parallelogram(quad, [first, second]) => {
                let share = first.solid_angle() / self.solid_angle;
                if u.x < share {
                    let [_, b, c] = first.sample(DVec2::new(u.x / share, u.y));
                    quad.point_at((b + c).min(1.0), c)
                } else {
                    let rest = (u.x - share) / (1.0 - share);
                    let [_, c, d] = second.sample(DVec2::new(rest.min(1.0), u.y));
                    quad.point_at(c, (c + d).min(1.0))
                }
            }
        }
    }

    /// The density of `sample` at a point of the shape: 0 where the receiver sees a sphere's far
    /// side.
    #[inline]
    pub(super) fn pdf(&self, point: &SurfacePoint) -> PerArea {
        let to_receiver = self.receiver - point.position;
        let distance_squared = to_receiver.length_squared();
        let cosine = point.geometric_normal.dot(to_receiver) / distance_squared.sqrt();
        if cosine > 0.0 || !matches!(self.outline, Outline::Circle(_)) {
            PerSolidAngle(1.0 / self.solid_angle).per_area(cosine, distance_squared)
        } else {
            PerArea::ZERO
        }
    }
}

/// The volume that a flat shape and the receiver span, from its signed value; `None` if the shape
/// shows its dark side, or if the height above the plane is no more than rounding: then the
/// solid angle would be noise. `cross` is normal to the plane, and `volume` the height times its
/// length.
fn visible_volume(
    volume: f64,
    cross: DVec3,
    size: f64,
    receiver: &SurfacePoint,
    two_sided: bool,
) -> Option<f64> {
    let rounding = 16.0 * f64::EPSILON * (receiver.position.abs().max_element() + size);
    let is_above = volume.abs() > (receiver.error + rounding) * cross.length();
    (is_above && (two_sided || volume < 0.0)).then_some(volume.abs())
}

/// The number of [0, 1] nearest to x; 0 if x is not a number.
#[inline(always)]
fn unit_interval(x: f64) -> f64 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}
