//! What leaving out saves: rays per sample, time per sample and variance × time of every integrator, with everything and with what the scene
//! needs alone, and what the adaptive one decides. Makes the tables of docs/leave-out.md.

#[path = "../common/mod.rs"]
mod common;

mod scenes;

use clap::Parser;
use common::{AnyIntegrator, parse_duration, parse_size};
use pathspace::endpoint::Camera;
use pathspace::glam::UVec2;
use pathspace::integrator::{Adaptive, Bidirectional, Integrator, LightTracer, PathTracer, UniformArea};
use pathspace::path::{LeftOut, TechniqueSet};
use pathspace::render::{Budget, Progress, Render, RenderError, Rendering, Settings, unattended};
use pathspace::report::inference::Interval;
use pathspace::report::{Contestant, Method, MethodReport, Plan, Reference, ReferencePlan, SceneInfo, study};
use pathspace::scene::{Scene, WithNeeds, World};
use std::error::Error;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Duration;

/// Measures what leaving out saves, scene by scene, and prints tables in Markdown.
#[derive(Parser, Debug)]
struct Options {
    /// Scenes, separated by commas; those of the gallery and some small ones by default
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// Time for each integrator
    #[arg(long, default_value = "20s", value_parser = parse_duration)]
    time: Duration,
    /// Independent runs that an integrator's time is split into
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(2..=1024))]
    seeds: u32,
    /// Width and height of the images in pixels
    #[arg(long, default_value = "64x64", value_parser = parse_size)]
    size: UVec2,
    /// Seed that those of the runs are derived from
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// An integrator on a scene that claims to need everything.
struct Everything<I>(I);

