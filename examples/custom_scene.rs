//! A renderer of one's own plugged in: a toy host with its own geometry, its own material and its
//! own light, rendered by three of this crate's integrators. With `--scene world` the material is
//! on a mesh of a ready-made [`World`], for those who bring nothing but a BSDF.
//!
//! A host implements [`Scene`] (and [`SurfaceArea`], if it wants uniform-area sampling), [`Bsdf`]
//! for its materials and, if the ready-made lights do not suffice, [`Endpoint`] and [`Light`].
//! Integrators know nothing else about it.
//!
//! Path tracing, light tracing and bidirectional path tracing sample the same integral in different
//! ways. If their images agree, then the host's sampling, densities and values are consistent with
//! each other: comparing them is the best test of a new material or light.

mod common;

use clap::{Parser, ValueEnum};
use pathspace::bsdf::{Bsdf, BsdfSample, Lobes, TransportMode};
use pathspace::endpoint::{
    AreaLight, DirectionSample, Endpoint, Light, LightId, PinholeCamera, PointSample,
};
use pathspace::film::{Image, ImageFile};
use pathspace::geometry::{Disk, Frame, Place, Quad, Shape, Sphere, SurfacePoint};
use pathspace::glam::{DAffine3, DVec2, DVec3, UVec2};
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer};
use pathspace::math::statistics::Estimate;
use pathspace::math::warp::square_to_cosine_hemisphere;
use pathspace::math::{PerArea, PerProjected, Rgb};
use pathspace::render::{Budget, Render, Settings, unattended};
use pathspace::scene::{
    Emission, Material, Mesh, Needs, Scene, SceneError, SurfaceArea, World, WorldBuilder,
};
use std::error::Error;
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::path::PathBuf;
use std::process::ExitCode;

// -------------------------------------------------------------------------------------------------
// the host's material

/// A two-sided diffuse surface with a retro-reflective lobe, as on traffic signs: `f = ρ_d/π + ρ_r
/// (n+2)/(2π) max(0, ω_light · ω_camera)ⁿ`.
///
/// Directions are in the frame of the surface, z = normal, and point away from it. Densities are
/// per projected solid angle: a density per solid angle, divided by the cosine.
struct RetroReflector {
    diffuse: Rgb,
    retro: Rgb,
    exponent: f64,
}

impl RetroReflector {
    /// Probability of sampling the retro-reflective lobe.
    fn retro_probability(&self) -> f64 {
        let (diffuse, retro) = (self.diffuse.mean(), self.retro.mean());
        if retro > 0.0 { retro / (diffuse + retro) } else { 0.0 }
    }
}

impl Bsdf for RetroReflector {
    fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE_REFLECTION | Lobes::GLOSSY_REFLECTION
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        if to_light.z * to_camera.z <= 0.0 {
            return Rgb::BLACK; // nothing is transmitted
        }
        let lobe =
            to_light.dot(to_camera).max(0.0).powf(self.exponent) * (self.exponent + 2.0) / TAU;
        self.diffuse * FRAC_1_PI + self.retro * lobe
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _mode: TransportMode) -> PerProjected {
        if fixed.z * next.z <= 0.0 {
            return PerProjected(0.0);
        }
        // The density of the mixture, whichever lobe was sampled.
        let p = self.retro_probability();
        let lobe = fixed.dot(next).max(0.0).powf(self.exponent) * (self.exponent + 1.0) / TAU;
        PerProjected((1.0 - p) * FRAC_1_PI + p * lobe / next.z.abs())
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let next = if u1 < self.retro_probability() {
            Frame::from_normal(fixed).to_world(power_cosine(self.exponent, u2))
        } else {
            square_to_cosine_hemisphere(u2) * fixed.z.signum()
        };
        let pdf = self.pdf(fixed, next, mode);
        // Below the horizon the lobe is cut off: that light is absorbed.
        (pdf.value() > 0.0).then(|| {
            let (to_light, to_camera) = mode.label(fixed, next);
            let weight = self.eval(to_light, to_camera) / pdf.value();
            BsdfSample {
                next,
                weight,
                pdf,
                pdf_reverse: self.pdf(next, fixed, mode.reversed()),
                dirac: false,
                relative_ior: 1.0,
            }
        })
    }
}

/// A direction around z with the density `(n+1)/(2π) cosⁿ` per solid angle.
fn power_cosine(exponent: f64, u: DVec2) -> DVec3 {
    let cos = (1.0 - u.x).powf(1.0 / (exponent + 1.0));
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    DVec3::new(sin * (TAU * u.y).cos(), sin * (TAU * u.y).sin(), cos)
}

// -------------------------------------------------------------------------------------------------
// the host's light

