//! The lengths of paths that count.

use super::MAX_BOUNCES;
use crate::scene::Needs;

/// The paths that count, by their number of scattering events; 0 is light that comes straight from an
/// emitter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Depth {
    /// Paths with fewer scattering events are left out.
    pub min_bounces: u32,
    /// Paths with more scattering events are left out; `None` for no limit but [`MAX_BOUNCES`].
    pub max_bounces: Option<u32>,
}

impl Depth {
    /// Up to `max_bounces` scattering events.
    #[must_use]
    pub const fn up_to(max_bounces: u32) -> Self {
        Self { min_bounces: 0, max_bounces: Some(max_bounces) }
    }

    /// Exactly `bounces` scattering events.
    #[must_use]
    pub const fn exactly(bounces: u32) -> Self {
        Self { min_bounces: bounces, max_bounces: Some(bounces) }
    }

    /// The same, less what a scene with these needs has no light for.
    #[inline]
    #[must_use]
    pub fn within(self, needs: &Needs) -> Self {
        match needs.most_bounces() {
            Some(most) => Self {
                max_bounces: Some(self.max_bounces.map_or(most, |max| max.min(most))),
                ..self
            },
            None => self,
        }
    }

    /// The largest number of scattering events.
    #[inline]
    #[must_use]
    pub fn limit(&self) -> u32 {
        self.max_bounces.map_or(MAX_BOUNCES, |max| max.min(MAX_BOUNCES))
    }

    /// True if paths with so many scattering events count.
    #[inline]
    #[must_use]
    pub fn contains(&self, bounces: u32) -> bool {
        self.min_bounces <= bounces && bounces <= self.limit()
    }
}
