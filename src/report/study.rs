//! The study: renders with every integrator under several seeds and watches error and cost on the
//! way.
//!
//! Runs alternate (all integrators with the first seed, then all with the second …, each time
//! beginning with another one), so that a machine that slows down slows all alike. A run before the
//! first is discarded: it warms up and tells how many samples a budget of time makes. All runs of
//! an integrator have the same number of samples, and checkpoints at powers of two.

use super::analysis;
use super::batches::Layout;
use super::error::ReportError;
use super::leave_out::WithoutTechnique;
use super::method::{Contestant, Probe};
use super::metrics::Errors;
use super::pyramid::{Pyramid, measure_pyramid};
use super::reference::Reference;
use super::result::{Report, SceneInfo};
use super::runs::{Runs, Task, run_seed};
use crate::endpoint::Camera;
use crate::film::Image;
use crate::integrator::Bidirectional;
use crate::path::TechniqueSet;
use crate::render::{Budget, RenderError, Settings};
use crate::scene::Scene;
use std::cell::Cell;
use std::ops::ControlFlow;

/// How to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// For each integrator, all its runs together: when they end, or end at the latest if
    /// `until_target`.
    pub budget: Budget,
    /// Independent runs of each integrator; at least two. Default: 8.
    pub seeds: u32,
    /// Filter, sampler, threads, and the seed that those of the runs are derived from. Its budget
    /// and target error are not used.
    pub settings: Settings,
    /// relMSE of a run whose time is asked for. Default: 0.01.
    pub target: f64,
    /// Whether runs are only as long as it takes to the target: the discarded run before them goes
    /// on until its error against the reference is below it, and the others get 1.25 times the
    /// samples that it took. Default: no.
    pub until_target: bool,
    /// The name of the integrator that speed-ups are relative to. Default: the first that sees
    /// everything and whose variance is finite.
    pub baseline: Option<String>,
    /// Bidirectional path tracing whose techniques are measured one by one, if wanted.
    pub pyramid: Option<Bidirectional>,
    /// The command that makes this report again, to be printed.
    pub command: Option<String>,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            budget: Budget::Samples(64),
            seeds: 8,
            settings: Settings::default(),
            target: 0.01,
            until_target: false,
            baseline: None,
            pyramid: None,
            command: None,
        }
    }
}

/// How far a study is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step<'a> {
    /// What is being done.
    pub label: &'a str,
    /// Part of the work that is done, 0 to 1.
    pub fraction: f64,
}

/// A finished, or stopped, study.
#[derive(Clone, Debug)]
pub struct Study {
    /// The numbers.
    pub report: Report,
    /// Images of each integrator, in the order of `report.methods`.
    pub images: Vec<MethodImages>,
    /// The reference.
    pub reference: Reference,
    /// Images of the techniques.
    pub pyramid: Option<Pyramid>,
}

/// Images of one integrator.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodImages {
    /// Mean of all runs.
    pub mean: Image,
    /// The first run after about 1/16, 1/4 and all of its budget, as far as a sample per pixel
    /// takes less.
    pub snapshots: Vec<Snapshot>,
}

/// An image of the first run.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Part of the budget of a run.
    pub part: f64,
    /// Samples per pixel.
    pub samples: u32,
    /// Wall-clock seconds.
    pub wall: f64,
    /// The image.
    pub image: Image,
    /// Its errors.
    pub errors: Errors,
}

