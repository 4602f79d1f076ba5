//! The cone of directions under which a point outside sees a sphere, sampled uniformly by solid
//! angle.
//!
//! With s = r/d the sine of the half angle, the solid angle is `2π (1 - cos θ_max) = 2π s² / (1 +
//! √(1 - s²))`. No step subtracts nearly equal numbers, so the ratio may be 1e-12 as well as almost
//! 1.

use crate::geometry::{Frame, Sphere, SurfacePoint};
use crate::math::angle::sin_cos_of_turn;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// See the module's documentation.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphereCone<'s> {
    sphere: &'s Sphere,
    /// Unit vector from the centre to the receiver.
    to_receiver: DVec3,
    /// r / d.
    sine: f64,
    /// `1 - cos θ_max`.
    one_minus_cosine_max: f64,
}

impl<'s> SphereCone<'s> {
    /// `None` unless the sphere is whole, emits outwards, and the receiver is outside by more than
    /// the rounding of both positions: a point on the sphere itself sees nothing of it, and its
    /// "cone" would be noise.
    #[inline]
    pub(super) fn new(sphere: &'s Sphere, receiver: &SurfacePoint) -> Option<Self> {
        let offset = receiver.position - sphere.center;
        let distance = offset.length();
        let tolerance = receiver.error + 8.0 * f64::EPSILON * sphere.radius;
        let is_outside = distance - sphere.radius > tolerance && distance.is_finite();
        if !sphere.is_whole() || sphere.inward || !is_outside {
            return None;
        }
        let sine = sphere.radius / distance;
        // √(1 - s²), with the difference taken where it is exact.
        let cosine_max =
            ((distance - sphere.radius) * (distance + sphere.radius)).sqrt() / distance;
        let one_minus_cosine_max = sine * sine / (1.0 + cosine_max);
        // Where the solid angle underflows (r/d below 1e-162) there is no density per solid angle;
        // uniform area still has one.
        (one_minus_cosine_max > 0.0).then_some(Self {
            sphere,
            to_receiver: offset / distance,
            sine,
            one_minus_cosine_max,
        })
    }

    /// The point of the sphere seen in a direction uniform in the cone; uv and tangent only if they
    /// are asked for.
    #[inline]
    pub(super) fn sample(&self, u: DVec2, with_uv: bool) -> SurfacePoint {
        // θ at the receiver, φ between the sphere's normal and the direction to the receiver, α = φ
        // - θ at the centre.
        let v = u.x * self.one_minus_cosine_max;
        let cos_theta = 1.0 - v;
        // sin² φ = (sin θ / s)², with s² cancelled.
        let sin2_phi = (v * (2.0 - v) / (self.sine * self.sine)).min(1.0);
        let (sin_phi, cos_phi) = (sin2_phi.sqrt(), (1.0 - sin2_phi).sqrt());
        let cos_alpha = cos_phi * cos_theta + sin2_phi * self.sine;
        let sin_alpha = sin_phi * (cos_theta - self.sine * cos_phi).max(0.0);
        let (sin_turn, cos_turn) = sin_cos_of_turn(u.y);
        let local = DVec3::new(sin_alpha * cos_turn, sin_alpha * sin_turn, cos_alpha);
        let outward = Frame::from_normal(self.to_receiver).to_world(local).normalize();
        if with_uv { self.sphere.point_at(outward) } else { self.sphere.bare_point_at(outward) }
    }

    /// The solid angle of the cone.
    #[inline]
    pub(super) fn solid_angle(&self) -> f64 {
        2.0 * PI * self.one_minus_cosine_max
    }
}
