//! The finished runs of one integrator: images, costs, errors, and its efficiency.

use super::batches::{Batch, Layout};
use super::evidence::Undecided;
use super::interval::Interval;
use super::metrics::{Errors, mean_image};
use super::reference::Reference;
use super::tail::Tail;
use crate::film::Image;
use crate::integrator::Estimator;
use crate::math::Rgb;
use crate::math::statistics::Estimate;
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// The relative standard error of the mean squared error above which the noise of an image is
/// dominated by a handful of contributions.
const LARGEST_RELATIVE_ERROR: f64 = 0.2;
/// Tails are long if the relative mean squared error is known no better than this.
const LONG_TAILS: f64 = 0.05;

/// Time and work of a rendering up to a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Wall-clock seconds; NaN in a report without clocks.
    #[serde(with = "super::number")]
    pub wall: f64,
    /// Processor seconds of the process, all threads together; NaN in a report without clocks.
    #[serde(with = "super::number")]
    pub cpu: f64,
    /// Rays.
    pub rays: f64,
    /// Scattering vertices sampled.
    pub scattered: f64,
}

impl Cost {
    /// The work without the time that it took.
    pub(in crate::report) fn without_clocks(self) -> Self {
        Self { wall: f64::NAN, cpu: f64::NAN, ..self }
    }
}

impl AddAssign for Cost {
    fn add_assign(&mut self, other: Self) {
        self.wall += other.wall;
        self.cpu += other.cpu;
        self.rays += other.rays;
        self.scattered += other.scattered;
    }
}

/// Efficiency over that of the baseline: ratios of variance × cost with runs paired by seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedUp {
    /// The ratio in wall-clock time.
    pub wall: Interval,
    /// The ratio in processor time.
    pub cpu: Interval,
    /// The ratio in rays: does not depend on the machine.
    pub rays: Interval,
}

/// The finished runs of one integrator.
pub(in crate::report) struct Measured {
    pub name: String,
    /// True if it claims to draw every path.
    pub complete: bool,
    /// The kind of mean that it claims to have.
    pub estimator: Estimator,
    /// True if samples of one run depend on one another.
    pub is_correlated: bool,
    /// Samples per pixel of each run.
    pub samples: u32,
    pub marks: Vec<Mark>,
    /// The image of each run.
    pub finals: Vec<Image>,
    pub batches: Vec<Batch>,
    pub tail: Option<Tail>,
}

/// All runs at one checkpoint.
pub(in crate::report) struct Mark {
    pub samples: u32,
    pub costs: Vec<Cost>,
    pub errors: Vec<Errors>,
    /// The errors of each pair of runs, split: the first and the second, the third and the fourth ….
    pub splits: Vec<Split>,
    /// I - R of the run that has no partner yet.
    single: Option<Image>,
}

/// The mean squared error of two independent runs in its two parts, means over pixels and channels.
///
/// With the deviations d = I - R of the runs, `(d_1² + d_2²)/2 = (d_1 - d_2)²/2 + d_1 d_2`, whose
/// expectations are variance and squared bias, whatever pixels of a run have to do with each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// Variance of a run.
    #[serde(with = "super::number")]
    pub variance: f64,
    /// Squared bias, the reference's own variance subtracted.
    #[serde(with = "super::number")]
    pub squared_bias: f64,
}

impl Split {
    fn of(deviations: [&Image; 2], own_mse: f64) -> Self {
        let [mut variance, mut squared_bias] = [0.0; 2];
        for (a, b) in deviations[0].pixels().iter().zip(deviations[1].pixels()) {
            let difference = *a - *b;
            variance += 0.5 * (difference * difference).mean();
            squared_bias += (*a * *b).mean();
        }
        let pixels = deviations[0].pixels().len().max(1) as f64;
        Self { variance: variance / pixels, squared_bias: squared_bias / pixels - own_mse }
    }
}

impl Mark {
    fn new(samples: u32) -> Self {
        Self { samples, costs: Vec::new(), errors: Vec::new(), splits: Vec::new(), single: None }
    }

    fn add(&mut self, cost: Cost, image: &Image, reference: &Reference) {
        self.costs.push(cost);
        self.errors.push(Errors::of(image, reference));
        let mut deviation = image.clone();
        let pixels = deviation.pixels_mut().iter_mut().zip(reference.image().pixels());
        pixels.for_each(|(d, r)| *d = *d - *r);
        match self.single.take() {
            None => self.single = Some(deviation),
            Some(first) => {
                self.splits.push(Split::of([&first, &deviation], reference.own_mse()));
            }
        }
    }
}

impl Measured {
    /// An integrator without runs yet.
    pub fn new(
        name: String,
        complete: bool,
        estimator: Estimator,
        is_correlated: bool,
        samples: u32,
    ) -> Self {
        Self {
            name,
            complete,
            estimator,
            is_correlated,
            samples,
            marks: Vec::new(),
            finals: Vec::new(),
            batches: Vec::new(),
            tail: None,
        }
    }

