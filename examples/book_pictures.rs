//! Renders the pictures of the book in `docs/book`: the same bytes each time.
//!
//! ```text
//! cargo run --release --example book_pictures
//! ```

#[macro_use]
mod common;

use clap::Parser;
use common::End;
use pathspace::film::{Image, ImageFile};
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::{
    Bidirectional, Depth, InstantRadiosity, LightTracer, Merging, Metropolis, PathTracer,
    PathTracing, PhotonMapping, Regularization, UniformArea,
};
use pathspace::math::Rgb;
use pathspace::path::{Roulette, Survival};
use pathspace::render::{Budget, RenderError, Settings};
use pathspace::report::{Method, signed_error_map};
use pathspace::scene::World;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

type Integrator = Box<dyn Method<World>>;

/// A picture: its name, which begins with that of its chapter's file, the scene of the gallery, the
/// samples per pixel, and the integrator.
type Picture = (&'static str, &'static str, u32, fn() -> Integrator);

const PICTURES: &[Picture] = &[
    ("rendering-equation", "cornell-box", 256, || both(LONG)),
    ("surface-form", "cornell-box", 256, || boxed(path(bounces(0, 1)))),
    ("path-integral-1", "cornell-box", 256, || both(bounces(1, 1))),
    ("path-integral-2", "cornell-box", 256, || both(bounces(2, 2))),
    ("path-integral-3", "cornell-box", 256, || both(bounces(3, 3))),
    ("roulette-zero", "sphere-cap", 1, || with_constant(0.0)),
    ("roulette-constant", "sphere-cap", 1, || with_constant(0.1)),
    ("uniform-area-1", "cornell-box", 64, || uniform(bounces(0, 1))),
    ("uniform-area-3", "cornell-box", 64, || uniform(bounces(0, 3))),
    ("path-tracing", "lamp-room", 64, || boxed(path(LONG))),
    ("path-tracing-reversed", "lamp-room", 64, || light(LONG)),
    ("light-tracing", "caustic", 64, || light(LONG)),
    ("light-tracing-reversed", "caustic", 64, || boxed(path(LONG))),
    ("photons-none", "pool", 64, || boxed(path(LONG))),
    ("photons-merged", "pool", 16, photons),
    ("photons-unbounded", "cornell-box", 16, || virtual_lights(Some(f64::INFINITY), true)),
    ("photons-clamped", "cornell-box", 16, || virtual_lights(None, false)),
    ("bidirectional-hit", "glossy-plates", 16, || path_by(PathTracing::EmissionOnly)),
    ("bidirectional-connect", "glossy-plates", 16, || path_by(PathTracing::NextEventOnly)),
    ("bidirectional-both", "glossy-plates", 16, || path_by(PathTracing::Both)),
    ("leave-out-path", "smooth-mesh", 16, || boxed(path(LONG))),
    ("leave-out-light", "smooth-mesh", 16, || light(LONG)),
    ("beyond-dirac", "pool", 1024, || boxed(path(LONG))),
    ("beyond-regularized", "pool", 1024, regularized),
    ("beyond-metropolis", "lamp-room", 64, || boxed(Metropolis::over(bidirectional(LONG)))),
];

/// Pictures that show the signed relative error against bidirectional path tracing.
const ERRORS: &[Picture] = &[
    ("measuring-path", "cornell-box", 256, || boxed(path(LONG))),
    ("measuring-light", "cornell-box", 256, || light(LONG)),
    ("measuring-dark", "cornell-box", 256, || boxed(path(bounces(0, 3)))),
];
const REFERENCE_SAMPLES: u32 = 1024;

const SEED: u64 = 1;
/// So small that no PNG has more than 80 kB.
const SIZE: UVec2 = UVec2::splat(144);
/// Longer paths add less than a shade of grey.
const LONG: Depth = bounces(0, 16);

const fn bounces(min_bounces: u32, max_bounces: u32) -> Depth {
    Depth { min_bounces, max_bounces: Some(max_bounces) }
}

/// The stops by which pictures of a scene are made brighter.
fn stops(scene: &str) -> f64 {
    match scene {
        "lamp-room" => 1.0,
        "sphere-cap" => 2.0,
        _ => 0.0,
    }
}

fn boxed(integrator: impl Method<World> + 'static) -> Integrator {
    Box::new(integrator)
}

fn path(depth: Depth) -> PathTracer {
    PathTracer { depth, ..PathTracer::default() }
}

fn path_by(mode: PathTracing) -> Integrator {
    boxed(PathTracer { mode, ..path(LONG) })
}

