//! The distributions of micro-normals behind one type, and masking-shadowing in both of its forms.
//!
//! A point of the micro-surface at the height below which the share x of the surface lies is seen
//! from a direction above with the probability `x^Λ(o)`, and from one below with `(1 - x)^Λ(i)`.
//! Heights are independent of normals (Smith's assumption), so that two directions are unoccluded
//! together with the probability
//!
//! ```text
//! same side:       G2 = ∫ x^(Λo + Λi) dx       = 1 / (1 + Λo + Λi)      ≥ G1(o) G1(i)
//! opposite sides:  G2 = ∫ x^Λo (1 - x)^Λi dx   = B(1 + Λo, 1 + Λi)      ≤ G1(o) G1(i)
//! ```
//!
//! with Euler's Beta function (Ross, Dion and Potvin 2005 for the first; Heitz 2014 reviews it;
//! Heitz, Hanika, d'Eon and Dachsbacher 2016 use both for single scattering in dielectrics). What
//! is high is seen from above and hidden from below, so that refraction lets less through than if
//! masking and shadowing were independent. Renderers differ here: the product `G1 G1` of Walter et
//! al. (2007) for both is common, and so is the first form for both. For refraction at α = 1, index
//! 1.5 and a cosine of 0.2 these transmit 1.9 and 2.8 times too much in all. The product is offered
//! for agreement with them ([`Microfacets::with_independent_masking`]): reflection is then less by
//! the factor `(1 + Λo + Λi) / ((1 + Λo)(1 + Λi))`.

use super::{Beckmann, Ggx};
use crate::math::binomial::inverse_binomial;
use glam::{DVec2, DVec3};

/// A distribution of micro-normals with its masking: the rough models are made of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Microfacets {
    /// Long tails: most materials.
    Ggx(Ggx),
    /// Gaussian slopes.
    Beckmann(Beckmann),
}

/// The masking of two directions on the same side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Masked {
    /// Projected areas of the micro-surface, `z (1 + Λ)`.
    pub areas: [f64; 2],
    /// `G2 / (2 a_z b_z)`.
    pub correlation: f64,
}

macro_rules! forward {
    ($($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty),*) -> $result:ty;)*) => {$(
        $(#[$doc])*
        #[inline]
        #[must_use]
        pub fn $name(&self, $($argument: $type),*) -> $result {
            match self {
                Self::Ggx(ggx) => ggx.$name($($argument),*),
                Self::Beckmann(beckmann) => beckmann.$name($($argument),*),
            }
        }
    )*};
}

impl Microfacets {
    forward! {
        /// True if models are to behave as their smooth counterparts.
        is_smooth() -> bool;
        /// Density D of micro-normals, 1/sr, so that `∫ D(h) h_z dh = 1`.
        density(normal: DVec3) -> f64;
        /// Smith's masking G1: the visible fraction of the micro-surface that faces the direction.
        masking(direction: DVec3) -> f64;
        /// Area of the micro-surface projected to the direction, `z (1 + Λ)`, per unit of
        /// macroscopic area.
        projected_area(direction: DVec3) -> f64;
        /// `G2 / (2 a_z b_z)` of directions on the same side, finite at grazing angles.
        correlation(a: DVec3, b: DVec3) -> f64;
        /// `G2(seen_from, next) / G1(seen_from)` ≤ 1 of directions on the same side: what is left
        /// for the weight after sampling a visible normal.
        shadowing(seen_from: DVec3, next: DVec3) -> f64;
        /// Density of the normals seen from a direction, divided by `(seen_from · normal)`, 1/sr.
        visible_density_over_cosine(seen_from: DVec3, normal: DVec3) -> f64;
        /// Samples a normal among those seen from a direction, in proportion to their projected
        /// area; `None` where rounding leaves none.
        sample_visible(seen_from: DVec3, u: DVec2) -> Option<DVec3>;
    }

