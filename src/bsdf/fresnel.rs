//! Fresnel's equations for unpolarised light, in forms without cancellation.
//!
//! With the relative index `m = n_far / n_near`, `c` and `s` the cosine and sine of the angle on
//! the near side and `q = m cos θ_far = √(m² - s²)`, the amplitudes are `r_s = (c - q)/(c + q)` and
//! `r_p = (m² c - q)/(m² c + q)` (Born and Wolf 1999, section 1.5.2). Both numerators cancel as m →
//! 1. Multiplying by the denominators removes the roots,
//!
//! ```text
//! (c - q)(c + q)         = (1 - m)(1 + m)
//! (m² c - q)(m² c + q)   = (m² - 1)(m c - s)(m c + s)
//! ```
//!
//! so that R keeps its relative precision at m = 1 + 1e-12, at Brewster's angle `m c = s`, and at
//! the critical angle `s = m`, where `q² = (m - s)(m + s) = (m - 1)(m + 1) + c²` vanishes. The same
//! identities hold for the complex index of a conductor.

use super::error::{BsdfError, checked_reflectance};
use crate::math::Rgb;

/// The effect of a smooth interface between two dielectrics on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Reflected fraction R of the power.
    pub reflectance: f64,
    /// Refracted fraction T of the power, computed apart from R: `1 - R` would lose it (and R) near
    /// index matching and grazing angles.
    pub transmittance: f64,
    /// |cos| of the refracted ray's angle; 0 under total internal reflection.
    pub refracted_cosine: f64,
}

impl Interface {
    const TOTAL_REFLECTION: Self =
        Self { reflectance: 1.0, transmittance: 0.0, refracted_cosine: 0.0 };
}

/// Reflection and refraction at a dielectric interface.
///
/// `cosine` ≥ 0 and `sine` ≥ 0 are of the same angle on the near side, and `relative_ior` = n_far /
/// n_near. The sine is asked for because a local frame knows it exactly where the cosine is nearly
/// 1.
#[inline]
#[must_use]
pub fn dielectric(cosine: f64, sine: f64, relative_ior: f64) -> Interface {
    let m = relative_ior;
    if m == 1.0 {
        return Interface { reflectance: 0.0, transmittance: 1.0, refracted_cosine: cosine };
    }
    let q_squared = difference_of_squares(m, cosine, sine);
    if q_squared <= 0.0 {
        return Interface::TOTAL_REFLECTION;
    }
    let q = q_squared.sqrt();
    let refracted_cosine = q / m;
    let (s, p) = polarised_reflectances(cosine, sine, m, q);
    Interface {
        reflectance: (0.5 * (s + p)).min(1.0),
        transmittance: transmittance(cosine, refracted_cosine, m),
        refracted_cosine,
    }
}

/// T from the cosines on both sides of an interface. It is the same in both directions, as T of a
/// refracted ray must be.
#[inline]
#[must_use]
pub fn transmittance(cosine_near: f64, cosine_far: f64, relative_ior: f64) -> f64 {
    let m = relative_ior;
    if m == 1.0 {
        return 1.0;
    }
    let product = 4.0 * m * cosine_near * cosine_far;
    if product == 0.0 {
        return 0.0;
    }
    let s = cosine_near + m * cosine_far;
    let p = m * cosine_near + cosine_far;
    (0.5 * product * (1.0 / (s * s) + 1.0 / (p * p))).min(1.0)
}

/// `m² - s²` from the smaller one of sine and cosine, whose rounding error is the smaller one, too.
#[inline]
pub(crate) fn difference_of_squares(m: f64, cosine: f64, sine: f64) -> f64 {
    if sine < cosine { (m - sine) * (m + sine) } else { (m - 1.0) * (m + 1.0) + cosine * cosine }
}

/// (R_s, R_p); `q = m cos θ_far`.
fn polarised_reflectances(c: f64, s: f64, m: f64, q: f64) -> (f64, f64) {
    let difference = (m - 1.0) * (m + 1.0);
    let sum_s = c + q;
    let sum_p = m * m * c + q;
    let r_s = difference / (sum_s * sum_s);
    let r_p = difference * (m * c - s) * (m * c + s) / (sum_p * sum_p);
    (r_s * r_s, r_p * r_p)
}