/// A head lamp: a point that emits the intensity `I cosⁿ` around an axis. It is a Dirac position,
/// so its densities are a probability for the point and per solid angle for the direction; see the
/// table in `pathspace::endpoint`.
struct HeadLamp {
    position: DVec3,
    axis: DVec3,
    intensity: Rgb,
    exponent: f64,
}

impl Endpoint for HeadLamp {
    fn sample_point(&self, _u1: f64, _u2: DVec2) -> Option<PointSample> {
        let point = SurfacePoint::dirac(self.position);
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let direction = Frame::from_normal(self.axis).to_world(power_cosine(self.exponent, u));
        let pdf = self.direction_pdf(point, direction);
        (pdf.value() > 0.0).then(|| DirectionSample {
            from: *point,
            direction,
            pdf,
            weight: self.emit(point, direction) / pdf.value(),
        })
    }

    fn direction_pdf(&self, _point: &SurfacePoint, direction: DVec3) -> PerProjected {
        PerProjected(
            self.axis.dot(direction).max(0.0).powf(self.exponent) * (self.exponent + 1.0) / TAU,
        )
    }

    fn emit(&self, _point: &SurfacePoint, direction: DVec3) -> Rgb {
        self.intensity * self.axis.dot(direction).max(0.0).powf(self.exponent)
    }
}

impl Light for HeadLamp {
    fn power(&self) -> Rgb {
        self.intensity * (TAU / (self.exponent + 1.0))
    }

    fn can_be_hit(&self) -> bool {
        false // no ray meets a point by chance
    }
}

// -------------------------------------------------------------------------------------------------
// the host's geometry

/// A square of ground, y = 0, and balls. The last ball is a lamp; the head lamp is the second
/// light.
struct ToyScene {
    ground: RetroReflector,
    balls: Vec<(Sphere, RetroReflector)>,
    lights: [Box<dyn Light>; 2],
}

/// The ground is primitive 0, ball i is primitive i + 1.
const GROUND: u32 = 0;
const GROUND_HALF_WIDTH: f64 = 5.0;

impl ToyScene {
    fn new() -> Result<Self, Box<dyn Error>> {
        let material = |diffuse, retro, exponent| RetroReflector {
            diffuse: Rgb(diffuse),
            retro: Rgb(retro),
            exponent,
        };
        let ball = |x, y, z, radius| Sphere::new(DVec3::new(x, y, z), radius);
        let lamp = ball(1.2, 3.5, -0.8, 0.4);
        let balls = vec![
            (ball(-2.1, 1.0, 0.0, 1.0), material([0.6, 0.2, 0.15], [0.0; 3], 0.0)),
            (ball(0.0, 1.0, -0.7, 1.0), material([0.1, 0.25, 0.1], [0.3, 0.5, 0.3], 8.0)),
            (ball(2.1, 1.0, 0.0, 1.0), material([0.05, 0.05, 0.2], [0.6, 0.6, 0.7], 60.0)),
            (lamp, material([0.0; 3], [0.0; 3], 0.0)),
        ];
        // One of the crate's lights, on the host's surface: it must know the number by which the
        // host calls that primitive.
        let primitive = balls.len() as u32;
        let glow = AreaLight::new(
            vec![Shape::Sphere(lamp)],
            primitive,
            primitive,
            Rgb::new(30.0, 25.0, 20.0),
            false,
        )?;
        let position = DVec3::new(-0.5, 3.2, 8.0);
        let axis = (DVec3::new(0.5, 0.6, 0.0) - position).normalize();
        let head_lamp =
            HeadLamp { position, axis, intensity: Rgb::new(16.0, 20.0, 26.0), exponent: 40.0 };
        let ground = material([0.5, 0.5, 0.5], [0.1, 0.1, 0.1], 20.0);
        Ok(Self { ground, balls, lights: [Box::new(glow), Box::new(head_lamp)] })
    }

    fn primitives(&self) -> std::ops::RangeInclusive<u32> {
        GROUND..=self.balls.len() as u32
    }

    /// Distance at which a ray meets a primitive. That a ray which starts on a primitive is at
    /// distance 0 from it is known, not computed: so there is no self-intersection, and no epsilon
    /// against it.
    fn distance(&self, primitive: u32, from: &SurfacePoint, direction: DVec3) -> Option<f64> {
        let touches = from.place == Place::Area && from.primitive == primitive;
        if primitive == GROUND {
            let t = -from.position.y / direction.y;
            let hit = from.position + direction * t;
            let inside = hit.x.abs() <= GROUND_HALF_WIDTH && hit.z.abs() <= GROUND_HALF_WIDTH;
            return (!touches && t > 0.0 && inside).then_some(t);
        }
        let sphere = &self.balls[primitive as usize - 1].0;
        let offset = from.position - sphere.center;
        let middle = -offset.dot(direction);
        if touches {
            return (middle > 0.0).then_some(2.0 * middle);
        }
        let half_chord =
            (sphere.radius.powi(2) - (offset + direction * middle).length_squared()).sqrt();
        // A ray that misses has a half chord that is not a number, which no comparison accepts.
        [middle - half_chord, middle + half_chord].into_iter().find(|t| *t > 0.0)
    }

