//! The pilot of [`Adaptive`](super::Adaptive): one run of bidirectional path tracing tells what every set of techniques would have cost and how noisy
//! it would have been (efficiency-aware multiple importance sampling: Grittmann, Yazici, Georgiev and Slusallek 2022).
//!
//! Each sample has one camera walk and two light walks, so that variances over light walks given the camera walk are known. A path x that technique j drew
//! has the value v = f/p_j and the ratios r_i = p_i/p_j. With n_i samples of technique i, a set C gives it the weight and the second moment
//!
//! ```text
//! w_i = (n_i r_i)^β / T,    T = Σ_{i ∈ C} (n_i r_i)^β,        E_C = Σ_{i ∈ C} (n_i r_i)^{2β-1} / T² · v²,
//! ```
//!
//! so sums of r^β and r^{2β-1} over each family are all that a path has to tell. E_C is estimated with the samples of all techniques, each with the weight that
//! it has in the pilot: what a set would find rarely and with huge values is seen here by whoever finds it easily.
//!
//! What the camera walk contributes to its own pixel is summed before it is squared, since it is correlated. With A from the camera walk alone and b_1, b_2
//! from its connections with each light walk, x = A + (b_1 + b_2)/2, D = (b_1 - b_2)², S = (b_1² + b_2²)/2, the variance with n light walks is
//!
//! ```text
//! Var x + (1/(2n) - 1/4) E D    for n ≥ 1,        Var x + E D / 4 + (1/n - 1) E S    for n < 1.
//! ```
//!
//! Var x comes from the set's own samples. Where Σ a², the sum of the squares of its single contributions, differs by more than a tenth from what E_C says that it
//! should be, rare contributions are missing or overrepresented in it, and the difference is made up for. Contributions through the lens are taken as independent of
//! all others. Variances are of luminance, mean over pixels.

use super::bidirectional::Kernel;
use super::{Bidirectional, Pilot};
use crate::endpoint::Camera;
use crate::film::{Contribution, FilmSample, Technique};
use crate::path::{Counters, Family, LightWalks, Path, PathDensities, Scratch, TechniqueSet};
use crate::sampler::{Independent, SampleSource, Sampler};
use crate::scene::Scene;
use std::sync::OnceLock;

/// Samples of each pixel that the pilot looks at: enough for a variance.
pub(super) const PASSES: u32 = 4;
/// Light walks per sample.
const WALKS: usize = 2;
/// Pixels per task.
const TASK: u64 = 4;
/// Independent parts of the pilot, which tell how certain it is.
pub(super) const GROUPS: usize = 8;
/// Techniques of longer paths are drawn but not told apart.
pub(super) const MOST_BOUNCES: u16 = 5;

/// A set of techniques and what the pilot says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The techniques and the number of light walks.
    pub set: TechniqueSet,
    /// Variance of one sample of a pixel's luminance, mean over pixels.
    pub variance: f64,
    /// Cost of one sample; see [`Counters::cost`].
    pub cost: f64,
}

impl Candidate {
    /// Variance × cost: the smaller the better.
    #[must_use]
    pub fn work(&self) -> f64 {
        self.variance * self.cost
    }
}

/// One technique in the pilot, with one light walk per camera walk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// Mean luminance of its weighted contributions.
    pub energy: f64,
    /// Second moment of its weighted contributions.
    pub square: f64,
    /// Cost of its connections.
    pub cost: f64,
}

/// Sums of one candidate.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Σ over pixels of the variance of x.
    variance: f64,
    /// Σ D and Σ S.
    difference: f64,
    square: f64,
    /// Σ of the squares of single contributions to the own pixel, from own samples and from all samples.
    direct: f64,
    robust: f64,
    /// The same through the lens, from all samples, and the mean.
    lens: f64,
    lens_mean: f64,
}

/// What has one value per sample or per pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Running {
    camera: f64,
    walks: [f64; WALKS],
    sum: f64,
    squares: f64,
}

