//! The driver: turns an integrator into an image, within a budget, on several threads, and says
//! what it did.
//!
//! A rendering proceeds in *passes* of one sample per pixel of the window. A pass is cut into
//! chunks of consecutive pixels whose size depends on the window alone; threads take chunks as they
//! come, a few of the next pass too, and what chunks recorded is merged in the order of their
//! numbers. Random numbers depend on (seed, pixel, pass). So the same settings give the same image
//! to the bit for any number of threads, after every pass.

#[cfg(feature = "report")]
mod alone;
mod checkpoint;
mod chunks;
mod compiled;
mod driver;
mod identity;
#[cfg(feature = "image")]
mod image_file;
mod measure;
#[cfg(feature = "checkpoint")]
mod npz;
mod queue;
mod settings;
mod shard;
mod state;
mod target;
#[cfg(test)]
mod tests;

pub use checkpoint::{Checkpoint, CheckpointError, MergeError, Merger};
#[cfg(feature = "report")]
pub(crate) use identity::Identity;
pub use measure::{Measurement, measure};
#[cfg(feature = "checkpoint")]
pub use npz::CheckpointFileError;
pub use settings::{Budget, RenderError, Settings};
pub use shard::{Shard, ShardError};

use crate::endpoint::Camera;
use crate::film::{Film, Filter, Image, NonFinite};
use crate::integrator::{Integrator, Notes};
use crate::path::{Counters, MissingPaths, TechniqueSet};
use crate::sampler::{SampleSource, SamplerKind};
use crate::scene::Scene;
#[cfg(feature = "report")]
pub(crate) use alone::Alone;
use compiled::Compiled;
#[cfg(feature = "report")]
pub(crate) use compiled::start_alone;
use driver::drive;
use state::State;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

/// The state of a rendering after a pass.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    /// Passes done: samples per pixel so far.
    pub passes: u32,
    /// Part of the budget that is used, or of the way to the target error if that is nearer, 0 to
    /// 1.
    pub fraction: f64,
    /// Wall-clock time spent rendering; time spent in the progress callback does not count,
    /// although other threads begin with the next pass in it.
    pub wall: Duration,
    /// The sums so far.
    pub film: &'a Film,
    /// Counts of what was done so far.
    pub counters: &'a Counters,
    state: &'a State,
    /// Makes a checkpoint of it.
    keep: &'a dyn Fn(&State) -> Checkpoint,
}

impl fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { passes, fraction, wall, .. } = self;
        let mut progress = f.debug_struct("Progress");
        progress.field("passes", passes).field("fraction", fraction).field("wall", wall);
        progress.finish_non_exhaustive()
    }
}

impl Progress<'_> {
    /// The image so far.
    #[must_use]
    pub fn image(&self) -> Image {
        self.state.image()
    }

    /// The rendering so far, from which [`resume`](resume()) goes on. It costs little if it is
    /// dropped before the next pass, else a copy of the film; the first one takes the scene's
    /// [fingerprint](Scene::fingerprint).
    #[must_use]
    pub fn checkpoint(&self) -> Checkpoint {
        (self.keep)(self.state)
    }
}

/// A finished, or stopped, rendering.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The image of the film's window, in radiance.
    pub image: Image,
    /// The sums that the image comes from.
    pub film: Arc<Film>,
    /// Samples per pixel, the same in all pixels; of a shard, its own.
    pub samples_per_pixel: u32,
    /// Counts of what was done. `non_finite` includes the contributions that the film refused.
    pub counters: Counters,
    /// Wall-clock time spent rendering, without the progress callback.
    pub wall: Duration,
    /// The part of it before the first pass, in which lights were observed and the integrator
    /// prepared itself.
    pub preparation: Duration,
    /// Sum over the threads of the time that they spent on samples: processor time, if no thread
    /// had to wait for a processor.
    pub thread_time: Duration,
    /// The techniques that the integrator ran.
    pub techniques: TechniqueSet,
    /// The notes of the run on its estimate: omissions, what is missing, decision, bias.
    pub notes: Notes,
    /// The integrator's name.
    pub integrator: &'static str,
    /// The pixel filter.
    pub filter: Filter,
    /// The sampler and the seed; `None` if the caller brought a source of their own.
    pub sampling: Option<(SamplerKind, u64)>,
    /// Estimated relMSE of the image, if the settings have a target for it and there were enough
    /// passes.
    pub estimated_error: Option<f64>,
    /// True if the progress callback stopped the rendering. The image is valid all the same.
    pub stopped: bool,
    /// The rendering as something to go on from, if the
    /// [settings](Settings::keeps_checkpoint) ask for it.
    pub checkpoint: Option<Checkpoint>,
}

