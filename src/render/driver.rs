//! The driver: a rendering from its start, or from a checkpoint, to its end.

use super::chunks::Job;
use super::identity::Identity;
use super::settings::Threads;
use super::shard::Shard;
use super::state::{State, samples};
use super::target::Watch;
use super::{Budget, Checkpoint, CheckpointError, Progress, RenderError, Rendering, Settings};
use crate::endpoint::Camera;
use crate::film::Film;
use crate::integrator::{AnyIntegrator, Arrivals, Crew, Stage};
use crate::path::Counters;
use crate::sampler::{SampleSource, SamplerKind};
use crate::scene::Scene;
use std::cell::OnceCell;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use web_time::Instant;

/// Samples per pixel that are expected of a budget of time.
const UNKNOWN_BUDGET: u32 = 64;

/// Renders the passes of a shard, or those that a checkpoint of it lacks. The sampler is known if it
/// is a ready-made one.
pub(super) fn drive<N: SampleSource, S: Scene + ?Sized>(
    (source, sampler): (&N, Option<SamplerKind>),
    (scene, camera, integrator): (&S, &dyn Camera, &dyn AnyIntegrator<S, N::Sampler>),
    settings: &Settings,
    from: Option<Checkpoint>,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError> {
    let (shard, passes) = (settings.shard, settings.check()?);
    let kernel = settings.filter.kernel()?;
    let threads = Threads::new(settings.threads)?;
    let identity = OnceCell::new();
    let identify =
        || identity.get_or_init(|| Identity::new(scene, camera, integrator, settings, sampler));
    let keep = |state: &State| Checkpoint::new(identify(), shard, state);
    let is_resumed = from.is_some();
    let mut state = match from {
        Some(checkpoint) => checkpoint.into_state(identify(), shard)?,
        None => {
            let watch = settings.target_error.map(Watch::new);
            State { watch, ..State::before(passes.start, Film::new(camera.film())?) }
        }
    };
    let region = state.film.region();
    let start = Instant::now();
    let crew = TimedCrew { threads: &threads, nanoseconds: AtomicU64::new(0) };
    let expected = settings.budget.samples().unwrap_or(UNKNOWN_BUDGET);
    let stage = Stage {
        scene,
        camera,
        film: region,
        kernel,
        needs: scene.needs(),
        samples: samples(&state.film, expected),
        seed: settings.seed,
        arrival: None,
    };
    let observes = settings.observes_lights && integrator.chooses_lights();
    let arrivals = observes.then(|| Arrivals::observe(stage, &crew)).flatten();
    let stage = Stage { arrival: arrivals.as_ref().map(|a| &a.arrival), ..stage };
    let mut run = integrator.start(stage, &crew)?;
    if run.learns() && shard != Shard::WHOLE {
        return Err(RenderError::ShardOfLearner { integrator: integrator.name(), shard });
    }
    let dependent_passes = run.notes().dependent_passes;
    state.watch = state.watch.take().map(|watch| watch.by_rows(dependent_passes));
    let mut prepared = arrivals.as_ref().map_or_else(Counters::default, |a| a.counters);
    prepared += run.take_preparation();
    // Samples of preparations are none of the image's.
    prepared.samples = 0;
    if is_resumed && prepared != state.prepared {
        return Err(CheckpointError::Prepared.into());
    }
    state.prepared = prepared;

    let before = state.times;
    state.times.preparation += start.elapsed();
    let budget = match settings.budget {
        Budget::Samples(_) => Budget::Samples(passes.len() as u32),
        time => time,
    };
    let is_enough = |state: &State| {
        let is_reached = |watch: &Watch| watch.fraction(state.samples_per_pixel()) >= 1.0;
        let (times, done) = (state.times, state.samples_per_pixel());
        state.watch.as_ref().is_some_and(is_reached)
            || done > 0 && budget.is_spent(done, times.wall, times.preparation)
    };
    let (mut paused, mut stopped) = (Duration::ZERO, false);
    let job = Job { source, kernel, region, threads: &threads };
    let after_pass = |state: &mut State| {
        let since = start.elapsed();
        state.times.wall = before.wall + (since - paused);
        let (passes, wall) = (state.samples_per_pixel(), state.times.wall);
        let mut fraction = budget.fraction(passes, wall);
        if let Some(mut watch) = state.watch.take() {
            watch.look(passes, || state.image());
            fraction = watch.fraction(passes).max(fraction);
            state.watch = Some(watch);
        }
        let (film, counters) = (&*state.film, &state.counters());
        let seen = Progress { passes, fraction, wall, film, counters, state, keep: &keep };
        stopped = progress(&seen).is_break();
        paused += start.elapsed() - since;
        if stopped || is_enough(state) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    if !is_enough(&state) {
        job.render(&mut *run, passes.end, &mut state, &crew, after_pass)?;
    }
    state.times.threads += crew.time();
    let passes = state.samples_per_pixel();
    Ok(Rendering {
        image: state.image(),
        film: state.film.clone(),
        samples_per_pixel: passes,
        counters: state.counters(),
        wall: state.times.wall,
        preparation: state.times.preparation,
        thread_time: state.times.threads,
        techniques: run.techniques(),
        notes: run.notes(),
        integrator: integrator.name(),
        filter: settings.filter,
        sampling: sampler.map(|sampler| (sampler, settings.seed)),
        estimated_error: state.watch.as_ref().and_then(|watch| watch.error(passes)),
        stopped,
        checkpoint: settings.keeps_checkpoint.then(|| keep(&state)),
    })
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
