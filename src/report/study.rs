//! The study: renders with every integrator under several seeds and watches error and cost on the way.
//!
//! Runs alternate (all integrators with the first seed, then all with the second …, each time beginning with another one), so that a machine that slows
//! down slows all alike. A run before the first is discarded: it warms up and tells how many samples a budget of time makes. All runs of
//! an integrator have the same number of samples, and checkpoints at powers of two.

use super::analysis::{self, Measured};
use super::batches::{Batch, Layout};
use super::error::ReportError;
use super::method::{Contestant, Probe};
use super::metrics::Errors;
use super::pyramid::{Pyramid, measure_pyramid};
use super::reference::Reference;
use super::result::{Cost, Report, SceneInfo};
use crate::endpoint::Camera;
use crate::film::{Image, NonFinite};
use crate::integrator::Bidirectional;
use crate::math::Rgb;
use crate::path::{Counters, LeftOut, TechniqueSet};
use crate::render::{Budget, Progress, RenderError, Settings};
use crate::sampler::SamplerKind;
use crate::scene::Scene;
use cpu_time::ProcessTime;
use std::ops::ControlFlow;
use std::time::Duration;

/// How to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// For each integrator, all its runs together.
    pub budget: Budget,
    /// Independent runs of each integrator; at least two. Default: 8.
    pub seeds: u32,
    /// Filter, sampler, threads, and the seed that those of the runs are derived from. The budget in it is not used.
    pub settings: Settings,
    /// relMSE whose time is asked for. Default: 0.01.
    pub target: f64,
    /// The name of the integrator that speed-ups are relative to. Default: the first that sees everything.
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
    /// The first run after about 1/16, 1/4 and all of its budget.
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

/// Parts of a run's budget after which the first run's image is kept.
const SNAPSHOTS: [f64; 3] = [1.0 / 16.0, 0.25, 1.0];
/// Independent batches that each run is cut into, for the test of bias; only if samples are independent.
const BATCHES_PER_RUN: u32 = 4;
/// Part of an integrator's budget for the probe of its contributions.
const PROBE_PART: u32 = 16;

/// A seed of its own for each run of each stream of renderings.
pub(super) fn run_seed(base: u64, stream: u64, run: u32) -> u64 {
    base.wrapping_add((stream + 1) << 40).wrapping_add(u64::from(run) << 20)
}

