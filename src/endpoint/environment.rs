//! An environment of constant radiance.

use super::{
    AnyLight, DirectionSample, Endpoint, EndpointError, Light, PointSample, SceneExtent, check,
};
use crate::geometry::SurfacePoint;
use crate::math::{PerArea, PerProjected, Rgb, warp::square_to_sphere};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The same radiance from all directions, from infinitely far away.
#[derive(Clone, Debug, PartialEq)]
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
        self.extent.sample_direction(point, self.radiance, u)
    }

    fn direction_pdf(&self, point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        self.extent.direction_pdf(point)
    }

    fn emit(&self, _point: &SurfacePoint, _direction: DVec3) -> Rgb {
        self.radiance
    }

    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        self.extent.facing(point, receiver)
    }
}

impl Light for ConstantEnvironment {
    /// The flux into the spheres around the boxes of the scene's extent, `Σ π R² ∫ L dσ`.
    fn power(&self) -> Rgb {
        self.radiance * (self.extent.cross_section() * 4.0 * PI)
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn is_black(&self) -> bool {
        self.radiance.is_black()
    }

    fn set_scene_extent(&mut self, extent: &SceneExtent) {
        self.extent = extent.clone();
    }

    fn into_any(self) -> AnyLight {
        AnyLight::Constant(self)
    }
}