/// A candidate's families as factors, and powers of its number of light walks.
struct Factors {
    hits: f64,
    sampling: f64,
    connections: f64,
    lens: f64,
    /// n, n^β and n^{2β-1}.
    walks: f64,
    weight: f64,
    moment: f64,
    lens_first: bool,
}

/// What the pilot found; sums over all its samples.
#[derive(Clone, Debug, Default)]
pub(super) struct Findings {
    sums: Vec<Sums>,
    pub shares: Vec<Share>,
    camera_walks: Counters,
    emitter_sampling: Counters,
    /// The same where lens sampling comes first.
    rest_walks: Counters,
    rest_sampling: Counters,
    light_walks: Counters,
    connections: Counters,
    lens: Counters,
    pub samples: u64,
}

/// What the kernel that runs a set costs relative to the general one: the dedicated ones, and lens sampling that comes first, have few weights or none.
pub(super) fn kernel_cost(set: &TechniqueSet) -> f64 {
    let dedicated = set.lens_first || !(set.has_camera_walk() && set.has_light_walk());
    if dedicated { Counters::DEDICATED } else { 1.0 }
}

/// Index of a technique among [`Findings::shares`].
pub(super) fn share_index(technique: Technique) -> Option<usize> {
    let bounces = (technique.s + technique.t).checked_sub(2).filter(|b| *b <= MOST_BOUNCES)?;
    Some(usize::from(bounces * (bounces + 3) / 2 + technique.s))
}

/// Runs the pilot for a number of pixels; returns its findings in a few independent groups.
pub(super) fn run<S: Scene + ?Sized, C: Camera + ?Sized>(
    integrator: &Bidirectional,
    candidates: &[TechniqueSet],
    scene: &S,
    camera: &C,
    pilot: &Pilot<'_>,
    pixels: u64,
) -> [Findings; GROUPS] {
    let walks = LightWalks::power_of_two(1).unwrap_or_default();
    let proxy = Bidirectional { techniques: TechniqueSet { light_walks: walks, ..integrator.techniques }, ..*integrator };
    let factors: Vec<Factors> = candidates.iter().map(|set| Factors::new(&proxy, set)).collect();
    let parts = in_parallel(pilot, pixels, |range, scratch| {
        let mut task = Task { findings: Findings::new(factors.len()), running: vec![Running::default(); factors.len()], factors: &factors };
        for site in range {
            for_each_sample(camera, pilot, site, pixels, 0, |film, sampler| task.sample(&proxy, scene, camera, film, sampler, scratch));
            task.end_pixel();
        }
        task.findings
    });
    let mut groups = std::array::from_fn(|_| Findings::new(candidates.len()));
    // Neighbours in different groups: each group sees all of the image.
    parts.iter().zip((0..GROUPS).cycle()).for_each(|(part, group)| groups[group].merge(part));
    groups
}

