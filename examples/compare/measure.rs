//! Independent renderings of one integrator, and what their spread says.
//!
//! Batch b has n_b samples per pixel and the image I_b; the final image is Σ n_b I_b / N. If one sample has the variance σ², then the sum
//! Σ n_b (I_b - I)² / (B - 1) estimates σ² without bias, and σ²/N is the variance of the final image, batches of unequal size included.

use super::Options;
use super::common::{AnyIntegrator, NamedScene};
use pathspace::film::{FilmRegion, Image, ImageFile};
use pathspace::math::Rgb;
use pathspace::math::statistics::Estimate;
use pathspace::path::{Counters, TechniqueSet};
use pathspace::render::{Budget, Render, Rendering, Settings, unattended};
use pathspace::scene::World;
use pathspace::scene::gallery::Claims;
use std::error::Error;
use std::path::Path;
use std::time::Duration;

/// Width and height of the blocks that agreement is tested on, in pixels.
pub const BLOCK: u32 = 8;

/// The image as pixels and as blocks of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    pub width: u32,
    pub height: u32,
}

impl Layout {
    pub fn new(film: FilmRegion) -> Self {
        let size = film.window_size();
        Self { width: size.x, height: size.y }
    }

    pub fn blocks(&self) -> usize {
        (self.width.div_ceil(BLOCK) * self.height.div_ceil(BLOCK)) as usize
    }

    /// Pixels of the upper left corner of a block.
    pub fn corner(&self, block: usize) -> [u32; 2] {
        let columns = self.width.div_ceil(BLOCK);
        [block as u32 % columns * BLOCK, block as u32 / columns * BLOCK]
    }

    /// Mean luminance of each block.
    fn block_means(&self, image: &Image) -> Vec<f64> {
        let (mut sums, mut counts) = (vec![0.0; self.blocks()], vec![0u32; self.blocks()]);
        let columns = self.width.div_ceil(BLOCK);
        for (i, pixel) in image.pixels().iter().enumerate() {
            let (x, y) = (i as u32 % self.width, i as u32 / self.width);
            let block = (y / BLOCK * columns + x / BLOCK) as usize;
            sums[block] += pixel.luminance();
            counts[block] += 1;
        }
        sums.iter().zip(counts).map(|(sum, count)| sum / f64::from(count.max(1))).collect()
    }

    pub fn black(&self) -> Image {
        Image::from_fn(self.width, self.height, |_, _| Rgb::BLACK)
    }
}

/// A mean with its variance, estimated from batches.
#[derive(Clone, Copy, Debug)]
pub struct BatchMean {
    pub mean: f64,
    /// Variance of `mean`.
    pub variance: f64,
    /// Degrees of freedom of the variance.
    pub freedom: f64,
}

impl BatchMean {
    /// From (samples, value) of each batch.
    pub fn of(batches: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let total: f64 = batches.clone().map(|(n, _)| n).sum();
        let mean = batches.clone().map(|(n, x)| n * x).sum::<f64>() / total;
        let count = batches.clone().count() as f64;
        let spread: f64 = batches.map(|(n, x)| n * (x - mean).powi(2)).sum();
        let freedom = count - 1.0;
        Self { mean, variance: if freedom > 0.0 { spread / freedom / total } else { f64::INFINITY }, freedom }
    }

    pub fn standard_error(&self) -> f64 {
        self.variance.sqrt()
    }
}

/// A seed of its own for each stream of renderings; batches count on from it.
pub fn seed(base: u64, stream: u64) -> u64 {
    base.wrapping_add((stream + 1) << 40)
}

/// What an integrator may spend, and in how many batches.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    pub budget: Budget,
    pub batches: u32,
}

/// Fewer batches say too little about their spread; an integrator that is out of time still makes so many, of one pass each.
const FEWEST_BATCHES: usize = 4;

/// Added to R² in relative errors (I - R)² / R², which have no meaning where the reference R is dark.
pub fn floor(reference: &Image) -> f64 {
    0.01 * reference.mean().mean().powi(2)
}

