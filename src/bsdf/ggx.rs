//! The GGX distribution of micro-normals with Smith's masking (Trowbridge and Reitz 1975; Walter et
//! al. 2007; Heitz 2014).
//!
//! Everything is written with the *stretched length* `S(w) = √(α_x² x² + α_y² y² + z²)`, in which
//! Smith's function is `Λ(w) = (S/|z| - 1)/2`. Then masking, shadowing and the density of visible
//! normals need no division that can fail at grazing angles:
//!
//! ```text
//! G1(o)    = 1/(1 + Λ(o))        = 2 o_z / (o_z + S(o))
//! G2(o, i) = 1/(1 + Λ(o) + Λ(i)) = 2 o_z i_z / (i_z S(o) + o_z S(i))          height-correlated
//! D_o(h)   = G1 D (o·h) / o_z    = 2 D(h) (o·h) / (o_z + S(o))
//! ```
//!
//! This G2 is of directions on the same side; [`microfacets`](super::microfacets) has that of
//! opposite sides.
//!
//! Directions and normals here are in the upper hemisphere, z > 0, of the side they are seen from.

use super::BsdfError;
use super::microfacets::Masked;
use crate::math::angle::sin_cos_of_turn;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Roughness below which a surface counts as smooth, and to which the smaller of two roughnesses is
/// raised.
///
/// At this α the albedo is within 1e-3 of that of the smooth surface down to μ = 0.01, and f64
/// keeps D to 1e-11.
pub const LEAST_ALPHA: f64 = 1e-4;

/// Largest accepted roughness; 1 is already a very rough surface.
pub const GREATEST_ALPHA: f64 = 10.0;

/// Cosines below this count as 0 in the rough models: densities per projected solid angle grow like
/// their inverse, and must not overflow.
pub(super) const LEAST_COSINE: f64 = 1e-14;

/// An anisotropic GGX distribution; x and y are the axes of the local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    alpha_x: f64,
    alpha_y: f64,
    smooth: bool,
    pub(super) independent: bool,
}

impl Ggx {
    /// A distribution with the roughness `alpha_x` along x and `alpha_y` along y.
    ///
    /// # Errors
    /// If a roughness is not in [0, 10].
    pub fn new(alpha_x: f64, alpha_y: f64) -> Result<Self, BsdfError> {
        let ([alpha_x, alpha_y], smooth) = checked_alpha(alpha_x, alpha_y)?;
        Ok(Self { alpha_x, alpha_y, smooth, independent: false })
    }

    /// A roughness in all directions that is known to be valid.
    pub(super) const fn of_valid(alpha: f64) -> Self {
        let raised = alpha.max(LEAST_ALPHA);
        let smooth = alpha < LEAST_ALPHA;
        Self { alpha_x: raised, alpha_y: raised, smooth, independent: false }
    }

    /// Roughnesses that are known to be at most [`GREATEST_ALPHA`], raised to
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

    /// True if both roughnesses are below [`LEAST_ALPHA`], so that models are to behave as their
    /// smooth counterparts.
    #[inline]
    #[must_use]
    pub const fn is_smooth(&self) -> bool {
        self.smooth
    }

    /// Density D of micro-normals, 1/sr, so that `∫ D(h) h_z dh = 1` (Walter et al. 2007, eq. 33,
    /// anisotropic).
    ///
    /// Takes the components and not a cosine: sin² from `1 - cos²` makes an error of 300 % at α =
    /// 1e-4 in f32.
    #[inline]
    #[must_use]
    pub fn density(&self, normal: DVec3) -> f64 {
        let (x, y) = (normal.x / self.alpha_x, normal.y / self.alpha_y);
        let e = x * x + y * y + normal.z * normal.z;
        1.0 / (PI * self.alpha_x * self.alpha_y * e * e)
    }

