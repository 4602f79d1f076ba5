//! Exact answers for all integrators that can see them; `analytic.json` entries are named by their ids.

#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;
#[path = "common/rooms.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod rooms;

use compare::{Comparison, measure};
use glam::{DAffine3, DVec2, DVec3, UVec2};
use pathspace::endpoint::{ConstantEnvironment, PinholeCamera};
use pathspace::film::{Contribution, FilmSample, Filter, Technique};
use pathspace::geometry::Sphere;
use pathspace::integrator::{Bidirectional, Depth, Integrator, LightTracer, PathTracer, PathTracing, UniformArea};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, PathDensities, Roulette, Scratch, TechniqueSet};
use pathspace::render::Render;
use pathspace::sampler::{Independent, SampleSource};
use pathspace::scene::{Material, Mesh, World};
use rooms::{Room, lambert, v};
use std::f64::consts::{FRAC_1_PI, PI};

const BLACK: Material = Material::Black;

fn path(depth: Depth) -> PathTracer {
    PathTracer { depth, ..PathTracer::default() }
}

fn path_mode(mode: PathTracing, depth: Depth) -> PathTracer {
    PathTracer { mode, depth, ..PathTracer::default() }
}

fn bidirectional(depth: Depth, heuristic: Heuristic) -> Bidirectional {
    Bidirectional { depth, heuristic, ..Bidirectional::default() }
}

