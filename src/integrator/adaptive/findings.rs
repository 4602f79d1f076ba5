//! What the pilot's paths say of every set of techniques, by one formula for all.
//!
//! A path x that technique j drew has the value v = f/p_j and the ratios r_i = p_i/p_j. With n_i
//! samples of technique i, a set C gives it the weight and the second moment
//!
//! ```text
//! w_i = (n_i r_i)^β / T,    T = Σ_{i ∈ C} (n_i r_i)^β,        E_C = Σ_{i ∈ C} (n_i r_i)^{2β-1} / T² · v²,
//! ```
//!
//! so sums of r^β and r^{2β-1} over each family are all that a path has to tell. E_C is estimated
//! with the samples of all techniques, each with the weight that it has in the pilot: what a set
//! would find rarely and with huge values is seen here by whoever finds it easily.
//!
//! What the camera walk contributes to its own pixel is summed before it is squared, since it is
//! correlated. With A from the camera walk alone and b_1, b_2 from its connections with each light
//! walk, x = A + (b_1 + b_2)/2, D = (b_1 - b_2)², S = (b_1² + b_2²)/2, the variance with n light
//! walks is
//!
//! ```text
//! V + E D / (2n)    for n ≥ 1,        V + E D / 2 + (1/n - 1) E S    for n < 1,        V = Var x - E D / 4.
//! ```
//!
//! Var x comes from the set's own samples. Where Σ a², the sum of the squares of its single
//! contributions, differs by more than a tenth from what E_C says that it should be, rare
//! contributions are missing or overrepresented in it, and the difference is made up for.
//! Contributions through the lens are taken as independent of all others. Variances are of
//! luminance, mean over pixels.

use super::pilot::{PASSES, WALKS};
use crate::film::Technique;
use crate::path::{Counters, Heuristic, TechniqueSet};

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
    /// Σ of the squares of single contributions to the own pixel, from own samples and from all
    /// samples.
    direct: f64,
    robust: f64,
    /// The same through the lens, from all samples, and the mean.
    lens: f64,
    lens_mean: f64,
}

/// A path that contributed, as every candidate has to know it.
pub(super) struct Seen {
    /// Index of the family that drew it.
    pub family: usize,
    /// With which light walk, and how many samples its technique has.
    pub walk: usize,
    pub count: f64,
    /// f/p, and its square with the weight that an average over all samples of all techniques gives
    /// it.
    pub value: f64,
    pub moment: f64,
    /// Sums of r^β and r^{2β-1} by family.
    pub p: [f64; 4],
    pub q: [f64; 4],
}

/// A candidate's families as factors 0 or 1, and powers of its number of light walks.
pub(super) struct Factors {
    families: [f64; 4],
    /// n, n^β and n^{2β-1}.
    walks: f64,
    weight: f64,
    moment: f64,
    lens_first: bool,
}

impl Factors {
    pub fn new(heuristic: Heuristic, set: &TechniqueSet) -> Self {
        let on = |family: bool| f64::from(u8::from(family));
        let walks = set.light_walks.count();
        let weight = heuristic.raise(walks);
        Self {
            families: [set.emitter_hits, set.emitter_sampling, set.connections, set.lens_sampling]
                .map(on),
            walks,
            weight,
            moment: weight * weight / walks,
            lens_first: set.lens_first,
        }
    }

    /// The families that draw a path.
    fn families(&self, seen: &Seen) -> [f64; 4] {
        if self.lens_first && seen.p[3] > 0.0 { [0.0, 0.0, 0.0, 1.0] } else { self.families }
    }
}

/// What the pilot found; sums over all its samples.
#[derive(Clone, Debug, Default)]
pub(super) struct Findings {
    sums: Vec<Sums>,
    pub shares: Vec<Share>,
    pub camera_walks: Counters,
    pub emitter_sampling: Counters,
    /// The same where lens sampling comes first.
    pub rest_walks: Counters,
    pub rest_sampling: Counters,
    pub light_walks: Counters,
    pub connections: Counters,
    pub lens: Counters,
    pub samples: u64,
}

/// What has one value per sample or per pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Running {
    camera: f64,
    walks: [f64; WALKS],
    sum: f64,
    squares: f64,
}

