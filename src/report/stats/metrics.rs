//! Errors of an image against a reference, averaged over pixels and channels.
//!
//! | measure | definition | falls as |
//! |---|---|---|
//! | MSE | `mean (I - R)²` | 1/N |
//! | relMSE | `mean (I - R)² / (R² + ε)` | 1/N |
//! | MAPE | `mean \|I - R\| / (\|R\| + 0.01 · mean(R))` | 1/√N |
//! | SMAPE | `mean \|I - R\| / (\|I\| + \|R\|)`, 0 where both are 0 | 1/√N |
//! | MedSE | median of `(I - R)²` | 1/N |
//!
//! In relMSE `ε = 0.01 · mean(R)²` is relative to the image, so that exposure does not matter.
//! SMAPE is at most 1 per value, so outliers cannot dominate it. MedSE is robust, too; for a tail
//! index α < 2 it falls as `N^(2/α - 2)`.
//!
//! A pixel that is not finite is never skipped: it makes every mean infinite, and it is counted.

use super::reference::{RELATIVE_EPSILON, Reference, ratio};
use crate::film::Image;
use crate::math::Rgb;
use serde::{Deserialize, Serialize};

/// All measures of one image. Infinite if a pixel is not finite, which JSON writes as null.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Mean squared error, the reference's own variance subtracted.
    #[serde(with = "super::number")]
    pub mse: f64,
    /// Relative mean squared error, the reference's own variance subtracted.
    #[serde(with = "super::number")]
    pub relative_mse: f64,
    /// Mean absolute percentage error (as a fraction).
    #[serde(with = "super::number")]
    pub mape: f64,
    /// Symmetric mean absolute percentage error (as a fraction).
    #[serde(with = "super::number")]
    pub smape: f64,
    /// Median squared error.
    #[serde(with = "super::number")]
    pub median_squared: f64,
    /// Pixels with a component that is infinite or not a number.
    pub non_finite_pixels: u64,
}

impl Errors {
    /// Compares an image with a reference. Images of different size give infinite errors with all
    /// pixels counted.
    #[must_use]
    pub fn of(image: &Image, reference: &Reference) -> Self {
        let expected = reference.image();
        let same = (image.width(), image.height()) == (expected.width(), expected.height());
        let bad = image.pixels().iter().filter(|p| !p.is_finite()).count() as u64;
        if !same || bad > 0 {
            let count = if same { bad } else { image.pixels().len() as u64 };
            let inf = f64::INFINITY;
            return Self {
                mse: inf,
                relative_mse: inf,
                mape: inf,
                smape: inf,
                median_squared: inf,
                non_finite_pixels: count,
            };
        }
        let scale = reference.scale();
        let (epsilon, floor) = (RELATIVE_EPSILON * scale * scale, RELATIVE_EPSILON * scale);
        let mut squares = Vec::with_capacity(3 * image.pixels().len());
        let [mut mse, mut relative, mut mape, mut smape] = [0.0; 4];
        for (i, r) in image
            .pixels()
            .iter()
            .zip(expected.pixels())
            .flat_map(|(a, b)| (0..3).map(|c| (a[c], b[c])))
        {
            let (error, square) = ((i - r).abs(), (i - r) * (i - r));
            squares.push(square);
            mse += square;
            relative += ratio(square, r * r + epsilon);
            mape += ratio(error, r.abs() + floor);
            smape += ratio(error, i.abs() + r.abs());
        }
        let n = squares.len().max(1) as f64;
        Self {
            mse: mse / n - reference.own_mse(),
            relative_mse: relative / n - reference.own_relative_mse(),
            mape: mape / n,
            smape: smape / n,
            median_squared: median(&mut squares),
            non_finite_pixels: 0,
        }
    }
}

/// The middle one, or the mean of the two in the middle; 0 for none.
fn median(values: &mut [f64]) -> f64 {
    let n = values.len();
    if n == 0 {
        return 0.0;
    }
    let (below, &mut upper, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    if n % 2 == 1 {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}

/// Median of means: images are grouped in order, each group is averaged, and the median over the
/// groups is taken per pixel and channel. Its error has exponential tails even where single images
/// have infinite variance, at the price of a bias towards the median. `None` without images or with
/// images of different size.
#[must_use]
pub fn median_of_means(images: &[Image], groups: usize) -> Option<Image> {
    let first = images.first()?;
    if images.iter().any(|i| (i.width(), i.height()) != (first.width(), first.height())) {
        return None;
    }
    let length = images.len().div_ceil(groups.clamp(1, images.len()));
    let means: Vec<Image> = images.chunks(length).filter_map(mean_image).collect();
    let mut values = vec![0.0; means.len()];
    let pixels = (0..first.pixels().len()).map(|i| {
        Rgb([0, 1, 2].map(|c| {
            values.iter_mut().zip(&means).for_each(|(v, m)| *v = m.pixels()[i][c]);
            median(&mut values)
        }))
    });
    Image::new(first.width(), first.height(), pixels.collect())
}

/// Mean of images of one size; `None` without images.
pub(super) fn mean_image(images: &[Image]) -> Option<Image> {
    let mut sum = images.first()?.clone();
    for image in &images[1..] {
        sum.pixels_mut().iter_mut().zip(image.pixels()).for_each(|(s, p)| *s += *p);
    }
    sum.pixels_mut().iter_mut().for_each(|s| *s = *s / images.len() as f64);
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(value: f64) -> Image {
        Image::from_fn(4, 4, |_, _| Rgb::splat(value))
    }

    #[test]
    fn errors_by_hand() {
        let reference = Reference::exact(constant(2.0)).unwrap();
        let errors = Errors::of(&constant(2.5), &reference);
        assert!(
            (errors.mse - 0.25).abs() < 1e-15 && (errors.relative_mse - 0.25 / 4.04).abs() < 1e-15
        );
        assert!(
            (errors.mape - 0.5 / 2.02).abs() < 1e-15 && (errors.smape - 0.5 / 4.5).abs() < 1e-15
        );
        assert_eq!(errors.median_squared, 0.25);
        let black = Reference::exact(constant(0.0)).unwrap();
        assert_eq!(Errors::of(&constant(0.0), &black), Errors::default());
    }

    #[test]
    fn non_finite_pixels_are_counted_and_not_skipped() {
        let mut image = constant(1.0);
        image.pixels_mut()[5] = Rgb::new(1.0, f64::NAN, 1.0);
        let errors = Errors::of(&image, &Reference::exact(constant(1.0)).unwrap());
        assert_eq!(
            (errors.non_finite_pixels, errors.mse, errors.smape),
            (1, f64::INFINITY, f64::INFINITY)
        );
    }

    #[test]
    fn median_of_means_ignores_an_outlier() {
        let mut images = vec![constant(1.0); 8];
        images[3].pixels_mut()[0] = Rgb::splat(1e9);
        let robust = median_of_means(&images, 4).unwrap();
        assert_eq!(robust, constant(1.0));
        assert!(median_of_means(&[], 4).is_none());
        assert_eq!(median_of_means(&images[..1], 4), Some(constant(1.0)));
    }
}
