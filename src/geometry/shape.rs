//! The shapes that surfaces are made of, and uniform sampling of their area.

use super::{Bounds, SurfacePoint};
use crate::lanes::{Lane, Vector};
use crate::math::angle;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Relative rounding error of one operation, 2⁻⁵³.
const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;

/// Bound on the relative error of n operations in a row, γ_n = n ε / (1 - n ε) (Higham 2002,
/// section 3.1).
#[inline]
#[must_use]
pub(crate) const fn gamma(n: u32) -> f64 {
    let ne = n as f64 * UNIT_ROUNDOFF;
    ne / (1.0 - ne)
}

/// A triangle; its front side sees the vertices counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Vertex positions.
    pub vertices: [DVec3; 3],
}

/// A sphere, or the part of it on one side of a plane perpendicular to `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: DVec3,
    /// Radius, positive.
    pub radius: f64,
    /// Unit vector from the centre to the pole.
    pub axis: DVec3,
    /// The lower bound of `n · axis` over the shape, n the outward normal; -1 for the whole sphere.
    pub cos_min: f64,
    /// The upper bound of `n · axis`; 1 for the whole sphere.
    pub cos_max: f64,
    /// True if the front side is the inside.
    pub inward: bool,
}

/// A parallelogram `origin + u edge_u + v edge_v`, u and v in [0, 1]; its normal is `edge_u ×
/// edge_v`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// Corner.
    pub origin: DVec3,
    /// First edge.
    pub edge_u: DVec3,
    /// Second edge.
    pub edge_v: DVec3,
}

/// The side of a closed surface that is its front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Facing {
    /// The outside.
    Outward,
    /// The inside.
    Inward,
}

/// A flat disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// Centre.
    pub center: DVec3,
    /// Unit normal, on the front side.
    pub normal: DVec3,
    /// Radius, positive.
    pub radius: f64,
}

/// Any of the shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A triangle.
    Triangle(Triangle),
    /// A sphere or a zone of one.
    Sphere(Sphere),
    /// A parallelogram.
    Quad(Quad),
    /// A disk.
    Disk(Disk),
}

/// Texture coordinates at the barycentric coordinates `1 - u - v, u, v` of a triangle, from those
/// of its corners.
#[must_use]
pub(crate) fn interpolated(corners: [DVec2; 3], barycentric: DVec2) -> DVec2 {
    let [a, b, c] = corners;
    a * (1.0 - barycentric.x - barycentric.y) + b * barycentric.x + c * barycentric.y
}

/// Sums of three vectors with coefficients, in lanes, and the greatest components of the sums of
/// their absolute values, of which rounding is a multiple.
#[inline(always)]
pub(crate) fn spanned<L: Lane>([a, b, c]: [Vector<L>; 3], [s, t, u]: [L; 3]) -> (Vector<L>, L) {
    let (pa, pb, pc) = (a * s, b * t, c * u);
    (pa + pb + pc, (pa.abs() + pb.abs() + pc.abs()).max_element())
}

impl Triangle {
    /// The barycentric coordinates u and v of the point of its plane that is nearest to a position.
    #[must_use]
    pub(crate) fn barycentric(&self, position: DVec3) -> DVec2 {
        let [a, b, c] = self.vertices;
        let normal = (b - a).cross(c - a);
        let offset = position - a;
        let coordinates =
            DVec2::new(offset.cross(c - a).dot(normal), (b - a).cross(offset).dot(normal));
        coordinates / normal.length_squared()
    }

    /// The rounding error of a point relative to its [reach](spanned).
    pub(crate) const ROUNDING: f64 = gamma(7);

    /// Twice the area times the unit normal, from the two shortest edges: their cross product
    /// cancels least.
    #[inline]
    #[must_use]
    pub fn cross(&self) -> DVec3 {
        let [a, b, c] = self.vertices;
        let (ab, bc, ca) = (b - a, c - b, a - c);
        let (ab2, bc2, ca2) = (ab.length_squared(), bc.length_squared(), ca.length_squared());
        if bc2 >= ab2 && bc2 >= ca2 {
            ca.cross(ab)
        } else if ca2 >= ab2 {
            ab.cross(bc)
        } else {
            bc.cross(ca)
        }
    }

    /// The point with barycentric coordinates `1 - u - v, u, v`, with its error bound.
    #[inline(always)]
    #[must_use]
    pub fn point_at(&self, u: f64, v: f64) -> SurfacePoint {
        let [a, b, c] = self.vertices;
        let (position, reach) = spanned([a, b, c].map(Vector::from), [1.0 - u - v, u, v]);
        let normal = self.cross().normalize();
        SurfacePoint {
            uv: DVec2::new(u, v),
            tangent: b - a,
            ..SurfacePoint::on_surface(position.into(), Self::ROUNDING * reach, normal)
        }
    }
}