    /// The same distribution with other roughnesses, at most 10 and raised to
    /// [`LEAST_ALPHA`](super::ggx::LEAST_ALPHA): it is never smooth.
    pub(super) const fn with_roughness(self, alpha_x: f64, alpha_y: f64) -> Self {
        let raised = match self {
            Self::Ggx(_) => Self::Ggx(Ggx::raised(alpha_x, alpha_y)),
            Self::Beckmann(_) => Self::Beckmann(Beckmann::raised(alpha_x, alpha_y)),
        };
        if self.is_independent() { raised.with_independent_masking() } else { raised }
    }

    /// The same distribution with masking and shadowing taken as independent, `G2 = G1 G1` on the
    /// same side and on opposite sides (Walter et al. 2007, eq. 23).
    #[must_use]
    pub const fn with_independent_masking(self) -> Self {
        match self {
            Self::Ggx(ggx) => Self::Ggx(ggx.with_independent_masking()),
            Self::Beckmann(beckmann) => Self::Beckmann(beckmann.with_independent_masking()),
        }
    }

    const fn is_independent(&self) -> bool {
        match self {
            Self::Ggx(ggx) => ggx.independent,
            Self::Beckmann(beckmann) => beckmann.independent,
        }
    }

    /// The masking of two directions on the same side.
    #[inline]
    pub(super) fn masked(&self, a: DVec3, b: DVec3) -> Masked {
        match self {
            Self::Ggx(ggx) => ggx.masked(a, b),
            Self::Beckmann(beckmann) => beckmann.masked(a, b),
        }
    }

    /// `G2 / (2 a_z b_z)` of directions on opposite sides, each with z > 0 seen from its own side.
    #[inline]
    #[must_use]
    pub fn correlation_across(&self, a: DVec3, b: DVec3) -> f64 {
        let areas = [self.projected_area(a), self.projected_area(b)];
        if self.is_independent() {
            return 0.5 / areas[0] / areas[1];
        }
        across((a.z, areas[0]), (b.z, areas[1]))
    }

    /// `G2(seen_from, next) / G1(seen_from)` ≤ 1 of directions on opposite sides, each with z > 0
    /// seen from its own side.
    #[inline]
    #[must_use]
    pub fn shadowing_across(&self, seen_from: DVec3, next: DVec3) -> f64 {
        2.0 * next.z * self.projected_area(seen_from) * self.correlation_across(seen_from, next)
    }
}

/// `B(1 + Λa, 1 + Λb) / (2 a_z b_z)` of z and `P = z (1 + Λ)` for both directions: what the same
/// side has, over a binomial coefficient. An absolute error of Λ is harmless, so that `P/z - 1` may
/// cancel.
fn across((a_z, a_area): (f64, f64), (b_z, b_area): (f64, f64)) -> f64 {
    let lambda = |z: f64, area: f64| (area / z - 1.0).max(0.0);
    let same_side = 0.5 / (a_z * b_area + b_z * (a_area - a_z));
    same_side * inverse_binomial(lambda(a_z, a_area), lambda(b_z, b_area))
}

impl From<Ggx> for Microfacets {
    fn from(ggx: Ggx) -> Self {
        Self::Ggx(ggx)
    }
}

