//! Owen-scrambled Sobol' sequences: randomised quasi-Monte Carlo.

use super::dimension::Dimension;
use super::hash::{combine, hash_sample, mix, unit_interval};
use super::{SampleSource, Sampler, Stream};
use glam::DVec2;
use sobol_burley::parts::{hash, owen_scramble_rev, sobol_rev};
use std::sync::LazyLock;

/// Owen-scrambled Sobol' points (Sobol' 1967; Owen 1995; hashed scrambling by Burley 2020), four
/// dimensions at a time.
///
/// Each pixel and each set of four dimensions of a [`Stream`] has its own scramble (padding), so
/// any single estimate is unbiased, and smooth integrands in few dimensions converge faster than
/// 1/√N. The samples of one pixel are *not* independent: a sample variance over them overestimates
/// the error; compare renderings with different seeds instead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sobol {
    /// Different seeds give independent renderings.
    pub seed: u64,
}

/// Points of one scrambled sequence; what `sobol_burley` supports. Later samples take the next,
/// independently scrambled sequence.
const SEQUENCE_LENGTH: u32 = 1 << 16;
/// Dimensions that are stratified together.
const SET: u32 = 4;

/// The contribution of each value of each hexadecimal digit of an index, its bits in reverse order,
/// to the first four dimensions of Sobol' points, theirs in reverse order too, 16 each. The digits'
/// contributions combine by exclusive or.
static CONTRIBUTIONS: LazyLock<[[u64; 16]; 4]> = LazyLock::new(|| {
    let lanes = |reversed_index: u32| {
        (0..SET)
            .fold(0, |all, lane| all | u64::from(sobol_rev(reversed_index, lane)) << (16 * lane))
    };
    [0, 1, 2, 3].map(|digit| std::array::from_fn(|value| lanes((value as u32) << (16 + 4 * digit))))
});

/// Four dimensions of an Owen-scrambled point, 32 bits each: those of `sobol_burley::sample_4d`,
/// before it rounds them.
#[inline]
fn scrambled(index: u32, seed: u32) -> [u32; SET as usize] {
    let shuffled = owen_scramble_rev(index.reverse_bits(), hash(seed ^ 0x79c6_8e4a)) >> 16;
    let [a, b, c, d] = &*CONTRIBUTIONS;
    let digit = |n: u32| (shuffled >> (4 * n) & 15) as usize;
    let point = a[digit(0)] ^ b[digit(1)] ^ c[digit(2)] ^ d[digit(3)];
    let seed = seed.wrapping_mul(0x9c8f_2d3b);
    let lane = |n: u32, key: u32| {
        owen_scramble_rev(u32::from((point >> (16 * n)) as u16), hash(seed ^ key)).reverse_bits()
    };
    [lane(0, 0x912f_69ba), lane(1, 0x174f_18ab), lane(2, 0x691e_72ca), lane(3, 0xb40c_c1b8)]
}

/// The sampler of [`Sobol`].
#[derive(Clone, Copy, Debug)]
pub struct SobolSampler {
    /// Decides the scrambles: equal for all samples of a pixel within one sequence.
    sequence: u64,
    /// Decides the bits below the resolution of the sequence: different for each sample.
    sample: u64,
    index: u32,
    dimension: Dimension,
    /// The set that is in `numbers`, as (stream, number within the stream).
    cached: Option<(u64, u32)>,
    numbers: [f64; SET as usize],
}

impl SobolSampler {
    /// Two dimensions for a point. They must not straddle two sets, which know nothing of each
    /// other.
    #[inline]
    fn take_pair(&mut self) -> u32 {
        if self.dimension.count % SET == SET - 1 {
            self.dimension.take(1);
        }
        self.dimension.take(2)
    }

    /// Dimension `n` of the current stream.
    #[inline]
    fn number(&mut self, n: u32) -> f64 {
        let place = (self.dimension.stream, n / SET);
        if self.cached != Some(place) {
            self.numbers = self.set(place);
            self.cached = Some(place);
        }
        self.numbers[(n % SET) as usize]
    }

    /// A set of dimensions of a stream. The sequence gives 32 bits; random ones below them make 53
    /// and cannot carry the number out of its stratum or to 1.
    fn set(&self, (stream, set): (u64, u32)) -> [f64; SET as usize] {
        let hashed = |key: u64| combine(combine(key, stream), u64::from(set));
        let [a, b, c, d] = scrambled(self.index, (hashed(self.sequence) >> 32) as u32)
            .map(|bits| u64::from(bits) << 32);
        let fine = hashed(self.sample);
        let more = mix(fine);
        [a | fine >> 32, b | fine & 0xffff_ffff, c | more >> 32, d | more & 0xffff_ffff]
            .map(unit_interval)
    }
}

impl Sampler for SobolSampler {
    #[inline]
    fn next_1d(&mut self) -> f64 {
        let n = self.dimension.take(1);
        self.number(n)
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let n = self.take_pair();
        DVec2::new(self.number(n), self.number(n.wrapping_add(1)))
    }

    #[inline]
    fn skip_1d(&mut self) {
        self.dimension.take(1);
    }

    #[inline]
    fn skip_2d(&mut self) {
        self.take_pair();
    }

    #[inline]
    fn stream(&mut self, stream: Stream) {
        self.dimension.announce(stream);
    }
}

impl SampleSource for Sobol {
    type Sampler = SobolSampler;

    #[inline]
    fn sampler(&self, pixel: u32, pass: u32) -> SobolSampler {
        SobolSampler {
            sequence: hash_sample(mix(self.seed) ^ 0x0053_4f42_4f4c, pixel, pass / SEQUENCE_LENGTH),
            sample: hash_sample(self.seed, pixel, pass),
            index: pass % SEQUENCE_LENGTH,
            dimension: Dimension::default(),
            cached: None,
            numbers: [0.0; SET as usize],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_those_of_sobol_burley() {
        for (index, seed) in
            (0..SEQUENCE_LENGTH).step_by(37).zip((0u32..).map(|n| n.wrapping_mul(0x9e37_79b9)))
        {
            let points = scrambled(index, seed).map(sobol_burley::parts::u32_to_f32_norm);
            assert_eq!(points, sobol_burley::sample_4d(index, 0, seed), "{index} {seed}");
        }
    }
}
