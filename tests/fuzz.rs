//! Random worlds: whatever a builder accepts renders without a panic, without a number that is not
//! finite, and with paths that are what the definitions say.
//!
//! Tamer ones, without what makes noise hide or feign a difference, must look the same to path
//! tracing and bidirectional path tracing.
//!
//! The number of cases and the seed are fixed. `PATHSPACE_FUZZ_SECONDS=600 cargo test --release
//! -p pathspace-tests --test fuzz -- --ignored --nocapture` goes on for as long as it says,
//! with new seeds from `PATHSPACE_FUZZ_SEED` on; a failure names its own.
#![allow(missing_docs, reason = "a test program")]

mod common;
#[path = "../examples/stability/measure.rs"]
#[allow(dead_code, reason = "shared with an example")]
mod measure;
mod worlds;

use common::Random;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, UVec2};
use measure::{Method, Probe};
use pathspace::endpoint::{
    Camera, ConstantEnvironment, DirectionalLight, EnvironmentMap, OrthographicCamera,
    PinholeCamera, PointLight, SpotLight, ThinLensCamera,
};
use pathspace::film::{Contribution, Filter, Sample};
use pathspace::geometry::{Disk, Place, Quad, Sphere};
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer, Stage, UniformArea};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, PathRecord, Scratch, Weighting};
use pathspace::render::{Budget, Render, Settings};
use pathspace::sampler::SamplerKind;
use pathspace::scene::{Emission, Material, Mesh, Needs, Scene, Warning, World, WorldBuilder};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseResult, TestRng, TestRunner};
use std::cell::Cell;
use std::error::Error;
use std::time::{Duration, Instant};

/// Cases of the test that always runs.
const CASES: u32 = 400;
/// Cases of the comparison of integrators that always runs.
const COMPARED: u32 = 80;
/// Samples of each world whose paths are verified.
const PATHS: u32 = 256;

/// A scene as numbers: shapes and lights in a unit cube, placed by scale and offset.
#[derive(Clone, Debug)]
struct Plan {
    /// Decimal exponents of the scene's scale and of the offset relative to the scale.
    scale: f64,
    offset: (f64, DVec3),
    shapes: Vec<ShapePlan>,
    lights: Vec<LightPlan>,
    camera: (u8, DVec3, DVec3, f64),
    seed: u64,
}

#[derive(Clone, Debug)]
struct ShapePlan {
    kind: u8,
    center: DVec3,
    axis: DVec3,
    /// Decimal exponents of two sizes relative to the scene.
    size: (f64, f64),
    material: Material,
    glow: Option<(f64, bool)>,
}

#[derive(Clone, Debug)]
struct LightPlan {
    kind: u8,
    position: DVec3,
    direction: DVec3,
    strength: f64,
}