/// R of a conductor with the complex index `eta + i k`, relative to the medium outside.
///
/// `cosine` ≥ 0 and `sine` ≥ 0 are of the same angle.
#[must_use]
pub fn conductor(cosine: f64, sine: f64, eta: f64, k: f64) -> f64 {
    let (c, s) = (cosine, sine);
    let m2 = ((eta - k) * (eta + k), 2.0 * eta * k);
    let q = complex_sqrt(difference_of_squares(eta, c, s) - k * k, m2.1);
    // |1 - m²|², |m² c² - s²|² and the squared norms of the denominators of both polarisations
    let difference = ((1.0 - eta) * (1.0 - eta) + k * k) * ((1.0 + eta) * (1.0 + eta) + k * k);
    if difference == 0.0 {
        return 0.0;
    }
    let brewster = norm_squared(m2.0 * c * c - s * s, m2.1 * c * c);
    let sum_s = norm_squared(c + q.0, q.1);
    let sum_p = norm_squared(m2.0 * c + q.0, m2.1 * c + q.1);
    let r_s = difference / (sum_s * sum_s);
    let r_p = difference * brewster / (sum_p * sum_p);
    let reflectance = 0.5 * (r_s + r_p);
    // 0/0 only where no wave enters: an index of 0
    if reflectance.is_nan() { 1.0 } else { reflectance.min(1.0) }
}

fn norm_squared(re: f64, im: f64) -> f64 {
    re * re + im * im
}

/// The root with positive real part, for im ≥ 0.
fn complex_sqrt(re: f64, im: f64) -> (f64, f64) {
    let large = (0.5 * (norm_squared(re, im).sqrt() + re.abs())).sqrt();
    if large == 0.0 {
        return (0.0, 0.0);
    }
    let small = 0.5 * im / large;
    if re >= 0.0 { (large, small) } else { (small, large) }
}

/// The reflectance of an opaque mirror-like surface as a function of the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reflectance {
    /// The same at all angles.
    Constant(Rgb),
    /// Fresnel's equations with a complex index per channel, relative to the medium outside.
    Conductor {
        /// Real part.
        eta: Rgb,
        /// Imaginary part (absorption).
        k: Rgb,
    },
}

impl Reflectance {
    /// The same reflectance at all angles.
    ///
    /// # Errors
    /// If a channel is not in [0, 1].
    pub fn constant(reflectance: Rgb) -> Result<Self, BsdfError> {
        checked_reflectance(reflectance).map(Self::Constant)
    }

    /// Fresnel's equations with the index `eta + i k` relative to the medium outside.
    ///
    /// # Errors
    /// If a component is not in [0, 1e6].
    pub fn conductor(eta: Rgb, k: Rgb) -> Result<Self, BsdfError> {
        let valid = eta.0.iter().chain(&k.0).all(|component| (0.0..=1e6).contains(component));
        if valid { Ok(Self::Conductor { eta, k }) } else { Err(BsdfError::ComplexIor(eta, k)) }
    }

    /// The reflectance at one angle, given its cosine and sine, both ≥ 0.
    #[inline]
    #[must_use]
    pub fn at(&self, cosine: f64, sine: f64) -> Rgb {
        match *self {
            Self::Constant(reflectance) => reflectance,
            Self::Conductor { eta, k } => Rgb::new(
                conductor(cosine, sine, eta[0], k[0]),
                conductor(cosine, sine, eta[1], k[1]),
                conductor(cosine, sine, eta[2], k[2]),
            ),
        }
    }
}