type Team = Vec<(&'static str, Box<dyn Render<World>>)>;

/// Path tracing (both techniques, and hits alone) and bidirectional path tracing.
fn from_camera(depth: Depth) -> Team {
    vec![
        ("path", Box::new(path(depth))),
        ("emission only", Box::new(path_mode(PathTracing::EmissionOnly, depth))),
        ("bidirectional, power", Box::new(bidirectional(depth, Heuristic::Power(2.0)))),
        ("bidirectional, balance", Box::new(bidirectional(depth, Heuristic::Balance))),
    ]
}

/// And light tracing and uniform-area sampling.
fn everybody(depth: Depth) -> Team {
    let mut team = from_camera(depth);
    team.push(("light", Box::new(LightTracer { depth, ..LightTracer::default() })));
    team.push(("uniform area", Box::new(UniformArea { depth, ..UniformArea::default() })));
    team
}

fn assert_all(case: &str, world: &World, camera: &PinholeCamera, team: &Team, expected: [f64; 3], error: f64) {
    println!("{case}");
    let comparison = Comparison { target: 0.7 * error, most: 20_000, ..Comparison::default() };
    for (name, integrator) in team {
        measure(world, camera, (name, integrator.as_ref()), &comparison).assert_mean(expected, error);
    }
}

/// A camera that sees as good as one point.
fn narrow(position: DVec3, target: DVec3) -> PinholeCamera {
    let up = if (target - position).normalize().z.abs() > 0.9 { DVec3::X } else { DVec3::Z };
    PinholeCamera::new(position, target, up, 0.02, UVec2::splat(4)).expect("valid camera")
}

fn inward_cube() -> Mesh {
    let positions = (0..8).map(|i| v(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect();
    // Counter-clockwise seen from inside.
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, indices, ..Mesh::default() }
}

/// The unit cube whose walls all reflect and emit.
fn furnace(albedo: Rgb) -> World {
    let mut room = Room::default();
    let cube = room.mesh(&inward_cube(), DAffine3::IDENTITY, Material::Lambert { albedo });
    room.emit(cube, Rgb::WHITE, false);
    room.build()
}

fn inside() -> PinholeCamera {
    PinholeCamera::new(DVec3::splat(0.5), v(0.9, 0.6, 0.3), DVec3::Z, 60.0, UVec2::splat(8)).expect("valid camera")
}

#[test]
fn a01_closed_furnace() {
    let team = everybody(Depth::default()).into_iter().filter(|(name, _)| *name != "uniform area").collect();
    assert_all("A01", &furnace(Rgb::splat(0.5)), &inside(), &team, [2.0; 3], 0.003);
    // The variance of 1/r² in the corners is infinite: one digit less.
    let uniform: Team = vec![("uniform area", Box::new(UniformArea::up_to(1)))];
    assert_all("A01, one bounce", &furnace(Rgb::splat(0.5)), &inside(), &uniform, [1.5; 3], 0.01);
}

#[test]
fn a02_truncated_furnace() {
    let world = furnace(Rgb::splat(0.8));
    for (k, expected) in [(0, 1.0), (1, 1.8), (2, 2.44), (4, 3.3616)] {
        let team = everybody(Depth::up_to(k)).into_iter().filter(|(name, _)| k == 0 || *name != "uniform area").collect();
        assert_all(&format!("A02, k = {k}"), &world, &inside(), &team, [expected; 3], 0.003);
    }
}

/// Walks survive with their albedo, without a cap below 1.
#[test]
fn a03_bright_furnace() {
    let team: Team = vec![("path", Box::new(path(Depth::default()))), ("light", Box::new(LightTracer::default()))];
    assert_all("A03, albedo 0.98", &furnace(Rgb::splat(0.98)), &inside(), &team, [50.0; 3], 0.01);
}

#[test]
fn a04_coloured_furnace() {
    let team = everybody(Depth::default()).into_iter().filter(|(name, _)| *name != "uniform area").collect();
    assert_all("A04", &furnace(Rgb::new(0.2, 0.5, 0.9)), &inside(), &team, [1.25, 2.0, 10.0], 0.005);
}

#[test]
fn a13_wedge_under_an_environment() {
    // The wedge's opening angle φ: a plane sees the other one under the form factor (1 + cos φ)/2, so L = ρ (1 - cos φ)/(2 - ρ (1 + cos φ)). A13 states
    // the same numbers for the angle π - φ.
    for (degrees, expected) in [(60.0f64, 0.272_727_272_727_272_7), (90.0, 0.428_571_428_571_428_55), (120.0, 0.529_411_764_705_882_4)] {
        let mut room = Room::default();
        let (sin, cos) = degrees.to_radians().sin_cos();
        let rho = || lambert(0.6, 0.6, 0.6);
        room.quad(v(0.0, -5e7, 0.0), v(1e8, 0.0, 0.0), v(0.0, 1e8, 0.0), rho());
        room.quad(v(0.0, -5e7, 0.0), v(0.0, 1e8, 0.0), v(1e8 * cos, 0.0, 1e8 * sin), rho());
        room.environment(ConstantEnvironment::new(Rgb::WHITE).expect("valid"));
        let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
        let camera = narrow(v(1.0 + 2.0 * cos, 0.3, 2.0 * sin), v(1.0, 0.0, 0.0));
        // Truncation of the half planes decays as their size to the power of -0.65: 6e-4 at 1e4, measured.
        assert_all(&format!("A13, {degrees}°"), &room.build(), &camera, &from_camera(Depth::default()), [expected; 3], 0.003);
    }
}

/// A floor of albedo 0.5 at the origin and one light above; irradiance E there.
fn above_floor(case: &str, light: impl Fn(&mut Room), irradiance: f64) {
    let mut room = Room::default();
    room.disk(DVec3::ZERO, DVec3::Z, 0.3, lambert(0.5, 0.5, 0.5));
    light(&mut room);
    let mut team = from_camera(Depth::exactly(1));
    team.push(("next event only", Box::new(path_mode(PathTracing::NextEventOnly, Depth::exactly(1)))));
    team.push(("uniform area", Box::new(UniformArea { depth: Depth::exactly(1), ..UniformArea::default() })));
    assert_all(case, &room.build(), &narrow(v(0.3, 0.0, 0.5), DVec3::ZERO), &team, [irradiance * 0.5 * FRAC_1_PI; 3], 0.002);
}

#[test]
fn b06_square_light() {
    let light = |room: &mut Room| {
        let square = room.quad(v(-1.0, -1.0, 2.0), v(0.0, 2.0, 0.0), v(2.0, 0.0, 0.0), BLACK);
        room.emit(square, Rgb::WHITE, false);
    };
    above_floor("B06", light, 0.752_274_688_454_107_5);
}

#[test]
fn b09_sphere_light() {
    let (sin, cos) = (PI / 6.0).sin_cos();
    let light = |room: &mut Room| {
        let sphere = room.sphere(Sphere::new(v(3.0 * sin, 0.0, 3.0 * cos), 1.0), BLACK);
        room.emit(sphere, Rgb::WHITE, false);
    };
    above_floor("B09", light, 0.302_299_894_039_036_3);
}

#[test]
fn b11_disk_light() {
    let light = |room: &mut Room| {
        let disk = room.disk(v(0.0, 0.0, 2.0), -DVec3::Z, 1.0, BLACK);
        room.emit(disk, Rgb::WHITE, false);
    };
    above_floor("B11", light, 0.628_318_530_717_958_6);
}

#[test]
fn b19_cube_with_a_bright_ceiling() {
    let mut room = Room::default();
    let cube = inward_cube();
    let walls = Mesh { indices: cube.indices.iter().copied().filter(|t| t.iter().any(|&i| i < 4)).collect(), ..cube.clone() };
    let ceiling = Mesh { indices: cube.indices.iter().copied().filter(|t| t.iter().all(|&i| i >= 4)).collect(), ..cube };
    room.mesh(&walls, DAffine3::IDENTITY, lambert(0.5, 0.5, 0.5));
    let ceiling = room.mesh(&ceiling, DAffine3::IDENTITY, BLACK);
    room.emit(ceiling, Rgb::WHITE, false);
    let (world, camera) = (room.build(), narrow(v(0.7, 0.6, 0.4), v(0.5, 0.5, 0.0)));
    for (k, expected) in [(1, 0.119_728_235_230_386_77), (2, 0.034_688_115_736_270_76)] {
        let mut team = from_camera(Depth::exactly(k));
        if k == 1 {
            team.push(("uniform area", Box::new(UniformArea { depth: Depth::exactly(k), ..UniformArea::default() })));
        }
        assert_all(&format!("B19, {k} bounces"), &world, &camera, &team, [expected; 3], 0.003);
    }
}

/// All paths have one edge: s = 0 and (1, 1).
#[test]
fn e03_rectangle_seen_directly() {
    let mut room = Room::default();
    let rectangle = room.quad(v(-0.25, -0.2, 2.0), v(0.0, 0.4, 0.0), v(0.5, 0.0, 0.0), BLACK);
    room.emit(rectangle, Rgb::WHITE, false);
    let camera = PinholeCamera::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 60.0, UVec2::splat(8)).expect("valid camera");
    assert_all("E03", &room.build(), &camera, &everybody(Depth::up_to(0)), [0.0375; 3], 0.002);
}

/// Every filter's shifted copies sum to 1: no pixel is dark, neither at the border nor in the corners.
#[test]
fn e05_constant_radiance() {
    let mut room = Room::default();
    let sphere = room.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, BLACK);
    room.emit(sphere, Rgb::WHITE, false);
    let world = room.build();
    let camera = PinholeCamera::new(v(0.1, 0.0, 0.2), DVec3::X, DVec3::Z, 50.0, UVec2::splat(8)).expect("valid camera");
    for filter in [Filter::Box, Filter::Tent, Filter::Gaussian { standard_deviation: 0.8 }] {
        for (name, integrator) in everybody(Depth::up_to(1)) {
            let comparison = Comparison { filter, target: 0.002, most: 20_000, ..Comparison::default() };
            let measured = measure(&world, &camera, (name, integrator.as_ref()), &comparison);
            measured.assert_mean([1.0; 3], 0.003);
            measured.assert_pixels(1.0);
        }
    }
}

