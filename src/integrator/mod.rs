//! Integrators: each is a set of techniques for drawing paths.
//!
//! | integrator | techniques |
//! |---|---|
//! | [`UniformArea`] | every vertex behind the first surface uniform on the scene's area: the lecture's estimator |
//! | [`PathTracer`] | s = 0 (hit a light) and s = 1 (emitter sampling), or either alone |
//! | [`LightTracer`] | t = 1 (connect to the lens) |
//! | [`Bidirectional`] | all (s, t), or any set of them |
//! | [`Adaptive`] | the most efficient set, from path tracing to all (s, t), as a pilot finds it |
//!
//! All of them estimate the same image, with the same normalisation and the same meaning of depth.

mod adaptive;
mod bidirectional;
mod light_tracer;
mod path_tracer;
mod uniform_area;

pub use adaptive::{Adaptive, Candidate, Decision, TechniqueRecord};
pub use bidirectional::Bidirectional;
pub use light_tracer::LightTracer;
pub use path_tracer::{PathTracer, PathTracing};
pub use uniform_area::UniformArea;

use crate::endpoint::Camera;
use crate::film::{BatchSample, BatchSink, Contribution, FilmSample, Kernel, Sink};
use crate::path::{Counters, LeftOut, MAX_BOUNCES, Scratch, TechniqueSet};
use crate::sampler::Sampler;
use crate::scene::{Needs, Scene};

/// A way to estimate the image: draws paths and reports their contributions. Open for users to
/// implement.
pub trait Integrator<S: Scene + ?Sized>: Sync {
    /// The name in the field's terms, such as `path-tracing`.
    fn name(&self) -> &'static str;

    /// The techniques that it runs on a scene with these needs.
    fn techniques(&self, needs: &Needs) -> TechniqueSet;

    /// What it would run on a scene that needs everything, and leaves out on this one.
    fn left_out(&self, needs: &Needs) -> LeftOut {
        self.techniques(&Needs::ALL).left_out(needs)
    }

    /// Looks at the scene before the first sample and says what to run instead; `None`, the
    /// default, to run what it is. The driver asks once for each rendering.
    fn adapt<C: Camera + ?Sized>(
        &self,
        _scene: &S,
        _camera: &C,
        _pilot: &Pilot<'_>,
    ) -> Option<Adapted<Self>>
    where
        Self: Sized,
    {
        None
    }

    /// Draws one sample of the image: one camera walk, one light walk, or one of each. Every
    /// integrator normalises alike: with N samples spread evenly over the window of P pixels, a
    /// pixel's value is `P/N` times the sum of the contributions that fall in it.
    fn sample<'s, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    );

    /// Draws several samples: the contributions of each are those of [`sample`](Self::sample), in
    /// the same order; those of different samples may mix. By default one after the other; an
    /// integrator that lets them advance together gives the scene many rays at a time.
    fn sample_batch<'s, C: Camera + ?Sized, P: Sampler, K: BatchSink>(
        &self,
        scene: &'s S,
        camera: &C,
        samples: &mut [BatchSample<P>],
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        for (i, BatchSample { film, sampler }) in samples.iter_mut().enumerate() {
            self.sample(scene, camera, *film, sampler, &mut OneOf { sink, sample: i }, scratch);
        }
    }
}

/// What an integrator that adapts itself may use.
pub struct Pilot<'a> {
    /// Samples that the rendering will take over all pixels, as far as that is known.
    pub samples: u64,
    /// The rendering's seed.
    pub seed: u64,
    /// The kernel of the pixel filter.
    pub kernel: &'a Kernel,
    /// Calls a function with every number below the given one, each once, on the rendering's
    /// threads.
    pub parallel: &'a (dyn Fn(usize, Task<'_>) + Sync + 'a),
}

/// Work in numbered parts that may be done in any order, at the same time.
pub type Task<'a> = &'a (dyn Fn(usize) + Sync);

impl std::fmt::Debug for Pilot<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pilot")
            .field("samples", &self.samples)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}

/// An integrator that has adapted itself.
#[derive(Clone, Debug)]
pub struct Adapted<I> {
    /// What to run.
    pub integrator: I,
    /// Why.
    pub decision: Decision,
    /// What it took to decide. None of it is in the image.
    pub counters: Counters,
}

/// Which paths count, by their number of scattering events; 0 is light that comes straight from an
/// emitter.
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

    /// The same, less what a scene with these needs has no light for.
    #[inline]
    #[must_use]
    pub fn within(self, needs: &Needs) -> Self {
        match needs.most_bounces() {
            Some(most) => Self {
                max_bounces: Some(self.max_bounces.map_or(most, |max| max.min(most))),
                ..self
            },
            None => self,
        }
    }

    /// The largest number of scattering events.
    #[inline]
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

/// What one sample of a batch adds to.
struct OneOf<'a, K: ?Sized> {
    sink: &'a mut K,
    sample: usize,
}

impl<K: BatchSink + ?Sized> Sink for OneOf<'_, K> {
    fn add(&mut self, contribution: &Contribution) {
        self.sink.add(self.sample, contribution);
    }
}

/// What the only sample of a batch adds to.
struct Alone<'a, K: ?Sized>(&'a mut K);

impl<K: Sink + ?Sized> BatchSink for Alone<'_, K> {
    fn add(&mut self, _sample: usize, contribution: &Contribution) {
        self.0.add(contribution);
    }
}
