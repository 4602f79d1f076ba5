//! The counters of a rendering: rays, vertices, rejected contributions and the energy ledger.

use super::MAX_BOUNCES;
use crate::bsdf::TransportMode;
use crate::math::Rgb;
use std::ops::AddAssign;

/// The energy ledger of light subpaths: the flux that they start with and where it ends. In
/// expectation, emitted = absorbed + escaped + truncated + rejected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Flux that light subpaths started with.
    pub emitted: Rgb,
    /// Flux that surfaces absorbed.
    pub absorbed: Rgb,
    /// Flux that left the scene.
    pub escaped: Rgb,
    /// Flux still under way where the number of bounces was limited.
    pub truncated: Rgb,
    /// Flux lost in non-finite samples.
    pub rejected: Rgb,
    /// Radiance, summed over samples, that a bound on connections cut off and that nothing else
    /// draws; no part of the balance.
    pub clamped: Rgb,
}

impl Ledger {
    /// All entries, in the order above.
    pub(crate) fn to_array(self) -> [Rgb; 6] {
        [self.emitted, self.absorbed, self.escaped, self.truncated, self.rejected, self.clamped]
    }

    /// The ledger of these entries.
    pub(crate) fn from_array(
        [emitted, absorbed, escaped, truncated, rejected, clamped]: [Rgb; 6],
    ) -> Self {
        Self { emitted, absorbed, escaped, truncated, rejected, clamped }
    }
}

impl AddAssign for Ledger {
    fn add_assign(&mut self, other: Self) {
        self.emitted += other.emitted;
        self.absorbed += other.absorbed;
        self.escaped += other.escaped;
        self.truncated += other.truncated;
        self.rejected += other.rejected;
        self.clamped += other.clamped;
    }
}

/// Counts of what integrators did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    any(feature = "checkpoint", feature = "report"),
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Counters {
    /// Samples, each a camera subpath, a light subpath, or one of each.
    pub samples: u64,
    /// Light subpaths started.
    pub light_subpaths: u64,
    /// Rays traced for the nearest hit.
    pub closest_rays: u64,
    /// Shadow rays traced.
    pub shadow_rays: u64,
    /// Scattering vertices sampled.
    pub scattered: u64,
    /// Pairs of vertices that were to be connected: scattering or emission was evaluated at one of
    /// them at least.
    pub connections: u64,
    /// Vertices of light subpaths that all pixels share, as photons or as virtual lights.
    pub photons: u64,
    /// Searches for the photons near a vertex of a camera subpath.
    pub queries: u64,
    /// Photons found in reach, for each of which scattering was evaluated.
    pub merges: u64,
    /// Bytes of the largest map that the pixels of a pass shared; 0 without one.
    pub shared_bytes: u64,
    /// Contributions that were infinite or not a number; they were not added to the film.
    pub non_finite: u64,
    /// Walks that the library's own limit on bounces ([`MAX_BOUNCES`]) cut off, whose light is
    /// lost. Those that end where the [`Depth`](super::Depth) of the settings does lose nothing that
    /// was asked for and are not among them.
    pub truncated_subpaths: u64,
    /// Energy ledger of the light subpaths.
    #[cfg_attr(any(feature = "checkpoint", feature = "report"), serde(skip))]
    pub ledger: Ledger,
}

impl Counters {
    /// Cost in units of a ray that is traced for its nearest hit: counts times constants, so that
    /// it is the same on every machine and in every run. The constants were fitted to processor
    /// times of the integrators that share no light walks, on the gallery (docs/leave-out.md); maps
    /// and what is found in them are not in it.
    #[must_use]
    pub fn cost(&self) -> f64 {
        (self.closest_rays + self.shadow_rays + self.connections + self.scattered) as f64
            + 1.5 * self.light_subpaths as f64
    }

    /// Records a walk that leaves the scene.
    #[inline]
    pub(super) fn escape(&mut self, mode: TransportMode, throughput: Rgb) {
        if mode == TransportMode::Importance {
            self.ledger.escaped += throughput;
        }
    }

    /// Records a walk that a limit on the number of bounces ends after so many.
    #[inline]
    pub(super) fn truncate(&mut self, mode: TransportMode, throughput: Rgb, bounces: u32) {
        // A walk that is connected ends up to two before.
        self.truncated_subpaths += u64::from(bounces + 2 >= MAX_BOUNCES);
        if mode == TransportMode::Importance {
            self.ledger.truncated += throughput;
        }
    }

    /// Records the size of a map that the pixels of a pass share.
    pub(crate) fn share(&mut self, bytes: usize) {
        self.shared_bytes = self.shared_bytes.max(bytes as u64);
    }

    /// All rays.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.closest_rays + self.shadow_rays
    }
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.samples += other.samples;
        self.light_subpaths += other.light_subpaths;
        self.closest_rays += other.closest_rays;
        self.shadow_rays += other.shadow_rays;
        self.scattered += other.scattered;
        self.connections += other.connections;
        self.photons += other.photons;
        self.queries += other.queries;
        self.merges += other.merges;
        self.shared_bytes = self.shared_bytes.max(other.shared_bytes);
        self.non_finite += other.non_finite;
        self.truncated_subpaths += other.truncated_subpaths;
        self.ledger += other.ledger;
    }
}