impl From<Beckmann> for Microfacets {
    fn from(beckmann: Beckmann) -> Self {
        Self::Beckmann(beckmann)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn direction(cosine: f64) -> DVec3 {
        DVec3::new(0.6, 0.8, 0.0) * ((1.0 - cosine) * (1.0 + cosine)).sqrt() + DVec3::Z * cosine
    }

    fn distributions(alpha: f64) -> [Microfacets; 2] {
        let beckmann = Beckmann::new(alpha, 0.5 * alpha).unwrap();
        [Ggx::new(alpha, 0.5 * alpha).unwrap().into(), beckmann.into()]
    }

    /// Both forms of G2 are the mean over all heights of what is seen from both ends.
    #[test]
    fn masking_shadowing_is_an_integral_over_heights() {
        for distribution in distributions(1.0) {
            for (a, b) in [(0.9, 0.4), (0.3, 0.3), (0.05, 0.7), (0.1, 0.02)] {
                let (a, b) = (direction(a), direction(b));
                let [lambda_a, lambda_b] = [a, b].map(|w| 1.0 / distribution.masking(w) - 1.0);
                // x = 3t² - 2t³, whose density vanishes at both ends
                let n = 200_000;
                let mean = |visible: &dyn Fn(f64) -> f64| -> f64 {
                    let at = |i| (f64::from(i) + 0.5) / f64::from(n);
                    (0..n)
                        .map(|i| {
                            let t: f64 = at(i);
                            6.0 * t * (1.0 - t) * visible(t * t * (3.0 - 2.0 * t))
                        })
                        .sum::<f64>()
                        / f64::from(n)
                };
                let same = mean(&|x| x.powf(lambda_a + lambda_b));
                let opposite = mean(&|x| x.powf(lambda_a) * (1.0 - x).powf(lambda_b));
                let here = 2.0 * a.z * b.z * distribution.correlation(a, b);
                assert_relative_eq!(here, same, max_relative = 1e-8);
                let here = 2.0 * a.z * b.z * distribution.correlation_across(a, b);
                assert_relative_eq!(here, opposite, max_relative = 1e-8);
                assert!(opposite < distribution.masking(a) * distribution.masking(b));
                assert!(same > distribution.masking(a) * distribution.masking(b));
            }
        }
    }

    #[test]
    fn independent_masking_is_the_product() {
        for correlated in distributions(1.0) {
            let distribution = correlated.with_independent_masking();
            for (a, b) in [(0.9, 0.4), (0.3, 0.3), (0.05, 0.7), (0.1, 0.02)] {
                let (a, b) = (direction(a), direction(b));
                let [masked_a, masked_b] = [a, b].map(|w| correlated.masking(w));
                let product = masked_a * masked_b / (2.0 * a.z * b.z);
                assert_relative_eq!(distribution.correlation(a, b), product, max_relative = 1e-14);
                let across = distribution.correlation_across(a, b);
                assert_relative_eq!(across, product, max_relative = 1e-14);
                let shadowing = [distribution.shadowing(a, b), distribution.shadowing_across(a, b)];
                for shadowing in shadowing {
                    assert_relative_eq!(shadowing, masked_b, max_relative = 1e-14);
                }
            }
        }
    }

    /// The weight of a sampled refraction stays in [0, 1] at the ends of the range, and is that of
    /// a reflection where nothing is hidden.
    #[test]
    fn weights_across_stay_in_range() {
        for distribution in [1e-4, 0.1, 1.0, 10.0].into_iter().flat_map(distributions) {
            for a in [1.0, 0.5, 1e-3, 1e-8, 1e-14].map(direction) {
                for b in [1.0, 0.5, 1e-3, 1e-8, 1e-14].map(direction) {
                    let weight = distribution.shadowing_across(a, b);
                    assert!(weight >= 0.0, "{distribution:?} {a} {b}: {weight}");
                    assert!(weight <= distribution.shadowing(a, b) * (1.0 + 1e-15));
                    assert!(weight <= 1.0 + 1e-15, "{distribution:?} {a} {b}: {weight}");
                    let value = distribution.correlation_across(a, b);
                    let swapped = distribution.correlation_across(b, a);
                    assert_relative_eq!(value, swapped, epsilon = 0.0, max_relative = 1e-12);
                    assert_relative_eq!(
                        2.0 * a.z * b.z * value / distribution.masking(a),
                        weight,
                        epsilon = 0.0,
                        max_relative = 1e-14
                    );
                }
                let (up, same) = (DVec3::Z, distribution.shadowing(DVec3::Z, a));
                assert_relative_eq!(distribution.shadowing_across(up, a), same, epsilon = 1e-15);
            }
        }
    }
}
