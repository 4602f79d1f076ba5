//! Renders one image of a scene with one integrator.
//!
//! ```text
//! cargo run --release --example render -- --integrator bidirectional --out target/box.png
//! cargo run --release --example render -- --scene model.obj --time 30s
//! cargo run --release --example render -- --scene scene.xml -D resx=256 -D resy=256 --strict
//! cargo run --release --example render -- --scene model.glb --environment sky.hdr --view left
//! cargo run --release --example render -- --scene model.glb --info
//! cargo run --release --example render -- --samples 4096 --checkpoint target/box.npz --resume
//! cargo run --release --example render -- --samples 4096 --shard 1/8
//! cargo run --release --example render -- --samples 4096 --live
//! cargo run --release --example render -- --scene list
//! ```

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod live;
#[cfg(test)]
mod tests;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use common::{
    AnyIntegrator, FileOptions, FilterName, INTERRUPTED, MANY, NamedScene, SamplerName, Tuning,
};
use cpu_time::ProcessTime;
use live::{Live, Views};
use pathspace::film::{ImageFile, check_replaceable};
use pathspace::glam::UVec2;
use pathspace::integrator::{Depth, Estimator};
use pathspace::math::Rgb;
use pathspace::path::Roulette;
use pathspace::render::{
    Budget, Checkpoint, CheckpointFileError, Progress, RenderError, Rendering, Settings, Shard,
};
use std::collections::BTreeMap;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Renders one image of a scene with one integrator.
///
/// cargo run --release --example render -- --integrator bdpt --samples 256 --out target/box.png
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// A scene of the gallery, a Wavefront OBJ, glTF, Mitsuba XML or pbrt file, or `list` for the
    /// names of the gallery
    #[arg(long, default_value = "cornell-box", value_name = "NAME|FILE")]
    scene: String,
    #[command(flatten)]
    file: FileOptions,
    /// Integrator, which decides how paths are drawn; those that it cannot draw are named first
    #[arg(long, value_enum, default_value_t = AnyIntegrator::PathTracing)]
    integrator: AnyIntegrator,
    #[command(flatten)]
    tuning: Tuning,
    /// Samples per pixel [default: 64, or 65536 as the limit of --target-error]
    #[arg(long, value_parser = common::parse_count::<u32, 1, MANY>, conflicts_with = "time")]
    samples: Option<u32>,
    /// Time to render for, such as 500ms, 10s or 2m; the image then depends on the machine
    #[arg(long, value_parser = common::parse_duration)]
    time: Option<Duration>,
    /// End once the relative mean squared error is estimated to be this; --samples and --time are
    /// then limits
    #[arg(long, value_name = "E", value_parser = common::parse_error)]
    target_error: Option<f64>,
    /// Different seeds give independent images
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of threads, which never changes the image [default: all processors]
    #[arg(long, value_parser = common::parse_count::<u16, 1, 1024>)]
    threads: Option<u16>,
    /// Leave out paths with more scattering events [default: the scene's own]
    #[arg(long)]
    max_bounces: Option<u32>,
    /// Leave out paths with fewer scattering events
    #[arg(long, default_value_t = 0)]
    min_bounces: u32,
    /// Let walks end by absorption, escape and --max-bounces only
    #[arg(long)]
    no_roulette: bool,
    /// Image size in pixels, into which films of files fit with the shape that they have
    /// [default: 256x256, or the file's own]
    #[arg(long, value_parser = common::parse_size, value_name = "WxH")]
    size: Option<UVec2>,
    /// Print what the scene holds (cameras, lights, materials, warnings), and render nothing
    #[arg(long)]
    info: bool,
    /// Source of random numbers
    #[arg(long, value_enum, default_value_t)]
    sampler: SamplerName,
    /// Pixel filter [default: the scene's own, or the box]
    #[arg(long, value_enum)]
    filter: Option<FilterName>,
    /// Stops by which a PNG is made brighter; HDR and EXR keep radiance
    #[arg(long, default_value = "0", value_parser = common::parse_exposure)]
    exposure: f64,
    /// Image file to write, .exr, .hdr or .png [default: target/SCENE-INTEGRATOR.exr, and none of a
    /// shard]
    #[arg(long, value_parser = common::parse_image_path)]
    out: Option<PathBuf>,
    /// File of the rendering so far, from which --resume goes on; written from time to time, when the
    /// process is asked to end, and in the end
    #[arg(long, value_name = "FILE.npz")]
    checkpoint: Option<PathBuf>,
    /// Time from one checkpoint to the next
    #[arg(long, default_value = "60s", value_name = "TIME", value_parser = common::parse_duration)]
    every: Duration,
    /// Go on from the checkpoint, if it is there; the image is that of a rendering without a break
    #[arg(long)]
    resume: bool,
    /// Render part I of N, into a checkpoint; the example `merge` makes one image of all
    /// [checkpoint: target/SCENE-INTEGRATOR-I-of-N.npz]
    #[arg(long, value_name = "I/N", conflicts_with_all = ["time", "target_error"])]
    shard: Option<Shard>,
    /// Show the image in the viewer tev while it is rendered, and write the preview, too; without a
    /// viewer, or if it goes away, the rendering goes on [without a value: 127.0.0.1:14158]
    #[arg(
        long,
        value_name = "HOST:PORT",
        num_args = 0..=1,
        default_missing_value = live::TEV,
        value_parser = live::parse_viewer
    )]
    live: Option<String>,
    /// Write the image so far, a PNG, beside the image from time to time [default: 5s with --live]
    #[arg(long, value_name = "TIME", value_parser = common::parse_duration)]
    preview_every: Option<Duration>,
    /// Leave out of files what a clock decides: the same rendering makes the same bytes
    #[arg(long)]
    no_clocks: bool,
}