impl Sphere {
    /// The whole sphere, front side outside.
    #[must_use]
    pub fn new(center: DVec3, radius: f64) -> Self {
        Self { center, radius, axis: DVec3::Z, cos_min: -1.0, cos_max: 1.0, inward: false }
    }

    /// The whole sphere, front side inside: a lamp that shines inward, a room.
    ///
    /// ```
    /// use pathspace::geometry::Sphere;
    /// use pathspace::glam::DVec3;
    ///
    /// let room = Sphere::inward(DVec3::ZERO, 2.0);
    /// assert_eq!(room.point_at(DVec3::X).geometric_normal, -DVec3::X);
    /// ```
    #[must_use]
    pub fn inward(center: DVec3, radius: f64) -> Self {
        Self { inward: true, ..Self::new(center, radius) }
    }

    /// True if nothing of the sphere is masked.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.cos_min <= -1.0 && self.cos_max >= 1.0
    }

    /// The point of the surface in direction `outward` (unit) from the centre, with its error
    /// bound; uv = (longitude / 2π, angle from the axis / π).
    #[must_use]
    pub fn point_at(&self, outward: DVec3) -> SurfacePoint {
        let local = super::Frame::from_normal(self.axis).to_local(outward);
        let uv = DVec2::new(
            angle::turn(local.y, local.x),
            angle::atan2(local.truncate().length(), local.z) / PI,
        );
        SurfacePoint { uv, tangent: self.axis.cross(outward), ..self.bare_point_at(outward) }
    }

    /// The same point, but with uv and tangent zero, which cost more than all the rest.
    #[inline]
    pub(crate) fn bare_point_at(&self, outward: DVec3) -> SurfacePoint {
        let position = self.center + outward * self.radius;
        let error = gamma(6) * (self.center.abs() + DVec3::splat(self.radius)).max_element();
        let normal = if self.inward { -outward } else { outward };
        SurfacePoint::on_surface(position, error, normal)
    }
}

impl Quad {
    /// The rounding error of a point relative to its [reach](spanned).
    pub(crate) const ROUNDING: f64 = gamma(5);

    /// The same parallelogram with its front side, which emits, towards a point: the edges change
    /// places if it is not. As it is if the point lies in its plane.
    ///
    /// ```
    /// use pathspace::geometry::Quad;
    /// use pathspace::glam::DVec3;
    ///
    /// let lamp = Quad { origin: DVec3::Z, edge_u: DVec3::X, edge_v: DVec3::Y }.facing(DVec3::ZERO);
    /// assert_eq!(lamp.cross(), -DVec3::Z);
    /// ```
    #[must_use]
    pub fn facing(self, target: DVec3) -> Self {
        let Self { origin, edge_u, edge_v } = self;
        if self.cross().dot(target - origin) < 0.0 {
            Self { origin, edge_u: edge_v, edge_v: edge_u }
        } else {
            self
        }
    }

    /// The faces of a box: at its lower and its upper end of x, y and z.
    #[must_use]
    pub fn faces_of(bounds: &Bounds, facing: Facing) -> [Self; 6] {
        let (min, max) = (bounds.min, bounds.max);
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (max - min) * axis);
        // The normal of the faces at the lower end is outward: z × y = -x.
        let face = |origin, edge_u, edge_v| match facing {
            Facing::Outward => Self { origin, edge_u, edge_v },
            Facing::Inward => Self { origin, edge_u: edge_v, edge_v: edge_u },
        };
        [
            face(min, z, y),
            face(max, -y, -z),
            face(min, x, z),
            face(max, -z, -x),
            face(min, y, x),
            face(max, -x, -y),
        ]
    }

    /// Area times the unit normal.
    #[inline]
    #[must_use]
    pub fn cross(&self) -> DVec3 {
        self.edge_u.cross(self.edge_v)
    }

    /// The corners in the order of the outline.
    #[must_use]
    pub fn corners(&self) -> [DVec3; 4] {
        let (o, u, v) = (self.origin, self.edge_u, self.edge_v);
        [o, o + u, o + u + v, o + v]
    }

    /// The point with parameters u, v, with its error bound.
    #[inline]
    #[must_use]
    pub fn point_at(&self, u: f64, v: f64) -> SurfacePoint {
        let spans = [self.origin, self.edge_u, self.edge_v].map(Vector::from);
        let (position, reach) = spanned(spans, [1.0, u, v]);
        let normal = self.cross().normalize();
        SurfacePoint {
            uv: DVec2::new(u, v),
            tangent: self.edge_u,
            ..SurfacePoint::on_surface(position.into(), Self::ROUNDING * reach, normal)
        }
    }
}

