//! Integrators: each is a set of techniques for drawing paths.

use crate::endpoint::Camera;
use crate::film::{FilmSample, Sink};
use crate::path::{Scratch, TechniqueSet};
use crate::sampler::Sampler;
use crate::scene::{Needs, Scene};

/// A way to estimate the image: draws paths and reports their contributions. Open for users to implement.
pub trait Integrator<S: Scene + ?Sized>: Sync {
    /// The name in the field's terms, such as `path-tracing`.
    fn name(&self) -> &'static str;

    /// The techniques that it runs on a scene with these needs.
    fn techniques(&self, needs: &Needs) -> TechniqueSet;

    /// Draws one sample of the image: one camera walk, one light walk, or one of each. Every integrator normalises alike: with N
    /// samples spread evenly over the window of P pixels, a pixel's value is `P/N` times the sum of the contributions that fall in it.
    fn sample<'s, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    );
}
