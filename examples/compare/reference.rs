//! The reference image, and how wrong it is itself.

use super::Options;
use super::common::{AnyIntegrator, NamedScene, progress_bar};
use super::measure::{self, Batches, Layout, Measured, Plan};
use pathspace::film::{Image, ImageFile};
use pathspace::math::Rgb;
use pathspace::render::{Budget, Settings};
use std::error::Error;
use std::path::Path;

/// The batches of each half: enough that their spread says how good it is.
const BATCHES: u32 = 8;

/// An image to compare with.
pub struct Reference {
    pub image: Image,
    /// Variance of each pixel; zero for an image from a file, which is taken as exact.
    pub variance: Image,
    /// Mean luminance, and the variance of it.
    pub mean: f64,
    pub mean_variance: f64,
    /// Where it comes from and how good it is, for people.
    pub origin: String,
}

impl Reference {
    pub fn make(options: &Options, scene: &NamedScene, depth: Option<u32>, layout: Layout) -> Result<Self, Box<dyn Error>> {
        match &options.reference {
            Some(path) => Self::load(path, layout),
            None => Self::render(options, scene, depth, layout),
        }
    }

    fn load(path: &Path, layout: Layout) -> Result<Self, Box<dyn Error>> {
        let image = ImageFile::load(path)?.image;
        if (image.width(), image.height()) != (layout.width, layout.height) {
            let (width, height) = (image.width(), image.height());
            let message = format!("reference {} has {width} x {height} pixels, not {} x {}", path.display(), layout.width, layout.height);
            return Err(message.into());
        }
        if image.pixels().iter().any(|pixel| !pixel.is_finite()) {
            return Err(format!("reference {} has pixels that are not finite", path.display()).into());
        }
        let origin = format!("{}, taken as exact", path.display());
        Ok(Self { mean: image.mean().luminance(), mean_variance: 0.0, variance: layout.black(), image, origin })
    }

    /// Two halves by different integrators, if two of them see everything, weighted by the inverse of their variances.
    fn render(options: &Options, scene: &NamedScene, depth: Option<u32>, layout: Layout) -> Result<Self, Box<dyn Error>> {
        let second = if scene.claims.path_tracing { AnyIntegrator::PathTracing } else { AnyIntegrator::Bidirectional };
        let threads = options.threads.map(|n| n as usize);
        // Streams of random numbers that no measured rendering uses.
        let mut halves = [(AnyIntegrator::Bidirectional, 1000), (second, 1001)].map(|(integrator, stream)| {
            let settings = Settings { threads, seed: measure::seed(options.seed, stream), ..Settings::default() };
            Batches::new(integrator, integrator.build(0, depth), settings, layout)
        });
        let budget = options.reference_samples.map_or(Budget::Time(options.reference_time / 2), |samples| Budget::Samples(samples / 2));
        let plan = Plan { budget, batches: BATCHES };
        let bar = progress_bar("reference");
        for batch in 0..BATCHES {
            for (i, half) in halves.iter_mut().enumerate() {
                bar.set_position((u64::from(batch) * 2 + i as u64) * 1000 / u64::from(2 * BATCHES));
                half.render(scene, plan, batch, None)?;
            }
        }
        bar.finish_and_clear();
        Ok(Self::combine(&halves.map(|half| half.finish(&scene.claims))))
    }

    fn combine(halves: &[Measured; 2]) -> Self {
        let [a, b] = halves;
        let (va, vb) = (a.mean_variance(), b.mean_variance());
        let weight = if va + vb > 0.0 { vb / (va + vb) } else { 0.5 };
        let blend = |x: &Image, y: &Image, p: f64, q: f64| {
            let pixels: Vec<Rgb> = x.pixels().iter().zip(y.pixels()).map(|(x, y)| *x * p + *y * q).collect();
            Image::new(x.width(), x.height(), pixels).unwrap_or_else(|| x.clone())
        };
        let image = blend(&a.image, &b.image, weight, 1.0 - weight);
        let variance = blend(&a.variance, &b.variance, weight.powi(2), (1.0 - weight).powi(2));
        let mean_variance = weight.powi(2) * a.mean.variance + (1.0 - weight).powi(2) * b.mean.variance;
        let z = (a.mean.mean - b.mean.mean) / (a.mean.variance + b.mean.variance).sqrt();
        let origin = format!(
            "{} ({} samples per pixel, weight {weight:.2}) and {} ({}); standard error {:.2e} per pixel, {:.2e} of the mean; its halves differ by {z:+.2} standard errors",
            a.integrator,
            a.samples_per_pixel,
            b.integrator,
            b.samples_per_pixel,
            variance.mean().mean().sqrt(),
            mean_variance.sqrt()
        );
        Self { mean: image.mean().luminance(), mean_variance, image, variance, origin }
    }

    /// Mean over pixels and channels of the reference's own variance, over `scale(R)`.
    pub fn own_error(&self, scale: impl Fn(f64) -> f64) -> f64 {
        let pairs = self.variance.pixels().iter().zip(self.image.pixels());
        let sum: f64 = pairs.map(|(v, r)| (0..3).map(|c| v[c] / scale(r[c])).sum::<f64>()).sum();
        sum / (3 * self.image.pixels().len().max(1)) as f64
    }

    pub fn save(&self, scene: &NamedScene, path: &Path) -> Result<(), Box<dyn Error>> {
        let mut file = ImageFile::from(self.image.clone());
        file.metadata.insert("scene".to_owned(), scene.name.clone());
        file.metadata.insert("reference".to_owned(), self.origin.clone());
        file.save(path)?;
        Ok(())
    }
}
