//! Looks at the samples of an integrator, one by one, in the calling thread.

use crate::endpoint::Camera;
use crate::film::{Contribution, FilmRegion, FilmSample, Sample};
use crate::integrator::{Caller, Integrator, Run, Stage};
use crate::path::Scratch;
use crate::render::{Budget, RenderError, Settings};
use crate::sampler::{AnySource, SampleSource};
use crate::scene::Scene;
use std::ops::ControlFlow;
use std::time::Instant;

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
    observer: &mut impl Observer,
) -> Result<Option<(u32, f64)>, RenderError> {
    let region = camera.film();
    let samples = u64::from(region.pixels()) * u64::from(settings.budget.samples().unwrap_or(1));
    let kernel = settings.filter.kernel()?;
    let stage = Stage { samples, seed: settings.seed, kernel, ..Stage::new(scene, camera) };
    let mut scratch = Scratch::default();
    let mut run = integrator.start(stage, &Caller)?;
    // One that prepares passes does so for the whole window at once.
    let mut chunk = <I::Run<'_> as Run<'_, S>>::Chunk::default();
    let passes = for_each_sample(region, settings, |pixel, pass, film, sampler| {
        let mut sink = |_: usize, contribution: &Contribution| observer.add(contribution);
        if run.prepares() {
            if pixel == 0 {
                if pass > 0 {
                    run.collect(&mut chunk);
                }
                run.begin_pass(pass, &Caller)?;
            }
            run.draw(&mut [Sample { film, sampler }], &mut sink, &mut chunk, &mut scratch);
        } else {
            run.sample(film, sampler, &mut sink, &mut scratch);
        }
        Ok(observer.end_sample(pixel))
    })?;
    let rays = run.take_preparation().rays() + scratch.counters.rays();
    let rays = rays as f64 / scratch.counters.samples.max(1) as f64;
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
    P: FnMut(
        u32,
        u32,
        FilmSample,
        &mut <AnySource as SampleSource>::Sampler,
    ) -> Result<ControlFlow<()>, RenderError>,
{
    let kernel = settings.filter.kernel()?;
    let strata = if let Budget::Samples(n) = settings.budget { n } else { 64 };
    let source = settings.sampler.source(settings.seed, strata);
    let start = Instant::now();
    for pass in 0.. {
        for pixel in 0..region.pixels() {
            let mut sampler = source.sampler(pixel, pass);
            let film = FilmSample::draw(&region, pixel, &kernel, &mut sampler);
            if visit(pixel, pass, film, &mut sampler)?.is_break() {
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