fn in_cube() -> impl Strategy<Value = DVec3> {
    // Some points on a lattice, so that things touch, coincide and line up.
    let coordinate = || {
        let lattice = prop::sample::select(vec![-1.0, -0.5, 0.0, 0.5, 1.0]);
        prop_oneof![3 => -1.0..1.0f64, 1 => lattice]
    };
    (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn simple_material() -> impl Strategy<Value = Material> {
    let unit = || prop_oneof![4 => 0.0..=1.0f64, 1 => Just(0.0), 1 => Just(1.0)];
    let rgb = move || (unit(), unit(), unit()).prop_map(|(r, g, b)| Rgb::new(r, g, b));
    let alpha =
        || (-5.0..0.5f64, -5.0..0.5f64).prop_map(|(x, y)| DVec2::new(10f64.powf(x), 10f64.powf(y)));
    let ior = || {
        let special = prop::sample::select(vec![1.0 + 1e-7, 0.999, 1e-3, 1e3]);
        prop_oneof![4 => 0.4..2.5f64, 1 => Just(1.0), 1 => special]
    };
    let metal = || {
        (0.1..4.0f64, 0.0..6.0f64)
            .prop_map(|(eta, k)| (Rgb::new(eta, 0.5, 1.0), Rgb::new(k, 2.0, 0.0)))
    };
    prop_oneof![
        1 => Just(Material::Black),
        1 => Just(Material::Null),
        5 => rgb().prop_map(|albedo| Material::Lambert { albedo }),
        1 => rgb().prop_map(|reflectance| Material::Mirror { reflectance }),
        1 => metal().prop_map(|(eta, k)| Material::Conductor { eta, k }),
        2 => ior().prop_map(|relative_ior| Material::Dielectric { relative_ior }),
        1 => (rgb(), alpha())
            .prop_map(|(reflectance, alpha)| Material::RoughMirror { reflectance, alpha }),
        2 => (metal(), alpha())
            .prop_map(|((eta, k), alpha)| Material::RoughConductor { eta, k, alpha }),
        2 => (ior(), alpha())
            .prop_map(|(relative_ior, alpha)| Material::RoughDielectric { relative_ior, alpha }),
    ]
}

fn material() -> impl Strategy<Value = Material> {
    let mixture = (simple_material(), simple_material(), 0.0..=1.0f64).prop_map(|(a, b, w)| {
        Material::Mixture { components: Box::new([a, b]), weights: [w, 1.0 - w] }
    });
    prop_oneof![3 => simple_material(), 1 => mixture]
}

fn shape() -> impl Strategy<Value = ShapePlan> {
    let size = (-3.0..0.5f64, -3.0..0.5f64);
    let glow = prop::option::weighted(0.35, (-3.0..3.0f64, any::<bool>()));
    (0..6u8, in_cube(), in_cube(), size, material(), glow).prop_map(
        |(kind, center, axis, size, material, glow)| ShapePlan {
            kind,
            center,
            axis,
            size,
            material,
            glow,
        },
    )
}

fn plan() -> impl Strategy<Value = Plan> {
    let light = (0..5u8, in_cube(), in_cube(), -3.0..3.0f64).prop_map(
        |(kind, position, direction, strength)| LightPlan { kind, position, direction, strength },
    );
    let scale = prop_oneof![1 => Just(0.0), 2 => -6.0..6.0f64];
    let offset = (prop_oneof![2 => Just(f64::NEG_INFINITY), 1 => -1.0..6.0f64], in_cube());
    let camera = (0..3u8, in_cube().prop_map(|p| p * 3.0), in_cube(), 5.0..120.0f64);
    (
        scale,
        offset,
        prop::collection::vec(shape(), 0..8),
        prop::collection::vec(light, 0..4),
        camera,
        any::<u64>(),
    )
        .prop_map(|(scale, offset, shapes, lights, camera, seed)| Plan {
            scale,
            offset,
            shapes,
            lights,
            camera,
            seed,
        })
}

impl Plan {
    fn scale(&self) -> f64 {
        10f64.powf(self.scale)
    }

    fn place(&self, p: DVec3) -> DVec3 {
        (p + self.offset.1 * 10f64.powf(self.offset.0)) * self.scale()
    }

    fn world(&self) -> Result<World, Box<dyn Error>> {
        let mut b = WorldBuilder::new();
        for (i, plan) in self.shapes.iter().enumerate() {
            let material = b.add_material(format!("material {i}"), plan.material.clone())?;
            let name = format!("shape {i}");
            let center = self.place(plan.center);
            let (size, other) =
                (10f64.powf(plan.size.0) * self.scale(), 10f64.powf(plan.size.1) * self.scale());
            let frame = plan.axis.try_normalize().map(|z| (z, z.any_orthonormal_vector()));
            let (z, x) = frame.unwrap_or((DVec3::Z, DVec3::X));
            let rotation = DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z));
            let id = match plan.kind {
                0 => b.add_sphere(
                    name,
                    Sphere { inward: plan.center.x > 0.5, ..Sphere::new(center, size) },
                    material,
                )?,
                1 => {
                    let zone = Sphere {
                        cos_min: -1.0,
                        cos_max: plan.axis.y,
                        axis: z,
                        inward: plan.center.y > 0.0,
                        ..Sphere::new(center, size)
                    };
                    b.add_sphere(name, zone, material)?
                }
                2 => b.add_quad(
                    name,
                    Quad {
                        origin: center,
                        edge_u: x * size,
                        edge_v: z.cross(x) * other + x * (0.3 * size),
                    },
                    material,
                )?,
                3 => {
                    b.add_disk(name, Disk { center, normal: plan.axis, radius: size }, material)?
                }
                _ => {
                    let mut ball = Mesh::icosphere(u32::from(plan.kind) - 4);
                    ball.normals = (plan.kind == 5).then(|| ball.positions.clone());
                    // Up to three and a half decades flat, sometimes mirrored.
                    let stretch =
                        DVec3::new(size, other, if plan.axis.x > 0.3 { -size } else { size });
                    b.add_mesh(
                        name,
                        &ball,
                        DAffine3::from_scale_rotation_translation(stretch, rotation, center),
                        material,
                    )?
                }
            };
            if let Some((radiance, two_sided)) = plan.glow {
                b.set_emission(
                    id,
                    Emission {
                        radiance: Rgb::new(1.0, 0.5, 0.0) * 10f64.powf(radiance),
                        two_sided,
                    },
                )?;
            }
        }
        for (i, plan) in self.lights.iter().enumerate() {
            let (name, strength) = (format!("light {i}"), Rgb::splat(10f64.powf(plan.strength)));
            let (position, intensity) =
                (self.place(plan.position), strength * self.scale().powi(2));
            match plan.kind {
                0 => b.add_light(name, PointLight::new(position, intensity)?)?,
                1 => {
                    let outer = 90.0 + 89.0 * plan.position.x;
                    b.add_light(
                        name,
                        SpotLight::new(position, plan.direction, intensity, outer * 0.5, outer)?,
                    )?;
                }
                2 => b.add_light(name, DirectionalLight::new(plan.direction, strength)?)?,
                3 => b.set_environment(name, ConstantEnvironment::new(strength)?)?,
                _ => {
                    let pixel = |i: u32| strength * f64::from(i * 7 % 5);
                    b.set_environment(
                        name,
                        EnvironmentMap::new(
                            4,
                            3,
                            (0..12).map(pixel).collect(),
                            DMat3::from_quat(DQuat::from_rotation_x(1.0)),
                        )?,
                    )?;
                }
            }
        }
        Ok(b.build()?)
    }

    fn camera(&self) -> Result<Box<dyn Camera + Send>, Box<dyn Error>> {
        let (kind, position, target, fov) = self.camera;
        let (position, target, up, film) =
            (self.place(position), self.place(target), DVec3::new(0.1, 1.0, 0.2), UVec2::splat(4));
        let size = self.scale() * fov / 50.0;
        Ok(match kind {
            0 => Box::new(PinholeCamera::new(position, target, up, fov, film)?),
            1 => Box::new(ThinLensCamera::new(
                position,
                target,
                up,
                fov,
                0.05 * size,
                2.0 * size,
                film,
            )?),
            _ => Box::new(OrthographicCamera::new(position, target, up, size, film)?),
        })
    }
}

