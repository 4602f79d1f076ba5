//! Entries of a study: named integrators, and a look at their single contributions.

use super::observer::{Observer, observe};
use super::pyramid::measure_techniques;
use crate::endpoint::Camera;
use crate::film::{Contribution, FilmRegion, Image};
use crate::integrator::Integrator;
use crate::render::{Render, RenderError, Settings};
use crate::report::result::Pyramid;
use crate::report::stats::{Largest, Layout, RELATIVE_EPSILON, Tail};
use crate::scene::Scene;
use std::fmt;
use std::ops::ControlFlow;

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
