//! Renderings of an integrator in a view of the scene, which lives as long as samples are drawn.

use super::{Caller, Crew, Integrator, IntegratorError, Notes, Run, Stage};
use crate::film::{Sample, Sink};
use crate::path::{Counters, Scratch, TechniqueSet};
use crate::sampler::Sampler;
use crate::scene::Scene;

/// The techniques and the notes of an integrator on a stage.
///
/// # Errors
/// If it cannot render the stage, or keeps something from sample to sample, for which a view does
/// not live long enough.
pub(super) fn look<'v, S: Scene + ?Sized, I: Integrator<S>>(
    integrator: &'v I,
    stage: Stage<'v, S>,
    crew: &dyn Crew,
) -> Result<(TechniqueSet, Notes), IntegratorError> {
    let mut run = integrator.start(stage, crew)?;
    if run.prepares() || run.take_preparation() != Counters::default() {
        return Err(IntegratorError {
            integrator: integrator.name(),
            reason: "what its samples share cannot be kept for a scene that a rendering changes: \
                     render the changed scene itself with it"
                .to_owned(),
        });
    }
    Ok((run.techniques(), run.notes()))
}

/// Draws samples of an integrator, whose run keeps nothing, on a stage.
pub(super) fn draw<'v, S: Scene + ?Sized, I: Integrator<S>, P: Sampler>(
    integrator: &'v I,
    stage: Stage<'v, S>,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    counters: &mut Counters,
) {
    // It has been started before, without an error.
    let Ok(run) = integrator.start(stage, &Caller) else { return };
    let mut scratch = Scratch::default();
    run.draw(samples, sink, &mut Default::default(), &mut scratch);
    *counters += scratch.counters;
}
