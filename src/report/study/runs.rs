//! The runs of one integrator: a warm-up that decides how long they are, then one rendering per
//! seed that is watched on its way.
//!
//! All runs of an integrator have the same number of samples. Where the runs shall reach a target
//! error, the warm-up is what goes on until it is reached, with a seed of its own: so the length of
//! the runs does not depend on what they find, which would make them too dark.

use super::method::{Contestant, Probe};
use super::plan::{Plan, run_seed};
use super::watch::Watch;
use crate::endpoint::Camera;
use crate::film::NonFinite;
use crate::integrator::{Decision, Estimator, Notes};
use crate::path::{Counters, TechniqueSet};
use crate::render::{Budget, Progress, RenderError, Settings};
use crate::report::result::{Pyramid, Snapshot};
use crate::report::stats::{Cost, Errors, Measured, Reference, time_to_error};
use crate::sampler::SamplerKind;
use crate::scene::Scene;
use std::ops::ControlFlow;
use std::time::Duration;

/// Part of an integrator's budget for the probe of its contributions.
const PROBE_PART: u32 = 16;
/// Runs are longer by this than the warm-up took to the target, so that nearly all of them reach it
/// too.
const MARGIN: f64 = 1.25;

/// The object, plan and reference of a measurement.
pub(super) struct Task<'a, S: Scene + ?Sized> {
    pub scene: &'a S,
    pub camera: &'a dyn Camera,
    pub contestant: &'a Contestant<'a, S>,
    pub plan: &'a Plan,
    pub reference: &'a Reference,
}

/// The runs of one integrator.
pub(super) struct Runs {
    settings: Settings,
    pub techniques: TechniqueSet,
    /// Of the warm-up; the bytes are those of the largest map of any run.
    pub notes: Notes,
    pub measured: Measured,
    pub snapshots: Vec<Snapshot>,
    pub counters: Counters,
    pub non_finite: Option<NonFinite>,
    pub total: Cost,
    pub decisions: Vec<Decision>,
    pub energy_by_bounces: Vec<f64>,
    pub pyramid: Option<Pyramid>,
}

impl Runs {
    /// Warms up and decides on the number of samples. If `report` stops the warm-up, so should the
    /// study.
    pub fn prepare<S: Scene + ?Sized>(
        task: &Task<'_, S>,
        stream: u64,
        report: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Self, RenderError> {
        let plan = task.plan;
        let settings = Settings {
            seed: run_seed(plan.settings.seed, stream, 0),
            target_error: None,
            ..plan.settings
        };
        let limit = match plan.budget {
            Budget::Samples(samples) => Budget::Samples((samples / plan.seeds).max(1)),
            Budget::Time(time) => Budget::Time(time / plan.seeds),
        };
        let trial = match limit {
            limit if plan.until_target => limit,
            Budget::Samples(_) => Budget::Samples(1),
            Budget::Time(time) => Budget::Time(time / 4),
        };
        let warm_up = Settings { budget: trial, seed: !settings.seed, ..settings };
        let mut curve = Vec::new();
        let rendering = task.contestant.method.render_with_progress(
            task.scene,
            task.camera,
            &warm_up,
            &mut |p: &Progress<'_>| {
                let flow = report(p.fraction);
                if !plan.until_target || !p.passes.is_power_of_two() {
                    return flow;
                }
                let error = Errors::of(&p.image(), task.reference).relative_mse;
                curve.push((f64::from(p.passes), error));
                if error <= plan.target { ControlFlow::Break(()) } else { flow }
            },
        )?;
        let most = match limit {
            Budget::Samples(samples) => samples,
            Budget::Time(time) => {
                let drawing = rendering.wall.saturating_sub(rendering.preparation);
                let pass =
                    drawing.as_secs_f64().max(1e-9) / f64::from(rendering.samples_per_pixel.max(1));
                let left = time.saturating_sub(rendering.preparation);
                (left.as_secs_f64() / pass).round().clamp(1.0, 1e9) as u32
            }
        };
        let needed = time_to_error(&curve, plan.target)
            .map_or(f64::INFINITY, |samples| (MARGIN * samples).ceil());
        let samples = if needed < f64::from(most) { needed as u32 } else { most };
        Ok(Self {
            settings: Settings { budget: Budget::Samples(samples), ..settings },
            techniques: rendering.techniques,
            measured: Measured {
                name: task.contestant.name.clone(),
                complete: task.contestant.complete,
                estimator: rendering.notes.estimator,
                is_correlated: rendering.notes.is_correlated,
                samples,
                marks: Vec::new(),
                finals: Vec::new(),
                batches: Vec::new(),
                tail: None,
            },
            notes: rendering.notes,
            snapshots: Vec::new(),
            counters: Counters::default(),
            non_finite: None,
            total: Cost::default(),
            decisions: Vec::new(),
            energy_by_bounces: Vec::new(),
            pyramid: None,
        })
    }

    /// The run with one seed. A run that is stopped leaves no trace.
    pub fn render<S: Scene + ?Sized>(
        &mut self,
        task: &Task<'_, S>,
        seed: u32,
        report: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<(), RenderError> {
        let settings = Settings {
            seed: self.settings.seed.wrapping_add(u64::from(seed) << 20),
            ..self.settings
        };
        let Measured { samples, estimator, is_correlated, .. } = self.measured;
        // Passes with a bias of their own, and passes that depend on each other, are no batches.
        let has_batches = settings.sampler == SamplerKind::Independent
            && estimator == Estimator::Unbiased
            && !is_correlated;
        let mut watch = Watch::new(task.reference, samples, has_batches, seed == 0);
        let rendering = task.contestant.method.render_with_progress(
            task.scene,
            task.camera,
            &settings,
            &mut |progress: &Progress<'_>| {
                watch.stop_clock();
                let flow = report(progress.fraction);
                watch.look(progress);
                watch.start_clock();
                flow
            },
        )?;
        if rendering.samples_per_pixel < samples {
            return Ok(());
        }
        let Watch { checkpoints, batches, snapshots, .. } = watch;
        if let Some((_, cost, _)) = checkpoints.last() {
            self.total += *cost;
        }
        self.measured.add(checkpoints, task.reference);
        self.measured.batches.extend(batches);
        self.snapshots.extend(snapshots);
        self.counters += rendering.counters;
        if self.non_finite.is_none() && rendering.non_finite().count() > 0 {
            self.non_finite = Some(rendering.non_finite().clone());
        }
        self.decisions.extend(rendering.notes.decision);
        Ok(())
    }

    /// A look at single contributions.
    pub fn probe<S: Scene + ?Sized>(&mut self, task: &Task<'_, S>) -> Result<(), RenderError> {
        let budget = match task.plan.budget {
            Budget::Samples(samples) => Budget::Samples((samples / PROBE_PART).max(1)),
            Budget::Time(time) => Budget::Time((time / PROBE_PART).max(Duration::from_nanos(1))),
        };
        let settings = Settings { budget, seed: !self.settings.seed, ..self.settings };
        let (method, reference) = (task.contestant.method, task.reference.image());
        let Probe { tail, energy_by_bounces, .. } =
            method.probe(task.scene, task.camera, &settings, reference)?;
        self.measured.tail = tail;
        self.energy_by_bounces = energy_by_bounces;
        Ok(())
    }
}
