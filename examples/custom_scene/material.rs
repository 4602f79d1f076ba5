//! The host's material.

use pathspace::bsdf::{Bsdf, BsdfSample, Lobes, TransportMode};
use pathspace::geometry::Frame;
use pathspace::glam::{DVec2, DVec3};
use pathspace::math::warp::square_to_cosine_hemisphere;
use pathspace::math::{PerProjected, Rgb};
use std::f64::consts::{FRAC_1_PI, TAU};

/// A two-sided diffuse surface with a retro-reflective lobe, as on traffic signs: `f = ρ_d/π + ρ_r
/// (n+2)/(2π) max(0, ω_light · ω_camera)ⁿ`.
///
/// Directions are in the frame of the surface, z = normal, and point away from it. Densities are
/// per projected solid angle: a density per solid angle, divided by the cosine.
pub struct RetroReflector {
    pub diffuse: Rgb,
    pub retro: Rgb,
    pub exponent: f64,
}

impl RetroReflector {
    /// Probability of sampling the retro-reflective lobe.
    fn retro_probability(&self) -> f64 {
        let (diffuse, retro) = (self.diffuse.mean(), self.retro.mean());
        if retro > 0.0 { retro / (diffuse + retro) } else { 0.0 }
    }
}

impl Bsdf for RetroReflector {
    fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE_REFLECTION | Lobes::GLOSSY_REFLECTION
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        if to_light.z * to_camera.z <= 0.0 {
            return Rgb::BLACK; // nothing is transmitted
        }
        let lobe =
            to_light.dot(to_camera).max(0.0).powf(self.exponent) * (self.exponent + 2.0) / TAU;
        self.diffuse * FRAC_1_PI + self.retro * lobe
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _mode: TransportMode) -> PerProjected {
        if fixed.z * next.z <= 0.0 {
            return PerProjected(0.0);
        }
        // The density of the mixture, whichever lobe was sampled.
        let p = self.retro_probability();
        let lobe = fixed.dot(next).max(0.0).powf(self.exponent) * (self.exponent + 1.0) / TAU;
        PerProjected((1.0 - p) * FRAC_1_PI + p * lobe / next.z.abs())
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let next = if u1 < self.retro_probability() {
            Frame::from_normal(fixed).to_world(power_cosine(self.exponent, u2))
        } else {
            square_to_cosine_hemisphere(u2) * fixed.z.signum()
        };
        let pdf = self.pdf(fixed, next, mode);
        // Below the horizon the lobe is cut off: that light is absorbed.
        (pdf.value() > 0.0).then(|| {
            let (to_light, to_camera) = mode.label(fixed, next);
            let weight = self.eval(to_light, to_camera) / pdf.value();
            BsdfSample {
                next,
                weight,
                pdf,
                pdf_reverse: self.pdf(next, fixed, mode.reversed()),
                dirac: false,
                relative_ior: 1.0,
            }
        })
    }
}

/// A direction around z with the density `(n+1)/(2π) cosⁿ` per solid angle.
pub fn power_cosine(exponent: f64, u: DVec2) -> DVec3 {
    let cos = (1.0 - u.x).powf(1.0 / (exponent + 1.0));
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    DVec3::new(sin * (TAU * u.y).cos(), sin * (TAU * u.y).sin(), cos)
}
