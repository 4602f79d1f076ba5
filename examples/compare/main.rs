//! Compares the integrators on a scene: images, error maps, a table of error against cost, and a test of whether they agree.
//!
//! All integrators get the same time, or the same number of samples, in several independent renderings (batches). The spread of the batches
//! gives every number its standard error. Batches of the integrators alternate, so that a machine that slows down slows all alike.
//! The reference is rendered by path tracing and bidirectional path tracing with seeds of its own, and its error is measured too.

#[path = "../common/mod.rs"]
mod common;

mod agreement;
mod font;
mod measure;
mod picture;
mod reference;
mod report;

use clap::Parser;
use common::{AnyIntegrator, NamedScene, parse_duration, parse_size, progress_bar, scene_list, scene_or_file};
use measure::{Batches, Layout, Measured, Plan};
use pathspace::glam::UVec2;
use pathspace::path::TechniqueSet;
use pathspace::render::{Budget, Settings, unattended};
use pathspace::scene::gallery;
use reference::Reference;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Renders a scene with all integrators, measures their error and cost, and tests whether they agree.
#[derive(Parser, Debug)]
#[command(after_help = format!("Scenes of the gallery:\n{}", scene_list()))]
pub struct Options {
    /// Name of a scene in the gallery, a scene file, or `all` for the whole gallery
    #[arg(long, default_value = "cornell-box")]
    scene: String,
    /// Time for each integrator, such as 500ms, 10s or 2m
    #[arg(long, default_value = "10s", value_parser = parse_duration)]
    time: Duration,
    /// Samples per pixel for each integrator, instead of equal time
    #[arg(long, conflicts_with = "time", value_parser = clap::value_parser!(u32).range(4..))]
    samples: Option<u32>,
    /// Independent renderings that an integrator's budget is split into
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(4..=1024))]
    batches: u32,
    /// Integrators to compare, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "path-tracing,light-tracing,uniform-area,bidirectional")]
    integrators: Vec<AnyIntegrator>,
    /// Width and height of the images in pixels
    #[arg(long, default_value = "256x256", value_parser = parse_size)]
    size: UVec2,
    /// Largest number of scattering events; the default depends on the scene
    #[arg(long)]
    max_bounces: Option<u32>,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of threads; all processors by default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    /// Image to compare with (.exr), in place of a rendered reference
    #[arg(long, conflicts_with_all = ["reference_samples", "reference_time"])]
    reference: Option<PathBuf>,
    /// Samples per pixel of the reference, half of them by each of two integrators
    #[arg(long, conflicts_with = "reference_time", value_parser = clap::value_parser!(u32).range(8..))]
    reference_samples: Option<u32>,
    /// Time for rendering the reference
    #[arg(long, default_value = "20s", value_parser = parse_duration)]
    reference_time: Duration,
    /// Directory for the results; a directory is made in it for each scene
    #[arg(long, default_value = "target/compare")]
    out: PathBuf,
}

fn main() -> ExitCode {
    let options = Options::parse();
    match run(&options) {
        Ok(true) => ExitCode::SUCCESS,
        // Told apart from errors, so that scripts can use the verdict.
        Ok(false) => ExitCode::from(3),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Whether the integrators agree on all scenes.
fn run(options: &Options) -> Result<bool, Box<dyn Error>> {
    let names = if options.scene == "all" { gallery::NAMES.to_vec() } else { vec![options.scene.as_str()] };
    let mut disagreements = Vec::new();
    for name in &names {
        let scene = scene_or_file(name, options.size)?;
        let directory = options.out.join(&scene.name);
        std::fs::create_dir_all(&directory).map_err(|e| format!("{}: {e}", directory.display()))?;
        if !compare(options, &scene, &directory)? {
            disagreements.push(scene.name);
        }
    }
    if names.len() > 1 {
        match disagreements.len() {
            0 => println!("the integrators agree on all {} scenes", names.len()),
            n => println!("the integrators disagree on {n} of {} scenes: {}", names.len(), disagreements.join(", ")),
        }
    }
    Ok(disagreements.is_empty())
}

fn compare(options: &Options, scene: &NamedScene, directory: &Path) -> Result<bool, Box<dyn Error>> {
    let camera = &*scene.camera.0;
    let layout = Layout::new(camera.film());
    let depth = options.max_bounces.or(scene.max_bounces);
    let bounces = depth.map_or_else(|| "no limit on bounces".to_owned(), |depth| format!("at most {depth} bounces"));
    let size = camera.film().window_size();
    println!("{}: {}", scene.name, scene.description);
    println!("{} x {} pixels, {bounces}, seed {}, {} batches", size.x, size.y, options.seed, options.batches);

    let reference = Reference::make(options, scene, depth, layout)?;
    println!("reference: {}", reference.origin);

    let threads = options.threads.map(|n| n as usize);
    let bar = progress_bar("comparing");
    let mut runs: Vec<Batches> = Vec::new();
    for (index, integrator) in options.integrators.iter().enumerate() {
        let settings = Settings { threads, seed: measure::seed(options.seed, index as u64), ..Settings::default() };
        let method = integrator.build(0, depth);
        // A pass that does not count, to warm up.
        let warm_up = Settings { budget: Budget::Samples(1), seed: !options.seed, ..settings };
        let techniques = method.render(&scene.world, camera, &warm_up, &mut unattended)?.techniques;
        if techniques == TechniqueSet::NONE {
            println!("{integrator} has no technique for this scene and is left out");
        } else {
            runs.push(Batches::new(*integrator, method, settings, layout));
        }
    }
    let steps = u64::from(options.batches) * runs.len().max(1) as u64;
    let budget = options.samples.map_or(Budget::Time(options.time), Budget::Samples);
    let plan = Plan { budget, batches: options.batches };
    let mut done = 0;
    for batch in 0..options.batches {
        for run in &mut runs {
            bar.set_position(done * 1000 / steps);
            done += 1;
            bar.set_message(run.integrator.name());
            run.render(scene, plan, batch, Some(&reference.image))?;
        }
    }
    bar.finish_and_clear();
    let measured: Vec<Measured> = runs.into_iter().map(|run| run.finish(&scene.claims)).collect();

    let rows = report::rows(&measured, &reference);
    report::print(&rows, &reference);
    let pairs = agreement::test_pairs(&measured, layout);
    agreement::print(&pairs);
    let agree = pairs.iter().all(|pair| pair.agrees());

    for run in &measured {
        run.save(scene, options, directory)?;
    }
    let files = ["reference.exr", "compare.png", "compare.json"].map(|name| directory.join(name));
    reference.save(scene, &files[0])?;
    picture::side_by_side(&measured, &reference, &rows).save(&files[1])?;
    report::write_json(&files[2], scene, options, depth, &rows, &pairs, &reference)?;
    println!("wrote {}, {} and one .png and .exr per integrator", files[1].display(), files[2].display());

    match pairs.iter().filter(|pair| !pair.agrees()).map(|pair| format!("{} and {}", pair.names[0], pair.names[1])).collect::<Vec<_>>() {
        disagreeing if !disagreeing.is_empty() => println!("THE INTEGRATORS DISAGREE: {}\n", disagreeing.join("; ")),
        _ if pairs.is_empty() => println!("nothing to test: fewer than two integrators see everything in this scene\n"),
        _ => println!("the integrators agree\n"),
    }
    Ok(agree)
}
