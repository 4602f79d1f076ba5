//! The pyramid of techniques (Veach 1997, figure 10.3), as it is drawn.

use crate::Fallible;
use crate::catalogue::merging;
use crate::lesson::Lesson;
use crate::race::{Effort, Report};
use glam::UVec2;
use pathspace::film::{Contribution, FilmSample, Image, Sample, Technique};
use pathspace::integrator::{
    AnyIntegrator, Bidirectional, Caller, Depth, Merging, Stage, VertexConnectionMerging,
};
use pathspace::math::Rgb;
use pathspace::path::{Excluded, Scratch, TechniqueSet};
use pathspace::render::Budget;
use pathspace::sampler::{AnySampler, SampleSource, SamplerKind};
use pathspace::scene::{Needs, Scene, World};
use serde::{Deserialize, Serialize};
use std::time::Duration;
use web_time::Instant;

/// Samples that are drawn at a time.
const BATCH: u32 = 256;
/// Time between two looks.
const PERIOD: Duration = Duration::from_millis(250);

/// A pyramid of techniques.
#[derive(Clone, Debug, Deserialize)]
pub struct TechniquesJob {
    /// The most scattering events of a path.
    pub bounces: u16,
    /// True if subpaths merge, too.
    #[serde(default)]
    pub merges: bool,
    /// The techniques that are switched off, as `s,t` or `merge s,t`.
    #[serde(default)]
    pub off: Vec<String>,
    /// True to multiply what a technique contributes by its weight.
    #[serde(default)]
    pub weighted: bool,
    /// The end, the seed and the radius.
    #[serde(flatten)]
    pub effort: Effort,
}

/// A technique's part of the image.
#[derive(Clone, Debug, Serialize)]
pub struct Layer {
    name: String,
    s: u16,
    t: u16,
    merged: bool,
    bounces: u16,
    /// True if it is not switched off.
    on: bool,
    /// Mean luminance of its weighted contributions, over pixels.
    mean: f64,
    /// The same as a part of that of all techniques.
    share: f64,
}

/// The state of a pyramid.
#[derive(Clone, Debug, Serialize)]
pub struct LayerReport {
    #[serde(flatten)]
    report: Report,
    techniques: Vec<Layer>,
}

/// The name of a technique on the page.
pub(crate) fn name(technique: Technique) -> String {
    let Technique { s, t, merged } = technique;
    format!("{}{s},{t}", if merged { "merge " } else { "" })
}

/// The technique of a name.
pub(crate) fn parse(name: &str) -> Fallible<Technique> {
    let plain = name.strip_prefix("merge ");
    let pair = plain.unwrap_or(name).split_once(',');
    let numbers = pair.and_then(|(s, t)| Some((s.trim().parse().ok()?, t.trim().parse().ok()?)));
    let (s, t): (u16, u16) = numbers.ok_or_else(|| format!("{name:?} is not a technique"))?;
    Ok(if plain.is_some() { Technique::merge(s, t) } else { Technique::new(s, t) })
}

/// The techniques of paths with so many scattering events at most: connections by path length and
/// s, then merges.
fn up_to(bounces: u16, merges: bool) -> Vec<Technique> {
    let merging = Technique::merges_up_to(if merges { bounces } else { 0 });
    Technique::up_to(bounces).chain(merging).collect()
}

/// Images of all techniques.
struct Layers {
    techniques: Vec<Technique>,
    excluded: Excluded,
    size: UVec2,
    /// Sums of what is shown of each.
    images: Vec<Image>,
    sum: Image,
    /// Sums of weighted luminance.
    luminance: Vec<f64>,
}

impl Layers {
    fn report(&self, passes: u32, time: Duration, scratch: &Scratch<'_, World>) -> LayerReport {
        let samples = f64::from(passes) * f64::from(self.size.x * self.size.y);
        let total: f64 = self.luminance.iter().sum();
        let layer = |(technique, luminance): (&Technique, &f64)| Layer {
            name: name(*technique),
            s: technique.s,
            t: technique.t,
            merged: technique.merged,
            bounces: technique.bounces(),
            on: !self.excluded.contains(*technique),
            mean: luminance / samples,
            share: if total > 0.0 { luminance / total } else { 0.0 },
        };
        LayerReport {
            report: Report::new(passes, time, &scratch.counters),
            techniques: self.techniques.iter().zip(&self.luminance).map(layer).collect(),
        }
    }

