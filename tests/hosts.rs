//! Integrators and scenes of a host's own: one lamp of two against path tracing without the other,
//! and a choice of light that depends wildly on the receiver.
#![allow(missing_docs, reason = "a test program")]

mod common;
#[path = "../examples/custom_integrator/one_light.rs"]
mod one_light;
#[path = "common/rooms.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod rooms;

use common::{Moments, Random};
use glam::{DVec2, DVec3};
use one_light::OneLight;
use pathspace::endpoint::{Camera, LightId};
use pathspace::film::{Contribution, FilmSample, Sample};
use pathspace::geometry::{Sphere, SurfacePoint};
use pathspace::integrator::{Bidirectional, Caller, Depth, Integrator, PathTracer, Run, Stage};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, Scratch, TechniqueSet, Weighting};
use pathspace::sampler::{SampleSource, Sampler, Stratified};
use pathspace::scene::{Material, Needs, Scene, World};
use rooms::{Room, camera, lambert, v};

/// A box with a lamp under its ceiling and another one beside it, of which some are lit.
fn two_lamps(lit: [bool; 2]) -> World {
    let mut room = Room::open(lambert(0.6, 0.5, 0.4));
    let spheres = [Sphere::new(v(-0.4, 0.2, 1.4), 0.2), Sphere::new(v(0.6, -0.3, 1.0), 0.15)];
    for (sphere, is_lit) in spheres.into_iter().zip(lit) {
        let lamp = room.sphere(sphere, Material::Black);
        if is_lit {
            room.emit(lamp, Rgb::new(4.0, 5.0, 6.0), false);
        }
    }
    room.build()
}

/// Moments of the luminance that a sample contributes to the film.
fn moments<S: Scene, I: Integrator<S>>(scene: &S, integrator: &I, samples: u32) -> Moments {
    let camera = camera();
    let run = integrator.start(Stage::new(scene, &camera), &Caller).expect("a run");
    let (mut random, mut scratch) = (Random::new(11), Scratch::default());
    let mut moments = Moments::default();
    for _ in 0..samples {
        let mut sum = 0.0;
        let mut add = |_: usize, c: &Contribution| sum += c.value.luminance() * c.weight;
        let film = film_sample(&camera, &mut random);
        run.sample(film, &mut random, &mut add, &mut scratch);
        moments.add(sum);
    }
    moments
}

fn film_sample(camera: &dyn Camera, random: &mut Random) -> FilmSample {
    FilmSample { raster: camera.film().from_window(random.next_2d()), offset: DVec2::ZERO }
}

/// The contributions of 5000 samples, each in the order of its techniques.
fn contributions<S: Scene, I: Integrator<S>>(scene: &S, integrator: &I) -> Vec<Contribution> {
    const SAMPLES: u32 = 5000;
    let (camera, source) = (camera(), Stratified { seed: 3, samples_per_pixel: SAMPLES });
    let run = integrator.start(Stage::new(scene, &camera), &Caller).expect("a run");
    let (mut scratch, mut all) = (Scratch::default(), Vec::new());
    for pass in 0..SAMPLES {
        let (mut sampler, from) = (source.sampler(0, pass), all.len());
        let raster = camera.film().from_window(sampler.next_2d());
        run.sample(FilmSample { raster, offset: DVec2::ZERO }, sampler, &mut all, &mut scratch);
        all[from..].sort_by_key(|found: &Contribution| found.technique);
    }
    all
}

/// Means within 4 standard errors, which are small enough for a bias of 1 % to be seen.
#[track_caller]
fn assert_same(name: &str, a: Moments, b: Moments) {
    let error = a.standard_error().hypot(b.standard_error());
    assert!((a.mean() - b.mean()).abs() <= 4.0 * error, "{name}: {a:?} {b:?}");
    assert!(error <= 0.0025 * b.mean(), "{name}: {error} of {}", b.mean());
}

