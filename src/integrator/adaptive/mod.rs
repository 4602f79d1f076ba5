//! Bidirectional path tracing with as much of it as pays: a pilot of a few per cent of the budget
//! finds the set of techniques, and the number of light walks per camera walk, with the least
//! variance × cost, from plain path tracing to all techniques, and the rest of the budget goes to
//! that (efficiency-aware multiple importance sampling: Grittmann, Yazici, Georgiev and Slusallek
//! 2022).
//!
//! Only sets that draw every path are candidates, which is decided from what the scene needs and
//! never from samples; the pilot's samples have random numbers of their own and are not in the
//! image. So the image is unbiased whatever the pilot finds. Costs are counted, not timed: the same
//! seed gives the same decision.

mod decision;
mod findings;
mod pilot;

pub use decision::{Decision, TechniqueRecord};
pub use findings::Candidate;

use super::{
    Adapted, Bidirectional, Depth, Integrator, LightTracer, PathTracer, PathTracing, Pilot,
};
use crate::endpoint::Camera;
use crate::film::{BatchSample, BatchSink, Contribution, FilmRegion, FilmSample, Sink};
use crate::math::Rgb;
use crate::path::{Counters, Heuristic, LightWalks, Roulette, Scratch, TechniqueSet};
use crate::sampler::Sampler;
use crate::scene::{Needs, Scene};
use findings::Findings;
use pilot::{GROUPS, PASSES, for_each_sample, in_parallel};

/// Bidirectional path tracing that leaves out what does not pay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Which path lengths count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
    /// How the techniques are weighted.
    pub heuristic: Heuristic,
    /// Part of the rendering's budget for the pilot, 0 to 1. Default: 0.03.
    pub pilot: f64,
    /// The techniques to run; `None`, the default, to find them by a pilot.
    pub techniques: Option<TechniqueSet>,
}

/// An integrator for a set of techniques.
enum Chosen {
    Path(PathTracer),
    Light(LightTracer),
    Both(Bidirectional),
}

impl Default for Adaptive {
    fn default() -> Self {
        Self {
            depth: Depth::default(),
            roulette: Roulette::default(),
            heuristic: Heuristic::default(),
            pilot: 0.03,
            techniques: None,
        }
    }
}

/// What a sample of the pilot costs, in samples of path tracing: about.
const PILOT_SAMPLE: f64 = 16.0;
/// The pilot's pixels: fewer say nothing, more say nothing new.
const PIXELS: [u64; 2] = [128, 4096];
/// Exponents of the numbers of light walks per camera walk.
const EXPONENTS: std::ops::RangeInclusive<i8> = -3..=4;
/// A simpler set is taken if it is worse by no more than this: its estimate is the more certain
/// one.
const TIE: f64 = 1.02;
/// A choice that takes so many times the variance × cost of its estimate when it is run counts with
/// what it took, and there is another choice.
const MISTRUST: f64 = 2.0;
/// Choices that are run at most.
const RUNS: u32 = 4;