/// Measures integrators on a scene against a reference.
///
/// `info` names the scene; its size is taken from the camera. `progress` is called after each pass;
/// if it stops, the report has the runs that were finished.
///
/// # Errors
/// If the plan has fewer than two seeds, two contestants have the same name, the reference has another size than the film, or a rendering fails.
pub fn study<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    info: &SceneInfo,
    contestants: &[Contestant<'_, S>],
    reference: Reference,
    plan: &Plan,
    progress: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
) -> Result<Study, ReportError> {
    if plan.seeds < 2 {
        return Err(ReportError::TooFewSeeds(plan.seeds));
    }
    for (i, contestant) in contestants.iter().enumerate() {
        if contestants[..i].iter().any(|other| other.name == contestant.name) {
            return Err(ReportError::DuplicateName(contestant.name.clone()));
        }
    }
    if !(plan.target > 0.0 && plan.target.is_finite()) {
        return Err(ReportError::Target(plan.target));
    }
    let (layout, size) = (Layout::of(reference.image()), camera.film().window_size());
    if [layout.width, layout.height] != size.to_array() {
        return Err(ReportError::ReferenceSize([layout.width, layout.height], size.to_array()));
    }
    let setup = analysis::setup(plan);
    let stopped = Cell::new(false);
    let total = contestants.len() * (1 + plan.seeds as usize);
    let mut report = |label: &str, done: usize, part: f64| {
        let flow = progress(&Step { label, fraction: (done as f64 + part) / total as f64 });
        stopped.set(stopped.get() | flow.is_break());
        flow
    };
    let (mut runs, mut left_out) = (Vec::new(), Vec::new());
    for (stream, contestant) in contestants.iter().enumerate().take_while(|_| !stopped.get()) {
        let task = Task { scene, camera, contestant, plan, reference: &reference };
        let label = format!("{}, warm-up", contestant.name);
        let run = Runs::prepare(&task, stream as u64, &mut |part| report(&label, stream, part))
            .map_err(naming(contestant))?;
        if run.techniques() == TechniqueSet::NONE {
            left_out.push(WithoutTechnique::new(&contestant.name, &run.left_out()));
            continue;
        }
        runs.push((task, run));
    }
    let turns = (0..plan.seeds)
        .flat_map(|seed| (0..runs.len()).map(move |turn| (seed, turn)))
        .collect::<Vec<_>>();
    for (seed, turn) in turns.into_iter().take_while(|_| !stopped.get()) {
        let index = (turn + seed as usize) % runs.len();
        let (task, run) = &mut runs[index];
        let done = contestants.len() * (1 + seed as usize) + turn;
        run.render(task, seed, &mut |part| report(&task.contestant.name, done, part))
            .map_err(naming(task.contestant))?;
    }
    let stopped = stopped.get();
    let mut measured = Vec::new();
    for (task, run) in runs {
        let probe = if stopped {
            Probe::default()
        } else {
            run.probe(&task).map_err(naming(task.contestant))?
        };
        if !run.is_empty() {
            measured.push(run.finish(task.contestant, probe));
        }
    }
    let pyramid = match &plan.pyramid {
        Some(integrator) if !stopped => {
            let step = Step { label: "techniques", fraction: 1.0 };
            let mut ask = || progress(&step);
            measure_pyramid(scene, camera, integrator, &pyramid_settings(plan), &mut ask)
                .map_err(|source| ReportError::Render { name: "pyramid".to_owned(), source })?
        }
        _ => None,
    };
    let info = SceneInfo { width: layout.width, height: layout.height, ..info.clone() };
    let report = analysis::report(
        &measured,
        &reference,
        info,
        setup,
        plan,
        pyramid.as_ref(),
        left_out,
        stopped,
    );
    let images = measured
        .into_iter()
        .map(|m| MethodImages { mean: m.mean, snapshots: m.snapshots })
        .collect();
    Ok(Study { report, images, reference, pyramid })
}

fn naming<S: Scene + ?Sized>(
    contestant: &Contestant<'_, S>,
) -> impl FnOnce(RenderError) -> ReportError {
    let name = contestant.name.clone();
    |source| ReportError::Render { name, source }
}

fn pyramid_settings(plan: &Plan) -> Settings {
    let budget = match plan.budget {
        Budget::Samples(samples) => Budget::Samples((samples / 8).clamp(2, 64)),
        Budget::Time(time) => Budget::Time(time / 4),
    };
    Settings {
        budget,
        seed: run_seed(plan.settings.seed, 2000, 0),
        target_error: None,
        ..plan.settings
    }
}
