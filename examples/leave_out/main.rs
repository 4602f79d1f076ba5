//! The savings of leaving out: rays per sample, time per sample and variance × time of every
//! integrator beside the same one unpruned, which leaves nothing out, and the decisions of the
//! adaptive one. Makes the tables of docs/leave-out.md.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod scenes;
mod unpruned;

use clap::Parser;
use common::{AnyIntegrator, End, exit_code, interrupt_flag, parse_duration, parse_size};
use pathspace::endpoint::Camera;
use pathspace::glam::UVec2;
use pathspace::integrator::Estimator;
use pathspace::path::TechniqueSet;
use pathspace::render::{Budget, Settings};
use pathspace::report::{
    Contestant, Interval, MethodReport, Omission, Plan, Reference, ReferencePlan, SceneInfo, study,
};
use pathspace::scene::{Scene, World};
use std::error::Error;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Measures what leaving out saves, scene by scene, and prints tables in Markdown.
///
/// cargo run --release --example leave_out -- --scenes mirror-room,point-light --time 10s
#[derive(Parser, Debug)]
struct Options {
    /// Scenes, separated by commas; those of the gallery and some small ones by default
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// Time for each integrator
    #[arg(long, default_value = "20s", value_parser = parse_duration)]
    time: Duration,
    /// Independent runs that an integrator's time is split into
    #[arg(long, default_value_t = 8, value_parser = common::parse_count::<u32, 2, 1024>)]
    seeds: u32,
    /// Width and height of the images in pixels
    #[arg(long, default_value = "64x64", value_parser = parse_size)]
    size: UVec2,
    /// Seed that those of the runs are derived from
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    exit_code(run(&common::options()))
}

fn run(options: &Options) -> Result<End, Box<dyn Error>> {
    let interrupted = interrupt_flag();
    let names = if options.scenes.is_empty() { scenes::names() } else { options.scenes.clone() };
    for name in names {
        measure(options, &name, &interrupted)?;
        if interrupted.load(Ordering::Relaxed) {
            return Ok(End::Interrupted);
        }
    }
    Ok(End::Done)
}

fn measure(options: &Options, name: &str, interrupted: &AtomicBool) -> Result<(), Box<dyn Error>> {
    let scene = scenes::build(name, options.size)?;
    let (world, camera) = (&scene.world, &*scene.camera.0);
    let is_sparing = !TechniqueSet::BIDIRECTIONAL.left_out(&world.needs()).is_empty();
    let mut methods = Vec::new();
    for integrator in AnyIntegrator::ALL {
        let method = integrator.build_up_to(scene.max_bounces);
        methods.push((integrator, integrator.name().to_owned(), method));
        if is_sparing && let Some(method) = unpruned::build(integrator, scene.max_bounces) {
            methods.push((integrator, format!("{integrator}, unpruned"), method));
        }
    }
    let mut contestants = Vec::new();
    for (integrator, name, method) in &methods {
        let missing = scene.missing(*integrator, &**method)?;
        let is_complete = scene.is_complete(*integrator, &missing);
        contestants.push(Contestant::<World>::new(name, &**method, is_complete));
    }
    let quiet = &mut |_: &pathspace::report::Step<'_>| match interrupted.load(Ordering::Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let settings = Settings { seed: options.seed, threads: Some(1), ..Plan::default().settings };
    // Variances need no reference; this one only gives brightness a scale.
    let both = AnyIntegrator::Bidirectional.build_up_to(scene.max_bounces);
    let half = Contestant::new("reference", &*both, true);
    let reference_plan = ReferencePlan { budget: Budget::Samples(8), runs: 4, settings };
    let reference = Reference::render(world, camera, [&half, &half], &reference_plan, quiet)?;
    let plan = Plan {
        budget: Budget::Time(options.time),
        seeds: options.seeds,
        settings,
        ..Plan::default()
    };
    let study = study(
        world,
        camera,
        &SceneInfo { name: name.to_owned(), ..SceneInfo::default() },
        &contestants,
        reference,
        &plan,
        quiet,
    )?;

    say!("\n### {name}\n");
    say!("Needs: {}.\n", world.needs());
    say!("| integrator | rays per sample | time per sample [µs] | variance × time [µs] |");
    say!("|---|---|---|---|");
    let pixels = f64::from(options.size.x * options.size.y);
    study.report.methods.iter().for_each(|method| row(method, pixels));
    say!();
    for method in study.report.methods.iter().filter(|method| !method.left_out.is_empty()) {
        say!("- {} leaves out {}", method.name, Omission::sentence(&method.left_out));
    }
    let regularized = AnyIntegrator::Regularized.name();
    let idle = |m: &&MethodReport| m.name == regularized && m.estimator == Estimator::Unbiased;
    if let Some(method) = study.report.methods.iter().find(idle) {
        say!("- {} has no Dirac lobes to blur: it is path tracing", method.name);
    }
    for method in &study.report.methods {
        if let Some(guidance) = method.findings.first().and_then(|found| found.guidance) {
            let is_guided = if guidance.is_used { "is guided" } else { "is not guided" };
            say!("- {} {is_guided}: expected gain {:.2}", method.name, guidance.expected_gain);
        }
    }
    let settings = Settings { budget: Budget::Samples(64), ..settings };
    let adaptive = AnyIntegrator::Adaptive.build_up_to(scene.max_bounces);
    // The decision alone: what comes after it does not matter.
    let rendering =
        adaptive.render_with_progress(world, camera, &settings, &mut |_| ControlFlow::Break(()))?;
    if let Some(decision) = &rendering.notes.decision {
        say!("\n```text\n{decision}\n```");
    }
    if std::env::var_os("LEAVE_OUT_COSTS").is_some() {
        costs(&study.report.methods, &contestants, world, camera, &settings)?;
    }
    Ok(())
}

fn row(method: &MethodReport, pixels: f64) {
    let incomplete = if method.complete { "" } else { " *" };
    let (rays, time) = (method.rays_per_sample, 1e6 * method.cpu_per_sample);
    let Interval { value, low, high } = method.variance_times_cpu;
    let [value, low, high] = [value, low, high].map(|x| x * 1e6 / pixels);
    say!(
        "| {}{incomplete} | {rays:.2} | {time:.2} | {value:.3e} ({low:.2e} … {high:.2e}) |",
        method.name
    );
}

/// Counts per sample beside times: what the constants of the cost model were fitted to.
fn costs(
    methods: &[MethodReport],
    contestants: &[Contestant<'_, World>],
    world: &World,
    camera: &dyn Camera,
    settings: &Settings,
) -> Result<(), Box<dyn Error>> {
    let settings = Settings { budget: Budget::Samples(1), ..*settings };
    for method in methods {
        let Some(contestant) =
            contestants.iter().find(|c| c.name == method.name && c.name != "adaptive")
        else {
            continue;
        };
        let counters = contestant.method.render(world, camera, &settings)?.counters;
        let per_sample = |n: u64| n as f64 / counters.samples as f64;
        eprintln!(
            "COST {} {:.3} {:.3} {:.3} {:.3} {:.3}",
            method.name.replace(' ', "_"),
            1e6 * method.cpu_per_sample,
            per_sample(counters.closest_rays),
            per_sample(counters.shadow_rays),
            per_sample(counters.scattered),
            per_sample(counters.connections)
        );
    }
    Ok(())
}
