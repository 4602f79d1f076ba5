//! Audits one path as a teacher would on the board: every factor of its contribution, the densities
//! of all techniques that could have drawn it, their weights and estimates, and a check of what the
//! integrator had cached against the definitions.

#[macro_use]
mod common;

use clap::Parser;
use common::{
    End, FileOptions, WrongArgument, exit_code, interrupt_flag, scene_list, scene_or_file,
};
use pathspace::film::Technique;
use pathspace::geometry::Place;
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::{
    Audit, AuditError, AuditedPath, Bidirectional, Depth, Merging, VertexConnectionMerging,
};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, Obstacle, PathDensities, PathRecord, Weighting};
use pathspace::scene::World;
use std::error::Error;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::str::FromStr;
use std::sync::atomic::Ordering;

/// Errors of a path's cached numbers above this are no rounding errors.
const TOLERANCE: f64 = 1e-6;
/// Light walks that merge with each camera walk, and samples that share them.
const LIGHT_WALKS: u32 = 1 << 14;

/// Draws a path with bidirectional path tracing, or with vertex connection and merging, and writes
/// down all that makes up its contribution.
///
/// cargo run --release --example audit -- --scene pool --technique merge:3,3
#[derive(Parser)]
#[command(after_help = format!("Wrong is a path whose cached numbers are not those of the definitions.\n\nScenes of the gallery:\n{}", scene_list()))]
struct Options {
    /// Name of a scene in the gallery, or a scene file
    #[arg(long, default_value = "cornell-box")]
    scene: String,
    /// Number of scattering events of the path
    #[arg(long, default_value_t = 3, value_parser = common::parse_count::<u32, 0, 60>)]
    bounces: u32,
    /// The technique that must have drawn the path: s vertices from the light, t from the camera,
    /// with s + t = bounces + 2, or bounces + 3 to merge them; any if not given
    #[arg(long, value_name = "S,T|merge:S,T", value_parser = parse_technique, allow_hyphen_values = true)]
    technique: Option<Technique>,
    /// Let subpaths merge, too; --radius and a technique that merges imply it
    #[arg(long)]
    merge: bool,
    /// Radius within which subpaths merge, in units of the scene [default: twice the size of a
    /// pixel on what is seen]
    #[arg(long, value_parser = common::parse_radius)]
    radius: Option<f64>,
    /// Only paths through this pixel, column and row
    #[arg(long, value_name = "X,Y", value_parser = parse_pair::<u32>, allow_hyphen_values = true)]
    pixel: Option<(u32, u32)>,
    /// Seed of the random numbers; another seed gives another path
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn parse_pair<T: FromStr>(text: &str) -> Result<(T, T), String> {
    let numbers = text
        .split_once(',')
        .and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    numbers.ok_or_else(|| format!("{text:?} is not a pair of whole numbers from 0 such as 1,4"))
}

fn parse_technique(text: &str) -> Result<Technique, String> {
    let merge = text.strip_prefix("merge:");
    let (s, t) = parse_pair(merge.unwrap_or(text))?;
    match merge {
        Some(_) if s < 2 || t < 2 => {
            Err("s and t are at least 2: both walks have found the vertex where they meet"
                .to_owned())
        }
        Some(_) => Ok(Technique::merge(s, t)),
        None if t == 0 => Err("t is at least 1: the lens is never hit by chance".to_owned()),
        None => Ok(Technique::new(s, t)),
    }
}

impl Options {
    fn merges(&self) -> bool {
        self.merge || self.radius.is_some() || self.technique.is_some_and(|wanted| wanted.merged)
    }

