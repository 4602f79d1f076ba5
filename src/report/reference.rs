//! The image that errors are measured against, and how wrong it is itself.
//!
//! It is exact where a closed form is known. Else it is rendered by two different integrators with
//! seeds of their own in several runs each; their spread gives its variance, which is subtracted
//! from squared errors. The halves are weighted by the inverse of their variances.

use super::batches::{Batch, BatchMean, Layout};
use super::error::ReportError;
use super::method::Contestant;
use super::metrics::{RELATIVE_EPSILON, ratio};
use super::runs::run_seed;
use super::study::Step;
use crate::endpoint::Camera;
use crate::film::{Image, ImageFile};
use crate::math::Rgb;
use crate::render::{Budget, Settings};
use crate::scene::Scene;
use std::ops::ControlFlow;
use std::path::Path;

/// A reference image.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    image: Image,
    /// Variance of each pixel.
    variance: Image,
    origin: String,
    /// Weight and batches of each half; none if the image is taken as exact.
    halves: Vec<(f64, Vec<Batch>)>,
    /// Mean over pixels and channels.
    scale: f64,
    own_mse: f64,
    own_relative_mse: f64,
}

/// How to render a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferencePlan {
    /// For both halves together.
    pub budget: Budget,
    /// Runs of each half; at least two.
    pub runs: u32,
    /// Filter, sampler, threads, and the seed that its own are derived from. Its budget and target
    /// error are not used.
    pub settings: Settings,
}

impl Reference {
    /// An image that is known exactly.
    ///
    /// # Errors
    /// If it has no pixels or some that are not finite.
    pub fn exact(image: Image) -> Result<Self, ReportError> {
        let variance = Image::from_fn(image.width(), image.height(), |_, _| Rgb::BLACK);
        Self::new(image, variance, "exact".to_owned(), Vec::new())
    }