/// A wall of radiance 1 at z = 2, facing down, behind what `interfaces` adds; seen from the origin along z.
fn wall_behind(interfaces: impl Fn(&mut Room)) -> (World, PinholeCamera) {
    let mut room = Room::default();
    let wall = room.quad(v(-5.0, -5.0, 2.0), v(0.0, 10.0, 0.0), v(10.0, 0.0, 0.0), BLACK);
    room.emit(wall, Rgb::WHITE, false);
    interfaces(&mut room);
    (room.build(), narrow(DVec3::ZERO, DVec3::Z))
}

fn pane(room: &mut Room, z: f64, faces_up: bool, material: Material) {
    let (x, y) = (v(6.0, 0.0, 0.0), v(0.0, 6.0, 0.0));
    let (u, w) = if faces_up { (x, y) } else { (y, x) };
    room.quad(v(-3.0, -3.0, z), u, w, material);
}

#[test]
fn c03_slab() {
    let glass = Material::Dielectric { relative_ior: 1.5 };
    let (world, camera) = wall_behind(|room| {
        pane(room, 1.0, false, glass.clone());
        pane(room, 1.1, true, glass.clone());
    });
    for (depth, expected) in [(Depth::up_to(2), 0.9216), (Depth::up_to(4), 0.923_074_56), (Depth::default(), 0.923_076_923_076_923_1)] {
        assert_all("C03", &world, &camera, &from_camera(depth), [expected; 3], 0.001);
    }
}

