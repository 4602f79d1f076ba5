//! The Beckmann distribution of micro-normals with Smith's masking (Beckmann and Spizzichino 1963;
//! Walter et al. 2007; Heitz 2014).
//!
//! The slopes of the surface are Gaussian. With `r(w) = √(α_x² x² + α_y² y²)`, `a = z/r` and
//! Smith's `Λ = e^{-a²}/(2 a √π) - erfc(a)/2`, everything is written with the *projected area* of
//! the micro-surface towards w,
//!
//! ```text
//! P(w) = z (1 + Λ(w)) = z (1 + erf a)/2 + r e^{-a²}/(2 √π)
//! G1(o)    = o_z / P(o)
//! G2(o, i) = o_z i_z / (o_z P(i) + i_z P(o) - o_z i_z)                       height-correlated
//! D_o(h)   = D(h) (o·h) / P(o)
//! ```
//!
//! which is finite at grazing angles. This G2 is of directions on the same side;
//! [`microfacets`](super::microfacets) has that of opposite sides. Λ is exact and not the rational
//! fit of Walter et al., so visible normals are sampled exactly.

use super::BsdfError;
use super::ggx::{LEAST_ALPHA, checked_alpha};
use super::microfacets::Masked;
use crate::math::erf;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_2_SQRT_PI, PI};

/// An anisotropic Beckmann distribution; x and y are the axes of the local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann {
    alpha_x: f64,
    alpha_y: f64,
    smooth: bool,
    pub(super) independent: bool,
}

/// Slopes beyond this have a probability below the resolution of f64.
const STEEPEST: f64 = erf::FARTHEST;

impl Beckmann {
    /// A distribution with the roughness `alpha_x` along x and `alpha_y` along y: √2 times the
    /// standard deviation of the slope.
    ///
    /// # Errors
    /// If a roughness is not in [0, 10].
    pub fn new(alpha_x: f64, alpha_y: f64) -> Result<Self, BsdfError> {
        let ([alpha_x, alpha_y], smooth) = checked_alpha(alpha_x, alpha_y)?;
        Ok(Self { alpha_x, alpha_y, smooth, independent: false })
    }

    /// Roughnesses that are known to be at most 10, raised to
    /// [`LEAST_ALPHA`]: never smooth.
    pub(super) const fn raised(alpha_x: f64, alpha_y: f64) -> Self {
        let (alpha_x, alpha_y) = (alpha_x.max(LEAST_ALPHA), alpha_y.max(LEAST_ALPHA));
        Self { alpha_x, alpha_y, smooth: false, independent: false }
    }

    /// The same distribution with masking and shadowing taken as independent, `G2 = G1 G1`.
    #[must_use]
    pub const fn with_independent_masking(self) -> Self {
        Self { independent: true, ..self }
    }

    /// The same roughness in all directions.
    ///
    /// # Errors
    /// If `alpha` is not in [0, 10].
    pub fn isotropic(alpha: f64) -> Result<Self, BsdfError> {
        Self::new(alpha, alpha)
    }

    /// True if both roughnesses are below [`LEAST_ALPHA`], so that models
    /// are to behave as their smooth counterparts.
    #[inline]
    #[must_use]
    pub const fn is_smooth(&self) -> bool {
        self.smooth
    }

    /// Density D of micro-normals, 1/sr, so that `∫ D(h) h_z dh = 1` (Walter et al. 2007, eq. 25,
    /// anisotropic).
    #[inline]
    #[must_use]
    pub fn density(&self, normal: DVec3) -> f64 {
        let (x, y) = (normal.x / self.alpha_x, normal.y / self.alpha_y);
        let z2 = normal.z * normal.z;
        let gaussian = libm::exp(-(x * x + y * y) / z2);
        // 0/0 in the plane of the surface
        if gaussian > 0.0 { gaussian / (PI * self.alpha_x * self.alpha_y * z2 * z2) } else { 0.0 }
    }

    /// Area of the micro-surface projected to the direction, `z (1 + Λ)`, per unit of macroscopic
    /// area.
    #[inline]
    #[must_use]
    pub fn projected_area(&self, direction: DVec3) -> f64 {
        let r = DVec2::new(self.alpha_x * direction.x, self.alpha_y * direction.y).length();
        projected(direction.z, r, direction.z / r).0
    }

    /// Smith's masking G1: the visible fraction of the micro-surface that faces the direction.
    #[inline]
    #[must_use]
    pub fn masking(&self, direction: DVec3) -> f64 {
        direction.z / self.projected_area(direction)
    }

    /// `G2 / (2 a_z b_z)` of directions on the same side, finite at grazing angles.
    #[inline]
    #[must_use]
    pub fn correlation(&self, a: DVec3, b: DVec3) -> f64 {
        self.masked(a, b).correlation
    }

