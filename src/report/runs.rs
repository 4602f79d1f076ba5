//! The runs of one integrator: a warm-up that decides how long they are, then one rendering per
//! seed that is watched on its way.
//!
//! All runs of an integrator have the same number of samples, and checkpoints at powers of two and
//! at the end. Looking at the image does not count as time. Where the runs shall reach a target
//! error, the warm-up is what goes on until it is reached, with a seed of its own: so the length of
//! the runs does not depend on what they find, which would make them too dark.

use super::analysis::Measured;
use super::batches::{Batch, Layout};
use super::inference::time_to_error;
use super::method::{Contestant, Probe};
use super::metrics::{Errors, mean_image};
use super::reference::Reference;
use super::result::Cost;
use super::study::{Plan, Snapshot};
use crate::endpoint::Camera;
use crate::film::{Image, NonFinite};
use crate::integrator::Decision;
use crate::math::Rgb;
use crate::path::{Counters, LeftOut, TechniqueSet};
use crate::render::{Budget, Progress, RenderError, Settings};
use crate::sampler::SamplerKind;
use crate::scene::Scene;
use cpu_time::ProcessTime;
use std::ops::ControlFlow;
use std::time::Duration;

/// Parts of a run's budget after which the first run's image is kept.
pub(super) const SNAPSHOTS: [f64; 3] = [1.0 / 16.0, 0.25, 1.0];
/// Independent batches that each run is cut into, for the test of bias; only if samples are
/// independent.
const BATCHES_PER_RUN: u32 = 4;
/// Part of an integrator's budget for the probe of its contributions.
const PROBE_PART: u32 = 16;
/// Runs are longer by this than the warm-up took to the target, so that nearly all of them reach it
/// too.
const MARGIN: f64 = 1.25;

/// A seed of its own for each run of each stream of renderings.
pub(super) fn run_seed(base: u64, stream: u64, run: u32) -> u64 {
    base.wrapping_add((stream + 1) << 40).wrapping_add(u64::from(run) << 20)
}

