//! Studies that go on until a target error is reached.

use super::{Synthetic, contestants, cornell_box, exactly, go_on};
use pathspace::glam::UVec2;
use pathspace::render::Budget;
use pathspace::report::{Plan, Report, ReportError, SceneInfo, Study, study};
use pathspace::sampler::Sampler;
use pathspace::scene::World;

/// relMSE = variance / N / 1.01 for a mean of 1.
fn until(target: f64, samples: u32, half_width: f64) -> Result<Study, ReportError> {
    let scene = cornell_box(32);
    let noise = Synthetic(move |s: &mut dyn Sampler| 1.0 + half_width * (2.0 * s.next_1d() - 1.0));
    let quiet =
        Synthetic(move |s: &mut dyn Sampler| 1.0 + 0.5 * half_width * (2.0 * s.next_1d() - 1.0));
    let all = contestants::<World>(&[("noise", &noise), ("quiet", &quiet)]);
    let plan =
        Plan { budget: Budget::Samples(samples), target, until_target: true, ..Plan::default() };
    let info = SceneInfo::default();
    study(
        &scene.world,
        &*scene.camera,
        &info,
        &all,
        exactly(1.0, UVec2::splat(32)),
        &plan,
        &mut go_on,
    )
}

fn reached(report: &Report, method: usize) -> u32 {
    report.methods[method].time_to_target.map_or(0, |t| t.reached)
}

#[test]
fn runs_are_as_long_as_the_target_takes() {
    // Variances 1/3 and 1/12: the target takes 33.0 and 8.25 samples, and runs are 1.25 times as
    // long. The error of 1024 pixels scatters by 3 %.
    let report = until(0.01, 8 * 1000, 1.0).unwrap().report;
    let samples: Vec<u32> = report.methods.iter().map(|m| m.samples_per_pixel).collect();
    assert!((37..=46).contains(&samples[0]) && (9..=12).contains(&samples[1]), "{samples:?}");
    for (index, method) in report.methods.iter().enumerate() {
        assert_eq!(reached(&report, index), 8);
        let time = method.time_to_target.unwrap();
        assert!(
            !time.extrapolated && time.seconds.value < method.last().unwrap().cost.wall,
            "{time:?}"
        );
        assert!(method.last().unwrap().relative_mse.high < 0.01 && !method.bias.flagged);
    }
    assert!(
        report.setup.until_target
            && report.setup.budget.contains("0.01")
            && report.setup.budget.contains("8000")
    );
    assert!(!report.verdicts().iter().any(|v| v.starts_with("Target")), "{:?}", report.verdicts());
}

#[test]
fn the_budget_is_the_limit_and_what_is_not_reached_is_said() {
    let study = until(0.01, 8 * 20, 1.0).unwrap();
    let report = &study.report;
    assert_eq!(report.methods[0].samples_per_pixel, 20);
    assert_eq!((reached(report, 0), reached(report, 1)), (0, 8));
    let time = report.methods[0].time_to_target.unwrap();
    // 33 samples are 1.65 times as many as there were.
    let factor = time.seconds.value / report.methods[0].last().unwrap().cost.wall;
    assert!(time.extrapolated && (factor / 1.65 - 1.0).abs() < 0.1, "{factor}");
    let verdict =
        "Target: relMSE 0.01 is reached by 0 of 8 runs of noise, with 20 samples per pixel.";
    assert!(report.verdicts().iter().any(|v| v == verdict), "{:?}", report.verdicts());
    assert!(study.page().contains(verdict));
    assert!(matches!(until(0.0, 80, 1.0), Err(ReportError::Target(_))));
}
