//! Error against run time: compares the integrators on a scene and writes a page with images, plots
//! and tables.
//!
//! All integrators get the same time, the same number of samples, or what they need to reach a
//! target error, in several independent runs that alternate. The library's `report` module
//! measures; this program chooses scene, integrators and reference, shows progress and writes the
//! files. Ctrl-C ends the work early and still writes the page. With `--serve` a browser shows it
//! while it fills.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod columns;
mod picture;
mod serve;
mod table;
#[cfg(test)]
mod tests;

use clap::Parser;
use columns::wrapped;
use common::{
    AnyIntegrator, End, FileOptions, MANY, NamedScene, Tuning, exit_code, interrupt_flag,
    parse_count, parse_duration, parse_error, parse_size, progress_bar, scene_list, scene_or_file,
};
use indicatif::ProgressBar;
use pathspace::film::replace_file;
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::{Bidirectional, Depth};
use pathspace::path::Roulette;
use pathspace::render::{Budget, Settings, Shard};
use pathspace::report::{
    Contestant, Plan, Reference, ReferencePlan, SceneInfo, Step, Study, cached_reference, study,
    study_of_shards, study_shard,
};
use pathspace::scene::World;
use serve::Server;
use std::error::Error;
use std::net::SocketAddr;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Renders a scene with all integrators, measures their error and cost, tests whether they agree,
/// and writes a page.
///
/// cargo run --release --example compare -- --scene pool --integrators pt,bdpt,vcm --time 30s
#[derive(Parser, Debug)]
#[command(after_help = format!(
    "Wrong is an unbiased integrator that disagrees with another or with the reference. What has \
     met too little to be tested is called undecided, which is no fault and no agreement.\n\n\
     Scenes of the gallery:\n{}",
    scene_list()
))]
struct Options {
    /// Name of a scene in the gallery, a scene file, or `all` for the whole gallery
    #[arg(long, default_value = "cornell-box")]
    scene: String,
    #[command(flatten)]
    file: FileOptions,
    /// Time for each integrator, all runs together, such as 500ms, 10s or 2m
    #[arg(long, default_value = "10s", value_parser = parse_duration)]
    time: Duration,
    /// Samples per pixel for each integrator, all runs together, instead of equal time
    #[arg(long, conflicts_with = "time", value_parser = parse_count::<u32, 2, MANY>)]
    samples: Option<u32>,
    /// Independent runs that an integrator's budget is split into
    #[arg(long, default_value_t = 8, value_parser = parse_count::<u32, 2, 1024>)]
    seeds: u32,
    /// Integrators to compare, separated by commas; the first that sees every path, without bias
    /// and with a finite variance, is the baseline of speed-ups
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "path-tracing,light-tracing,uniform-area,bidirectional"
    )]
    integrators: Vec<AnyIntegrator>,
    #[command(flatten)]
    tuning: Tuning,
    /// Width and height of the images in pixels, into which films of files fit with the shape that
    /// they have [default: 256x256, or the file's own]
    #[arg(long, value_parser = parse_size)]
    size: Option<UVec2>,
    /// Largest number of scattering events; the default depends on the scene
    #[arg(long)]
    max_bounces: Option<u32>,
    /// Seed that those of the runs are derived from
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of threads; all processors by default
    #[arg(long, value_parser = parse_count::<u32, 1, 1024>)]
    threads: Option<u32>,
    /// Image to compare with (.exr), taken as exact, in place of a rendered reference
    #[arg(long, conflicts_with_all = ["reference_samples", "reference_time"])]
    reference: Option<PathBuf>,
    /// Samples per pixel of the reference, half of them by each of two integrators
    #[arg(
        long,
        conflicts_with = "reference_time",
        value_parser = parse_count::<u32, 4, MANY>
    )]
    reference_samples: Option<u32>,
    /// Time for rendering the reference, which is kept in target/references
    #[arg(long, default_value = "20s", value_parser = parse_duration)]
    reference_time: Duration,
    /// Render until a run's relative mean squared error is this, with --time or --samples as the
    /// limit [default: use up the budget, and say when 0.01 was reached]
    #[arg(long, value_name = "E", value_parser = parse_error)]
    target_error: Option<f64>,
    /// Leave out of the files what clocks tell and the machine: two runs with one seed write the
    /// same bytes. Without --reference, the reference has 16 times the samples
    #[arg(long, requires = "samples", conflicts_with = "reference_time")]
    no_clocks: bool,
    /// Render part I of N of the runs, integrators and seeds, into files in OUT/SCENE/shard-I-of-N
    #[arg(long, value_name = "I/N", requires = "samples", conflicts_with = "target_error")]
    shard: Option<Shard>,
    /// Make the page of the runs in OUT/SCENE/shard-*, in place of rendering them
    #[arg(long, requires = "samples", conflicts_with_all = ["shard", "target_error"])]
    merge: bool,
    /// Serve the page on this machine alone while it fills, with a button that ends the study as
    /// Ctrl-C does; then until the page is closed, or Ctrl-C [without a value: port 8327, or a free
    /// one if that is taken]
    #[arg(long, value_name = "HOST:PORT", value_parser = serve::parse_loopback, conflicts_with = "shard")]
    serve: Option<Option<SocketAddr>>,
    /// Directory for the results; a directory is made in it for each scene
    #[arg(long, default_value = "target/compare")]
    out: PathBuf,
}