/// Splits the pixels into tasks and returns what each of them gave, in order.
pub(super) fn in_parallel<'s, S: Scene + ?Sized + 's, T: Send + Sync>(
    pilot: &Pilot<'_>,
    pixels: u64,
    task: impl Fn(std::ops::Range<u64>, &mut Scratch<'s, S>) -> T + Sync,
) -> Vec<T> {
    let slots: Vec<OnceLock<T>> = (0..pixels.div_ceil(TASK)).map(|_| OnceLock::new()).collect();
    (pilot.parallel)(slots.len(), &|i| {
        let first = i as u64 * TASK;
        slots[i].get_or_init(|| task(first..(first + TASK).min(pixels), &mut Scratch::default()));
    });
    slots.into_iter().filter_map(OnceLock::into_inner).collect()
}

/// The samples of one of the pixels that are spread over the window. Pass numbers run down from the largest, which no rendering reaches: so the samples
/// are independent of the rendering's.
pub(super) fn for_each_sample<C: Camera + ?Sized>(
    camera: &C,
    pilot: &Pilot<'_>,
    site: u64,
    sites: u64,
    round: u64,
    mut visit: impl FnMut(FilmSample, &mut <Independent as SampleSource>::Sampler),
) {
    let region = camera.film();
    let source = Independent { seed: pilot.seed };
    let first = (site + round * sites) * u64::from(PASSES);
    let pass = |i: u64| u32::MAX - ((first + i) % (1 << 31)) as u32;
    // One site in each part of the window, at random in it.
    let position = (site as f64 + source.sampler(0, pass(0)).next_1d()) / sites as f64;
    let pixel = ((position * f64::from(region.pixels())) as u32).min(region.pixels() - 1);
    for i in 0..u64::from(PASSES) {
        let mut sampler = source.sampler(pixel, pass(i));
        let film = FilmSample::draw(&region, pixel, pilot.kernel, &mut sampler);
        visit(film, &mut sampler);
    }
}

impl Factors {
    fn new(integrator: &Bidirectional, set: &TechniqueSet) -> Self {
        let on = |family: bool| f64::from(u8::from(family));
        let walks = set.light_walks.count();
        let weight = integrator.heuristic.raise(walks);
        Self {
            hits: on(set.emitter_hits),
            sampling: on(set.emitter_sampling),
            connections: on(set.connections),
            lens: on(set.lens_sampling),
            walks,
            weight,
            moment: weight * weight / walks,
            lens_first: set.lens_first,
        }
    }

    /// 1 / T for sums of r^β by family.
    fn inverse_total(&self, p: &[f64; 4]) -> f64 {
        let lens = self.weight * self.lens * p[3];
        1.0 / if self.leaves_to_lens(p) {
            lens
        } else {
            self.hits * p[0] + self.sampling * p[1] + self.weight * self.connections * p[2] + lens
        }
    }

    /// Whether only lens sampling draws the path.
    fn leaves_to_lens(&self, p: &[f64; 4]) -> bool {
        self.lens_first && p[3] > 0.0
    }
}

/// Index of a family among sums.
fn column(technique: Technique) -> usize {
    match Family::of(technique) {
        Family::EmitterSampling => 1,
        Family::Connections => 2,
        Family::LensSampling => 3,
        Family::EmitterHits | Family::UniformArea => 0,
    }
}

struct Task<'a> {
    findings: Findings,
    running: Vec<Running>,
    factors: &'a [Factors],
}

