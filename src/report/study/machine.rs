//! The set-up of a study, and the machine that it ran on.

use super::plan::Plan;
use crate::render::Budget;
use crate::report::result::{Machine, Setup};

/// The setup of a study, with the machine's load at the time of the call.
pub(super) fn setup(plan: &Plan) -> Setup {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let model = read("/proc/cpuinfo").and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    Setup {
        command: plan.command.clone(),
        seeds: plan.seeds,
        seed: plan.settings.seed,
        budget: match (plan.budget, plan.until_target) {
            (Budget::Samples(samples), false) => format!("{samples} samples per pixel"),
            (Budget::Time(time), false) => format!("{time:?}"),
            (Budget::Samples(samples), true) => {
                format!("what relMSE {} takes, at most {samples} samples per pixel", plan.target)
            }
            (Budget::Time(time), true) => {
                format!("what relMSE {} takes, at most {time:?}", plan.target)
            }
        },
        filter: format!("{:?}", plan.settings.filter),
        sampler: format!("{:?}", plan.settings.sampler),
        threads: plan.settings.threads,
        target: plan.target,
        until_target: plan.until_target,
        baseline: None,
        machine: Some(Machine {
            processor: model.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
            load: read("/proc/loadavg")
                .map(|text| text.split_whitespace().take(3).collect::<Vec<_>>().join(" ")),
        }),
        debug_build: cfg!(debug_assertions),
    }
}
