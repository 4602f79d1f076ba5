//! The pilot: a race between sets of techniques.
//!
//! In each heat every set that is left draws samples of the same pixels, and the half with the
//! least variance × cost goes on, to twice as many. A set that has not met its rare, bright
//! contributions looks better than it is, but too dark, too: if its mean is below what another one
//! is sure of by an energy e, then e came in none of its N samples, which adds N e² to its variance
//! at least.

use super::{Candidate, Chosen};
use crate::film::{Contribution, FilmRegion, FilmSample, Sample, Sink};
use crate::integrator::{Crew, Stage};
use crate::math::distribution::AliasTable;
use crate::path::{Counters, Scratch, TechniqueSet};
use crate::sampler::{Independent, SampleSource, Sampler};
use crate::scene::Scene;
use std::ops::{AddAssign, Range};

/// Samples of each pixel that is looked at: the fewest that have a variance. A few pixels, such as
/// those at the edge of a lamp, may have most of it, so many pixels say more than many samples.
const PASSES: u64 = 2;
/// Cost of a sample of the race, in samples of path tracing: about.
const SAMPLE: f64 = 4.0;
/// Pixels of each set in the first heat: fewer say nothing, more say nothing new.
const PIXELS: [u64; 2] = [160, 2048];
/// A simpler set is taken if it is worse by no more than this.
const TIE: f64 = 1.15;
/// Pixels that are looked at before the race.
const SITES: u64 = 1024;
/// Pixels per task.
const TASK: u64 = 16;

/// The sets of a race and what is known of them.
pub(super) struct Race<'r, 'a, S: Scene + ?Sized> {
    pub stage: Stage<'a, S>,
    pub crew: &'r dyn Crew,
    pub run: &'r (dyn Fn(TechniqueSet) -> Chosen<'a, S> + Sync),
    pub sets: Vec<(TechniqueSet, Sums)>,
    /// The pixels that are looked at; none before they have been chosen.
    pub sites: Sites,
}

/// Pixels, and how often each is looked at.
#[derive(Default)]
pub(super) struct Sites {
    pixels: Vec<u32>,
    chances: Option<AliasTable>,
}

impl<S: Scene + ?Sized> Race<'_, '_, S> {
    /// Runs it within a budget, in samples of path tracing, and returns the index of the winner.
    pub fn winner(&mut self, budget: f64) -> usize {
        let mut field: Vec<usize> = (0..self.sets.len()).collect();
        if field.len() > 1 {
            self.choose_sites(field.len() - 1);
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
                self.heat(&close, first..first + 2 * pixels);
                field.extend(close);
                break;
            }
            field.truncate(half);
            pixels *= 2;
        }
        let works = self.works();
        let best = field.iter().map(|i| works[*i]).fold(f64::INFINITY, f64::min);
        field.into_iter().filter(|i| works[*i] <= TIE * best).min().unwrap_or_default()
    }

    /// A set and those with half and twice the number of light subpaths, and without next event
    /// estimation, if they draw every path.
    fn close_to(&mut self, best: usize) -> Vec<usize> {
        let set = self.sets[best].0;
        let mut close = vec![best];
        if set.has_camera_subpath() && set.has_light_subpath() {
            let walks = [set.light_subpaths.halved(), set.light_subpaths.doubled()];
            let walks = walks.into_iter().flatten();
            let walks = walks.map(|light_subpaths| TechniqueSet { light_subpaths, ..set });
            let without = TechniqueSet { next_event: false, ..set };
            let Stage { needs, camera, .. } = &self.stage;
            for set in walks.chain([without]).filter(|set| set.is_complete(needs, camera.place())) {
                close.push(self.sets.len());
                self.sets.push((set, Sums::default()));
            }
        }
        close
    }

    /// Chooses pixels for their noise and brightness, as two samples by the plain set tell.
    fn choose_sites(&mut self, plain: usize) {
        let (run, count) = ((self.run)(self.sets[plain].0), SITES.div_ceil(TASK));
        let parts = self.crew.collect(count as usize, |task| {
            let from = task as u64 * TASK;
            self.draw(&run, from..(from + TASK).min(SITES), &(0..SITES))
        });
        let (sums, own): (Vec<Sums>, Vec<_>) = parts.into_iter().unzip();
        let own: Vec<(u32, f64, f64)> = own.into_iter().flatten().collect();
        let mean = own.iter().map(|(.., x)| x.abs()).sum::<f64>() / own.len() as f64;
        let scores = own.chunks(PASSES as usize).map(|pixel| {
            let [a, b] = [pixel[0].2, pixel[1].2];
            (a - b).abs() + 0.25 * (a.abs() + b.abs() + mean)
        });
        let chances = AliasTable::new(&scores.collect::<Vec<_>>());
        let pixels = own.iter().step_by(PASSES as usize).map(|(pixel, ..)| *pixel).collect();
        self.sites = Sites { pixels, chances };
        sums.into_iter().for_each(|sums| self.sets[plain].1.counters += sums.counters);
    }

    /// Lets some sets draw samples of so many pixels.
    fn heat(&mut self, field: &[usize], pixels: Range<u64>) {
        let tasks = (pixels.end - pixels.start).div_ceil(TASK);
        let runs: Vec<Chosen<'_, S>> = field.iter().map(|i| (self.run)(self.sets[*i].0)).collect();
        let parts = self.crew.collect(field.len() * tasks as usize, |task| {
            let (run, task) = (&runs[task / tasks as usize], task as u64 % tasks);
            let from = pixels.start + task * TASK;
            self.draw(run, from..(from + TASK).min(pixels.end), &pixels)
        });
        for (i, (part, _)) in parts.iter().enumerate() {
            self.sets[field[i / tasks as usize]].1 += *part;
        }
    }

    /// Draws samples of some of the pixels of a heat. Pass numbers run down from the largest, which
    /// no rendering reaches: so the samples are independent of the rendering's.
    fn draw(
        &self,
        run: &Chosen<'_, S>,
        pixels: Range<u64>,
        heat: &Range<u64>,
    ) -> (Sums, Vec<(u32, f64, f64)>) {
        let Stage { film, kernel, seed, .. } = self.stage;
        let (source, count) = (Independent { seed }, (heat.end - heat.start) as f64);
        let pass = |i: u64| u32::MAX - (i % (1 << 31)) as u32;
        let (mut samples, mut own) = (Vec::new(), Vec::new());
        for number in pixels.clone() {
            // One in each part of the window, at random in it.
            let jitter = source.sampler(0, pass(number)).next_1d();
            let position = ((number - heat.start) as f64 + jitter) / count;
            let (pixel, weight) = if let Some(chances) = &self.sites.chances {
                let (site, chance) = chances.sample(position.min(1.0f64.next_down()));
                (self.sites.pixels[site], 1.0 / (chance * chances.len() as f64))
            } else {
                let pixel = (position * f64::from(film.pixels())) as u32;
                (pixel.min(film.pixels() - 1), 1.0)
            };
            for i in 0..PASSES {
                let mut sampler = source.sampler(pixel, pass(number * PASSES + i));
                let film = FilmSample::draw(&film, pixel, &kernel, &mut sampler);
                samples.push(Sample { film, sampler });
                own.push((pixel, weight, 0.0));
            }
        }
        let mut scratch = Scratch::default();
        let mut moments = Moments { film, own, sums: Sums::default() };
        run.draw(&mut samples, &mut moments, &mut scratch);
        let pixels = pixels.end - pixels.start;
        let sums = Sums { counters: scratch.counters, pixels, ..moments.finish() };
        (sums, moments.own)
    }

    /// Variance × cost of each set that has drawn samples.
    fn works(&self) -> Vec<f64> {
        let sure = |(_, sums): &(TechniqueSet, Sums)| sums.mean() - 2.0 * sums.error();
        let known = self.sets.iter().map(sure).fold(0.0, f64::max);
        let work = |(set, sums): &(TechniqueSet, Sums)| {
            let unseen = (known - sums.mean()).max(0.0);
            let variance = sums.variance().max(unseen * unseen * sums.samples());
            let work = variance * sums.candidate(*set).cost;
            // Without noise the cheapest is best.
            if work > 0.0 { work } else { f64::MIN_POSITIVE * sums.candidate(*set).cost }
        };
        self.sets.iter().map(work).collect()
    }
}

