//! The files that a study writes, keeps and refuses.

use super::{contestants, cornell_box, exactly, go_on, readable};
use pathspace::film::Image;
use pathspace::glam::UVec2;
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer};
use pathspace::math::Rgb;
use pathspace::render::Budget;
use pathspace::report::{
    Plan, Reference, ReferencePlan, Report, ReportError, SceneInfo, Step, Study, cached_reference,
    study,
};
use pathspace::scene::World;
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn small_study() -> Study {
    let scene = cornell_box(24);
    let (paths, light, both) =
        (PathTracer::up_to(3), LightTracer::up_to(3), Bidirectional::up_to(3));
    let all = contestants::<World>(&[
        ("path-tracing", &paths),
        ("light-tracing", &light),
        ("bidirectional", &both),
    ]);
    let reference =
        ReferencePlan { budget: Budget::Samples(64), runs: 4, settings: Plan::default().settings };
    let reference =
        Reference::render(&scene.world, &*scene.camera, [&all[0], &all[2]], &reference, &mut go_on)
            .unwrap();
    let plan = Plan {
        budget: Budget::Samples(4 * 11),
        seeds: 4,
        pyramid: Some(both),
        command: Some("make <this> \"again\"".to_owned()),
        ..Plan::default()
    };
    let info =
        SceneInfo { name: "cornell-box".to_owned(), max_bounces: Some(3), ..SceneInfo::default() };
    study(&scene.world, &*scene.camera, &info, &all, reference, &plan, &mut go_on).unwrap()
}

#[test]
fn the_same_seeds_give_the_same_errors_to_the_bit() {
    let [a, b] = [small_study(), small_study()];
    assert_eq!(a.reference, b.reference);
    for (a, b) in a.report.methods.iter().zip(&b.report.methods) {
        let points: Vec<u32> = a.checkpoints.iter().map(|c| c.samples).collect();
        assert_eq!(points, [1, 2, 4, 8, 11]);
        for (a, b) in a.checkpoints.iter().zip(&b.checkpoints) {
            assert_eq!(
                (&a.runs, a.cost.rays, a.mse, a.variance),
                (&b.runs, b.cost.rays, b.mse, b.variance)
            );
        }
        assert_eq!(
            (a.bias, a.tail, a.variance_per_sample),
            (b.bias, b.tail, b.variance_per_sample)
        );
    }
    assert_eq!(
        (a.report.pairs, a.report.pyramid, a.images.len()),
        (b.report.pairs, b.report.pyramid, 3)
    );
}

#[test]
fn the_pyramid_adds_up_to_the_image() {
    let study = small_study();
    let pyramid = study.pyramid.unwrap();
    assert_eq!(pyramid.layers.len(), 2 + 3 + 4 + 5);
    let energy: f64 = pyramid.layers.iter().map(|l| l.share.energy).sum();
    assert!((energy - 1.0).abs() < 1e-12, "{energy}");
    let sum = pyramid.layers.iter().map(|l| l.weighted.mean().luminance()).sum::<f64>();
    let expected = study.report.reference.mean;
    assert!((sum / expected - 1.0).abs() < 0.1, "{sum} and {expected}");
    for share in pyramid.layers.iter().map(|l| l.share) {
        assert!((-0.01..1.0).contains(&share.cost) && share.efficiency_without > 0.0, "{share:?}");
    }
}

