//! The study: renders with every integrator under several seeds and watches error and cost on the
//! way.
//!
//! Runs alternate (all integrators with the first seed, then all with the second …, each time
//! beginning with another one), so that a machine that slows down slows all alike. A run before the
//! first is discarded: it warms up and tells how many samples a budget of time makes. Those whose
//! first run misses its time all the same make it again; and an integrator has as many runs as its
//! time allows. All its runs have the same number of samples, and checkpoints at powers of two.

use super::machine::setup;
use super::method::Contestant;
use super::plan::{Plan, Step, run_seed};
use super::pyramid::measure_pyramid;
use super::run_file::RunFiles;
use super::runs::{Runs, Task};
use super::summary::{baseline, methods, rankable};
use crate::endpoint::Camera;
use crate::path::TechniqueSet;
use crate::render::{Budget, RenderError, Settings};
use crate::report::error::ReportError;
use crate::report::result::{
    MethodImages, Pyramid, ReferenceInfo, Report, SCHEMA, SceneInfo, Setup, Study, WithoutTechnique,
};
use crate::report::stats::{Layout, Measured, Ranking, Reference, test_pairs};
use crate::scene::Scene;
use std::cell::Cell;
use std::ops::ControlFlow;

/// The number of times that a first run may be made again because it missed its time.
const CORRECTIONS: u32 = 2;

/// Measures integrators on a scene against a reference.
///
/// `info` names the scene; its size is taken from the camera. `progress` is called after each pass,
/// and after each run with the [study so far](Step::study); if it stops, the report has the runs that
/// were finished.
///
/// # Errors
/// If the plan has fewer than two seeds or a target that is no positive number, two contestants
/// have the same name, the reference has another size than the film, or a rendering fails.
pub fn study<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    info: &SceneInfo,
    contestants: &[Contestant<'_, S>],
    reference: Reference,
    plan: &Plan,
    progress: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
) -> Result<Study, ReportError> {
    measure((scene, camera, info), contestants, reference, plan, None, progress)
}

