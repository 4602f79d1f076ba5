//! The pyramid of techniques (Veach 1997, figure 10.3): the contributions of each technique,
//! unweighted and weighted, and its share of energy and variance; for those of bidirectional path
//! tracing also its share of the cost, and the efficiency of the rest without it.
//!
//! Variances are per sample of one pixel, mean over pixels, of luminance. Without technique j the
//! others' weights are evaluated anew on the same paths (the sweep without j), so the second
//! moments of the reduced set are exact for the samples at hand. Two things are approximated:
//! contributions through the lens (t = 1) are taken as independent of what the sample's camera
//! subpath contributes to the same pixel; and the cost is the number of rays, measured by running
//! the reduced set on a part of the pixels.

use super::observer::{Observer, for_each_sample, observe};
use crate::endpoint::Camera;
use crate::film::{Contribution, FilmRegion, Image, Sample, Technique};
use crate::integrator::{Bidirectional, Integrator, Stage};
use crate::math::Rgb;
use crate::path::{PathDensities, Scratch, TechniqueSet, Weighting};
use crate::render::{Budget, RenderError, Settings, start_alone};
use crate::report::result::{Layer, Pyramid, TechniqueShare};
use crate::report::stats::ratio;
use crate::scene::Scene;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Techniques of longer paths than this many scattering events are drawn but not told apart.
const MOST_BOUNCES: u16 = 4;
/// Samples from one question of whether to go on to the next.
const ASK_EVERY: u32 = 1024;

/// Sums that make the variance of a pixel's sample: own contributions per pixel, and splats.
struct Variance {
    own: f64,
    /// Σ x and Σ x² of own contributions, per pixel.
    sums: Vec<[f64; 2]>,
    splats: f64,
}

impl Variance {
    fn new(pixels: usize) -> Self {
        Self { own: 0.0, sums: vec![[0.0; 2]; pixels], splats: 0.0 }
    }

    fn add(&mut self, x: f64, is_own: bool) {
        if is_own { self.own += x } else { self.splats += x * x }
    }

    fn end_sample(&mut self, pixel: u32) {
        let sums = &mut self.sums[pixel as usize];
        *sums = [sums[0] + self.own, sums[1] + self.own * self.own];
        self.own = 0.0;
    }

    /// Mean over pixels of the variance of one sample.
    fn value(&self, passes: u32) -> f64 {
        let n = f64::from(passes);
        let own =
            self.sums.iter().map(|[x, xx]| ((xx - x * x / n) / (n - 1.0)).max(0.0)).sum::<f64>();
        (own + self.splats / n) / self.sums.len().max(1) as f64
    }
}

/// Sums over the contributions of one technique.
struct Sums {
    unweighted: Image,
    weighted: Image,
    variance: Variance,
}

/// Sums over the contributions of an integrator, technique by technique.
struct Layers {
    region: FilmRegion,
    sums: BTreeMap<Technique, Sums>,
    whole: Variance,
}

impl Layers {
    /// Sums for these techniques; others get theirs when they contribute.
    fn new(region: FilmRegion, techniques: impl Iterator<Item = Technique>) -> Self {
        let whole = Variance::new(region.pixels() as usize);
        let mut layers = Self { region, sums: BTreeMap::new(), whole };
        for technique in techniques {
            layers.of(technique);
        }
        layers
    }

    /// The sums of a technique, if it is told apart.
    fn of(&mut self, technique: Technique) -> Option<&mut Sums> {
        let size = self.region.window_size();
        let black = || Image::from_fn(size.x, size.y, |_, _| Rgb::BLACK);
        let variance = || Variance::new(self.region.pixels() as usize);
        let new = || Sums { unweighted: black(), weighted: black(), variance: variance() };
        let is_told_apart = technique.bounces() <= MOST_BOUNCES;
        is_told_apart.then(|| self.sums.entry(technique).or_insert_with(new))
    }

    /// Sum of a technique's weighted luminance, mean over pixels.
    fn mean(&self, technique: Technique) -> f64 {
        self.sums.get(&technique).map_or(0.0, |sums| sums.weighted.mean().luminance())
    }

