//! Independent uniform numbers: plain Monte Carlo.

use super::hash::{combine, hash_sample, mix, unit_interval};
use super::{SampleSource, Sampler};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

/// Independent uniform numbers. The error falls as 1/√N and sample variances estimate it without
/// bias.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Independent {
    /// Different seeds give independent renderings.
    pub seed: u64,
}

/// The sampler of [`Independent`]: PCG XSL-RR 128/64 (O'Neill 2014).
#[derive(Clone, Debug)]
pub struct IndependentSampler {
    generator: Pcg64,
}

impl IndependentSampler {
    /// A generator whose sequence is decided by all 64 bits of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        // PCG's streams are only as independent as their starts, so the whole state is hashed and
        // so is the stream.
        let word =
            |n: u64| u128::from(mix(seed.wrapping_add(n.wrapping_mul(0x9e37_79b9_7f4a_7c15))));
        Self { generator: Pcg64::new(word(1) << 64 | word(2), word(3) << 64 | word(4)) }
    }

    /// A generator seeded by the next numbers of a sampler: they are independent also where those of
    /// different samples are not, as Sobol' points.
    #[must_use]
    pub fn seeded_by<P: Sampler>(sampler: &mut P) -> Self {
        let bits = [sampler.next_1d(), sampler.next_1d()].map(f64::to_bits);
        Self::new(combine(mix(bits[0]), bits[1]))
    }

    /// The next 64 bits.
    #[inline]
    pub fn next_u64(&mut self) -> u64 {
        self.generator.next_u64()
    }
}

impl Sampler for IndependentSampler {
    #[inline]
    fn next_1d(&mut self) -> f64 {
        unit_interval(self.generator.next_u64())
    }
}

impl SampleSource for Independent {
    type Sampler = IndependentSampler;

    #[inline]
    fn sampler(&self, pixel: u32, pass: u32) -> IndependentSampler {
        IndependentSampler::new(hash_sample(self.seed, pixel, pass))
    }
}
