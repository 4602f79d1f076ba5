//! Probability densities that carry their measure in their type.
//!
//! A density means nothing without the measure it is taken against. Three measures occur in path
//! space (Veach 1997, chapter 8): area on the scene's surfaces, solid angle, and *projected* solid
//! angle `dσ⊥ = |cos θ| dσ`. The crate keeps densities of directions per projected solid angle,
//! because then
//!
//! ```text
//! p_area(y) = p⊥(x → y) · G(x, y)
//! ```
//!
//! holds with the very geometry term of the path integral, and cosines and `1/r²` cancel between a
//! measurement and the density of its sample. Conversions are the only way from one type to
//! another.

use std::ops::Mul;

macro_rules! density {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl $name {
            /// The density that is 0 everywhere.
            pub const ZERO: Self = Self(0.0);

            /// The bare number.
            #[inline]
            #[must_use]
            pub const fn value(self) -> f64 {
                self.0
            }
        }

        /// Scales by a dimensionless probability, such as that of choosing a light or a lobe.
        impl Mul<f64> for $name {
            type Output = Self;
            #[inline]
            fn mul(self, probability: f64) -> Self {
                Self(self.0 * probability)
            }
        }
    };
}

density! {
    /// Density of a vertex in the measure of its [`Place`](crate::geometry::Place): per unit area
    /// on a surface (1/m²), per solid angle for a point at infinity (1/sr), and a plain probability
    /// for a Dirac position.
    PerArea
}
density! {
    /// Density of a direction per solid angle, 1/sr.
    PerSolidAngle
}
density! {
    /// Density of a direction per projected solid angle, 1/sr⊥: `p⊥ = p_ω / |cos θ|`.
    ///
    /// A Dirac lobe carries its probability here, with the Dirac distribution left out. At a Dirac
    /// position there is no surface and hence no cosine: `p⊥ = p_ω`. At infinity the "direction" is
    /// the place where the ray enters the scene, and the density is per area perpendicular to the
    /// ray, 1/m².
    PerProjected
}

impl PerSolidAngle {
    /// `p⊥ = p_ω / |cos θ|`; 0 stays 0 even where the cosine vanishes.
    #[inline]
    #[must_use]
    pub fn per_projected(self, cosine: f64) -> PerProjected {
        PerProjected(if self.0 == 0.0 { 0.0 } else { self.0 / cosine.abs() })
    }

    // ANCHOR: per-area
    /// `p_A = p_ω |cos θ'| / r²`, with the cosine and the distance at the *new* vertex.
    #[inline]
    #[must_use]
    pub fn per_area(self, cosine_at_new_vertex: f64, distance_squared: f64) -> PerArea {
        PerArea(if self.0 == 0.0 {
            0.0
        } else {
            self.0 * cosine_at_new_vertex.abs() / distance_squared
        })
    }
    // ANCHOR_END: per-area
}

impl PerProjected {
    /// `p_ω = p⊥ |cos θ|`.
    #[inline]
    #[must_use]
    pub fn per_solid_angle(self, cosine: f64) -> PerSolidAngle {
        PerSolidAngle(self.0 * cosine.abs())
    }

    /// `p_A = p⊥ G`, the geometry term without visibility.
    #[inline]
    #[must_use]
    pub fn per_area(self, geometry_term: f64) -> PerArea {
        PerArea(self.0 * geometry_term)
    }
}

impl PerArea {
    /// `p_ω = p_A r² / |cos θ'|`, with the cosine at the vertex that the density belongs to.
    #[inline]
    #[must_use]
    pub fn per_solid_angle(self, cosine_at_vertex: f64, distance_squared: f64) -> PerSolidAngle {
        PerSolidAngle(if self.0 == 0.0 {
            0.0
        } else {
            self.0 * distance_squared / cosine_at_vertex.abs()
        })
    }

    /// `p⊥ = p_A / G`, the geometry term without visibility.
    #[inline]
    #[must_use]
    pub fn per_projected(self, geometry_term: f64) -> PerProjected {
        PerProjected(if self.0 == 0.0 { 0.0 } else { self.0 / geometry_term })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn conversions_are_inverse_to_each_other() {
        let p = PerSolidAngle(0.7);
        let (cos_x, cos_y, r2) = (0.3f64, -0.8, 4.0);
        let g = (cos_x * cos_y / r2).abs();
        assert_relative_eq!(
            p.per_projected(cos_x).per_area(g).value(),
            p.per_area(cos_y, r2).value(),
            max_relative = 1e-15
        );
        assert_relative_eq!(
            p.per_area(cos_y, r2).per_solid_angle(cos_y, r2).value(),
            0.7,
            max_relative = 1e-15
        );
        assert_relative_eq!(
            PerArea(2.0).per_projected(g).per_area(g).value(),
            2.0,
            max_relative = 1e-15
        );
    }

    #[test]
    fn zero_density_survives_vanishing_cosines() {
        assert_eq!(PerSolidAngle::ZERO.per_projected(0.0), PerProjected::ZERO);
        assert_eq!(PerArea::ZERO.per_projected(0.0), PerProjected::ZERO);
        assert_eq!(PerArea::ZERO.per_solid_angle(0.0, 1.0), PerSolidAngle::ZERO);
    }
}
