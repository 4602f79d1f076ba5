//! Independent samples from which the constant b and the first states of chains come.

use crate::integrator::Crew;
use crate::math::Fingerprint;
use std::ops::Range;

/// The candidates of some passes.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    /// The key of the first; those of the others follow it.
    key: u64,
    /// The sums of I over the candidates up to each.
    sums: Vec<f64>,
    /// The place of the last one that contributes.
    last: usize,
}

/// Candidates that a thread draws at a time.
const CHUNK: u32 = 256;

/// The fractional part of the golden ratio, whose multiples fill `[0, 1)` evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Candidates {
    /// Draws candidates, given I of those of some keys; with the constant b by these alone.
    ///
    /// # Errors
    /// If there is no memory for them.
    pub fn draw(
        seed: (u64, u32),
        number: u32,
        crew: &dyn Crew,
        importances: impl Fn(Range<u64>) -> Vec<f64> + Sync,
    ) -> Result<(Self, Normalization), String> {
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
        let normalization = Normalization { candidates: number.into(), black, sum, squares };
        Ok((Self { key, sums, last }, normalization))
    }

    /// The constant b.
    pub fn mean(&self) -> f64 {
        self.sums.last().map_or(0.0, |sum| sum / self.sums.len() as f64)
    }

    /// The key of a candidate that is drawn in proportion to its I: chains with numbers that follow
    /// one another choose evenly.
    pub fn choose(&self, chain: u32) -> u64 {
        let offset = (self.key as u32 as f64) / f64::from(u32::MAX);
        let u = (offset + f64::from(chain) * GOLDEN).fract();
        let x = u * self.sums.last().copied().unwrap_or(0.0);
        let place = self.sums.partition_point(|sum| *sum <= x).min(self.last);
        self.key + place as u64
    }
}

/// The constant b of Metropolis sampling as the candidates tell it: the mean of the image over its
/// pixels and channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Normalization {
    /// Number of candidates.
    pub candidates: u64,
    /// Number of sets of candidates of which none contributed. The passes of such a set are black,
    /// as the mean demands, and the next set is larger.
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

    pub(super) fn add(&mut self, other: &Self) {
        self.candidates += other.candidates;
        self.black += other.black;
        self.sum += other.sum;
        self.squares += other.squares;
    }
}
