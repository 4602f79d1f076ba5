//! The pyramid of techniques with its images, and its numbers.

use crate::film::{Image, Technique};
use serde::{Deserialize, Serialize};

/// The pyramid with its images.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    /// The techniques, those that merge last, by path length and then s.
    pub layers: Vec<Layer>,
    /// Samples per pixel.
    pub passes: u32,
    /// Variance per sample of all techniques together.
    pub variance: f64,
    /// Rays per sample of all techniques together.
    pub rays: f64,
}

/// One technique.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The technique.
    pub technique: Technique,
    /// Its contributions as if it were alone.
    pub unweighted: Image,
    /// Its weighted contributions: all layers together are the image.
    pub weighted: Image,
    /// Its numbers.
    pub share: TechniqueShare,
}

/// The numbers of one technique.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TechniqueShare {
    /// Vertices from the light.
    pub s: u16,
    /// Vertices from the camera.
    pub t: u16,
    /// True if it merges the ends of its subpaths; false if it connects them.
    pub merged: bool,
    /// Share of the image's mean luminance.
    pub energy: f64,
    /// Variance of its weighted contributions over that of the whole; the shares do not add up to
    /// 1, since techniques are correlated.
    pub variance: f64,
    /// Share of the rays that the integrator saves without it. NaN if it was not measured, which is
    /// for bidirectional path tracing only.
    #[serde(with = "crate::report::stats::number")]
    pub cost: f64,
    /// Efficiency 1 / (variance × rays) without it over that with it; above 1 it does not pay. NaN
    /// if the rest cannot draw its paths, or if it was not measured.
    #[serde(with = "crate::report::stats::number")]
    pub efficiency_without: f64,
}

/// The numbers of the pyramid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PyramidReport {
    /// Samples per pixel that they come from.
    pub samples_per_pixel: u32,
    /// Variance of one sample of a pixel's luminance, mean over pixels.
    pub variance: f64,
    /// Rays per sample.
    pub rays_per_sample: f64,
    /// The techniques, those that merge last, by path length and then s.
    pub techniques: Vec<TechniqueShare>,
}

impl Pyramid {
    pub(in crate::report) fn report(&self) -> PyramidReport {
        PyramidReport {
            samples_per_pixel: self.passes,
            variance: self.variance,
            rays_per_sample: self.rays,
            techniques: self.layers.iter().map(|layer| layer.share).collect(),
        }
    }
}
