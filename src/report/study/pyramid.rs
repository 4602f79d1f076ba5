//! The pyramid of techniques (Veach 1997, figure 10.3): the contributions of each technique (s, t),
//! unweighted and weighted, its share of energy, variance and cost, and the efficiency of the rest
//! without it.
//!
//! Variances are per sample of one pixel, mean over pixels, of luminance. Without technique j the
//! others' weights are evaluated anew on the same paths (the sweep without j), so the second
//! moments of the reduced set are exact for the samples at hand. Two things are approximated:
//! contributions through the lens (t = 1) are taken as independent of what the sample's camera
//! subpath contributes to the same pixel; and the cost is the number of rays, measured by running
//! the reduced set on a part of the pixels.

use super::method::for_each_sample;
use crate::endpoint::Camera;
use crate::film::{Contribution, Image, Sample, Technique};
use crate::integrator::{Bidirectional, Caller, Integrator, Run, Stage};
use crate::math::Rgb;
use crate::path::{PathDensities, Scratch, TechniqueSet, Weighting};
use crate::render::{Budget, RenderError, Settings};
use crate::report::result::{Layer, Pyramid, TechniqueShare};
use crate::scene::Scene;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Techniques of longer paths than this many scattering events are drawn but not told apart.
const MOST_BOUNCES: u16 = 4;

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

struct Work {
    unweighted: Image,
    weighted: Image,
    alone: Variance,
    without: Variance,
    /// True if another technique could draw every path that this one drew.
    replaceable: bool,
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
    let (size, pixels) = (region.window_size(), region.pixels() as usize);
    let set = integrator.techniques.pruned(&scene.needs());
    let most = integrator.depth.limit().min(u32::from(MOST_BOUNCES)) as u16;
    let black = || Image::from_fn(size.x, size.y, |_, _| Rgb::BLACK);
    let mut work = BTreeMap::new();
    for technique in Technique::up_to(most).filter(|t| set.contains(*t)) {
        let (alone, without) = (Variance::new(pixels), Variance::new(pixels));
        work.insert(
            technique,
            Work { unweighted: black(), weighted: black(), alone, without, replaceable: true },
        );
    }
    let without = |technique| {
        let excluded = set.excluded.with(technique).unwrap_or(set.excluded);
        TechniqueSet { excluded, ..set }
    };
    let reduced: Vec<(Technique, TechniqueSet)> = work.keys().map(|&t| (t, without(t))).collect();
    let stage = Stage::new(scene, camera);
    let mut whole = Variance::new(pixels);
    let mut scratch = Scratch::default();
    let mut stopped = false;
    let settings = match settings.budget {
        Budget::Samples(samples) => {
            Settings { budget: Budget::Samples(samples.max(2)), ..*settings }
        }
        Budget::Time(_) => *settings,
    };
    let mut passes = for_each_sample(region, &settings, |pixel, _, film, sampler| {
        if pixel % 1024 == 0 {
            stopped |= ask().is_break();
        }
        if stopped {
            return;
        }
        integrator.for_each_path(
            stage,
            Sample { film, sampler },
            &mut scratch,
            |path, contribution| {
                let Some(target) = region.pixel_index(contribution.raster) else { return };
                let (value, weight) = (contribution.value, contribution.weight);
                let luminance = value.luminance();
                if !(luminance * weight).is_finite() {
                    return;
                }
                let is_own = contribution.technique.t > 1;
                whole.add(luminance * weight, is_own);
                for (technique, reduced) in &reduced {
                    let Some(item) = work.get_mut(technique) else { continue };
                    if *technique == contribution.technique {
                        item.unweighted.pixels_mut()[target as usize] += value;
                        item.weighted.pixels_mut()[target as usize] += value * weight;
                        item.alone.add(luminance * weight, is_own);
                        item.replaceable &= weight < 1.0
                            || has_competitor(&path.densities(), reduced, contribution.technique);
                    } else {
                        let same_length = technique.s + technique.t
                            == contribution.technique.s + contribution.technique.t;
                        let weight = if same_length {
                            path.weight(&Weighting::new(*reduced, integrator.heuristic))
                        } else {
                            weight
                        };
                        item.without.add(luminance * weight, is_own);
                    }
                }
            },
        );
        whole.end_sample(pixel);
        for item in work.values_mut() {
            item.alone.end_sample(pixel);
            item.without.end_sample(pixel);
        }
    })?;
    if stopped {
        return Ok(None);
    }
    passes = passes.max(1);
    if passes < 2 {
        // A budget of time may end after one pass, which has no variance.
        let settings = Settings { budget: Budget::Samples(2), ..settings };
        return measure_pyramid(scene, camera, integrator, &settings, ask);
    }
    let rays = |set: TechniqueSet| {
        count_rays(scene, camera, &Bidirectional { techniques: set, ..*integrator }, &settings)
    };
    let all_rays = rays(set)?;
    let variance = whole.value(passes);
    let energy: f64 = work.values().map(|item| item.weighted.mean().luminance()).sum();
    let mut layers = Vec::new();
    for (technique, mut item) in work {
        let fewer = rays(without(technique))?;
        let without = item.without.value(passes);
        let mean = item.weighted.mean().luminance();
        let scale = 1.0 / f64::from(passes);
        [&mut item.unweighted, &mut item.weighted]
            .into_iter()
            .flat_map(Image::pixels_mut)
            .for_each(|p| *p *= scale);
        let is_idle = mean == 0.0;
        let efficiency = if is_idle || item.replaceable {
            variance * all_rays / (without * fewer)
        } else {
            f64::NAN
        };
        let share = TechniqueShare {
            s: technique.s,
            t: technique.t,
            energy: if energy > 0.0 { mean / energy } else { 0.0 },
            variance: if variance > 0.0 { item.alone.value(passes) / variance } else { 0.0 },
            cost: if all_rays > 0.0 { 1.0 - fewer / all_rays } else { 0.0 },
            efficiency_without: efficiency,
        };
        layers.push(Layer {
            technique,
            unweighted: item.unweighted,
            weighted: item.weighted,
            share,
        });
    }
    layers.sort_by_key(|layer| (layer.technique.s + layer.technique.t, layer.technique.s));
    Ok(Some(Pyramid { layers, passes, variance, rays: all_rays }))
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
    let mut scratch = Scratch::default();
    let settings = Settings { budget: Budget::Samples(1), ..*settings };
    let run = integrator.start(Stage::new(scene, camera), &Caller)?;
    let mut nowhere = |_: usize, _: &Contribution| {};
    for_each_sample(region, &settings, |pixel, _, film, sampler| {
        if pixel % step == 0 {
            run.sample(film, sampler, &mut nowhere, &mut scratch);
        }
    })?;
    Ok(scratch.counters.rays() as f64 / scratch.counters.samples.max(1) as f64)
}
