//! Rays and where they meet shapes, in f64 and without an absolute epsilon.
//!
//! An [`Intersection`] carries the ray parameter, which only orders hits, and the shape's own
//! parameters, from which [`Shape::point_at_hit`] computes a position whose error does not grow
//! with the distance the ray has travelled.

use super::{Disk, Quad, Shape, SurfacePoint, Triangle};
use crate::lanes::{Lane, Mask, Vector};
use glam::{DVec2, DVec3};

/// A ray with the terms that the watertight triangle test needs once per ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The start of the ray.
    pub origin: DVec3,
    /// The direction, of unit length.
    pub direction: DVec3,
    /// The axis of the largest component of the direction.
    largest: u8,
    /// Maps the direction to (0, 0, 1): `x - shear.x z`, `y - shear.y z`, `shear.z z`.
    shear: DVec3,
}

/// The point at which a ray meets a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// Distance along the ray in units of its direction's length, positive.
    pub t: f64,
    /// First parameter: barycentric coordinate of a triangle's second vertex, a quad's u; 0 for
    /// other shapes.
    pub u: f64,
    /// Second parameter: barycentric coordinate of a triangle's third vertex, a quad's v; 0 for
    /// other shapes.
    pub v: f64,
}

/// The ends of a ray that are known to lie on the shape that is tested, so that these contacts are
/// not hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    /// Neither.
    None,
    /// The ray's origin.
    Origin,
    /// The point at this distance along the ray.
    End(f64),
    /// Origin and end.
    Both,
}

impl Ray {
    /// A ray from `origin` into the unit vector `direction`. A zero or non-finite ray hits nothing.
    #[inline]
    #[must_use]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        // Without branches, which rays of no order would make the processor guess.
        let [x, y] = largest_axis(direction.into());
        let largest = 2 - 2 * u8::from(x) - u8::from(y);
        let [i, j, k] = AXES[usize::from(largest) % 3];
        let d = direction.to_array();
        let shear = shear_along(Vector::new(d[i], d[j], d[k]));
        Self { origin, direction, largest, shear: shear.into() }
    }

    /// The point at distance `t`.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// A point in the coordinates in which the ray is the positive z axis. Depends on the point
    /// alone, so that triangles that share a vertex see it at the same place.
    #[inline]
    fn sheared(&self, p: DVec3) -> Vector<f64> {
        self.shear(rotated(p - self.origin, self.largest))
    }

    #[inline(always)]
    fn shear(&self, p: DVec3) -> Vector<f64> {
        sheared(self.shear.into(), p.into())
    }

    /// All axes in cyclic order, that of the largest component of the direction last.
    #[inline(always)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        AXES[usize::from(self.largest) % 3]
    }

    /// The intersection with a triangle whose corners have their coordinates along [`Self::axes`]:
    /// bit by bit that of [`Triangle::intersect`], without a branch by axis.
    #[inline(always)]
    pub(crate) fn meet(&self, [a, b, c]: [DVec3; 3]) -> Option<Intersection> {
        let [i, j, k] = self.axes();
        let o = self.origin.to_array();
        let o = DVec3::new(o[i], o[j], o[k]);
        let at = |p: DVec3| self.shear(p - o);
        Met::triangle(at(a), at(b), at(c)).intersection()
    }
}

impl Met<f64> {
    #[inline(always)]
    fn intersection(self) -> Option<Intersection> {
        self.hit.then_some(Intersection { t: self.t, u: self.u, v: self.v })
    }
}

/// True where the first axis is that of the largest component, and where the second is.
#[inline(always)]
pub(crate) fn largest_axis<L: Lane>(direction: Vector<L>) -> [L::Mask; 2] {
    let Vector { x, y, z } = direction.abs();
    [x.more(y) & x.more(z), !x.more(y) & y.more(z)]
}

/// The shear that makes a direction the z axis, given with its largest component last.
#[inline(always)]
pub(crate) fn shear_along<L: Lane>(direction: Vector<L>) -> Vector<L> {
    let scale = direction.z.constant(1.0) / direction.z;
    Vector::new(direction.x * scale, direction.y * scale, scale)
}

/// A point seen from the ray's origin, with coordinates in the order of the shear's.
#[inline(always)]
pub(crate) fn sheared<L: Lane>(shear: Vector<L>, p: Vector<L>) -> Vector<L> {
    Vector::new(p.x - shear.x * p.z, p.y - shear.y * p.z, shear.z * p.z)
}

/// All axes in cyclic order, by the last one.
const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The components in cyclic order with that of the given axis last. A branch that is the same for a
/// whole ray is cheaper than indexing.
#[inline]
fn rotated(v: DVec3, last: u8) -> DVec3 {
    match last {
        0 => DVec3::new(v.y, v.z, v.x),
        1 => DVec3::new(v.z, v.x, v.y),
        _ => v,
    }
}

impl Shape {
    /// The nearest point in front of the ray's origin.
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Intersection> {
        self.intersect_apart_from(ray, Contact::None)
    }