/// What is measured, how, and against what.
pub(super) struct Task<'a, S: Scene + ?Sized> {
    pub scene: &'a S,
    pub camera: &'a dyn Camera,
    pub contestant: &'a Contestant<'a, S>,
    pub plan: &'a Plan,
    pub reference: &'a Reference,
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
pub(super) struct Runs {
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
    decisions: Vec<Decision>,
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
        let rendering = task.contestant.method.render(
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
                let pass = rendering.wall.as_secs_f64().max(1e-9)
                    / f64::from(rendering.samples_per_pixel.max(1));
                (time.as_secs_f64() / pass).round().clamp(1.0, 1e9) as u32
            }
        };
        let needed = time_to_error(&curve, plan.target)
            .map_or(f64::INFINITY, |samples| (MARGIN * samples).ceil());
        let samples = if needed < f64::from(most) { needed as u32 } else { most };
        Ok(Self {
            settings: Settings { budget: Budget::Samples(samples), ..settings },
            samples,
            layout: Layout::of(task.reference.image()),
            techniques: rendering.techniques,
            left_out: rendering.left_out,
            marks: Vec::new(),
            finals: Vec::new(),
            batches: Vec::new(),
            snapshots: Vec::new(),
            counters: Counters::default(),
            non_finite: None,
            total: Cost::default(),
            decisions: Vec::new(),
        })
    }

    pub fn techniques(&self) -> TechniqueSet {
        self.techniques
    }

    pub fn left_out(&self) -> LeftOut {
        self.left_out
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
        let cuts = if settings.sampler == SamplerKind::Independent {
            BATCHES_PER_RUN.min(self.samples)
        } else {
            1
        };
        let cut = |i: u32| (u64::from(self.samples) * u64::from(i) / u64::from(cuts)) as u32;
        let (mut marks, mut batches, mut snapshots) = (Vec::new(), Vec::<Batch>::new(), Vec::new());
        let mut sums_before = vec![0.0; self.layout.blocks()];
        let mut passes_before = 0;
        let mut clock = Clock::start();
        let mut cpu = 0.0;
        let rendering = task.contestant.method.render(
            task.scene,
            task.camera,
            &settings,
            &mut |p: &Progress<'_>| {
                cpu += clock.lap();
                let (last, due) = (p.passes == self.samples, batches.len() as u32 + 1);
                let flow = report(p.fraction);
                let is_mark = p.passes.is_power_of_two() || last;
                let is_cut = p.passes == cut(due);
                // A long pass may go beyond several of them: then the image belongs to the last.
                let kept = snapshots.last().map_or(0.0, |shot: &Snapshot| shot.part);
                let part = SNAPSHOTS
                    .into_iter()
                    .rfind(|part| seed == 0 && *part > kept && p.fraction >= *part);
                if is_mark || is_cut || part.is_some() {
                    let image = p.image();
                    if is_mark {
                        let cost = Cost {
                            wall: p.wall.as_secs_f64(),
                            cpu,
                            rays: p.counters.rays() as f64,
                            scattered: p.counters.scattered as f64,
                        };
                        marks.push((p.passes, cost, image.clone()));
                    }
                    if is_cut {
                        let sums: Vec<f64> = self
                            .layout
                            .block_means(&image)
                            .iter()
                            .map(|m| m * f64::from(p.passes))
                            .collect();
                        let samples = f64::from(p.passes - passes_before);
                        let blocks =
                            sums.iter().zip(&sums_before).map(|(a, b)| (a - b) / samples).collect();
                        batches.push(Batch { samples, blocks });
                        (sums_before, passes_before) = (sums, p.passes);
                    }
                    if let Some(part) = part {
                        let errors = Errors::of(&image, task.reference);
                        snapshots.push(Snapshot {
                            part,
                            samples: p.passes,
                            wall: p.wall.as_secs_f64(),
                            image,
                            errors,
                        });
                    }
                }
                clock.lap();
                flow
            },
        )?;
        if rendering.samples_per_pixel < self.samples {
            return Ok(());
        }
        for (index, (samples, cost, image)) in marks.into_iter().enumerate() {
            self.mark(index, samples, cost, &image, task.reference);
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
        self.decisions.extend(rendering.decision.clone());
        if self.non_finite.is_none() && rendering.non_finite().count() > 0 {
            self.non_finite = Some(rendering.non_finite().clone());
        }
        Ok(())
    }

    fn mark(
        &mut self,
        index: usize,
        samples: u32,
        cost: Cost,
        image: &Image,
        reference: &Reference,
    ) {
        if self.marks.len() == index {
            let deviation = Image::from_fn(image.width(), image.height(), |_, _| Rgb::BLACK);
            self.marks.push(Mark {
                samples,
                cost: Vec::new(),
                errors: Vec::new(),
                deviation,
                squares: 0.0,
            });
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

    /// A look at single contributions.
    pub fn probe<S: Scene + ?Sized>(&self, task: &Task<'_, S>) -> Result<Probe, RenderError> {
        let budget = match task.plan.budget {
            Budget::Samples(samples) => Budget::Samples((samples / PROBE_PART).max(1)),
            Budget::Time(time) => Budget::Time((time / PROBE_PART).max(Duration::from_nanos(1))),
        };
        let settings = Settings { budget, seed: !self.settings.seed, ..self.settings };
        task.contestant.method.probe(task.scene, task.camera, &settings, task.reference.image())
    }

    /// Whether a run was finished.
    pub fn is_empty(&self) -> bool {
        self.finals.is_empty()
    }

    pub fn finish<S: Scene + ?Sized>(
        self,
        contestant: &Contestant<'_, S>,
        probe: Probe,
    ) -> Measured {
        let mean =
            mean_image(&self.finals).unwrap_or_else(|| Image::from_fn(0, 0, |_, _| Rgb::BLACK));
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
            decisions: self.decisions,
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
        let seconds =
            now.zip(self.0).map_or(0.0, |(now, before)| now.duration_since(before).as_secs_f64());
        self.0 = now;
        seconds
    }
}