impl Rendering {
    /// The blind spots of the integrator: paths that the image lacks, as far as the scene has them;
    /// the same as [`Render::blind_spots`] tells before.
    #[must_use]
    pub fn blind_spots(&self) -> &[MissingPaths] {
        &self.notes.missing
    }

    /// Contributions that were infinite or not a number: none, unless something is wrong.
    #[must_use]
    pub fn non_finite(&self) -> &NonFinite {
        self.film.non_finite()
    }
}

/// The image of a scene, with one of the ready-made samplers.
///
/// # Errors
/// If the settings or the camera's film are invalid, the threads cannot be started, or the
/// integrator cannot render the scene.
pub fn render<S: Scene + ?Sized, I: Integrator<S>>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &I,
    settings: &Settings,
) -> Result<Rendering, RenderError> {
    render_with_progress(scene, camera, integrator, settings, &mut |_| ControlFlow::Continue(()))
}

/// [`render()`] with `progress`, which is called after each pass, on this thread, and may stop the
/// rendering.
///
/// # Errors
/// Those of [`render()`].
pub fn render_with_progress<S: Scene + ?Sized, I: Integrator<S>>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &I,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError> {
    (Compiled::NEAREST.render)((scene, camera, integrator), settings, None, progress)
}

/// [`render_with_progress`] with the given source of random numbers, in place of the settings' `seed`
/// and `sampler`.
///
/// # Errors
/// Those of [`render()`].
pub fn render_with_source<N: SampleSource, S: Scene + ?Sized, I: Integrator<S>>(
    source: &N,
    scene: &S,
    camera: &dyn Camera,
    integrator: &I,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError> {
    drive((source, None), (scene, camera, integrator), settings, None, progress)
}

/// [`render_with_progress`] from a checkpoint on: the result is that of a rendering without a break,
/// to the bit. One that [`learns`](crate::integrator::Run::learns) draws all passes again to learn
/// from them.
///
/// # Errors
/// Those of [`render()`], and if the checkpoint is of another rendering.
pub fn resume<S: Scene + ?Sized, I: Integrator<S>>(
    checkpoint: Checkpoint,
    scene: &S,
    camera: &dyn Camera,
    integrator: &I,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError> {
    let of = (scene, camera, integrator);
    (Compiled::NEAREST.render)(of, settings, Some(checkpoint), progress)
}

/// An integrator that renders scenes of type `S`, as an object: `&[&dyn Render<S>]` is a
/// comparison. Every [`Integrator`] is one.
pub trait Render<S: Scene + ?Sized>: Sync {
    /// The integrator's name.
    fn name(&self) -> &'static str;

    /// The image of a scene; see [`render()`].
    ///
    /// # Errors
    /// If the settings or the camera's film are invalid, the threads cannot be started, or the
    /// integrator cannot render the scene.
    fn render(
        &self,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
    ) -> Result<Rendering, RenderError> {
        self.render_with_progress(scene, camera, settings, &mut |_| ControlFlow::Continue(()))
    }

    /// The image of a scene, with a callback; see [`render_with_progress`].
    ///
    /// # Errors
    /// Those of [`Self::render`].
    fn render_with_progress(
        &self,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Rendering, RenderError>;

    /// The rendering from a checkpoint on; see [`resume`](resume()).
    ///
    /// # Errors
    /// Those of [`resume`](resume()).
    fn resume(
        &self,
        checkpoint: Checkpoint,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Rendering, RenderError>;

    /// The blind spots of the integrator: paths that its image will lack, as far as the scene has
    /// them, known before it is rendered. By default it does not know of any. Afterwards
    /// [`Rendering::blind_spots`] tells the same.
    ///
    /// # Errors
    /// If the integrator cannot render the scene.
    fn blind_spots(
        &self,
        scene: &S,
        camera: &dyn Camera,
    ) -> Result<Vec<MissingPaths>, RenderError> {
        let _ = (scene, camera);
        Ok(Vec::new())
    }
}

impl<S: Scene + ?Sized, I: Integrator<S>> Render<S> for I {
    fn name(&self) -> &'static str {
        Integrator::name(self)
    }

    fn render_with_progress(
        &self,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Rendering, RenderError> {
        render_with_progress(scene, camera, self, settings, progress)
    }

    fn resume(
        &self,
        checkpoint: Checkpoint,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Rendering, RenderError> {
        resume(checkpoint, scene, camera, self, settings, progress)
    }

    fn blind_spots(
        &self,
        scene: &S,
        camera: &dyn Camera,
    ) -> Result<Vec<MissingPaths>, RenderError> {
        (Compiled::NEAREST.blind_spots)(scene, camera, self)
    }
}
