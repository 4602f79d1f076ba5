//! Studies in parts.

use glam::UVec2;
use pathspace::film::{Image, ImageFile};
use pathspace::gallery;
use pathspace::integrator::{
    Adaptive, Guiding, LightTracer, Metropolis, PathTracer, VertexConnectionMerging,
};
use pathspace::math::Rgb;
use pathspace::render::{Budget, Settings, Shard};
use pathspace::report::{
    Contestant, Plan, Reference, SceneInfo, Step, Study, study, study_of_shards, study_shard,
};
use std::ops::ControlFlow;
use std::path::PathBuf;

fn quiet(_: &Step<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn shards_of_a_study_make_the_study_of_one_machine() {
    let scene = gallery::build("cornell-box", UVec2::splat(16)).unwrap();
    let (path, light) = (PathTracer::default(), LightTracer::default());
    let (adaptive, vcm) = (Adaptive::default(), VertexConnectionMerging::default());
    let (chains, guided) = (Metropolis::over(path), Guiding::new(path));
    let contestants = [
        Contestant::new("path", &path, true),
        Contestant::new("light", &light, true),
        Contestant::new("adaptive", &adaptive, true),
        Contestant::new("vcm", &vcm, true),
        Contestant::new("metropolis", &chains, true),
        Contestant::new("guided", &guided, true),
    ];
    let (world, camera) = (&scene.world, &*scene.camera);
    let directory = tempfile::tempdir().unwrap();
    let white = directory.path().join("white.exr");
    ImageFile::from(Image::from_fn(16, 16, |_, _| Rgb::WHITE)).save(&white).unwrap();
    let reference = || Reference::load(&white).unwrap();
    let plan = |seed| Plan {
        budget: Budget::Samples(20),
        seeds: 4,
        settings: Settings { seed, ..Plan::default().settings },
        ..Plan::default()
    };
    let info = SceneInfo::default();
    let whole = study(world, camera, &info, &contestants, reference(), &plan(1), &mut quiet);
    let whole = whole.unwrap();

    let part = |index: u32| directory.path().join(format!("part {index}"));
    let render = |index, count, to: PathBuf, seed| {
        let (shard, plan) = (Shard::new(index, count).unwrap(), plan(seed));
        study_shard(world, camera, &contestants, &plan, shard, &to, &mut quiet)
            .map(|files| files.len())
    };
    let files: usize = (1..=3).map(|index| render(index, 3, part(index), 1).unwrap()).sum();
    assert_eq!(files, 24);
    let merge = |parts: &[u32]| {
        let parts: Vec<PathBuf> = parts.iter().map(|index| part(*index)).collect();
        let (plan, reference) = (plan(1), reference());
        study_of_shards(world, camera, &info, &contestants, reference, &plan, &parts, &mut quiet)
            .map_err(|error| error.to_string())
    };
    let text =
        |study: &Study| serde_json::to_string(&study.clone().without_clocks().report).unwrap();
    for order in [[1, 2, 3], [3, 1, 2]] {
        let merged = merge(&order).unwrap();
        assert_eq!(text(&merged), text(&whole));
        for (one, other) in merged.images.iter().zip(&whole.images) {
            assert_eq!(one.mean, other.mean);
            assert_eq!(one.snapshots.len(), other.snapshots.len());
        }
    }
    let missing = merge(&[1, 3]).unwrap_err();
    assert!(missing.contains("adaptive-0000.run") && missing.contains("shard 2/3"), "{missing}");
    render(2, 3, part(4), 1).unwrap();
    let twice = merge(&[1, 2, 3, 4]).unwrap_err();
    assert!(twice.contains("part 4") && twice.contains("part 2"), "{twice}");
    render(2, 3, part(5), 2).unwrap();
    let other = merge(&[1, 3, 5]).unwrap_err();
    assert!(other.contains("part 5") && other.contains("seed"), "{other}");
    let file = part(1).join("light-0001.run");
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let damaged = merge(&[1, 2, 3]).unwrap_err();
    assert!(damaged.contains("light-0001.run") && damaged.contains("damaged"), "{damaged}");
    let empty = render(25, 25, part(6), 1).unwrap_err().to_string();
    assert_eq!(empty, "shard 25/25 has no runs: there are 24 in all");
}
