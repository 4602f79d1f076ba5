//! The pilot: a race between sets of techniques.
//!
//! In each heat every set draws samples of the same pixels, and the half with the least variance ×
//! cost goes on, to twice as many. A set that has not met its rare, bright contributions looks better
//! than it is. So the paths of plain bidirectional path tracing, which finds them easily, tell the
//! second moment that the single contributions of a set C should have,
//!
//! ```text
//! E_C = ∫ f² / Σ_{i ∈ C} n_i p_i  =  E[Σ w v² / Σ_{i ∈ C} n_i p_i/p],       v = f/p,
//! ```
//!
//! over the paths of a plain sample, drawn with density p, w by the balance heuristic (Grittmann et
//! al. 2022). Where a set's samples fall short of it by a tenth, its variance is that much larger.

use super::{Adaptive, Candidate, Chosen};
use crate::film::{Contribution, FilmRegion, FilmSample, Sample, Sink};
use crate::integrator::{Bidirectional, Crew, Stage};
use crate::math::distribution::AliasTable;
use crate::path::{Counters, Family, Path, PathDensities, Scratch, TechniqueSet};
use crate::sampler::{Independent, IndependentSampler, SampleSource, Sampler};
use crate::scene::Scene;
use std::ops::Range;

/// Samples of each pixel that is looked at: the fewest that have a variance. A few pixels, such as
/// those at the edge of a lamp, may have most of it, so many pixels say more than many samples.
const PASSES: u64 = 2;
/// Cost of a sample of the race, in samples of path tracing: about.
const SAMPLE: f64 = 4.0;
/// Pixels of each set in the first heat: fewer say nothing, more say nothing new.
const PIXELS: [u64; 2] = [96, 2048];
/// A simpler set is taken if it is worse by no more than this.
const TIE: f64 = 1.1;
/// Pixels that are looked at before the race.
const SITES: u64 = 1024;
/// Pixels per task.
const TASK: u64 = 16;
type Samples = [Sample<IndependentSampler>; PASSES as usize];

/// The sets of a race and what is known of them.
pub(super) struct Race<'r, 'a, S: Scene + ?Sized> {
    stage: Stage<'a, S>,
    crew: &'r dyn Crew,
    settings: Adaptive,
    /// Plain bidirectional path tracing, the last of the sets.
    plain: Bidirectional,
    sets: Vec<(TechniqueSet, Sums)>,
    scouted: Scouted,
}

/// The findings of plain bidirectional path tracing before the race.
#[derive(Default)]
struct Scouted {
    /// The pixels that are looked at, and how often each.
    pixels: Vec<u32>,
    chances: Option<AliasTable>,
    /// Of each path p_i/p summed over each family, and w v².
    paths: Vec<([f64; FAMILIES], f64)>,
    counters: Counters,
}

impl<'r, 'a, S: Scene + ?Sized> Race<'r, 'a, S> {
    pub fn new(
        settings: Adaptive,
        stage: Stage<'a, S>,
        crew: &'r dyn Crew,
        sets: &[TechniqueSet],
    ) -> Self {
        let plain = settings.bidirectional(sets.last().copied().unwrap_or_default());
        let sets = sets.iter().map(|set| (*set, Sums::default())).collect();
        Self { stage, crew, settings, plain, sets, scouted: Scouted::default() }
    }

    /// Runs it within a budget, in samples of path tracing; returns what is known of each set, the
    /// index of the winner, and what was done.
    pub fn run(mut self, budget: f64) -> (Vec<Candidate>, usize, Counters) {
        let mut field: Vec<usize> = (0..self.sets.len()).collect();
        if field.len() > 1 {
            self.scout();
        }
        let heats = f64::from(field.len().ilog2() + 1);
        let share = budget / (heats * field.len() as f64 * SAMPLE * PASSES as f64);
        let (mut first, mut pixels) = (0, (share as u64).clamp(PIXELS[0], PIXELS[1]));
        while field.len() > 1 {
            self.heat(&field, first..first + pixels);
            first += pixels;
            let (half, works) = (field.len() / 2, self.works());
            field.sort_by(|i, j| works[*i].total_cmp(&works[*j]));
            if half == 1 {
                let close = self.close_to(field[0]);
                self.heat(&close, first..first + pixels);
                field.extend(close);
                break;
            }
            field.truncate(half);
            pixels *= 2;
        }
        let works = self.works();
        let best = field.iter().map(|i| works[*i]).fold(f64::INFINITY, f64::min);
        let winner = field.into_iter().filter(|i| works[*i] <= TIE * best).min();
        let mut counters = self.scouted.counters;
        self.sets.iter().for_each(|(_, sums)| counters += sums.counters);
        (self.candidates(), winner.unwrap_or_default(), counters)
    }

