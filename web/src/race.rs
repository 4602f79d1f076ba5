//! The rendering of a scene by one integrator, as it proceeds.

use crate::Fallible;
use crate::catalogue::{INTEGRATORS, word};
use crate::lesson::Lesson;
use pathspace::math::Fingerprint;
use pathspace::path::Counters;
use pathspace::render::{Budget, Progress, Settings};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::time::Duration;
use web_time::Instant;

/// Time between two looks at a rendering.
const PERIOD: Duration = Duration::from_millis(200);

/// A rendering by an integrator.
#[derive(Clone, Debug, Deserialize)]
pub struct RaceJob {
    /// The integrator's name.
    pub integrator: String,
    /// The end, the seed and the radius.
    #[serde(flatten)]
    pub effort: Effort,
}

/// The settings that all jobs have.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Effort {
    /// Wall-clock time after which it ends.
    pub seconds: Option<f64>,
    /// Samples per pixel after which it ends, if no time is given; without either it goes on until
    /// it is stopped.
    pub samples: Option<u32>,
    /// The seed.
    #[serde(default)]
    pub seed: u64,
    /// The radius within which subpaths merge in the first pass; `None` for the usual one.
    pub radius: Option<f64>,
}

/// The state of a rendering.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Samples per pixel.
    pub passes: u32,
    /// Wall-clock time.
    pub seconds: f64,
    /// Rays traced.
    pub rays: u64,
    /// Samples drawn.
    pub samples: u64,
}

impl Report {
    pub(crate) fn new(passes: u32, time: Duration, counters: &Counters) -> Self {
        let Counters { samples, closest_rays, shadow_rays, .. } = *counters;
        Self { passes, seconds: time.as_secs_f64(), rays: closest_rays + shadow_rays, samples }
    }
}

/// A rendering that has ended.
#[derive(Clone, Debug, Serialize)]
pub struct Finished {
    /// The last state.
    #[serde(flatten)]
    pub report: Report,
    /// The part of the time before the first pass.
    pub preparation: f64,
    /// The kind of the estimate: unbiased, consistent or biased.
    pub estimator: &'static str,
    /// The paths that the image lacks, in words.
    pub missing: Vec<String>,
    /// The techniques that were not needed, each with the reason.
    pub left_out: Vec<String>,
    /// True if it was stopped.
    pub stopped: bool,
    /// A number that two images share only if they are the same to the bit.
    pub fingerprint: String,
}

impl Effort {
    /// The end.
    pub(crate) fn budget(&self) -> Fallible<Budget> {
        match (self.seconds, self.samples) {
            (Some(seconds), _) => Duration::try_from_secs_f64(seconds)
                .map(Budget::Time)
                .map_err(|error| format!("{seconds} s is no time to render: {error}")),
            (None, samples) => Ok(Budget::Samples(samples.unwrap_or(u32::MAX))),
        }
    }
}

impl Lesson {
    /// Renders, and shows what there is after the first pass, then a few times a second, and at the
    /// end; `progress` says whether to stop.
    ///
    /// # Errors
    /// There is no such integrator, or it cannot render the scene.
    pub fn render(
        &self,
        job: &RaceJob,
        progress: &mut dyn FnMut(&Report, &[f32]) -> bool,
    ) -> Fallible<Finished> {
        let entry = INTEGRATORS.iter().find(|entry| entry.name == job.integrator);
        let entry = entry.ok_or_else(|| format!("there is no integrator {:?}", job.integrator))?;
        let integrator = (entry.build)(self.depths(), job.effort.radius);
        let settings = Settings {
            budget: job.effort.budget()?,
            seed: job.effort.seed,
            filter: self.filter,
            ..Settings::default()
        };
        let mut shown: Option<Instant> = None;
        let mut show = |now: &Progress<'_>| {
            if shown.is_some_and(|shown| shown.elapsed() < PERIOD) {
                return ControlFlow::Continue(());
            }
            shown = Some(Instant::now());
            let report = Report::new(now.passes, now.wall, now.counters);
            if progress(&report, &now.image().to_f32()) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let rendering = integrator
            .render_with_progress(&self.world, &*self.camera, &settings, &mut show)
            .map_err(|error| error.to_string())?;
        let report = Report::new(rendering.samples_per_pixel, rendering.wall, &rendering.counters);
        progress(&report, &rendering.image.to_f32());
        Ok(Finished {
            report,
            preparation: rendering.preparation.as_secs_f64(),
            estimator: word(rendering.notes.estimator),
            missing: rendering.notes.missing.iter().map(ToString::to_string).collect(),
            left_out: rendering
                .notes
                .left_out
                .items()
                .map(|(what, why)| format!("{what}: {why}"))
                .collect(),
            stopped: rendering.stopped,
            fingerprint: format!("{:016x}", Fingerprint::of(rendering.image.pixels())),
        })
    }
}
