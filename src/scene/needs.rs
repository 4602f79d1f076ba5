//! The needs of a scene, computed once before rendering, so that integrators can leave out the
//! rest.

use std::fmt;

bitflags::bitflags! {
    /// A set of features that a scene has. A scene that is not sure whether it has one says so:
    /// more is always safe.
    #[derive(Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Needs: u32 {
        /// Lights that a ray can hit by chance: area lights or an environment.
        const HITTABLE_LIGHTS = 1 << 0;
        /// Lights that can be connected to.
        const CONNECTIBLE_LIGHTS = 1 << 1;
        /// Materials with lobes that are functions, where connections are possible.
        const FINITE_LOBES = 1 << 2;
        /// Materials with Dirac lobes.
        const DIRAC_LOBES = 1 << 3;
        /// An environment, reached by rays that leave the scene.
        const ENVIRONMENT = 1 << 4;
        /// Lights that no ray can hit: points, spots, directional ones.
        const DIRAC_LIGHTS = 1 << 5;
        /// Lights that cannot be connected to: Dirac in position and direction.
        const UNCONNECTIBLE_LIGHTS = 1 << 6;
        /// Materials with glossy lobes.
        const GLOSSY_LOBES = 1 << 7;
        /// Light that reaches a surface. Without it all that can be seen is emitters, directly.
        const ILLUMINATION = 1 << 8;
        /// Light that reaches one surface from another. Without it, as on a single convex object
        /// under the sky, light scatters once.
        const INTERREFLECTION = 1 << 9;
    }
}

impl Needs {
    /// Nothing: no light at all.
    pub const NONE: Self = Self::empty();
    /// Everything: the safe answer of a scene that does not know.
    pub const ALL: Self = Self::all();

    /// Every feature alone, in the order of their bits.
    pub const SINGLE: [Self; 10] = {
        let mut single = [Self::NONE; 10];
        let mut bit = 0;
        while bit < single.len() {
            single[bit] = Self::from_bits_retain(1 << bit);
            bit += 1;
        }
        single
    };

    /// This set without the other.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        self.difference(other)
    }

    /// The same needs with glossy lobes in place of Dirac ones.
    #[must_use]
    pub const fn regularized(self) -> Self {
        if self.contains(Self::DIRAC_LOBES) {
            let glossy = Self::GLOSSY_LOBES.union(Self::FINITE_LOBES);
            self.difference(Self::DIRAC_LOBES).union(glossy)
        } else {
            self
        }
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

impl fmt::Display for Needs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("nothing");
        }
        let words = |name: &str| name.to_lowercase().replace('_', " ").replace("dirac", "Dirac");
        let names: Vec<String> = self.iter_names().map(|(name, _)| words(name)).collect();
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
        assert_eq!(Needs::ALL.to_string().split(", ").count(), Needs::SINGLE.len());
        assert_eq!(Needs::ALL.bits().count_ones() as usize, Needs::SINGLE.len());
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