#[test]
fn c08_looking_out_of_a_medium() {
    // The camera is behind the interface, in the denser medium.
    let (world, camera) = wall_behind(|room| pane(room, 1.0, true, Material::Dielectric { relative_ior: 1.5 }));
    assert_all("C08", &world, &camera, &from_camera(Depth::up_to(1)), [2.16; 3], 0.001);
    // Radiance falls by n² the other way: (1 - R)/n².
    let (world, camera) = wall_behind(|room| pane(room, 1.0, false, Material::Dielectric { relative_ior: 1.5 }));
    assert_all("C08, looking in", &world, &camera, &from_camera(Depth::up_to(1)), [0.96 / 2.25; 3], 0.001);
}

#[test]
fn c13_index_matched_interface() {
    let materials = [
        Material::Null,
        Material::Dielectric { relative_ior: 1.0 },
        Material::RoughDielectric { relative_ior: 1.0, alpha: DVec2::splat(0.3) },
    ];
    for material in materials {
        let (world, camera) = wall_behind(|room| {
            pane(room, 1.0, false, material.clone());
            pane(room, 1.1, true, material.clone());
        });
        for (name, integrator) in from_camera(Depth::up_to(2)) {
            let measured = measure(&world, &camera, (name, integrator.as_ref()), &Comparison { most: 4, ..Comparison::default() });
            let pixels = measured.images.iter().flat_map(|image| image.pixels());
            assert!(pixels.into_iter().all(|p| p.0.iter().all(|c| (c - 1.0).abs() < 1e-12)), "{name}, {material:?}");
        }
    }
}

// Weights and counts of single samples ---------------------------------------------------------------------------------------------------

/// Draws samples spread over the film, and calls `each` with their numbers' sampler.
fn film_samples(camera: &PinholeCamera, count: u32, mut each: impl FnMut(FilmSample, &mut <Independent as SampleSource>::Sampler)) {
    use pathspace::endpoint::Camera;
    let film = camera.film();
    for i in 0..count {
        let mut sampler = Independent { seed: 1 }.sampler(i % film.pixels(), i / film.pixels());
        let raster = {
            use pathspace::sampler::Sampler;
            film.from_window(sampler.next_2d())
        };
        each(FilmSample { raster, offset: DVec2::ZERO }, &mut sampler);
    }
}

fn emissive_sphere(albedo: f64) -> World {
    let mut room = Room::default();
    let sphere = room.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, lambert(albedo, albedo, albedo));
    room.emit(sphere, Rgb::WHITE, false);
    room.build()
}

/// Inside a sphere that emits everywhere, sampling its area and sampling the cosine are the same: both weights are 1/2.
#[test]
fn f15_weights_in_an_emissive_sphere() {
    let (world, camera) = (emissive_sphere(0.9), inside_sphere());
    for (depth, expected) in [(Depth::up_to(1), 1.9), (Depth::up_to(2), 2.71)] {
        assert_all("F15", &world, &camera, &from_camera(depth), [expected; 3], 0.001);
    }
    let general = TechniqueSet { emitter_hits: true, emitter_sampling: true, ..TechniqueSet::NONE };
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0)] {
        let depth = Depth { min_bounces: 1, max_bounces: Some(4) };
        let dedicated = PathTracer { depth, heuristic, ..PathTracer::default() };
        let kernel = Bidirectional { techniques: general, depth, heuristic, ..Bidirectional::default() };
        let (mut scratch, mut sink) = (Scratch::default(), Vec::<Contribution>::new());
        film_samples(&camera, 2000, |film, sampler| {
            dedicated.sample(&world, &camera, film, sampler, &mut sink, &mut scratch);
            kernel.sample(&world, &camera, film, sampler, &mut sink, &mut scratch);
        });
        assert!(sink.len() > 20_000, "{}", sink.len());
        for contribution in &sink {
            assert!((contribution.weight - 0.5).abs() < 1e-9, "{heuristic:?}: {contribution:?}");
        }
    }
}