/// Sums over the samples of a set.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pixels: u64,
    /// Σ over pixels of the variance of what samples add to their own pixel.
    variance: f64,
    /// Σ of the squares of that.
    own_squares: f64,
    /// Σ of the squares of single contributions to other pixels.
    splats: f64,
    /// Σ of all contributions.
    luminance: f64,
    pub counters: Counters,
}

impl Sums {
    fn samples(&self) -> f64 {
        (self.pixels * PASSES) as f64
    }

    fn mean(&self) -> f64 {
        self.luminance / self.samples().max(1.0)
    }

    /// Standard error of the mean.
    fn error(&self) -> f64 {
        ((self.own_squares + self.splats) / self.samples().max(1.0).powi(2)).sqrt()
    }

    fn variance(&self) -> f64 {
        (self.variance * PASSES as f64 + self.splats) / self.samples()
    }

    pub fn candidate(&self, set: TechniqueSet) -> Candidate {
        let cost = set.kernel_cost() * self.counters.cost() / self.samples();
        Candidate { set, variance: self.variance(), cost, samples: self.pixels * PASSES }
    }
}

impl AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.variance += other.variance;
        self.own_squares += other.own_squares;
        self.splats += other.splats;
        self.luminance += other.luminance;
        self.counters += other.counters;
    }
}

/// Sums what samples add to their own pixel, and squares what they splat.
struct Moments {
    film: FilmRegion,
    /// The pixel of each sample, what it counts, and what it was given.
    own: Vec<(u32, f64, f64)>,
    sums: Sums,
}

impl Moments {
    fn finish(&mut self) -> Sums {
        for pixel in self.own.chunks(PASSES as usize) {
            let n = PASSES as f64;
            let (sum, squares) =
                pixel.iter().fold((0.0, 0.0), |(a, b), (.., x)| (a + x, b + x * x));
            let weight = pixel[0].1;
            self.sums.variance += weight * (squares - sum * sum / n).max(0.0) / (n - 1.0);
            self.sums.own_squares += weight * weight * squares;
            self.sums.luminance += weight * sum;
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
            Some((own, _, sum)) if contribution.technique.t > 1 && *own == pixel => *sum += x,
            _ => {
                self.sums.splats += x * x;
                self.sums.luminance += x;
            }
        }
    }
}
