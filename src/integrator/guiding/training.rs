//! The walks that teach a field, and what they tell of guiding.
//!
//! A pass has twice the samples of the one before it, and is guided by what that has learnt. A
//! guided sample `X = Σ x_j`, with its contributions in the order of the walk, tells the second
//! moments with guiding and without,
//!
//! ```text
//! E[X²]    and    E[Σ_j r_j x_j (x_j + 2 Σ_{i > j} x_i)],     r_j = Π p⊥/p⊥_bsdf up to the vertex of x_j,
//! ```
//!
//! where a path that the BSDF hardly finds counts as much as it should. Both have the same mean, so
//! the difference is that of the variances. Weights and roulette are taken to be the same.

use super::Guidance;
use crate::bsdf::shading::ShadedBsdf;
use crate::bsdf::{Bsdf, TransportMode};
use crate::film::{Contribution, FilmSample, Sample};
use crate::guiding::{Field, Guided, GuidedBsdf, Record};
use crate::integrator::{Crew, PathTracer, Stage};
use crate::math::Rgb;
use crate::path::{Counters, Plan, RandomWalk, Scratch, Site, Steps, Vertex, Visit, advance, join};
use crate::sampler::{Independent, SampleSource, Sampler};
use crate::scene::Scene;
use glam::DVec3;
use std::ops::{ControlFlow, Range};

/// Parts of the rendering's cost that learning may have, by what is known: as a trial, and in all
/// if the second moment with guiding is less by this; most samples.
const TRIAL: f64 = 0.1;
const PART: f64 = 0.5;
const PROMISE: f64 = 1.2;
const MOST: u64 = 1 << 25;
/// Samples of the trial's first pass, at least, and most of its passes.
const FEWEST: u64 = 1 << 10;
const PASSES: u32 = 4;
/// Cost of a sample that is guided and of one that is learnt from, and of one without either where
/// walks between flat diffuse surfaces go in lanes, over that of others with the same counts.
const GUIDED: f64 = 1.3;
const LEARNT: f64 = 2.5;
const IN_LANES: f64 = 0.6;
/// Samples of each pixel that is looked at: the fewest that have a variance.
const SAMPLES: usize = 2;
/// Pixels that are drawn at a time, those of a task, and tasks whose records are kept at a time.
const BATCH: u64 = 64;
const TASK: u64 = 256;
const TASKS: u64 = 64;
/// Tells the numbers of these walks from those of samples.
const OWN_NUMBERS: u64 = 0x6775_6964_696e_6773;

/// The learning of a field.
pub(super) struct Training<'r, 'a, S: Scene + ?Sized> {
    teacher: PathTracer,
    alpha: f64,
    stage: Stage<'a, S>,
    crew: &'r dyn Crew,
    pub field: Field,
    pub counters: Counters,
}

/// The findings of some of the pixels of a pass.
#[derive(Default)]
struct Part {
    records: Vec<Record>,
    pixels: u64,
    /// Σ of the variance of a sample, and of how much more it is without guiding.
    variance: f64,
    difference: f64,
    counters: Counters,
}

impl<'r, 'a, S: Scene + ?Sized> Training<'r, 'a, S> {
    pub fn new(teacher: PathTracer, alpha: f64, stage: Stage<'a, S>, crew: &'r dyn Crew) -> Self {
        let (field, counters) = (Field::unknown(), Counters::default());
        Self { teacher, alpha, stage, crew, field, counters }
    }

