//! Studies in parts: the runs of all integrators with all seeds, shared out between machines.

use super::compare::{check, measure, naming};
use super::method::Contestant;
use super::plan::{Plan, Step};
use super::run_file::{Drawn, RunFile, RunFiles};
use super::runs::{Runs, Task};
use crate::endpoint::Camera;
use crate::path::TechniqueSet;
use crate::render::{Budget, Shard};
use crate::report::error::{ReportError, file_error};
use crate::report::result::{SceneInfo, Study};
use crate::report::stats::Reference;
use crate::scene::Scene;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Renders the runs of one part of a study into files, for [`study_of_shards`]; returns the files. The
/// runs are numbered integrator by integrator, and a part has consecutive ones. No reference is
/// needed. If `progress` stops it, the runs that were finished are in files.
///
/// # Errors
/// If the budget is not one of samples, there is a target error to be reached or there are fewer runs
/// than shards; if a rendering fails or a file cannot be written; and those of
/// [`study`](super::study).
pub fn study_shard<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    contestants: &[Contestant<'_, S>],
    plan: &Plan,
    shard: Shard,
    directory: &Path,
    progress: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
) -> Result<Vec<PathBuf>, ReportError> {
    check(contestants, plan)?;
    check_budget(plan, shard)?;
    let jobs = contestants.len() as u32 * plan.seeds;
    let part = shard.part_of(jobs);
    if jobs < shard.count() {
        return Err(ReportError::EmptyShard { shard, runs: jobs });
    }
    std::fs::create_dir_all(directory).map_err(file_error(directory))?;
    let (mut files, mut stopped) = (Vec::new(), false);
    for (stream, contestant) in (0..).zip(contestants) {
        let all = stream * plan.seeds..(stream + 1) * plan.seeds;
        let own = part.start.max(all.start)..part.end.min(all.end);
        if own.is_empty() {
            continue;
        }
        let task = Task { scene, camera, contestant, plan };
        let mut report = |job: u32, fraction: f64| {
            let done = f64::from(job - part.start) + fraction;
            let fraction = done / part.len() as f64;
            let flow = progress(&Step::new(&contestant.name, fraction, None));
            stopped |= flow.is_break();
            flow
        };
        let mut warm_up = |_| report(own.start, 0.0);
        let runs = Runs::prepare(&task, u64::from(stream), None, true, &mut warm_up)
            .map_err(naming(contestant))?;
        if runs.techniques == TechniqueSet::NONE {
            continue;
        }
        for job in own {
            let run = job - all.start;
            let drawn = runs
                .draw(&task, run, true, &mut |fraction| report(job, fraction))
                .map_err(naming(contestant))?;
            let Some(drawn) = drawn else { return Ok(files) };
            files.push(
                RunFile { name: contestant.name.clone(), run, shard, drawn }.save(directory)?,
            );
        }
        if stopped {
            break;
        }
    }
    Ok(files)
}

/// The study whose runs [`study_shard`] has rendered into files in these directories: that of one
/// machine but for times. What comes before and after the runs, such as the look at single
/// contributions, is made here.
///
/// # Errors
/// If a run is missing, there twice, damaged, or of another study; and those of [`study_shard`] and of
/// [`study`](super::study).
#[allow(clippy::too_many_arguments)]
pub fn study_of_shards<S: Scene + ?Sized>(
    scene: &S,
    camera: &dyn Camera,
    info: &SceneInfo,
    contestants: &[Contestant<'_, S>],
    reference: Reference,
    plan: &Plan,
    directories: &[PathBuf],
    progress: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>,
) -> Result<Study, ReportError> {
    check_budget(plan, Shard::WHOLE)?;
    let files = RunFiles::find(directories)?;
    measure((scene, camera, info), contestants, reference, plan, Some(&files), progress)
}

fn check_budget(plan: &Plan, shard: Shard) -> Result<(), ReportError> {
    match plan.budget {
        Budget::Samples(_) if !plan.until_target => Ok(()),
        _ => Err(ReportError::ShardOfTime(shard)),
    }
}

impl RunFiles {
    /// The run of an integrator, given by its number among so many, with a seed.
    pub fn drawn<S: Scene + ?Sized>(
        &self,
        task: &Task<'_, S>,
        runs: &Runs,
        (stream, contestants): (u32, u32),
        run: u32,
    ) -> Result<Drawn, ReportError> {
        let (name, seeds) = (&task.contestant.name, task.plan.seeds);
        let jobs = [stream * seeds + run, contestants * seeds];
        let (path, RunFile { drawn, .. }) = self.load(name, run, jobs)?;
        match drawn.difference(runs.identity.as_ref(), runs.seed(run), runs.measured.samples) {
            Some(reason) => Err(ReportError::Run { path, reason }),
            None => Ok(drawn),
        }
    }
}
