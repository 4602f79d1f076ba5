//! The host's light.

use super::material::power_cosine;
use pathspace::endpoint::{DirectionSample, Endpoint, Light, PointSample};
use pathspace::geometry::{Frame, SurfacePoint};
use pathspace::glam::{DVec2, DVec3};
use pathspace::math::{PerArea, PerProjected, Rgb};
use std::f64::consts::TAU;

/// A head lamp: a point that emits the intensity `I cosⁿ` around an axis. It is a Dirac position,
/// so its densities are a probability for the point and per solid angle for the direction; see the
/// table in `pathspace::endpoint`.
pub struct HeadLamp {
    pub position: DVec3,
    pub axis: DVec3,
    pub intensity: Rgb,
    pub exponent: f64,
}

impl Endpoint for HeadLamp {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        let point = SurfacePoint::dirac(self.position);
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction = Frame::from_normal(self.axis).to_world(power_cosine(self.exponent, u));
        let pdf = self.direction_pdf(point, direction);
        (pdf.value() > 0.0).then(|| DirectionSample {
            from: *point,
            direction,
            pdf,
            weight: self.emit(point, direction) / pdf.value(),
        })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, direction: DVec3) -> PerProjected {
        PerProjected(
            self.axis.dot(direction).max(0.0).powf(self.exponent) * (self.exponent + 1.0) / TAU,
        )
    }

    fn emit(&self, _point: &SurfacePoint, direction: DVec3) -> Rgb {
        self.intensity * self.axis.dot(direction).max(0.0).powf(self.exponent)
    }
}

impl Light for HeadLamp {
    fn power(&self) -> Rgb {
        self.intensity * (TAU / (self.exponent + 1.0))
    }

    fn can_be_hit(&self) -> bool {
        false // no ray meets a point by chance
    }
}
