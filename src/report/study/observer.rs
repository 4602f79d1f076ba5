//! Looks at the samples of an integrator, one by one, in the calling thread.

use crate::endpoint::Camera;
use crate::film::{Contribution, FilmRegion, FilmSample};
use crate::integrator::{Integrator, Stage};
use crate::render::{Alone, Budget, RenderError, Settings, start_alone};
use crate::sampler::{AnySampler, SampleSource};
use crate::scene::Scene;
use std::ops::ControlFlow;
use web_time::Instant;

/// A look at the samples of an integrator, one by one.
pub(super) trait Observer {
    /// Takes a contribution.
    fn add(&mut self, contribution: &Contribution);

    /// Ends a sample that was drawn for this pixel; says whether another one follows.
    fn end_sample(&mut self, pixel: u32) -> ControlFlow<()>;
}

/// Draws samples in the calling thread; returns the number of passes and rays per sample, or `None`
/// if the observer breaks off.
pub(super) fn observe<S: Scene + ?Sized, I: Integrator<S>>(
    integrator: &I,
    scene: &S,
    camera: &dyn Camera,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Option<(u32, f64)>, RenderError> {
    let region = camera.film();
    let samples = u64::from(region.pixels()) * u64::from(settings.budget.samples().unwrap_or(1));
    let kernel = settings.filter.kernel()?;
    let stage = Stage { samples, seed: settings.seed, kernel, ..Stage::new(scene, camera) };
    observe_run(&mut *start_alone(integrator, stage)?, region, settings, observer)
}

fn observe_run(
    run: &mut dyn Alone,
    region: FilmRegion,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Option<(u32, f64)>, RenderError> {
    let passes = for_each_sample(region, settings, |pixel, pass, film, sampler| {
        // A pass is prepared for the whole window at once.
        if pixel == 0 {
            run.begin_pass(pass)?;
        }
        let mut sink = |_: usize, contribution: &Contribution| observer.add(contribution);
        run.draw(film, sampler, &mut sink);
        Ok(observer.end_sample(pixel))
    })?;
    let rays = run.rays_per_sample();
    Ok(passes.map(|passes| (passes, rays)))
}

/// Visits the samples that a rendering with these settings draws, in the calling thread and with
/// the pixel's number and the pass; returns the number of passes, or `None` if a visit breaks off.
pub(super) fn for_each_sample<P>(
    region: FilmRegion,
    settings: &Settings,
    mut visit: P,
) -> Result<Option<u32>, RenderError>
where
    P: FnMut(u32, u32, FilmSample, AnySampler) -> Result<ControlFlow<()>, RenderError>,
{
    let kernel = settings.filter.kernel()?;
    let strata = if let Budget::Samples(n) = settings.budget { n } else { 64 };
    let source = settings.sampler.source(settings.seed, strata);
    let start = Instant::now();
    for pass in 0.. {
        for pixel in 0..region.pixels() {
            let mut sampler = source.sampler(pixel, pass);
            let film = FilmSample::draw(&region, pixel, &kernel, &mut sampler);
            if visit(pixel, pass, film, sampler)?.is_break() {
                return Ok(None);
            }
        }
        let spent = match settings.budget {
            Budget::Samples(samples) => pass + 1 >= samples,
            Budget::Time(limit) => start.elapsed() >= limit,
        };
        if spent {
            return Ok(Some(pass + 1));
        }
    }
    Ok(None)
}
