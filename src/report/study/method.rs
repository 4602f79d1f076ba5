//! Entries of a study: named integrators, and a look at their single contributions.

use super::pyramid::measure_techniques;
use crate::endpoint::Camera;
use crate::film::{Contribution, FilmRegion, FilmSample, Image, Sample};
use crate::integrator::{Caller, Integrator, Run, Stage};
use crate::path::Scratch;
use crate::render::{Budget, Render, RenderError, Settings};
use crate::report::result::Pyramid;
use crate::report::stats::{Largest, Layout, RELATIVE_EPSILON, Tail};
use crate::sampler::{AnySource, SampleSource};
use crate::scene::Scene;
use std::fmt;
use std::ops::ControlFlow;
use std::time::Instant;

/// An integrator with a name of its own.
pub struct Contestant<'a, S: Scene + ?Sized> {
    /// The name in tables and plots.
    pub name: String,
    /// The integrator.
    pub method: &'a dyn Method<S>,
    /// True if it can draw every path of the scene. If not, its image is too dark somewhere and is
    /// not tested for bias.
    pub complete: bool,
    /// True if its techniques are to be shown one by one. Default: no.
    pub pyramid: bool,
}

impl<'a, S: Scene + ?Sized> Contestant<'a, S> {
    /// An entry of a study.
    pub fn new(name: impl Into<String>, method: &'a dyn Method<S>, complete: bool) -> Self {
        Self { name: name.into(), method, complete, pyramid: false }
    }
}

impl<S: Scene + ?Sized> fmt::Debug for Contestant<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Contestant")
            .field("name", &self.name)
            .field("complete", &self.complete)
            .field("pyramid", &self.pyramid)
            .finish_non_exhaustive()
    }
}

/// A renderer that a study can measure: [`Render`], and looks at single contributions. Every
/// [`Integrator`] is one; a renderer that is none implements this with the default looks, which see
/// nothing.
pub trait Method<S: Scene + ?Sized>: Render<S> {
    /// Draws samples in the calling thread and looks at each contribution. The reference tells what
    /// is bright for a pixel: a lamp that is seen directly is no tail.
    ///
    /// # Errors
    /// If the filter is invalid, or the integrator cannot render the scene.
    fn probe(
        &self,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        reference: &Image,
    ) -> Result<Probe, RenderError> {
        let _ = (scene, camera, settings, reference);
        Ok(Probe::default())
    }

    /// Its techniques one by one: [`measure_techniques`]. `None` if `ask` stops it, or by default.
    ///
    /// # Errors
    /// As [`measure_techniques`].
    fn pyramid(
        &self,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        ask: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Option<Pyramid>, RenderError> {
        let _ = (scene, camera, settings, ask);
        Ok(None)
    }
}

impl<S: Scene + ?Sized, I: Integrator<S>> Method<S> for I {
    fn probe(
        &self,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        reference: &Image,
    ) -> Result<Probe, RenderError> {
        let mut sink = ProbeSink::new(camera.film(), reference);
        let drawn = observe(self, scene, camera, settings, &mut sink)?;
        Ok(sink.finish(drawn.map_or(0, |(passes, _)| passes)))
    }

    fn pyramid(
        &self,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        ask: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Option<Pyramid>, RenderError> {
        measure_techniques(scene, camera, self, settings, ask)
    }
}

/// Statistics of single contributions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Probe {
    /// Samples per pixel.
    pub passes: u32,
    /// Tail of the luminance that samples give to a pixel: contributions to a sample's own pixel
    /// together, those through the lens one by one. Each is relative to its pixel or its block of
    /// pixels in the reference, whichever is brighter (plus 1 % of the mean). `None` if there were
    /// too few.
    pub tail: Option<Tail>,
    /// Mean luminance of the image by number of scattering events; the last entry has all longer
    /// paths.
    pub energy_by_bounces: Vec<f64>,
}

/// Numbers of scattering events that are told apart.
const BOUNCES: usize = 8;
/// The number of the largest values that are kept.
const LARGEST: usize = 8192;

struct ProbeSink {
    region: FilmRegion,
    /// One over the luminance that is usual for a pixel.
    scales: Vec<f64>,
    largest: Largest,
    /// The sample's contributions to its own pixel so far, scaled.
    own: f64,
    energy: [f64; BOUNCES + 1],
}

impl ProbeSink {
    fn new(region: FilmRegion, reference: &Image) -> Self {
        let floor = RELATIVE_EPSILON * reference.mean().luminance();
        let layout = Layout::of(reference);
        let blocks = layout.block_means(reference);
        // A pixel of a rendered reference may be dark by chance: then what surrounds it tells what
        // is usual there.
        let usual = |pixel: usize| {
            reference.pixels()[pixel].luminance().max(blocks[layout.block_of(pixel)]).max(0.0)
        };
        let scales =
            (0..reference.pixels().len()).map(|pixel| 1.0 / (usual(pixel) + floor)).collect();
        Self {
            region,
            scales,
            largest: Largest::new(LARGEST),
            own: 0.0,
            energy: [0.0; BOUNCES + 1],
        }
    }

    fn finish(self, passes: u32) -> Probe {
        let samples = f64::from(passes) * f64::from(self.region.pixels().max(1));
        let energy_by_bounces = self.energy.iter().map(|e| e / samples.max(1.0)).collect();
        Probe { passes, tail: self.largest.tail(), energy_by_bounces }
    }
}

impl Observer for ProbeSink {
    fn add(&mut self, contribution: &Contribution) {
        let luminance = contribution.value.luminance() * contribution.weight;
        let Some(pixel) =
            self.region.pixel_index(contribution.raster).filter(|_| luminance.is_finite())
        else {
            return;
        };
        let bounces = usize::from(contribution.technique.bounces());
        self.energy[bounces.min(BOUNCES)] += luminance;
        let Some(scale) = self.scales.get(pixel as usize) else { return };
        // Contributions through the lens fall on pixels of their own.
        if contribution.technique.t > 1 {
            self.own += luminance * scale
        } else {
            self.largest.push(luminance * scale)
        }
    }

    fn end_sample(&mut self, _: u32) -> ControlFlow<()> {
        self.largest.push(std::mem::take(&mut self.own));
        ControlFlow::Continue(())
    }
}

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
    // One that learns does so from the whole window at once.
    let mut chunk = <I::Run<'_> as Run<'_, S>>::Chunk::default();
    let passes = for_each_sample(region, settings, |pixel, pass, film, sampler| {
        let mut sink = |_: usize, contribution: &Contribution| observer.add(contribution);
        if run.learns() {
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
    let rays = run.preparation().rays() + scratch.counters.rays();
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