    /// Takes a contribution; the weighted luminance that it adds to a pixel, if it does.
    fn add(&mut self, contribution: &Contribution) -> Option<f64> {
        let Contribution { raster, value, weight, technique } = *contribution;
        let pixel = self.region.pixel_index(raster)? as usize;
        let luminance = value.luminance() * weight;
        if !luminance.is_finite() {
            return None;
        }
        let is_own = technique.t > 1;
        self.whole.add(luminance, is_own);
        if let Some(sums) = self.of(technique) {
            sums.unweighted.pixels_mut()[pixel] += value;
            sums.weighted.pixels_mut()[pixel] += value * weight;
            sums.variance.add(luminance, is_own);
        }
        Some(luminance)
    }

    fn end_sample(&mut self, pixel: u32) {
        self.whole.end_sample(pixel);
        self.sums.values_mut().for_each(|sums| sums.variance.end_sample(pixel));
    }

    /// The pyramid; `without` tells a technique's share of the cost, and the efficiency without it.
    fn finish(self, passes: u32, rays: f64, without: impl Fn(Technique) -> [f64; 2]) -> Pyramid {
        let variance = self.whole.value(passes);
        let energy: f64 = self.sums.keys().map(|technique| self.mean(*technique)).sum();
        let layer = |(technique, mut sums): (Technique, Sums)| {
            let mean = sums.weighted.mean().luminance();
            let [cost, efficiency_without] = without(technique);
            [&mut sums.unweighted, &mut sums.weighted]
                .into_iter()
                .flat_map(Image::pixels_mut)
                .for_each(|p| *p *= 1.0 / f64::from(passes));
            let share = TechniqueShare {
                s: technique.s,
                t: technique.t,
                merged: technique.merged,
                energy: ratio(mean, energy),
                variance: ratio(sums.variance.value(passes), variance),
                cost,
                efficiency_without,
            };
            let Sums { unweighted, weighted, .. } = sums;
            Layer { technique, unweighted, weighted, share }
        };
        let mut layers: Vec<Layer> = self.sums.into_iter().map(layer).collect();
        layers.sort_by_key(|Layer { technique: t, .. }| (t.merged, t.bounces(), t.s));
        Pyramid { layers, passes, variance, rays }
    }
}

/// Measures the techniques of any integrator on a scene, merging ones among them, by its
/// contributions alone: what each costs, and the efficiency without it, are NaN. With a budget of at
/// least two samples per pixel; `None` if `ask` stops it.
///
/// # Errors
/// If the filter is invalid, or the integrator cannot render the scene.
pub fn measure_techniques<S: Scene + ?Sized, I: Integrator<S>>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &I,
    settings: &Settings,
    ask: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Option<Pyramid>, RenderError> {
    let layers = Layers::new(camera.film(), std::iter::empty());
    let mut watched = Watched { layers, ask };
    let drawn = observe(integrator, scene, camera, &enough(settings), &mut watched)?;
    let Some((passes, rays)) = drawn else { return Ok(None) };
    if passes < 2 {
        return measure_techniques(scene, camera, integrator, &two_samples(settings), ask);
    }
    Ok(Some(watched.layers.finish(passes, rays, |_| [f64::NAN; 2])))
}

/// Layers under way, which may be stopped.
struct Watched<'a> {
    layers: Layers,
    ask: &'a mut dyn FnMut() -> ControlFlow<()>,
}

impl Observer for Watched<'_> {
    fn add(&mut self, contribution: &Contribution) {
        self.layers.add(contribution);
    }

    fn end_sample(&mut self, pixel: u32) -> ControlFlow<()> {
        self.layers.end_sample(pixel);
        if pixel.is_multiple_of(ASK_EVERY) { (self.ask)() } else { ControlFlow::Continue(()) }
    }
}

/// One sample has no variance.
fn two_samples(settings: &Settings) -> Settings {
    Settings { budget: Budget::Samples(2), ..*settings }
}

/// The settings, with two samples per pixel at least. A budget of time may still end after one.
fn enough(settings: &Settings) -> Settings {
    match settings.budget {
        Budget::Samples(0 | 1) => two_samples(settings),
        _ => *settings,
    }
}

/// The other techniques without one.
struct Rest {
    set: TechniqueSet,
    weighting: Weighting,
    variance: Variance,
    /// True if they could draw every path that it drew.
    is_complete: bool,
}

