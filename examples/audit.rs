//! Audits one path as a teacher would on the board: every factor of its contribution, the densities
//! of all techniques that could have drawn it, their weights and estimates, and a check of what the
//! integrator had cached against the definitions.

mod common;

use clap::Parser;
use common::{FileOptions, NamedScene, scene_list, scene_or_file};
use pathspace::film::{FilmSample, Sample, Technique};
use pathspace::geometry::Place;
use pathspace::glam::{DVec2, DVec3, UVec2};
use pathspace::integrator::{Bidirectional, Depth, Stage};
use pathspace::math::Rgb;
use pathspace::path::{
    Heuristic, PathDensities, PathRecord, Scratch, TechniqueSet, Verification, Weighting,
};
use pathspace::sampler::{Independent, SampleSource, Sampler};
use pathspace::scene::{Scene, World};
use std::process::ExitCode;

/// Errors of a path's cached numbers above this are no rounding errors.
const TOLERANCE: f64 = 1e-6;
const MOST_SAMPLES: u32 = 10_000_000;

/// Draws a path with bidirectional path tracing and writes down all that makes up its contribution.
#[derive(Parser)]
#[command(after_help = format!("Scenes of the gallery:\n{}", scene_list()))]
struct Options {
    /// Name of a scene in the gallery, or a scene file
    #[arg(long, default_value = "cornell-box")]
    scene: String,
    /// Number of scattering events of the path
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=60))]
    bounces: u32,
    /// The technique that must have drawn the path: s vertices from the light, t from the camera,
    /// with s + t = bounces + 2; any if not given
    #[arg(long, value_name = "S,T", value_parser = parse_technique)]
    technique: Option<Technique>,
    /// Only paths through this pixel, column and row
    #[arg(long, value_name = "X,Y", value_parser = parse_pair)]
    pixel: Option<(u16, u16)>,
    /// Seed of the random numbers; another seed gives another path
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn parse_pair(text: &str) -> Result<(u16, u16), String> {
    let numbers = text
        .split_once(',')
        .and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    numbers.ok_or_else(|| format!("{text:?} is not a pair of numbers such as 1,4"))
}

