//! A point light.

use super::{AnyLight, DirectionSample, Endpoint, EndpointError, Light, PointSample, check};
use crate::geometry::{Bounds, SurfacePoint};
use crate::light_tree::LightBounds;
use crate::math::{PerArea, PerProjected, Rgb, warp::square_to_sphere};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

const OBJECT: &str = "point light";

/// A point that emits the same intensity into all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    position: DVec3,
    intensity: Rgb,
}

impl PointLight {
    /// A light of the given radiant intensity (W/sr).
    ///
    /// # Errors
    /// If a number is not finite, or the intensity negative.
    pub fn new(position: DVec3, intensity: Rgb) -> Result<Self, EndpointError> {
        let intensity = check::emission(OBJECT, "intensity", intensity)?;
        Ok(Self { position: check::position(OBJECT, "position", position)?, intensity })
    }
}

impl Endpoint for PointLight {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        Some(PointSample { point: SurfacePoint::dirac(self.position), pdf: PerArea(1.0) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction = square_to_sphere(u);
        let pdf = self.direction_pdf(point, direction);
        Some(DirectionSample { from: *point, direction, pdf, weight: self.intensity / pdf.value() })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, _direction: DVec3) -> PerProjected {
        PerProjected(0.25 / PI)
    }

    fn emit(&self, _point: &SurfacePoint, _direction: DVec3) -> Rgb {
        self.intensity
    }
}

impl Light for PointLight {
    fn power(&self) -> Rgb {
        self.intensity * (4.0 * PI)
    }

    fn bounds(&self) -> Option<LightBounds> {
        let place = Bounds::of_points([self.position]);
        Some(LightBounds::isotropic(place, self.intensity.mean()))
    }

    fn can_be_hit(&self) -> bool {
        false
    }

    fn is_black(&self) -> bool {
        self.intensity.is_black()
    }

    fn into_any(self) -> AnyLight {
        AnyLight::Point(self)
    }
}