/// An integrator at work.
pub struct Batches {
    pub integrator: AnyIntegrator,
    method: Box<dyn Render<World>>,
    settings: Settings,
    layout: Layout,
    techniques: TechniqueSet,
    /// Samples per pixel of each batch.
    samples: Vec<u32>,
    wall: Duration,
    counters: Counters,
    /// Σ n_b I_b and Σ n_b I_b².
    sums: Image,
    squares: Image,
    /// Mean luminance of each block, for each batch.
    blocks: Vec<Vec<f64>>,
    means: Vec<f64>,
    /// Mean squared error of each batch against an image, times its samples, summed over pixels: all have the same expectation.
    errors: Estimate,
    /// The same for the relative error, to which bright pixels contribute no more than others.
    relative_errors: Estimate,
}

impl Batches {
    pub fn new(integrator: AnyIntegrator, method: Box<dyn Render<World>>, settings: Settings, layout: Layout) -> Self {
        Self {
            integrator,
            method,
            settings,
            layout,
            techniques: TechniqueSet::NONE,
            samples: Vec::new(),
            wall: Duration::ZERO,
            counters: Counters::default(),
            sums: layout.black(),
            squares: layout.black(),
            blocks: Vec::new(),
            means: Vec::new(),
            errors: Estimate::default(),
            relative_errors: Estimate::default(),
        }
    }

    /// Renders batch number `batch` of a plan, unless the time is used up.
    pub fn render(&mut self, scene: &NamedScene, plan: Plan, batch: u32, reference: Option<&Image>) -> Result<(), Box<dyn Error>> {
        let budget = match plan.budget {
            // With more batches than samples, the last ones are empty.
            Budget::Samples(samples) => match samples / plan.batches + u32::from(batch < samples % plan.batches) {
                0 => return Ok(()),
                share => Budget::Samples(share),
            },
            Budget::Time(time) => {
                let passes = self.samples.iter().sum::<u32>();
                let after_half_a_pass = self.wall.as_secs_f64() * (1.0 + 0.5 / f64::from(passes.max(1)));
                if self.samples.len() >= FEWEST_BATCHES && after_half_a_pass >= time.as_secs_f64() {
                    return Ok(());
                }
                // Ends when all batches so far have used their part, so that rounding to whole passes does not add up.
                let end = time.mul_f64(f64::from(batch + 1) / f64::from(plan.batches));
                Budget::Time(end.saturating_sub(self.wall).max(Duration::from_nanos(1)))
            }
            _ => return Err("unknown kind of budget".into()),
        };
        let seed = self.settings.seed.wrapping_add((self.samples.len() as u64) << 20);
        let settings = Settings { budget, seed, ..self.settings };
        let rendering = self.method.render(&scene.world, &*scene.camera.0, &settings, &mut unattended)?;
        self.add(&rendering);
        if let Some(reference) = reference {
            let samples = f64::from(rendering.samples_per_pixel);
            let (floor, mut sums) = (floor(reference), [0.0; 2]);
            for (i, r) in rendering.image.pixels().iter().zip(reference.pixels()) {
                for c in 0..3 {
                    let squared = (i[c] - r[c]).powi(2);
                    sums = [sums[0] + squared, sums[1] + squared / (r[c] * r[c] + floor)];
                }
            }
            self.errors.push(samples * sums[0]);
            self.relative_errors.push(samples * sums[1]);
        }
        Ok(())
    }

    fn add(&mut self, rendering: &Rendering) {
        let n = f64::from(rendering.samples_per_pixel);
        for ((sum, square), pixel) in self.sums.pixels_mut().iter_mut().zip(self.squares.pixels_mut()).zip(rendering.image.pixels()) {
            *sum += *pixel * n;
            *square += *pixel * *pixel * n;
        }
        self.techniques = rendering.techniques;
        self.samples.push(rendering.samples_per_pixel);
        self.wall += rendering.wall;
        self.counters += rendering.counters;
        self.means.push(rendering.image.mean().luminance());
        self.blocks.push(self.layout.block_means(&rendering.image));
    }