impl Adaptive {
    /// Up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    fn set(&self) -> TechniqueSet {
        self.techniques.unwrap_or(TechniqueSet::BIDIRECTIONAL)
    }

    fn bidirectional(&self, techniques: TechniqueSet) -> Bidirectional {
        Bidirectional {
            techniques,
            depth: self.depth,
            roulette: Roulette { constant: Rgb::BLACK, ..self.roulette },
            heuristic: self.heuristic,
        }
    }

    /// What runs the chosen techniques in the least time.
    fn chosen(&self) -> Chosen {
        let set = self.set();
        let general @ Bidirectional { depth, roulette, heuristic, .. } = self.bidirectional(set);
        match (set.has_camera_walk(), set.has_light_walk()) {
            (true, false) => {
                let mode = if set.emitter_sampling {
                    PathTracing::Both
                } else {
                    PathTracing::EmissionOnly
                };
                Chosen::Path(PathTracer { mode, depth, roulette, heuristic })
            }
            (false, true) => Chosen::Light(LightTracer { depth, roulette }),
            _ => Chosen::Both(general),
        }
    }

    /// The sets that draw every path, the simplest first, all techniques last.
    fn candidates<C: Camera + ?Sized>(&self, needs: &Needs, camera: &C) -> Vec<TechniqueSet> {
        let all = TechniqueSet::BIDIRECTIONAL.pruned(needs);
        let walks = || EXPONENTS.filter_map(LightWalks::power_of_two);
        let mut sets = Vec::new();
        for emitter_sampling in [false, true] {
            sets.push(TechniqueSet { emitter_hits: true, emitter_sampling, ..TechniqueSet::NONE });
        }
        sets.push(TechniqueSet { lens_sampling: true, ..TechniqueSet::NONE });
        for emitter_sampling in [false, true] {
            // Without Dirac lobes the camera walk would be left nothing.
            if needs.contains(Needs::DIRAC_LOBES) {
                let set = TechniqueSet {
                    emitter_hits: true,
                    emitter_sampling,
                    lens_sampling: true,
                    lens_first: true,
                    ..TechniqueSet::NONE
                };
                sets.extend(walks().map(|light_walks| TechniqueSet { light_walks, ..set }));
            }
            for (connections, lens_sampling) in [(false, true), (true, false), (true, true)] {
                let set = TechniqueSet {
                    emitter_hits: all.emitter_hits,
                    emitter_sampling,
                    connections,
                    lens_sampling,
                    ..TechniqueSet::NONE
                };
                sets.extend(walks().map(|light_walks| TechniqueSet { light_walks, ..set }));
            }
        }
        let lens = camera.place();
        // Without a camera walk one light walk is a sample.
        let is_new = |set: &TechniqueSet| {
            *set != all && (set.has_camera_walk() || set.light_walks == LightWalks::ONE)
        };
        sets.retain(|set| set.pruned(needs) == *set && set.is_complete(needs, lens) && is_new(set));
        sets.push(all);
        sets
    }

    /// Variance and cost of one sample, by running the integrator as it is.
    fn measure<S: Scene + ?Sized, C: Camera + ?Sized>(
        &self,
        scene: &S,
        camera: &C,
        pilot: &Pilot<'_>,
        pixels: u64,
    ) -> (Candidate, Counters) {
        let parts = in_parallel(pilot, pixels, |range, scratch: &mut Scratch<'_, S>| {
            let mut sink = Moments { region: camera.film(), pixel: None, own: 0.0, splats: 0.0 };
            let mut variance = 0.0;
            for site in range {
                let (mut sum, mut squares) = (0.0, 0.0);
                for_each_sample(camera, pilot, site, pixels, 1, |film, sampler| {
                    sink.pixel = sink.region.pixel_index(film.raster);
                    self.sample(scene, camera, film, sampler, &mut sink, scratch);
                    let x = std::mem::take(&mut sink.own);
                    (sum, squares) = (sum + x, squares + x * x);
                });
                let n = f64::from(PASSES);
                variance += (squares - sum * sum / n).max(0.0) / (n - 1.0);
            }
            (variance, sink.splats, scratch.counters)
        });
        let (mut variance, mut splats, mut counters) = (0.0, 0.0, Counters::default());
        for part in parts {
            (variance, splats) = (variance + part.0, splats + part.1);
            counters += part.2;
        }
        let samples = (pixels * u64::from(PASSES)) as f64;
        let set = self.set();
        let variance = variance / pixels as f64 + splats / samples;
        (Candidate { set, variance, cost: set.kernel_cost() * counters.cost() / samples }, counters)
    }
}

/// The index of the candidate with the least variance × cost, where that of each is taken as large
/// as it may well be: times e to the power of two standard errors of the logarithm of its ratio to
/// plain bidirectional path tracing, by the jackknife over groups. A pilot that saw no more of a
/// set's noise than one huge contribution is not to be trusted.
fn choose(all: &[Candidate], without_one: &[Vec<Candidate>]) -> usize {
    let pessimistic = |i: usize| {
        let ratios: Vec<f64> = without_one
            .iter()
            .filter_map(|part| Some((part[i].work() / part.last()?.work()).ln()))
            .collect();
        let n = ratios.len() as f64;
        let mean = ratios.iter().sum::<f64>() / n;
        let error = ((n - 1.0) / n * ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>()).sqrt();
        let work = all[i].work();
        // Neither has any noise, or there are too few samples to know.
        if error.is_finite() { work * (2.0 * error).exp() } else { work }
    };
    let works: Vec<f64> = (0..all.len()).map(pessimistic).collect();
    let best = works.iter().copied().fold(f64::INFINITY, f64::min);
    let mut good = (0..all.len()).filter(|i| works[*i] <= best * TIE);
    // Without noise, or without light, the cheapest is best.
    let chosen = if best > 0.0 {
        good.next()
    } else {
        good.min_by(|i, j| all[*i].cost.total_cmp(&all[*j].cost))
    };
    chosen.unwrap_or(all.len() - 1)
}

