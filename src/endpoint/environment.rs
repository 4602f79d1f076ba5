//! An environment of constant radiance.

use super::{
    DirectionSample, Endpoint, EndpointError, Light, PointSample, check, extent::SceneExtent,
};
use crate::geometry::{Bounds, SurfacePoint};
use crate::math::{PerArea, PerProjected, Rgb, warp::square_to_sphere};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The same radiance from all directions, from infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantEnvironment {
    radiance: Rgb,
    extent: SceneExtent,
}

impl ConstantEnvironment {
    /// An environment of the given radiance (W/(m² sr)).
    ///
    /// # Errors
    /// If the radiance is negative or not finite.
    pub fn new(radiance: Rgb) -> Result<Self, EndpointError> {
        Ok(Self {
            radiance: check::emission("constant environment", "radiance", radiance)?,
            extent: SceneExtent::default(),
        })
    }
}

impl Endpoint for ConstantEnvironment {
    fn sample_point(&self, _u1: f64, u2: DVec2) -> Option<PointSample> {
        let point = SurfacePoint::infinite(DVec3::ZERO, square_to_sphere(u2));
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(0.25 / PI)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction = point.geometric_normal;
        let pdf = self.direction_pdf(point, direction);
        let from = SurfacePoint { position: self.extent.sample_ray(direction, u), ..*point };
        (pdf.value() > 0.0).then(|| DirectionSample {
            from,
            direction,
            pdf,
            weight: self.radiance / pdf.value(),
        })
    }

    fn direction_pdf(&self, point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        self.extent.ray_pdf(point.geometric_normal)
    }

    fn emit(&self, _point: &SurfacePoint, _direction: DVec3) -> Rgb {
        self.radiance
    }

    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        self.extent.facing(point, receiver)
    }
}

impl Light for ConstantEnvironment {
    /// The flux into the sphere around the scene, `π R² ∫ L dσ`.
    fn power(&self) -> Rgb {
        self.radiance * (PI * self.extent.radius().powi(2) * 4.0 * PI)
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn is_black(&self) -> bool {
        self.radiance.is_black()
    }

    fn set_scene_bounds(&mut self, bounds: &Bounds) {
        self.extent = SceneExtent::new(bounds);
    }
}