    /// The search for the first path that fits.
    fn audit(&self) -> Audit {
        let depth = Depth::exactly(self.bounces);
        let merging = Merging {
            radius: self.radius,
            alpha: 1.0,
            light_walks: Some(if self.merges() { LIGHT_WALKS } else { 0 }),
        };
        Audit {
            integrator: VertexConnectionMerging {
                bidirectional: Bidirectional { depth, ..Bidirectional::default() },
                merging,
                ..VertexConnectionMerging::default()
            },
            technique: self.technique,
            pixel: self.pixel.map(UVec2::from),
            candidates: 1,
            seed: self.seed,
            ..Audit::default()
        }
    }
}

fn main() -> ExitCode {
    exit_code(run(&common::options()))
}

/// Renders, audits and prints the path.
fn run(options: &Options) -> Result<End, Box<dyn Error>> {
    if let Some(technique @ Technique { s, t, merged }) = options.technique {
        let shared = if merged { 3 } else { 2 };
        if u32::from(s) + u32::from(t) != options.bounces + shared {
            return Err(WrongArgument(format!(
                "technique {technique} draws paths with s + t - {shared} = {} bounces, not {}",
                i64::from(s) + i64::from(t) - i64::from(shared),
                options.bounces
            ))
            .into());
        }
    }
    let scene = scene_or_file(&options.scene, None, &FileOptions::default())?;
    let interrupted = interrupt_flag();
    let ask = &mut || match interrupted.load(Ordering::Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let camera = &*scene.camera.0;
    let found = match options.audit().find(&scene.world, camera, ask) {
        Ok(Some(found)) => found,
        Ok(None) => return Ok(End::Interrupted),
        Err(error @ AuditError::Pixel { .. }) => {
            return Err(WrongArgument(format!("--pixel: {error}")).into());
        }
        Err(AuditError::NotFound { samples }) => {
            let technique = options
                .technique
                .map_or("any technique".to_owned(), |wanted| format!("technique {wanted}"));
            return Err(format!(
                "no path with {} bounces drawn by {technique} in {samples} samples of {}",
                options.bounces, scene.name
            )
            .into());
        }
        Err(error) => return Err(error.into()),
    };
    let size = camera.film().resolution;
    say!("{}: {}", scene.name, scene.description);
    say!(
        "sample {} of seed {}: a path with {} bounces, drawn by technique (s, t) = {}",
        found.sample,
        options.seed,
        options.bounces,
        found.technique
    );
    say!(
        "it meets the film of {} x {} pixels at ({:.2}, {:.2})\n",
        size.x,
        size.y,
        found.raster.x,
        found.raster.y
    );
    print_vertices(&found, &scene.world);
    print_factors(&found.record);
    print_contribution(&found.record);
    print_techniques(&found);
    Ok(if print_verification(&found) { End::Done } else { End::Wrong })
}

fn print_vertices(found: &AuditedPath, world: &World) {
    let AuditedPath { record, technique, distance, .. } = found;
    say!("VERTICES, from the lens x_0 to the light x_{}", record.edges());
    say!("  {:<4} {:<10} {:<20} position, and normals", "", "kind", "surface");
    for (i, x) in record.points.iter().enumerate() {
        let kind = record.vertex_kind(i);
        let name = if i == 0 { "camera" } else { world.surface_name(x).unwrap_or("-") };
        say!("  x_{i:<2} {kind:<10} {name:<20} {}", vector(x.position));
        if x.place != Place::Dirac {
            let shading = if x.is_flat() { "the same".to_owned() } else { short(x.shading_normal) };
            let geometric = short(x.geometric_normal);
            say!("  {:<4} geometric {geometric}, shading {shading}", "");
        }
    }
    if let Some(distance) = distance {
        let (m, radius) = (technique.t - 1, found.radius());
        say!(
            "  x_{m} is where the camera walk ends; the light walk ends {distance:.5} beside it,\n  \
             less than r = {radius:.5}"
        );
    }
}

fn print_factors(record: &PathRecord) {
    let k = record.edges();
    say!("\nFACTORS");
    say!("  We or f or Le:  importance at the lens, BSDF per steradian (Dirac: its");
    say!("                  coefficient), radiance at the light");
    say!("  G_i = V |cos θ_i cos θ'_i| / r²  of the edge x_i x_(i+1), geometric normals");
    say!("  a_i = p⊥(x_i → x_(i+1))          density of a camera walk's direction, per");
    say!("                                   projected solid angle");
    say!("  b_i = p⊥(x_i → x_(i-1))          the same for a light walk\n");
    say!("  {:<4} {:<6} {COLUMNS} {:>10} {:>10} {:>10}", "", "factor", "G_i", "a_i", "b_i");
    for i in 0..=k {
        let factor = record.factor_symbol(i);
        let when =
            |shown: bool, value: f64| if shown { format!("{value:.4e}") } else { "-".to_owned() };
        let g = if i < k { record.geometry_terms[i] } else { 0.0 };
        say!(
            "  x_{i:<2} {factor:<6} {} {:>10} {:>10} {:>10}",
            rgb(record.factors[i]),
            when(i < k, g),
            when(i < k, record.towards_light[i]),
            when(i > 0, record.towards_camera[i])
        );
    }
    let ends = record.ends;
    say!("\n  densities of the ends, in the measure of their place (area, solid angle, or a");
    say!("  probability)");
    let end = |x: usize, role: &str, density: f64| {
        say!("  x_{x:<2} {role:<40} {density:>12.5e}");
    };
    end(0, "as the start of a camera walk", ends.camera);
    end(0, "as the point that x_1 connects to", ends.camera_connection);
    end(k, "as the start of a light walk", ends.light);
    end(k, &format!("as the point that x_{} connects to", k - 1), ends.light_connection);
}

fn print_contribution(record: &PathRecord) {
    let k = record.edges();
    let product = format!("T = Π_(i=1)^({}) f(x_i) G(x_i, x_(i+1))", k - 1);
    say!("\n{:<44} {COLUMNS}", "CONTRIBUTION f(x), and throughput T");
    say!("  {product:<42} {}", rgb(record.throughput()));
    say!("  {:<42} {}", "f(x) = We · G(x_0, x_1) · T · Le", rgb(record.contribution()));
}

fn print_techniques(found: &AuditedPath) {
    let AuditedPath { record, weighting, technique: drawn_by, .. } = found;
    let (k, set) = (record.edges(), *weighting.set());
    say!("\nTECHNIQUES (s, t): s vertices from the light, t from the camera, s + t = {}", k + 1);
    say!(
        "  p_(s,t) = p(ends) · Π_(i=0)^(t-2) a_i G_i · Π_(i=t+1)^k b_i G_(i-1)\n  \
         w_(s,t) = (n p)^β / Σ (n p)^β over the admissible ones"
    );
    if found.radius() > 0.0 {
        say!(
            "  merge (s, t): s + t = {}, n = {} light walks,\n  \
             p = π r² · p(ends) · Π_(i=0)^(t-2) a_i G_i · Π_(i=t)^k b_i G_(i-1)",
            k + 2,
            set.merges
        );
    }
    say!(
        "\n  {:<12} {:<11} {:>12} {:>10} {:>10}",
        "(s, t)",
        "admissible",
        "density p",
        "w (β = 1)",
        "w (β = 2)"
    );
    let weightings = [Heuristic::Balance, Heuristic::Power(2.0)]
        .map(|heuristic| Weighting::new(set, heuristic).with_merge_radius(found.radius()));
    let mut sums = [0.0; 2];
    for look in found.techniques() {
        let technique = look.technique;
        let mark = if technique == *drawn_by { "←" } else { "" };
        let label = technique.to_string();
        let reason = match look.obstacle {
            None => "yes",
            Some(_) if !look.is_in_set() => "not in set",
            Some(Obstacle::End | Obstacle::Edge(..)) => "no (p = 0)",
            Some(_) => "no (δ)",
        };
        let Some(estimate) = look.estimate.filter(|_| look.obstacle.is_none()) else {
            say!("  {label:<12} {reason:<11}");
            continue;
        };
        let weights = weightings.map(|weighting| record.weight(technique, &weighting));
        sums = [sums[0] + weights[0], sums[1] + weights[1]];
        say!(
            "  {label:<12} {reason:<11} {:>12.5e} {:>10.6} {:>10.6} {mark}",
            look.density,
            weights[0],
            weights[1]
        );
        for (name, value) in [("f/(n p)", estimate), ("w f/(n p), β = 2", estimate * weights[1])] {
            say!("  {:<12} {name:<24} {}", "", rgb(value));
        }
    }
    say!("  {:<12} {:<11} {:>12} {:>10.6} {:>10.6}", "Σ", "", "", sums[0], sums[1]);
}

fn print_verification(found: &AuditedPath) -> bool {
    let AuditedPath { value, survival, weight, verification, .. } = found;
    let ok = verification.worst() < TOLERANCE;
    say!("\nVERIFICATION of what the integrator had cached against the definitions above");
    say!("  its f/p                          {}", rgb(*value));
    say!("  its roulette survival Π (1 - q)  {survival:.5e} (f/p contains the inverse)");
    say!("  its weight                       {weight:.6}");
    say!("  relative error of f/p            {:.1e}", verification.value_error);
    say!("  error of the weight              {:.1e}", verification.weight_error);
    say!("  |Σ w - 1|                        {:.1e}", verification.weight_sum_error);
    say!("{}", if ok { "verified" } else { "NOT VERIFIED" });
    ok
}

/// The heading of what [`rgb`] writes.
const COLUMNS: &str = "red        green      blue       ";

fn rgb(value: Rgb) -> String {
    value.0.map(|c| format!("{c:<11.4e}")).concat()
}

fn vector(v: DVec3) -> String {
    format!("({:10.5}, {:10.5}, {:10.5})", v.x, v.y, v.z)
}

fn short(v: DVec3) -> String {
    format!("({:6.3}, {:6.3}, {:6.3})", v.x, v.y, v.z)
}