    /// An image from a file, taken as exact.
    ///
    /// # Errors
    /// If it cannot be read, has no pixels or some that are not finite.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ReportError> {
        let path = path.as_ref();
        let image = ImageFile::load(path)?.image;
        Ok(Self { origin: format!("{}, taken as exact", path.display()), ..Self::exact(image)? })
    }

    /// Renders with two integrators, which must see every path and should be different ones.
    ///
    /// # Errors
    /// If a rendering fails, the plan has fewer than two runs, or `progress` stops before each half
    /// has two.
    pub fn render<S: Scene + ?Sized>(
        scene: &S,
        camera: &dyn Camera,
        halves: [&Contestant<'_, S>; 2],
        plan: &ReferencePlan,
        progress: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
    ) -> Result<Self, ReportError> {
        if plan.runs < 2 {
            return Err(ReportError::TooFewSeeds(plan.runs));
        }
        let budget = match plan.budget {
            Budget::Samples(samples) => Budget::Samples((samples / 2 / plan.runs).max(1)),
            Budget::Time(time) => Budget::Time(time / (2 * plan.runs)),
        };
        let mut sums = [Moments::default(), Moments::default()];
        let total = f64::from(2 * plan.runs);
        'runs: for run in 0..plan.runs {
            for (half, moments) in sums.iter_mut().enumerate() {
                let done = f64::from(2 * run) + half as f64;
                // Streams of random numbers that no study uses.
                let seed = run_seed(plan.settings.seed, 1000 + half as u64, run);
                let settings = Settings { budget, seed, target_error: None, ..plan.settings };
                let mut stopped = false;
                let rendering = halves[half]
                    .method
                    .render(scene, camera, &settings, &mut |p| {
                        let flow = progress(&Step {
                            label: "reference",
                            fraction: (done + p.fraction) / total,
                        });
                        stopped |= flow.is_break();
                        flow
                    })
                    .map_err(|source| ReportError::Render {
                        name: halves[half].name.clone(),
                        source,
                    })?;
                moments.add(&rendering.image, rendering.samples_per_pixel);
                if stopped {
                    break 'runs;
                }
            }
        }
        let names = halves.map(|half| half.name.as_str());
        if sums.iter().any(|half| half.batches.len() < 2) {
            return Err(ReportError::ReferenceStopped);
        }
        Self::combine(names, sums)
    }

    fn combine(names: [&str; 2], halves: [Moments; 2]) -> Result<Self, ReportError> {
        let [(a, va), (b, vb)] = [halves[0].mean_and_variance(), halves[1].mean_and_variance()];
        let (mean_a, mean_b) = (va.mean().mean(), vb.mean().mean());
        let p = if mean_a + mean_b > 0.0 { mean_b / (mean_a + mean_b) } else { 0.5 };
        let q = 1.0 - p;
        let blend = |x: &Image, y: &Image, p: f64, q: f64| {
            let pixels = x.pixels().iter().zip(y.pixels()).map(|(x, y)| *x * p + *y * q).collect();
            Image::new(x.width(), x.height(), pixels).unwrap_or_else(|| x.clone())
        };
        let (image, variance) = (blend(&a, &b, p, q), blend(&va, &vb, p * p, q * q));
        let weights = Layout::of(&image).uniform_weights();
        let samples = [0, 1].map(|i| halves[i].samples);
        let [first, second] = halves.map(|half| half.batches);
        let gap =
            BatchMean::of_sum(&first, &weights).plus(BatchMean::of_sum(&second, &weights), -1.0);
        let origin = format!(
            "{} ({} samples per pixel, weight {p:.2}) and {} ({}); standard error {:.2e} per pixel and channel; the means of the halves differ by {:+.2} standard errors",
            names[0],
            samples[0],
            names[1],
            samples[1],
            variance.mean().mean().sqrt(),
            ratio(gap.mean, gap.standard_error()),
        );
        Self::new(image, variance, origin, vec![(p, first), (q, second)])
    }

    pub(super) fn new(
        image: Image,
        variance: Image,
        origin: String,
        halves: Vec<(f64, Vec<Batch>)>,
    ) -> Result<Self, ReportError> {
        if image.pixels().is_empty() {
            return Err(ReportError::ReferenceEmpty);
        }
        match image.pixels().iter().filter(|p| !p.is_finite()).count() {
            0 => {}
            bad => return Err(ReportError::ReferenceNotFinite(bad)),
        }
        let scale = image.mean().mean();
        let epsilon = RELATIVE_EPSILON * scale * scale;
        let n = 3.0 * image.pixels().len() as f64;
        let pairs = || {
            variance
                .pixels()
                .iter()
                .zip(image.pixels())
                .flat_map(|(v, r)| (0..3).map(|c| (v[c], r[c])))
        };
        let own_mse = pairs().map(|(v, _)| v).sum::<f64>() / n;
        let own_relative_mse = pairs().map(|(v, r)| ratio(v, r * r + epsilon)).sum::<f64>() / n;
        Ok(Self { image, variance, origin, halves, scale, own_mse, own_relative_mse })
    }

    /// The image.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Variance of each pixel; zero if the image is taken as exact.
    #[must_use]
    pub fn variance(&self) -> &Image {
        &self.variance
    }

    /// Where it comes from and how good it is, for people.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Whether it is taken as exact.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.halves.is_empty()
    }

    /// Mean over pixels and channels.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Its own mean squared error.
    #[must_use]
    pub fn own_mse(&self) -> f64 {
        self.own_mse
    }

    /// Its own relative mean squared error.
    #[must_use]
    pub fn own_relative_mse(&self) -> f64 {
        self.own_relative_mse
    }

    pub(super) fn halves(&self) -> &[(f64, Vec<Batch>)] {
        &self.halves
    }

    /// A weighted sum over blocks of mean luminance.
    #[must_use]
    pub fn block_sum(&self, weights: &[f64]) -> BatchMean {
        if self.is_exact() {
            let blocks = Layout::of(&self.image).block_means(&self.image);
            return BatchMean::exact(Batch { samples: 1.0, blocks }.sum(weights));
        }
        let parts = self
            .halves
            .iter()
            .map(|(weight, batches)| BatchMean::of_sum(batches, weights).scaled(*weight));
        parts.reduce(|a, b| a.plus(b, 1.0)).unwrap_or(BatchMean::exact(0.0))
    }

    /// Weights of the blocks that make a bias proportional to the image most visible: value /
    /// variance (the best linear statistic), with the variance as the reference has it, kept above
    /// 1 % of the typical one so that blocks without noise do not decide alone. The weighted sum of
    /// the reference is 1. Uniform for an exact reference, whose noise is unknown.
    #[must_use]
    pub fn bias_weights(&self) -> Vec<f64> {
        let layout = Layout::of(&self.image);
        let means = layout.block_means(&self.image);
        let mut weights: Vec<f64> = (0..layout.blocks()).map(|b| layout.pixels(b)).collect();
        if !self.is_exact() {
            let mut one = vec![0.0; layout.blocks()];
            let relative: Vec<f64> = (0..layout.blocks())
                .map(|block| {
                    one[block] = 1.0;
                    let variance = self.block_sum(&one).variance;
                    one[block] = 0.0;
                    if means[block] > 0.0 {
                        variance / (means[block] * means[block])
                    } else {
                        f64::INFINITY
                    }
                })
                .collect();
            let mut sorted: Vec<f64> = relative.iter().copied().filter(|r| r.is_finite()).collect();
            sorted.sort_by(f64::total_cmp);
            let typical = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
            if typical > 0.0 {
                for ((weight, relative), mean) in weights.iter_mut().zip(&relative).zip(&means) {
                    *weight =
                        if *mean > 0.0 { 1.0 / (relative.max(0.01 * typical) * mean) } else { 0.0 };
                }
            }
        }
        let sum: f64 = weights.iter().zip(&means).map(|(w, m)| w * m).sum();
        weights.iter().map(|w| ratio(*w, sum)).collect()
    }
}