    pub fn finish(self, claims: &Claims) -> Measured {
        let batches = || self.samples.iter().map(|n| f64::from(*n));
        let total: f64 = batches().sum();
        let freedom = self.samples.len() as f64 - 1.0;
        let mut image = self.sums;
        image.pixels_mut().iter_mut().for_each(|pixel| *pixel = *pixel / total);
        let mut variance = self.squares;
        for (square, mean) in variance.pixels_mut().iter_mut().zip(image.pixels()) {
            // The difference of two large numbers may round below zero.
            *square = ((*square - *mean * *mean * total) / (freedom * total)).map(|v| v.max(0.0));
        }
        let relative = |errors: &Estimate| errors.standard_error() / errors.mean();
        Measured {
            integrator: self.integrator,
            sees_all: self.integrator.sees_all(claims),
            techniques: self.techniques,
            long_tails: relative(&self.relative_errors) > 0.05,
            relative_error: relative(&self.errors),
            samples_per_pixel: self.samples.iter().sum(),
            wall: self.wall,
            counters: self.counters,
            mean: BatchMean::of(batches().zip(self.means.iter().copied())),
            batch_samples: batches().collect(),
            batch_blocks: self.blocks,
            image,
            variance,
        }
    }
}

/// What an integrator made of its budget.
pub struct Measured {
    pub integrator: AnyIntegrator,
    /// Whether it can draw every path of this scene.
    pub sees_all: bool,
    pub techniques: TechniqueSet,
    pub samples_per_pixel: u32,
    pub wall: Duration,
    pub counters: Counters,
    /// Mean luminance of the image.
    pub mean: BatchMean,
    /// Samples per pixel of each batch.
    pub batch_samples: Vec<f64>,
    /// Mean luminance of each block, for each batch.
    pub batch_blocks: Vec<Vec<f64>>,
    /// Whether rare, large contributions make up much of the relative variance, so that even all batches together do not know it well. Then
    /// whoever missed them in a block has too small a mean *and* too small a variance there, and no test can tell that from missing light.
    pub long_tails: bool,
    /// Relative standard error of the variance of a sample.
    pub relative_error: f64,
    pub image: Image,
    /// Variance of each pixel of `image`.
    pub variance: Image,
}

impl Measured {
    /// Variance of the image, averaged over pixels and channels.
    pub fn mean_variance(&self) -> f64 {
        self.variance.mean().mean()
    }

    /// Mean luminance of some blocks together.
    pub fn block(&self, blocks: &[usize]) -> BatchMean {
        let mean = |means: &Vec<f64>| blocks.iter().map(|block| means[*block]).sum::<f64>() / blocks.len().max(1) as f64;
        BatchMean::of(self.batch_samples.iter().copied().zip(self.batch_blocks.iter().map(mean)))
    }

    /// Variance × time: the seconds that an image of variance 1 takes.
    pub fn cost(&self) -> f64 {
        self.mean_variance() * self.wall.as_secs_f64()
    }

    pub fn save(&self, scene: &NamedScene, options: &Options, directory: &Path) -> Result<(), Box<dyn Error>> {
        let mut file = ImageFile::from(self.image.clone());
        let entries = [
            ("scene", scene.name.clone()),
            ("integrator", self.integrator.name().to_owned()),
            ("techniques", self.techniques.to_string()),
            ("seed", options.seed.to_string()),
            ("batches", options.batches.to_string()),
            ("samples_per_pixel", self.samples_per_pixel.to_string()),
            ("seconds", format!("{:.3}", self.wall.as_secs_f64())),
        ];
        file.metadata.extend(entries.map(|(key, value)| (key.to_owned(), value)));
        file.exposure = super::picture::exposure(&self.image);
        for extension in ["png", "exr"] {
            file.save(directory.join(format!("{}.{extension}", self.integrator.name())))?;
        }
        Ok(())
    }
}
