//! The table: what each integrator did, how wrong it is, and what that cost; for people and as JSON.

use super::Options;
use super::agreement::Pair;
use super::common::{AnyIntegrator, NamedScene};
use super::measure::{self, Measured};
use super::reference::Reference;
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

/// The error of an image is limited by its reference if the reference's own variance is more than this part of it.
const REFERENCE_SHARE: f64 = 0.1;

/// One line of the table.
pub struct Row {
    pub integrator: AnyIntegrator,
    pub sees_all: bool,
    pub long_tails: bool,
    pub techniques: String,
    pub samples_per_pixel: u32,
    pub seconds: f64,
    pub mega_rays_per_second: f64,
    pub rays_per_sample: f64,
    pub mean: f64,
    pub mean_error: f64,
    pub bias: f64,
    pub bias_error: f64,
    /// Mean squared error against the reference, whose own variance is subtracted.
    pub mse: f64,
    pub relative_mse: f64,
    /// Relative standard error of `mse`, and about that of all that follows from the variance.
    pub relative_error: f64,
    pub reference_limited: bool,
    /// Variance × time.
    pub cost: f64,
    /// Cost of path tracing over this cost, with its standard error.
    pub speed_up: Option<(f64, f64)>,
    pub non_finite: u64,
}

pub fn rows(measured: &[Measured], reference: &Reference) -> Vec<Row> {
    let path_tracing = measured.iter().find(|run| run.integrator == AnyIntegrator::PathTracing && run.sees_all);
    measured.iter().map(|run| row(run, path_tracing, reference)).collect()
}

fn row(run: &Measured, path_tracing: Option<&Measured>, reference: &Reference) -> Row {
    let floor = measure::floor(&reference.image);
    let squared_error = |scale: &dyn Fn(f64) -> f64| {
        let pairs = run.image.pixels().iter().zip(reference.image.pixels());
        let sum: f64 = pairs.map(|(i, r)| (0..3).map(|c| (i[c] - r[c]).powi(2) / scale(r[c])).sum::<f64>()).sum();
        sum / (3 * run.image.pixels().len().max(1)) as f64 - reference.own_error(scale)
    };
    let mse = squared_error(&|_| 1.0);
    let seconds = run.wall.as_secs_f64();
    let rays = run.counters.rays() as f64;
    let speed_up = path_tracing.filter(|_| run.sees_all).map(|baseline| {
        let ratio = baseline.cost() / run.cost();
        let independent = baseline.integrator != run.integrator;
        (ratio, if independent { ratio * baseline.relative_error.hypot(run.relative_error) } else { 0.0 })
    });
    Row {
        integrator: run.integrator,
        sees_all: run.sees_all,
        long_tails: run.long_tails,
        techniques: run.techniques.to_string(),
        samples_per_pixel: run.samples_per_pixel,
        seconds,
        mega_rays_per_second: rays / seconds * 1e-6,
        rays_per_sample: rays / (run.counters.samples.max(1) as f64),
        mean: run.mean.mean,
        mean_error: run.mean.standard_error(),
        bias: run.mean.mean - reference.mean,
        bias_error: (run.mean.variance + reference.mean_variance).sqrt(),
        mse,
        relative_mse: squared_error(&|r| r * r + floor),
        relative_error: run.relative_error,
        reference_limited: reference.own_error(|_| 1.0) > REFERENCE_SHARE * mse,
        cost: run.cost(),
        speed_up,
        non_finite: run.counters.non_finite,
    }
}