/// Half of all walks end at every bounce.
fn with_constant(c: f64) -> Integrator {
    let survival = Survival::Fixed(0.5);
    boxed(PathTracer {
        roulette: Roulette { start: 0, survival, constant: Rgb::splat(c) },
        ..PathTracer::default()
    })
}

fn bidirectional(depth: Depth) -> Bidirectional {
    Bidirectional { depth, ..Bidirectional::default() }
}

fn both(depth: Depth) -> Integrator {
    boxed(bidirectional(depth))
}

fn light(depth: Depth) -> Integrator {
    boxed(LightTracer { depth, ..LightTracer::default() })
}

fn uniform(depth: Depth) -> Integrator {
    boxed(UniformArea { depth, ..UniformArea::default() })
}

fn photons() -> Integrator {
    let merging = Merging { light_walks: Some(50_000), ..Merging::from_radius(0.03) };
    boxed(PhotonMapping { depth: LONG, merging, ..PhotonMapping::default() })
}

fn virtual_lights(bound: Option<f64>, compensates: bool) -> Integrator {
    boxed(InstantRadiosity { path_tracer: path(LONG), light_walks: 2, bound, compensates })
}

fn regularized() -> Integrator {
    boxed(Regularization { epsilon: 0.2, ..Regularization::new(path(LONG)) })
}

/// Renders the pictures of the book; the same bytes each time.
///
/// cargo run --release --example book_pictures
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Directory to write them to
    #[arg(long, default_value = "docs/book/src/pictures")]
    out: PathBuf,
    /// Render only those whose names begin like this
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Print the table of pictures, and render nothing
    #[arg(long)]
    list: bool,
}

fn main() -> ExitCode {
    common::exit_code(run(&common::options()))
}

fn run(Arguments { out, only, list }: &Arguments) -> Result<End, Box<dyn Error>> {
    let all = || PICTURES.iter().chain(ERRORS);
    if *list {
        say!("{:22} {:14} {:>7} {:>4}  integrator", "picture", "scene", "samples", "seed");
        for (name, scene, samples, integrator) in all() {
            say!("{name:22} {scene:14} {samples:>7} {SEED:>4}  {}", integrator().name());
        }
        return Ok(End::Done);
    }
    let is_chosen = |(name, ..): &&Picture| name.starts_with(only.as_deref().unwrap_or(""));
    if let Some(only) = only.as_ref().filter(|_| !all().any(|picture| is_chosen(&picture))) {
        let reason = format!("--only: no picture's name begins with {only}; --list has them all");
        return Err(common::WrongArgument(reason).into());
    }
    std::fs::create_dir_all(out)
        .map_err(|error| format!("directory {}: {error}", out.display()))?;
    let interrupted = &*common::interrupt_flag();
    let save = |name: &str, image: Image, exposure: f64| {
        let path = out.join(name).with_extension("png");
        ImageFile { exposure, ..ImageFile::from(image) }.save(&path)?;
        say!("{}", path.display());
        Ok::<(), Box<dyn Error>>(())
    };
    for picture @ (name, scene, ..) in PICTURES.iter().filter(is_chosen) {
        let Some(image) = draw(picture, SEED, interrupted)? else { return Ok(End::Interrupted) };
        save(name, image, stops(scene))?;
    }
    let mut reference = None;
    for picture @ (name, scene, ..) in ERRORS.iter().filter(is_chosen) {
        if reference.is_none() {
            let exact: Picture = ("reference", scene, REFERENCE_SAMPLES, || both(LONG));
            reference = draw(&exact, SEED + 1, interrupted)?;
        }
        let image = draw(picture, SEED, interrupted)?;
        let (Some(image), Some(reference)) = (image, &reference) else {
            return Ok(End::Interrupted);
        };
        save(name, signed_error_map(&image, reference), 0.0)?;
    }
    Ok(End::Done)
}

/// The image of a picture; `None` if it was interrupted.
fn draw(
    (name, scene, samples, integrator): &Picture,
    seed: u64,
    interrupted: &AtomicBool,
) -> Result<Option<Image>, Box<dyn Error>> {
    let scene = gallery::build(scene, SIZE)?;
    let settings = Settings { budget: Budget::Samples(*samples), seed, ..Settings::default() };
    let bar = common::progress_bar(name);
    let rendering = integrator().render_with_progress(
        &scene.world,
        &*scene.camera,
        &settings,
        &mut |progress| match interrupted.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => common::show(&bar, progress),
        },
    );
    let rendering = rendering.map_err(|error: RenderError| format!("{name}: {error}"))?;
    bar.finish_and_clear();
    Ok((!rendering.stopped).then_some(rendering.image))
}
