//! Scrambled Sobol' sequences: randomised quasi-Monte Carlo.

use super::dimension::{Dimension, SET};
use super::hash::{hash_sample, mix, nth, unit_interval};
use super::{SampleSource, Sampler, Stream};
use glam::DVec2;
use std::sync::LazyLock;

/// Scrambled Sobol' points (Sobol' 1967), four dimensions at a time.
///
/// Each pixel and each set of four dimensions of a [`Stream`] has its own scramble and its own
/// order (padding), so any single estimate is unbiased, and smooth integrands in few dimensions
/// converge faster than 1/√N. The samples of one pixel are *not* independent: a sample variance
/// over them overestimates the error; compare renderings with different seeds instead.
///
/// Each dimension is scrambled linearly, by one of a few random matrices and any shift (Matoušek
/// 1998), with the variance of Owen's scrambling (1995).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sobol {
    /// Different seeds give independent renderings.
    pub seed: u64,
}

/// Bits of an index and of each of its dimensions. Later samples take the next, independently
/// scrambled sequence.
const BITS: usize = 16;

/// Number of linear scrambles to choose from.
const SCRAMBLES: usize = 64;

/// A sequence in four dimensions, 16 bits each, the first one's on top: the exclusive or of what
/// each hexadecimal digit of an index contributes.
#[derive(Clone, Copy)]
struct Sequence([[u64; 16]; BITS / 4]);

static SEQUENCES: LazyLock<[Sequence; SCRAMBLES]> =
    LazyLock::new(|| std::array::from_fn(|key| Sequence::new(scrambled(generators(), key as u64))));

impl Sequence {
    /// The sequence with these points for the single bits of an index.
    fn new(generators: [u64; BITS]) -> Self {
        let contribution = |digit: usize, value: usize| {
            let bits = (0..4).filter(|bit| value >> bit & 1 == 1);
            bits.fold(0, |point, bit| point ^ generators[4 * digit + bit])
        };
        Self(std::array::from_fn(|digit| std::array::from_fn(|value| contribution(digit, value))))
    }

    #[inline]
    fn point(&self, index: u32) -> u64 {
        let digit = |n: usize| self.0[n][(index >> (4 * n) & 15) as usize];
        digit(0) ^ digit(1) ^ digit(2) ^ digit(3)
    }
}

/// The points of the single bits of an index, by the direction numbers of Joe and Kuo (2008).
fn generators() -> [u64; BITS] {
    // The degree of a primitive polynomial, its inner coefficients, and the numbers to start with.
    let dimension = |degree: usize, coefficients: usize, first: &[u16]| {
        let mut v: Vec<u16> = first.iter().enumerate().map(|(i, m)| m << (BITS - 1 - i)).collect();
        for i in degree..BITS {
            let inner = (1..degree).filter(|k| coefficients >> (degree - 1 - k) & 1 == 1);
            v.push(inner.fold(v[i - degree] ^ v[i - degree] >> degree, |all, k| all ^ v[i - k]));
        }
        v
    };
    let radical_inverse = (0..BITS).map(|i| 1 << (BITS - 1 - i)).collect();
    let dimensions = [
        radical_inverse,
        dimension(1, 0, &[1]),
        dimension(2, 1, &[1, 3]),
        dimension(3, 1, &[1, 3, 1]),
    ];
    std::array::from_fn(|bit| dimensions.iter().fold(0, |all, v| all << BITS | u64::from(v[bit])))
}

/// Points after a linear scramble: each bit of a dimension changes ones below it, which `key`
/// decides, so that strata stay together.
fn scrambled(points: [u64; BITS], key: u64) -> [u64; BITS] {
    points.map(|point| {
        (0..64).filter(|bit| point >> bit & 1 == 1).fold(0, |all, bit| {
            let lane = bit - bit % BITS as u32;
            let below = nth(key, bit.into()) & ((1 << (bit - lane)) - 1);
            all ^ 1 << bit ^ below << lane
        })
    })
}

/// A permutation of indices that keeps those below a power of two together, and from 256 on blocks
/// of 256, and so the strata of as many samples. Within these it is any: if it kept halves of halves
/// together, as nested scrambling does, pairs of samples would differ in the first bit of every set
/// at once, which takes half as much variance again where sets are multiplied.
#[inline]
fn shuffled(index: u32, key: u64) -> u32 {
    if index < 2 {
        return index;
    }
    let block = index & !255;
    let bits = if block == 0 { index.ilog2() } else { 8 };
    let (mask, shift) = ((1 << bits) - 1, bits.div_ceil(2));
    let key = nth(key, block.into());
    let mut x = index & mask;
    for round in 0..3 {
        // Invertible modulo 2^bits, each step.
        let key = key >> (20 * round);
        x = x.wrapping_add(key as u32) & mask;
        x = x.wrapping_mul((key >> 10) as u32 | 1) & mask;
        x ^= x >> shift;
    }
    index & !mask | x
}