fn inside_sphere() -> PinholeCamera {
    PinholeCamera::new(v(0.2, 0.1, 0.0), DVec3::X, DVec3::Z, 60.0, UVec2::splat(8)).expect("valid camera")
}

/// Lens – diffuse – mirror – diffuse – light: unfolded at the mirror, the two diffuse vertices draw each other with the same density, so the balance
/// weights follow from positions alone. Any other treatment of the Dirac vertex fails here although its weights may sum to 1.
#[test]
fn f16_weights_across_a_mirror() {
    let mut room = Room::default();
    room.quad(v(-2.0, -2.0, 0.0), v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0), lambert(0.5, 0.5, 0.5));
    room.quad(v(2.0, -2.0, 0.0), v(0.0, 0.0, 3.0), v(0.0, 4.0, 0.0), Material::Mirror { reflectance: Rgb::WHITE });
    room.quad(v(-2.0, -2.0, 3.0), v(0.0, 4.0, 0.0), v(4.0, 0.0, 0.0), lambert(0.5, 0.5, 0.5));
    let lamp = room.quad(v(-1.5, -1.0, 0.5), v(0.0, 0.0, 1.0), v(0.3, 1.5, 0.0), BLACK);
    room.emit(lamp, Rgb::WHITE, true);
    let world = room.build();
    let camera = PinholeCamera::new(v(-1.0, 0.0, 1.5), v(0.8, 0.0, 0.0), DVec3::Z, 70.0, UVec2::splat(8)).expect("valid camera");
    let film_area = (2.0 * 35.0f64.to_radians().tan()).powi(2);
    let forward = (v(0.8, 0.0, 0.0) - v(-1.0, 0.0, 1.5)).normalize();
    let lamp_density = 1.0 / v(0.0, 0.0, 1.0).cross(v(0.3, 1.5, 0.0)).length();
    let depth = Depth::exactly(3);
    let integrator = Bidirectional { depth, heuristic: Heuristic::Balance, roulette: Roulette::NEVER, ..Bidirectional::default() };
    let mut seen = [0; 3];
    let mut scratch = Scratch::default();
    film_samples(&camera, 60_000, |film, sampler| {
        integrator.for_each_path(&world, &camera, film, sampler, &mut scratch, |path, contribution| {
            let record = path.record();
            if record.dirac != [false, false, true, false, false] {
                return;
            }
            let [x0, a, d, b, light] = [0, 1, 2, 3, 4].map(|i| record.points[i]);
            let (first, last) = (a.position - x0.position, light.position - b.position);
            let unfolded = a.position.distance(d.position) + d.position.distance(b.position);
            let cos = |x: &pathspace::geometry::SurfacePoint, w: DVec3| x.geometric_normal.dot(w.normalize()).abs();
            let across = FRAC_1_PI * cos(&a, d.position - a.position) * cos(&b, d.position - b.position) / unfolded.powi(2);
            let from_camera = cos(&a, first) / (film_area * first.normalize().dot(forward).powi(3) * first.length_squared());
            let g = cos(&b, last) * cos(&light, last) / last.length_squared();
            // The lamp emits on both sides: 1/(2π) per projected solid angle.
            let densities =
                [from_camera * across * FRAC_1_PI * g, from_camera * across * lamp_density, lamp_density * 0.5 * FRAC_1_PI * g * across];
            let index = match contribution.technique {
                Technique { s: 0, .. } => 0,
                Technique { s: 1, .. } => 1,
                Technique { t: 1, .. } => 2,
                other => panic!("{other:?} connects to a mirror"),
            };
            let expected = densities[index] / densities.iter().sum::<f64>();
            assert!((contribution.weight - expected).abs() < 1e-9, "{path:?}: {} instead of {expected}", contribution.weight);
            assert!((1..=5).filter(|&t| record.is_admissible(t)).count() == 3);
            seen[index] += 1;
        });
    });
    assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
}

