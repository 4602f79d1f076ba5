//! Runs that draw one sample after the other in the calling thread, as objects.

use crate::film::{FilmSample, Sample, Sink};
use crate::integrator::{BoxedRun, Caller, IntegratorError};
use crate::path::Scratch;
use crate::sampler::AnySampler;
use crate::scene::Scene;

/// A run with all that it needs to draw samples in the calling thread.
pub trait Alone {
    /// Prepares a pass, if the run prepares any.
    ///
    /// # Errors
    /// If there is not enough memory.
    fn begin_pass(&mut self, pass: u32) -> Result<(), IntegratorError>;

    /// Draws a sample.
    fn draw(&mut self, film: FilmSample, sampler: AnySampler, sink: &mut dyn Sink);

    /// Rays per sample so far, with those of preparations since it was last asked.
    fn rays_per_sample(&mut self) -> f64;
}

/// The run with working memory.
pub(super) fn alone<'a, S: Scene + ?Sized + 'a>(
    mut run: BoxedRun<'a, S, AnySampler>,
) -> Box<dyn Alone + 'a> {
    run.keep_chunks(1);
    let has_chains = run.notes().normalization.is_some();
    Box::new(Drawn { run, has_chains, scratch: Scratch::default() })
}

struct Drawn<'a, S: Scene + ?Sized> {
    run: BoxedRun<'a, S, AnySampler>,
    has_chains: bool,
    scratch: Scratch<'a, S>,
}

impl<'a, S: Scene + ?Sized + 'a> Alone for Drawn<'a, S> {
    fn begin_pass(&mut self, pass: u32) -> Result<(), IntegratorError> {
        if !self.run.prepares() {
            return Ok(());
        }
        if pass > 0 {
            self.run.collect();
        }
        self.run.begin_pass(pass, &Caller)
    }

    fn draw(&mut self, film: FilmSample, sampler: AnySampler, sink: &mut dyn Sink) {
        let Self { run, scratch, .. } = self;
        let sample = Sample { film, sampler };
        if self.has_chains {
            // Those of a chain are all alike, and their tail tells nothing of the integrand's.
            run.sample(sample, sink, scratch);
        } else {
            run.draw(&mut [sample], sink, 0, scratch);
        }
    }

    fn rays_per_sample(&mut self) -> f64 {
        let drawn = &self.scratch.counters;
        let rays = self.run.take_preparation().rays() + drawn.rays();
        rays as f64 / drawn.samples.max(1) as f64
    }
}
