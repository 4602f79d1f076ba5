//! Pixel reconstruction filters.

use crate::sampler::Sampler;
use glam::DVec2;
use std::f64::consts::TAU;

/// The pixel filter: the kernel that averages the radiance around a pixel into it.
///
/// Every filter is the pixel's box convolved with a kernel, and is realised by sampling: a sample's
/// position inside the pixel covers the box and an offset drawn from the kernel covers the rest
/// (filter importance sampling: Ernst, Stamminger and Greiner 2006). The shifted copies of such a
/// filter sum to 1 everywhere, so nothing darkens at the film's border, whether a sample comes from
/// a camera subpath or is splatted by a light subpath. All filters are positive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Filter {
    /// The average over the pixel. Its variance is 1/12 square pixel per axis.
    #[default]
    Box,
    /// The separable tent of radius 1 pixel: the box convolved with itself. Its variance is 1/6.
    Tent,
    /// The box convolved with a rotationally symmetric Gaussian that is cut off at four of its own
    /// standard deviations.
    Gaussian {
        /// Standard deviation per axis of the whole filter, box included, in pixels: more than
        /// √(1/12) ≈ 0.2887. 0.5 is usual.
        standard_deviation: f64,
    },
}

/// A Gaussian filter whose standard deviation is not finite or not more than that of the pixel's
/// box.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "standard deviation {standard_deviation} of the Gaussian filter is not between that of a pixel \
     (0.2887) and 1000 pixels"
)]
pub struct FilterError {
    /// The refused standard deviation in pixels.
    pub standard_deviation: f64,
}

/// Variance of a pixel's box per axis.
const BOX_VARIANCE: f64 = 1.0 / 12.0;
/// The end of the Gaussian kernel, in its own standard deviations before the cut.
const CUT: f64 = 4.0;

/// A checked [`Filter`], ready to draw offsets. By default that of the box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kernel(Shape);

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Shape {
    #[default]
    Point,
    Square,
    /// Standard deviation before the cut.
    Gaussian(f64),
}

impl Filter {
    /// Checks the filter.
    ///
    /// # Errors
    /// If a Gaussian is not wider than a pixel's box, is wider than 1000 pixels, or is not a
    /// number.
    pub fn kernel(&self) -> Result<Kernel, FilterError> {
        Ok(Kernel(match *self {
            Self::Box => Shape::Point,
            Self::Tent => Shape::Square,
            Self::Gaussian { standard_deviation } => {
                let variance = standard_deviation * standard_deviation - BOX_VARIANCE;
                if !(standard_deviation > 0.0 && variance > 0.0 && standard_deviation <= 1000.0) {
                    return Err(FilterError { standard_deviation });
                }
                // R²/2 is exponentially distributed and cut at T = CUT²/2; its mean is the variance
                // per axis.
                let (t, tail) = (CUT * CUT / 2.0, libm::exp(-CUT * CUT / 2.0));
                Shape::Gaussian((variance / (1.0 - t * tail / (1.0 - tail))).sqrt())
            }
        }))
    }
}

impl Kernel {
    /// Draws an offset in pixels. The box draws no random numbers.
    #[inline]
    #[must_use]
    pub fn sample<P: Sampler + ?Sized>(&self, sampler: &mut P) -> DVec2 {
        match self.0 {
            Shape::Point => DVec2::ZERO,
            Shape::Square => sampler.next_2d() - 0.5,
            Shape::Gaussian(standard_deviation) => {
                let u = sampler.next_2d();
                // Inverts the distribution of the radius (Box and Muller 1958), restricted to radii
                // below the cut.
                let inside = 1.0 - libm::exp(-CUT * CUT / 2.0);
                let radius = standard_deviation * (-2.0 * libm::log1p(-u.x * inside)).sqrt();
                DVec2::from_angle(TAU * u.y) * radius
            }
        }
    }

    /// The longest offset along an axis, in pixels.
    #[must_use]
    pub fn reach(&self) -> f64 {
        match self.0 {
            Shape::Point => 0.0,
            Shape::Square => 0.5,
            Shape::Gaussian(standard_deviation) => CUT * standard_deviation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Independent, Replay, SampleSource};

    /// The variance of each filter's samples. With n = 200 000 the standard error of a variance σ²
    /// is about σ² √(2/n) = 0.3 % of it; bound 5 standard errors.
    #[test]
    fn total_variance_is_the_filters() {
        let n = 200_000;
        let gaussian = |s| (Filter::Gaussian { standard_deviation: s }, s * s);
        for (filter, variance) in [
            (Filter::Box, 1.0 / 12.0),
            (Filter::Tent, 1.0 / 6.0),
            gaussian(0.3),
            gaussian(0.5),
            gaussian(2.0),
        ] {
            let kernel = filter.kernel().unwrap();
            let mut sampler = Independent { seed: 3 }.sampler(0, 0);
            let (mut mean, mut square, mut product, mut farthest) =
                (DVec2::ZERO, DVec2::ZERO, 0.0, 0.0f64);
            for _ in 0..n {
                let offset = kernel.sample(&mut sampler);
                farthest = farthest.max(offset.length());
                let x = sampler.next_2d() - 0.5 + offset;
                (mean, square, product) = (
                    mean + x / f64::from(n),
                    square + x * x / f64::from(n),
                    product + x.x * x.y / f64::from(n),
                );
            }
            assert!(
                mean.abs().max_element() < 5.0 * (variance / f64::from(n)).sqrt(),
                "{filter:?} {mean}"
            );
            assert!(
                (square / variance - 1.0).abs().max_element() < 0.016,
                "{filter:?} {square} instead of {variance}"
            );
            assert!((product / variance).abs() < 0.012, "{filter:?} {product}");
            assert!(farthest <= kernel.reach() * 2f64.sqrt());
        }
    }

    #[test]
    fn the_ends_of_the_random_numbers_give_finite_offsets() {
        for filter in [Filter::Box, Filter::Tent, Filter::Gaussian { standard_deviation: 0.5 }] {
            let kernel = filter.kernel().unwrap();
            for u in [0.0, 1.0f64.next_down()] {
                for v in [0.0, 1.0f64.next_down()] {
                    let offset = kernel.sample(&mut Replay::new(vec![u, v]));
                    assert!(
                        offset.abs().max_element() <= kernel.reach() * (1.0 + 1e-12),
                        "{filter:?} {offset}"
                    );
                }
            }
        }
    }

    #[test]
    fn too_narrow_gaussians_are_refused() {
        for standard_deviation in [0.0, -1.0, 0.288, f64::NAN, f64::INFINITY, 1e200] {
            let error = Filter::Gaussian { standard_deviation }.kernel().unwrap_err();
            assert!(error.to_string().contains("Gaussian"));
        }
    }
}