/// The directory in which references are kept.
const CACHE: &str = "target/references";
/// Runs of each half of the reference.
const REFERENCE_RUNS: u32 = 16;

fn main() -> ExitCode {
    let options: Options = common::options();
    exit_code(run(&options, &interrupt_flag()))
}

/// Runs the studies of all scenes.
fn run(options: &Options, interrupted: &AtomicBool) -> Result<End, Box<dyn Error>> {
    let server = options.serve.map(Server::start).transpose()?;
    if let Some(server) = &server {
        say!("page: {}\n", server.url());
    }
    let mut watch = Watch { interrupted, server, has_clocks: !options.no_clocks };
    let names =
        if options.scene == "all" { gallery::NAMES.to_vec() } else { vec![options.scene.as_str()] };
    let mut suspicious = Vec::new();
    for name in &names {
        let scene = scene_or_file(name, options.size, &options.file)?;
        let directory = options.out.join(&scene.name);
        if !compare(options, &scene, &directory, &mut watch)? {
            suspicious.push(scene.name);
        }
        if watch.is_ended() {
            break;
        }
    }
    if names.len() > 1 {
        match suspicious.len() {
            0 => say!("the integrators agree on all {} scenes", names.len()),
            n => say!(
                "something is wrong on {n} of {} scenes: {}",
                names.len(),
                suspicious.join(", ")
            ),
        }
    }
    let end = match watch.is_ended() {
        true => End::Interrupted,
        false if suspicious.is_empty() => End::Done,
        false => End::Wrong,
    };
    if let Some(server) = watch.server
        && !interrupted.load(Ordering::Relaxed)
    {
        say!("page: {} until it is closed there, or Ctrl-C", server.url());
        server.wait(interrupted);
    }
    Ok(end)
}

/// The ones who see how far the work is, and may end it.
struct Watch<'a> {
    interrupted: &'a AtomicBool,
    server: Option<Server>,
    has_clocks: bool,
}

impl Watch<'_> {
    /// True if the work is to end early.
    fn is_ended(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
            || self.server.as_ref().is_some_and(Server::is_stopped)
    }

    fn see(&mut self, bar: &ProgressBar, step: &Step<'_>) -> ControlFlow<()> {
        bar.set_position((step.fraction * common::STEPS as f64) as u64);
        bar.set_message(step.label.to_owned());
        if self.is_ended() {
            return ControlFlow::Break(());
        }
        if let Some(server) = &mut self.server {
            server.tell(step.label, step.fraction);
            let study = || step.study().map(|study| clocked(study, self.has_clocks));
            server.update(|| study().map(|study| study.page()));
        }
        ControlFlow::Continue(())
    }
}

fn compare(
    options: &Options,
    scene: &NamedScene,
    directory: &Path,
    watch: &mut Watch<'_>,
) -> Result<bool, Box<dyn Error>> {
    let depth = options.max_bounces.or(scene.max_bounces);
    say!("{}", wrapped(&format!("{}: {}", scene.name, scene.description)));
    let mut integrators: Vec<AnyIntegrator> = Vec::new();
    for integrator in &options.integrators {
        if !integrators.contains(integrator) {
            integrators.push(*integrator);
        }
    }
    let range = Depth { min_bounces: 0, max_bounces: depth };
    let build = |i: &AnyIntegrator| i.build(range, Roulette::default(), options.tuning);
    let methods: Vec<_> = integrators.iter().map(build).collect();
    let mut contestants = Vec::new();
    for (integrator, method) in integrators.iter().zip(&methods) {
        let missing = scene.missing(*integrator, &**method)?;
        let is_complete = scene.is_complete(*integrator, &missing);
        contestants.push(Contestant::<World> {
            pyramid: *integrator == AnyIntegrator::Vcm,
            ..Contestant::new(integrator.name(), &**method, is_complete)
        });
    }

    let settings = Settings {
        seed: options.seed,
        threads: options.threads.map(|n| n as usize),
        filter: scene.filter,
        ..Plan::default().settings
    };
    let plan = Plan {
        budget: options.samples.map_or(Budget::Time(options.time), Budget::Samples),
        seeds: options.seeds,
        settings,
        target: options.target_error.unwrap_or(Plan::default().target),
        until_target: options.target_error.is_some(),
        baseline: None,
        pyramid: Some(Bidirectional { depth: range, ..Bidirectional::default() }),
        command: Some(command_line()),
    };
    let info = SceneInfo {
        name: scene.name.clone(),
        description: scene.description.clone(),
        max_bounces: depth,
        ..SceneInfo::default()
    };
    let (world, camera) = (&scene.world, &*scene.camera.0);
    if let Some(server) = &mut watch.server {
        server.begin(&scene.name, directory);
    }
    if let Some(shard) = options.shard {
        let runs = directory.join(format!("shard-{}-of-{}", shard.index(), shard.count()));
        let bar = progress_bar("comparing");
        let mut see = |step: &Step<'_>| watch.see(&bar, step);
        let files = study_shard(world, camera, &contestants, &plan, shard, &runs, &mut see)?;
        bar.finish_and_clear();
        say!("wrote {} runs to {}\n", files.len(), runs.display());
        return Ok(true);
    }
    let reference = reference(options, scene, depth, &settings, watch)?;
    say!("{}\n", wrapped(&format!("reference: {}", reference.origin())));
    let bar = progress_bar("comparing");
    let mut see = |step: &Step<'_>| watch.see(&bar, step);
    let study = if options.merge {
        let shards = shards(directory)?;
        study_of_shards(world, camera, &info, &contestants, reference, &plan, &shards, &mut see)?
    } else {
        study(world, camera, &info, &contestants, reference, &plan, &mut see)?
    };
    bar.finish_and_clear();
    let study = clocked(study, watch.has_clocks);

    table::print(&study.report);
    write(&study, directory)?;
    if let Some(server) = &watch.server {
        let page = directory.join("index.html");
        let unreadable = |error| format!("{}: {error}", page.display());
        server.finish(&std::fs::read_to_string(&page).map_err(unreadable)?);
    }
    say!("wrote {}\n", directory.join("index.html").display());
    Ok(study.report.is_clean())
}

