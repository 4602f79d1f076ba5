//! A spot light: a point light that shines into a cone.

use super::{AnyLight, DirectionSample, Endpoint, EndpointError, Light, PointSample, check};
use crate::geometry::{Bounds, Frame, SurfacePoint};
use crate::light_tree::LightBounds;
use crate::math::warp::{direction_from_one_minus_cosine, square_to_smoothstep};
use crate::math::{PerArea, PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

const OBJECT: &str = "spot light";

/// A point that emits full intensity into a cone and falls off smoothly to zero in a wider one
/// around it.
///
/// Between the cones the intensity is `3t² - 2t³` with t linear in `cos θ`, from 0 at the outer
/// cone to 1 at the inner one. Its integral over solid angle is half that of the full shell, so
/// power is known in closed form and directions are sampled exactly in proportion to intensity.
/// With [squared falloff](SpotLight::with_squared_falloff) it is t², whose integral is a third.
/// With [linear falloff](SpotLight::with_linear_falloff) it is linear in θ instead; directions are
/// then uniform in the shell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    position: DVec3,
    intensity: Rgb,
    frame: Frame,
    falloff: Falloff,
}

/// The intensity relative to the axis as a function of `v = 1 - cos θ`, which is uniform in solid
/// angle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Falloff {
    inner: f64,
    outer: f64,
    shape: FalloffShape,
}

/// The intensity between the cones.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FalloffShape {
    /// `3t² - 2t³`
    Smooth,
    /// `t²`
    Squared,
    /// Linear in the angle; the angles of the cones in radians.
    Linear([f64; 2]),
}

impl SpotLight {
    /// A light of the given radiant intensity (W/sr) on its axis. Angles are measured from the
    /// axis, in degrees: full intensity up to `inner_degrees`, none from `outer_degrees` on.
    ///
    /// # Errors
    /// If a number is not finite, the intensity negative, the axis zero, or not `0 <= inner_degrees
    /// <= outer_degrees <= 180` with `outer_degrees > 0`.
    pub fn new(
        position: DVec3,
        axis: DVec3,
        intensity: Rgb,
        inner_degrees: f64,
        outer_degrees: f64,
    ) -> Result<Self, EndpointError> {
        let intensity = check::emission(OBJECT, "intensity", intensity)?;
        let position = check::position(OBJECT, "position", position)?;
        let frame = Frame::from_normal(check::direction(OBJECT, "axis", axis)?);
        if !(outer_degrees > 0.0 && outer_degrees <= 180.0) {
            let range = "(0, 180]";
            return Err(EndpointError::AngleOutOfRange {
                object: OBJECT,
                quantity: "outer angle",
                degrees: outer_degrees,
                range,
            });
        }
        if !(inner_degrees >= 0.0 && inner_degrees <= outer_degrees) {
            let range = "[0, outer angle]";
            return Err(EndpointError::AngleOutOfRange {
                object: OBJECT,
                quantity: "inner angle",
                degrees: inner_degrees,
                range,
            });
        }
        let one_minus_cosine = |degrees: f64| 2.0 * libm::sin(0.5 * degrees.to_radians()).powi(2);
        let falloff = Falloff {
            inner: one_minus_cosine(inner_degrees),
            outer: one_minus_cosine(outer_degrees),
            shape: FalloffShape::Smooth,
        };
        check::positive(OBJECT, "solid angle", falloff.solid_angle())?;
        Ok(Self { position, intensity, frame, falloff })
    }

    /// The same light with an intensity between the cones that is linear in the angle from the
    /// axis.
    #[must_use]
    pub fn with_linear_falloff(mut self) -> Self {
        let angle = |v: f64| 2.0 * libm::asin((0.5 * v).sqrt());
        self.falloff.shape =
            FalloffShape::Linear([angle(self.falloff.inner), angle(self.falloff.outer)]);
        self
    }

    /// The same light with the intensity t² between the cones, t linear in the cosine: that of
    /// glTF, which has a kink at the inner cone.
    #[must_use]
    pub fn with_squared_falloff(mut self) -> Self {
        self.falloff.shape = FalloffShape::Squared;
        self
    }

    fn relative_intensity(&self, direction: DVec3) -> f64 {
        self.falloff.at(self.one_minus_cosine(direction))
    }

    fn one_minus_cosine(&self, direction: DVec3) -> f64 {
        // |w - a|² = 2 (1 - cos θ), without cancellation in narrow cones.
        0.5 * (direction - self.frame.z).length_squared()
    }
}

