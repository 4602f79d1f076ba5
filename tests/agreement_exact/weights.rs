//! Weights and counts of single samples.

use crate::rooms::{self, Room, lambert, v};
use crate::{BLACK, assert_all, bidirectional, from_camera};
use glam::{DAffine3, DVec2, DVec3, UVec2};
use pathspace::endpoint::PinholeCamera;
use pathspace::film::{Contribution, FilmSample, Sample, Technique};
use pathspace::geometry::Sphere;
use pathspace::integrator::{
    Bidirectional, Caller, Depth, Integrator, LightTracer, PathTracer, Run, Stage,
};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, PathDensities, Roulette, Scratch, TechniqueSet, Weighting};
use pathspace::sampler::{Independent, SampleSource};
use pathspace::scene::{Material, Mesh, World};
use std::f64::consts::FRAC_1_PI;

/// Draws samples spread over the film, and calls `each` with their numbers' sampler.
fn film_samples(
    camera: &PinholeCamera,
    count: u32,
    mut each: impl FnMut(FilmSample, &mut <Independent as SampleSource>::Sampler),
) {
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
    let sphere = room.sphere(
        Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) },
        lambert(albedo, albedo, albedo),
    );
    room.emit(sphere, Rgb::WHITE, false);
    room.build()
}

/// Inside a sphere that emits everywhere, sampling its area and sampling the cosine are the same:
/// both weights are 1/2.
#[test]
fn f15_weights_in_an_emissive_sphere() {
    let (world, camera) = (emissive_sphere(0.9), inside_sphere());
    for (depth, expected) in [(Depth::up_to(1), 1.9), (Depth::up_to(2), 2.71)] {
        assert_all("F15", &world, &camera, &from_camera(depth), [expected; 3], 0.001);
    }
    let general = TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0)] {
        let depth = Depth { min_bounces: 1, max_bounces: Some(4) };
        let dedicated = PathTracer { depth, heuristic, ..PathTracer::default() };
        let kernel =
            Bidirectional { techniques: general, depth, heuristic, ..Bidirectional::default() };
        let (mut scratch, mut sink) = (Scratch::default(), Vec::<Contribution>::new());
        let stage = Stage::new(&world, &camera);
        let dedicated = dedicated.start(stage, &Caller).expect("a run");
        let kernel = kernel.start(stage, &Caller).expect("a run");
        film_samples(&camera, 2000, |film, sampler| {
            dedicated.sample(film, &mut *sampler, &mut sink, &mut scratch);
            kernel.sample(film, sampler, &mut sink, &mut scratch);
        });
        assert!(sink.len() > 20_000, "{}", sink.len());
        for contribution in &sink {
            assert!((contribution.weight - 0.5).abs() < 1e-9, "{heuristic:?}: {contribution:?}");
        }
    }
}

fn inside_sphere() -> PinholeCamera {
    PinholeCamera::new(v(0.2, 0.1, 0.0), DVec3::X, DVec3::Z, 60.0, UVec2::splat(8))
        .expect("valid camera")
}

