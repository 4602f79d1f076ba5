//! Owen-scrambled Sobol' sequences: randomised quasi-Monte Carlo.

use super::dimension::Dimension;
use super::hash::{combine, hash_sample, mix, unit_interval};
use super::{SampleSource, Sampler, Stream};
use glam::DVec2;

/// Owen-scrambled Sobol' points (Sobol' 1967; Owen 1995; hashed scrambling by Burley 2020), four dimensions at a time.
///
/// Each pixel and each set of four dimensions of a [`Stream`] has its own scramble (padding), so any single estimate
/// is unbiased, and smooth integrands in few dimensions converge faster than 1/√N. The samples of one pixel are *not* independent: a
/// sample variance over them overestimates the error; compare renderings with different seeds instead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sobol {
    /// Different seeds give independent renderings.
    pub seed: u64,
}

/// Points of one scrambled sequence; what `sobol_burley` supports. Later samples take the next, independently scrambled sequence.
const SEQUENCE_LENGTH: u32 = 1 << 16;
/// Dimensions that are stratified together.
const SET: u32 = 4;

/// The sampler of [`Sobol`].
#[derive(Clone, Copy, Debug)]
pub struct SobolSampler {
    /// Decides the scrambles: equal for all samples of a pixel within one sequence.
    sequence: u64,
    /// Decides the bits below the resolution of the sequence: different for each sample.
    sample: u64,
    index: u32,
    dimension: Dimension,
    /// The set that is in `points`, as (stream, number within the stream).
    cached: Option<(u64, u32)>,
    points: [f32; SET as usize],
}

impl SobolSampler {
    /// Two dimensions for a point. They must not straddle two sets, which know nothing of each other.
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
        let stream = self.dimension.stream;
        let set = n / SET;
        if self.cached != Some((stream, set)) {
            let scramble = combine(combine(self.sequence, stream), u64::from(set));
            self.points = sobol_burley::sample_4d(self.index, 0, (scramble >> 32) as u32);
            self.cached = Some((stream, set));
        }
        // The sequence gives 24 bits; random ones below them make 53 and cannot carry the number out of its stratum or to 1.
        const RESOLUTION: f64 = (1u64 << 24) as f64;
        let coarse = (f64::from(self.points[(n % SET) as usize]) * RESOLUTION) as u64;
        let fine = combine(combine(self.sample, stream), u64::from(n));
        unit_interval(coarse << 40 | fine >> 24)
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
            points: [0.0; SET as usize],
        }
    }
}
