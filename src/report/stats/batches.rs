//! Independent parts of a rendering as means over blocks of pixels: little memory, many degrees of
//! freedom.
//!
//! Batch b has n_b samples per pixel and the mean I_b. If one sample has the variance σ², then `Σ
//! n_b (I_b - I)² / (B - 1)` estimates σ² without bias and σ²/N is the variance of the mean over
//! all N samples, batches of unequal size included.

use crate::film::Image;
use serde::{Deserialize, Serialize};

/// Width and height of a block in pixels.
pub const BLOCK: u32 = 8;

/// An image as blocks of [`BLOCK`] × [`BLOCK`] pixels; those at the right and lower border may be
/// smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Width of the image.
    pub width: u32,
    /// Height of the image.
    pub height: u32,
}

impl Layout {
    /// The layout of an image.
    #[must_use]
    pub fn of(image: &Image) -> Self {
        Self { width: image.width(), height: image.height() }
    }

    /// Number of blocks.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.width.div_ceil(BLOCK) as usize * self.height.div_ceil(BLOCK) as usize
    }

    /// First and one past the last column and row of a block.
    #[must_use]
    pub fn bounds(&self, block: usize) -> [[u32; 2]; 2] {
        let columns = self.width.div_ceil(BLOCK).max(1);
        let (x, y) = (block as u32 % columns * BLOCK, block as u32 / columns * BLOCK);
        [[x, (x + BLOCK).min(self.width)], [y, (y + BLOCK).min(self.height)]]
    }

    /// Number of pixels in a block.
    #[must_use]
    pub fn pixels(&self, block: usize) -> f64 {
        let [x, y] = self.bounds(block);
        f64::from(x[1].saturating_sub(x[0])) * f64::from(y[1].saturating_sub(y[0]))
    }

    /// The block that a pixel is in.
    #[must_use]
    pub fn block_of(&self, pixel: usize) -> usize {
        let width = self.width.max(1) as usize;
        let (x, y) = (pixel % width / BLOCK as usize, pixel / width / BLOCK as usize);
        y * self.width.div_ceil(BLOCK) as usize + x
    }

    /// Weights that make a sum over blocks the mean over pixels.
    #[must_use]
    pub fn uniform_weights(&self) -> Vec<f64> {
        let pixels = f64::from(self.width) * f64::from(self.height);
        (0..self.blocks()).map(|block| self.pixels(block) / pixels).collect()
    }

    /// Mean luminance of each block.
    #[must_use]
    pub fn block_means(&self, image: &Image) -> Vec<f64> {
        let mut sums = vec![0.0; self.blocks()];
        for (index, pixel) in image.pixels().iter().enumerate() {
            sums[self.block_of(index)] += pixel.luminance();
        }
        sums.iter().enumerate().map(|(block, sum)| sum / self.pixels(block)).collect()
    }
}

/// One batch: its samples per pixel and the mean luminance of each block.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Samples per pixel.
    pub samples: f64,
    /// Mean luminance of each block.
    pub blocks: Vec<f64>,
}

impl Batch {
    /// A sum over blocks with the given weights.
    #[must_use]
    pub fn sum(&self, weights: &[f64]) -> f64 {
        self.blocks.iter().zip(weights).map(|(b, w)| b * w).sum()
    }
}

/// A mean and its error, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatchMean {
    /// The mean.
    pub mean: f64,
    /// Variance of `mean`.
    #[serde(with = "super::number")]
    pub variance: f64,
    /// Degrees of freedom of the variance.
    #[serde(with = "super::number")]
    pub freedom: f64,
}

impl BatchMean {
    /// A number that is known exactly.
    #[must_use]
    pub fn exact(mean: f64) -> Self {
        Self { mean, variance: 0.0, freedom: f64::INFINITY }
    }

    /// The mean of (samples, value) of each batch; the variance of fewer than two is infinite.
    pub fn of(batches: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let total: f64 = batches.clone().map(|(n, _)| n).sum();
        let mean = if total > 0.0 {
            batches.clone().map(|(n, x)| n * x).sum::<f64>() / total
        } else {
            0.0
        };
        let freedom = batches.clone().count() as f64 - 1.0;
        let spread: f64 = batches.map(|(n, x)| n * (x - mean).powi(2)).sum();
        let variance = if freedom > 0.0 { spread / freedom / total } else { f64::INFINITY };
        Self { mean, variance, freedom: freedom.max(0.0) }
    }

    /// A weighted sum over the blocks of batches.
    #[must_use]
    pub fn of_sum(batches: &[Batch], weights: &[f64]) -> Self {
        Self::of(batches.iter().map(|batch| (batch.samples, batch.sum(weights))))
    }

    /// `self · factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { mean: self.mean * factor, variance: self.variance * factor * factor, ..self }
    }

    /// The sum with the sign of the other, independent, mean; degrees of freedom by Welch and
    /// Satterthwaite.
    #[must_use]
    pub fn plus(self, other: Self, sign: f64) -> Self {
        let variance = self.variance + other.variance;
        let part = |m: Self| if m.variance > 0.0 { m.variance.powi(2) / m.freedom } else { 0.0 };
        let parts = part(self) + part(other);
        let freedom =
            if parts > 0.0 { variance.powi(2) / parts } else { self.freedom + other.freedom };
        Self { mean: self.mean + sign * other.mean, variance, freedom }
    }

    /// Standard error of the mean.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        self.variance.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    #[test]
    fn blocks_cover_the_image() {
        let layout = Layout { width: 19, height: 9 };
        assert_eq!(layout.blocks(), 6);
        assert_eq!((0..6).map(|b| layout.pixels(b)).sum::<f64>(), 171.0);
        assert_eq!(layout.bounds(5), [[16, 19], [8, 9]]);
        let image = Image::from_fn(19, 9, |x, y| Rgb::splat(f64::from(x >= 16 && y >= 8)));
        assert_eq!(layout.block_means(&image), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn unequal_batches() {
        let mean = BatchMean::of([(1.0, 2.0), (3.0, 4.0)].into_iter());
        assert_eq!((mean.mean, mean.variance, mean.freedom), (3.5, 3.0 / 4.0, 1.0));
        let difference = mean.plus(BatchMean::exact(1.0), -1.0);
        assert_eq!((difference.mean, difference.variance, difference.freedom), (2.5, 0.75, 1.0));
        assert_eq!(BatchMean::of([(1.0, 2.0)].into_iter()).variance, f64::INFINITY);
    }
}