    /// The point of a primitive next to `position`, which is on it up to rounding.
    fn point(&self, primitive: u32, position: DVec3) -> SurfacePoint {
        let point = if primitive == GROUND {
            SurfacePoint::on_surface(position.with_y(0.0), 1e-15 * position.length(), DVec3::Y)
        } else {
            let sphere = &self.balls[primitive as usize - 1].0;
            sphere.point_at((position - sphere.center).normalize())
        };
        SurfacePoint { primitive, surface: primitive, ..point }
    }
}

impl Scene for ToyScene {
    /// A host with several models would use an enum or `&'a dyn Bsdf`.
    type Bsdf<'a> = &'a RetroReflector;
    type Light = dyn Light;

    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        let hits = self.primitives().filter_map(|p| Some((self.distance(p, from, direction)?, p)));
        let (t, primitive) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(self.point(primitive, from.position + direction * t))
    }

    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        let segment = b.position - a.position;
        let (length, direction) = (segment.length(), segment.normalize_or_zero());
        !self.primitives().any(|p| match (p == a.primitive, p == b.primitive) {
            (true, true) => false, // balls are convex, the ground is flat
            (_, false) => self.distance(p, a, direction).is_some_and(|t| t < length),
            (false, true) => self.distance(p, b, -direction).is_some_and(|t| t < length),
        })
    }

    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_> {
        if x.primitive == GROUND { &self.ground } else { &self.balls[x.primitive as usize - 1].1 }
    }

    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        (x.primitive as usize == self.balls.len()).then_some(LightId(0))
    }

    fn light(&self, id: LightId) -> &Self::Light {
        &*self.lights[id.0 as usize]
    }

    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        Some((LightId(u32::from(u >= 0.5)), 0.5))
    }

    fn pick_pmf(&self, _id: LightId) -> f64 {
        0.5
    }

    /// Optional: integrators leave out what the scene does not need.
    fn needs(&self) -> Needs {
        Needs::ALL.without(Needs::DIRAC_LOBES | Needs::ENVIRONMENT | Needs::UNCONNECTIBLE_LIGHTS)
    }
}

/// Optional: only uniform-area path sampling asks for it.
impl SurfaceArea for ToyScene {
    fn total_area(&self) -> f64 {
        4.0 * GROUND_HALF_WIDTH.powi(2)
            + self.balls.iter().map(|(ball, _)| 4.0 * PI * ball.radius.powi(2)).sum::<f64>()
    }

    fn sample_surface(&self, u1: f64, u2: DVec2) -> SurfacePoint {
        let mut area = u1 * self.total_area() - 4.0 * GROUND_HALF_WIDTH.powi(2);
        if area < 0.0 {
            let p = (u2 * 2.0 - 1.0) * GROUND_HALF_WIDTH;
            return self.point(GROUND, DVec3::new(p.x, 0.0, p.y));
        }
        let last = self.balls.len() - 1;
        let chosen = self.balls[..last].iter().position(|(ball, _)| {
            area -= 4.0 * PI * ball.radius.powi(2);
            area < 0.0
        });
        let chosen = chosen.unwrap_or(last);
        let point = Shape::Sphere(self.balls[chosen].0).sample_area(u2);
        SurfacePoint { primitive: chosen as u32 + 1, surface: chosen as u32 + 1, ..point }
    }
}

// -------------------------------------------------------------------------------------------------
// the host's material in a ready-made scene

/// A retro-reflective ball, a mesh with smooth normals, on a grey floor under a lamp.
fn world() -> Result<World, SceneError> {
    let mut builder = WorldBuilder::new();
    let floor = builder.add_material("floor", Material::Lambert { albedo: Rgb::splat(0.5) })?;
    let black = builder.add_material("black", Material::Black)?;
    // Any `Bsdf` will do. That it is diffuse and glossy, and no mirror, is what it says itself.
    let sign = RetroReflector {
        diffuse: Rgb::new(0.1, 0.25, 0.1),
        retro: Rgb::new(0.3, 0.5, 0.3),
        exponent: 8.0,
    };
    let sign = builder.add_material("sign", Material::custom(sign))?;

    let mut ball = Mesh::icosphere(4);
    ball.normals = Some(ball.positions.clone());
    builder.add_mesh("ball", &ball, DAffine3::from_translation(DVec3::Y), sign)?;
    let ground = Disk { center: DVec3::ZERO, normal: DVec3::Y, radius: 5.0 };
    builder.add_disk("ground", ground, floor)?;
    let lamp =
        Quad { origin: DVec3::new(0.5, 3.5, 0.0), edge_u: DVec3::X * 1.5, edge_v: DVec3::Z * 1.5 };
    let lamp = builder.add_quad("lamp", lamp, black)?;
    builder.set_emission(lamp, Emission { radiance: Rgb::splat(9.0), two_sided: false })?;
    builder.build()
}