/// The sampler of [`Sobol`].
#[derive(Clone, Copy, Debug)]
pub struct SobolSampler {
    /// Decides the scrambles: equal for all samples of a pixel within one sequence.
    sequence: u64,
    /// Decides the bits below the resolution of the sequence: different for each sample.
    sample: u64,
    /// The number in the sequence.
    index: u32,
    dimension: Dimension,
    /// The set that is in `numbers`.
    cached: Option<u64>,
    numbers: [f64; SET as usize],
}

impl SobolSampler {
    /// Dimension `n` of the current stream.
    #[inline]
    fn number(&mut self, n: u32) -> f64 {
        let set = self.dimension.id(n / SET);
        if self.cached != Some(set) {
            self.numbers = self.set(set);
            self.cached = Some(set);
        }
        self.numbers[(n % SET) as usize]
    }

    /// A set of dimensions. The sequence gives 16 bits; random ones below them cannot carry the
    /// number out of its stratum or to 1.
    #[inline]
    fn set(&self, id: u64) -> [f64; SET as usize] {
        let shift = nth(self.sequence, id);
        let keys = mix(shift);
        let sequence = &SEQUENCES[(keys >> 58) as usize % SCRAMBLES];
        let point = sequence.point(shuffled(self.index, keys)) ^ shift;
        let fine = nth(self.sample, id);
        let number = |lane: usize, fine: u64| {
            unit_interval(point << (BITS * lane) & 0xffff << 48 | (fine & 0xffff_ffff) << BITS)
        };
        let more = mix(fine);
        [number(0, fine), number(1, fine >> 32), number(2, more), number(3, more >> 32)]
    }
}

impl Sampler for SobolSampler {
    #[inline]
    fn next_1d(&mut self) -> f64 {
        let n = self.dimension.number();
        self.number(n)
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        let n = self.dimension.point();
        DVec2::new(self.number(n), self.number(n + 1))
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

impl SampleSource for Sobol {
    type Sampler = SobolSampler;

    #[inline]
    fn sampler(&self, pixel: u32, pass: u32) -> SobolSampler {
        SobolSampler {
            sequence: hash_sample(mix(self.seed) ^ 0x0053_4f42_4f4c, pixel, pass >> BITS),
            sample: hash_sample(self.seed, pixel, pass),
            index: pass % (1 << BITS),
            dimension: Dimension::default(),
            cached: None,
            numbers: [0.0; SET as usize],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coordinates of the sequence itself, in units of 2⁻¹⁶.
    fn coordinates(point: u64) -> [u16; 4] {
        [48, 32, 16, 0].map(|shift| (point >> shift) as u16)
    }

    #[test]
    fn points_are_those_of_joe_and_kuo() {
        let sequence = Sequence::new(generators());
        let eighths: Vec<[u16; 4]> =
            (0..8).map(|i| coordinates(sequence.point(i)).map(|x| x >> 13)).collect();
        assert_eq!(
            eighths,
            [
                [0, 0, 0, 0],
                [4, 4, 4, 4],
                [2, 6, 6, 6],
                [6, 2, 2, 2],
                [1, 5, 3, 1],
                [5, 1, 7, 5],
                [3, 3, 5, 7],
                [7, 7, 1, 3],
            ]
        );
    }

    /// A block of 2ᵏ points fills 2ᵏ intervals in each dimension, and in the first two all
    /// elementary rectangles, whatever the scramble and the order.
    #[test]
    fn scrambles_keep_strata_and_shuffles_keep_blocks() {
        for (number, sequence) in SEQUENCES.iter().enumerate() {
            let key = nth(7, number as u64);
            for (first, bits) in [(0, 4), (64, 6), (256, 8), (65_536 - 4096, 12)] {
                let points: Vec<[u16; 4]> = (first..first + (1u32 << bits))
                    .map(|i| coordinates(sequence.point(shuffled(i, key))))
                    .collect();
                let are_filled = |cell: &dyn Fn(&[u16; 4]) -> u32| {
                    let mut cells: Vec<u32> = points.iter().map(cell).collect();
                    cells.sort_unstable();
                    cells.into_iter().eq(0..1 << bits)
                };
                let leading = |x: u16, count: u32| u32::from(x) >> (BITS as u32 - count);
                for d in 0..4 {
                    assert!(are_filled(&|x| leading(x[d], bits)), "{number}: {first}, {d}");
                }
                for split in 1..bits {
                    let cell = |x: &[u16; 4]| {
                        leading(x[0], split) << (bits - split) | leading(x[1], bits - split)
                    };
                    assert!(are_filled(&cell), "{number}: {first}, {split}");
                }
            }
        }
    }
}
