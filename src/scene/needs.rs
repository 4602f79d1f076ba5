//! What a scene needs, computed once before rendering, so that integrators can leave out the rest.

use std::fmt;

/// A set of features that a scene has. A scene that is not sure whether it has one says so: more is
/// always safe.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Needs(u32);

impl Needs {
    /// Nothing: no light at all.
    pub const NONE: Self = Self(0);
    /// Lights that a ray can hit by chance: area lights or an environment.
    pub const HITTABLE_LIGHTS: Self = Self(1);
    /// Lights that can be connected to.
    pub const CONNECTIBLE_LIGHTS: Self = Self(2);
    /// Materials with lobes that are functions, where connections are possible.
    pub const FINITE_LOBES: Self = Self(4);
    /// Materials with Dirac lobes.
    pub const DIRAC_LOBES: Self = Self(8);
    /// Materials that transmit light.
    pub const TRANSMISSION: Self = Self(16);
    /// An environment, reached by rays that leave the scene.
    pub const ENVIRONMENT: Self = Self(32);
    /// Shading normals that differ from the geometric ones.
    pub const SMOOTH_NORMALS: Self = Self(64);
    /// Lights that no ray can hit: points, spots, directional ones.
    pub const DIRAC_LIGHTS: Self = Self(128);
    /// Lights that cannot be connected to: Dirac in position and direction.
    pub const UNCONNECTIBLE_LIGHTS: Self = Self(256);
    /// Materials with glossy lobes.
    pub const GLOSSY_LOBES: Self = Self(512);
    /// Light that reaches a surface. Without it all that can be seen is emitters, directly.
    pub const ILLUMINATION: Self = Self(1024);
    /// Light that reaches one surface from another. Without it, as on a single convex object under
    /// the sky, light scatters once.
    pub const INTERREFLECTION: Self = Self(2048);
    /// Materials or area lights that differ from point to point.
    pub const TEXTURES: Self = Self(4096);
    /// Everything: the safe answer of a scene that does not know.
    pub const ALL: Self = Self(8191);

    /// Every feature alone, in the order of their bits.
    pub const SINGLE: [Self; 13] = {
        let mut single = [Self::NONE; 13];
        let mut bit = 0;
        while bit < single.len() {
            single[bit] = Self(1 << bit);
            bit += 1;
        }
        single
    };

    const NAMES: [&'static str; 13] = [
        "hittable lights",
        "connectible lights",
        "finite lobes",
        "Dirac lobes",
        "transmission",
        "environment",
        "smooth normals",
        "Dirac lights",
        "unconnectible lights",
        "glossy lobes",
        "illumination",
        "interreflection",
        "textures",
    ];

    /// Both sets together.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// This set without the other.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether all of `other` is needed.
    #[inline]
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The largest number of scattering events that a path with light in it can have; `None` if
    /// there is no bound.
    #[inline]
    #[must_use]
    pub const fn most_bounces(self) -> Option<u32> {
        if !self.contains(Self::ILLUMINATION) {
            Some(0)
        } else if !self.contains(Self::INTERREFLECTION) {
            Some(1)
        } else {
            None
        }
    }
}

impl std::ops::BitOr for Needs {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        self.union(other)
    }
}

impl fmt::Display for Needs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = (0..)
            .zip(Self::NAMES)
            .filter(|(bit, _)| self.0 >> bit & 1 == 1)
            .map(|(_, name)| name)
            .collect();
        f.write_str(if names.is_empty() { "nothing" } else { "" })?;
        f.write_str(&names.join(", "))
    }
}

impl fmt::Debug for Needs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Needs({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_need_has_a_name() {
        assert_eq!(Needs::ALL.to_string().split(", ").count(), Needs::NAMES.len());
        assert_eq!(Needs::ALL.0.count_ones() as usize, Needs::NAMES.len());
        assert_eq!(Needs::NONE.to_string(), "nothing");
        assert_eq!(Needs::SINGLE.into_iter().fold(Needs::NONE, Needs::union), Needs::ALL);
        assert_eq!(
            (Needs::DIRAC_LIGHTS | Needs::ENVIRONMENT).to_string(),
            "environment, Dirac lights"
        );
        assert_eq!(Needs::ALL.without(Needs::ENVIRONMENT) | Needs::ENVIRONMENT, Needs::ALL);
    }

    #[test]
    fn bounces_are_bounded_only_where_it_is_certain() {
        assert_eq!(Needs::ALL.most_bounces(), None);
        assert_eq!(Needs::ALL.without(Needs::INTERREFLECTION).most_bounces(), Some(1));
        assert_eq!(Needs::ALL.without(Needs::ILLUMINATION).most_bounces(), Some(0));
    }
}