    /// The means of passes: the sum of all techniques, then each.
    fn floats(&self, passes: u32) -> Vec<f32> {
        let scale = 1.0 / passes as f32;
        let all = std::iter::once(&self.sum).chain(&self.images);
        all.flat_map(Image::to_f32).map(|sum| sum * scale).collect()
    }
}

impl Lesson {
    /// Draws the pyramid, and shows it after the first pass, then a few times a second, and at the
    /// end; `progress` says whether to stop.
    ///
    /// # Errors
    /// A technique is unknown or draws paths that are too long to be switched off, or the radius is
    /// out of range.
    pub fn techniques(
        &self,
        job: &TechniquesJob,
        progress: &mut dyn FnMut(&LayerReport, &[f32]) -> bool,
    ) -> Fallible<LayerReport> {
        let limit = Excluded::MOST_BOUNCES;
        if job.bounces > limit {
            return Err(format!("{} bounces are more than {limit}", job.bounces));
        }
        let mut excluded = Excluded::NONE;
        for off in &job.off {
            let technique = parse(off)?;
            excluded = excluded
                .with(technique)
                .ok_or_else(|| format!("technique {technique} cannot be switched off"))?;
        }
        let integrator = VertexConnectionMerging {
            bidirectional: Bidirectional {
                techniques: TechniqueSet { excluded, ..TechniqueSet::BIDIRECTIONAL },
                depth: Depth::up_to(job.bounces.into()),
                ..Bidirectional::default()
            },
            merging: match job.merges {
                true => merging(job.effort.radius),
                false => Merging { light_walks: Some(0), ..Merging::default() },
            },
            ..VertexConnectionMerging::default()
        };
        let kernel = self.filter.kernel().map_err(|error| error.to_string())?;
        // Merges are shown where they are not needed, too.
        let needs = if job.merges { Needs::ALL } else { self.world.needs() };
        let stage = Stage::new(&self.world, &*self.camera);
        let stage = Stage { needs, kernel, seed: job.effort.seed, ..stage };
        let start = Instant::now();
        let integrator: &dyn AnyIntegrator<World, AnySampler> = &integrator;
        let mut run = integrator.start(stage, &Caller).map_err(|error| error.to_string())?;
        let budget = job.effort.budget()?;
        let source = SamplerKind::default().source(job.effort.seed, 64);

        let (region, size) = (stage.film, stage.film.window_size());
        let black = || Image::from_fn(size.x, size.y, |_, _| Rgb::BLACK);
        let techniques = up_to(job.bounces, job.merges);
        let mut layers = Layers {
            excluded,
            size,
            images: techniques.iter().map(|_| black()).collect(),
            sum: black(),
            luminance: vec![0.0; techniques.len()],
            techniques,
        };
        let mut scratch = Scratch::default();
        let mut shown: Option<Instant> = None;
        for pass in 0..u32::MAX {
            if run.prepares() {
                run.begin_pass(pass, &Caller).map_err(|error| error.to_string())?;
            }
            for first in (0..region.pixels()).step_by(BATCH as usize) {
                let pixels = first..region.pixels().min(first + BATCH);
                let mut samples: Vec<_> = pixels
                    .map(|pixel| {
                        let mut sampler = source.sampler(pixel, pass);
                        let film = FilmSample::draw(&region, pixel, &kernel, &mut sampler);
                        Sample { film, sampler }
                    })
                    .collect();
                let sink = &mut |_: usize, contribution: &Contribution| {
                    let Contribution { raster, value, weight, technique } = *contribution;
                    let Some(pixel) = region.pixel_index(raster) else { return };
                    let weighted = value * weight;
                    if !weighted.is_finite() {
                        return;
                    }
                    layers.sum.pixels_mut()[pixel as usize] += weighted;
                    if let Some(i) = layers.techniques.iter().position(|t| *t == technique) {
                        let shown = if job.weighted { weighted } else { value };
                        layers.images[i].pixels_mut()[pixel as usize] += shown;
                        layers.luminance[i] += weighted.luminance();
                    }
                };
                run.draw(&mut samples, sink, 0, &mut scratch);
            }
            let (passes, time) = (pass + 1, start.elapsed());
            let is_last = match budget {
                Budget::Time(limit) => time >= limit,
                Budget::Samples(samples) => passes >= samples,
                _ => true,
            };
            if is_last || shown.is_none_or(|shown| shown.elapsed() >= PERIOD) {
                shown = Some(Instant::now());
                let report = layers.report(passes, time, &scratch);
                if progress(&report, &layers.floats(passes)) || is_last {
                    return Ok(report);
                }
            }
        }
        Err("more passes than can be counted".to_owned())
    }
}