    /// The nearest point in front of the ray's origin which is not a known contact.
    ///
    /// A ray that touches a flat shape meets it nowhere else. A ray that touches a sphere meets it
    /// at one more point at most, which follows without cancellation from the angle at the contact.
    #[inline(always)]
    #[must_use]
    pub fn intersect_apart_from(&self, ray: &Ray, contact: Contact) -> Option<Intersection> {
        match self {
            Self::Sphere(s) => s.intersect_apart_from(ray, contact),
            _ if contact != Contact::None => None,
            Self::Triangle(t) => t.intersect(ray),
            Self::Quad(q) => q.intersect(ray),
            Self::Disk(d) => d.intersect(ray),
        }
    }

    /// The surface point of an intersection that this shape returned for this ray; primitive and
    /// surface ids are left to the caller.
    ///
    /// The position is recomputed from the shape's parameters or projected onto the shape, so its
    /// error bound is that of the shape's coordinates. The normals are those of the front side,
    /// whichever side the ray comes from.
    #[inline]
    #[must_use]
    pub fn point_at_hit(&self, ray: &Ray, hit: &Intersection) -> SurfacePoint {
        match self {
            Self::Triangle(t) => t.point_at(hit.u, hit.v),
            Self::Sphere(s) => s.point_at((ray.at(hit.t) - s.center).normalize()),
            Self::Quad(q) => q.point_at(hit.u, hit.v),
            Self::Disk(d) => {
                let offset = (ray.origin - d.center) + ray.direction * hit.t;
                let frame = super::Frame::from_normal(d.normal);
                d.point_at(DVec2::new(frame.x.dot(offset), frame.y.dot(offset)))
            }
        }
    }
}

/// The intersection of a ray and a flat shape, or of several rays with one each.
#[derive(Clone, Copy)]
pub(crate) struct Met<L: Lane> {
    /// True if there is one; nothing else counts otherwise.
    pub hit: L::Mask,
    /// The distance.
    pub t: L,
    /// The parameters.
    pub u: L,
    pub v: L,
}

impl<L: Lane> Met<L> {
    /// That with a triangle whose corners are given in the ray's coordinates: the watertight test of
    /// Woop, Benthin and Wald (2013). Triangles that share an edge or a vertex never let a ray pass
    /// between them.
    ///
    /// The sign of the rounded `fl(p q) - fl(r s)` is never opposite to that of `p q - r s`, since
    /// rounding is monotone: at worst it is 0, which counts as inside for both neighbours. So no
    /// extended precision is needed where an edge function vanishes.
    #[inline(always)]
    pub fn triangle(a: Vector<L>, b: Vector<L>, c: Vector<L>) -> Self {
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        let outside = (u.is_negative() | v.is_negative() | w.is_negative())
            & (u.is_positive() | v.is_positive() | w.is_positive());
        let determinant = u + v + w;
        let t = (u * a.z + v * b.z + w * c.z) / determinant;
        // Also no hit for a triangle seen edge-on, where t is not a number or infinite.
        let hit = !outside & t.is_positive() & t.less(t.constant(f64::INFINITY));
        Self { hit, t, u: v / determinant, v: w / determinant }
    }

    /// That with a parallelogram, from that with the triangle of its first three corners.
    #[inline(always)]
    pub fn first_half(self) -> Self {
        Self { u: self.sum(), ..self }
    }

    /// That with a parallelogram, from that with the triangle of its first corner and the last two.
    #[inline(always)]
    pub fn second_half(self) -> Self {
        Self { v: self.sum(), ..self }
    }

    /// The sum of the parameters, which rounding does not take beyond 1.
    #[inline(always)]
    fn sum(self) -> L {
        let (sum, one) = (self.u + self.v, self.u.constant(1.0));
        one.less(sum).choose(one, sum)
    }

    /// This one where it is a hit, else the other one.
    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        Self {
            hit: self.hit | other.hit,
            t: self.hit.choose(self.t, other.t),
            u: self.hit.choose(self.u, other.u),
            v: self.hit.choose(self.v, other.v),
        }
    }
}

impl Triangle {
    /// The point in front of the ray's origin, on either side.
    #[inline(always)]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Intersection> {
        let [a, b, c] = self.vertices;
        Met::triangle(ray.sheared(a), ray.sheared(b), ray.sheared(c)).intersection()
    }
}

impl Quad {
    /// The point in front of the ray's origin, on either side; watertight with triangles and quads
    /// that share its corners.
    #[inline(never)]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Intersection> {
        let [a, b, c, d] = self.corners();
        let (a, c) = (ray.sheared(a), ray.sheared(c));
        let first = Met::triangle(a, ray.sheared(b), c).first_half().intersection();
        first.or_else(|| Met::triangle(a, c, ray.sheared(d)).second_half().intersection())
    }
}

impl Disk {
    /// The point in front of the ray's origin, on either side.
    #[inline(never)]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Intersection> {
        let from_center = ray.origin - self.center;
        let t = -from_center.dot(self.normal) / ray.direction.dot(self.normal);
        if !(t > 0.0 && t < f64::INFINITY) {
            return None;
        }
        let offset = from_center + ray.direction * t;
        (offset.length_squared() <= self.radius * self.radius).then_some(Intersection {
            t,
            u: 0.0,
            v: 0.0,
        })
    }
}

#[cfg(test)]
mod tests;
