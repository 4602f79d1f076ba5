//! Settings of a rendering: budget, seed, threads, filter and sampler.

use super::{CheckpointError, Shard};
use crate::film::{FilmError, Filter, FilterError};
use crate::integrator::{Crew, IntegratorError};
use crate::sampler::{AnySource, SamplerKind};
use std::ops::Range;
use std::time::Duration;

/// When a rendering ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Budget {
    /// After this many samples per pixel.
    Samples(u32),
    /// With the pass whose end is nearest to this wall-clock time, but not before the first.
    /// Progress callbacks do not count. How many samples that makes depends on the machine, so only
    /// a budget in samples gives reproducible images.
    Time(Duration),
}

impl Budget {
    /// The number of samples per pixel, if it is known before.
    pub(crate) fn samples(self) -> Option<u32> {
        match self {
            Self::Samples(samples) => Some(samples),
            Self::Time(_) => None,
        }
    }

    pub(super) fn is_spent(self, passes: u32, wall: Duration, preparation: Duration) -> bool {
        match self {
            Self::Samples(samples) => passes >= samples,
            // Another pass takes about as long as the average one: is its end nearer to the budget
            // than now?
            Self::Time(limit) => {
                let pass = wall.saturating_sub(preparation).as_secs_f64() / f64::from(passes);
                passes == u32::MAX || wall.as_secs_f64() + 0.5 * pass >= limit.as_secs_f64()
            }
        }
    }

    pub(super) fn fraction(self, passes: u32, wall: Duration) -> f64 {
        let fraction = match self {
            Self::Samples(samples) => f64::from(passes) / f64::from(samples),
            Self::Time(limit) if limit.is_zero() => 1.0,
            Self::Time(limit) => wall.as_secs_f64() / limit.as_secs_f64(),
        };
        fraction.min(1.0)
    }
}

/// The settings of a rendering. `Settings { seed: 7, ..Settings::default() }` changes one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// When to end at the latest. Default: 64 samples per pixel.
    pub budget: Budget,
    /// End earlier, once the relative mean squared error of the image is estimated to be this or
    /// less: `mean (I - R)² / (R² + 0.01 mean(R)²)`. It is estimated from how much the image
    /// changes when the number of passes is doubled, with 1/N in between, from 8 passes on; samples
    /// must be independent (with others it comes out too large). A rare, bright contribution that
    /// has not been seen lowers both the estimate and the image, so that an image that ends this
    /// way is a little too dark on average. Default: none.
    pub target_error: Option<f64>,
    /// Different seeds give independent images.
    pub seed: u64,
    /// Number of threads; `None` leaves it to rayon: all processors, `RAYON_NUM_THREADS`, or the
    /// pool that the caller is in. It never changes the image. At most 1024 are started. Without
    /// the feature `parallel`, and on `wasm32-unknown-unknown`, there is one thread.
    pub threads: Option<usize>,
    /// The pixel filter. Default: the pixel's box.
    pub filter: Filter,
    /// The source of random numbers. Default: scrambled Sobol' points, which leave the least
    /// variance for their time, however many samples there will be.
    pub sampler: SamplerKind,
    /// The part of the passes to draw. Default: all of them.
    pub shard: Shard,
    /// True if the rendering is to [have](super::Rendering::checkpoint) its checkpoint in the end.
    /// The scene's [fingerprint](crate::scene::Scene::fingerprint) is made for it, which takes about
    /// a second for a million triangles. Default: false.
    pub keeps_checkpoint: bool,
    /// True to see first which lights [arrive](crate::integrator::Arrivals) in the picture and to
    /// choose among them by that, where there are several. Default: true.
    pub observes_lights: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            budget: Budget::Samples(64),
            target_error: None,
            seed: 0,
            threads: None,
            filter: Filter::Box,
            sampler: SamplerKind::default(),
            shard: Shard::WHOLE,
            keeps_checkpoint: false,
            observes_lights: true,
        }
    }
}

impl Settings {
    /// The source of random numbers. Strata per pixel for stratified sampling are the samples per
    /// pixel if they are known, sets of 64 otherwise.
    pub(super) fn source(&self) -> AnySource {
        self.sampler.source(self.seed, self.budget.samples().unwrap_or(64))
    }

    /// The passes to draw, if the settings are valid.
    pub(super) fn check(&self) -> Result<Range<u32>, RenderError> {
        if self.budget == Budget::Samples(0) {
            return Err(RenderError::NoSamples);
        }
        if let Some(target) = self.target_error {
            if !(target > 0.0 && target.is_finite()) {
                return Err(RenderError::TargetError(target));
            }
            if self.shard != Shard::WHOLE {
                return Err(RenderError::ShardOfTarget(self.shard));
            }
        }
        self.shard.passes(self.budget.samples())
    }
}

