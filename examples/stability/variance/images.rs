//! The variance of independent images, and what they cost.

use pathspace::endpoint::Camera;
use pathspace::math::statistics::Estimate;
use pathspace::render::{Budget, Render, Settings};
use pathspace::sampler::SamplerKind;
use pathspace::scene::Scene;
use std::time::Instant;

/// The price of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Price {
    /// Seconds of one thread.
    Time,
    /// Rays, which are the same on every machine.
    Rays,
}

/// The effort that a measurement takes.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Independent images of each method, at least 2.
    pub images: u32,
    pub samples_per_pixel: u32,
    pub price: Price,
}

/// A number and its relative standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertain {
    pub value: f64,
    pub error: f64,
}

impl Uncertain {
    pub fn over(self, other: Self) -> Self {
        Self { value: self.value / other.value, error: self.error.hypot(other.error) }
    }

    /// True unless it exceeds a bound by more than so many errors. What is not a number does.
    pub fn is_within(self, bound: f64, errors: f64) -> bool {
        (self.value / bound).ln() <= errors * self.error
    }
}

/// Images of the same scene by the same method, and what each cost.
#[derive(Clone, Debug, Default)]
pub struct Images {
    pixels: Vec<Vec<f64>>,
    prices: Vec<f64>,
}

impl Images {
    /// Renders one more.
    pub fn render<S: Scene>(
        &mut self,
        scene: &S,
        camera: &dyn Camera,
        integrator: &dyn Render<S>,
        effort: Effort,
        seed: u64,
    ) {
        let budget = Budget::Samples(effort.samples_per_pixel);
        let sampler = SamplerKind::Independent;
        let settings = Settings { budget, seed, threads: Some(1), sampler, ..Settings::default() };
        let start = Instant::now();
        let rendering = integrator.render(scene, camera, &settings).expect("an image");
        self.prices.push(match effort.price {
            Price::Time => start.elapsed().as_secs_f64(),
            Price::Rays => rendering.counters.rays() as f64,
        });
        self.pixels.push(rendering.image.pixels().iter().map(|pixel| pixel.mean()).collect());
    }

    /// Variance of one image, mean over its pixels, times its price.
    pub fn inefficiency(&self) -> Uncertain {
        let images = self.pixels.len() as f64;
        let means: Vec<f64> = (0..self.pixels[0].len())
            .map(|i| self.pixels.iter().map(|image| image[i]).sum::<f64>() / images)
            .collect();
        let square_error = |image: &Vec<f64>| {
            let squares = image.iter().zip(&means).map(|(x, mean)| (x - mean).powi(2));
            squares.sum::<f64>() / means.len() as f64 * images / (images - 1.0)
        };
        let variance: Estimate = self.pixels.iter().map(square_error).collect();
        let (price, error) = (self.price(), variance.standard_error() / variance.mean());
        Uncertain { value: variance.mean() * price.value, error: error.hypot(price.error) }
    }

    /// The least price of an image: other programs only ever add to the time. The error is the
    /// distance of the next one, which tells whether it was disturbed, too.
    pub fn price(&self) -> Uncertain {
        let mut prices = self.prices.clone();
        prices.sort_by(f64::total_cmp);
        Uncertain { value: prices[0], error: prices[1] / prices[0] - 1.0 }
    }

    /// Mean over the film.
    pub fn mean(&self) -> Estimate {
        self.pixels.iter().map(|image| image.iter().sum::<f64>() / image.len() as f64).collect()
    }
}