    /// A set and those with half and twice the number of light subpaths.
    fn close_to(&mut self, best: usize) -> Vec<usize> {
        let (set, from) = (self.sets[best].0, self.sets.len());
        if set.has_camera_subpath() && set.has_light_subpath() {
            let numbers = [set.light_subpaths.halved(), set.light_subpaths.doubled()];
            let close = numbers.into_iter().flatten();
            let close = close.map(|light_subpaths| TechniqueSet { light_subpaths, ..set });
            self.sets.extend(close.map(|set| (set, Sums::default())));
        }
        std::iter::once(best).chain(from..self.sets.len()).collect()
    }

    /// Draws plain samples, and chooses pixels for their noise and brightness.
    fn scout(&mut self) {
        let parts = self.crew.collect(SITES.div_ceil(TASK) as usize, |task| {
            let (mut own, mut scouted, mut scratch) =
                (vec![], Scouted::default(), Scratch::default());
            for number in (task as u64 * TASK..SITES).take(TASK as usize) {
                let (pixel, _, samples) = self.samples(number, &(0..SITES));
                own.push(samples.map(|sample| {
                    let mut sum = 0.0;
                    self.plain.for_each_path(self.stage, sample, &mut scratch, |path, found| {
                        if found.technique.t > 1 {
                            sum += found.value.luminance() * found.weight;
                        }
                        scouted.paths.extend(moment(path, &self.plain.techniques));
                    });
                    if sum.is_finite() { sum.abs() } else { 0.0 }
                }));
                scouted.pixels.push(pixel);
            }
            (own, Scouted { counters: scratch.counters, ..scouted })
        });
        let mut own = Vec::new();
        for (sums, part) in parts {
            own.extend(sums);
            self.scouted.pixels.extend(part.pixels);
            self.scouted.paths.extend(part.paths);
            self.scouted.counters += part.counters;
        }
        let mean = own.iter().flatten().sum::<f64>() / (PASSES * SITES) as f64;
        let scores = own.iter().map(|[a, b]| (a - b).abs() + 0.25 * (a + b + mean));
        self.scouted.chances = AliasTable::new(&scores.collect::<Vec<_>>());
    }

    /// The samples of a pixel of a heat: the pixel, and how much it counts. Pass numbers run down
    /// from the largest, which no rendering reaches: so they are independent of the rendering's.
    fn samples(&self, number: u64, heat: &Range<u64>) -> (u32, f64, Samples) {
        let Stage { film, kernel, seed, .. } = self.stage;
        let source = Independent { seed };
        let pass = |i: u64| u32::MAX - (i % (1 << 31)) as u32;
        // One in each part of the window or of the sites, at random in it.
        let jitter = source.sampler(0, pass(number)).next_1d();
        let u = ((number - heat.start) as f64 + jitter) / (heat.end - heat.start) as f64;
        let (pixel, weight) = if let Some(chances) = &self.scouted.chances {
            let (site, chance) = chances.sample(u.min(1.0f64.next_down()));
            (self.scouted.pixels[site], 1.0 / (chance * chances.len() as f64))
        } else {
            (((u * f64::from(film.pixels())) as u32).min(film.pixels() - 1), 1.0)
        };
        let sample = |i| {
            let mut sampler = source.sampler(pixel, pass(number * PASSES + i as u64));
            Sample { film: FilmSample::draw(&film, pixel, &kernel, &mut sampler), sampler }
        };
        (pixel, weight, std::array::from_fn(sample))
    }

    /// Lets some sets draw samples of so many pixels.
    fn heat(&mut self, field: &[usize], pixels: Range<u64>) {
        let tasks = (pixels.end - pixels.start).div_ceil(TASK);
        let runs: Vec<Chosen<'_, S>> =
            field.iter().map(|i| self.settings.run(self.stage, self.sets[*i].0)).collect();
        let parts = self.crew.collect(field.len() * tasks as usize, |task| {
            let (run, task) = (&runs[task / tasks as usize], task as u64 % tasks);
            let from = pixels.start + task * TASK;
            self.draw(run, from..(from + TASK).min(pixels.end), &pixels)
        });
        for (i, part) in parts.iter().enumerate() {
            self.sets[field[i / tasks as usize]].1.add(part);
        }
    }