/// Sums what samples add to their own pixel, and squares what they splat.
struct Moments {
    region: FilmRegion,
    pixel: Option<u32>,
    own: f64,
    splats: f64,
}

impl Sink for Moments {
    fn add(&mut self, contribution: &Contribution) {
        let x = contribution.value.luminance() * contribution.weight;
        let pixel = self.region.pixel_index(contribution.raster);
        if !x.is_finite() || pixel.is_none() {
            return;
        }
        if contribution.technique.t > 1 && pixel == self.pixel {
            self.own += x
        } else {
            self.splats += x * x
        }
    }
}

impl<S: Scene + ?Sized> Integrator<S> for Adaptive {
    fn name(&self) -> &'static str {
        "adaptive"
    }

    fn techniques(&self, needs: &Needs) -> TechniqueSet {
        self.set().pruned(needs)
    }

    fn left_out(&self, needs: &Needs) -> crate::path::LeftOut {
        TechniqueSet::BIDIRECTIONAL.left_out(needs)
    }

    fn adapt<C: Camera + ?Sized>(
        &self,
        scene: &S,
        camera: &C,
        pilot: &Pilot<'_>,
    ) -> Option<Adapted<Self>> {
        if self.techniques.is_some() {
            return None;
        }
        let needs = scene.needs();
        let sets = self.candidates(&needs, camera);
        let plain = *sets.last()?;
        if sets.len() == 1 {
            let decision = Decision::only(plain, Integrator::<S>::left_out(self, &needs));
            return Some(Adapted {
                integrator: Self { techniques: Some(plain), ..*self },
                decision,
                counters: Counters::default(),
            });
        }
        let share =
            self.pilot.clamp(0.0, 1.0) * pilot.samples as f64 / (PILOT_SAMPLE * f64::from(PASSES));
        let pixels = (share as u64).clamp(PIXELS[0], PIXELS[1]);
        let groups = pilot::run(&self.bidirectional(plain), &sets, scene, camera, pilot, pixels);
        let film_pixels = camera.film().pixels();
        let candidates = |skip: Option<usize>| -> (Findings, Vec<Candidate>) {
            let mut findings = Findings::new(sets.len());
            groups
                .iter()
                .enumerate()
                .filter(|(i, _)| Some(*i) != skip)
                .for_each(|(_, group)| findings.merge(group));
            let all =
                (0..).zip(&sets).map(|(i, set)| findings.candidate(i, *set, film_pixels)).collect();
            (findings, all)
        };
        let (findings, mut all) = candidates(None);
        let mut without_one: Vec<Vec<Candidate>> =
            (0..GROUPS).map(|group| candidates(Some(group)).1).collect();
        let mut counters = findings.counters();
        let mut runs = 0;
        let (integrator, chosen, achieved) = loop {
            let index = choose(&all, &without_one);
            let chosen = all[index];
            let integrator = Self { techniques: Some(chosen.set), ..*self };
            let (achieved, more) = integrator.measure(scene, camera, pilot, pixels);
            counters += more;
            runs += 1;
            if achieved.work() <= MISTRUST * chosen.work() || runs == RUNS {
                break (integrator, chosen, achieved);
            }
            all[index] = achieved;
            without_one.iter_mut().for_each(|part| part[index] = achieved);
        };
        let left_out = Integrator::<S>::left_out(self, &needs);
        let decision = Decision::measured(&findings, all, chosen, achieved, left_out);
        Some(Adapted { integrator, decision, counters })
    }

    fn sample<'s, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        match self.chosen() {
            Chosen::Path(tracer) => tracer.sample(scene, camera, film, sampler, sink, scratch),
            Chosen::Light(tracer) => tracer.sample(scene, camera, film, sampler, sink, scratch),
            Chosen::Both(tracer) => tracer.sample(scene, camera, film, sampler, sink, scratch),
        }
    }

    fn sample_batch<'s, C: Camera + ?Sized, P: Sampler, K: BatchSink>(
        &self,
        scene: &'s S,
        camera: &C,
        samples: &mut [BatchSample<P>],
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        match self.chosen() {
            Chosen::Path(tracer) => tracer.sample_batch(scene, camera, samples, sink, scratch),
            Chosen::Light(tracer) => tracer.sample_batch(scene, camera, samples, sink, scratch),
            Chosen::Both(tracer) => tracer.sample_batch(scene, camera, samples, sink, scratch),
        }
    }
}
