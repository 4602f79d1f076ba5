//! Integrators: each is a set of techniques for drawing paths.
//!
//! | integrator | techniques |
//! |---|---|
//! | [`UniformArea`] | every vertex behind the first surface uniform on the scene's area: the lecture's estimator |
//! | [`PathTracer`] | s = 0 (hit a light) and s = 1 (emitter sampling), or either alone |
//! | [`LightTracer`] | t = 1 (connect to the lens) |
//! | [`Bidirectional`] | all (s, t), or any set of them |
//!
//! All of them estimate the same image, with the same normalisation and the same meaning of depth.

mod bidirectional;
mod light_tracer;
mod path_tracer;
mod uniform_area;

pub use bidirectional::Bidirectional;
pub use light_tracer::LightTracer;
pub use path_tracer::{PathTracer, PathTracing};
pub use uniform_area::UniformArea;

use crate::endpoint::Camera;
use crate::film::{FilmSample, Sink};
use crate::path::{MAX_BOUNCES, Scratch, TechniqueSet};
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

/// Which paths count, by their number of scattering events; 0 is light that comes straight from an emitter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Depth {
    /// Paths with fewer scattering events are left out.
    pub min_bounces: u32,
    /// Paths with more scattering events are left out; `None` for no limit but [`MAX_BOUNCES`].
    pub max_bounces: Option<u32>,
}

impl Depth {
    /// Up to `max_bounces` scattering events.
    #[must_use]
    pub const fn up_to(max_bounces: u32) -> Self {
        Self { min_bounces: 0, max_bounces: Some(max_bounces) }
    }

    /// Exactly `bounces` scattering events.
    #[must_use]
    pub const fn exactly(bounces: u32) -> Self {
        Self { min_bounces: bounces, max_bounces: Some(bounces) }
    }

    /// The largest number of scattering events.
    #[must_use]
    pub fn limit(&self) -> u32 {
        self.max_bounces.map_or(MAX_BOUNCES, |max| max.min(MAX_BOUNCES))
    }

    /// Whether paths with so many scattering events count.
    #[inline]
    #[must_use]
    pub fn contains(&self, bounces: u32) -> bool {
        self.min_bounces <= bounces && bounces <= self.limit()
    }
}