/// Lens – diffuse – mirror – diffuse – light: unfolded at the mirror, the two diffuse vertices draw
/// each other with the same density, so the balance weights follow from positions alone. Any other
/// treatment of the Dirac vertex fails here although its weights may sum to 1.
#[test]
fn f16_weights_across_a_mirror() {
    let mut room = Room::default();
    room.quad(v(-2.0, -2.0, 0.0), v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0), lambert(0.5, 0.5, 0.5));
    room.quad(
        v(2.0, -2.0, 0.0),
        v(0.0, 0.0, 3.0),
        v(0.0, 4.0, 0.0),
        Material::Mirror { reflectance: Rgb::WHITE },
    );
    room.quad(v(-2.0, -2.0, 3.0), v(0.0, 4.0, 0.0), v(4.0, 0.0, 0.0), lambert(0.5, 0.5, 0.5));
    let lamp = room.quad(v(-1.5, -1.0, 0.5), v(0.0, 0.0, 1.0), v(0.3, 1.5, 0.0), BLACK);
    room.emit(lamp, Rgb::WHITE, true);
    let world = room.build();
    let camera =
        PinholeCamera::new(v(-1.0, 0.0, 1.5), v(0.8, 0.0, 0.0), DVec3::Z, 70.0, UVec2::splat(8))
            .expect("valid camera");
    let film_area = (2.0 * 35.0f64.to_radians().tan()).powi(2);
    let forward = (v(0.8, 0.0, 0.0) - v(-1.0, 0.0, 1.5)).normalize();
    let lamp_density = 1.0 / v(0.0, 0.0, 1.0).cross(v(0.3, 1.5, 0.0)).length();
    let depth = Depth::exactly(3);
    let integrator = Bidirectional {
        depth,
        heuristic: Heuristic::Balance,
        roulette: Roulette::NEVER,
        ..Bidirectional::default()
    };
    let mut seen = [0; 3];
    let mut scratch = Scratch::default();
    film_samples(&camera, 60_000, |film, sampler| {
        integrator.for_each_path(
            Stage::new(&world, &camera),
            Sample { film, sampler },
            &mut scratch,
            |path, contribution| {
                let record = path.record();
                if record.dirac != [false, false, true, false, false] {
                    return;
                }
                let [x0, a, d, b, light] = [0, 1, 2, 3, 4].map(|i| record.points[i]);
                let (first, last) = (a.position - x0.position, light.position - b.position);
                let unfolded = a.position.distance(d.position) + d.position.distance(b.position);
                let cos = |x: &pathspace::geometry::SurfacePoint, w: DVec3| {
                    x.geometric_normal.dot(w.normalize()).abs()
                };
                let across =
                    FRAC_1_PI * cos(&a, d.position - a.position) * cos(&b, d.position - b.position)
                        / unfolded.powi(2);
                let from_camera = cos(&a, first)
                    / (film_area * first.normalize().dot(forward).powi(3) * first.length_squared());
                let g = cos(&b, last) * cos(&light, last) / last.length_squared();
                // The lamp emits on both sides: 1/(2π) per projected solid angle.
                let densities = [
                    from_camera * across * FRAC_1_PI * g,
                    from_camera * across * lamp_density,
                    lamp_density * 0.5 * FRAC_1_PI * g * across,
                ];
                let index = match contribution.technique {
                    Technique { s: 0, .. } => 0,
                    Technique { s: 1, .. } => 1,
                    Technique { t: 1, .. } => 2,
                    other => panic!("{other:?} connects to a mirror"),
                };
                let expected = densities[index] / densities.iter().sum::<f64>();
                assert!(
                    (contribution.weight - expected).abs() < 1e-9,
                    "{path:?}: {} instead of {expected}",
                    contribution.weight
                );
                assert!(
                    (1..=5).filter(|&t| record.is_admissible(record.technique(t))).count() == 3
                );
                seen[index] += 1;
            },
        );
    });
    assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
}

