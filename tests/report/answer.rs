//! Who wins, by how much, and how sure that is; and budgets of time that are used.

use super::{Synthetic, contestants, cornell_box, exactly, go_on};
use pathspace::film::ImageFile;
use pathspace::glam::UVec2;
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer};
use pathspace::render::Budget;
use pathspace::report::{Contestant, Method, Plan, Price, SceneInfo, Study, study};
use pathspace::sampler::Sampler;
use pathspace::scene::World;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Uniform numbers around 1, whose variance is a third of the squared half width.
fn around_one(half_width: f64) -> impl Fn(&mut dyn Sampler) -> f64 + Sync {
    move |s| 1.0 + half_width * (2.0 * s.next_1d() - 1.0)
}

fn study_of(methods: &[(&str, &dyn Method<World>)], budget: Budget, seeds: u32) -> Study {
    let all = contestants(methods);
    of(&all, &Plan { budget, seeds, ..Plan::default() })
}

fn of(all: &[Contestant<'_, World>], plan: &Plan) -> Study {
    let scene = cornell_box(32);
    let reference = exactly(1.0, UVec2::splat(32));
    study(&scene.world, &*scene.camera, &SceneInfo::default(), all, reference, plan, &mut go_on)
        .unwrap()
}

#[test]
fn the_best_is_named_with_how_far_behind_the_others_are() {
    // Per ray, the variances are 1/3, 1/12 and 1.002² / 12.
    let (noise, quiet) = (Synthetic(around_one(1.0)), Synthetic(around_one(0.5)));
    let level = Synthetic(around_one(0.501));
    let methods: [(&str, &dyn Method<World>); 3] =
        [("noise", &noise), ("quiet", &quiet), ("level", &level)];
    let report = study_of(&methods[..2], Budget::Samples(8 * 16), 8).report;
    let [time, rays] = &report.rankings[..] else { panic!("{:?}", report.rankings) };
    assert_eq!((time.price, rays.price), (Price::Time, Price::Rays));
    assert_eq!((rays.best.as_str(), rays.others[0].name.as_str()), ("quiet", "noise"));
    // 1024 pixels of 3 equal channels and 8 runs: the ratio has a standard error of 2.2 %.
    let ratio = rays.others[0].ratio;
    assert!((ratio.value / 4.0 - 1.0).abs() < 4.0 * 0.022 && ratio.low < ratio.value, "{ratio:?}");
    assert!(rays.confidence() > 0.9999);

    let report = study_of(&methods, Budget::Samples(8 * 16), 8).without_clocks().report;
    assert!(report.rankings.len() == 1 && !report.has_clocks());
    let answers = report.answers();
    assert_eq!(answers.len(), 3, "{answers:#?}");
    assert!(answers[0].starts_with("No winner is certain: "), "{answers:#?}");
    assert!(answers[1].ends_with("a difference that these runs cannot tell from none."));
    assert!(answers[2].starts_with("noise takes ") && answers[2].contains(" times the rays of "));
}

#[test]
fn who_is_not_ranked_is_told_why() {
    let quiet = Synthetic(around_one(0.5));
    // One in 500 samples has all.
    let rare = Synthetic(|s: &mut dyn Sampler| if s.next_1d() < 1e-5 { 1e5 } else { 0.0 });
    let mut all = contestants::<World>(&[("quiet", &quiet), ("blind", &quiet), ("rare", &rare)]);
    all[1].complete = false;
    let report = of(&all, &Plan { budget: Budget::Samples(32), ..Plan::default() }).report;
    assert_eq!(
        report.answers(),
        [
            "quiet is the only integrator that can be ranked.",
            "blind is not ranked: it cannot draw every path of this scene.",
            "rare is not ranked: it has met too little to tell its error."
        ]
    );
    assert!(of(&all, &Plan::default()).page().contains("<strong>quiet is the only"));
}

/// Whatever the machine does before and on the way: here the first samples take ten times as long.
#[test]
fn a_budget_of_time_is_used_by_all() {
    let drawn = AtomicU64::new(0);
    let busy = |microseconds: u64| {
        let start = Instant::now();
        while start.elapsed() < Duration::from_micros(microseconds) {}
    };
    let slow_at_first = Synthetic(|s: &mut dyn Sampler| {
        busy(if drawn.fetch_add(1, Ordering::Relaxed) < 5000 { 30 } else { 3 });
        s.next_1d()
    });
    let steady = Synthetic(|s: &mut dyn Sampler| {
        busy(10);
        s.next_1d()
    });
    let methods: [(&str, &dyn Method<World>); 2] = [("slow", &slow_at_first), ("steady", &steady)];
    let budget = Duration::from_millis(800);
    let report = study_of(&methods, Budget::Time(budget), 4).report;
    for method in &report.methods {
        let (used, runs) = (method.total.wall, f64::from(method.runs));
        // To half a run, and the last one may take a little longer than the mean of the others.
        let off = (used - budget.as_secs_f64()).abs();
        assert!(off <= 0.75 * used / runs, "{} used {used} s in {runs} runs", method.name);
        assert!(method.checkpoints.iter().all(|c| c.runs.len() == method.runs as usize));
    }
}

/// The bytes of all files in a directory.
fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap());
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    entries.map(|entry| (name(&entry.path()), std::fs::read(entry.path()).unwrap())).collect()
}

#[test]
fn without_clocks_one_seed_writes_the_same_bytes() {
    let directory = std::env::temp_dir().join(format!("pathspace-clocks-{}", std::process::id()));
    let (paths, light, both) =
        (PathTracer::up_to(3), LightTracer::up_to(3), Bidirectional::up_to(3));
    let mut all = contestants::<World>(&[("paths", &paths), ("light/2", &light), ("both", &both)]);
    all[2].pyramid = true;
    let plan = |threads| {
        let mut plan = Plan { budget: Budget::Samples(16), seeds: 4, ..Plan::default() };
        plan.settings.threads = Some(threads);
        plan
    };
    let write = |name: &str, threads| {
        let mut study = of(&all, &plan(threads)).without_clocks();
        study.report.setup.threads = None;
        let directory = directory.join(name);
        study.save(&directory).unwrap();
        (files(&directory), study)
    };
    let ((first, study), (second, _)) = (write("first", 1), write("second", 2));
    assert_eq!(first.keys().collect::<Vec<_>>(), second.keys().collect::<Vec<_>>());
    for (name, bytes) in &first {
        assert!(*bytes == second[name], "{name}");
    }
    for (name, mean) in [("paths", 0), ("light-2", 1), ("both", 2)] {
        let file = ImageFile::load(directory.join(format!("first/{name}.exr"))).unwrap();
        let (found, expected) = (file.image.pixels()[77], study.images[mean].mean.pixels()[77]);
        assert!((0..3).all(|c| (found[c] - expected[c]).abs() <= 1e-7 * expected[c]), "{name}");
    }
    let text = |name: &str| String::from_utf8(first[name].clone()).unwrap();
    assert!(text("index.html").contains("href=\"light-2.exr\""));
    assert!(!first.contains_key("time.svg") && !text("rays.svg").contains("wall"));
    assert!(text("report.json").contains("\"wall\": null"));
    // Wall and processor seconds are empty.
    assert!(text("report.csv").lines().nth(1).unwrap().starts_with("paths,0,1,,,"));
    std::fs::remove_dir_all(&directory).unwrap();
}