#[test]
fn one_light_of_two_is_path_tracing_without_the_other() {
    let both = two_lamps([true, true]);
    for (light, lit) in [(0, [true, false]), (1, [false, true])] {
        let alone = two_lamps(lit);
        let depth = Depth { min_bounces: 1, max_bounces: Some(3) };
        let expected = moments(&alone, &PathTracer { depth, ..PathTracer::default() }, 1_200_000);
        let one = OneLight { light: LightId(light), max_bounces: 3 };
        assert_same(&format!("lamp {light}"), moments(&both, &one, 1_200_000), expected);
    }
}

/// A world whose choice of light to connect to is a function of the receiver's position that jumps
/// between 4 % and 96 % from one place to the next.
struct Fickle(World);

impl Fickle {
    /// Probability of the first light.
    fn first(receiver: &SurfacePoint) -> f64 {
        let x = (receiver.position * 917.0).dot(v(1.0, 3.7, 9.1)).sin() * 43_758.5;
        0.04 + 0.92 * (x - x.floor())
    }
}

impl Scene for Fickle {
    type Bsdf<'a> = <World as Scene>::Bsdf<'a>;
    type Light = <World as Scene>::Light;

    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        self.0.intersect(from, direction)
    }
    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        self.0.visible(a, b)
    }
    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_> {
        self.0.bsdf(x)
    }
    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        self.0.light_at(x)
    }
    fn light(&self, id: LightId) -> &Self::Light {
        self.0.light(id)
    }
    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        self.0.pick_light(u)
    }
    fn pick_pmf(&self, id: LightId) -> f64 {
        self.0.pick_pmf(id)
    }
    fn pick_light_for(&self, receiver: &SurfacePoint, u: f64) -> Option<(LightId, f64)> {
        let first = Self::first(receiver);
        Some(if u < first { (LightId(0), first) } else { (LightId(1), 1.0 - first) })
    }
    fn pick_pmf_for(&self, receiver: &SurfacePoint, id: LightId) -> f64 {
        let first = Self::first(receiver);
        if id == LightId(0) { first } else { 1.0 - first }
    }
    fn needs(&self) -> Needs {
        self.0.needs()
    }
}

/// Weights sum to one, those in constant time are those of the sweep and of the definitions, and no
/// integrator's mean notices.
#[test]
fn a_fickle_choice_of_light_is_in_every_weight() {
    let (scene, camera) = (Fickle(two_lamps([true, true])), camera());
    for heuristic in [Heuristic::Balance, Heuristic::Power(2.0)] {
        let both = Bidirectional { heuristic, ..Bidirectional::up_to(4) };
        let (mut random, mut scratch, mut paths) = (Random::new(5), Scratch::default(), 0);
        for _ in 0..2000 {
            let film = film_sample(&camera, &mut random);
            let sample = Sample { film, sampler: &mut random };
            both.for_each_path(Stage::new(&scene, &camera), sample, &mut scratch, |path, found| {
                let swept = path.weight(&Weighting::new(both.techniques, heuristic));
                assert!((found.weight - swept).abs() <= 1e-12, "{path:?} {found:?} {swept}");
                let verified = path.verify(&Weighting::new(both.techniques, heuristic));
                assert!(verified.weight_sum_error < 1e-12, "{path:?} {verified:?}");
                assert!(verified.worst() < 1e-7, "{path:?} {verified:?}");
                paths += 1;
            });
        }
        assert!(paths > 5_000, "{paths}");
    }
    // With numbers that depend on the sample and their purpose alone, path tracing draws the paths
    // that bidirectional path tracing draws by s = 0 and s = 1, and gives them the same weights.
    let techniques = TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };
    let general = Bidirectional { techniques, ..Bidirectional::up_to(4) };
    let [dedicated, general] =
        [contributions(&scene, &PathTracer::up_to(4)), contributions(&scene, &general)];
    assert!(dedicated.len() > 10_000 && dedicated.len() == general.len());
    for (a, b) in dedicated.iter().zip(&general) {
        assert_eq!(a.technique, b.technique);
        assert!((a.weight - b.weight).abs() <= 1e-9, "{a:?} {b:?}");
    }

    let plain = moments(&scene.0, &PathTracer::up_to(3), 2_000_000);
    assert_same("path tracing", moments(&scene, &PathTracer::up_to(3), 4_000_000), plain);
    assert_same("bidirectional", moments(&scene, &Bidirectional::up_to(3), 600_000), plain);
}