    /// The masking of two directions on the same side.
    #[inline]
    pub(super) fn masked(&self, a: DVec3, b: DVec3) -> Masked {
        let areas = [self.projected_area(a), self.projected_area(b)];
        let correlation = if self.independent {
            0.5 / areas[0] / areas[1]
        } else {
            0.5 / (a.z * areas[1] + b.z * (areas[0] - a.z))
        };
        Masked { areas, correlation }
    }

    /// `G2(seen_from, next) / G1(seen_from)` ≤ 1 of directions on the same side: what is left for
    /// the weight after sampling a visible normal.
    #[inline]
    #[must_use]
    pub fn shadowing(&self, seen_from: DVec3, next: DVec3) -> f64 {
        2.0 * next.z * self.projected_area(seen_from) * self.correlation(seen_from, next)
    }

    /// Density of the normals seen from a direction, divided by `(seen_from · normal)`, 1/sr.
    #[inline]
    #[must_use]
    pub fn visible_density_over_cosine(&self, seen_from: DVec3, normal: DVec3) -> f64 {
        self.density(normal) / self.projected_area(seen_from)
    }

    /// Samples a normal among those seen from a direction, in proportion to their projected area.
    ///
    /// After stretching, roughness is 1 and the view may be turned to the x axis: the slope across
    /// it is Gaussian, and the slope x along it has the density `(z - x r) e^{-x²}/√π` up to z/r,
    /// whose integral, the projected area up to x, is inverted (Heitz and d'Eon 2014). `None` where
    /// rounding leaves no normal.
    #[must_use]
    pub fn sample_visible(&self, seen_from: DVec3, u: DVec2) -> Option<DVec3> {
        let stretched = DVec2::new(self.alpha_x * seen_from.x, self.alpha_y * seen_from.y);
        let axis = stretched.try_normalize().unwrap_or(DVec2::X);
        let slope = axis * inverse(seen_from.z, stretched.length(), u.x)
            + axis.perp() * inverse(1.0, 0.0, u.y);
        let normal =
            DVec3::new(-self.alpha_x * slope.x, -self.alpha_y * slope.y, 1.0).try_normalize()?;
        // beyond the horizon of the view only by rounding
        (normal.dot(seen_from) > 0.0).then_some(normal)
    }
}

/// Projected area, towards a view of height z and stretched length r, of all slopes up to `x`; and
/// `e^{-x²}`.
#[inline]
fn projected(z: f64, r: f64, x: f64) -> (f64, f64) {
    // All that the other terms would add is rounding.
    if x >= STEEPEST {
        return (z, 0.0);
    }
    let gaussian = libm::exp(-x * x);
    (0.5 * z * erf::complement(-x, gaussian) + 0.25 * FRAC_2_SQRT_PI * r * gaussian, gaussian)
}