fn main() -> ExitCode {
    let arguments: Arguments = common::options();
    if arguments.scene == "list" {
        say!("{}", common::scene_list().trim_end());
        return ExitCode::SUCCESS;
    }
    if arguments.info {
        match common::scene_info(&arguments.scene, arguments.size, &arguments.file) {
            Ok(text) => say!("{}", text.trim_end()),
            Err(error) => refuse(&format!("--scene: {error}")),
        }
        return ExitCode::SUCCESS;
    }
    let scene = match common::scene_or_file(&arguments.scene, arguments.size, &arguments.file) {
        Ok(scene) => scene,
        Err(error) => refuse(&format!("--scene: {error}")),
    };
    let max_bounces = arguments.max_bounces.or(scene.max_bounces);
    if max_bounces.is_some_and(|max| max < arguments.min_bounces) {
        refuse("--min-bounces is larger than the largest number of bounces: no path would count");
    }
    match run(&arguments, &scene, max_bounces, &common::interrupt_flag()) {
        Ok(Stopped(false)) => ExitCode::SUCCESS,
        Ok(Stopped(true)) => ExitCode::from(INTERRUPTED),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Ends the program as it ends for any other wrong argument.
fn refuse(reason: &str) -> ! {
    Arguments::command().error(ErrorKind::ValueValidation, reason).exit()
}

/// True if the image has not all samples because the process was asked to end.
struct Stopped(bool);

fn run(
    arguments: &Arguments,
    scene: &NamedScene,
    max_bounces: Option<u32>,
    interrupted: &AtomicBool,
) -> Result<Stopped, Box<dyn Error>> {
    let name = arguments.integrator.name();
    let files = Files::of(arguments, &format!("target/{}-{name}", scene.name));
    files.probe()?;
    let settings = Settings {
        budget: match arguments.time {
            Some(time) => Budget::Time(time),
            None => {
                Budget::Samples(arguments.samples.unwrap_or(if arguments.target_error.is_some() {
                    65536
                } else {
                    64
                }))
            }
        },
        target_error: arguments.target_error,
        seed: arguments.seed,
        threads: arguments.threads.map(usize::from),
        filter: arguments.filter.map_or(scene.filter, Into::into),
        sampler: arguments.sampler.into(),
        shard: arguments.shard.unwrap_or_default(),
        keeps_checkpoint: files.keeps_checkpoint,
        ..Settings::default()
    };
    let depth = Depth { min_bounces: arguments.min_bounces, max_bounces };
    let roulette = if arguments.no_roulette { Roulette::NEVER } else { Roulette::default() };
    let integrator = arguments.integrator.build(depth, roulette, arguments.tuning);
    let missing = scene.missing(arguments.integrator, &*integrator)?;
    missing.iter().for_each(|paths| eprintln!("not in this image: {paths}"));
    if missing.is_empty() && !scene.is_complete(arguments.integrator, &missing) {
        eprintln!("not in this image: some light, since {name} cannot draw every path");
    }
    let depth = max_bounces.map_or_else(|| "unbounded".to_owned(), |max| max.to_string());
    let metadata: BTreeMap<String, String> = [
        ("scene", arguments.scene.clone()),
        ("max_bounces", depth),
        ("min_bounces", arguments.min_bounces.to_string()),
        ("exposure", arguments.exposure.to_string()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into();
    let from = if arguments.resume { files.checkpoint()? } else { None };
    if let Some(from) = &from {
        if from.metadata != metadata {
            let (there, here) = (&from.metadata, &metadata);
            return Err(
                format!("{}: it is of {there:?}, not of {here:?}", files.npz.display()).into()
            );
        }
        say!("resumed     {} after {} passes", files.npz.display(), from.passes().len());
    }
    let bar = common::progress_bar(name);
    let mut live = match files.views(arguments, scene.camera.0.film().window_size()) {
        Some(views) => Some(Live::start(views, &bar)?),
        None => None,
    };
    let clock = ProcessTime::now();
    let (mut saved, mut failed) = (Instant::now(), None);
    let mut watch = |progress: &Progress<'_>| {
        common::show(&bar, progress)?;
        if let Some(live) = &mut live {
            live.look(progress);
        }
        let is_interrupted = interrupted.load(Ordering::Relaxed);
        if is_interrupted || files.keeps_checkpoint && saved.elapsed() >= arguments.every {
            failed = files.save(progress.checkpoint(), &metadata).err();
            saved = Instant::now();
        }
        match is_interrupted || failed.is_some() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let (world, camera) = (&scene.world, &*scene.camera.0);
    let rendering = match from {
        Some(from) => integrator.resume(from, world, camera, &settings, &mut watch),
        None => integrator.render_with_progress(world, camera, &settings, &mut watch),
    };
    let rendering = rendering.map_err(|error| match error {
        RenderError::Checkpoint(error) => format!("{}: {error}", files.npz.display()),
        RenderError::ShardOfLearner { .. } => {
            format!("--shard: {error}; renderings with other --seed can be averaged instead")
        }
        error => error.to_string(),
    })?;
    let processors = clock.elapsed();
    if let Some(live) = live {
        live.finish(rendering.image.clone());
    }
    bar.finish_and_clear();
    let stopped = Stopped(rendering.stopped);
    let checkpoint = match &rendering.checkpoint {
        Some(checkpoint) => files.save(checkpoint.clone(), &metadata),
        None => Ok(()),
    };
    print_summary(&rendering, name, processors, scene);
    if let Some(out) = &files.image {
        let mut file = rendering.to_file();
        file.exposure = arguments.exposure;
        file.metadata.extend(metadata);
        if arguments.no_clocks {
            file.metadata.remove(ImageFile::CLOCK);
        }
        file.save(out)?;
        say!("image       {}", out.display());
    }
    // The image is there all the same.
    failed.map_or(checkpoint, Err)?;
    if files.keeps_checkpoint || stopped.0 {
        say!("checkpoint  {}", files.npz.display());
    }
    Ok(stopped)
}

/// The files of a rendering.
struct Files {
    image: Option<PathBuf>,
    npz: PathBuf,
    /// Of the image so far, if it is wanted.
    preview: Option<PathBuf>,
    /// True if the checkpoint is written in any case, and not only when the process is asked to end.
    keeps_checkpoint: bool,
    has_clocks: bool,
}

impl Files {
    fn of(arguments: &Arguments, default: &str) -> Self {
        let image = arguments.out.clone();
        let image = match arguments.shard {
            None => Some(image.unwrap_or_else(|| PathBuf::from(format!("{default}.exr")))),
            Some(_) => image,
        };
        let npz = arguments.checkpoint.clone().unwrap_or_else(|| match (arguments.shard, &image) {
            (Some(shard), _) => {
                PathBuf::from(format!("{default}-{}-of-{}.npz", shard.index(), shard.count()))
            }
            (None, Some(image)) => image.with_extension("npz"),
            (None, None) => PathBuf::from(format!("{default}.npz")),
        });
        let keeps_checkpoint = arguments.checkpoint.is_some() || arguments.shard.is_some();
        let is_seen = arguments.live.is_some() || arguments.preview_every.is_some();
        let preview = is_seen.then(|| {
            let beside = image.as_ref().unwrap_or(&npz);
            let stem = beside.file_stem().unwrap_or_default().to_string_lossy();
            beside.with_file_name(format!("{stem}-preview.png"))
        });
        Self { image, npz, preview, keeps_checkpoint, has_clocks: !arguments.no_clocks }
    }

    /// The places in which the rendering is to be seen while it goes on.
    fn views(&self, arguments: &Arguments, size: UVec2) -> Option<Views> {
        let file = self.preview.clone()?;
        let image = self.image.as_ref().unwrap_or(&self.npz);
        Some(Views {
            viewer: arguments.live.clone(),
            // Another name for each rendering: a viewer may have that of the last one.
            title: format!("{} (rendering {})", image.display(), std::process::id()),
            size,
            file,
            exposure: arguments.exposure,
            every: arguments.preview_every.unwrap_or(Duration::from_secs(5)),
        })
    }

    /// Finds out whether they can be written: an hour's work must not end with a missing directory.
    fn probe(&self) -> Result<(), Box<dyn Error>> {
        for file in self.image.iter().chain([&self.npz]).chain(&self.preview) {
            let directory = file.parent().filter(|directory| !directory.as_os_str().is_empty());
            if let Some(directory) = directory {
                std::fs::create_dir_all(directory)
                    .map_err(|error| format!("directory {}: {error}", directory.display()))?;
            }
            check_replaceable(file).map_err(|error| format!("{}: {error}", file.display()))?;
        }
        Ok(())
    }

    /// The checkpoint to go on from, if it is there.
    fn checkpoint(&self) -> Result<Option<Checkpoint>, CheckpointFileError> {
        self.npz.exists().then(|| Checkpoint::load(&self.npz)).transpose()
    }

    fn save(
        &self,
        mut checkpoint: Checkpoint,
        metadata: &BTreeMap<String, String>,
    ) -> Result<(), CheckpointFileError> {
        checkpoint.metadata.clone_from(metadata);
        let checkpoint = if self.has_clocks { checkpoint } else { checkpoint.without_clocks() };
        checkpoint.save(&self.npz)
    }
}

fn print_summary(rendering: &Rendering, name: &str, processors: Duration, scene: &NamedScene) {
    let counters = &rendering.counters;
    let seconds = rendering.wall.as_secs_f64();
    say!("scene       {}: {}", scene.name, scene.description);
    say!("integrator  {name}: {}", rendering.techniques);
    say!("left out    {}", rendering.notes.left_out);
    if let Some(decision) = &rendering.notes.decision {
        say!("decision    {}", decision.to_string().replace('\n', "\n            "));
    }
    if let Some(guidance) = &rendering.notes.guidance {
        say!("guiding     {guidance}");
    }
    if let Some(normalization) = &rendering.notes.normalization {
        say!(
            "chains      b = {:.5} ± {:.2} %, the mean of {} candidates",
            normalization.mean(),
            100.0 * normalization.relative_error(),
            normalization.candidates
        );
    }
    say!("samples     {} per pixel, {} in all", rendering.samples_per_pixel, counters.samples);
    if let Some(error) = rendering.estimated_error {
        say!("error       relMSE {error:.3e}, estimated");
    }
    say!("time        {seconds:.3} s on the wall, {:.3} s of processors", processors.as_secs_f64());
    say!(
        "rays        {} ({:.2} million per second)",
        counters.rays(),
        counters.rays() as f64 / seconds.max(1e-9) / 1e6
    );
    if counters.photons > 0 {
        say!(
            "photons     {}, {} queries, {} merges, {:.1} MB at most",
            counters.photons,
            counters.queries,
            counters.merges,
            counters.shared_bytes as f64 / 1e6
        );
    }
    if rendering.notes.estimator != Estimator::Unbiased {
        say!("estimator   {}", rendering.notes.estimator);
    }
    say!("mean        {}", rgb(rendering.image.mean()));
    let ledger = &counters.ledger;
    // Integrators without walks from the light keep no ledger.
    if !ledger.emitted.is_black() {
        let share = |part: Rgb| 100.0 * part.mean() / ledger.emitted.mean();
        say!(
            "light       absorbed {:.2} %, escaped {:.2} %, truncated {:.2} %, rejected {:.2} % of what was emitted",
            share(ledger.absorbed),
            share(ledger.escaped),
            share(ledger.truncated),
            share(ledger.rejected)
        );
    }
    if !ledger.clamped.is_black() {
        let lost = ledger.clamped * (1.0 / counters.samples as f64);
        say!("clamped     {} of the mean, which is lost", rgb(lost));
    }
    say!("truncated   {} walks", counters.truncated_subpaths);
    say!("non-finite  {}", counters.non_finite);
    for (technique, count) in rendering.non_finite().by_technique() {
        say!("            {count} by (s, t) = {technique}");
    }
}

fn rgb(value: Rgb) -> String {
    format!("{:.5} {:.5} {:.5}", value.r(), value.g(), value.b())
}