/// Measures integrators on a scene against a reference.
///
/// `info` names the scene; its size is taken from the camera. `progress` is called after each pass; if it stops, the report has the runs that
/// were finished.
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
    let (layout, size) = (Layout::of(reference.image()), camera.film().window_size());
    if [layout.width, layout.height] != size.to_array() {
        return Err(ReportError::ReferenceSize([layout.width, layout.height], size.to_array()));
    }
    let setup = analysis::setup(plan);
    let (mut runs, mut left_out) = (Vec::new(), Vec::new());
    for (stream, contestant) in (0..).zip(contestants) {
        let run = Runs::prepare(scene, camera, contestant, plan, stream, layout).map_err(naming(contestant))?;
        if run.techniques == TechniqueSet::NONE { left_out.push(contestant.name.clone()) } else { runs.push((contestant, run)) }
    }
    let total = runs.len() * plan.seeds as usize;
    let mut stopped = false;
    'all: for seed in 0..plan.seeds {
        for turn in 0..runs.len() {
            let index = (turn + seed as usize) % runs.len();
            let (contestant, run) = &mut runs[index];
            let done = seed as usize * total / plan.seeds as usize + turn;
            let mut report = |fraction: f64| {
                let step = Step { label: &contestant.name, fraction: (done as f64 + fraction) / total as f64 };
                let flow = progress(&step);
                stopped |= flow.is_break();
                flow
            };
            run.render(scene, camera, contestant, &reference, seed, &mut report).map_err(naming(contestant))?;
            if stopped {
                break 'all;
            }
        }
    }
    let mut measured = Vec::new();
    for (contestant, run) in runs {
        let probe =
            if stopped { Probe::default() } else { run.probe(scene, camera, contestant, plan, &reference).map_err(naming(contestant))? };
        if !run.finals.is_empty() {
            measured.push(run.finish(contestant, probe));
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
    let report = analysis::report(&measured, &reference, info, setup, plan, pyramid.as_ref(), left_out, stopped);
    let images = measured.into_iter().map(|m| MethodImages { mean: m.mean, snapshots: m.snapshots }).collect();
    Ok(Study { report, images, reference, pyramid })
}

fn naming<S: Scene + ?Sized>(contestant: &Contestant<'_, S>) -> impl FnOnce(RenderError) -> ReportError {
    let name = contestant.name.clone();
    |source| ReportError::Render { name, source }
}

fn pyramid_settings(plan: &Plan) -> Settings {
    let budget = match plan.budget {
        Budget::Samples(samples) => Budget::Samples((samples / 8).clamp(2, 64)),
        Budget::Time(time) => Budget::Time(time / 4),
    };
    Settings { budget, seed: run_seed(plan.settings.seed, 2000, 0), ..plan.settings }
}

/// What all runs have at one checkpoint.
pub(super) struct Mark {
    pub samples: u32,
    pub cost: Vec<Cost>,
    pub errors: Vec<Errors>,
    /// Sum over runs of I - R, and of the mean of its square.
    pub deviation: Image,
    pub squares: f64,
}

/// The runs of one integrator.
struct Runs {
    settings: Settings,
    samples: u32,
    layout: Layout,
    techniques: TechniqueSet,
    left_out: LeftOut,
    marks: Vec<Mark>,
    finals: Vec<Image>,
    batches: Vec<Batch>,
    snapshots: Vec<Snapshot>,
    counters: Counters,
    non_finite: Option<NonFinite>,
    total: Cost,
}

impl Runs {
    /// Warms up and decides on the number of samples.
    fn prepare<S: Scene + ?Sized>(
        scene: &S,
        camera: &dyn Camera,
        contestant: &Contestant<'_, S>,
        plan: &Plan,
        stream: u64,
        layout: Layout,
    ) -> Result<Self, RenderError> {
        let settings = Settings { seed: run_seed(plan.settings.seed, stream, 0), ..plan.settings };
        let share = match plan.budget {
            Budget::Samples(samples) => Budget::Samples((samples / plan.seeds).max(1)),
            Budget::Time(time) => Budget::Time(time / plan.seeds),
        };
        let trial = match share {
            Budget::Samples(_) => Budget::Samples(1),
            Budget::Time(time) => Budget::Time(time / 4),
        };
        let warm_up = Settings { budget: trial, seed: !settings.seed, ..settings };
        let rendering = contestant.method.render(scene, camera, &warm_up, &mut crate::render::unattended)?;
        let samples = match share {
            Budget::Samples(samples) => samples,
            Budget::Time(time) => {
                let pass = rendering.wall.as_secs_f64().max(1e-9) / f64::from(rendering.samples_per_pixel.max(1));
                (time.as_secs_f64() / pass).round().clamp(1.0, 1e9) as u32
            }
        };
        Ok(Self {
            settings: Settings { budget: Budget::Samples(samples), ..settings },
            samples,
            layout,
            techniques: rendering.techniques,
            left_out: rendering.left_out,
            marks: Vec::new(),
            finals: Vec::new(),
            batches: Vec::new(),
            snapshots: Vec::new(),
            counters: Counters::default(),
            non_finite: None,
            total: Cost::default(),
        })
    }

    /// The run with one seed. A run that is stopped leaves no trace.
    fn render<S: Scene + ?Sized>(
        &mut self,
        scene: &S,
        camera: &dyn Camera,
        contestant: &Contestant<'_, S>,
        reference: &Reference,
        seed: u32,
        report: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<(), RenderError> {
        let settings = Settings { seed: self.settings.seed.wrapping_add(u64::from(seed) << 20), ..self.settings };
        let cuts = if settings.sampler == SamplerKind::Independent { BATCHES_PER_RUN.min(self.samples) } else { 1 };
        let cut = |i: u32| (u64::from(self.samples) * u64::from(i) / u64::from(cuts)) as u32;
        let (mut marks, mut batches, mut snapshots) = (Vec::new(), Vec::<Batch>::new(), Vec::new());
        let mut sums_before = vec![0.0; self.layout.blocks()];
        let mut passes_before = 0;
        let mut clock = Clock::start();
        let mut cpu = 0.0;
        let rendering = contestant.method.render(scene, camera, &settings, &mut |p: &Progress<'_>| {
            cpu += clock.lap();
            let (last, due) = (p.passes == self.samples, batches.len() as u32 + 1);
            let flow = report(p.fraction);
            let is_mark = p.passes.is_power_of_two() || last;
            let is_cut = p.passes == cut(due);
            let part = SNAPSHOTS.get(snapshots.len()).copied().filter(|part| seed == 0 && p.fraction >= *part);
            if is_mark || is_cut || part.is_some() {
                let image = p.image();
                if is_mark {
                    let cost =
                        Cost { wall: p.wall.as_secs_f64(), cpu, rays: p.counters.rays() as f64, scattered: p.counters.scattered as f64 };
                    marks.push((p.passes, cost, image.clone()));
                }
                if is_cut {
                    let sums: Vec<f64> = self.layout.block_means(&image).iter().map(|m| m * f64::from(p.passes)).collect();
                    let samples = f64::from(p.passes - passes_before);
                    let blocks = sums.iter().zip(&sums_before).map(|(a, b)| (a - b) / samples).collect();
                    batches.push(Batch { samples, blocks });
                    (sums_before, passes_before) = (sums, p.passes);
                }
                if let Some(part) = part {
                    let errors = Errors::of(&image, reference);
                    snapshots.push(Snapshot { part, samples: p.passes, wall: p.wall.as_secs_f64(), image, errors });
                }
            }
            clock.lap();
            flow
        })?;
        if rendering.samples_per_pixel < self.samples {
            return Ok(());
        }
        for (index, (samples, cost, image)) in marks.into_iter().enumerate() {
            self.mark(index, samples, cost, &image, reference);
            if samples == self.samples {
                self.finals.push(image);
                let total = &mut self.total;
                *total = Cost {
                    wall: total.wall + cost.wall,
                    cpu: total.cpu + cost.cpu,
                    rays: total.rays + cost.rays,
                    scattered: total.scattered + cost.scattered,
                };
            }
        }
        self.batches.extend(batches);
        self.snapshots.extend(snapshots);
        self.counters += rendering.counters;
        if self.non_finite.is_none() && rendering.non_finite().count() > 0 {
            self.non_finite = Some(rendering.non_finite().clone());
        }
        Ok(())
    }

    fn mark(&mut self, index: usize, samples: u32, cost: Cost, image: &Image, reference: &Reference) {
        if self.marks.len() == index {
            let deviation = Image::from_fn(image.width(), image.height(), |_, _| Rgb::BLACK);
            self.marks.push(Mark { samples, cost: Vec::new(), errors: Vec::new(), deviation, squares: 0.0 });
        }
        let mark = &mut self.marks[index];
        mark.cost.push(cost);
        mark.errors.push(Errors::of(image, reference));
        let mut squares = 0.0;
        let pixels = image.pixels().iter().zip(reference.image().pixels());
        for (sum, (i, r)) in mark.deviation.pixels_mut().iter_mut().zip(pixels) {
            let deviation = *i - *r;
            *sum += deviation;
            squares += (deviation * deviation).mean();
        }
        mark.squares += squares / image.pixels().len().max(1) as f64;
    }

    fn probe<S: Scene + ?Sized>(
        &self,
        scene: &S,
        camera: &dyn Camera,
        contestant: &Contestant<'_, S>,
        plan: &Plan,
        reference: &Reference,
    ) -> Result<Probe, RenderError> {
        let budget = match plan.budget {
            Budget::Samples(samples) => Budget::Samples((samples / PROBE_PART).max(1)),
            Budget::Time(time) => Budget::Time((time / PROBE_PART).max(Duration::from_nanos(1))),
        };
        let settings = Settings { budget, seed: !self.settings.seed, ..self.settings };
        contestant.method.probe(scene, camera, &settings, reference.image())
    }

    fn finish<S: Scene + ?Sized>(self, contestant: &Contestant<'_, S>, probe: Probe) -> Measured {
        let mean = super::metrics::mean_image(&self.finals).unwrap_or_else(|| Image::from_fn(0, 0, |_, _| Rgb::BLACK));
        Measured {
            name: contestant.name.clone(),
            complete: contestant.complete,
            techniques: self.techniques,
            left_out: self.left_out,
            samples: self.samples,
            marks: self.marks,
            finals: self.finals,
            mean,
            batches: self.batches,
            snapshots: self.snapshots,
            counters: self.counters,
            non_finite: self.non_finite,
            total: self.total,
            probe,
        }
    }
}

/// Processor time of the process.
struct Clock(Option<ProcessTime>);

impl Clock {
    fn start() -> Self {
        Self(ProcessTime::try_now().ok())
    }

    /// Seconds since the last call; 0 if the system does not tell.
    fn lap(&mut self) -> f64 {
        let now = ProcessTime::try_now().ok();
        let seconds = now.zip(self.0).map_or(0.0, |(now, before)| now.duration_since(before).as_secs_f64());
        self.0 = now;
        seconds
    }
}