    /// `S(w) = √(α_x² x² + α_y² y² + z²) = |z| (1 + 2 Λ(w))`.
    #[inline]
    #[must_use]
    pub fn stretched_length(&self, direction: DVec3) -> f64 {
        self.stretch(direction).length()
    }

    /// Area of the micro-surface projected to the direction, `z (1 + Λ)`, per unit of macroscopic
    /// area.
    #[inline]
    #[must_use]
    pub fn projected_area(&self, direction: DVec3) -> f64 {
        0.5 * (direction.z + self.stretched_length(direction))
    }

    /// Smith's masking G1: the visible fraction of the micro-surface that faces the direction.
    #[inline]
    #[must_use]
    pub fn masking(&self, direction: DVec3) -> f64 {
        let z = direction.z;
        2.0 * z / (z + self.stretched_length(direction))
    }

    /// Masking and shadowing G2 of directions on the same side, height-correlated (Heitz 2014, eq.
    /// 99) unless they are [independent](Self::with_independent_masking).
    #[inline]
    #[must_use]
    pub fn masking_shadowing(&self, a: DVec3, b: DVec3) -> f64 {
        2.0 * a.z * b.z * self.correlation(a, b)
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
        let lengths = [self.stretched_length(a), self.stretched_length(b)];
        let areas = [0.5 * (a.z + lengths[0]), 0.5 * (b.z + lengths[1])];
        let correlation = if self.independent {
            0.5 / areas[0] / areas[1]
        } else {
            1.0 / (b.z * lengths[0] + a.z * lengths[1])
        };
        Masked { areas, correlation }
    }

    /// `G2(seen_from, next) / G1(seen_from)` ≤ 1 of directions on the same side: what is left for
    /// the weight after sampling a visible normal.
    #[inline]
    #[must_use]
    pub fn shadowing(&self, seen_from: DVec3, next: DVec3) -> f64 {
        next.z
            * (seen_from.z + self.stretched_length(seen_from))
            * self.correlation(seen_from, next)
    }

    /// Density of the normals seen from a direction, divided by `(seen_from · normal)`, 1/sr (Heitz
    /// 2018, eq. 3).
    #[inline]
    #[must_use]
    pub fn visible_density_over_cosine(&self, seen_from: DVec3, normal: DVec3) -> f64 {
        2.0 * self.density(normal) / (seen_from.z + self.stretched_length(seen_from))
    }

    /// Samples a normal among those seen from a direction, in proportion to their projected area.
    ///
    /// In the space where the ellipsoid becomes the unit sphere, the mirror images of the direction
    /// in its visible normals are uniform on a spherical cap (Dupuy and Benyoub 2023). `None` where
    /// rounding leaves no normal.
    #[must_use]
    pub fn sample_visible(&self, seen_from: DVec3, u: DVec2) -> Option<DVec3> {
        let view = self.stretch(seen_from).try_normalize()?;
        // 1 - z of a uniform point on the cap z ≥ -view.z
        let depth = u.y * (1.0 + view.z);
        let radius = (depth * (2.0 - depth)).max(0.0).sqrt();
        let (sin, cos) = sin_cos_of_turn(u.x);
        let mirrored = DVec3::new(radius * cos, radius * sin, 1.0 - depth);
        let normal = self.stretch(mirrored + view).try_normalize()?;
        (normal.z > 0.0).then_some(normal)
    }

    #[inline]
    fn stretch(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.alpha_x * v.x, self.alpha_y * v.y, v.z)
    }
}