impl Falloff {
    fn at(&self, v: f64) -> f64 {
        if v <= self.inner {
            return 1.0;
        } else if v >= self.outer {
            return 0.0;
        }
        let t = (self.outer - v) / (self.outer - self.inner);
        match self.shape {
            FalloffShape::Smooth => t * t * (3.0 - 2.0 * t),
            FalloffShape::Squared => t * t,
            FalloffShape::Linear([inner, outer]) => {
                ((outer - 2.0 * libm::asin((0.5 * v).sqrt())) / (outer - inner)).clamp(0.0, 1.0)
            }
        }
    }

    /// The integral over solid angle.
    fn solid_angle(&self) -> f64 {
        2.0 * PI * (self.inner + self.shell())
    }

    /// The integral over the shell in units of `1 - cos θ`: `cos a - (sin b - sin a)/(b - a)` for a
    /// falloff that is linear in the angle from a to b, here by its halved angles, which do not
    /// cancel.
    fn shell(&self) -> f64 {
        match self.shape {
            FalloffShape::Squared => (self.outer - self.inner) / 3.0,
            FalloffShape::Linear([a, b]) if b > a => {
                let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
                let sinc =
                    if half > 1e-4 { libm::sin(half) / half } else { 1.0 - half * half / 6.0 };
                // cos a - cos m + cos m (1 - sinc)
                2.0 * libm::sin(0.5 * (a + middle)) * libm::sin(0.5 * half)
                    + libm::cos(middle) * (1.0 - sinc)
            }
            _ => 0.5 * (self.outer - self.inner),
        }
    }

    /// Samples `v`, uniform in the inner cone; in the shell in proportion to the falloff, or
    /// uniform if that is linear in the angle. The inner cone's share is its share of the whole
    /// integral.
    fn sample(&self, u: f64) -> f64 {
        let inner_share = self.inner_share();
        if u < inner_share {
            return self.inner * (u / inner_share);
        }
        let rest = ((u - inner_share) / (1.0 - inner_share)).clamp(0.0, 1.0);
        let t = match self.shape {
            FalloffShape::Smooth => square_to_smoothstep(rest),
            FalloffShape::Squared => libm::cbrt(rest),
            FalloffShape::Linear(_) => rest,
        };
        self.outer - t * (self.outer - self.inner)
    }

    fn inner_share(&self) -> f64 {
        self.inner / (self.inner + self.shell())
    }

    /// Density of `sample` per solid angle.
    fn pdf(&self, v: f64) -> f64 {
        if v <= self.inner || !matches!(self.shape, FalloffShape::Linear(_)) {
            self.at(v) / self.solid_angle()
        } else if v < self.outer {
            (1.0 - self.inner_share()) / (2.0 * PI * (self.outer - self.inner))
        } else {
            0.0
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
        let direction =
            self.frame.to_world(direction_from_one_minus_cosine(self.falloff.sample(u.x), u.y));
        let pdf = self.direction_pdf(point, direction);
        // At the rim, where intensity vanishes, rounding may step out of the cone.
        (pdf.value() > 0.0).then(|| DirectionSample {
            from: *point,
            direction,
            pdf,
            weight: self.emit(point, direction) / pdf.value(),
        })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, direction: DVec3) -> PerProjected {
        PerProjected(self.falloff.pdf(self.one_minus_cosine(direction)))
    }

    fn emit(&self, _point: &SurfacePoint, direction: DVec3) -> Rgb {
        self.intensity * self.relative_intensity(direction)
    }
}

impl Light for SpotLight {
    fn power(&self) -> Rgb {
        self.intensity * self.falloff.solid_angle()
    }

    /// The cosine of the angle from the inner cone stands for the falloff.
    fn bounds(&self) -> Option<LightBounds> {
        let angle = |one_minus_cosine: f64| 2.0 * libm::asin((0.5 * one_minus_cosine).sqrt());
        let [theta_o, outer] = [self.falloff.inner, self.falloff.outer].map(angle);
        let place = Bounds::of_points([self.position]);
        let everywhere = LightBounds::isotropic(place, self.intensity.mean());
        let theta_e = outer - theta_o;
        Some(match theta_e <= FRAC_PI_2 {
            true => LightBounds { axis: self.frame.z, theta_o, theta_e, ..everywhere },
            false => everywhere,
        })
    }

    fn can_be_hit(&self) -> bool {
        false
    }

    fn is_black(&self) -> bool {
        self.intensity.is_black()
    }

    fn into_any(self) -> AnyLight {
        AnyLight::Spot(Box::new(self))
    }
}