/// Counts of what was tested, so that a test of nothing does not pass.
#[derive(Debug, Default)]
struct Seen {
    worlds: Cell<u32>,
    paths: Cell<u64>,
    /// Paths whose points do not tell their Dirac directions.
    blurred: Cell<u64>,
}

/// Renders with every integrator, then looks at the paths of the bidirectional one.
fn check(plan: &Plan, seen: &Seen) -> TestCaseResult {
    // Refusing a plan is an answer; its messages must be printable.
    let world = match plan.world() {
        Ok(world) => world,
        Err(error) => return accept(!error.to_string().is_empty()),
    };
    let camera = match plan.camera() {
        Ok(camera) => camera,
        Err(error) => return accept(!error.to_string().is_empty()),
    };
    let depth = Depth { min_bounces: 0, max_bounces: Some(12) };
    let integrators: [&dyn Render<World>; 4] = [
        &UniformArea { depth, ..UniformArea::default() },
        &PathTracer { depth, ..PathTracer::default() },
        &LightTracer { depth, ..LightTracer::default() },
        &Bidirectional { depth, ..Bidirectional::default() },
    ];
    for (i, integrator) in integrators.into_iter().enumerate() {
        let sampler = [SamplerKind::Independent, SamplerKind::Stratified, SamplerKind::Sobol]
            [(plan.seed as usize).wrapping_add(i) % 3];
        let filter = if plan.seed & 8 == 0 { Filter::Box } else { Filter::Tent };
        let settings = Settings {
            budget: Budget::Samples(8),
            seed: plan.seed,
            threads: Some(1),
            filter,
            sampler,
            ..Settings::default()
        };
        let rendering = integrator.render(&world, &*camera, &settings).expect("valid settings");
        let counters = rendering.counters;
        prop_assert_eq!(
            counters.non_finite,
            0,
            "{}: {:?}",
            rendering.integrator,
            rendering.non_finite()
        );
        prop_assert_eq!(counters.samples, 16 * 8);
        prop_assert!(
            rendering.image.pixels().iter().all(|p| p.is_finite() && p.0.iter().all(|c| *c >= 0.0))
        );
        // Walks of samples, and of trials of lights before them.
        let walks = counters.samples + 2 * 256;
        prop_assert!(
            counters.closest_rays <= walks * 2 * 14 && counters.shadow_rays <= walks * 14 * 15
        );
        prop_assert_eq!(counters.ledger.rejected, Rgb::BLACK);
        prop_assert!(counters.ledger.emitted.is_finite() && counters.ledger.absorbed.is_finite());
    }
    seen.worlds.set(seen.worlds.get() + 1);
    verify(plan, &world, &*camera, seen)
}