    /// Learns within the budget, and beyond the trial as long as that promises something; within the
    /// whole budget, and so much as it takes, if walks are `always` guided.
    pub fn run(&mut self, always: bool) -> Guidance {
        let mut guidance = Guidance::default();
        let is_in_lanes = self.stage.scene.flat_surfaces().is_some();
        let plain = if is_in_lanes { IN_LANES } else { 1.0 };
        let budget = (self.stage.samples as f64 * plain / LEARNT).min(MOST as f64);
        let most = (PART * budget) as u64;
        let trial = if always { most.max(7 * FEWEST) } else { (TRIAL * budget) as u64 };
        let passes = (trial / FEWEST + 1).ilog2().min(PASSES);
        if passes < 2 || self.alpha == 1.0 {
            return guidance;
        }
        let mut samples = trial / ((1 << passes) - 1);
        let (mut plain_cost, mut is_promising) = (f64::NAN, true);
        for pass in 0.. {
            if pass >= passes && !(is_promising && guidance.samples + samples <= most) {
                break;
            }
            let first = guidance.samples / SAMPLES as u64;
            let found = self.pass(first..first + samples / SAMPLES as u64);
            self.field.update();
            self.counters += found.counters;
            guidance.samples += found.counters.samples;
            guidance.parts = self.field.known();
            samples *= 2;
            let cost = found.counters.cost() / found.counters.samples as f64;
            if pass == 0 {
                plain_cost = plain * cost;
                continue;
            }
            let ratio = (found.variance + found.difference) / found.variance;
            guidance.gain = ratio * plain_cost / (GUIDED * cost);
            guidance.is_used = always || guidance.gain > 1.0;
            is_promising = ratio > PROMISE;
        }
        guidance
    }

    /// Draws samples of pixels and learns from them.
    fn pass(&mut self, pixels: Range<u64>) -> Part {
        let (mut sum, mut from) = (Part::default(), pixels.start);
        while from < pixels.end {
            let tasks = (pixels.end - from).div_ceil(TASK).min(TASKS);
            for part in self.crew.collect(tasks as usize, |task| {
                let from = from + task as u64 * TASK;
                self.draw(from..(from + TASK).min(pixels.end), &pixels)
            }) {
                self.field.learn(&part.records);
                sum.pixels += part.pixels;
                sum.variance += part.variance;
                sum.difference += part.difference;
                sum.counters += part.counters;
            }
            from += tasks * TASK;
        }
        sum
    }

    /// Draws samples of some of the pixels of a pass.
    fn draw(&self, pixels: Range<u64>, pass: &Range<u64>) -> Part {
        let mut part = Part { pixels: pixels.end - pixels.start, ..Part::default() };
        let Some(scene) = Guided::new(self.stage.scene, &self.field, self.alpha) else {
            return part;
        };
        let stage = self.stage.viewed(&scene, self.stage.needs);
        let plan = Plan::new(stage, self.teacher.techniques(), self.teacher.depth);
        let Stage { film, kernel, seed, .. } = stage;
        let source = Independent { seed: seed ^ OWN_NUMBERS };
        let mut scratch = Scratch::default();
        let mut from = pixels.start;
        while from < pixels.end {
            let mut samples = Vec::with_capacity(BATCH as usize * SAMPLES);
            for number in from..(from + BATCH).min(pixels.end) {
                // One in each part of the window, at random in it.
                let jitter = source.sampler(u32::MAX, number as u32).next_1d();
                let u = ((number - pass.start) as f64 + jitter) / (pass.end - pass.start) as f64;
                let pixel = ((u * f64::from(film.pixels())) as u32).min(film.pixels() - 1);
                samples.extend((0..SAMPLES as u64).map(|i| {
                    let mut sampler = source.sampler(pixel, (number * SAMPLES as u64 + i) as u32);
                    Sample { film: FilmSample::draw(&film, pixel, &kernel, &mut sampler), sampler }
                }));
            }
            // The vertex of each contribution.
            let mut found: Vec<(usize, usize, Rgb)> = Vec::new();
            let sink = &mut |sample: usize, c: &Contribution| {
                found.push((sample, usize::from(c.technique.t) - 1, c.value * c.weight));
            };
            scratch.counters.samples += samples.len() as u64;
            advance(&plan, &Kept(self.teacher), &mut samples, sink, &mut scratch);
            found.sort_by_key(|(sample, vertex, _)| (*sample, *vertex));
            let (mut found, mut number, mut sums) = (found.iter().peekable(), 0, Vec::new());
            let mut ahead = Vec::new();
            let nowhere = &mut |_: usize, _: &Contribution| {};
            join(&plan, &mut samples, nowhere, &mut scratch, |site| {
                let camera = &site.subpaths.camera;
                ahead.clear();
                ahead.resize(camera.len(), Rgb::BLACK);
                while let Some((_, vertex, value)) = found.next_if(|(i, ..)| *i == number) {
                    ahead[*vertex] += *value;
                }
                let (sum, difference) = compare(camera, &ahead);
                sums.push(sum);
                if difference.is_finite() {
                    part.difference += difference / SAMPLES as f64;
                }
                for i in (1..camera.len().saturating_sub(1)).rev() {
                    let next = ahead[i + 1];
                    ahead[i] += next;
                    let direction = -camera[i + 1].to_previous;
                    match record(&self.field, self.alpha, &camera[i], direction, next) {
                        Some(Ok(record)) => part.records.push(record),
                        Some(Err(())) => site.counters.non_finite += 1,
                        None => {}
                    }
                }
                number += 1;
            });
            for pair in sums.chunks_exact(SAMPLES) {
                let variance = 0.5 * (pair[0] - pair[1]).powi(2);
                part.variance += if variance.is_finite() { variance } else { 0.0 };
            }
            from += BATCH;
        }
        Part { counters: scratch.counters, ..part }
    }
}

