//! Lambertian emission from surfaces.

use super::{DirectionSample, Endpoint, EndpointError, Light, PointSample, check, sphere_cone};
use crate::geometry::{Bounds, Disk, Frame, Place, Shape, Sphere, SurfacePoint};
use crate::math::distribution::AliasTable;
use crate::math::{PerArea, PerProjected, Rgb, warp::square_to_cosine_hemisphere};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, PI};

const OBJECT: &str = "area light";

/// Shapes that emit the same radiance from every point into every direction of their front side, or of both sides.
///
/// Points are uniform on the total area, except that a receiver outside of a whole sphere samples the cone of directions under which it
/// sees the sphere. The front side is that of the *geometric* normal.
#[derive(Clone, Debug)]
pub struct AreaLight {
    shapes: Vec<Shape>,
    by_area: AliasTable,
    area: f64,
    first_primitive: u32,
    surface: u32,
    radiance: Rgb,
    two_sided: bool,
}

impl AreaLight {
    /// A light of the given radiance (W/(m² sr)).
    ///
    /// `shapes` are consecutive primitives of the scene, the first having the number `first_primitive`; `surface` is their surface id.
    /// Shapes without area are never sampled.
    ///
    /// # Errors
    /// If the radiance is negative or not finite, if a shape's area is not finite or its radius negative, if the total area is zero, or if primitive numbers
    /// overflow.
    pub fn new(shapes: Vec<Shape>, first_primitive: u32, surface: u32, radiance: Rgb, two_sided: bool) -> Result<Self, EndpointError> {
        let radiance = check::emission(OBJECT, "radiance", radiance)?;
        let areas: Vec<f64> = shapes.iter().map(Shape::area).collect();
        let is_valid = |shape: &Shape| match shape {
            Shape::Sphere(Sphere { radius, .. }) | Shape::Disk(Disk { radius, .. }) => *radius >= 0.0,
            Shape::Triangle(_) | Shape::Quad(_) => true,
        };
        if let Some(index) = (0..shapes.len()).find(|i| !(is_valid(&shapes[*i]) && areas[*i] >= 0.0 && areas[*i].is_finite())) {
            return Err(EndpointError::InvalidShape { index });
        }
        let last = u32::try_from(shapes.len()).ok().and_then(|count| first_primitive.checked_add(count));
        if last.is_none() {
            return Err(EndpointError::TooManyShapes { shapes: shapes.len() });
        }
        let by_area = AliasTable::new(&areas).ok_or(EndpointError::NoArea { shapes: shapes.len() })?;
        Ok(Self { area: areas.iter().sum(), by_area, shapes, first_primitive, surface, radiance, two_sided })
    }

    /// Total area of the shapes.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Emitted radiance.
    #[must_use]
    pub fn radiance(&self) -> Rgb {
        self.radiance
    }

    /// Whether both sides emit.
    #[must_use]
    pub fn is_two_sided(&self) -> bool {
        self.two_sided
    }

    /// The surface id of all its shapes.
    #[must_use]
    pub fn surface(&self) -> u32 {
        self.surface
    }

    /// The numbers of its primitives.
    #[must_use]
    pub fn primitives(&self) -> std::ops::Range<u32> {
        self.first_primitive..self.first_primitive + self.shapes.len() as u32
    }

    /// Whether the side of `point` that faces `direction` emits.
    fn emits(&self, point: &SurfacePoint, direction: DVec3) -> bool {
        let cosine = point.geometric_normal.dot(direction);
        cosine > 0.0 || (self.two_sided && cosine < 0.0)
    }

    fn with_ids(&self, index: usize, point: SurfacePoint) -> SurfacePoint {
        SurfacePoint { primitive: self.first_primitive + index as u32, surface: self.surface, ..point }
    }

    /// The cone under which the receiver sees the light, if it is a whole sphere seen from outside. The one predicate that
    /// decides between cone and area, for samples and for densities.
    fn cone(&self, receiver: &SurfacePoint) -> Option<sphere_cone::SphereCone> {
        match self.shapes[..] {
            [Shape::Sphere(sphere)] if receiver.place != Place::Infinite => sphere_cone::SphereCone::new(sphere, receiver),
            _ => None,
        }
    }
}

impl Endpoint for AreaLight {
    fn sample_point(&self, u1: f64, u2: DVec2) -> Option<PointSample> {
        let (index, _) = self.by_area.sample(u1);
        let point = self.with_ids(index, self.shapes[index].sample_area(u2));
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0 / self.area)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let (mut u, mut side) = (u, 1.0);
        if self.two_sided {
            side = if u.x < 0.5 { 1.0 } else { -1.0 };
            u.x = if u.x < 0.5 { 2.0 * u.x } else { 2.0 * u.x - 1.0 };
        }
        let local = square_to_cosine_hemisphere(u);
        let direction = Frame::from_normal(point.geometric_normal * side).to_world(local);
        let pdf = self.direction_pdf(point, direction);
        // A direction in the tangent plane may round to either side.
        (pdf.value() > 0.0).then(|| DirectionSample { from: *point, direction, pdf, weight: self.radiance / pdf.value() })
    }

    fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected {
        let density = if self.two_sided { 0.5 * FRAC_1_PI } else { FRAC_1_PI };
        if self.emits(point, direction) { PerProjected(density) } else { PerProjected::ZERO }
    }

    fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
        if self.emits(point, direction) { self.radiance } else { Rgb::BLACK }
    }

    fn sample_from(&self, receiver: &SurfacePoint, u1: f64, u2: DVec2) -> Option<PointSample> {
        let Some(cone) = self.cone(receiver) else {
            return self.sample_point(u1, u2);
        };
        let point = self.with_ids(0, cone.sample(u2));
        let pdf = cone.pdf(&point);
        (pdf.value() > 0.0).then_some(PointSample { point, pdf })
    }

    fn pdf_from(&self, receiver: &SurfacePoint, point: &SurfacePoint) -> PerArea {
        match self.cone(receiver) {
            Some(cone) => cone.pdf(point),
            None => self.point_pdf(point),
        }
    }
}

impl Light for AreaLight {
    fn power(&self) -> Rgb {
        self.radiance * (PI * self.area * if self.two_sided { 2.0 } else { 1.0 })
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn is_black(&self) -> bool {
        self.radiance.is_black()
    }

    /// No, if it is flat, one-sided, and everything is behind it.
    fn can_illuminate(&self, bounds: &Bounds) -> bool {
        let is_in_front = |shape: &Shape| {
            let (origin, normal) = match shape {
                Shape::Triangle(triangle) => (triangle.vertices[0], triangle.cross()),
                Shape::Quad(quad) => (quad.origin, quad.cross()),
                Shape::Disk(disk) => (disk.center, disk.normal),
                Shape::Sphere(_) => return true,
            };
            // The corner that is farthest along the normal.
            let corner = DVec3::select(normal.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
            (corner - origin).dot(normal) > 0.0
        };
        !bounds.is_empty() && (self.two_sided || self.shapes.iter().any(is_in_front))
    }
}