// -------------------------------------------------------------------------------------------------
// rendering

/// Whose geometry it is.
#[derive(Clone, Copy, ValueEnum)]
enum Geometry {
    /// The host's own
    Host,
    /// A ready-made world, with the host's material on a mesh
    World,
}

/// Renders a toy host's scene with three integrators and tests that their images agree.
#[derive(Parser)]
struct Options {
    /// The scene
    #[arg(long, value_enum, default_value = "host")]
    scene: Geometry,
    /// Image file: the three images side by side (.png, .hdr or .exr)
    #[arg(long, default_value = "target/custom_scene.png", value_parser = common::parse_image_path)]
    out: PathBuf,
    /// Width and height of each image in pixels
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=4096))]
    size: u32,
    /// Samples per pixel and rendering
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Independent renderings per integrator, from which standard errors are estimated
    #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u32).range(2..=1000))]
    batches: u32,
    /// Largest number of scattering events
    #[arg(long, default_value_t = 5)]
    max_bounces: u32,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let agree = match options.scene {
        Geometry::Host => ToyScene::new().and_then(|scene| run(&scene, &options)),
        Geometry::World => world().map_err(Into::into).and_then(|scene| run(&scene, &options)),
    };
    match agree {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Renders by each integrator; true if they agree.
fn run<S: Scene>(scene: &S, options: &Options) -> Result<bool, Box<dyn Error>> {
    let camera = PinholeCamera::new(
        DVec3::new(0.0, 3.0, 8.0),
        DVec3::new(0.0, 1.3, 0.0),
        DVec3::Y,
        46.0,
        UVec2::splat(options.size),
    )?;
    let depth = options.max_bounces;
    let (path, light, both) =
        (PathTracer::up_to(depth), LightTracer::up_to(depth), Bidirectional::up_to(depth));
    let integrators: [&dyn Render<S>; 3] = [&path, &light, &both];

    let mut images = Vec::new();
    let mut means: Vec<(&str, Estimate)> = Vec::new();
    for (i, integrator) in integrators.into_iter().enumerate() {
        let (mut mean, mut name) = (Estimate::default(), "");
        let mut image = Image::from_fn(options.size, options.size, |_, _| Rgb::BLACK);
        for batch in 0..u64::from(options.batches) {
            // No two renderings may share random numbers, or their difference would look smaller
            // than it is.
            let seed = options.seed.wrapping_add((i as u64 * 1000 + batch) << 32);
            let settings =
                Settings { budget: Budget::Samples(options.samples), seed, ..Settings::default() };
            let rendering = integrator.render(scene, &camera, &settings, &mut unattended)?;
            name = rendering.integrator;
            mean.push(rendering.image.mean().luminance());
            for (sum, pixel) in image.pixels_mut().iter_mut().zip(rendering.image.pixels()) {
                *sum += *pixel / f64::from(options.batches);
            }
            eprint!("\r{name}: {} of {} renderings ", batch + 1, options.batches);
        }
        println!("\r{name:<15} mean luminance {:.6} ± {:.6}", mean.mean(), mean.standard_error());
        images.push(image);
        means.push((name, mean));
    }

    let mut agree = true;
    for (i, (name, a)) in means.iter().enumerate() {
        for (other, b) in &means[i + 1..] {
            let z = (a.mean() - b.mean()) / a.standard_error().hypot(b.standard_error());
            println!("{name} - {other}: {z:+.2} standard errors");
            agree &= z.abs() < 4.0;
        }
    }
    println!("{}", if agree { "the integrators agree" } else { "THE INTEGRATORS DISAGREE" });

    let side_by_side = Image::from_fn(3 * options.size, options.size, |x, y| {
        images[(x / options.size) as usize].get(x % options.size, y).unwrap_or(Rgb::BLACK)
    });
    if let Some(directory) = options.out.parent() {
        std::fs::create_dir_all(directory)?;
    }
    ImageFile::from(side_by_side).save(&options.out)?;
    println!("wrote {}", options.out.display());
    Ok(agree)
}
