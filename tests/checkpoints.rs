//! Checkpoints, shards, and processes that are killed.

use glam::{DVec3, UVec2};
use pathspace::endpoint::PinholeCamera;
use pathspace::gallery::{self, GalleryScene};
use pathspace::integrator::{
    Adaptive, Bidirectional, Depth, Guiding, InstantRadiosity, LightTracer, Metropolis,
    Multiplexed, PathTracer, PhotonMapping, Regularization, UniformArea, VertexConnectionMerging,
};
use pathspace::render::{
    Budget, Checkpoint, MergeError, Merger, Progress, Render, Rendering, Settings, Shard,
};
use pathspace::sampler::SamplerKind;
use pathspace::scene::World;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::tempdir;

const SIDE: u32 = 12;
const PASSES: u32 = 7;

fn scene(name: &str) -> GalleryScene {
    gallery::build(name, UVec2::splat(SIDE)).unwrap()
}

fn settings() -> Settings {
    Settings {
        budget: Budget::Samples(PASSES),
        seed: 3,
        keeps_checkpoint: true,
        ..Settings::default()
    }
}

fn integrators(scene: &GalleryScene) -> Vec<Box<dyn Render<World>>> {
    let depth = Depth { max_bounces: scene.max_bounces, ..Depth::default() };
    let path_tracer = PathTracer { depth, ..PathTracer::default() };
    let bidirectional = Bidirectional { depth, ..Bidirectional::default() };
    let photon_mapping = PhotonMapping { depth, next_event: true, ..PhotonMapping::default() };
    vec![
        Box::new(path_tracer),
        Box::new(LightTracer { depth, ..LightTracer::default() }),
        Box::new(UniformArea { depth, ..UniformArea::default() }),
        Box::new(bidirectional),
        Box::new(Adaptive { depth, ..Adaptive::default() }),
        Box::new(photon_mapping),
        Box::new(InstantRadiosity { path_tracer, ..InstantRadiosity::default() }),
        Box::new(VertexConnectionMerging { bidirectional, ..Default::default() }),
        Box::new(Regularization::new(path_tracer)),
        Box::new(Guiding::new(path_tracer)),
    ]
}

/// Those whose passes depend on the ones before, so that they cannot be shared out.
fn learners(scene: &GalleryScene) -> Vec<Box<dyn Render<World>>> {
    let depth = Depth { max_bounces: scene.max_bounces, ..Depth::default() };
    let bidirectional = Bidirectional { depth, ..Bidirectional::default() };
    let over = Metropolis::over(Multiplexed { bidirectional });
    vec![
        Box::new(Metropolis { restart: 3, ..Metropolis::over(bidirectional) }),
        Box::new(Metropolis { restart: 4, ..over }),
    ]
}

/// The bytes of the file of a checkpoint.
fn bytes(checkpoint: &Checkpoint) -> Vec<u8> {
    let directory = tempdir().unwrap();
    let path = directory.path().join("bytes.npz");
    checkpoint.clone().without_clocks().save(&path).unwrap();
    fs::read(path).unwrap()
}

fn render(scene: &GalleryScene, integrator: &dyn Render<World>, settings: &Settings) -> Rendering {
    integrator.render(&scene.world, &*scene.camera, settings).unwrap()
}

/// Ends after so many passes, with a checkpoint that has been in a file.
fn stopped(
    scene: &GalleryScene,
    integrator: &dyn Render<World>,
    settings: &Settings,
    passes: u32,
) -> Checkpoint {
    let directory = tempdir().unwrap();
    let path = directory.path().join("stopped.npz");
    let mut stop = |progress: &Progress<'_>| {
        if progress.passes < passes {
            return ControlFlow::Continue(());
        }
        progress.checkpoint().save(&path).unwrap();
        ControlFlow::Break(())
    };
    let (world, camera) = (&scene.world, &*scene.camera);
    let rendering = integrator.render_with_progress(world, camera, settings, &mut stop).unwrap();
    assert!(rendering.stopped || passes == PASSES);
    let checkpoint = Checkpoint::load(path).unwrap();
    assert_eq!(bytes(&checkpoint), bytes(&rendering.checkpoint.unwrap()));
    checkpoint
}

