//! Random numbers: a [`Sampler`] per sample, made by a [`SampleSource`] from the sample's index.
//!
//! A path of any length is a function of a point `u ∈ [0, 1)^∞`; a sampler is that point, number by
//! number. Since it follows from pixel, pass and seed alone, a sample can be drawn again at any
//! time, and no number of threads changes an image. [`Stream`] names the purpose of the next
//! numbers, so that the same decision of different paths uses the same dimension.
//!
//! | points | item |
//! |---|---|
//! | independent | [`Independent`] |
//! | stratified over the samples of a pixel | [`Stratified`] |
//! | scrambled Sobol' points | [`Sobol`] |
//! | any of them, chosen at run time | [`SamplerKind`], [`AnySource`] |
//! | recorded and played back | [`Recorder`], [`Replay`] |
//! | of a Markov chain, moved a little from state to state | [`ChainSampler`] |

mod chain;
mod dimension;
mod hash;
mod independent;
mod kind;
mod replay;
mod sobol;
mod stratified;
#[cfg(test)]
mod tests;

pub use chain::ChainSampler;
pub use independent::{Independent, IndependentSampler};
pub use kind::{AnySampler, AnySource, SamplerKind};
pub use replay::{Recorder, Replay};
pub use sobol::{Sobol, SobolSampler};
pub use stratified::{Stratified, StratifiedSampler};

use glam::DVec2;

/// The purpose of the next numbers; lets structured samplers keep their dimensions aligned whatever
/// a path does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stream {
    /// Position on the film and the offset of the pixel filter.
    Film,
    /// The start of the camera subpath: a point on the lens.
    Lens,
    /// The start of the light subpath: choice of light, point and direction.
    Emission,
    /// Scattering at the given vertex of the camera subpath (1 = first surface).
    CameraVertex(u32),
    /// Scattering at the given vertex of the light subpath (1 = first surface).
    LightVertex(u32),
    /// Next event estimation from the given vertex of the camera subpath.
    NextEvent(u32),
    /// Sampling of the lens from the given vertex of the light subpath.
    LensSampling(u32),
    /// The length of the path, where it is chosen beforehand. A Markov chain keeps it.
    PathLength,
    /// The technique, where one is chosen for the sample.
    Technique,
}

/// A source of numbers in `[0, 1)` for one sample. It is dyn-safe and open for users to implement.
pub trait Sampler {
    /// The next number in `[0, 1)`.
    fn next_1d(&mut self) -> f64;

    /// The next point of the unit square `[0, 1)²`.
    fn next_2d(&mut self) -> DVec2 {
        DVec2::new(self.next_1d(), self.next_1d())
    }

    /// The next number, and the next point behind it: a choice, and where to go.
    fn next_1d_2d(&mut self) -> (f64, DVec2) {
        (self.next_1d(), self.next_2d())
    }

    /// Passes over a number that nobody will look at, such as where on a pinhole: what comes after
    /// it is the same as if it had been drawn.
    fn skip_1d(&mut self) {
        self.next_1d();
    }

    /// Passes over a point that nobody will look at.
    fn skip_2d(&mut self) {
        self.next_2d();
    }

    /// Announces what the numbers from here on are for. Unstructured samplers ignore it.
    fn stream(&mut self, _stream: Stream) {}
}

impl<T: Sampler + ?Sized> Sampler for &mut T {
    fn next_1d(&mut self) -> f64 {
        (**self).next_1d()
    }
    fn next_2d(&mut self) -> DVec2 {
        (**self).next_2d()
    }
    fn next_1d_2d(&mut self) -> (f64, DVec2) {
        (**self).next_1d_2d()
    }
    fn skip_1d(&mut self) {
        (**self).skip_1d();
    }
    fn skip_2d(&mut self) {
        (**self).skip_2d();
    }
    fn stream(&mut self, stream: Stream) {
        (**self).stream(stream);
    }
}

/// Makes the sampler of each sample. The index alone decides its numbers, never the thread or the
/// order of calls.
pub trait SampleSource: Sync {
    /// The sampler of one sample.
    type Sampler: Sampler;

    /// The sampler of sample number `pass` of pixel number `pixel` (row-major in the rendered
    /// window).
    fn sampler(&self, pixel: u32, pass: u32) -> Self::Sampler;
}