/// Every path of a scene with glass, frosted glass, metal and smooth normals, against the definitions evaluated anew.
#[test]
fn paths_verify_on_every_material() {
    let sphere = Mesh::icosphere(1);
    let smooth = Mesh { normals: Some(sphere.positions.clone()), ..sphere };
    let metal = Material::RoughMirror { reflectance: Rgb::new(0.9, 0.8, 0.7), alpha: DVec2::new(0.2, 0.4) };
    let mirror = Material::Mirror { reflectance: Rgb::splat(0.9) };
    let mixture = Material::Mixture { components: Box::new([lambert(0.5, 0.5, 0.5), mirror]), weights: [0.6, 0.3] };
    let mut room = Room::closed_above(metal);
    room.lamp(0.5, 4.0);
    let ball = |x: f64, z: f64| DAffine3::from_scale_rotation_translation(DVec3::splat(0.3), glam::DQuat::IDENTITY, v(x, -0.2, z));
    room.mesh(&smooth, ball(-0.5, 1.2), lambert(0.7, 0.6, 0.5));
    room.mesh(&smooth, ball(0.5, 0.4), Material::Dielectric { relative_ior: 1.5 });
    room.sphere(Sphere::new(v(0.0, 0.4, 1.3), 0.3), Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(0.3) });
    room.sphere(Sphere::new(v(0.6, 0.4, 1.3), 0.2), mixture);
    let light = room.sphere(Sphere::new(v(-0.4, 0.5, 1.6), 0.1), BLACK);
    room.emit(light, Rgb::splat(5.0), false);
    room.light(pathspace::endpoint::PointLight::new(v(0.2, -0.3, 1.8), Rgb::splat(0.5)).expect("valid"));
    let (world, camera) = (room.build(), rooms::camera());
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0)] {
        let integrator = bidirectional(Depth::up_to(6), heuristic);
        let (mut scratch, mut seen, mut worst) = (Scratch::default(), 0, 0.0f64);
        film_samples(&camera, 4000, |film, sampler| {
            integrator.for_each_path(&world, &camera, film, sampler, &mut scratch, |path, contribution| {
                let verification = path.verify(&integrator.techniques, heuristic);
                assert!(verification.weight_sum_error < 1e-9, "{path:?} {verification:?}");
                // Directions recomputed from positions lose digits on short edges.
                assert!(verification.worst() < 1e-4, "{path:?} {contribution:?} {verification:?}");
                worst = worst.max(verification.worst());
                seen += 1;
            });
        });
        println!("{heuristic:?}: {seen} paths, worst error {worst:.1e}");
        assert!(seen > 10_000, "{seen}");
    }
}

fn rays_per_sample(integrator: &impl Integrator<World>, world: &World, camera: &PinholeCamera) -> f64 {
    let (mut scratch, mut sink) = (Scratch::default(), Vec::<Contribution>::new());
    film_samples(camera, 500, |film, sampler| {
        sink.clear();
        integrator.sample(world, camera, film, sampler, &mut sink, &mut scratch);
    });
    scratch.counters.rays() as f64 / scratch.counters.samples as f64
}

/// Rays per sample of paths with up to D edges in a closed scene without roulette. Nothing is culled inside a sphere that emits everywhere.
#[test]
fn f17_ray_counts() {
    let (world, camera) = (emissive_sphere(0.9), inside_sphere());
    let roulette = Roulette::NEVER;
    for edges in [2u32, 3, 5, 10, 20] {
        let (depth, d) = (Depth::up_to(edges - 1), f64::from(edges));
        let path = rays_per_sample(&PathTracer { depth, roulette, ..PathTracer::default() }, &world, &camera);
        assert_eq!(path, 2.0 * d - 1.0, "path tracing, D = {d}");
        // D - 1 rays of the walk and, of the D vertices, those that the film sees; the light's own vertex is (1, 1).
        let light = rays_per_sample(&LightTracer { depth, roulette }, &world, &camera);
        assert!(light > d - 1.0 && light < 2.0 * d - 1.0, "light tracing, D = {d}: {light}");
        // The bound counts a connection of every light vertex with the lens; (1, 1) is one more.
        let both = rays_per_sample(&Bidirectional { depth, roulette, ..Bidirectional::default() }, &world, &camera);
        let bound = d + (d - 1.0) + 2.0 * (d - 1.0) + 0.5 * (d - 1.0) * (d - 2.0);
        assert!(both <= bound + 1.0 && both > bound - d, "bidirectional, D = {d}: {both}, bound {bound}");
    }
}