impl Disk {
    /// The point with these coordinates in the plane of the disk (world units, axes of
    /// [`Frame::from_normal`](super::Frame)), with its error bound; uv maps the square around the
    /// disk to the unit square.
    #[must_use]
    pub fn point_at(&self, p: DVec2) -> SurfacePoint {
        let frame = super::Frame::from_normal(self.normal);
        let offset = frame.x * p.x + frame.y * p.y;
        let error = gamma(6) * (self.center.abs() + offset.abs()).max_element();
        let uv = 0.5 + p * (0.5 / self.radius);
        SurfacePoint {
            uv,
            tangent: frame.x,
            ..SurfacePoint::on_surface(self.center + offset, error, self.normal)
        }
    }
}

impl Shape {
    /// The triangle, if it is one.
    #[inline]
    #[must_use]
    pub fn as_triangle(&self) -> Option<Triangle> {
        if let Self::Triangle(triangle) = self { Some(*triangle) } else { None }
    }

    /// Surface area.
    #[must_use]
    pub fn area(&self) -> f64 {
        match self {
            Self::Triangle(t) => 0.5 * t.cross().length(),
            Self::Sphere(s) => 2.0 * PI * s.radius * s.radius * (s.cos_max - s.cos_min),
            Self::Quad(q) => q.cross().length(),
            Self::Disk(d) => PI * d.radius * d.radius,
        }
    }

    /// The point that the unit square's `u` maps to, uniform by area; primitive and surface ids are
    /// left to the caller.
    #[inline(always)]
    #[must_use]
    pub fn sample_area(&self, u: DVec2) -> SurfacePoint {
        match self {
            Self::Triangle(t) => {
                let b = crate::math::warp::square_to_triangle(u);
                t.point_at(b.x, b.y)
            }
            Self::Sphere(s) => {
                let z = s.cos_min + (s.cos_max - s.cos_min) * u.x;
                let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
                let (sin, cos) = angle::sin_cos_of_turn(u.y);
                let frame = super::Frame::from_normal(s.axis);
                s.point_at(frame.to_world(DVec3::new(r * cos, r * sin, z)).normalize())
            }
            Self::Quad(q) => q.point_at(u.x, u.y),
            Self::Disk(d) => d.point_at(crate::math::warp::square_to_disk(u) * d.radius),
        }
    }

    /// The derivatives of the position by the shape's own parameters u and v, at a point of it.
    #[must_use]
    pub(crate) fn partials(&self, x: &SurfacePoint) -> [DVec3; 2] {
        match self {
            Self::Triangle(Triangle { vertices: [a, b, c] }) => [*b - *a, *c - *a],
            Self::Sphere(s) => {
                let offset = x.position - s.center;
                let height = offset.dot(s.axis);
                let around = offset - s.axis * height;
                let down = around.normalize_or_zero() * height - s.axis * around.length();
                [s.axis.cross(offset) * (2.0 * PI), down * PI]
            }
            Self::Quad(q) => [q.edge_u, q.edge_v],
            Self::Disk(d) => {
                let frame = super::Frame::from_normal(d.normal);
                [frame.x, frame.y].map(|axis| axis * (2.0 * d.radius))
            }
        }
    }

    /// An axis-aligned box that contains the shape (the whole sphere for a masked one), the
    /// smallest one up to rounding, which is outwards.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let around = |center: DVec3, extent: DVec3| {
            let extent = extent * (1.0 + gamma(8));
            let (min, max) = (center - extent, center + extent);
            Bounds {
                min: DVec3::new(min.x.next_down(), min.y.next_down(), min.z.next_down()),
                max: DVec3::new(max.x.next_up(), max.y.next_up(), max.z.next_up()),
            }
        };
        match self {
            Self::Triangle(t) => Bounds::of_points(t.vertices),
            Self::Sphere(s) => around(s.center, DVec3::splat(s.radius)),
            Self::Quad(q) => Bounds::of_points(q.corners()),
            Self::Disk(d) => {
                let n = d.normal;
                around(
                    d.center,
                    DVec3::new(libm::hypot(n.y, n.z), libm::hypot(n.x, n.z), libm::hypot(n.x, n.y))
                        * d.radius,
                )
            }
        }
    }
}
