//! The image that errors are measured against, and how wrong it is itself.
//!
//! It is exact where a closed form is known. Else it is rendered by two different integrators with
//! seeds of their own in several runs each; their spread gives its variance, which is subtracted
//! from squared errors. The halves are weighted by the inverse of their variances.

use super::batches::{Batch, BatchMean, Layout};
use super::evidence::Undecided;
use crate::film::Image;
use crate::math::Rgb;
use crate::report::error::ReportError;

/// The part of the squared mean of the reference that is added to the denominator of relMSE, and of
/// the mean for MAPE.
pub const RELATIVE_EPSILON: f64 = 0.01;

/// A reference image.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    image: Image,
    /// Variance of each pixel.
    variance: Image,
    origin: String,
    missing: Vec<String>,
    /// Weight and batches of each half; none if the image is taken as exact.
    halves: Vec<(f64, Vec<Batch>)>,
    /// Mean over pixels and channels.
    scale: f64,
    own_mse: f64,
    own_relative_mse: f64,
}

impl Reference {
    /// An image that is known exactly.
    ///
    /// # Errors
    /// If it has no pixels or some that are not finite.
    pub fn exact(image: Image) -> Result<Self, ReportError> {
        Self::known(image, "exact".to_owned())
    }

    /// The same with a word on where it comes from.
    pub(in crate::report) fn known(image: Image, origin: String) -> Result<Self, ReportError> {
        let variance = Image::from_fn(image.width(), image.height(), |_, _| Rgb::BLACK);
        Self::new(image, variance, origin, Vec::new())
    }

    pub(in crate::report) fn new(
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
        let missing = Vec::new();
        Ok(Self { image, variance, origin, missing, halves, scale, own_mse, own_relative_mse })
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

    /// Its source and its quality, for people.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Paths that only integrators which merge draw, and that are missing here, in words.
    #[must_use]
    pub fn missing(&self) -> &[String] {
        &self.missing
    }

    /// The same reference, with a note on what is missing.
    pub(in crate::report) fn without(self, missing: Vec<String>) -> Self {
        Self { missing, ..self }
    }

    /// True if it is taken as exact.
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

    pub(in crate::report) fn halves(&self) -> &[(f64, Vec<Batch>)] {
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

    /// The reason why it is no measure: it has met too little. `None` if it is one.
    #[must_use]
    pub fn undecided(&self) -> Option<Undecided> {
        let (pixels, weights) =
            (self.image.pixels().len(), Layout::of(&self.image).uniform_weights());
        let of = |half: &(f64, Vec<Batch>)| Undecided::of_sum(&half.1, &weights, pixels);
        self.halves.iter().filter(|(weight, _)| *weight > 0.0).find_map(of)
    }

    /// Weights of the blocks that make a bias proportional to the image most visible: value /
    /// variance (the best linear statistic), with the variance as the reference has it, kept above
    /// 1 % of the typical one so that blocks without noise do not decide alone. The weighted sum of
    /// the reference is 1, unless it is black. Uniform for an exact reference, whose noise is unknown.
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
        let scale = if sum == 0.0 { 0.0 } else { 1.0 / sum };
        weights.iter().map(|w| w * scale).collect()
    }
}

/// 0 / 0 is no error.
pub(in crate::report) fn ratio(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}
