//! Entries of a study: named integrators, and a look at their single contributions.

use crate::endpoint::Camera;
use crate::film::{Contribution, FilmRegion, FilmSample, Image, Sink};
use crate::integrator::{Caller, Integrator, Run, Stage};
use crate::path::Scratch;
use crate::render::{Budget, Render, RenderError, Settings};
use crate::report::stats::{Largest, Layout, RELATIVE_EPSILON, Tail};
use crate::sampler::SampleSource;
use crate::scene::Scene;
use std::fmt;
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
}

impl<'a, S: Scene + ?Sized> Contestant<'a, S> {
    /// An entry of a study.
    pub fn new(name: impl Into<String>, method: &'a dyn Method<S>, complete: bool) -> Self {
        Self { name: name.into(), method, complete }
    }
}

impl<S: Scene + ?Sized> fmt::Debug for Contestant<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Contestant")
            .field("name", &self.name)
            .field("complete", &self.complete)
            .finish_non_exhaustive()
    }
}

/// A renderer that a study can measure: [`Render`], and a probe of single contributions. Every
/// [`Integrator`] is one; a renderer that is none implements this with the default probe, which
/// sees nothing.
pub trait Method<S: Scene + ?Sized>: Render<S> {
    /// Draws samples in the calling thread and looks at each contribution. The reference tells what
    /// is bright for a pixel: a lamp that is seen directly is no tail.
    ///
    /// # Errors
    /// If the filter is invalid.
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
}

impl<S: Scene + ?Sized, I: Integrator<S>> Method<S> for I {
    fn probe(
        &self,
        scene: &S,
        camera: &dyn Camera,
        settings: &Settings,
        reference: &Image,
    ) -> Result<Probe, RenderError> {
        let region = camera.film();
        let mut sink = ProbeSink::new(region, reference);
        let mut scratch = Scratch::default();
        let samples =
            u64::from(region.pixels()) * u64::from(settings.budget.samples().unwrap_or(1));
        let kernel = settings.filter.kernel()?;
        let stage = Stage { samples, seed: settings.seed, kernel, ..Stage::new(scene, camera) };
        let run = self.start(stage, &Caller)?;
        let passes = for_each_sample(region, settings, |_, _, film, sampler| {
            run.sample(film, sampler, &mut sink, &mut scratch);
            sink.end_sample();
        })?;
        Ok(sink.finish(passes))
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

    fn end_sample(&mut self) {
        self.largest.push(std::mem::take(&mut self.own));
    }

    fn finish(self, passes: u32) -> Probe {
        let samples = f64::from(passes) * f64::from(self.region.pixels().max(1));
        let energy_by_bounces = self.energy.iter().map(|e| e / samples.max(1.0)).collect();
        Probe { passes, tail: self.largest.tail(), energy_by_bounces }
    }
}

impl Sink for ProbeSink {
    fn add(&mut self, _sample: usize, contribution: &Contribution) {
        let luminance = contribution.value.luminance() * contribution.weight;
        let Some(pixel) =
            self.region.pixel_index(contribution.raster).filter(|_| luminance.is_finite())
        else {
            return;
        };
        let bounces = usize::from(contribution.technique.s) + usize::from(contribution.technique.t);
        self.energy[bounces.saturating_sub(2).min(BOUNCES)] += luminance;
        let Some(scale) = self.scales.get(pixel as usize) else { return };
        // Contributions through the lens fall on pixels of their own.
        if contribution.technique.t > 1 {
            self.own += luminance * scale
        } else {
            self.largest.push(luminance * scale)
        }
    }
}

/// Draws the samples that a rendering with these settings draws, in the calling thread and with the
/// pixel's number and the pass; returns the number of passes.
pub(super) fn for_each_sample<P>(
    region: FilmRegion,
    settings: &Settings,
    mut visit: P,
) -> Result<u32, RenderError>
where
    P: FnMut(u32, u32, FilmSample, &mut <crate::sampler::AnySource as SampleSource>::Sampler),
{
    let kernel = settings.filter.kernel()?;
    let strata = if let Budget::Samples(n) = settings.budget { n } else { 64 };
    let source = settings.sampler.source(settings.seed, strata);
    let start = Instant::now();
    for pass in 0.. {
        for pixel in 0..region.pixels() {
            let mut sampler = source.sampler(pixel, pass);
            let film = FilmSample::draw(&region, pixel, &kernel, &mut sampler);
            visit(pixel, pass, film, &mut sampler);
        }
        let spent = match settings.budget {
            Budget::Samples(samples) => pass + 1 >= samples,
            Budget::Time(limit) => start.elapsed() >= limit,
        };
        if spent {
            return Ok(pass + 1);
        }
    }
    Ok(0)
}
