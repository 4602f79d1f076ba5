//! Runs as objects, so that a driver is compiled once for all of them, and those of the built-in
//! integrators on a [`World`] together with this crate.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::{Crew, Integrator, IntegratorError, Notes, Run, Stage, Started};
use crate::film::{Sample, Sink};
use crate::path::{Counters, Scratch, TechniqueSet};
use crate::sampler::{AnySampler, Sampler};
use crate::scene::{Scene, World};
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// A [`Run`] as an object, for one type of samplers. It keeps the states of its chunks itself.
pub trait AnyRun<'a, S: Scene + ?Sized, P>: Sync {
    /// See [`Run::techniques`].
    fn techniques(&self) -> TechniqueSet;
    /// See [`Run::notes`].
    fn notes(&self) -> Notes;
    /// See [`Run::prepares`].
    fn prepares(&self) -> bool;
    /// See [`Run::learns`].
    fn learns(&self) -> bool;
    /// Makes room for so many chunks, if the run [`learns`](Run::learns).
    fn keep_chunks(&mut self, count: usize);
    /// See [`Run::begin_pass`].
    ///
    /// # Errors
    /// If there is not enough memory.
    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError>;
    /// Draws samples of the chunk of this number; see [`Run::draw`].
    fn draw(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        chunk: usize,
        scratch: &mut Scratch<'a, S>,
    );
    /// Draws a sample in a chunk of its own; see [`Run::sample`].
    fn sample(&self, sample: Sample<P>, sink: &mut dyn Sink, scratch: &mut Scratch<'a, S>);
    /// Learns from all chunks; see [`Run::collect`].
    fn collect(&mut self);
    /// See [`Run::take_preparation`].
    fn take_preparation(&mut self) -> Counters;
}

/// A run with the states of its chunks.
struct Kept<R, C> {
    run: R,
    chunks: Vec<Mutex<C>>,
}

impl<'a, S: Scene + ?Sized + 'a, P: Sampler, R: Run<'a, S>> AnyRun<'a, S, P> for Kept<R, R::Chunk> {
    fn techniques(&self) -> TechniqueSet {
        self.run.techniques()
    }

    fn notes(&self) -> Notes {
        self.run.notes()
    }

    fn prepares(&self) -> bool {
        self.run.prepares()
    }

    fn learns(&self) -> bool {
        self.run.learns()
    }

    fn keep_chunks(&mut self, count: usize) {
        let count = if self.run.learns() { count } else { 0 };
        self.chunks.resize_with(count, Mutex::default);
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        self.run.begin_pass(pass, crew)
    }

    fn draw(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        chunk: usize,
        scratch: &mut Scratch<'a, S>,
    ) {
        // No other thread has this chunk.
        let kept = self.chunks.get(chunk);
        let mut kept = kept.map(|chunk| chunk.lock().unwrap_or_else(PoisonError::into_inner));
        let mut own = R::Chunk::default();
        self.run.draw(samples, sink, kept.as_deref_mut().unwrap_or(&mut own), scratch);
    }

    fn sample(&self, sample: Sample<P>, sink: &mut dyn Sink, scratch: &mut Scratch<'a, S>) {
        self.run.sample(sample.film, sample.sampler, sink, scratch);
    }

    fn collect(&mut self) {
        for chunk in &mut self.chunks {
            self.run.collect(chunk.get_mut().unwrap_or_else(PoisonError::into_inner));
        }
    }

    fn take_preparation(&mut self) -> Counters {
        self.run.take_preparation()
    }
}

/// A run as an object that lives as long as its stage.
pub type BoxedRun<'a, S, P> = Box<dyn AnyRun<'a, S, P> + 'a>;

/// An [`Integrator`] as an object, for one type of scenes and one of samplers.
pub trait AnyIntegrator<S: Scene + ?Sized, P>: fmt::Debug + Sync {
    /// See [`Integrator::name`].
    fn name(&self) -> &'static str;
    /// See [`Integrator::chooses_lights`].
    fn chooses_lights(&self) -> bool;
    /// See [`Integrator::start`].
    ///
    /// # Errors
    /// If the settings do not fit the stage, or there is not enough memory.
    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<BoxedRun<'a, S, P>>;
}

/// A run as an object.
fn boxed<'a, S: Scene + ?Sized + 'a, P: Sampler>(run: impl Run<'a, S> + 'a) -> BoxedRun<'a, S, P> {
    Box::new(Kept { run, chunks: Vec::new() })
}

impl<S: Scene + ?Sized, P: Sampler, I: Integrator<S>> AnyIntegrator<S, P> for I {
    fn name(&self) -> &'static str {
        Integrator::name(self)
    }

    fn chooses_lights(&self) -> bool {
        Integrator::chooses_lights(self)
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<BoxedRun<'a, S, P>> {
        Ok(boxed(Integrator::start(self, stage, crew)?))
    }
}

/// The start of an integrator on a [`World`] with the ready-made samplers.
pub type StartOnWorld<I> =
    for<'a> fn(&'a I, Stage<'a, World>, &dyn Crew) -> Started<BoxedRun<'a, World, AnySampler>>;

/// The starts of the built-in integrators. They are no generic functions, and are never inlined, so
/// that runs and all below them are compiled with this crate and not again with each of its users.
pub(super) mod on_world {
    use super::super::{
        Adaptive, Bidirectional, Guiding, InstantRadiosity, LightTracer, Multiplexed, PathTracer,
        PhotonMapping, Regularization, UniformArea, VertexConnectionMerging,
    };
    use super::{AnyIntegrator, AnySampler, BoxedRun, Crew, Stage, Started, World};
    use crate::integrator::metropolis::Chains;

    /// Markov chains as an object, whatever they move.
    #[inline(never)]
    pub fn chains(run: Chains<'_, World>) -> BoxedRun<'_, World, AnySampler> {
        super::boxed(run)
    }

    macro_rules! starts {
        ($($name:ident: $integrator:ty),+ $(,)?) => {$(
            #[inline(never)]
            pub fn $name<'a>(
                settings: &'a $integrator,
                stage: Stage<'a, World>,
                crew: &dyn Crew,
            ) -> Started<BoxedRun<'a, World, AnySampler>> {
                AnyIntegrator::start(settings, stage, crew)
            }
        )+};
    }

    starts! {
        adaptive: Adaptive,
        bidirectional: Bidirectional,
        guided_path_tracer: Guiding<PathTracer>,
        instant_radiosity: InstantRadiosity,
        light_tracer: LightTracer,
        multiplexed: Multiplexed,
        path_tracer: PathTracer,
        photon_mapping: PhotonMapping,
        regularized_path_tracer: Regularization<PathTracer>,
        uniform_area: UniformArea,
        vertex_connection_merging: VertexConnectionMerging,
    }
}
