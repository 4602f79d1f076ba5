//! The estimated error of an image under way, without a reference: how much it changes when samples
//! are added.
//!
//! The image I_N after N passes is half of I_{N/2} and half of as many new samples, so if samples
//! are independent,
//!
//! ```text
//! E[(I_N - I_{N/2})²] = σ²/N = Var(I_N)
//! ```
//!
//! for each pixel. Looked at whenever N is a power of two, this costs one kept image. Where passes in
//! a row depend on one another, N counts such rows.

use crate::film::Image;
use crate::math::Rgb;
use std::sync::Arc;

/// Before this many passes nothing is believed: most pixels may have seen nothing yet.
const FEWEST_PASSES: u32 = 8;
/// The part of the squared mean of the image that is added to the denominator of relMSE.
const EPSILON: f64 = 0.01;

/// Watches an image on its way to an error.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    target: f64,
    /// Passes in a row that depend on one another.
    row: u32,
    pub before: Option<Arc<Image>>,
    /// Estimated error times passes: the variance of one sample, relative.
    pub variance: Option<f64>,
}

impl Watch {
    pub fn new(target: f64) -> Self {
        Self { target, row: 1, before: None, variance: None }
    }

    /// The same for passes of which so many in a row depend on one another; 0 if none do.
    pub fn by_rows(self, row: u32) -> Self {
        Self { row: row.max(1), ..self }
    }

    /// To be called after each pass.
    pub fn look(&mut self, passes: u32, image: impl FnOnce() -> Image) {
        let is_whole = passes.is_multiple_of(self.row) && (passes / self.row).is_power_of_two();
        if !is_whole || passes < FEWEST_PASSES / 2 {
            return;
        }
        let image = image();
        if let Some(before) = &self.before {
            self.variance =
                relative_change(before, &image).map(|change| change * f64::from(passes));
        }
        self.before = Some(Arc::new(image));
    }

    /// The estimated relMSE after this many passes.
    pub fn error(&self, passes: u32) -> Option<f64> {
        self.variance.map(|variance| variance / f64::from(passes))
    }

    /// Part of the way to the target.
    pub fn fraction(&self, passes: u32) -> f64 {
        self.error(passes)
            .map_or(0.0, |error| if error > self.target { self.target / error } else { 1.0 })
    }
}

/// `mean (a - b)² / (b² + ε)`; `None` for a black image, of whose error nothing is known.
fn relative_change(a: &Image, b: &Image) -> Option<f64> {
    let scale = b.mean().mean();
    let epsilon = EPSILON * scale * scale;
    let change = |a: Rgb, b: Rgb| {
        (0..3).map(|c| (a[c] - b[c]).powi(2) / (b[c] * b[c] + epsilon)).sum::<f64>()
    };
    let sum: f64 = a.pixels().iter().zip(b.pixels()).map(|(a, b)| change(*a, *b)).sum();
    (epsilon > 0.0).then(|| sum / (3.0 * b.pixels().len() as f64))
}