    /// Adds a run as samples per pixel, cost and image at each checkpoint; the last is the whole.
    pub fn add(&mut self, run: Vec<(u32, Cost, Image)>, reference: &Reference) {
        for (index, (samples, cost, image)) in run.into_iter().enumerate() {
            if self.marks.len() == index {
                self.marks.push(Mark::new(samples));
            }
            self.marks[index].add(cost, &image, reference);
            if samples == self.samples {
                self.finals.push(image);
            }
        }
    }

    /// True if its mean must be that of the others: it claims to draw every path, and to be unbiased.
    pub fn is_tested(&self) -> bool {
        self.complete && self.estimator == Estimator::Unbiased
    }

    /// The reason why its mean is no evidence; `None` if it is.
    pub fn undecided(&self) -> Option<Undecided> {
        let image = self.finals.first()?;
        let weights = Layout::of(image).uniform_weights();
        Undecided::of_sum(&self.batches, &weights, image.pixels().len())
    }

    /// Mean of all runs; without any, an image without pixels.
    pub fn mean(&self) -> Image {
        mean_image(&self.finals).unwrap_or_else(|| Image::from_fn(0, 0, |_, _| Rgb::BLACK))
    }

    /// Costs of the runs, in the order of seeds.
    pub fn costs(&self) -> &[Cost] {
        self.marks.last().map_or(&[], |mark| &mark.costs)
    }

    /// Errors of the runs, in the order of seeds.
    pub fn errors(&self) -> &[Errors] {
        self.marks.last().map_or(&[], |mark| &mark.errors)
    }

    /// Samples of all runs and pixels.
    pub fn all_samples(&self) -> f64 {
        f64::from(self.samples)
            * self.finals.iter().map(|image| image.pixels().len() as f64).sum::<f64>()
    }

    /// Variance of one sample per pixel as each run shows it, mean over pixels and channels.
    pub fn variances(&self) -> Vec<f64> {
        let (runs, mean) = (self.finals.len() as f64, self.mean());
        let correction = if runs > 1.0 { runs / (runs - 1.0) } else { f64::NAN };
        let spread = |image: &Image| {
            let squares = image
                .pixels()
                .iter()
                .zip(mean.pixels())
                .map(|(i, m)| ((*i - *m) * (*i - *m)).mean());
            squares.sum::<f64>() / image.pixels().len().max(1) as f64
        };
        self.finals
            .iter()
            .map(|image| spread(image) * correction * f64::from(self.samples))
            .collect()
    }

    /// A sample's variance times what a sample costs, for each run.
    pub fn products(&self, cost: fn(&Cost) -> f64) -> Vec<f64> {
        let variances = self.variances();
        variances
            .iter()
            .zip(self.costs())
            .map(|(v, c)| v * cost(c) / f64::from(self.samples))
            .collect()
    }

    /// Efficiency over that of another, with runs paired by seed.
    pub fn speed_up(&self, over: &Self) -> Option<SpeedUp> {
        let ratio = |cost: fn(&Cost) -> f64| {
            let (base, own) = (over.products(cost), self.products(cost));
            Interval::of_ratios(&base.iter().zip(own).map(|(b, m)| b / m).collect::<Vec<_>>())
        };
        let wall = ratio(|c| c.wall)?;
        Some(SpeedUp { wall, cpu: ratio(|c| c.cpu).unwrap_or(wall), rays: ratio(|c| c.rays)? })
    }

    /// Relative standard error of an error over the runs; 0 if there is no error, infinite for a
    /// single run.
    fn uncertainty(&self, measure: fn(&Errors) -> f64) -> f64 {
        let runs: Estimate = self.errors().iter().map(measure).collect();
        if runs.count() < 2 {
            return f64::INFINITY;
        }
        if runs.mean() > 0.0 { runs.standard_error() / runs.mean() } else { 0.0 }
    }

    /// True if not even its mean squared error is known, so that a mean that is too dark says
    /// nothing.
    pub fn has_open_mean(&self) -> bool {
        self.uncertainty(|e| e.mse) > LARGEST_RELATIVE_ERROR
    }

    /// True if rare, large contributions make up much of the relative variance, so that even all
    /// runs together do not know it well. Then whoever missed them in a block has too small a mean
    /// *and* too small a variance there, and no test can tell that from missing light.
    pub fn has_long_tails(&self) -> bool {
        self.uncertainty(|e| e.relative_mse) > LONG_TAILS
    }

    /// True if the tail says that the variance is infinite.
    pub fn has_infinite_variance(&self) -> bool {
        self.tail.is_some_and(|tail| tail.is_infinite_variance())
    }
}