/// Every path of a scene with glass, frosted glass, metal and smooth normals, against the
/// definitions evaluated anew.
#[test]
fn paths_verify_on_every_material() {
    let sphere = Mesh::icosphere(1);
    let smooth = Mesh { normals: Some(sphere.positions.clone()), ..sphere };
    let metal =
        Material::RoughMirror { reflectance: Rgb::new(0.9, 0.8, 0.7), alpha: DVec2::new(0.2, 0.4) };
    let mirror = Material::Mirror { reflectance: Rgb::splat(0.9) };
    let mixture = Material::Mixture {
        components: Box::new([lambert(0.5, 0.5, 0.5), mirror]),
        weights: [0.6, 0.3],
    };
    let mut room = Room::closed_above(metal);
    room.lamp(0.5, 4.0);
    let ball = |x: f64, z: f64| {
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.3),
            glam::DQuat::IDENTITY,
            v(x, -0.2, z),
        )
    };
    room.mesh(&smooth, ball(-0.5, 1.2), lambert(0.7, 0.6, 0.5));
    room.mesh(&smooth, ball(0.5, 0.4), Material::Dielectric { relative_ior: 1.5 });
    room.sphere(
        Sphere::new(v(0.0, 0.4, 1.3), 0.3),
        Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(0.3) },
    );
    room.sphere(Sphere::new(v(0.6, 0.4, 1.3), 0.2), mixture);
    let light = room.sphere(Sphere::new(v(-0.4, 0.5, 1.6), 0.1), BLACK);
    room.emit(light, Rgb::splat(5.0), false);
    room.light(
        pathspace::endpoint::PointLight::new(v(0.2, -0.3, 1.8), Rgb::splat(0.5)).expect("valid"),
    );
    let (world, camera) = (room.build(), rooms::camera());
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0)] {
        let integrator = bidirectional(Depth::up_to(6), heuristic);
        let (mut scratch, mut seen, mut worst) = (Scratch::default(), 0, 0.0f64);
        film_samples(&camera, 4000, |film, sampler| {
            integrator.for_each_path(
                Stage::new(&world, &camera),
                Sample { film, sampler },
                &mut scratch,
                |path, contribution| {
                    let verification =
                        path.verify(&Weighting::new(integrator.techniques, heuristic));
                    assert!(verification.weight_sum_error < 1e-9, "{path:?} {verification:?}");
                    // Directions recomputed from positions lose digits on short edges.
                    assert!(
                        verification.worst() < 1e-4,
                        "{path:?} {contribution:?} {verification:?}"
                    );
                    worst = worst.max(verification.worst());
                    seen += 1;
                },
            );
        });
        println!("{heuristic:?}: {seen} paths, worst error {worst:.1e}");
        assert!(seen > 10_000, "{seen}");
    }
}

fn rays_per_sample(
    integrator: &impl Integrator<World>,
    world: &World,
    camera: &PinholeCamera,
) -> f64 {
    let (mut scratch, mut sink) = (Scratch::default(), Vec::<Contribution>::new());
    let run = integrator.start(Stage::new(world, camera), &Caller).expect("a run");
    film_samples(camera, 500, |film, sampler| {
        sink.clear();
        run.sample(film, sampler, &mut sink, &mut scratch);
    });
    scratch.counters.rays() as f64 / scratch.counters.samples as f64
}

/// Rays per sample of paths with up to D edges in a closed scene without roulette. Nothing is
/// culled inside a sphere that emits everywhere.
#[test]
fn f17_ray_counts() {
    let (world, camera) = (emissive_sphere(0.9), inside_sphere());
    let roulette = Roulette::NEVER;
    for edges in [2u32, 3, 5, 10, 20] {
        let (depth, d) = (Depth::up_to(edges - 1), f64::from(edges));
        let path = rays_per_sample(
            &PathTracer { depth, roulette, ..PathTracer::default() },
            &world,
            &camera,
        );
        assert_eq!(path, 2.0 * d - 1.0, "path tracing, D = {d}");
        // D - 1 rays of the walk and, of the D vertices, those that the film sees; the light's own
        // vertex is (1, 1).
        let light = rays_per_sample(&LightTracer { depth, roulette }, &world, &camera);
        assert!(light > d - 1.0 && light < 2.0 * d - 1.0, "light tracing, D = {d}: {light}");
        // The bound counts a connection of every light vertex with the lens; (1, 1) is one more.
        let both = rays_per_sample(
            &Bidirectional { depth, roulette, ..Bidirectional::default() },
            &world,
            &camera,
        );
        let bound = d + (d - 1.0) + 2.0 * (d - 1.0) + 0.5 * (d - 1.0) * (d - 2.0);
        assert!(
            both <= bound + 1.0 && both > bound - d,
            "bidirectional, D = {d}: {both}, bound {bound}"
        );
    }
}
