//! One number with its error: the mean over a window of the film, or what a meter reads.

use super::{Budget, Render, RenderError, Settings, Shard};
use crate::endpoint::Camera;
use crate::film::Filter;
use crate::integrator::Notes;
use crate::math::Rgb;
use crate::math::statistics::Estimate;
use crate::math::student::half_width;
use crate::path::{Counters, MissingPaths};
use crate::scene::Scene;
use std::time::Duration;

/// Independent renderings of a measurement: with 15 degrees of freedom its standard error is known
/// to 18 %, and Sobol' points are in sequences that are still long.
const REPLICATIONS: u32 = 16;
/// The difference of the seeds of two of them: 2⁶⁴ over the golden ratio, odd, so that no two
/// seeds are the same.
const SEED_STEP: u64 = 0x9E37_79B9_7F4A_7C15;

/// A measured quantity with its error, per channel.
///
/// It is the mean of independent renderings, and its standard error comes from their differences
/// alone (randomised quasi-Monte Carlo by replication: Owen 1997; L'Ecuyer 2018, section 3). So it
/// is honest for any sampler and any integrator: points of a Sobol' sequence, and samples that
/// share light walks, depend on one another, and the spread of single samples says nothing of the
/// error of their mean. What it cannot know is bias: of integrators that are consistent or biased
/// ([`Notes::estimator`]), of [blind spots](Self::blind_spots), and of light so rare that no
/// rendering has met it.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The measured values of the renderings, per channel.
    pub replications: [Estimate; 3],
    /// Samples of all renderings, over all pixels.
    pub samples: u64,
    /// The notes of one of the runs: what is left out, what is missing, bias.
    pub notes: Notes,
    /// Counts of what was done.
    pub counters: Counters,
    /// Wall-clock time.
    pub wall: Duration,
}

impl Measurement {
    /// The measured value: radiance (W/(m² sr)), or irradiance (W/m²) of an
    /// [`IrradianceMeter`](crate::endpoint::IrradianceMeter).
    #[must_use]
    pub fn mean(&self) -> Rgb {
        Rgb(self.replications.map(|channel| channel.mean()))
    }

    /// The standard error of the mean.
    #[must_use]
    pub fn standard_error(&self) -> Rgb {
        Rgb(self.replications.map(|channel| channel.standard_error()))
    }

    /// The variance of a sample, by which integrators are compared: that of the mean times the number
    /// of samples. It is less with points that are spread better than independent ones.
    #[must_use]
    pub fn variance(&self) -> Rgb {
        self.standard_error().map(|error| error * error * self.samples as f64)
    }

    /// Half the width of the interval around the mean that contains the expected value with
    /// probability `confidence`, by Student's t distribution.
    #[must_use]
    pub fn half_width(&self, confidence: f64) -> Rgb {
        Rgb(self.replications.map(|channel| half_width(&channel, confidence)))
    }

    /// The distance of the mean from an expected value in standard errors.
    #[must_use]
    pub fn z_score(&self, expected: Rgb) -> Rgb {
        let mut channels = self.replications.iter().zip(expected.0);
        Rgb([(); 3].map(|()| channels.next().map_or(0.0, |(channel, x)| channel.z_score(x))))
    }

    /// Paths that contribute to the quantity and that the integrator cannot draw.
    #[must_use]
    pub fn blind_spots(&self) -> &[MissingPaths] {
        &self.notes.missing
    }
}

/// The mean radiance over the window of a camera's film, or what a meter reads, with its error.
///
/// A pixel is a window of one. The budget is divided among 16 renderings, or as many as there are
/// samples per pixel if these are fewer, but at least two, with seeds that follow from that of the
/// settings; each takes one sample per pixel at least, and a rest is left. The pixel filter is the
/// box; there is no target error, no shard and no checkpoint.
///
/// ```
/// use pathspace::gallery;
/// use pathspace::glam::UVec2;
/// use pathspace::integrator::PathTracer;
/// use pathspace::render::{Settings, measure};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scene = gallery::build("cornell-box", UVec2::splat(16))?;
/// let box_ = measure(&scene.world, &scene.camera, &PathTracer::up_to(3), &Settings::default())?;
/// println!("{:?} ± {:?}", box_.mean(), box_.half_width(0.95));
/// assert!(box_.blind_spots().is_empty());
/// assert!(box_.standard_error().r() < 0.05 * box_.mean().r());
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// If the settings or the camera's film are invalid, the threads cannot be started, or the
/// integrator cannot render the scene.
pub fn measure<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &dyn Render<S>,
    settings: &Settings,
) -> Result<Measurement, RenderError> {
    let (replications, budget) = match settings.budget {
        Budget::Samples(0) => return Err(RenderError::NoSamples),
        Budget::Samples(samples) => {
            let replications = samples.clamp(2, REPLICATIONS);
            (replications, Budget::Samples((samples / replications).max(1)))
        }
        Budget::Time(time) => (REPLICATIONS, Budget::Time(time / REPLICATIONS)),
    };
    let mut measured = Measurement {
        replications: [Estimate::default(); 3],
        samples: 0,
        notes: Notes::default(),
        counters: Counters::default(),
        wall: Duration::ZERO,
    };
    // ANCHOR: replications
    for replication in 0..u64::from(replications) {
        let rendering = integrator.render(
            scene,
            camera,
            &Settings {
                budget,
                seed: settings.seed.wrapping_add(replication.wrapping_mul(SEED_STEP)),
                filter: Filter::Box,
                target_error: None,
                shard: Shard::WHOLE,
                keeps_checkpoint: false,
                ..*settings
            },
        )?;
        let value = rendering.image.mean() * camera.response();
        measured.replications.iter_mut().zip(value.0).for_each(|(all, x)| all.push(x));
        let pixels = u64::from(camera.film().pixels());
        measured.samples += u64::from(rendering.samples_per_pixel) * pixels;
        measured.counters += rendering.counters;
        measured.wall += rendering.wall;
        measured.notes = rendering.notes;
    }
    // ANCHOR_END: replications
    Ok(measured)
}
