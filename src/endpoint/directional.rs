//! A directional light: parallel rays from infinitely far away.

use super::{
    AnyLight, DirectionSample, Endpoint, EndpointError, Light, PointSample, SceneExtent, check,
};
use crate::geometry::SurfacePoint;
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3};

const OBJECT: &str = "directional light";

/// Parallel light from infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionalLight {
    direction: DVec3,
    irradiance: Rgb,
    extent: SceneExtent,
}

impl DirectionalLight {
    /// A light that travels along `direction` (of any length but zero) and causes the given
    /// irradiance (W/m²) on a plane perpendicular to it.
    ///
    /// # Errors
    /// If a number is not finite, the irradiance negative, or the direction zero.
    pub fn new(direction: DVec3, irradiance: Rgb) -> Result<Self, EndpointError> {
        let irradiance = check::emission(OBJECT, "irradiance", irradiance)?;
        Ok(Self {
            direction: check::direction(OBJECT, "direction", direction)?,
            irradiance,
            extent: SceneExtent::default(),
        })
    }

    /// Unit direction in which the light travels.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        self.direction
    }
}

impl Endpoint for DirectionalLight {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        Some(PointSample {
            point: SurfacePoint::infinite(DVec3::ZERO, self.direction),
            pdf: PerArea(1.0),
        })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        self.extent.sample_direction(point, self.irradiance, u)
    }

    fn direction_pdf(&self, point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        self.extent.direction_pdf(point)
    }

    fn emit(&self, _point: &SurfacePoint, _direction: DVec3) -> Rgb {
        self.irradiance
    }

    fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        self.extent.facing(point, receiver)
    }
}

impl Light for DirectionalLight {
    /// The flux through the disks that cover the scene.
    fn power(&self) -> Rgb {
        self.irradiance * self.extent.disk_area(self.direction)
    }

    fn can_be_hit(&self) -> bool {
        false
    }

    fn is_black(&self) -> bool {
        self.irradiance.is_black()
    }

    fn set_scene_extent(&mut self, extent: &SceneExtent) {
        self.extent = extent.clone();
    }

    fn into_any(self) -> AnyLight {
        AnyLight::Directional(self)
    }
}