impl<I> Render<World> for Everything<I>
where
    I: for<'a> Integrator<WithNeeds<'a, World>>,
{
    fn techniques(&self, scene: &World) -> TechniqueSet {
        self.0.techniques(&WithNeeds::all(scene).needs())
    }

    fn left_out(&self, scene: &World) -> LeftOut {
        self.0.left_out(&WithNeeds::all(scene).needs())
    }

    fn render(
        &self,
        scene: &World,
        camera: &dyn Camera,
        settings: &Settings,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Rendering, RenderError> {
        pathspace::render::render(&WithNeeds::all(scene), camera, &self.0, settings, progress)
    }
}

impl<I> Method<World> for Everything<I> where I: for<'a> Integrator<WithNeeds<'a, World>> {}

/// The integrator that leaves nothing out.
fn everything(integrator: AnyIntegrator, max_bounces: Option<u32>) -> Box<dyn Method<World>> {
    let depth = pathspace::integrator::Depth { min_bounces: 0, max_bounces };
    match integrator {
        AnyIntegrator::PathTracing => Box::new(Everything(PathTracer { depth, ..PathTracer::default() })),
        AnyIntegrator::LightTracing => Box::new(Everything(LightTracer { depth, ..LightTracer::default() })),
        AnyIntegrator::UniformArea => Box::new(Everything(UniformArea { depth, ..UniformArea::default() })),
        AnyIntegrator::Bidirectional => Box::new(Everything(Bidirectional { depth, ..Bidirectional::default() })),
        AnyIntegrator::Adaptive => Box::new(Everything(Adaptive { depth, ..Adaptive::default() })),
    }
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let names = if options.scenes.is_empty() { scenes::names() } else { options.scenes.clone() };
    for name in names {
        measure(options, &name)?;
    }
    Ok(())
}

fn measure(options: &Options, name: &str) -> Result<(), Box<dyn Error>> {
    let scene = scenes::build(name, options.size)?;
    let (world, camera) = (&scene.world, &*scene.camera.0);
    let mut methods: Vec<(String, Box<dyn Method<World>>, bool)> = Vec::new();
    for integrator in AnyIntegrator::ALL {
        let (pruned, complete) = (integrator.build(0, scene.max_bounces), integrator.sees_all(&scene.claims));
        if !pruned.left_out(world).is_empty() && integrator != AnyIntegrator::Adaptive {
            methods.push((format!("{integrator}, everything"), everything(integrator, scene.max_bounces), complete));
        }
        methods.push((integrator.name().to_owned(), pruned, complete));
    }
    let contestants: Vec<Contestant<'_, World>> =
        methods.iter().map(|(name, method, complete)| Contestant { name: name.clone(), method: &**method, complete: *complete }).collect();
    let quiet = &mut |_: &pathspace::report::Step<'_>| ControlFlow::Continue(());
    let settings = Settings { seed: options.seed, threads: Some(1), ..Settings::default() };
    // Variances need no reference; this one only gives brightness a scale.
    let both = AnyIntegrator::Bidirectional.build(0, scene.max_bounces);
    let half = Contestant { name: "reference".to_owned(), method: &*both, complete: true };
    let reference_plan = ReferencePlan { budget: Budget::Samples(8), runs: 4, settings };
    let reference = Reference::render(world, camera, [&half, &half], &reference_plan, quiet)?;
    let plan = Plan {
        budget: Budget::Time(options.time),
        seeds: options.seeds,
        settings,
        baseline: Some(AnyIntegrator::Adaptive.name().to_owned()),
        ..Plan::default()
    };
    let study = study(world, camera, &SceneInfo { name: name.to_owned(), ..SceneInfo::default() }, &contestants, reference, &plan, quiet)?;

    println!("\n### {name}\n");
    println!("Needs: {}.\n", world.needs());
    println!("| integrator | rays per sample | time per sample [µs] | variance × time [µs] | efficiency / adaptive |");
    println!("|---|---|---|---|---|");
    for method in &study.report.methods {
        row(method, options.size);
    }
    println!();
    for (name, method, _) in &methods {
        let left_out = method.left_out(world);
        if !left_out.is_empty() {
            println!("- {name} leaves out {left_out}");
        }
    }
    let settings = Settings { budget: Budget::Samples(64), ..settings };
    let adaptive = AnyIntegrator::Adaptive.build(0, scene.max_bounces);
    // The decision alone: what comes after it does not matter.
    let rendering = adaptive.render(world, camera, &settings, &mut |_| ControlFlow::Break(()))?;
    if let Some(decision) = &rendering.decision {
        println!("\n```text\n{decision}\n```");
    }
    if std::env::var_os("LEAVE_OUT_COSTS").is_some() {
        costs(&study.report.methods, &contestants, world, camera, &settings, options)?;
    }
    Ok(())
}

/// Mean and interval.
fn text(interval: &Interval, scale: f64) -> String {
    let [value, low, high] = [interval.value, interval.low, interval.high].map(|x| x * scale);
    format!("{value:.3e} ({low:.2e} … {high:.2e})")
}

fn row(method: &MethodReport, size: UVec2) {
    let pixels = f64::from(size.x * size.y);
    let samples = f64::from(method.runs) * f64::from(method.samples_per_pixel) * pixels;
    let speed =
        method.speed_up.as_ref().map_or_else(|| "–".to_owned(), |s| format!("{:.2} ({:.2} … {:.2})", s.cpu.value, s.cpu.low, s.cpu.high));
    let incomplete = if method.complete { "" } else { " *" };
    println!(
        "| {}{incomplete} | {:.2} | {:.2} | {} | {speed} |",
        method.name,
        method.rays_per_sample,
        1e6 * method.total.cpu / samples,
        text(&method.variance_times_cpu, 1e6 / pixels)
    );
}

/// Counts per sample beside times: what the constants of the cost model were fitted to.
fn costs(
    methods: &[MethodReport],
    contestants: &[Contestant<'_, World>],
    world: &World,
    camera: &dyn Camera,
    settings: &Settings,
    options: &Options,
) -> Result<(), Box<dyn Error>> {
    let settings = Settings { budget: Budget::Samples(1), ..*settings };
    for method in methods {
        let Some(contestant) = contestants.iter().find(|c| c.name == method.name && c.name != "adaptive") else { continue };
        let counters = contestant.method.render(world, camera, &settings, &mut unattended)?.counters;
        let per_sample = |n: u64| n as f64 / counters.samples as f64;
        let samples = f64::from(method.runs * method.samples_per_pixel * options.size.x * options.size.y);
        eprintln!(
            "COST {} {:.3} {:.3} {:.3} {:.3} {:.3}",
            method.name.replace(' ', "_"),
            1e6 * method.total.cpu / samples,
            per_sample(counters.closest_rays),
            per_sample(counters.shadow_rays),
            per_sample(counters.scattered),
            per_sample(counters.connections)
        );
    }
    Ok(())
}