/// The two roughnesses, raised to [`LEAST_ALPHA`], and whether both were below it.
pub(super) fn checked_alpha(alpha_x: f64, alpha_y: f64) -> Result<([f64; 2], bool), BsdfError> {
    let range = 0.0..=GREATEST_ALPHA;
    if !range.contains(&alpha_x) || !range.contains(&alpha_y) {
        return Err(BsdfError::Roughness(alpha_x, alpha_y));
    }
    let smooth = alpha_x < LEAST_ALPHA && alpha_y < LEAST_ALPHA;
    Ok(([alpha_x.max(LEAST_ALPHA), alpha_y.max(LEAST_ALPHA)], smooth))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// ∫ g(h) dh over the upper hemisphere, with tan θ = α t/(1 - t) so that the peak is resolved
    /// at any roughness.
    fn integrate(alpha: f64, g: impl Fn(DVec3) -> f64) -> f64 {
        let (n, m) = (4000, 64);
        let mut sum = 0.0;
        for i in 0..n {
            let t = (f64::from(i) + 0.5) / f64::from(n);
            let tan = alpha * t / (1.0 - t);
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            let sin = tan * cos;
            // dθ = cos² d(tan θ)
            let jacobian = sin * cos * cos * alpha / ((1.0 - t) * (1.0 - t));
            for j in 0..m {
                let (s, c) = (2.0 * PI * (f64::from(j) + 0.5) / f64::from(m)).sin_cos();
                sum += jacobian * g(DVec3::new(sin * c, sin * s, cos));
            }
        }
        sum * 2.0 * PI / f64::from(n * m)
    }

    #[test]
    fn projected_area_is_conserved() {
        for (x, y) in [(1.0, 1.0), (0.3, 0.3), (0.1, 0.5), (1e-3, 1e-3), (2e-4, 1e-4)] {
            let ggx = Ggx::new(x, y).unwrap();
            let scale = (x * y).sqrt();
            assert_relative_eq!(
                integrate(scale, |h| ggx.density(h) * h.z),
                1.0,
                max_relative = 1e-5
            );
            for cosine in [1.0f64, 0.5, 0.1] {
                let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
                let o = DVec3::new(0.6 * sine, 0.8 * sine, cosine);
                let visible =
                    integrate(scale, |h| ggx.visible_density_over_cosine(o, h) * o.dot(h).max(0.0));
                assert_relative_eq!(visible, 1.0, max_relative = 2e-3);
            }
        }
    }

    #[test]
    fn visible_normals_exist_at_the_ends_of_the_unit_square() {
        let one = 1.0f64.next_down();
        for alpha in [0.0, 1e-4, 0.3, 10.0] {
            let ggx = Ggx::isotropic(alpha).unwrap();
            for cosine in [1.0f64, 0.5, 1e-8, 1e-13] {
                let o = DVec3::new(((1.0 - cosine) * (1.0 + cosine)).sqrt(), 0.0, cosine);
                for u in [(0.0, 0.0), (0.0, one), (one, 0.0), (one, one), (0.5, one)] {
                    if let Some(h) = ggx.sample_visible(o, DVec2::new(u.0, u.1)) {
                        assert!(h.is_normalized() && h.z > 0.0, "{h}");
                    }
                }
            }
        }
    }

    #[test]
    fn masking_agrees_with_its_definition() {
        let ggx = Ggx::new(0.2, 0.7).unwrap();
        let (a, b) = (DVec3::new(0.6, 0.48, 0.64), DVec3::new(-0.36, 0.48, 0.8));
        let lambda = |w: DVec3| {
            0.5 * ((1.0 + ((0.2 * w.x).powi(2) + (0.7 * w.y).powi(2)) / (w.z * w.z)).sqrt() - 1.0)
        };
        let area = a.z * (1.0 + lambda(a));
        assert_relative_eq!(ggx.projected_area(a), area, max_relative = 1e-14);
        assert_relative_eq!(ggx.masking(a), 1.0 / (1.0 + lambda(a)), max_relative = 1e-14);
        assert_relative_eq!(
            ggx.masking_shadowing(a, b),
            1.0 / (1.0 + lambda(a) + lambda(b)),
            max_relative = 1e-14
        );
        assert_relative_eq!(
            ggx.shadowing(a, b),
            ggx.masking_shadowing(a, b) / ggx.masking(a),
            max_relative = 1e-14
        );
    }
}
