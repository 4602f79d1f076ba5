//! The ready-made samplers as one type, for choosing one at run time.

use super::independent::IndependentSampler;
use super::stratified::StratifiedSampler;
use super::{
    ChainSampler, Independent, SampleSource, Sampler, Sobol, SobolSampler, Stratified, Stream,
};
use glam::DVec2;

/// A choice of sampler.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SamplerKind {
    /// [`Independent`]: plain Monte Carlo, whose variance can be estimated from the samples of one
    /// image.
    Independent,
    /// [`Stratified`] over the samples of each pixel.
    Stratified,
    /// [`Sobol`]: randomised quasi-Monte Carlo.
    #[default]
    Sobol,
}

impl SamplerKind {
    /// The source of this kind. `samples_per_pixel` decides the number of strata; it need not be
    /// what is taken in the end.
    #[must_use]
    pub fn source(self, seed: u64, samples_per_pixel: u32) -> AnySource {
        match self {
            Self::Independent => AnySource::Independent(Independent { seed }),
            Self::Stratified => AnySource::Stratified(Stratified { seed, samples_per_pixel }),
            Self::Sobol => AnySource::Sobol(Sobol { seed }),
        }
    }
}

/// One of the ready-made sources. One match per number costs less than compiling every integrator
/// once per sampler.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AnySource {
    /// Independent numbers.
    Independent(Independent),
    /// Stratified numbers.
    Stratified(Stratified),
    /// Scrambled Sobol' points.
    Sobol(Sobol),
}

/// The sampler of an [`AnySource`], or of a Markov chain.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum AnySampler {
    /// Independent numbers.
    Independent(IndependentSampler),
    /// Stratified numbers.
    Stratified(StratifiedSampler),
    /// Scrambled Sobol' points.
    Sobol(SobolSampler),
    /// The numbers of a Markov chain.
    Chain(Box<ChainSampler>),
}

impl SampleSource for AnySource {
    type Sampler = AnySampler;

    #[inline]
    fn sampler(&self, pixel: u32, pass: u32) -> AnySampler {
        match self {
            Self::Independent(source) => AnySampler::Independent(source.sampler(pixel, pass)),
            Self::Stratified(source) => AnySampler::Stratified(source.sampler(pixel, pass)),
            Self::Sobol(source) => AnySampler::Sobol(source.sampler(pixel, pass)),
        }
    }
}

impl Sampler for AnySampler {
    #[inline]
    fn next_1d(&mut self) -> f64 {
        match self {
            Self::Independent(sampler) => sampler.next_1d(),
            Self::Stratified(sampler) => sampler.next_1d(),
            Self::Sobol(sampler) => sampler.next_1d(),
            Self::Chain(sampler) => sampler.next_1d(),
        }
    }

    #[inline]
    fn next_2d(&mut self) -> DVec2 {
        match self {
            Self::Independent(sampler) => sampler.next_2d(),
            Self::Stratified(sampler) => sampler.next_2d(),
            Self::Sobol(sampler) => sampler.next_2d(),
            Self::Chain(sampler) => sampler.next_2d(),
        }
    }

    #[inline]
    fn next_1d_2d(&mut self) -> (f64, DVec2) {
        match self {
            Self::Independent(sampler) => sampler.next_1d_2d(),
            Self::Stratified(sampler) => sampler.next_1d_2d(),
            Self::Sobol(sampler) => sampler.next_1d_2d(),
            Self::Chain(sampler) => sampler.next_1d_2d(),
        }
    }

    #[inline]
    fn skip_1d(&mut self) {
        match self {
            Self::Independent(sampler) => sampler.skip_1d(),
            Self::Stratified(sampler) => sampler.skip_1d(),
            Self::Sobol(sampler) => sampler.skip_1d(),
            Self::Chain(sampler) => sampler.skip_1d(),
        }
    }

    #[inline]
    fn skip_2d(&mut self) {
        match self {
            Self::Independent(sampler) => sampler.skip_2d(),
            Self::Stratified(sampler) => sampler.skip_2d(),
            Self::Sobol(sampler) => sampler.skip_2d(),
            Self::Chain(sampler) => sampler.skip_2d(),
        }
    }

    #[inline]
    fn stream(&mut self, stream: Stream) {
        match self {
            Self::Independent(sampler) => sampler.stream(stream),
            Self::Stratified(sampler) => sampler.stream(stream),
            Self::Sobol(sampler) => sampler.stream(stream),
            Self::Chain(sampler) => sampler.stream(stream),
        }
    }
}
