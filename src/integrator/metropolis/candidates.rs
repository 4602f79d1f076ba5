//! Independent samples from which the constant b and the first states of chains come.

use super::chain::Chain;
use super::{CHAINS, Chains};
use crate::integrator::Crew;
use crate::math::Fingerprint;
use crate::path::{Counters, Ledger, Scratch};
use crate::scene::Scene;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// The candidates of a set of chains.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    /// The key of the first; those of the others follow it.
    key: u64,
    /// The sums of I over the candidates up to each.
    sums: Vec<f64>,
    /// The place of the last one that contributes.
    last: usize,
    /// The constant b by these candidates alone.
    pub found: Normalization,
}

/// The fewest candidates, if their number is not given.
const FEWEST: u32 = 1 << 12;

/// Candidates that a thread draws at a time.
const CHUNK: u32 = 256;

/// The fractional part of the golden ratio, whose multiples fill `[0, 1)` evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Candidates {
    /// Draws candidates, given I of those of some keys.
    ///
    /// # Errors
    /// If there is no memory for them.
    pub fn draw(
        seed: (u64, u32),
        number: u32,
        crew: &dyn Crew,
        importances: impl Fn(Range<u64>) -> Vec<f64> + Sync,
    ) -> Result<Self, String> {
        // Far from the end, so that no key overflows.
        let key = Fingerprint::of(("candidates", seed)) >> 1;
        let mut sums = Vec::new();
        let no_memory = |_| format!("no memory for {number} candidates");
        sums.try_reserve_exact(number as usize).map_err(no_memory)?;
        let chunks = crew.collect(number.div_ceil(CHUNK) as usize, |chunk| {
            let first = chunk as u32 * CHUNK;
            let end = first + CHUNK.min(number - first);
            importances(key + u64::from(first)..key + u64::from(end))
        });
        let (mut sum, mut squares, mut last) = (0.0, 0.0, 0);
        for importance in chunks.into_iter().flatten() {
            if importance > 0.0 {
                last = sums.len();
            }
            sum += importance;
            squares += importance * importance;
            sums.push(sum);
        }
        let black = u32::from(sum == 0.0);
        let found = Normalization { candidates: number.into(), black, sum, squares };
        Ok(Self { key, sums, last, found })
    }

    /// The constant b.
    pub fn mean(&self) -> f64 {
        self.found.mean()
    }

    /// The key of a candidate that is drawn in proportion to its I: chains with numbers that follow
    /// one another choose evenly.
    pub fn choose(&self, chain: f64) -> u64 {
        let offset = f64::from(self.key as u32) / f64::from(u32::MAX);
        let u = (offset + chain * GOLDEN).fract();
        let x = u * self.sums.last().copied().unwrap_or(0.0);
        let place = self.sums.partition_point(|sum| *sum <= x).min(self.last);
        self.key + place as u64
    }
}

impl<S: Scene + ?Sized> Chains<'_, S> {
    /// Draws the candidates of a set of chains.
    ///
    /// # Errors
    /// If there is no memory for them.
    pub(super) fn draw_candidates(&mut self, set: u32, crew: &dyn Crew) -> Result<(), String> {
        if set == 0 && self.settings.candidates.is_none() {
            // A pilot, which none of the image depends on, tells how many it takes.
            self.candidates = self.candidates(u32::MAX, FEWEST, crew)?;
        }
        self.candidates = self.candidates(set, self.number_of_candidates(), crew)?;
        self.normalization.add(&self.candidates.found);
        self.set = set;
        Ok(())
    }

    fn number_of_candidates(&self) -> u32 {
        let pixels = f64::from(self.stage.film.pixels());
        let mutations = (pixels * f64::from(self.settings.restart)).min(self.stage.samples as f64);
        let most = 0.125 * mutations;
        let chains = CHAINS as f64 / 256.0 * pixels;
        let enough = (chains / self.candidates.found.effective_part()).min(most);
        self.settings.candidates.unwrap_or(FEWEST.max(enough as u32))
    }

    fn candidates(&mut self, set: u32, number: u32, crew: &dyn Crew) -> Result<Candidates, String> {
        let counted = Mutex::new(Counters::default());
        let seed = (self.stage.seed, set);
        let candidates = Candidates::draw(seed, number, crew, |keys| {
            let mut scratch = Scratch::default();
            let chains = self.begin(keys, &mut scratch);
            let mut counted = counted.lock().unwrap_or_else(PoisonError::into_inner);
            *counted += Counters { ledger: Ledger::default(), ..scratch.counters };
            chains.iter().map(Chain::importance).collect()
        });
        self.counters += counted.into_inner().unwrap_or_else(PoisonError::into_inner);
        candidates
    }
}

/// The constant b of Metropolis sampling as the candidates tell it: the mean of the image over its
/// pixels and channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Normalization {
    /// Number of candidates.
    pub candidates: u64,
    /// Number of sets of candidates of which none contributed. The passes of such a set are black,
    /// as the mean demands.
    pub black: u32,
    sum: f64,
    squares: f64,
}

impl Normalization {
    /// The estimate of b, radiance.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum / self.candidates.max(1) as f64
    }

    /// The standard error of b relative to b; 0 if nothing contributed.
    #[must_use]
    pub fn relative_error(&self) -> f64 {
        let (n, mean) = (self.candidates as f64, self.mean());
        if mean > 0.0 { ((self.squares / n / mean / mean - 1.0).max(0.0) / n).sqrt() } else { 0.0 }
    }

    /// The part of the candidates that chains begin at, so to speak: as many equal ones would leave
    /// them as free a choice (Kish 1965, the effective size of a sample). 0 if nothing contributed.
    pub(super) fn effective_part(&self) -> f64 {
        let mean_square = self.squares * self.candidates as f64;
        if mean_square > 0.0 { self.sum / mean_square * self.sum } else { 0.0 }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.candidates += other.candidates;
        self.black += other.black;
        self.sum += other.sum;
        self.squares += other.squares;
    }
}