fn resume(
    checkpoint: Checkpoint,
    scene: &GalleryScene,
    integrator: &dyn Render<World>,
    settings: &Settings,
) -> Result<Rendering, String> {
    let mut go_on = |_: &Progress<'_>| ControlFlow::Continue(());
    integrator
        .resume(checkpoint, &scene.world, &*scene.camera, settings, &mut go_on)
        .map_err(|error| error.to_string())
}

#[test]
fn what_is_resumed_is_the_same_to_the_bit_for_all_integrators() {
    for name in ["cornell-box", "lamp-room", "pool"] {
        let scene = scene(name);
        for integrator in integrators(&scene).into_iter().chain(learners(&scene)) {
            for sampler in [SamplerKind::Sobol, SamplerKind::Stratified] {
                let settings = Settings { sampler, ..settings() };
                let whole = render(&scene, &*integrator, &settings);
                for passes in [1, 4, PASSES] {
                    let from = stopped(&scene, &*integrator, &settings, passes);
                    let settings = Settings { threads: Some(passes as usize), ..settings };
                    let resumed = resume(from, &scene, &*integrator, &settings).unwrap();
                    let what = format!("{} of {name} after {passes}", integrator.name());
                    assert_eq!(resumed.image, whole.image, "{what}");
                    assert_eq!(resumed.counters, whole.counters, "{what}");
                    let [one, other] = [&resumed, &whole].map(|r| r.checkpoint.as_ref().unwrap());
                    assert_eq!(bytes(one), bytes(other), "{what}");
                }
            }
        }
    }
}

/// The checkpoints of the shards of a rendering.
fn shards(scene: &GalleryScene, integrator: &dyn Render<World>, count: u32) -> Vec<Checkpoint> {
    let shard = |index| {
        let shard = Shard::new(index, count).unwrap();
        render(scene, integrator, &Settings { shard, ..settings() }).checkpoint.unwrap()
    };
    (1..=count).map(shard).collect()
}

fn merge<'c>(shards: impl IntoIterator<Item = &'c Checkpoint>) -> Result<Checkpoint, MergeError> {
    let mut merger = Merger::default();
    for (number, shard) in shards.into_iter().enumerate() {
        merger.add(&format!("file {number}"), shard.clone())?;
    }
    merger.finish()
}

#[test]
fn shards_in_any_order_make_the_image_of_one_process() {
    for name in ["cornell-box", "pool"] {
        let scene = scene(name);
        for integrator in integrators(&scene) {
            let whole = render(&scene, &*integrator, &settings());
            let whole_bytes = bytes(whole.checkpoint.as_ref().unwrap());
            for (count, orders) in [
                (7, vec![[0, 1, 2, 3, 4, 5, 6], [6, 5, 4, 3, 2, 1, 0], [3, 0, 6, 1, 5, 2, 4]]),
                (2, vec![[0, 1, 0, 0, 0, 0, 0]]),
            ] {
                let shards = shards(&scene, &*integrator, count);
                for order in orders {
                    let order = &order[..count as usize];
                    let merged = merge(order.iter().map(|index| &shards[*index])).unwrap();
                    let what = format!("{} of {name}, {order:?}", integrator.name());
                    assert_eq!(merged.image(), whole.image, "{what}");
                    assert_eq!(merged.counters(), whole.counters, "{what}");
                    assert_eq!(bytes(&merged), whole_bytes, "{what}");
                }
            }
        }
    }
}