fn verify(plan: &Plan, world: &World, camera: &(dyn Camera + Send), seen: &Seen) -> TestCaseResult {
    let (mut sampler, mut displacements, mut scratch) =
        (Random::new(plan.seed), Random::new(!plan.seed), Scratch::default());
    let integrator = Bidirectional {
        depth: Depth::up_to(8),
        heuristic: Heuristic::Balance,
        ..Bidirectional::default()
    };
    let set = integrator.techniques.pruned(&world.needs());
    let mut result = Ok(());
    for _ in 0..PATHS {
        let film = worlds::film_sample(camera, &mut sampler);
        integrator.for_each_path(
            Stage::new(world, camera),
            Sample { film, sampler: &mut sampler },
            &mut scratch,
            |path, &Contribution { weight, value, .. }| {
                if result.is_err() {
                    return;
                }
                seen.paths.set(seen.paths.get() + 1);
                if !is_auditable(&path.record()) {
                    seen.blurred.set(seen.blurred.get() + 1);
                    return;
                }
                let weighting = Weighting::new(set, integrator.heuristic);
                let verified = path.verify(&weighting);
                let what =
                    || format!("{path:?} weight {weight:e} {verified:?} {:?}", path.record());
                let fail = |reason: &str| Err(TestCaseError::fail(format!("{reason}: {}", what())));
                if !(value.is_finite() && weight.is_finite() && (0.0..=1.0).contains(&weight)) {
                    result = fail("not finite");
                } else if verified.weight_sum_error.is_nan() || verified.weight_sum_error > 1e-9 {
                    result = fail("weights do not sum to 1");
                } else if verified.worst() > 1e-12 {
                    let (value, weight) =
                        worlds::sensitivity(path, &weighting, 64, &mut displacements);
                    // Lobes of width 1e-4 between nearly equal indices also magnify the rounding of
                    // local frames, which displacements do not show.
                    let (value, weight) = (4.0 * value + 1e-12, 4.0 * weight + 1e-12);
                    if !(verified.value_error <= value && verified.weight_error <= weight) {
                        result = fail(&format!("beyond {value:e} or {weight:e}"));
                    }
                }
            },
        );
    }
    result
}

/// True if the points tell the directions at Dirac vertices well enough to recognise the lobe: not
/// if an edge is as short as the errors of its ends times 10⁸, as far away from the origin.
fn is_auditable(record: &PathRecord) -> bool {
    let sharp = |i: usize, j: usize| {
        let (a, b) = (record.points[i], record.points[j]);
        a.place == Place::Infinite
            || b.place == Place::Infinite
            || a.position.distance(b.position) > 1e8 * (a.error + b.error)
    };
    (1..record.points.len() - 1).all(|i| !record.dirac[i] || (sharp(i - 1, i) && sharp(i, i + 1)))
}

/// Nothing that few samples miss: no Dirac lobes and none narrower than 0.1, nothing smaller than a
/// thirtieth of the scene.
fn tame(mut plan: Plan) -> Plan {
    for shape in &mut plan.shapes {
        shape.material = tamed(shape.material.clone());
        shape.size = (shape.size.0.max(-1.5), shape.size.1.max(-1.5));
    }
    plan
}

fn tamed(material: Material) -> Material {
    let wide = |alpha: DVec2| alpha.clamp(DVec2::splat(0.1), DVec2::ONE);
    match material {
        Material::RoughMirror { reflectance, alpha } => {
            Material::RoughMirror { reflectance, alpha: wide(alpha) }
        }
        Material::RoughConductor { eta, k, alpha } => {
            Material::RoughConductor { eta, k, alpha: wide(alpha) }
        }
        Material::RoughDielectric { relative_ior, alpha } => Material::RoughDielectric {
            relative_ior: relative_ior.clamp(1.1, 2.0),
            alpha: wide(alpha),
        },
        Material::Mixture { components, weights } => {
            Material::Mixture { components: Box::new(components.map(tamed)), weights }
        }
        Material::Black | Material::Lambert { .. } => material,
        _ => Material::Lambert { albedo: Rgb::new(0.8, 0.5, 0.2) },
    }
}