/// The reason for which nothing could be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The budget is zero samples.
    #[error("budget is zero samples per pixel")]
    NoSamples,
    /// The target error is not a positive number.
    #[error("target error {0} is not a positive number")]
    TargetError(f64),
    /// The number of threads is zero.
    #[error("number of threads is zero")]
    NoThreads,
    /// The threads could not be started; the reason.
    #[error("threads could not be started: {0}")]
    ThreadPool(String),
    /// A rendering that ends with its time has no parts.
    #[error("shard {0} of a budget in time is not known before: use samples per pixel")]
    ShardOfTime(Shard),
    /// A rendering that ends with its error has no parts, since each sees its own error alone.
    #[error("shard {0} does not know the error of the whole image: use no target error")]
    ShardOfTarget(Shard),
    /// There are fewer passes than shards.
    #[error("shard {shard} has no passes: there are {passes} samples per pixel in all")]
    EmptyShard {
        /// The shard.
        shard: Shard,
        /// The passes of the whole rendering.
        passes: u32,
    },
    /// The integrator learns from all passes.
    #[error("{integrator} learns from the passes before, so it cannot draw shard {shard} alone")]
    ShardOfLearner {
        /// The integrator's name.
        integrator: &'static str,
        /// The shard.
        shard: Shard,
    },
    /// The checkpoint is not one of this rendering.
    #[error("{0}")]
    Checkpoint(#[from] CheckpointError),
    /// The pixel filter is invalid.
    #[error("{0}")]
    Filter(#[from] FilterError),
    /// The camera's film is invalid.
    #[error("{0}")]
    Film(#[from] FilmError),
    /// The integrator cannot render the scene.
    #[error("{0}")]
    Integrator(#[from] IntegratorError),
}

/// More threads than this are not started: they could not be kept busy.
#[cfg(feature = "parallel")]
const MOST_THREADS: usize = 1024;

/// The threads that render chunks.
#[derive(Debug)]
pub(super) enum Threads {
    /// In the calling thread.
    Caller,
    /// In rayon's current pool.
    #[cfg(feature = "parallel")]
    Current,
    /// In a pool of this rendering.
    #[cfg(feature = "parallel")]
    Own(rayon::ThreadPool),
}

impl Threads {
    pub fn new(threads: Option<usize>) -> Result<Self, RenderError> {
        match threads {
            Some(0) => Err(RenderError::NoThreads),
            Some(1) => Ok(Self::Caller),
            // There, no thread can be started.
            _ if cfg!(all(target_family = "wasm", target_os = "unknown")) => Ok(Self::Caller),
            #[cfg(feature = "parallel")]
            Some(threads) => {
                let pool =
                    rayon::ThreadPoolBuilder::new().num_threads(threads.min(MOST_THREADS)).build();
                pool.map(Self::Own).map_err(|e| RenderError::ThreadPool(e.to_string()))
            }
            #[cfg(feature = "parallel")]
            None => Ok(Self::Current),
            #[cfg(not(feature = "parallel"))]
            _ => Ok(Self::Caller),
        }
    }

    /// Calls `main` on this thread, with a function that calls `worker` on another one if there are
    /// several, and returns when all are done.
    pub fn with_workers(&self, worker: &(dyn Fn() + Sync), main: impl FnOnce(&dyn Fn())) {
        match self {
            Self::Caller => main(worker),
            #[cfg(feature = "parallel")]
            Self::Current => rayon::in_place_scope(|scope| main(&|| scope.spawn(|_| worker()))),
            #[cfg(feature = "parallel")]
            Self::Own(pool) => pool.in_place_scope(|scope| main(&|| scope.spawn(|_| worker()))),
        }
    }

    /// The number of threads, this one included.
    pub fn count(&self) -> usize {
        match self {
            Self::Caller => 1,
            #[cfg(feature = "parallel")]
            Self::Current => rayon::current_num_threads(),
            #[cfg(feature = "parallel")]
            Self::Own(pool) => pool.current_num_threads(),
        }
    }
}

impl Crew for Threads {
    fn each(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        #[cfg(feature = "parallel")]
        use rayon::prelude::*;
        match self {
            Self::Caller => (0..count).for_each(task),
            #[cfg(feature = "parallel")]
            Self::Current => (0..count).into_par_iter().for_each(task),
            #[cfg(feature = "parallel")]
            Self::Own(pool) => pool.install(|| (0..count).into_par_iter().for_each(task)),
        }
    }
}