impl Layout {
    /// Weights that make a sum over blocks the mean over pixels.
    #[must_use]
    pub fn uniform_weights(&self) -> Vec<f64> {
        let pixels = f64::from(self.width) * f64::from(self.height);
        (0..self.blocks()).map(|block| self.pixels(block) / pixels).collect()
    }
}

/// Sums over runs of different length.
#[derive(Default)]
struct Moments {
    sums: Option<(Image, Image)>,
    samples: f64,
    batches: Vec<Batch>,
}

impl Moments {
    fn add(&mut self, image: &Image, samples: u32) {
        let n = f64::from(samples);
        let black = || Image::from_fn(image.width(), image.height(), |_, _| Rgb::BLACK);
        let (sums, squares) = self.sums.get_or_insert_with(|| (black(), black()));
        for ((sum, square), pixel) in
            sums.pixels_mut().iter_mut().zip(squares.pixels_mut()).zip(image.pixels())
        {
            *sum += *pixel * n;
            *square += *pixel * *pixel * n;
        }
        self.samples += n;
        self.batches.push(Batch { samples: n, blocks: Layout::of(image).block_means(image) });
    }

    fn mean_and_variance(&self) -> (Image, Image) {
        let Some((sums, squares)) = &self.sums else {
            return (
                Image::from_fn(0, 0, |_, _| Rgb::BLACK),
                Image::from_fn(0, 0, |_, _| Rgb::BLACK),
            );
        };
        let (mut mean, mut variance) = (sums.clone(), squares.clone());
        let freedom = self.batches.len() as f64 - 1.0;
        mean.pixels_mut().iter_mut().for_each(|p| *p = *p / self.samples);
        for (square, mean) in variance.pixels_mut().iter_mut().zip(mean.pixels()) {
            // The difference of two large numbers may round below zero.
            *square = ((*square - *mean * *mean * self.samples) / (freedom * self.samples))
                .map(|v| v.max(0.0));
        }
        (mean, variance)
    }
}