#[test]
fn shards_that_make_no_image_are_named() {
    let scene = scene("cornell-box");
    let integrator = PathTracer::default();
    let all = shards(&scene, &integrator, 7);
    let error = |shards: Vec<&Checkpoint>| merge(shards).unwrap_err().to_string();
    assert_eq!(error(vec![]), "there are no shards to merge");
    let most: Vec<&Checkpoint> =
        all.iter().filter(|s| ![2, 6].contains(&s.shard().index())).collect();
    assert_eq!(error(most.clone()), "missing shards 2/7, 6/7");
    assert_eq!(error(all.iter().skip(1).collect()), "missing shard 1/7");
    let twice = most.iter().copied().chain([&all[4]]).collect();
    assert_eq!(error(twice), "file 5: shard 5/7 is there already, as file 3");
    let other = shards(&scene, &integrator, 5);
    let mixed = error(vec![&all[0], &other[1]]);
    assert!(mixed.starts_with("file 1") && mixed.contains("2/5"), "{mixed}");
    let seed = Settings { seed: 4, shard: Shard::new(2, 7).unwrap(), ..settings() };
    let seed = render(&scene, &integrator, &seed).checkpoint.unwrap();
    let mixed = error(vec![&all[0], &seed]);
    assert!(mixed.starts_with("file 1") && mixed.contains("seed is 4, here it is 3"), "{mixed}");
    let half = Settings { budget: Budget::Samples(14), shard: all[0].shard(), ..settings() };
    let half = stopped(&scene, &integrator, &half, 1);
    assert_eq!(
        error(vec![&half]),
        "file 0: shard 1/7 is unfinished, with 1 of 2 passes: resume it"
    );
    let mut noted = all[1].clone();
    noted.metadata.insert("exposure".to_owned(), "2".to_owned());
    let mixed = error(vec![&all[0], &noted]);
    assert!(mixed.contains("exposure is 2, here it is none"), "{mixed}");
    // A shard that failed is drawn again alone.
    let again = shards(&scene, &integrator, 7).swap_remove(3);
    let mended = all.iter().enumerate().map(|(i, shard)| if i == 3 { &again } else { shard });
    assert_eq!(bytes(&merge(mended).unwrap()), bytes(&merge(&all).unwrap()));
}

#[test]
fn what_differs_is_refused_by_name() {
    let cornell = scene("cornell-box");
    let integrator = PathTracer::default();
    let from = stopped(&cornell, &integrator, &settings(), 3);
    let refused = |scene: &GalleryScene, integrator: &dyn Render<World>, settings: Settings| {
        resume(from.clone(), scene, integrator, &settings).map(|_| ()).unwrap_err()
    };
    let refused_with = |settings| refused(&cornell, &integrator, settings);
    for (name, error) in [
        ("seed is 3, here it is 4", refused_with(Settings { seed: 4, ..settings() })),
        ("sampler", refused_with(Settings { sampler: SamplerKind::Independent, ..settings() })),
        ("samples per pixel", refused_with(Settings { budget: Budget::Samples(8), ..settings() })),
        (
            "samples per pixel",
            refused_with(Settings { budget: Budget::Time(Duration::from_secs(1)), ..settings() }),
        ),
        ("target error", refused_with(Settings { target_error: Some(0.1), ..settings() })),
        ("filter", refused_with(Settings { filter: pathspace::film::Filter::Tent, ..settings() })),
        ("observation", refused_with(Settings { observes_lights: false, ..settings() })),
        ("shard", refused_with(Settings { shard: Shard::new(1, 2).unwrap(), ..settings() })),
        ("integrator is path-tracing", refused(&cornell, &LightTracer::default(), settings())),
        (
            "settings of the integrator",
            refused(&cornell, &PathTracer { depth: Depth::up_to(3), ..integrator }, settings()),
        ),
    ] {
        assert!(error.contains(name), "{name}: {error}");
    }
    // The same camera before another scene, and the other way round.
    let other = GalleryScene { world: scene("lamp-room").world, ..scene("cornell-box") };
    let error = refused(&other, &integrator, settings());
    assert!(error.contains("its scene is"), "{error}");
    let moved = PinholeCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 40.0, UVec2::splat(SIDE));
    let moved = GalleryScene { camera: Box::new(moved.unwrap()), ..scene("cornell-box") };
    let error = refused(&moved, &integrator, settings());
    assert!(error.contains("its camera is"), "{error}");
    let wide = gallery::build("cornell-box", UVec2::new(SIDE, SIDE + 1)).unwrap();
    let error = refused(&wide, &integrator, settings());
    assert!(error.contains("camera") || error.contains("film"), "{error}");
    // Without a difference it goes on.
    resume(from.clone(), &cornell, &integrator, &settings()).unwrap();
}

