//! The driver: turns an integrator into an image, within a budget, on several threads, and says
//! what it did.
//!
//! A rendering proceeds in *passes* of one sample per pixel of the window. A pass is cut into
//! chunks of consecutive pixels whose size depends on the window alone; threads take chunks as they
//! come, a few of the next pass too, and what chunks recorded is merged in the order of their
//! numbers. Random numbers depend on (seed, pixel, pass). So the same settings give the same image
//! to the bit for any number of threads, after every pass.

mod chunks;
mod compiled;
mod measure;
mod queue;
mod settings;
mod target;
#[cfg(test)]
mod tests;

pub use measure::{Measurement, measure};
pub use settings::{Budget, RenderError, Settings};

use crate::endpoint::Camera;
use crate::film::{Film, Filter, Image, NonFinite};
use crate::integrator::{AnyIntegrator, Arrivals, Crew, Integrator, Notes, Stage};
use crate::path::{Counters, MissingPaths, TechniqueSet};
use crate::sampler::{AnySampler, SampleSource, SamplerKind};
use crate::scene::Scene;
use chunks::{Job, Totals};
use compiled::Compiled;
use settings::Threads;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use target::Watch;

/// The state of a rendering after a pass.
#[derive(Clone, Copy, Debug)]
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
}

impl Progress<'_> {
    /// The image so far.
    #[must_use]
    pub fn image(&self) -> Image {
        self.film.image(samples(self.film, self.passes))
    }
}

/// A finished, or stopped, rendering.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The image of the film's window, in radiance.
    pub image: Image,
    /// The sums that the image comes from.
    pub film: Film,
    /// Samples per pixel, the same in all pixels.
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

    /// The image with its window and metadata (integrator, sampler, seed, filter, samples per
    /// pixel, time, rays), ready to be saved.
    #[cfg(feature = "image")]
    #[must_use]
    pub fn to_file(&self) -> crate::film::ImageFile {
        let mut file = crate::film::ImageFile::from(self.image.clone());
        file.region = Some(self.film.region());
        let entries = [
            ("integrator", self.integrator.to_owned()),
            ("filter", format!("{:?}", self.filter)),
            ("samples_per_pixel", self.samples_per_pixel.to_string()),
            ("seconds", format!("{:.3}", self.wall.as_secs_f64())),
            ("rays", self.counters.rays().to_string()),
            ("non_finite", self.counters.non_finite.to_string()),
        ];
        file.metadata.extend(entries.map(|(key, value)| (key.to_owned(), value)));
        if let Some((sampler, seed)) = self.sampling {
            file.metadata.insert("sampler".to_owned(), format!("{sampler:?}"));
            file.metadata.insert("seed".to_owned(), seed.to_string());
        }
        file
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
    (Compiled::NEAREST.render)(scene, camera, integrator, settings, progress)
}

/// A rendering by objects with the settings' own source of random numbers.
fn drive_ready_made<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &dyn AnyIntegrator<S, AnySampler>,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError> {
    let source = settings.sampler.source(settings.seed, settings.strata());
    let rendering = drive(&source, scene, camera, integrator, settings, progress)?;
    Ok(Rendering { sampling: Some((settings.sampler, settings.seed)), ..rendering })
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
    drive(source, scene, camera, integrator, settings, progress)
}

