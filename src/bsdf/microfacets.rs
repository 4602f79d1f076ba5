//! The distributions of micro-normals behind one type.

use super::{Beckmann, Ggx};
use glam::{DVec2, DVec3};

/// A distribution of micro-normals with its masking: the rough models are made of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Microfacets {
    /// Long tails: most materials.
    Ggx(Ggx),
    /// Gaussian slopes.
    Beckmann(Beckmann),
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
        /// `G2 / (2 a_z b_z)` with height-correlated masking and shadowing (Heitz 2014), finite at
        /// grazing angles.
        correlation(a: DVec3, b: DVec3) -> f64;
        /// `G2(seen_from, next) / G1(seen_from)` ≤ 1: what is left for the weight after sampling a
        /// visible normal.
        shadowing(seen_from: DVec3, next: DVec3) -> f64;
        /// Density of the normals seen from a direction, divided by `(seen_from · normal)`, 1/sr.
        visible_density_over_cosine(seen_from: DVec3, normal: DVec3) -> f64;
        /// Samples a normal among those seen from a direction, in proportion to their projected
        /// area; `None` where rounding leaves none.
        sample_visible(seen_from: DVec3, u: DVec2) -> Option<DVec3>;
    }
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
