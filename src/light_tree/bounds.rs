//! Bounds on where lights are and where they shine.

use crate::geometry::Bounds;
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Bounds on a light, or on several: the box that contains them, the largest intensity that leaves
/// it, and the cone of directions that light leaves in (Conty Estevez and Kulla 2018, section 4.1).
///
/// Intensity in a direction at the angle φ from the axis is about `intensity · cos⁺(φ - θ_o)`, and
/// exactly 0 where `φ - θ_o > θ_e`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    /// The box around all points that emit.
    pub bounds: Bounds,
    /// The largest radiant intensity (W/sr, mean over the channels), summed over the lights. Of
    /// lights [without bounds](Self::unbounded), irradiance (W/m²).
    pub intensity: f64,
    /// Unit axis of the cone.
    pub axis: DVec3,
    /// θ_o, half the angle of the cone around the axis that contains the normals.
    pub theta_o: f64,
    /// θ_e, the largest angle from a normal at which light is emitted.
    pub theta_e: f64,
}

impl LightBounds {
    /// The bounds of no light.
    pub const NONE: Self = Self {
        bounds: Bounds::EMPTY,
        intensity: 0.0,
        axis: DVec3::Z,
        theta_o: 0.0,
        theta_e: FRAC_PI_2,
    };

    /// A light that may emit into all directions.
    #[must_use]
    pub const fn isotropic(bounds: Bounds, intensity: f64) -> Self {
        Self { bounds, intensity, axis: DVec3::Z, theta_o: PI, theta_e: FRAC_PI_2 }
    }

    /// A flat light of the given intensity along its normal, which it has times the cosine at an
    /// angle from there: Lambert's law.
    #[must_use]
    pub const fn lambertian(bounds: Bounds, intensity: f64, normal: DVec3) -> Self {
        Self { bounds, intensity, axis: normal, theta_o: 0.0, theta_e: FRAC_PI_2 }
    }

    /// A light without bounds, such as an environment, by the irradiance that it causes where
    /// nothing hides it.
    #[must_use]
    pub const fn unbounded(irradiance: f64) -> Self {
        let bounds = Bounds { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
        Self::isotropic(bounds, irradiance)
    }

    /// True unless it was made by [`unbounded`](Self::unbounded).
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.bounds.is_empty() || (self.bounds.max - self.bounds.min).is_finite()
    }

    /// Bounds on both: the smallest cone that contains two cones has its axis between theirs.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        if self.bounds.is_empty() {
            return other;
        }
        if other.bounds.is_empty() {
            return self;
        }
        let (a, b) = if self.theta_o >= other.theta_o { (self, other) } else { (other, self) };
        let (mut axis, mut theta_o) = (a.axis, a.theta_o);
        let between = match theta_o < PI {
            true => libm::atan2(a.axis.cross(b.axis).length(), a.axis.dot(b.axis)),
            false => 0.0,
        };
        if between + b.theta_o > a.theta_o {
            theta_o = 0.5 * (a.theta_o + between + b.theta_o);
            match a.axis.cross(b.axis).try_normalize() {
                Some(pole) if theta_o < PI => {
                    axis = DQuat::from_axis_angle(pole, theta_o - a.theta_o) * a.axis;
                }
                _ => theta_o = PI,
            }
        }
        Self {
            bounds: a.bounds.union(b.bounds),
            intensity: a.intensity + b.intensity,
            axis,
            theta_o,
            theta_e: a.theta_e.max(b.theta_e),
        }
    }

    /// Measure of the directions that light leaves in, each by the cosine from the cone of normals:
    /// M_Ω = ∫ cos⁺ over the cone, 1 within θ_o.
    pub(super) fn orientation(&self) -> f64 {
        let theta_w = (self.theta_o + self.theta_e).min(PI);
        let (sin, cos) = libm::sincos(self.theta_o);
        2.0 * PI * (1.0 - cos)
            + FRAC_PI_2
                * (2.0 * theta_w * sin
                    - libm::cos(self.theta_o - 2.0 * theta_w)
                    - 2.0 * self.theta_o * sin
                    + cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::{square_to_sphere, testing::random};
    use glam::DVec2;

    #[test]
    fn orientation_is_the_integral_that_it_stands_for() {
        let bounds = Bounds::of_points([DVec3::ZERO]);
        let cone = |theta_o, theta_e| LightBounds {
            theta_o,
            theta_e,
            ..LightBounds::isotropic(bounds, 1.0)
        };
        approx::assert_relative_eq!(
            cone(0.3, FRAC_PI_2).orientation(),
            4.740_240_977,
            max_relative = 1e-9
        );
        for (theta_o, theta_e) in [(0.0, FRAC_PI_2), (1.0, 0.4), (2.5, FRAC_PI_2), (PI, FRAC_PI_2)]
        {
            let end: f64 = f64::min(theta_o + theta_e, PI);
            let n = 200_000;
            let integral: f64 = (0..n)
                .map(|i| (f64::from(i) + 0.5) / f64::from(n) * end)
                .map(|t| 2.0 * PI * t.sin() * f64::max(t - theta_o, 0.0).cos() * end / f64::from(n))
                .sum();
            approx::assert_relative_eq!(
                cone(theta_o, theta_e).orientation(),
                integral,
                max_relative = 1e-8
            );
        }
    }

    #[test]
    fn a_union_contains_both_cones() {
        let mut rng = random(7);
        let bounds = Bounds::of_points([DVec3::ZERO]);
        let mut cone = || LightBounds {
            axis: square_to_sphere(DVec2::new(rng(), rng())),
            theta_o: PI * rng().powi(3),
            ..LightBounds::isotropic(bounds, 1.0)
        };
        for i in 0..2000 {
            let (a, b) = (cone(), cone());
            let b = if i % 50 == 0 { LightBounds { axis: -a.axis, ..b } } else { b };
            let both = a.union(b);
            for side in [a, b] {
                let between = side.axis.dot(both.axis).clamp(-1.0, 1.0).acos();
                assert!(
                    between + side.theta_o <= both.theta_o + 1e-6 || both.theta_o >= PI,
                    "{a:?} {b:?} {both:?}"
                );
            }
        }
    }
}
