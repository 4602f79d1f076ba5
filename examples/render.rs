//! Renders one image of a scene with one integrator.
//!
//! ```text
//! cargo run --release --example render -- --integrator bidirectional --out target/box.png
//! cargo run --release --example render -- --scene model.obj --time 30s
//! cargo run --release --example render -- --scene scene.xml -D resx=256 -D resy=256 --strict
//! cargo run --release --example render -- --scene model.glb --environment sky.hdr --view left
//! cargo run --release --example render -- --scene model.glb --info
//! cargo run --release --example render -- --scene list
//! ```

mod common;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use common::{
    AnyIntegrator, FileOptions, FilterName, INTERRUPTED, NamedScene, SamplerName, SharedWalks,
};
use cpu_time::ProcessTime;
use pathspace::film::check_replaceable;
use pathspace::glam::UVec2;
use pathspace::integrator::{Depth, Estimator};
use pathspace::math::Rgb;
use pathspace::path::Roulette;
use pathspace::render::{Budget, Rendering, Settings};
use std::error::Error;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Renders one image of a scene with one integrator.
#[derive(Debug, Parser)]
#[command(name = "render", version, about)]
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
    shared: SharedWalks,
    /// Samples per pixel [default: 64, or 65536 as the limit of --target-error]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "time")]
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
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
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
    #[arg(
        long,
        default_value = "0",
        value_parser = common::parse_exposure,
        allow_hyphen_values = true
    )]
    exposure: f64,
    /// Image file to write, .exr, .hdr or .png [default: target/SCENE-INTEGRATOR.exr]
    #[arg(long, value_parser = common::parse_image_path)]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.scene == "list" {
        print!("{}", common::scene_list());
        return ExitCode::SUCCESS;
    }
    if arguments.info {
        match common::scene_info(&arguments.scene, arguments.size, &arguments.file) {
            Ok(text) => print!("{text}"),
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
    match run(&arguments, &scene, max_bounces) {
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
) -> Result<Stopped, Box<dyn Error>> {
    let name = arguments.integrator.name();
    // Before rendering: an hour's work must not end with a missing directory.
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from(format!("target/{}-{name}.exr", scene.name)));
    if let Some(directory) = out.parent().filter(|directory| !directory.as_os_str().is_empty()) {
        std::fs::create_dir_all(directory)
            .map_err(|error| format!("directory {}: {error}", directory.display()))?;
    }
    check_replaceable(&out).map_err(|error| format!("image file {}: {error}", out.display()))?;

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
        ..Settings::default()
    };
    let depth = Depth { min_bounces: arguments.min_bounces, max_bounces };
    let roulette = if arguments.no_roulette { Roulette::NEVER } else { Roulette::default() };
    let integrator = arguments.integrator.build(depth, roulette, arguments.shared);
    let missing = scene.missing(arguments.integrator, &*integrator)?;
    missing.iter().for_each(|paths| eprintln!("not in this image: {paths}"));
    if missing.is_empty() && !scene.is_complete(arguments.integrator, &missing) {
        eprintln!("not in this image: some light, since {name} cannot draw every path");
    }
    let interrupted = common::interrupt_flag();
    let bar = common::progress_bar(name);
    let clock = ProcessTime::now();
    let rendering = integrator.render_with_progress(
        &scene.world,
        &*scene.camera.0,
        &settings,
        &mut |progress| {
            common::show(&bar, progress)?;
            match interrupted.load(Ordering::Relaxed) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        },
    )?;
    let processors = clock.elapsed();
    bar.finish_and_clear();
    let mut file = rendering.to_file();
    file.exposure = arguments.exposure;
    let depth = max_bounces.map_or_else(|| "unbounded".to_owned(), |max| max.to_string());
    let entries = [
        ("scene", arguments.scene.clone()),
        ("max_bounces", depth),
        ("min_bounces", arguments.min_bounces.to_string()),
    ];
    file.metadata.extend(entries.map(|(key, value)| (key.to_owned(), value)));
    file.save(&out)?;

    print_summary(&rendering, processors, scene);
    println!("image       {}", out.display());
    Ok(Stopped(rendering.stopped))
}

fn print_summary(rendering: &Rendering, processors: Duration, scene: &NamedScene) {
    let counters = &rendering.counters;
    let seconds = rendering.wall.as_secs_f64();
    println!("scene       {}: {}", scene.name, scene.description);
    println!("integrator  {}: {}", rendering.integrator, rendering.techniques);
    println!("left out    {}", rendering.notes.left_out);
    if let Some(decision) = &rendering.notes.decision {
        println!("decision    {}", decision.to_string().replace('\n', "\n            "));
    }
    println!("samples     {} per pixel, {} in all", rendering.samples_per_pixel, counters.samples);
    if let Some(error) = rendering.estimated_error {
        println!("error       relMSE {error:.3e}, estimated");
    }
    println!(
        "time        {seconds:.3} s on the wall, {:.3} s of processors",
        processors.as_secs_f64()
    );
    println!(
        "rays        {} ({:.2} million per second)",
        counters.rays(),
        counters.rays() as f64 / seconds.max(1e-9) / 1e6
    );
    if counters.photons > 0 {
        println!(
            "photons     {}, {} queries, {} merges, {:.1} MB at most",
            counters.photons,
            counters.queries,
            counters.merges,
            counters.shared_bytes as f64 / 1e6
        );
    }
    if rendering.notes.estimator != Estimator::Unbiased {
        println!("estimator   {}", rendering.notes.estimator);
    }
    println!("mean        {}", rgb(rendering.image.mean()));
    let ledger = &counters.ledger;
    // Integrators without walks from the light keep no ledger.
    if !ledger.emitted.is_black() {
        let share = |part: Rgb| 100.0 * part.mean() / ledger.emitted.mean();
        println!(
            "light       absorbed {:.2} %, escaped {:.2} %, truncated {:.2} %, rejected {:.2} % of what was emitted",
            share(ledger.absorbed),
            share(ledger.escaped),
            share(ledger.truncated),
            share(ledger.rejected)
        );
    }
    if !ledger.clamped.is_black() {
        let lost = ledger.clamped * (1.0 / counters.samples as f64);
        println!("clamped     {} of the mean, which is lost", rgb(lost));
    }
    println!("truncated   {} walks", counters.truncated_subpaths);
    println!("non-finite  {}", counters.non_finite);
    for (technique, count) in rendering.non_finite().by_technique() {
        println!("            {count} by (s, t) = {technique}");
    }
}

fn rgb(value: Rgb) -> String {
    format!("{:.5} {:.5} {:.5}", value.r(), value.g(), value.b())
}
