//! What a scene needs, computed once before rendering, so that integrators can leave out the rest.

/// A set of features that a scene has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
    /// Materials or area lights that differ from point to point.
    pub const TEXTURES: Self = Self(128);
    /// Everything: the safe answer of a scene that does not know.
    pub const ALL: Self = Self(255);

    /// Both sets together.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all of `other` is needed.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

impl std::ops::BitOr for Needs {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        self.union(other)
    }
}