impl Task<'_> {
    fn sample<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler>(
        &mut self,
        proxy: &Bidirectional,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        scratch: &mut Scratch<'s, S>,
    ) {
        let kernel = Kernel::new(proxy, scene, camera, film);
        scratch.counters = Counters { samples: 1, ..Counters::default() };
        kernel.walk_from_camera(sampler, scratch);
        let counters = std::mem::take(&mut scratch.counters);
        self.findings.camera_walks += counters;
        self.findings.rest_walks += match scratch.camera.get(1) {
            Some(first) if first.dirac => counters,
            _ => Counters { closest_rays: 1, scattered: counters.scattered.min(1), ..counters },
        };
        for t in 2..=scratch.camera.len() {
            for s in 0..2 {
                self.join(&kernel, proxy, (s, t), 0, sampler, scratch);
            }
        }
        for walk in 0..kernel.draw_light_walks(sampler) as usize {
            kernel.walk_from_light(sampler, scratch);
            self.findings.light_walks += std::mem::take(&mut scratch.counters);
            for t in 1..=scratch.camera.len().max(1) {
                for s in if t == 1 { 1 } else { 2 }..=scratch.light.len() {
                    self.join(&kernel, proxy, (s, t), walk, sampler, scratch);
                }
            }
        }
        for (running, sums) in self.running.iter_mut().zip(&mut self.findings.sums) {
            let [b1, b2] = std::mem::take(&mut running.walks);
            let x = std::mem::take(&mut running.camera) + 0.5 * (b1 + b2);
            running.sum += x;
            running.squares += x * x;
            sums.difference += (b1 - b2) * (b1 - b2);
            sums.square += 0.5 * (b1 * b1 + b2 * b2);
        }
        self.findings.samples += 1;
    }

    fn end_pixel(&mut self) {
        let n = f64::from(PASSES);
        for (running, sums) in self.running.iter_mut().zip(&mut self.findings.sums) {
            sums.variance += (running.squares - running.sum * running.sum / n).max(0.0) / (n - 1.0);
            *running = Running::default();
        }
    }

    fn join<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler>(
        &mut self,
        kernel: &Kernel<'_, 's, S, C>,
        proxy: &Bidirectional,
        (s, t): (usize, usize),
        walk: usize,
        sampler: &mut P,
        scratch: &mut Scratch<'s, S>,
    ) {
        let technique = Technique { s: s as u16, t: t as u16 };
        kernel.join(s, t, sampler, scratch, &mut |path, _: &Contribution| self.see(proxy, path, walk));
        let counters = std::mem::take(&mut scratch.counters);
        let findings = &mut self.findings;
        match column(technique) {
            1 => {
                findings.emitter_sampling += counters;
                if scratch.camera.get(1).is_some_and(|first| first.dirac) {
                    findings.rest_sampling += counters;
                }
            }
            2 => findings.connections += counters,
            3 => findings.lens += counters,
            _ => {}
        }
        if let Some(index) = share_index(technique) {
            findings.shares[index].cost += counters.cost() / proxy.techniques.count(technique);
        }
    }

    /// Takes down a path that contributes.
    fn see<S: Scene + ?Sized, C: Camera + ?Sized>(&mut self, proxy: &Bidirectional, path: &Path<'_, '_, S, C>, walk: usize) {
        let (technique, heuristic) = (path.technique(), proxy.heuristic);
        let value = path.value().luminance();
        // Sums of r^β and r^{2β-1} by family.
        let (mut p, mut q) = ([0.0; 4], [0.0; 4]);
        let own = column(technique);
        (p[own], q[own]) = (1.0, 1.0);
        let densities = path.densities();
        densities.sweep(usize::from(technique.t), |t, ratio| {
            let other = densities.technique(t);
            if ratio > 0.0 && proxy.techniques.contains(other) {
                let raised = heuristic.raise(ratio);
                p[column(other)] += raised;
                q[column(other)] += raised * (raised / ratio);
            }
        });
        let count = proxy.techniques.count(technique);
        let proxy_walks = heuristic.raise(proxy.techniques.light_walks.count());
        let proxy_total = p[0] + p[1] + proxy_walks * (p[2] + p[3]);
        // The weight in the pilot, over the number of samples: what an average over all samples of all techniques takes.
        let in_proxy = heuristic.raise(count) / proxy_total / count;
        if !(value.is_finite() && in_proxy.is_finite() && q.iter().all(|q| q.is_finite())) {
            return;
        }
        let plain = value / p.iter().sum::<f64>();
        if let Some(share) = share_index(technique).map(|index| &mut self.findings.shares[index]) {
            share.energy += plain / count;
            share.square += plain * plain / count;
        }
        let moment = in_proxy * value * value;
        for ((factors, running), sums) in self.factors.iter().zip(&mut self.running).zip(&mut self.findings.sums) {
            let inverse = factors.inverse_total(&p);
            if !inverse.is_finite() {
                continue;
            }
            let square = moment * inverse * inverse;
            sums.lens += square * factors.moment * factors.lens * q[3];
            if factors.leaves_to_lens(&p) && own != 3 {
                continue;
            }
            if !factors.leaves_to_lens(&p) {
                sums.robust += square * (factors.hits * q[0] + factors.sampling * q[1] + factors.moment * factors.connections * q[2]);
            }
            match own {
                0 | 1 => {
                    let x = if own == 0 { factors.hits } else { factors.sampling } * value * inverse;
                    running.camera += x;
                    sums.direct += x * x;
                }
                2 => {
                    let x = factors.connections * factors.weight * value * inverse;
                    running.walks[walk] += x;
                    // One walk of `count`; of n walks each contributes 1/n of that.
                    sums.direct += x * x / (count * factors.walks);
                }
                _ => sums.lens_mean += factors.lens * factors.weight * value * inverse / count,
            }
        }
    }
}

