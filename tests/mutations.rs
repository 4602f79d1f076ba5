//! Files of every format with random damage: an error or a scene, soon, in little memory, and never
//! a panic; some of what loads is rendered.
//!
//! The number of files and the seed are fixed. `PATHSPACE_FUZZ_FILES=100000 cargo test --release
//! -p pathspace-tests --test mutations -- --ignored --nocapture` tries as many of each format, of the
//! one that `PATHSPACE_FUZZ_FORMAT` names if it is set, with seeds from `PATHSPACE_FUZZ_SEED` on; a
//! failure names the seed and leaves the file behind.

#[path = "mutations/damage.rs"]
mod damage;
#[path = "mutations/formats.rs"]
mod formats;

use damage::damaged;
use formats::{Format, formats};
use glam::UVec2;
use pathspace::import::{Import, Limits, Options, gltf, mitsuba, obj, pbrt};
use pathspace::integrator::{Depth, PathTracer};
use pathspace::render::{Budget, Render, Settings};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Files of each format in the test that always runs.
const FILES: u64 = 800;
/// One of so many scenes is rendered.
const RENDERED: u64 = 8;
/// The longest that reading a file may take.
const LONGEST: Duration = Duration::from_secs(2);
/// The most memory that the process may take.
const MOST_MEMORY: u64 = 600 << 20;
/// The film of scenes that are rendered has at most so many pixels.
const MOST_PIXELS: u32 = 256;

/// Limits under which a file cannot take long; `Options` at their default admit minutes.
fn options() -> Options {
    let mut limits = Limits::default();
    (limits.bytes, limits.elements, limits.triangles, limits.pixels) =
        (1 << 20, 10_000, 100_000, 1 << 18);
    Options { limits, ..Options::default() }
}

fn load(scene: &Path) -> Result<Import, pathspace::import::Error> {
    let size = UVec2::splat(4);
    match scene.extension().and_then(|extension| extension.to_str()) {
        Some("xml") => mitsuba::load(scene, &options(), [("res".to_owned(), "4".to_owned())]),
        Some("obj") => obj::load(scene, size, &options()),
        Some("pbrt") => pbrt::load(scene, &options()),
        _ => gltf::load(scene, size, &options()),
    }
}

/// Renders a scene with a few samples.
fn render(import: &Import, seed: u64) {
    for view in &import.views {
        let film = view.camera.film();
        if film.resolution.x.saturating_mul(film.resolution.y) > MOST_PIXELS {
            continue;
        }
        let tracer = PathTracer { depth: Depth::up_to(4), ..PathTracer::default() };
        let settings = Settings {
            budget: Budget::Samples(1),
            seed,
            threads: Some(1),
            filter: view.filter,
            ..Settings::default()
        };
        let rendering =
            tracer.render(&import.world, &*view.camera, &settings).expect("valid settings");
        assert_eq!(rendering.counters.non_finite, 0, "{:?}", rendering.non_finite());
    }
}

/// Reads `count` damaged files of a format, and tells how many of them load.
fn fuzz(format: &Format, count: u64, first_seed: u64) -> u64 {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutations").join(format.name);
    let write = |name: &str, bytes: &[u8]| -> PathBuf {
        let path = directory.join(name);
        std::fs::create_dir_all(path.parent().expect("below")).expect("writable");
        std::fs::write(&path, bytes).expect("writable");
        path
    };
    format.others.iter().for_each(|(name, bytes)| drop(write(name, bytes)));
    let scene = directory.join(format.scene);
    let watch = Watch::over(format.name);
    let mut loaded = 0;
    for seed in first_seed..first_seed + count {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let original = &format.originals[(seed % format.originals.len() as u64) as usize];
        write(format.target, &damaged(original, format.is_text, &mut random));
        watch.begin(seed);
        let start = processor_time();
        let result = catch_unwind(|| {
            let import = load(&scene);
            let spent = processor_time() - start;
            if let Ok(import) = import.as_ref()
                && seed.is_multiple_of(RENDERED)
            {
                render(import, seed);
            }
            (import.map(drop).map_err(|error| error.to_string()), spent)
        });
        let place = || format!("seed {seed} of {}: {}", format.name, directory.display());
        let (result, spent) = result.unwrap_or_else(|_| panic!("a panic with {}", place()));
        assert!(spent < LONGEST, "{spent:?} with {}", place());
        let memory = most_memory();
        assert!(memory < MOST_MEMORY, "{memory} bytes with {}", place());
        match result {
            Ok(()) => loaded += 1,
            Err(message) => assert!(!message.is_empty(), "{}", place()),
        }
    }
    loaded
}

#[test]
fn damaged_files_load_or_are_refused() {
    for format in formats() {
        let loaded = fuzz(&format, FILES, 1);
        // Otherwise the damage would be too great to get anywhere.
        assert!(loaded >= FILES / 100, "{} of {}", loaded, format.name);
    }
}

#[test]
#[ignore = "as many files as the environment variable PATHSPACE_FUZZ_FILES says"]
fn soak() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let count = number("PATHSPACE_FUZZ_FILES").unwrap_or(10_000);
    let seed = number("PATHSPACE_FUZZ_SEED").unwrap_or(1_000_000);
    let only = std::env::var("PATHSPACE_FUZZ_FORMAT").ok();
    for format in formats() {
        if only.as_deref().is_some_and(|only| only != format.name) {
            continue;
        }
        let start = Instant::now();
        let loaded = fuzz(&format, count, seed);
        println!("{}: {loaded} of {count} load, {:?}", format.name, start.elapsed());
    }
}

/// Ends the process, with the file named, if one takes minutes.
struct Watch(&'static AtomicU64);

impl Watch {
    fn over(format: &'static str) -> Self {
        let seed: &AtomicU64 = Box::leak(Box::new(AtomicU64::new(0)));
        std::thread::spawn(move || {
            loop {
                let before = seed.load(Ordering::Relaxed);
                std::thread::sleep(Duration::from_secs(120));
                if before == u64::MAX {
                    break;
                }
                if seed.load(Ordering::Relaxed) == before {
                    eprintln!("seed {before} of {format} takes minutes");
                    std::process::abort();
                }
            }
        });
        Self(seed)
    }

    fn begin(&self, seed: u64) {
        self.0.store(seed, Ordering::Relaxed);
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.0.store(u64::MAX, Ordering::Relaxed);
    }
}

/// The processor time of this thread, where the system tells it; otherwise the time.
fn processor_time() -> Duration {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split(' ').next().and_then(|number| number.parse().ok());
    nanoseconds.map_or_else(|| START.elapsed(), Duration::from_nanos)
}

/// The most memory that the process has had so far; 0 where the system does not tell.
fn most_memory() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|l| l.trim().trim_end_matches(" kB").parse::<u64>().ok()).map_or(0, |k| k << 10)
}