/// The slope below which the share `u` of the projected area lies: from that of a Gaussian, which
/// it is for r = 0, by an iteration of fourth order, kept inside a shrinking bracket.
fn inverse(z: f64, r: f64, u: f64) -> f64 {
    let gaussian_slope = erf::quantile(u);
    if let Some(slope) = gaussian_slope.filter(|_| r == 0.0) {
        return slope;
    }
    let (mut low, mut high) = (-STEEPEST, (z / r).min(STEEPEST));
    let target = u * projected(z, r, z / r).0;
    // Away from the upper end, where the density is 0.
    let start = gaussian_slope.unwrap_or(if u < 0.5 { -2.5 } else { 2.5 });
    let mut x = start.min(0.5 * high).min(high - 0.5).max(low);
    let (mut area, mut gaussian) = if gaussian_slope == Some(x) {
        let gaussian = libm::exp(-x * x);
        (u * z + 0.25 * FRAC_2_SQRT_PI * r * gaussian, gaussian)
    } else {
        projected(z, r, x)
    };
    // Halving alone would end after 53 steps; others take 1 to 3.
    for _ in 0..64 {
        let miss = area - target;
        if miss > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let height = z - x * r;
        let newton = -miss / (0.5 * FRAC_2_SQRT_PI * height * gaussian);
        // Newton's step times half the logarithmic derivative of the density, which it takes for
        // constant.
        let steepness = r / height;
        let bend = newton * (x + 0.5 * steepness);
        // Halley's step with the next term of the inverse series; Newton's where it is too long,
        // which then halves the bracket.
        let fourth = newton / (1.0 - bend)
            + newton * (bend * bend / 3.0 + newton * newton * (2.0 + steepness * steepness) / 6.0);
        let step = if bend.abs() < 0.5 { fourth } else { newton };
        let is_inside = x + step >= low && x + step <= high;
        let next = if is_inside { x + step } else { 0.5 * (low + high) };
        let step = (next - x).abs();
        // What is left is of fourth order in this.
        let size = step * (1.0 + x.abs() + steepness);
        if step <= 1e-15 * (1.0 + x.abs()) || (is_inside && size < 1e-4) {
            return next;
        }
        x = next;
        (area, gaussian) = projected(z, r, x);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    /// ∫ g(h) dh over the upper hemisphere by the midpoint rule in the slopes, scaled to the
    /// roughness: dh = h_z³ dx dy.
    fn integrate(alpha: (f64, f64), g: impl Fn(DVec3) -> f64) -> f64 {
        let n = 1200;
        let step = 13.0 / f64::from(n);
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let (x, y) = ((f64::from(i) + 0.5) * step - 6.5, (f64::from(j) + 0.5) * step - 6.5);
                let h = DVec3::new(-alpha.0 * x, -alpha.1 * y, 1.0).normalize();
                sum += g(h) * h.z.powi(3);
            }
        }
        sum * step * step * alpha.0 * alpha.1
    }

    #[test]
    fn projected_area_is_conserved() {
        for alpha in [(1.0, 1.0), (0.3, 0.3), (0.1, 0.5), (1e-3, 1e-3)] {
            let beckmann = Beckmann::new(alpha.0, alpha.1).unwrap();
            assert_relative_eq!(
                integrate(alpha, |h| beckmann.density(h) * h.z),
                1.0,
                max_relative = 1e-9
            );
            for cosine in [1.0f64, 0.5, 0.1, 1e-3] {
                let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
                let o = DVec3::new(0.6 * sine, 0.8 * sine, cosine);
                let visible = integrate(alpha, |h| {
                    beckmann.visible_density_over_cosine(o, h) * o.dot(h).max(0.0)
                });
                assert_relative_eq!(visible, 1.0, max_relative = 1e-4);
            }
        }
    }

    #[test]
    fn masking_agrees_with_its_definition() {
        let beckmann = Beckmann::new(0.2, 0.7).unwrap();
        let (a, b) = (DVec3::new(0.6, 0.48, 0.64), DVec3::new(-0.36, 0.48, 0.8));
        let lambda = |w: DVec3| {
            let a = w.z / ((0.2 * w.x).powi(2) + (0.7 * w.y).powi(2)).sqrt();
            0.5 * (libm::erf(a) - 1.0) + (-a * a).exp() / (2.0 * a * PI.sqrt())
        };
        let both = 1.0 / (1.0 + lambda(a) + lambda(b));
        assert_relative_eq!(beckmann.masking(a), 1.0 / (1.0 + lambda(a)), max_relative = 1e-14);
        assert_relative_eq!(
            2.0 * a.z * b.z * beckmann.correlation(a, b),
            both,
            max_relative = 1e-14
        );
        assert_relative_eq!(
            beckmann.shadowing(a, b),
            both * (1.0 + lambda(a)),
            max_relative = 1e-14
        );
    }

    #[test]
    fn slopes_invert_their_distribution() {
        for (z, r) in [(1.0, 0.0), (0.9, 0.1), (0.5, 0.4), (0.1, 0.9), (1e-9, 0.3), (1e-14, 10.0)] {
            let total = projected(z, r, z / r).0;
            for i in 0..200 {
                let u = (f64::from(i) + 0.5) / 200.0;
                let x = inverse(z, r, u);
                assert!(x <= z / r, "{z} {r} {u} {x}");
                assert_relative_eq!(projected(z, r, x).0 / total, u, epsilon = 1e-13);
            }
            for u in [0.0, 1e-300, 1e-17, 1.0f64.next_down()] {
                assert!(inverse(z, r, u).is_finite());
            }
        }
    }

    #[test]
    fn visible_normals_exist_at_the_ends_of_the_unit_square() {
        let one = 1.0f64.next_down();
        for alpha in [0.0, 1e-4, 0.3, 10.0] {
            let beckmann = Beckmann::isotropic(alpha).unwrap();
            for cosine in [1.0f64, 0.5, 1e-8, 1e-13] {
                let (sin, cos) = (0.1 * TAU).sin_cos();
                let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
                let o = DVec3::new(sine * cos, sine * sin, cosine);
                for u in [(0.0, 0.0), (0.0, one), (one, 0.0), (one, one), (0.5, one)] {
                    if let Some(h) = beckmann.sample_visible(o, DVec2::new(u.0, u.1)) {
                        assert!(h.is_normalized() && h.z > 0.0, "{h}");
                    }
                }
            }
        }
    }
}