/// The luminance of a sample, by what each vertex of its walk contributes, and how much more its
/// second moment is without guiding.
fn compare<B: Bsdf>(camera: &[Vertex<GuidedBsdf<'_, B>>], own: &[Rgb]) -> (f64, f64) {
    let sum: f64 = own.iter().map(|value| value.luminance()).sum();
    let (mut rest, mut ratio, mut difference) = (sum, 1.0, 0.0);
    for (i, vertex) in camera.iter().enumerate() {
        if rest == 0.0 {
            break;
        }
        let x = own[i].luminance();
        rest -= x;
        if x != 0.0 {
            difference += (ratio - 1.0) * x * (x + 2.0 * rest);
        }
        if let (Some(bsdf), Some(next)) = (&vertex.bsdf, camera.get(i + 1)) {
            let (model, alpha) = (bsdf.model().inner(), bsdf.model().alpha());
            if alpha < 1.0 {
                let direction = -next.to_previous;
                ratio *= if vertex.dirac {
                    alpha
                } else {
                    let mode = TransportMode::Radiance;
                    let plain = ShadedBsdf::new(model, &vertex.point);
                    vertex.pdf_next.value() / plain.pdf(vertex.to_previous, direction, mode).value()
                };
            }
        }
    }
    (sum, difference)
}

/// The record of what goes on from a vertex, `f L |cos θ| / p`, given what the walk contributes
/// beyond; an error if it is not a number, `None` if the direction was that of a Dirac lobe.
fn record<B: Bsdf>(
    field: &Field,
    alpha: f64,
    vertex: &Vertex<GuidedBsdf<'_, B>>,
    direction: DVec3,
    mut value: Rgb,
) -> Option<Result<Record, ()>> {
    let bsdf = vertex.finite_bsdf().filter(|_| !vertex.dirac)?;
    let plain = ShadedBsdf::new(bsdf.model().inner(), &vertex.point);
    let plain = plain.pdf(vertex.to_previous, direction, TransportMode::Radiance);
    let cosine = vertex.point.geometric_normal.dot(direction);
    let pdfs = [vertex.pdf_next, plain].map(|pdf| pdf.per_solid_angle(cosine).value());
    for (channel, throughput) in value.0.iter_mut().zip(vertex.throughput.0) {
        // Nothing is known of a channel without throughput.
        *channel = if *channel == 0.0 { 0.0 } else { *channel / throughput };
    }
    let energy = value.luminance();
    Some(field.record(vertex.point.position, direction, energy, pdfs, alpha).ok_or(()))
}

/// Path tracing that keeps the vertices of its walks.
struct Kept(PathTracer);

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for Kept {
    const KEEPS: bool = true;
    const CONNECTS: bool = true;

    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        site.subpaths.camera.clear();
        let (walk, lens) = site.plan.stage.camera_walk(site.sample)?;
        site.subpaths.camera.push(lens);
        Some(walk)
    }

    fn arrive<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        self.0.arrive(visit)
    }

    fn connect<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) {
        self.0.connect(visit);
    }

    fn leave<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        self.0.leave(visit)
    }

    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        self.0.scatter(visit)
    }
}
