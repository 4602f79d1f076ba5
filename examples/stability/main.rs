//! The stability report: scenes with exact answers, pushed to extremes of scale, place, brightness,
//! roughness and geometry, by every integrator; and scenes full of useless lights, whose variance is
//! held against that of other choices of lights.
//!
//! ```text
//! cargo run --release --example stability -- --help
//! ```
//!
//! Prints the table and writes `index.html` and `stability.json` into a directory. docs/numerics.md
//! explains the rows.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod cases;
#[allow(dead_code, reason = "shared with tests")]
mod measure;
mod report;
#[allow(dead_code, reason = "shared with tests")]
mod scenes;
#[allow(dead_code, reason = "shared with tests")]
mod variance;
mod verdict;

use clap::Parser;
use common::{End, WrongArgument, exit_code};
use indicatif::{ProgressBar, ProgressStyle};
use pathspace::film::replace_file;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

/// Measures how integrators hold under numerical stress, and writes a report.
///
/// cargo run --release --example stability -- --quick --row S01
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Takes a twentieth of the rays: standard errors are larger
    #[arg(long)]
    quick: bool,
    /// Most rays per case and integrator, in millions [default: 10, with --quick 0.5]
    #[arg(long, value_name = "MILLIONS", value_parser = parse_millions)]
    rays: Option<f64>,
    /// Only rows whose id starts with this, as S01
    #[arg(long, value_name = "ID", default_value = "")]
    row: String,
    /// Leaves out the rows about variance, which take an hour and a quiet machine
    #[arg(long)]
    means_only: bool,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Directory of the report
    #[arg(long, value_name = "DIR", default_value = "target/stability")]
    out: PathBuf,
}

fn parse_millions(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(millions) if millions > 0.0 && millions <= 1e6 => Ok(millions),
        _ => Err("a number of millions of rays is above 0 and at most 1e6".to_owned()),
    }
}

fn run(arguments: &Arguments) -> Result<End, Box<dyn Error>> {
    let rays = (arguments.rays.unwrap_or(if arguments.quick { 0.5 } else { 10.0 }) * 1e6) as u64;
    // Fails now rather than after the work.
    std::fs::create_dir_all(&arguments.out)
        .map_err(|e| format!("{}: {e}", arguments.out.display()))?;
    let cases: Vec<_> =
        cases::all().into_iter().filter(|case| case.row.starts_with(&arguments.row)).collect();
    let entries: Vec<_> = variance::all()
        .into_iter()
        .filter(|entry| !arguments.means_only && entry.row.starts_with(&arguments.row))
        .collect();
    if cases.is_empty() && entries.is_empty() {
        return Err(WrongArgument(format!("no row's id starts with {:?}", arguments.row)).into());
    }
    let bar = ProgressBar::new((cases.len() + entries.len()) as u64);
    bar.set_style(ProgressStyle::with_template("{bar:32} {pos}/{len}  {msg}  {eta} left")?);
    let interrupted = common::interrupt_flag();
    let ends = || interrupted.load(Ordering::Relaxed);
    let mut lines = Vec::new();
    for case in cases.iter().take_while(|_| !ends()) {
        bar.set_message(format!("{} {} {:e}", case.row, case.family, case.value));
        lines.extend(verdict::judge(case, rays, arguments.seed));
        bar.inc(1);
    }
    let (images, samples_per_pixel) = if arguments.quick { (8, 16) } else { (32, 64) };
    let effort = variance::Effort { images, samples_per_pixel, price: variance::Price::Time };
    let mut comparisons = Vec::new();
    for entry in entries.iter().take_while(|_| !ends()) {
        bar.set_message(format!("{} {} {:e}", entry.row, entry.family, entry.value));
        comparisons.extend(variance::judge(entry, effort, arguments.seed));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let warnings: Vec<report::CaseWarning<'_>> = cases
        .iter()
        .flat_map(|case| {
            case.world.warnings().iter().map(move |warning| report::CaseWarning { case, warning })
        })
        .collect();
    say!("{}", report::text(&lines, &comparisons, &warnings).trim_end());
    for (name, contents) in [
        ("stability.json", report::json(&lines, &comparisons, &warnings)),
        ("index.html", report::html(&lines, &comparisons, &warnings)),
    ] {
        let path = arguments.out.join(name);
        replace_file(&path, contents.as_bytes()).map_err(|e| format!("{}: {e}", path.display()))?;
        say!("wrote {}", path.display());
    }
    let is_good = comparisons.iter().all(|comparison| comparison.is_good);
    if ends() {
        return Ok(End::Interrupted);
    }
    if is_good && lines.iter().all(|line| line.verdict.is_good()) {
        return Ok(End::Done);
    }
    eprintln!("a case is off by more than 4 standard errors, or has too much variance");
    Ok(End::Wrong)
}

fn main() -> ExitCode {
    exit_code(run(&common::options()))
}