impl Findings {
    pub fn new(candidates: usize) -> Self {
        let shares = vec![Share::default(); share_index(Technique { s: MOST_BOUNCES + 1, t: 1 }).map_or(0, |last| last + 1)];
        Self { sums: vec![Sums::default(); candidates], shares, ..Self::default() }
    }

    pub fn merge(&mut self, other: &Self) {
        for (a, b) in self.sums.iter_mut().zip(&other.sums) {
            a.variance += b.variance;
            a.difference += b.difference;
            a.square += b.square;
            a.direct += b.direct;
            a.robust += b.robust;
            a.lens += b.lens;
            a.lens_mean += b.lens_mean;
        }
        for (a, b) in self.shares.iter_mut().zip(&other.shares) {
            a.energy += b.energy;
            a.square += b.square;
            a.cost += b.cost;
        }
        self.camera_walks += other.camera_walks;
        self.emitter_sampling += other.emitter_sampling;
        self.rest_walks += other.rest_walks;
        self.rest_sampling += other.rest_sampling;
        self.light_walks += other.light_walks;
        self.connections += other.connections;
        self.lens += other.lens;
        self.samples += other.samples;
    }

    /// Everything that the pilot did.
    pub fn counters(&self) -> Counters {
        let mut all = self.camera_walks;
        for part in [&self.emitter_sampling, &self.light_walks, &self.connections, &self.lens] {
            all += *part;
        }
        all
    }

    /// Cost of the camera walk and of one light walk, per sample.
    pub fn walk_costs(&self) -> [f64; 2] {
        let n = self.samples.max(1) as f64;
        [self.camera_walks.cost() / n, self.light_walks.cost() / (n * WALKS as f64)]
    }

    /// Variance and cost of a candidate.
    pub fn candidate(&self, index: usize, set: TechniqueSet, film_pixels: u32) -> Candidate {
        let (sums, samples) = (&self.sums[index], self.samples.max(1) as f64);
        let n = set.light_walks.count();
        let (difference, square) = (sums.difference / samples, sums.square / samples);
        let more = if n >= 1.0 { (0.5 / n - 0.25) * difference } else { 0.25 * difference + (1.0 / n - 1.0) * square };
        let seen = (sums.variance * f64::from(PASSES) / samples + more).max(0.0);
        let (direct, robust) = (sums.direct / samples, sums.robust / samples);
        let own = if (robust - direct).abs() <= 0.1 * robust.max(direct) {
            seen
        } else if robust > direct {
            seen + (robust - direct)
        } else {
            seen * (robust / direct)
        };
        let mean = sums.lens_mean / samples;
        let lens = (sums.lens / samples - mean * mean / (n * f64::from(film_pixels.max(1)))).max(0.0);
        let cost = |counters: &Counters, share: f64| share * counters.cost() / samples;
        let light = |counters: &Counters| cost(counters, n / WALKS as f64);
        let (walks, sampling) =
            if set.lens_first { (&self.rest_walks, &self.rest_sampling) } else { (&self.camera_walks, &self.emitter_sampling) };
        let total = [
            // The cost of a sample is in that of its camera walk.
            if set.has_camera_walk() { cost(walks, 1.0) } else { Counters::SAMPLE_COST },
            if set.emitter_sampling { cost(sampling, 1.0) } else { 0.0 },
            if set.has_light_walk() { light(&self.light_walks) } else { 0.0 },
            if set.connections { light(&self.connections) } else { 0.0 },
            if set.lens_sampling { light(&self.lens) } else { 0.0 },
        ];
        Candidate { set, variance: own + lens, cost: total.iter().sum::<f64>() * kernel_cost(&set) }
    }
}