/// The study with clocks or without.
fn clocked(study: Study, has_clocks: bool) -> Study {
    if has_clocks { study } else { study.without_clocks() }
}

/// The directories of the shards of a study.
fn shards(directory: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let unreadable = |error| format!("{}: {error}", directory.display());
    let mut shards = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() && name.starts_with("shard-") {
            shards.push(path);
        }
    }
    shards.sort();
    match shards.is_empty() {
        true => Err(format!("{}: there are no directories shard-*", directory.display()).into()),
        false => Ok(shards),
    }
}

/// Two halves by different integrators, if two of them see everything.
fn reference(
    options: &Options,
    scene: &NamedScene,
    depth: Option<u32>,
    settings: &Settings,
    watch: &mut Watch<'_>,
) -> Result<Reference, Box<dyn Error>> {
    if let Some(path) = &options.reference {
        return Ok(Reference::load(path)?);
    }
    let paths = AnyIntegrator::PathTracing;
    let missing = scene.missing(paths, &*paths.build_up_to(depth))?;
    let is_complete = scene.is_complete(paths, &missing);
    let second = if is_complete { paths } else { AnyIntegrator::Bidirectional };
    let methods = [AnyIntegrator::Bidirectional, second]
        .map(|integrator| (integrator, integrator.build_up_to(depth)));
    let halves = [0, 1].map(|i| Contestant::new(methods[i].0.name(), &*methods[i].1, true));
    // Without clocks the budget may not be in time.
    let enough = options.samples.filter(|_| options.no_clocks).map(|n| n.saturating_mul(16));
    let samples = options.reference_samples.or(enough);
    let budget = samples.map_or(Budget::Time(options.reference_time), Budget::Samples);
    let runs = samples.map_or(REFERENCE_RUNS, |samples| REFERENCE_RUNS.min(samples / 2));
    let plan = ReferencePlan { budget, runs, settings: *settings };
    let bar = progress_bar("reference");
    let key = depth.map_or_else(|| scene.name.clone(), |depth| format!("{} {depth}", scene.name));
    let (world, camera) = (&scene.world, &*scene.camera.0);
    let mut see = |step: &Step<'_>| watch.see(&bar, step);
    let reference = cached_reference(
        Path::new(CACHE),
        &key,
        world,
        camera,
        [&halves[0], &halves[1]],
        &plan,
        &mut see,
    )?;
    bar.finish_and_clear();
    Ok(reference)
}

/// The command that was given, with cargo in place of the program's path, and without the
/// directory and the server, which change nothing in the files.
fn command_line() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=".contains(c);
    let quote = |text: String| {
        if text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
    };
    let mut arguments = Vec::new();
    let mut given = std::env::args().skip(1).peekable();
    while let Some(argument) = given.next() {
        match argument.split_once('=').map_or(&*argument, |(name, _)| name) {
            "--out" | "--serve" => {
                if !argument.contains('=') {
                    given.next_if(|value| !value.starts_with("--"));
                }
            }
            "--merge" => {}
            _ => arguments.push(quote(argument)),
        }
    }
    let command = format!("{} -- {}", common::CARGO_COMMAND, arguments.join(" "));
    command.trim_end_matches([' ', '-']).to_owned()
}

fn write(study: &Study, directory: &Path) -> Result<(), Box<dyn Error>> {
    study.save(directory)?;
    replace_file(directory.join("summary.md"), table::markdown(&study.report).as_bytes())?;
    picture::side_by_side(study).save(directory.join("compare.png"))?;
    Ok(())
}