fn parse_technique(text: &str) -> Result<Technique, String> {
    let (s, t) = parse_pair(text)?;
    if t == 0 {
        Err("t is at least 1: the lens is never hit by chance".to_owned())
    } else {
        Ok(Technique::new(s, t))
    }
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Renders, audits and prints the paths; true if the audit passes.
fn run(options: &Options) -> Result<bool, Box<dyn std::error::Error>> {
    if let Some(Technique { s, t, .. }) = options.technique
        && u32::from(s) + u32::from(t) != options.bounces + 2
    {
        return Err(format!(
            "technique {s},{t} draws paths with s + t - 2 = {} bounces, not {}",
            i32::from(s + t) - 2,
            options.bounces
        )
        .into());
    }
    let scene = scene_or_file(&options.scene, UVec2::splat(256), &FileOptions::default())?;
    let size = scene.camera.0.film().resolution;
    if let Some((x, y)) = options.pixel
        && (u32::from(x) >= size.x || u32::from(y) >= size.y)
    {
        return Err(
            format!("pixel {x},{y} is not on the film of {} x {} pixels", size.x, size.y).into()
        );
    }
    let Some(found) = find(&scene, options) else {
        let technique =
            options.technique.map_or("any technique".to_owned(), |Technique { s, t, .. }| {
                format!("technique ({s}, {t})")
            });
        return Err(format!(
            "no path with {} bounces drawn by {technique} in {MOST_SAMPLES} samples of {}",
            options.bounces, scene.name
        )
        .into());
    };
    println!("{}: {}", scene.name, scene.description);
    let Technique { s, t, .. } = found.technique;
    println!(
        "sample {} of seed {}: a path with {} bounces, drawn by technique (s, t) = ({s}, {t})",
        found.sample, options.seed, options.bounces
    );
    println!(
        "it meets the film of {} x {} pixels at ({:.2}, {:.2})\n",
        size.x, size.y, found.raster.x, found.raster.y
    );
    print_vertices(&found.record, &scene.world);
    print_factors(&found.record);
    print_contribution(&found.record);
    print_techniques(&found.record, &found.set, found.technique);
    Ok(print_verification(&found))
}

struct Found {
    sample: u32,
    technique: Technique,
    raster: DVec2,
    record: PathRecord,
    set: TechniqueSet,
    /// The integrator's own numbers: f/p with roulette, product of survival probabilities, weight.
    value: Rgb,
    survival: f64,
    weight: f64,
    verification: Verification,
}

/// The first path that fits, in the order of samples.
fn find(scene: &NamedScene, options: &Options) -> Option<Found> {
    let camera = &*scene.camera.0;
    let integrator =
        Bidirectional { depth: Depth::exactly(options.bounces), ..Bidirectional::default() };
    let set = integrator.techniques.pruned(&scene.world.needs());
    let mut scratch = Scratch::default();
    let source = Independent { seed: options.seed };
    let size = camera.film().resolution.as_dvec2();
    for sample in 0..MOST_SAMPLES {
        let mut sampler = source.sampler(sample, 0);
        let u = sampler.next_2d();
        // Camera walks start in the wanted pixel; light walks must happen to meet it.
        let raster =
            options.pixel.map_or(u * size, |(x, y)| DVec2::new(f64::from(x), f64::from(y)) + u);
        let film = FilmSample { raster, offset: DVec2::ZERO };
        let mut found = None;
        integrator.for_each_path(
            Stage::new(&scene.world, camera),
            Sample { film, sampler: &mut sampler },
            &mut scratch,
            |path, contribution| {
                let technique = contribution.technique;
                let here = options.pixel.is_none_or(|(x, y)| {
                    contribution.raster.floor() == DVec2::new(f64::from(x), f64::from(y))
                });
                if found.is_none()
                    && here
                    && options.technique.is_none_or(|wanted| wanted == technique)
                {
                    found = Some(Found {
                        sample,
                        technique,
                        raster: contribution.raster,
                        record: path.record(),
                        set,
                        value: path.value(),
                        survival: path.survival(),
                        weight: contribution.weight,
                        verification: path.verify(&Weighting::new(set, integrator.heuristic)),
                    });
                }
            },
        );
        if found.is_some() {
            return found;
        }
    }
    None
}

fn print_vertices(record: &PathRecord, world: &World) {
    println!("VERTICES, from the lens x_0 to the light x_{}", record.edges());
    println!(
        "  {:<4} {:<10} {:<20} {:<36} {:<24} shading normal",
        "", "kind", "surface", "position", "geometric normal"
    );
    let k = record.edges();
    for (i, x) in record.points.iter().enumerate() {
        let kind = match (i, x.place) {
            (0, Place::Area) => "lens",
            (0, Place::Dirac) => "pinhole",
            (0, Place::Infinite) => "lens at ∞",
            (i, Place::Area) if i == k => "light",
            (i, Place::Dirac) if i == k => "point light",
            (i, Place::Infinite) if i == k => "light at ∞",
            _ if record.dirac[i] => "specular",
            _ => "surface",
        };
        let name = if i == 0 { "camera" } else { world.surface_name(x).unwrap_or("-") };
        let normals = match x.place {
            Place::Dirac => format!("{:<24} -", "-"),
            _ => format!(
                "{:<24} {}",
                short(x.geometric_normal),
                if x.is_flat() { "the same".to_owned() } else { short(x.shading_normal) }
            ),
        };
        println!("  x_{i:<2} {kind:<10} {name:<20} {:<36} {normals}", vector(x.position));
    }
}

fn print_factors(record: &PathRecord) {
    let k = record.edges();
    println!("\nFACTORS");
    println!(
        "  We or f or Le: importance at the lens, BSDF per steradian (Dirac: its coefficient), radiance at the light"
    );
    println!("  G_i = V |cos θ_i cos θ'_i| / r²   of the edge x_i x_(i+1), with geometric normals");
    println!(
        "  a_i = p⊥(x_i → x_(i+1))           density of a camera walk's direction, per projected solid angle"
    );
    println!(
        "  b_i = p⊥(x_i → x_(i-1))           density of a light walk's direction, per projected solid angle\n"
    );
    println!(
        "  {:<4} {:<6} {:<37} {:>12} {:>12} {:>12}",
        "", "factor", "red          green        blue", "G_i", "a_i", "b_i"
    );
    for i in 0..=k {
        let factor = match i {
            0 => "We",
            _ if i == k => "Le",
            _ if record.dirac[i] => "f (δ)",
            _ => "f",
        };
        let when =
            |shown: bool, value: f64| if shown { format!("{value:.5e}") } else { "-".to_owned() };
        let g = if i < k { record.geometry_terms[i] } else { 0.0 };
        println!(
            "  x_{i:<2} {factor:<6} {:<37} {:>12} {:>12} {:>12}",
            rgb(record.factors[i]),
            when(i < k, g),
            when(i < k, record.towards_light[i]),
            when(i > 0, record.towards_camera[i])
        );
    }
    let ends = record.ends;
    println!(
        "\n  densities of the ends, in the measure of their place (area, solid angle, or a probability)"
    );
    println!(
        "    x_0 as the start of a camera walk {:>12.5e}    as the point that x_1 connects to {:>18.5e}",
        ends.camera, ends.camera_connection
    );
    let label = format!("as the point that x_{} connects to", k - 1);
    println!(
        "    x_{k:<1} as the start of a light walk  {:>12.5e}    {label:<33} {:>18.5e}",
        ends.light, ends.light_connection
    );
}

fn print_contribution(record: &PathRecord) {
    let k = record.edges();
    println!(
        "\nCONTRIBUTION                                            red          green        blue"
    );
    println!(
        "  throughput    T = Π_(i=1)^({}) f(x_i) G(x_i, x_(i+1))   {}",
        k - 1,
        rgb(record.throughput())
    );
    println!(
        "  contribution  f(x) = We · G(x_0, x_1) · T · Le          {}",
        rgb(record.contribution())
    );
}

fn print_techniques(record: &PathRecord, set: &TechniqueSet, drawn_by: Technique) {
    let k = record.edges();
    println!(
        "\nTECHNIQUES (s, t): s vertices from the light, t from the camera, s + t = {}",
        k + 1
    );
    println!(
        "  p_(s,t) = p(ends) · Π_(i=0)^(t-2) a_i G_i · Π_(i=t+1)^k b_i G_(i-1),   w_(s,t) = p^β / Σ p^β over the admissible ones\n"
    );
    println!(
        "  {:<8} {:<11} {:>12} {:>10} {:>10}   {:<37} {:<37}",
        "(s, t)",
        "admissible",
        "density p",
        "w (β = 1)",
        "w (β = 2)",
        "f/p: red     green        blue",
        "w f/p (β = 2)"
    );
    let [balance, power] = [Heuristic::Balance, Heuristic::Power(2.0)]
        .map(|heuristic| Weighting::new(*set, heuristic));
    let mut sums = [0.0; 2];
    for t in (1..=k + 1).rev() {
        let technique = record.technique(t);
        let mark = if technique == drawn_by { "←" } else { "" };
        let label = format!("({}, {t})", technique.s);
        let density = record.density(t);
        let reason = match () {
            () if !set.contains(technique) => "not in set",
            () if !record.is_admissible(technique) => "no (δ)",
            () if density == 0.0 => "no (p = 0)",
            () => "yes",
        };
        if reason != "yes" {
            println!("  {label:<8} {reason:<11}");
            continue;
        }
        let weights = [balance, power].map(|weighting| record.weight(technique, &weighting));
        sums = [sums[0] + weights[0], sums[1] + weights[1]];
        let estimate = record.estimate(t);
        println!(
            "  {label:<8} {reason:<11} {density:>12.5e} {:>10.6} {:>10.6}   {:<37} {:<37} {mark}",
            weights[0],
            weights[1],
            rgb(estimate),
            rgb(estimate * weights[1])
        );
    }
    println!("  {:<8} {:<11} {:>12} {:>10.6} {:>10.6}", "Σ", "", "", sums[0], sums[1]);
}

fn print_verification(found: &Found) -> bool {
    let Found { value, survival, weight, verification, .. } = found;
    let ok = verification.worst() < TOLERANCE;
    println!("\nVERIFICATION of what the integrator had cached against the definitions above");
    println!("  its f/p                          {}", rgb(*value));
    println!("  its roulette survival Π (1 - q)  {survival:.5e}   (f/p contains the inverse)");
    println!("  its weight                       {weight:.6}");
    println!("  relative error of f/p            {:.1e}", verification.value_error);
    println!("  error of the weight              {:.1e}", verification.weight_error);
    println!("  |Σ w - 1|                        {:.1e}", verification.weight_sum_error);
    println!("{}", if ok { "verified" } else { "NOT VERIFIED" });
    ok
}

fn rgb(value: Rgb) -> String {
    value.0.map(|c| format!("{c:<12.5e}")).join(" ")
}

fn vector(v: DVec3) -> String {
    format!("({:10.5}, {:10.5}, {:10.5})", v.x, v.y, v.z)
}

fn short(v: DVec3) -> String {
    format!("({:6.3}, {:6.3}, {:6.3})", v.x, v.y, v.z)
}