/// Measures the techniques of bidirectional path tracing on a scene; with a budget of at least two
/// samples per pixel. `None` if `ask` stops it.
///
/// # Errors
/// If the filter is invalid.
pub fn measure_pyramid<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &Bidirectional,
    settings: &Settings,
    ask: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Option<Pyramid>, RenderError> {
    let region = camera.film();
    let set = integrator.techniques.pruned(&scene.needs());
    let most = integrator.depth.limit().min(u32::from(MOST_BOUNCES)) as u16;
    let techniques = || Technique::up_to(most).filter(|technique| set.contains(*technique));
    let mut layers = Layers::new(region, techniques());
    let rest = |technique| {
        let excluded = set.excluded.with(technique).unwrap_or(set.excluded);
        let (set, variance) =
            (TechniqueSet { excluded, ..set }, Variance::new(region.pixels() as usize));
        let weighting = Weighting::new(set, integrator.heuristic);
        Rest { set, weighting, variance, is_complete: true }
    };
    let mut rests: BTreeMap<_, _> = techniques().map(|t| (t, rest(t))).collect();
    let stage = Stage::new(scene, camera);
    let mut scratch = Scratch::default();
    let settings = enough(settings);
    let passes = for_each_sample(region, &settings, |pixel, _, film, sampler| {
        if pixel.is_multiple_of(ASK_EVERY) && ask().is_break() {
            return Ok(ControlFlow::Break(()));
        }
        let sample = Sample { film, sampler };
        integrator.for_each_path(stage, sample, &mut scratch, |path, contribution| {
            let Some(luminance) = layers.add(contribution) else { return };
            let Contribution { value, weight, technique, .. } = *contribution;
            for (without, rest) in &mut rests {
                if *without == technique {
                    rest.is_complete &=
                        weight < 1.0 || has_competitor(&path.densities(), &rest.set, technique);
                    continue;
                }
                let luminance = if without.bounces() == technique.bounces() {
                    value.luminance() * path.weight(&rest.weighting)
                } else {
                    luminance
                };
                rest.variance.add(luminance, technique.t > 1);
            }
        });
        layers.end_sample(pixel);
        rests.values_mut().for_each(|rest| rest.variance.end_sample(pixel));
        Ok(ControlFlow::Continue(()))
    })?;
    let Some(passes) = passes else { return Ok(None) };
    if passes < 2 {
        return measure_pyramid(scene, camera, integrator, &two_samples(&settings), ask);
    }
    let rays = |set: TechniqueSet| {
        count_rays(scene, camera, &Bidirectional { techniques: set, ..*integrator }, &settings)
    };
    let (variance, all) = (layers.whole.value(passes), rays(set)?);
    let mut without = BTreeMap::new();
    for (technique, rest) in rests {
        let fewer = rays(rest.set)?;
        let cost = if all > 0.0 { 1.0 - fewer / all } else { 0.0 };
        let is_idle = layers.mean(technique) == 0.0;
        let efficiency = if is_idle || rest.is_complete {
            variance * all / (rest.variance.value(passes) * fewer)
        } else {
            f64::NAN
        };
        without.insert(technique, [cost, efficiency]);
    }
    let without = |technique| without.get(&technique).copied().unwrap_or([f64::NAN; 2]);
    Ok(Some(layers.finish(passes, all, without)))
}

/// True if another technique of the set can draw the path.
fn has_competitor(path: &impl PathDensities, set: &TechniqueSet, technique: Technique) -> bool {
    let mut found = false;
    path.sweep(technique, 0.0, |other, ratio| found |= ratio > 0.0 && set.contains(other));
    found
}

/// Rays per sample, from one sample in a part of the pixels.
fn count_rays<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &Bidirectional,
    settings: &Settings,
) -> Result<f64, RenderError> {
    const PIXELS: u32 = 4096;
    let region = camera.film();
    let step = (region.pixels() / PIXELS).max(1);
    let settings = Settings { budget: Budget::Samples(1), ..*settings };
    let mut run = start_alone(integrator, Stage::new(scene, camera))?;
    let mut nowhere = |_: usize, _: &Contribution| {};
    for_each_sample(region, &settings, |pixel, _, film, sampler| {
        if pixel.is_multiple_of(step) {
            run.draw(film, sampler, &mut nowhere);
        }
        Ok(ControlFlow::Continue(()))
    })?;
    Ok(run.rays_per_sample())
}