    /// Draws samples of some of the pixels of a heat.
    fn draw(&self, run: &Chosen<'_, S>, pixels: Range<u64>, heat: &Range<u64>) -> Sums {
        let (mut batch, mut own) = (Vec::new(), Vec::new());
        for number in pixels.clone() {
            let (pixel, weight, samples) = self.samples(number, heat);
            batch.extend(samples);
            own.extend([(pixel, weight, 0.0); PASSES as usize]);
        }
        let (film, mut scratch) = (self.stage.film, Scratch::default());
        let mut moments = Moments { film, own, sums: Sums::default() };
        run.draw(&mut batch, &mut moments, &mut scratch);
        let pixels = pixels.end - pixels.start;
        Sums { counters: scratch.counters, pixels, ..moments.finish() }
    }

    /// The variance and cost of a set, as far as they are known.
    fn candidate(&self, (set, sums): &(TechniqueSet, Sums)) -> Candidate {
        let counts =
            Family::ALL.map(|family| if set.has(family) { set.family_count(family) } else { 0.0 });
        let moments = self.scouted.paths.iter().map(|(ratios, moment)| {
            moment / ratios.iter().zip(counts).map(|(ratio, n)| ratio * n).sum::<f64>()
        });
        let moments = moments.filter(|moment| moment.is_finite());
        let expected = moments.sum::<f64>() / (PASSES * SITES) as f64;
        let samples = (sums.pixels * PASSES) as f64;
        let met = (sums.singles + sums.splats) / samples;
        let seen = (sums.variance * PASSES as f64 + sums.splats) / samples;
        let missed = expected - met;
        let variance = if missed > 0.1 * expected { seen + missed } else { seen };
        let cost = set.kernel_cost() * sums.counters.cost() / samples;
        Candidate { set: *set, variance, cost, samples: sums.pixels * PASSES }
    }

    fn candidates(&self) -> Vec<Candidate> {
        self.sets.iter().map(|set| self.candidate(set)).collect()
    }

    /// Variance × cost of each set; of those without noise the cheapest is best.
    fn works(&self) -> Vec<f64> {
        let sets = self.candidates().into_iter();
        sets.map(|set| set.work().max(f64::MIN_POSITIVE * set.cost)).collect()
    }
}

const FAMILIES: usize = Family::ALL.len();

/// The ratios and the moment of a path of a plain sample; see [`Scouted::paths`].
fn moment<S: Scene + ?Sized>(
    path: &Path<'_, '_, S>,
    plain: &TechniqueSet,
) -> Option<([f64; FAMILIES], f64)> {
    let column = |technique| Family::ALL.iter().position(|family| *family == Family::of(technique));
    let (densities, mut ratios) = (path.densities(), [0.0; FAMILIES]);
    ratios[column(path.technique())?] = 1.0;
    densities.sweep(path.technique(), 0.0, |other, ratio| {
        if let Some(column) = column(other).filter(|_| plain.contains(other)) {
            ratios[column] += ratio;
        }
    });
    let moment = path.value().luminance().powi(2) / ratios.iter().sum::<f64>();
    moment.is_finite().then_some((ratios, moment))
}

/// Sums over the samples of a set.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pixels: u64,
    /// Σ over pixels of the variance of what samples add to their own pixel.
    variance: f64,
    /// Σ of the squares of single contributions to the own pixel and to others.
    singles: f64,
    splats: f64,
    counters: Counters,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.variance += other.variance;
        self.singles += other.singles;
        self.splats += other.splats;
        self.counters += other.counters;
    }
}

/// Sums of what samples add to their own pixel, and squares of what they splat.
struct Moments {
    film: FilmRegion,
    /// The pixel of each sample, what it counts, and what it was given.
    own: Vec<(u32, f64, f64)>,
    sums: Sums,
}

impl Moments {
    fn finish(&mut self) -> Sums {
        for pair in self.own.chunks(PASSES as usize) {
            let [(_, weight, a), (.., b)] = pair else { continue };
            self.sums.variance += weight * 0.5 * (a - b).powi(2);
        }
        self.sums
    }
}

impl Sink for Moments {
    fn add(&mut self, sample: usize, contribution: &Contribution) {
        let x = contribution.value.luminance() * contribution.weight;
        let Some(pixel) = self.film.pixel_index(contribution.raster).filter(|_| x.is_finite())
        else {
            return;
        };
        match self.own.get_mut(sample) {
            Some((own, weight, sum)) if contribution.technique.t > 1 && *own == pixel => {
                *sum += x;
                self.sums.singles += *weight * x * x;
            }
            _ => self.sums.splats += x * x,
        }
    }
}
