//! The code that renders a scene with an integrator: for a [`World`] and the built-in integrators it
//! was compiled with this crate, for all others it is compiled where it is asked for.
//!
//! The choice is a constant, so that what is not taken is not compiled: a host that renders
//! worlds need not compile an integrator.

#[cfg(feature = "report")]
use super::alone::{Alone, alone};
use super::{Checkpoint, Progress, RenderError, Rendering, Settings, drive};
use crate::endpoint::Camera;
use crate::integrator::{AnyIntegrator, BoxedRun, Caller, Crew, Integrator, Stage, Started};
use crate::path::MissingPaths;
use crate::sampler::AnySampler;
use crate::scene::{Scene, World};
use std::fmt;
use std::marker::PhantomData;
use std::ops::ControlFlow;

/// The questions to an integrator and a scene, as functions.
pub(super) struct Compiled<S: Scene + ?Sized, I> {
    pub render: Render<S, I>,
    pub blind_spots: BlindSpots<S, I>,
    #[cfg(feature = "report")]
    pub start_alone: StartAlone<S, I>,
}

type BlindSpots<S, I> = fn(&S, &dyn Camera, &I) -> Result<Vec<MissingPaths>, RenderError>;

#[cfg(feature = "report")]
type StartAlone<S, I> = for<'a> fn(&'a I, Stage<'a, S>) -> Started<Box<dyn Alone + 'a>>;

type Render<S, I> = fn(
    (&S, &dyn Camera, &I),
    &Settings,
    Option<Checkpoint>,
    &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError>;

impl<S: Scene + ?Sized, I: Integrator<S>> Compiled<S, I> {
    /// With this crate, if it was.
    pub const NEAREST: Self = match (S::AS_WORLD, I::ON_WORLD) {
        (Some(_), Some(_)) => Self {
            render: |(scene, camera, integrator), settings, from, progress| {
                let integrator = &OnWorld(integrator, PhantomData::<fn(&S)>);
                render_world((as_world(scene), camera, integrator), settings, from, progress)
            },
            blind_spots: |scene, camera, integrator| {
                let integrator = &OnWorld(integrator, PhantomData::<fn(&S)>);
                blind_spots_in_world(as_world(scene), camera, integrator)
            },
            #[cfg(feature = "report")]
            start_alone: start_alone_in_world,
        },
        _ => Self {
            render: |(scene, camera, integrator), settings, from, progress| {
                drive_ready_made((scene, camera, integrator), settings, from, progress)
            },
            blind_spots: |scene, camera, integrator| blind_spots(scene, camera, integrator),
            #[cfg(feature = "report")]
            start_alone: |integrator, stage| {
                Ok(alone(AnyIntegrator::start(integrator, stage, &Caller)?))
            },
        },
    };
}

/// A run that draws samples in the calling thread.
///
/// # Errors
/// If the settings do not fit the stage, or there is not enough memory.
#[cfg(feature = "report")]
pub fn start_alone<'a, S: Scene + ?Sized, I: Integrator<S>>(
    integrator: &'a I,
    stage: Stage<'a, S>,
) -> Started<Box<dyn Alone + 'a>> {
    (Compiled::NEAREST.start_alone)(integrator, stage)
}

fn as_world<S: Scene + ?Sized>(scene: &S) -> &World {
    let as_world = const { S::AS_WORLD.expect("asked for where it is") };
    as_world(scene)
}

/// An integrator as it was compiled with this crate.
struct OnWorld<'i, S: ?Sized, I>(&'i I, PhantomData<fn(&S)>);

impl<S: ?Sized, I: fmt::Debug> fmt::Debug for OnWorld<'_, S, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<S: Scene + ?Sized, I: Integrator<S>> AnyIntegrator<World, AnySampler> for OnWorld<'_, S, I> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn chooses_lights(&self) -> bool {
        self.0.chooses_lights()
    }

    fn start<'a>(
        &'a self,
        stage: Stage<'a, World>,
        crew: &dyn Crew,
    ) -> Started<BoxedRun<'a, World, AnySampler>> {
        let start = const { I::ON_WORLD.expect("asked for where it is") };
        start(self.0, stage, crew)
    }
}

#[inline(never)]
fn render_world(
    of: (&World, &dyn Camera, &dyn AnyIntegrator<World, AnySampler>),
    settings: &Settings,
    from: Option<Checkpoint>,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError> {
    drive_ready_made(of, settings, from, progress)
}

/// A rendering by objects with the settings' own source of random numbers.
fn drive_ready_made<S: Scene + ?Sized>(
    of: (&S, &dyn Camera, &dyn AnyIntegrator<S, AnySampler>),
    settings: &Settings,
    from: Option<Checkpoint>,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Rendering, RenderError> {
    drive((&settings.source(), Some(settings.sampler)), of, settings, from, progress)
}

#[inline(never)]
fn blind_spots_in_world(
    world: &World,
    camera: &dyn Camera,
    integrator: &dyn AnyIntegrator<World, AnySampler>,
) -> Result<Vec<MissingPaths>, RenderError> {
    blind_spots(world, camera, integrator)
}

fn blind_spots<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &dyn AnyIntegrator<S, AnySampler>,
) -> Result<Vec<MissingPaths>, RenderError> {
    let stage = Stage { samples: 0, ..Stage::new(scene, camera) };
    Ok(integrator.start(stage, &Caller)?.notes().missing)
}

#[cfg(feature = "report")]
fn start_alone_in_world<'a, S: Scene + ?Sized, I: Integrator<S>>(
    integrator: &'a I,
    stage: Stage<'a, S>,
) -> Started<Box<dyn Alone + 'a>> {
    let start = const { I::ON_WORLD.expect("asked for where it is") };
    let Stage { scene, camera, film, kernel, needs, samples, seed, arrival } = stage;
    let scene = as_world(scene);
    let stage = Stage { scene, camera, film, kernel, needs, samples, seed, arrival };
    Ok(alone_in_world(start(integrator, stage, &Caller)?))
}

#[cfg(feature = "report")]
#[inline(never)]
fn alone_in_world<'a>(run: BoxedRun<'a, World, AnySampler>) -> Box<dyn Alone + 'a> {
    alone(run)
}