/// `relative_ior`, if it is in [1e-6, 1e6].
pub(super) fn checked_relative_ior(relative_ior: f64) -> Result<f64, BsdfError> {
    if (1e-6..=1e6).contains(&relative_ior) {
        Ok(relative_ior)
    } else {
        Err(BsdfError::RelativeIor(relative_ior))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn at_degrees(degrees: f64, relative_ior: f64) -> Interface {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        dielectric(cosine, sine, relative_ior)
    }

    #[test]
    fn dielectric_values_of_glass() {
        assert_relative_eq!(at_degrees(0.0, 1.5).reflectance, 0.04, max_relative = 1e-14);
        assert_relative_eq!(
            at_degrees(60.0, 1.5).reflectance,
            0.089_186_712_802_212_78,
            max_relative = 1e-14
        );
        assert_relative_eq!(
            at_degrees(85.0, 1.5).reflectance,
            0.612_799_645_264_827_4,
            max_relative = 1e-14
        );
        assert_relative_eq!(
            at_degrees(89.9, 1.5).reflectance,
            0.989_911_876_919_429_6,
            max_relative = 1e-13
        );
        assert_relative_eq!(
            at_degrees(40.0, 1.0 / 1.5).reflectance,
            0.245_291_204_286_910_9,
            max_relative = 1e-13
        );
        let (sine, cosine) = 1.5f64.atan().sin_cos();
        let q = difference_of_squares(1.5, cosine, sine).sqrt();
        assert!(polarised_reflectances(cosine, sine, 1.5, q).1 < 1e-30);
    }

    #[test]
    fn reflectance_survives_index_matching() {
        assert_relative_eq!(
            dielectric(1.0, 0.0, 1.0 + 1e-6).reflectance,
            2.499_997_500_001_875e-13,
            max_relative = 1e-9
        );
        assert_relative_eq!(
            dielectric(1.0, 0.0, 1.0001).reflectance,
            2.499_750_018_748_75e-9,
            max_relative = 1e-11
        );
        assert_eq!(
            dielectric(0.3, 0.91f64.sqrt(), 1.0),
            Interface { reflectance: 0.0, transmittance: 1.0, refracted_cosine: 0.3 }
        );
        let slab = dielectric(1.0, 0.0, 1.0001);
        // all orders of reflection inside the slab
        let slab =
            slab.transmittance * slab.transmittance / (1.0 - slab.reflectance * slab.reflectance);
        assert_relative_eq!(slab, 0.999_999_995_000_5, max_relative = 1e-14);
    }

    #[test]
    fn total_reflection_begins_at_the_critical_angle() {
        let critical = 41.810_314_895_778_6;
        assert_eq!(
            at_degrees(critical + 1e-7f64.to_degrees(), 1.0 / 1.5),
            Interface::TOTAL_REFLECTION
        );
        let before = at_degrees(critical - 1e-7f64.to_degrees(), 1.0 / 1.5);
        assert!(before.transmittance > 0.0 && before.reflectance < 1.0);
        // cos θ_t = √(2 m cos θ_c δ)/m to first order
        let expected = (2.0 * 1.25f64.sqrt() / 1.5 * 1e-7 * 1.5).sqrt();
        assert_relative_eq!(before.refracted_cosine, expected, max_relative = 1e-6);
    }

    #[test]
    fn power_is_conserved_everywhere() {
        for m in [1e-3, 0.5, 1.0 / 1.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5, 100.0, 1e6] {
            for cosine in [1.0f64, 0.999_999_99, 0.7, 0.1, 1e-3, 1e-8, 1e-12] {
                let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
                let interface = dielectric(cosine, sine, m);
                assert!(
                    (0.0..=1.0).contains(&interface.reflectance)
                        && (0.0..=1.0).contains(&interface.transmittance)
                );
                assert_relative_eq!(
                    interface.reflectance + interface.transmittance,
                    1.0,
                    max_relative = 1e-7
                );
                let c = conductor(cosine, sine, m, 0.0);
                assert_relative_eq!(c, interface.reflectance, max_relative = 1e-9, epsilon = 1e-15);
                for k in [0.0, 1e-6, 3.0, 1e6] {
                    assert!((0.0..=1.0).contains(&conductor(cosine, sine, m, k)));
                }
            }
        }
        assert_eq!(conductor(1.0, 0.0, 0.0, 0.0), 1.0);
    }

    #[test]
    fn conductor_at_normal_incidence() {
        assert_relative_eq!(
            conductor(1.0, 0.0, 0.2, 3.0),
            0.923_371_647_509_578_6,
            max_relative = 1e-14
        );
        assert_relative_eq!(conductor(0.0, 1.0, 0.2, 3.0), 1.0, max_relative = 1e-14);
    }

    #[test]
    fn diffuse_reflectance_of_both_sides() {
        // ∫ 2 μ R(μ) dμ by Simpson's rule in t with μ = t² (from outside, where R varies fastest at
        // grazing angles)
        let average = |relative_ior: f64, from: f64| {
            let n = 20_000;
            (0..=n)
                .map(|i| {
                    let t = from + (1.0 - from) * f64::from(i) / f64::from(n);
                    // μ² = μ_c² + t²: the square root at the critical angle becomes smooth
                    let critical = (1.0 - relative_ior.min(1.0).powi(2)).max(0.0);
                    let mu2 = critical + (1.0 - critical) * t * t;
                    let weight = if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
                    let reflectance =
                        dielectric(mu2.sqrt(), (1.0 - mu2).max(0.0).sqrt(), relative_ior)
                            .reflectance;
                    weight * reflectance * 2.0 * t * (1.0 - critical)
                })
                .sum::<f64>()
                / (3.0 * f64::from(n))
                + (1.0 - relative_ior.min(1.0).powi(2)).max(0.0)
        };
        assert_relative_eq!(average(1.5, 0.0), 0.091_777_959_342_351_21, max_relative = 1e-9);
        assert_relative_eq!(average(1.0 / 1.5, 0.0), 0.596_345_759_707_711_6, max_relative = 1e-9);
    }
}
