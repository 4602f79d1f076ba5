//! Stratified (jittered) numbers over the samples of each pixel.

use super::dimension::Dimension;
use super::hash::{ONE_MINUS_ULP, hash_sample, mix, nth, permute, unit_interval};
use super::{SampleSource, Sampler, Stream};
use glam::DVec2;

/// Stratifies each dimension over the samples of a pixel, and each point of the unit square over a
/// grid as well as over rows and columns (multi-jittered sampling: Chiu, Shirley and Wang 1994).
/// All cells of a column of the grid use its lines in the same order, and all of a row (correlated
/// multi-jittered sampling: Kensler 2013), which keeps points apart and so takes half of the
/// variance at edges. Strata are assigned to samples by permutations that are hashed per pixel and
/// dimension, so dimensions are independent of each other (padding).
///
/// Samples beyond `samples_per_pixel` start a new, independent set of strata.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stratified {
    /// Different seeds give independent renderings.
    pub seed: u64,
    /// Number of strata, 0 meaning 1. Squares, and products of two similar numbers, stratify the
    /// square best; for a prime number only the two axes are stratified.
    pub samples_per_pixel: u32,
}

/// The sampler of [`Stratified`].
#[derive(Clone, Copy, Debug)]
pub struct StratifiedSampler {
    /// Decides the permutations: equal for all samples of a set.
    set: u64,
    /// Decides the jitter: different for each sample.
    sample: u64,
    index: u32,
    strata: u32,
    columns: u32,
    rows: u32,
    /// The width of a stratum.
    width: f64,
    dimension: Dimension,
}

impl StratifiedSampler {
    /// Hashes for dimension `n` of the current stream: that of its permutations, and that of its
    /// jitter.
    #[inline]
    fn hashes(&self, n: u32) -> [u64; 2] {
        [self.set, self.sample].map(|hash| nth(hash, self.dimension.id(n)))
    }

    /// The number in `[0, 1)` at the place in a stratum that 64 random bits choose.
    #[inline]
    fn within(&self, stratum: u32, jitter: u64) -> f64 {
        ((f64::from(stratum) + unit_interval(jitter)) * self.width).min(ONE_MINUS_ULP)
    }
}

impl Sampler for StratifiedSampler {
    #[inline]
    fn next_1d(&mut self) -> f64 {
        let n = self.dimension.number();
        let [key, jitter] = self.hashes(n);
        self.within(permute(self.index, self.strata, key), jitter)
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let n = self.dimension.point();
        let [key, jitter] = self.hashes(n);
        let (columns, rows) = (self.columns, self.rows);
        let cell = permute(self.index, self.strata, key);
        let (column, row) = (cell % columns, cell / columns);
        // Within its cell the point takes one of `rows` × `columns` places such that no two points
        // share a line of the fine grid.
        let x = column * rows + permute(row, rows, nth(key, 0));
        let y = row * columns + permute(column, columns, nth(key, 1));
        DVec2::new(self.within(x, jitter), self.within(y, nth(jitter, 0)))
    }

    #[inline]
    fn skip_1d(&mut self) {
        self.dimension.number();
    }

    #[inline]
    fn skip_2d(&mut self) {
        self.dimension.point();
    }

    #[inline]
    fn stream(&mut self, stream: Stream) {
        self.dimension.announce(stream);
    }
}

impl SampleSource for Stratified {
    type Sampler = StratifiedSampler;

    #[inline]
    fn sampler(&self, pixel: u32, pass: u32) -> StratifiedSampler {
        let strata = self.samples_per_pixel.max(1);
        let columns = largest_divisor_up_to_root(strata);
        StratifiedSampler {
            set: hash_sample(mix(self.seed) ^ 0x5354_5241_5441, pixel, pass / strata),
            sample: hash_sample(self.seed, pixel, pass),
            index: pass % strata,
            strata,
            columns,
            rows: strata / columns,
            width: 1.0 / f64::from(strata),
            dimension: Dimension::default(),
        }
    }
}

/// The largest divisor of `n` that is at most √n. Takes √n steps at worst, once per sample.
fn largest_divisor_up_to_root(n: u32) -> u32 {
    (1..=n.isqrt()).rev().find(|&d| n.is_multiple_of(d)).unwrap_or(1)
}
