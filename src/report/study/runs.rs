//! The runs of one integrator: a warm-up that decides how long they are, then one rendering per
//! seed that is watched on its way.
//!
//! All runs of an integrator have the same number of samples. Under a budget of time the first run
//! tells whether the warm-up found the right one; if not, it is made again with another. Whatever
//! else the machine does on the way, runs are made until the time is used.
//!
//! Where the runs shall reach a target error, the warm-up is what goes on until it is reached, with
//! a seed of its own: so the length of the runs does not depend on what they find, which would make
//! them too dark.

use super::method::{Contestant, Probe};
use super::plan::{Plan, run_seed};
use super::run_file::Drawn;
use super::watch::{Shot, Watch};
use crate::endpoint::Camera;
use crate::integrator::{Estimator, Notes};
use crate::path::{Counters, TechniqueSet};
use crate::render::{Budget, Identity, Progress, RenderError, Settings};
use crate::report::result::{DecisionReport, FindingsReport, Pyramid, Snapshot};
use crate::report::stats::{Cost, Errors, Layout, Measured, Reference, time_to_error};
use crate::sampler::SamplerKind;
use crate::scene::Scene;
use std::ops::ControlFlow;
use std::time::Duration;

/// Part of an integrator's budget for the probe of its contributions.
const PROBE_PART: u32 = 16;
/// Runs are longer by this than the warm-up took to the target, so that nearly all of them reach it
/// too.
const MARGIN: f64 = 1.25;

/// The part of its time by which the first run may miss it.
const TOLERANCE: f64 = 0.1;
/// The most runs, over those that are planned.
const MOST_RUNS: u32 = 4;

/// The object and the plan of a measurement.
pub(super) struct Task<'a, S: Scene + ?Sized> {
    pub scene: &'a S,
    pub camera: &'a dyn Camera,
    pub contestant: &'a Contestant<'a, S>,
    pub plan: &'a Plan,
}

/// The runs of one integrator.
pub(super) struct Runs {
    settings: Settings,
    /// Seconds before the first pass, in the warm-up.
    preparation: f64,
    pub techniques: TechniqueSet,
    /// The identity of the warm-up, if the runs are kept in files.
    pub identity: Option<Identity>,
    /// Of the warm-up; the bytes are those of the largest map of any run.
    pub notes: Notes,
    pub measured: Measured,
    pub snapshots: Vec<Snapshot>,
    pub counters: Counters,
    pub first_non_finite: Option<String>,
    pub total: Cost,
    pub decisions: Vec<DecisionReport>,
    pub findings: Vec<FindingsReport>,
    pub energy_by_bounces: Vec<f64>,
    pub pyramid: Option<Pyramid>,
}

