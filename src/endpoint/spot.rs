//! A spot light: a point light that shines into a cone.

use super::{DirectionSample, Endpoint, EndpointError, Light, PointSample, check};
use crate::geometry::{Frame, SurfacePoint};
use crate::math::warp::{direction_from_one_minus_cosine, square_to_smoothstep};
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

const OBJECT: &str = "spot light";

/// A point that emits full intensity into a cone and falls off smoothly to zero in a wider one around it.
///
/// Between the cones the intensity is `3t² - 2t³`, or [t²](SpotLight::with_squared_falloff), with t linear in `cos θ`, from 0 at the outer cone to 1 at the inner
/// one. Its integral over solid angle is half, or a third, of that of the full shell, so power is known in closed form and directions are sampled
/// exactly in proportion to intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    position: DVec3,
    intensity: Rgb,
    frame: Frame,
    falloff: Falloff,
}

/// The intensity relative to the axis as a function of `v = 1 - cos θ`, which is uniform in solid angle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Falloff {
    inner: f64,
    outer: f64,
    squared: bool,
}

impl SpotLight {
    /// A light of the given radiant intensity (W/sr) on its axis. Angles are measured from the axis, in degrees: full intensity up
    /// to `inner_degrees`, none from `outer_degrees` on.
    ///
    /// # Errors
    /// If a number is not finite, the intensity negative, the axis zero, or not `0 <= inner_degrees <= outer_degrees <= 180`
    /// with `outer_degrees > 0`.
    pub fn new(position: DVec3, axis: DVec3, intensity: Rgb, inner_degrees: f64, outer_degrees: f64) -> Result<Self, EndpointError> {
        let intensity = check::emission(OBJECT, "intensity", intensity)?;
        let position = check::position(OBJECT, "position", position)?;
        let frame = Frame::from_normal(check::direction(OBJECT, "axis", axis)?);
        if !(outer_degrees > 0.0 && outer_degrees <= 180.0) {
            let range = "(0, 180]";
            return Err(EndpointError::AngleOutOfRange { object: OBJECT, quantity: "outer angle", degrees: outer_degrees, range });
        }
        if !(inner_degrees >= 0.0 && inner_degrees <= outer_degrees) {
            let range = "[0, outer angle]";
            return Err(EndpointError::AngleOutOfRange { object: OBJECT, quantity: "inner angle", degrees: inner_degrees, range });
        }
        let one_minus_cosine = |degrees: f64| 2.0 * (0.5 * degrees.to_radians()).sin().powi(2);
        let falloff = Falloff { inner: one_minus_cosine(inner_degrees), outer: one_minus_cosine(outer_degrees), squared: false };
        check::positive(OBJECT, "solid angle", falloff.solid_angle())?;
        Ok(Self { position, intensity, frame, falloff })
    }

    /// The same light with the falloff t² between the cones, that of glTF, which begins abruptly at the inner one.
    #[must_use]
    pub fn with_squared_falloff(self) -> Self {
        Self { falloff: Falloff { squared: true, ..self.falloff }, ..self }
    }

    fn relative_intensity(&self, direction: DVec3) -> f64 {
        // |w - a|² = 2 (1 - cos θ), without cancellation in narrow cones.
        self.falloff.at(0.5 * (direction - self.frame.z).length_squared())
    }
}

impl Falloff {
    fn at(&self, v: f64) -> f64 {
        if v <= self.inner {
            1.0
        } else if v < self.outer {
            let t = (self.outer - v) / (self.outer - self.inner);
            if self.squared { t * t } else { t * t * (3.0 - 2.0 * t) }
        } else {
            0.0
        }
    }

    /// The integral over solid angle.
    fn solid_angle(&self) -> f64 {
        let share = if self.squared { 1.0 / 3.0 } else { 0.5 };
        2.0 * PI * (self.inner + share * (self.outer - self.inner))
    }

    /// `v` with density in proportion to the falloff.
    fn sample(&self, u: f64) -> f64 {
        let inner_share = 2.0 * PI * self.inner / self.solid_angle();
        if u < inner_share {
            self.inner * (u / inner_share)
        } else {
            let rest = ((u - inner_share) / (1.0 - inner_share)).clamp(0.0, 1.0);
            let t = if self.squared { rest.cbrt() } else { square_to_smoothstep(rest) };
            self.outer - t * (self.outer - self.inner)
        }
    }
}

impl Endpoint for SpotLight {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        Some(PointSample { point: SurfacePoint::dirac(self.position), pdf: PerArea(1.0) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction = self.frame.to_world(direction_from_one_minus_cosine(self.falloff.sample(u.x), u.y));
        let pdf = self.direction_pdf(point, direction);
        // At the rim, where intensity vanishes, rounding may step out of the cone.
        (pdf.value() > 0.0).then(|| DirectionSample { from: *point, direction, pdf, weight: self.power() })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, direction: DVec3) -> PerProjected {
        PerProjected(self.relative_intensity(direction) / self.falloff.solid_angle())
    }

    fn emit(&self, _point: &SurfacePoint, direction: DVec3) -> Rgb {
        self.intensity * self.relative_intensity(direction)
    }
}

impl Light for SpotLight {
    fn power(&self) -> Rgb {
        self.intensity * self.falloff.solid_angle()
    }

    fn can_be_hit(&self) -> bool {
        false
    }
}