/// Path tracing and bidirectional path tracing see the same mean. A rare event that one of them has
/// not met yet looks like a difference; so a difference is one only if it is still there with 8 and
/// with 64 times the samples.
fn agree(plan: &Plan, compared: &Cell<u32>, undecided: &Cell<u32>) -> TestCaseResult {
    let (Ok(world), Ok(camera)) = (plan.world(), plan.camera()) else { return Ok(()) };
    let ambiguous =
        world.warnings().iter().any(|warning| matches!(warning, Warning::CoincidentEmitter { .. }));
    prop_assert!(!world.needs().contains(Needs::DIRAC_LOBES));
    if ambiguous || world.light_count() == 0 {
        return Ok(());
    }
    // Only connections to the lens see point lights through a thin lens, so what is seen directly
    // does not count.
    let probe = Probe::new(&world, &*camera, Depth { min_bounces: 1, max_bounces: Some(4) });
    let mut report = String::new();
    for samples in [4000, 32_000, 256_000] {
        let [path, bidirectional] = [Method::Path, Method::Bidirectional]
            .map(|method| probe.sample(method, samples, plan.seed ^ samples));
        prop_assert_eq!(path.non_finite + bidirectional.non_finite, 0);
        let z = |i: usize| {
            let (a, b) = (&path.channels[i], &bidirectional.channels[i]);
            // Rounding is no difference where there is no noise.
            let error = a.standard_error().hypot(b.standard_error()).hypot(1e-9 * a.mean());
            if a.mean() == b.mean() { 0.0 } else { (a.mean() - b.mean()) / error }
        };
        if (0..3).all(|i| z(i).abs() <= 4.0) {
            compared.set(compared.get() + u32::from(path.channels[0].mean() > 0.0));
            return Ok(());
        }
        let means = |m: &measure::Measured| m.channels.map(|c| c.mean());
        // Or black where the other is not: what it has never met has no spread either.
        let is_vague = |m: &measure::Measured, other: &measure::Measured| {
            m.channels.iter().zip(&other.channels).any(|(c, o)| {
                c.standard_error() > 0.1 * c.mean() || (c.mean() == 0.0 && o.mean() != 0.0)
            })
        };
        if samples == 256_000
            && (is_vague(&path, &bidirectional) || is_vague(&bidirectional, &path))
        {
            // A light next to a wall, say, which camera walks hardly ever find.
            undecided.set(undecided.get() + 1);
            return Ok(());
        }
        report += &format!(
            "\n{samples} samples: {:?} {:?}, z {:?}",
            means(&path),
            means(&bidirectional),
            [z(0), z(1), z(2)]
        );
    }
    Err(TestCaseError::fail(report))
}

fn accept(condition: bool) -> TestCaseResult {
    prop_assert!(condition);
    Ok(())
}

fn runner(cases: u32, seed: u64, max_shrink_iters: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, max_shrink_iters, ..Config::default() };
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &bytes))
}

fn fuzz(cases: u32, seed: u64) {
    let seen = Seen::default();
    if let Err(error) = runner(cases, seed, 2000).run(&plan(), |plan| check(&plan, &seen)) {
        panic!("PATHSPACE_FUZZ_SEED={seed}: {error}");
    }
    let (worlds, paths) = (seen.worlds.get(), seen.paths.get());
    println!("seed {seed}: {worlds} worlds of {cases} plans, {paths} paths");
    assert!(100 * seen.blurred.get() <= paths, "{seen:?}");
    assert!(
        worlds > cases / 2 && paths > 50 * u64::from(cases),
        "too many plans are refused or dark: {seen:?}"
    );
}

fn fuzz_agreement(cases: u32, seed: u64) {
    let (compared, undecided) = (Cell::new(0), Cell::new(0));
    // A difference takes long to confirm, so plans are hardly made simpler.
    if let Err(error) = runner(cases, seed, 10)
        .run(&plan().prop_map(tame), |plan| agree(&plan, &compared, &undecided))
    {
        panic!("PATHSPACE_FUZZ_SEED={seed}: {error}");
    }
    println!(
        "seed {seed}: {} of {cases} plans compared, {} undecided",
        compared.get(),
        undecided.get()
    );
    assert!(undecided.get() <= 1 + cases / 20, "{undecided:?}");
    assert!(compared.get() > cases / 8, "too many plans are dark: {compared:?}");
}

#[test]
fn random_worlds_render() {
    fuzz(CASES, 1);
}

#[test]
fn integrators_agree_on_random_worlds() {
    fuzz_agreement(COMPARED, 1);
}

#[test]
#[ignore = "as long as the environment variable PATHSPACE_FUZZ_SECONDS says"]
fn soak() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let end = Instant::now() + Duration::from_secs(number("PATHSPACE_FUZZ_SECONDS").unwrap_or(60));
    for seed in number("PATHSPACE_FUZZ_SEED").unwrap_or(2).. {
        fuzz(CASES, seed);
        fuzz_agreement(COMPARED, seed);
        if Instant::now() >= end {
            break;
        }
    }
}