impl Runs {
    /// Warms up and decides on the number of samples, by the reference if they depend on the error.
    /// If `report` stops the warm-up, so should the study.
    pub fn prepare<S: Scene + ?Sized>(
        task: &Task<'_, S>,
        stream: u64,
        reference: Option<&Reference>,
        is_kept: bool,
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
        let warm_up =
            Settings { budget: trial, seed: !settings.seed, keeps_checkpoint: is_kept, ..settings };
        let mut curve = Vec::new();
        let rendering = task.contestant.method.render_with_progress(
            task.scene,
            task.camera,
            &warm_up,
            &mut |p: &Progress<'_>| {
                let flow = report(p.fraction);
                let reference = reference.filter(|_| plan.until_target);
                let Some(reference) = reference.filter(|_| p.passes.is_power_of_two()) else {
                    return flow;
                };
                let error = Errors::of(&p.image(), reference).relative_mse;
                curve.push((f64::from(p.passes), error));
                if error <= plan.target { ControlFlow::Break(()) } else { flow }
            },
        )?;
        let preparation = rendering.preparation.as_secs_f64();
        let most = match limit {
            Budget::Samples(samples) => samples,
            Budget::Time(time) => samples_within(
                time.as_secs_f64(),
                rendering.wall.as_secs_f64(),
                preparation,
                rendering.samples_per_pixel,
            ),
        };
        let needed = time_to_error(&curve, plan.target)
            .map_or(f64::INFINITY, |samples| (MARGIN * samples).ceil());
        let samples = if needed < f64::from(most) { needed as u32 } else { most };
        Ok(Self {
            settings: Settings { budget: Budget::Samples(samples), ..settings },
            preparation,
            techniques: rendering.techniques,
            identity: rendering.checkpoint.map(|checkpoint| checkpoint.identity),
            measured: Measured::new(
                task.contestant.name.clone(),
                task.contestant.complete,
                rendering.notes.estimator,
                rendering.notes.is_correlated,
                samples,
            ),
            notes: rendering.notes,
            snapshots: Vec::new(),
            counters: Counters::default(),
            first_non_finite: None,
            total: Cost::default(),
            decisions: Vec::new(),
            findings: Vec::new(),
            energy_by_bounces: Vec::new(),
            pyramid: None,
        })
    }

    /// The seed of a run.
    pub fn seed(&self, run: u32) -> u64 {
        self.settings.seed.wrapping_add(u64::from(run) << 20)
    }

    /// The rendering with one seed; none if it was stopped. `is_kept` says whether it is to go into
    /// a file, which tells what it is of.
    pub fn draw<S: Scene + ?Sized>(
        &self,
        task: &Task<'_, S>,
        seed: u32,
        is_kept: bool,
        report: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Option<Drawn>, RenderError> {
        let settings =
            Settings { seed: self.seed(seed), keeps_checkpoint: is_kept, ..self.settings };
        let Measured { samples, estimator, is_correlated, .. } = self.measured;
        // Passes with a bias of their own, and passes that depend on each other, are no batches.
        let has_batches = settings.sampler == SamplerKind::Independent
            && estimator == Estimator::Unbiased
            && !is_correlated;
        let [width, height] = task.camera.film().window_size().to_array();
        let mut watch = Watch::new(Layout { width, height }, samples, has_batches, seed == 0);
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
        let is_whole = rendering.samples_per_pixel >= samples;
        Ok(is_whole.then(|| Drawn::new(watch, &rendering)))
    }

    /// Adds a rendering, that with the next seed.
    pub fn add(&mut self, drawn: Drawn, reference: &Reference) {
        let Drawn { checkpoints, batches, snapshots, counters, .. } = drawn;
        if let Some((_, cost, _)) = checkpoints.last() {
            self.total += *cost;
        }
        self.measured.add(checkpoints, reference);
        self.measured.batches.extend(batches);
        self.snapshots.extend(snapshots.into_iter().map(|shot| {
            let Shot { part, samples, wall, image } = shot;
            let errors = Errors::of(&image, reference);
            Snapshot { part, samples, wall, image, errors }
        }));
        self.counters += counters;
        self.first_non_finite = self.first_non_finite.take().or(drawn.first_non_finite);
        self.decisions.extend(drawn.decision);
        self.findings.extend(drawn.findings);
    }

    /// True if the run of this number is the next one and is to be made: as many as are planned; or
    /// under a budget of time, but at least two, until another one would end farther from it.
    pub fn lacks(&self, plan: &Plan, number: u32) -> bool {
        let is_within = match plan.budget {
            Budget::Time(time) if !plan.until_target => {
                let (used, runs) = (self.total.wall, f64::from(number));
                let is_nearer = used * (1.0 + 0.5 / runs) < time.as_secs_f64();
                number < 2 || is_nearer && number < MOST_RUNS * plan.seeds
            }
            _ => number < plan.seeds,
        };
        is_within && self.measured.finals.len() == number as usize
    }

    /// Forgets the first run, and changes the number of samples, if it missed its time. True if so.
    pub fn corrects_length(&mut self, plan: &Plan) -> bool {
        let (Budget::Time(time), Some(first)) = (plan.budget, self.measured.costs().first()) else {
            return false;
        };
        let (time, before) = ((time / plan.seeds).as_secs_f64(), self.measured.samples);
        let samples = samples_within(time, first.wall, self.preparation, before);
        let off = f64::from(samples.abs_diff(before)) / f64::from(before);
        if plan.until_target || off <= TOLERANCE {
            return false;
        }
        self.settings.budget = Budget::Samples(samples);
        let Measured { name, complete, estimator, is_correlated, .. } = &self.measured;
        self.measured = Measured::new(name.clone(), *complete, *estimator, *is_correlated, samples);
        self.snapshots.clear();
        self.counters = Counters::default();
        self.first_non_finite = None;
        self.total = Cost::default();
        self.decisions.clear();
        self.findings.clear();
        true
    }

    /// A look at single contributions.
    pub fn probe<S: Scene + ?Sized>(
        &mut self,
        task: &Task<'_, S>,
        reference: &Reference,
    ) -> Result<(), RenderError> {
        let budget = match task.plan.budget {
            Budget::Samples(samples) => Budget::Samples((samples / PROBE_PART).max(1)),
            Budget::Time(time) => Budget::Time((time / PROBE_PART).max(Duration::from_nanos(1))),
        };
        let settings = Settings { budget, seed: !self.settings.seed, ..self.settings };
        let (method, reference) = (task.contestant.method, reference.image());
        let Probe { tail, energy_by_bounces, .. } =
            method.probe(task.scene, task.camera, &settings, reference)?;
        self.measured.tail = tail;
        self.energy_by_bounces = energy_by_bounces;
        Ok(())
    }
}

/// The number of samples per pixel that take this time, if so many took `wall`; at least one.
fn samples_within(time: f64, wall: f64, preparation: f64, samples: u32) -> u32 {
    let pass = (wall - preparation).max(1e-9) / f64::from(samples.max(1));
    ((time - preparation) / pass).round().clamp(1.0, 1e9) as u32
}