/// Files that are cut off, or have wrong bytes, are refused and never believed.
#[test]
fn damaged_files_are_refused() {
    let scene = scene("cornell-box");
    let integrator = VertexConnectionMerging::default();
    let whole =
        stopped(&scene, &integrator, &Settings { target_error: Some(1e-9), ..settings() }, 5);
    let directory = tempdir().unwrap();
    let path = directory.path().join("damaged.npz");
    let sound = bytes(&whole);
    let same = |damaged: &[u8]| {
        fs::write(&path, damaged).unwrap();
        match Checkpoint::load(&path) {
            Ok(read) => bytes(&read) == sound,
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("damaged.npz") && text.len() < 500, "{text}");
                false
            }
        }
    };
    assert!(same(&sound));
    for length in (0..sound.len()).step_by(997).chain([sound.len() - 1]) {
        assert!(!same(&sound[..length]), "{length} of {} bytes", sound.len());
    }
    let mut refused = 0;
    for position in (0..sound.len()).step_by(61) {
        let mut damaged = sound.clone();
        damaged[position] ^= 1 << (position % 8);
        // A bit that means nothing, such as one of a time of change, may differ.
        fs::write(&path, &damaged).unwrap();
        match Checkpoint::load(&path) {
            Ok(read) => assert_eq!(bytes(&read), sound, "byte {position}"),
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 0);
    let error = Checkpoint::load(directory.path().join("none.npz")).unwrap_err().to_string();
    assert!(error.contains("none.npz"), "{error}");
}

/// The environment variable that tells a child of the next test where to write.
const CHILD: &str = "PATHSPACE_TEST_CHECKPOINT";

/// The rendering of the next test: it writes a checkpoint after each pass, and goes on from one.
fn render_to(path: &Path, scene: &GalleryScene, settings: &Settings) -> Rendering {
    let integrator = Bidirectional::default();
    let mut save = |progress: &Progress<'_>| {
        progress.checkpoint().save(path).unwrap();
        ControlFlow::Continue(())
    };
    let (world, camera) = (&scene.world, &*scene.camera);
    match path.exists() {
        true => {
            let from = Checkpoint::load(path).unwrap();
            integrator.resume(from, world, camera, settings, &mut save).unwrap()
        }
        false => integrator.render_with_progress(world, camera, settings, &mut save).unwrap(),
    }
}

/// At 50 moments, during passes and while files are written.
#[test]
fn a_killed_process_leaves_a_whole_checkpoint() {
    let scene = gallery::build("cornell-box", UVec2::splat(64)).unwrap();
    let settings = Settings { budget: Budget::Samples(200), ..settings() };
    if let Some(path) = std::env::var_os(CHILD) {
        render_to(Path::new(&path), &scene, &settings);
        return;
    }
    let directory = tempdir().unwrap();
    let path = directory.path().join("killed.npz");
    let child = || {
        Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "a_killed_process_leaves_a_whole_checkpoint"])
            .env(CHILD, &path)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    };
    let (mut wholes, mut passes) = (0, 0);
    for moment in 0..50u64 {
        let mut child = child();
        // Moments that come at every stage of a pass, sooner or later.
        std::thread::sleep(Duration::from_micros(20_000 + moment * 7_919 % 60_000));
        child.kill().unwrap();
        child.wait().unwrap();
        if path.exists() {
            let checkpoint = Checkpoint::load(&path).unwrap();
            assert!(checkpoint.passes().end >= passes, "moment {moment}");
            passes = checkpoint.passes().end;
            wholes += 1;
        }
    }
    assert!(wholes > 25, "only {wholes} of 50 were killed after the first pass");
    let killed = render_to(&path, &scene, &settings);
    fs::remove_file(&path).unwrap();
    let whole = render(&scene, &Bidirectional::default(), &settings);
    assert_eq!(killed.image, whole.image);
    assert_eq!(bytes(&killed.checkpoint.unwrap()), bytes(&whole.checkpoint.unwrap()));
}