/// Takes down paths, pixel by pixel.
pub(super) struct Tally<'a> {
    pub findings: Findings,
    running: Vec<Running>,
    factors: &'a [Factors],
}

impl<'a> Tally<'a> {
    pub fn new(factors: &'a [Factors]) -> Self {
        Self {
            findings: Findings::new(factors.len()),
            running: vec![Running::default(); factors.len()],
            factors,
        }
    }

    /// A path that contributes.
    pub fn see(&mut self, seen: &Seen) {
        let Seen { p, q, .. } = seen;
        for ((factors, running), sums) in
            self.factors.iter().zip(&mut self.running).zip(&mut self.findings.sums)
        {
            let on = factors.families(seen);
            let inverse = 1.0
                / (on[0] * p[0] + on[1] * p[1] + factors.weight * (on[2] * p[2] + on[3] * p[3]));
            if !inverse.is_finite() {
                continue;
            }
            let square = seen.moment * inverse * inverse;
            sums.lens += square * factors.moment * on[3] * q[3];
            sums.robust += square * (on[0] * q[0] + on[1] * q[1] + factors.moment * on[2] * q[2]);
            let x = on[seen.family] * seen.value * inverse;
            match seen.family {
                0 | 1 => {
                    running.camera += x;
                    sums.direct += x * x;
                }
                2 => {
                    let x = factors.weight * x;
                    running.walks[seen.walk] += x;
                    // One walk of `count`; of n walks each contributes 1/n of that.
                    sums.direct += x * x / (seen.count * factors.walks);
                }
                _ => sums.lens_mean += factors.weight * x / seen.count,
            }
        }
    }

    pub fn end_sample(&mut self) {
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

    pub fn end_pixel(&mut self) {
        let n = f64::from(PASSES);
        for (running, sums) in self.running.iter_mut().zip(&mut self.findings.sums) {
            sums.variance += (running.squares - running.sum * running.sum / n).max(0.0) / (n - 1.0);
            *running = Running::default();
        }
    }
}

/// Index of a technique among [`Findings::shares`].
pub(super) fn share_index(technique: Technique) -> Option<usize> {
    let bounces = (technique.s + technique.t).checked_sub(2).filter(|b| *b <= MOST_BOUNCES)?;
    Some(usize::from(bounces * (bounces + 3) / 2 + technique.s))
}

impl Findings {
    pub fn new(candidates: usize) -> Self {
        let shares = vec![
            Share::default();
            share_index(Technique { s: MOST_BOUNCES + 1, t: 1 })
                .map_or(0, |last| last + 1)
        ];
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
        // Not negative each for itself: noise must not cancel what light walks add.
        let camera = (sums.variance * f64::from(PASSES) / samples - 0.25 * difference).max(0.0);
        let seen = camera
            + if n >= 1.0 {
                0.5 / n * difference
            } else {
                0.5 * difference + (1.0 / n - 1.0) * square
            };
        let (direct, robust) = (sums.direct / samples, sums.robust / samples);
        let own = if (robust - direct).abs() <= 0.1 * robust.max(direct) {
            seen
        } else if robust > direct {
            seen + (robust - direct)
        } else {
            seen * (robust / direct)
        };
        let mean = sums.lens_mean / samples;
        let lens =
            (sums.lens / samples - mean * mean / (n * f64::from(film_pixels.max(1)))).max(0.0);
        let cost = |counters: &Counters, share: f64| share * counters.cost() / samples;
        let light = |counters: &Counters| cost(counters, n / WALKS as f64);
        let (walks, sampling) = if set.lens_first {
            (&self.rest_walks, &self.rest_sampling)
        } else {
            (&self.camera_walks, &self.emitter_sampling)
        };
        let total = [
            if set.has_camera_walk() { cost(walks, 1.0) } else { 0.0 },
            if set.emitter_sampling { cost(sampling, 1.0) } else { 0.0 },
            if set.has_light_walk() { light(&self.light_walks) } else { 0.0 },
            if set.connections { light(&self.connections) } else { 0.0 },
            if set.lens_sampling { light(&self.lens) } else { 0.0 },
        ];
        Candidate { set, variance: own + lens, cost: total.iter().sum::<f64>() * set.kernel_cost() }
    }
}