/// True to itself: two seeds at least, a target that is a number, and names that differ.
pub(super) fn check<S: Scene + ?Sized>(
    contestants: &[Contestant<'_, S>],
    plan: &Plan,
) -> Result<(), ReportError> {
    if plan.seeds < 2 {
        return Err(ReportError::TooFewSeeds(plan.seeds));
    }
    for (i, contestant) in contestants.iter().enumerate() {
        if contestants[..i].iter().any(|other| other.name == contestant.name) {
            return Err(ReportError::DuplicateName(contestant.name.clone()));
        }
    }
    match plan.target > 0.0 && plan.target.is_finite() {
        true => Ok(()),
        false => Err(ReportError::Target(plan.target)),
    }
}

/// A study of runs that are rendered, or that are in files.
pub(super) fn measure<S: Scene + ?Sized>(
    (scene, camera, info): (&S, &dyn Camera, &SceneInfo),
    contestants: &[Contestant<'_, S>],
    reference: Reference,
    plan: &Plan,
    files: Option<&RunFiles>,
    progress: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
) -> Result<Study, ReportError> {
    check(contestants, plan)?;
    let image = reference.image();
    let (known, size) = ([image.width(), image.height()], camera.film().window_size().to_array());
    if known != size {
        return Err(ReportError::ReferenceSize(known, size));
    }
    let [width, height] = size;
    let info = SceneInfo { width, height, ..info.clone() };
    let outline = Outline { info, setup: setup(plan), reference: &reference, plan };
    let stopped = Cell::new(false);
    let total = contestants.len() * (1 + plan.seeds as usize);
    let mut report = |label: &str, done: f64, so_far: Option<&dyn Fn() -> Study>| {
        let flow = progress(&Step::new(label, (done / total as f64).min(1.0), so_far));
        stopped.set(stopped.get() | flow.is_break());
        flow
    };
    let (mut runs, mut left_out) = (Vec::new(), Vec::new());
    for (stream, contestant) in contestants.iter().enumerate().take_while(|_| !stopped.get()) {
        let task = Task { scene, camera, contestant, plan };
        let label = format!("{}, warm-up", contestant.name);
        let mut report = |part| report(&label, stream as f64 + part, None);
        let (stream, is_kept) = (stream as u64, files.is_some());
        let run = Runs::prepare(&task, stream, Some(&reference), is_kept, &mut report)
            .map_err(naming(contestant))?;
        if run.techniques == TechniqueSet::NONE {
            left_out.push(WithoutTechnique::new(&contestant.name, &run.notes.left_out));
            continue;
        }
        runs.push((task, stream as u32, run));
    }
    let (mut seed, mut corrections) = (0, CORRECTIONS);
    while !stopped.get() && runs.iter().any(|(.., run)| run.lacks(plan, seed)) {
        for turn in 0..runs.len() {
            let index = (turn + seed as usize) % runs.len();
            let (task, stream, run) = &mut runs[index];
            let (contestant, done) =
                (task.contestant, contestants.len() * (1 + seed as usize) + turn);
            if stopped.get() || !run.lacks(plan, seed) {
                continue;
            }
            let mut draws = |part| report(&contestant.name, done as f64 + part, None);
            let drawn = match files {
                Some(files) => {
                    Some(files.drawn(task, run, (*stream, contestants.len() as u32), seed)?)
                }
                None => run.draw(task, seed, false, &mut draws).map_err(naming(contestant))?,
            };
            if let Some(drawn) = drawn {
                run.add(drawn, &reference);
                let so_far = || outline.study(&finished(&runs), &left_out, None, true);
                // A stop is noticed above.
                let _ = report(&contestant.name, (done + 1) as f64, Some(&so_far));
            }
        }
        // All that missed their time at once: what else the machine does is the same for them.
        let corrects = |any, (.., run): &mut (_, _, Runs)| run.corrects_length(plan) || any;
        let may_correct = seed == 0 && corrections > 0 && !stopped.get();
        if may_correct && runs.iter_mut().fold(false, corrects) {
            corrections -= 1;
        } else {
            seed += 1;
        }
    }
    let stopped = stopped.get();
    let mut ask = || progress(&Step::new("techniques", 1.0, None));
    for (task, _, run) in runs.iter_mut().filter(|_| !stopped) {
        run.probe(task, &reference).map_err(naming(task.contestant))?;
        if task.contestant.pyramid {
            let settings = pyramid_settings(plan);
            let pyramid = task.contestant.method.pyramid(scene, camera, &settings, &mut ask);
            run.pyramid = pyramid.map_err(naming(task.contestant))?;
        }
    }
    let pyramid = match &plan.pyramid {
        Some(integrator) if !stopped => {
            measure_pyramid(scene, camera, integrator, &pyramid_settings(plan), &mut ask)
                .map_err(|source| ReportError::Render { name: "pyramid".to_owned(), source })?
        }
        _ => None,
    };
    Ok(outline.study(&finished(&runs), &left_out, pyramid, stopped))
}

/// Those of the runs that have been drawn.
fn finished<T, U>(runs: &[(T, U, Runs)]) -> Vec<&Runs> {
    let runs = runs.iter().map(|(.., run)| run);
    runs.filter(|run| !run.measured.finals.is_empty()).collect()
}

/// The part of a study that does not depend on its runs.
struct Outline<'a> {
    info: SceneInfo,
    setup: Setup,
    reference: &'a Reference,
    plan: &'a Plan,
}

impl Outline<'_> {
    /// The study that these runs make.
    fn study(
        &self,
        runs: &[&Runs],
        left_out: &[WithoutTechnique],
        pyramid: Option<Pyramid>,
        stopped: bool,
    ) -> Study {
        let Self { info, setup, reference, plan } = self;
        let baseline = baseline(runs, plan);
        let ranked: Vec<&Measured> = rankable(runs).collect();
        let measured: Vec<&Measured> = runs.iter().map(|run| &run.measured).collect();
        let report = Report {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: info.clone(),
            setup: Setup { baseline: baseline.map(|m| m.name.clone()), ..setup.clone() },
            reference: ReferenceInfo::of(reference),
            methods: methods(runs, baseline, reference, plan.target),
            rankings: Ranking::all(&ranked),
            pairs: test_pairs(&measured, Layout::of(reference.image())),
            pyramid: pyramid.as_ref().map(Pyramid::report),
            left_out: left_out.to_vec(),
            stopped,
        };
        let images = runs.iter().map(|run| MethodImages {
            mean: run.measured.mean(),
            snapshots: run.snapshots.clone(),
            pyramid: run.pyramid.clone(),
        });
        Study { report, images: images.collect(), reference: (*reference).clone(), pyramid }
    }
}

pub(super) fn naming<S: Scene + ?Sized>(
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