#[test]
fn reports_are_written_and_read() {
    let study = small_study();
    let json = study.report.to_json();
    let report: Report = serde_json::from_str(&json).unwrap();
    assert_eq!(report.to_json(), json);
    let csv = study.report.to_csv();
    assert_eq!(csv.lines().count(), 1 + 3 * 5 * 4);
    assert!(csv.lines().all(|line| line.split(',').count() == 14));
    let page = study.page();
    let text = readable(&page);
    assert!(text.contains("make &lt;this&gt; &quot;again&quot;") && !text.contains("NaN"));
    // Self-contained: the only addresses are names of formats.
    assert!(!text.replace("http://www.w3.org/2000/svg", "").contains("http"));
    assert!(!page[page.find("<script>").unwrap()..].contains("http"));
    let directory = std::env::temp_dir().join(format!("pathspace-report-{}", std::process::id()));
    study.save(&directory).unwrap();
    for name in [
        "index.html",
        "report.json",
        "report.csv",
        "time.svg",
        "samples.svg",
        "rays.svg",
        "smape.svg",
    ] {
        assert!(directory.join(name).metadata().unwrap().len() > 300, "{name}");
    }
    // These have nothing to say here.
    for name in ["left-out.csv", "decisions.csv"] {
        let text = std::fs::read_to_string(directory.join(name)).unwrap();
        assert!(text.starts_with("integrator,") && text.lines().count() == 1, "{name}: {text}");
    }
    std::fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn references_are_cached_and_changes_are_noticed() {
    let directory =
        std::env::temp_dir().join(format!("pathspace-references-{}", std::process::id()));
    let scene = cornell_box(16);
    let render = |depth: u32| {
        let (paths, both) = (PathTracer::up_to(depth), Bidirectional::up_to(depth));
        let all = contestants::<World>(&[("bidirectional", &both), ("path-tracing", &paths)]);
        let plan = ReferencePlan {
            budget: Budget::Samples(8),
            runs: 2,
            settings: Plan::default().settings,
        };
        let mut passes = 0;
        let mut count = |_: &Step<'_>| {
            passes += 1;
            ControlFlow::Continue(())
        };
        let halves = [&all[0], &all[1]];
        let reference = cached_reference(
            &directory,
            "cornell box",
            &scene.world,
            &*scene.camera,
            halves,
            &plan,
            &mut count,
        )
        .unwrap();
        (reference, passes)
    };
    let (first, passes) = render(2);
    assert_eq!(passes, 8);
    assert_eq!(render(2), (first.clone(), 0));
    let (other, passes) = render(3);
    assert!(passes == 8 && other != first);
    std::fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn a_study_that_is_stopped_still_reports() {
    let scene = cornell_box(16);
    let paths = PathTracer::up_to(2);
    let all = contestants::<World>(&[("path-tracing", &paths)]);
    let reference = exactly(0.2, UVec2::splat(16));
    let plan = Plan { budget: Budget::Samples(64), ..Plan::default() };
    for passes in [0, 3, 20] {
        let mut left = passes;
        let mut stop = |_: &Step<'_>| {
            left -= 1;
            if left < 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let info = SceneInfo::default();
        let study =
            study(&scene.world, &*scene.camera, &info, &all, reference.clone(), &plan, &mut stop)
                .unwrap();
        assert!(study.report.stopped);
        assert_eq!(study.report.methods.first().map(|m| m.runs), (passes == 20).then_some(2));
        assert!(study.page().contains("Incomplete: "));
        assert!(!study.report.to_json().is_empty());
    }
}

/// The study so far is the one that a stop after the same run makes.
#[test]
fn a_study_so_far_is_that_of_a_stop() {
    let scene = cornell_box(16);
    let (paths, both) = (PathTracer::up_to(2), Bidirectional::up_to(2));
    let all = contestants::<World>(&[("path-tracing", &paths), ("bidirectional", &both)]);
    let reference = exactly(0.2, UVec2::splat(16));
    let plan = Plan { budget: Budget::Samples(12), seeds: 3, ..Plan::default() };
    let measure = |progress: &mut dyn FnMut(&Step<'_>) -> ControlFlow<()>| {
        let (world, info) = (&scene.world, SceneInfo::default());
        study(world, &*scene.camera, &info, &all, reference.clone(), &plan, progress).unwrap()
    };
    let mut so_far = Vec::new();
    let whole = measure(&mut |step| {
        so_far.extend(step.study());
        ControlFlow::Continue(())
    });
    assert_eq!(so_far.len(), 6);
    assert_eq!(so_far[5].images, whole.images);
    for (i, earlier) in so_far.into_iter().enumerate() {
        let runs: u32 = earlier.report.methods.iter().map(|m| m.runs).sum();
        assert!(runs == i as u32 + 1 && earlier.page().contains("Incomplete: "));
        let mut left = runs;
        let stopped = measure(&mut |step| {
            left -= u32::from(step.study().is_some());
            if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let [earlier, stopped] = [earlier, stopped].map(Study::without_clocks);
        assert_eq!(earlier.report.to_json(), stopped.report.to_json());
    }
}

#[test]
fn bad_plans_are_refused_by_name() {
    let scene = cornell_box(16);
    let paths = PathTracer::up_to(2);
    let run = |names: [&str; 2], size: u32, seeds: u32| {
        let all = contestants::<World>(&[(names[0], &paths), (names[1], &paths)]);
        let reference = exactly(1.0, UVec2::new(size, 16));
        let plan = Plan { seeds, budget: Budget::Samples(4), ..Plan::default() };
        study(
            &scene.world,
            &*scene.camera,
            &SceneInfo::default(),
            &all,
            reference,
            &plan,
            &mut go_on,
        )
        .map(|_| ())
    };
    assert!(matches!(run(["a", "b"], 16, 1), Err(ReportError::TooFewSeeds(1))));
    assert!(run(["a", "a"], 16, 2).unwrap_err().to_string().contains("\"a\""));
    assert!(matches!(run(["a", "b"], 15, 2), Err(ReportError::ReferenceSize([15, 16], [16, 16]))));
    assert!(run(["a", "b"], 16, 2).is_ok());
    assert!(Reference::exact(Image::from_fn(2, 2, |_, _| Rgb::splat(PI / 0.0))).is_err());
    assert!(Reference::exact(Image::from_fn(0, 2, |_, _| Rgb::WHITE)).is_err());
    assert!(Reference::load("no-such-file.exr").unwrap_err().to_string().contains("no-such-file"));
}