pub fn print(rows: &[Row], reference: &Reference) {
    println!("mean luminance of the reference: {:.6} ± {:.6}\n", reference.mean, reference.mean_variance.sqrt());
    println!(
        "{:<15} {:>8} {:>8} {:>8} {:>6} {:>20} {:>28} {:>17} {:>9} {:>10} {:>15} {:>10}",
        "integrator",
        "samples",
        "seconds",
        "Mrays/s",
        "rays/",
        "mean ± SE",
        "bias ± SE (z)",
        "MSE ± SE",
        "relMSE",
        "variance",
        "speed-up over",
        "non-finite"
    );
    println!(
        "{:<15} {:>8} {:>8} {:>8} {:>6} {:>20} {:>28} {:>17} {:>9} {:>10} {:>15}",
        "", "/pixel", "", "", "sample", "", "", "", "", "× time", "path tracing"
    );
    for row in rows {
        let speed_up = row.speed_up.map_or_else(
            || "-".to_owned(),
            |(ratio, error)| {
                let digits = if ratio < 0.095 { 4 } else { 2 };
                format!("{ratio:.digits$} ± {error:.digits$}")
            },
        );
        let flag = format!("{}{}", if row.sees_all { "" } else { " *" }, if row.long_tails { " ‡" } else { "" });
        println!(
            "{:<15} {:>8} {:>8.2} {:>8.2} {:>6.2} {:>20} {:>28} {:>17} {:>9} {:>10.2e} {:>15} {:>10}",
            format!("{}{flag}", row.integrator.name()),
            row.samples_per_pixel,
            row.seconds,
            row.mega_rays_per_second,
            row.rays_per_sample,
            format!("{:.5} ± {:.5}", row.mean, row.mean_error),
            format!("{:+.5} ± {:.5} ({:+.2})", row.bias, row.bias_error, row.bias / row.bias_error),
            format!("{} ± {:.0} %{}", error_text(row.mse), 100.0 * row.relative_error, if row.reference_limited { " †" } else { "" }),
            error_text(row.relative_mse),
            row.cost,
            speed_up,
            row.non_finite
        );
    }
    println!("MSE: mean over pixels and channels, the reference's own variance subtracted; relMSE: (I - R)² / (R² + 0.01 mean(R)²)");
    if rows.iter().any(|row| !row.sees_all) {
        println!("* cannot draw every path of this scene: not tested");
    }
    if rows.iter().any(|row| row.reference_limited) {
        println!("† reference-limited: the reference's own variance is more than {:.0} % of it", 100.0 * REFERENCE_SHARE);
    }
    if rows.iter().any(|row| row.long_tails) {
        println!("‡ long tails: rare, bright contributions make up much of the variance; its standard errors are lower bounds");
    }
    println!("\ntechniques:");
    rows.iter().for_each(|row| println!("  {:<15} {}", row.integrator.name(), row.techniques));
}

/// An error from which the reference's own was subtracted; nothing may be left.
pub fn error_text(error: f64) -> String {
    if error > 0.0 { format!("{error:.2e}") } else { "< ref.".to_owned() }
}

pub fn write_json(
    path: &Path,
    scene: &NamedScene,
    options: &Options,
    depth: Option<u32>,
    rows: &[Row],
    pairs: &[Pair],
    reference: &Reference,
) -> Result<(), Box<dyn Error>> {
    let document = json!({
        "scene": scene.name,
        "width": reference.image.width(),
        "height": reference.image.height(),
        "max_bounces": depth,
        "seed": options.seed,
        "batches": options.batches,
        "reference": {
            "origin": reference.origin,
            "mean": reference.mean,
            "mean_standard_error": reference.mean_variance.sqrt(),
            "variance": reference.own_error(|_| 1.0),
        },
        "integrators": rows.iter().map(row_json).collect::<Vec<Value>>(),
        "pairs": pairs.iter().map(pair_json).collect::<Vec<Value>>(),
        "agree": pairs.iter().all(Pair::agrees),
    });
    std::fs::write(path, serde_json::to_string_pretty(&document)?).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(())
}

fn row_json(row: &Row) -> Value {
    json!({
        "integrator": row.integrator.name(),
        "sees_everything": row.sees_all,
        "long_tails": row.long_tails,
        "techniques": row.techniques,
        "samples_per_pixel": row.samples_per_pixel,
        "seconds": row.seconds,
        "mega_rays_per_second": row.mega_rays_per_second,
        "rays_per_sample": row.rays_per_sample,
        "mean": row.mean,
        "mean_standard_error": row.mean_error,
        "bias": row.bias,
        "bias_standard_error": row.bias_error,
        "mse": row.mse,
        "relative_mse": row.relative_mse,
        "mse_relative_standard_error": row.relative_error,
        "reference_limited": row.reference_limited,
        "variance_times_seconds": row.cost,
        "speed_up_over_path_tracing": row.speed_up.map(|(ratio, _)| ratio),
        "speed_up_standard_error": row.speed_up.map(|(_, error)| error),
        "non_finite": row.non_finite,
    })
}

fn pair_json(pair: &Pair) -> Value {
    json!({
        "integrators": pair.names,
        "agree": pair.agrees(),
        "t_of_means": pair.mean.t,
        "p_of_means": pair.mean.p_value,
        "worst_block": pair.worst_place,
        "worst_block_means": pair.worst_means,
        "t_of_worst_block": pair.worst.t,
        "p_of_worst_block": pair.worst.p_value,
        "p_limit_of_worst_block": pair.worst_limit,
        "blocks": pair.tested_blocks,
        "pooled_blocks": pair.pooled_blocks,
        "mean_square_of_t": pair.mean_square,
        "mean_square_of_t_standard_error": pair.mean_square_error,
    })
}