/// A rendering by objects: compiled once for all integrators on a type of scenes.
fn drive<N: SampleSource, S: Scene + ?Sized>(
    source: &N,
    scene: &S,
    camera: &dyn Camera,
    integrator: &dyn AnyIntegrator<S, N::Sampler>,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError> {
    if settings.budget == Budget::Samples(0) {
        return Err(RenderError::NoSamples);
    }
    if let Some(target) =
        settings.target_error.filter(|target| !(*target > 0.0 && target.is_finite()))
    {
        return Err(RenderError::TargetError(target));
    }
    let kernel = settings.filter.kernel()?;
    let threads = Threads::new(settings.threads)?;
    let film = Film::new(camera.film())?;
    let region = film.region();
    let start = Instant::now();
    let crew = TimedCrew { threads: &threads, nanoseconds: AtomicU64::new(0) };
    let stage = Stage {
        scene,
        camera,
        film: region,
        kernel,
        needs: scene.needs(),
        samples: samples(&film, settings.budget.samples().unwrap_or(UNKNOWN_BUDGET)),
        seed: settings.seed,
        arrival: None,
    };
    let observes = settings.observes_lights && integrator.chooses_lights();
    let arrivals = observes.then(|| Arrivals::observe(stage, &crew)).flatten();
    let stage = Stage { arrival: arrivals.as_ref().map(|a| &a.arrival), ..stage };
    let observed = arrivals.as_ref().map_or_else(Counters::default, |a| a.counters);
    let mut run = integrator.start(stage, &crew)?;
    let preparation = start.elapsed();
    let job = Job { source, kernel, region, threads: &threads };
    let mut totals = Totals { film, counters: Counters::default(), thread_time: Duration::ZERO };
    let mut watch = settings.target_error.map(Watch::new);
    let (mut wall, mut paused) = (Duration::ZERO, Duration::ZERO);
    let (mut passes, mut stopped) = (0, false);
    let most = settings.budget.samples().unwrap_or(u32::MAX);
    job.render(&mut *run, most, &mut totals, &crew, |pass, run, totals| {
        let since = start.elapsed();
        (passes, wall) = (pass, since - paused);
        let (film, counters) =
            (&totals.film, &with_preparation(totals.counters, [observed, run.preparation()]));
        let mut fraction = settings.budget.fraction(passes, wall);
        if let Some(watch) = &mut watch {
            watch.look(passes, || film.image(samples(film, passes)));
            fraction = watch.fraction(passes).max(fraction);
        }
        stopped = progress(&Progress { passes, fraction, wall, film, counters }).is_break();
        let is_reached = watch.as_ref().is_some_and(|watch| watch.fraction(passes) >= 1.0);
        let is_enough =
            stopped || is_reached || settings.budget.is_spent(passes, wall, preparation);
        paused += start.elapsed() - since;
        if is_enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let Totals { film, counters, thread_time } = totals;
    Ok(Rendering {
        image: film.image(samples(&film, passes)),
        film,
        samples_per_pixel: passes,
        counters: with_preparation(counters, [observed, run.preparation()]),
        wall,
        preparation,
        thread_time: thread_time + crew.time(),
        techniques: run.techniques(),
        notes: run.notes(),
        integrator: integrator.name(),
        filter: settings.filter,
        sampling: None,
        estimated_error: watch.and_then(|watch| watch.error(passes)),
        stopped,
    })
}

/// Counts of samples and of what was done beside them, whose rays are rays but whose samples are
/// none of the image's.
fn with_preparation(mut counters: Counters, preparations: [Counters; 2]) -> Counters {
    for preparation in preparations {
        counters += Counters { samples: 0, ..preparation };
    }
    counters
}

/// The threads, with the time that they spend on what is no sample.
struct TimedCrew<'t> {
    threads: &'t Threads,
    nanoseconds: AtomicU64,
}

impl TimedCrew<'_> {
    fn time(&self) -> Duration {
        Duration::from_nanos(self.nanoseconds.load(Ordering::Relaxed))
    }
}

impl Crew for TimedCrew<'_> {
    fn each(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        self.threads.each(count, &|i| {
            let start = Instant::now();
            task(i);
            self.nanoseconds.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        });
    }
}

/// Samples per pixel that are expected of a budget of time.
const UNKNOWN_BUDGET: u32 = 64;

/// Samples over the whole window after a number of passes.
fn samples(film: &Film, passes: u32) -> u64 {
    u64::from(film.region().pixels()) * u64::from(passes)
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

    fn blind_spots(
        &self,
        scene: &S,
        camera: &dyn Camera,
    ) -> Result<Vec<MissingPaths>, RenderError> {
        (Compiled::NEAREST.blind_spots)(scene, camera, self)
    }
}
