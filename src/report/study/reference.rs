//! References from files and from two integrators.

use super::method::Contestant;
use super::plan::{ReferencePlan, Step, run_seed};
use crate::endpoint::Camera;
use crate::film::{Image, ImageFile};
use crate::integrator::Estimator;
use crate::math::Rgb;
use crate::path::DrawnBy;
use crate::render::{Budget, Settings};
use crate::report::error::ReportError;
use crate::report::stats::{Batch, BatchMean, Layout, Reference, Undecided, ratio};
use crate::report::text::{number, signed};
use crate::scene::Scene;
use std::ops::ControlFlow;
use std::path::Path;

impl Reference {
    /// An image from a file, taken as exact.
    ///
    /// # Errors
    /// If it cannot be read, has no pixels or some that are not finite.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ReportError> {
        let path = path.as_ref();
        let image = ImageFile::load(path)?.image;
        Self::known(image, format!("{}, taken as exact", path.display()))
    }

    /// Renders with two integrators, which should be different ones. One that has met too little to
    /// tell its error ([`Undecided`](crate::report::stats::Undecided)) has no part in the reference
    /// if the other has met enough.
    ///
    /// # Errors
    /// If an integrator does not draw every path or is not unbiased, a rendering fails, the plan has
    /// fewer than two runs, or `progress` stops before each half has two.
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
        if let Some(half) = halves.iter().find(|half| !half.complete) {
            return Err(ReportError::ReferenceIncomplete(half.name.clone()));
        }
        let budget = match plan.budget {
            Budget::Samples(samples) => Budget::Samples((samples / 2 / plan.runs).max(1)),
            Budget::Time(time) => Budget::Time(time / (2 * plan.runs)),
        };
        let mut sums = [Moments::default(), Moments::default()];
        let mut missing = Vec::new();
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
                    .render_with_progress(scene, camera, &settings, &mut |p| {
                        let fraction = (done + p.fraction) / total;
                        let flow = progress(&Step::new("reference", fraction, None));
                        stopped |= flow.is_break();
                        flow
                    })
                    .map_err(|source| ReportError::Render {
                        name: halves[half].name.clone(),
                        source,
                    })?;
                if rendering.notes.estimator != Estimator::Unbiased {
                    return Err(ReportError::ReferenceBiased(halves[half].name.clone()));
                }
                moments.add(&rendering.image, rendering.samples_per_pixel);
                for paths in rendering.notes.missing {
                    let what = paths.to_string();
                    if paths.drawn_by == DrawnBy::Merges && !missing.contains(&what) {
                        missing.push(what);
                    }
                }
                if stopped {
                    break 'runs;
                }
            }
        }
        let names = halves.map(|half| half.name.as_str());
        if sums.iter().any(|half| half.batches.len() < 2) {
            return Err(ReportError::ReferenceStopped);
        }
        Ok(Self::combine(names, sums)?.without(missing))
    }

    fn combine(names: [&str; 2], halves: [Moments; 2]) -> Result<Self, ReportError> {
        let [(a, va), (b, vb)] = [halves[0].mean_and_variance(), halves[1].mean_and_variance()];
        let (mean_a, mean_b) = (va.mean().mean(), vb.mean().mean());
        let (uniform, pixels) = (Layout::of(&a).uniform_weights(), a.pixels().len());
        let undecided =
            [0, 1].map(|i| Undecided::of_sum(&halves[i].batches, &uniform, pixels).is_some());
        let samples = [0, 1].map(|i| halves[i].samples);
        let p = match undecided {
            [true, false] => 0.0,
            [false, true] => 1.0,
            // Their variances say nothing: who has missed more believes in less.
            [true, true] => samples[0] / (samples[0] + samples[1]),
            _ if mean_a + mean_b > 0.0 => mean_b / (mean_a + mean_b),
            _ => 0.5,
        };
        let q = 1.0 - p;
        let blend = |x: &Image, y: &Image, p: f64, q: f64| {
            let pixels = x.pixels().iter().zip(y.pixels()).map(|(x, y)| *x * p + *y * q).collect();
            Image::new(x.width(), x.height(), pixels).unwrap_or_else(|| x.clone())
        };
        let (image, variance) = (blend(&a, &b, p, q), blend(&va, &vb, p * p, q * q));
        let [first, second] = halves.map(|half| half.batches);
        let gap =
            BatchMean::of_sum(&first, &uniform).plus(BatchMean::of_sum(&second, &uniform), -1.0);
        let agreement = match undecided {
            [false, false] => {
                let gap = ratio(gap.mean, gap.standard_error());
                format!("the means of the halves differ by {} standard errors", signed(gap))
            }
            [true, true] => "both have met too little to tell".to_owned(),
            [first, _] => {
                format!("{} has met too little to count", names[usize::from(!first)])
            }
        };
        let origin = format!(
            "{} ({} samples per pixel, weight {}) and {} ({}); standard error {} per pixel \
             and channel; {agreement}",
            names[0],
            samples[0],
            number(p),
            names[1],
            samples[1],
            number(variance.mean().mean().sqrt()),
        );
        Self::new(image, variance, origin, vec![(p, first), (q, second)])
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
