//! Lanes and the open traits give the same films: a scene whose BSDFs say nothing of their forms is
//! shaded one vertex at a time.
#![allow(missing_docs, reason = "a test program")]

#[path = "common/rooms.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod rooms;

use glam::{DAffine3, DVec2, DVec3, UVec2};
use pathspace::bsdf::{Bsdf, BsdfSample, DiracValue, Lobes, TransportMode};
use pathspace::endpoint::{AnyLight, Camera, ConstantEnvironment, LightId, PointLight};
use pathspace::film::Filter;
use pathspace::gallery::{self, GalleryScene};
use pathspace::geometry::{Sphere, SurfacePoint};
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer, PathTracing};
use pathspace::light_tree::LightTree;
use pathspace::math::{PerProjected, Rgb};
use pathspace::path::{Counters, Heuristic, Roulette, Survival};
use pathspace::render::{Budget, Render, Settings};
use pathspace::sampler::SamplerKind;
use pathspace::scene::{FlatSurfaces, Material, Mesh, Needs, Scene, World};
use rooms::{Room, lambert, v};
use std::error::Error;

/// A world without forms, which may hand on flat surfaces.
struct Formless<'a>(&'a World, Option<FlatSurfaces<'a>>);

/// A BSDF without a form.
struct Plain<B>(B);

impl<B: Bsdf> Bsdf for Plain<B> {
    fn lobes(&self) -> Lobes {
        self.0.lobes()
    }
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.0.eval(to_light, to_camera)
    }
    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        self.0.pdf(fixed, next, mode)
    }
    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        self.0.sample(fixed, mode, u1, u2)
    }
    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        self.0.dirac_images(fixed, mode, image);
    }
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        self.0.eval_dirac(to_light, to_camera)
    }
    fn is_anisotropic(&self) -> bool {
        self.0.is_anisotropic()
    }
}

impl Scene for Formless<'_> {
    type Bsdf<'a>
        = Plain<<World as Scene>::Bsdf<'a>>
    where
        Self: 'a;
    type Light = AnyLight;

    fn intersect(&self, from: &SurfacePoint, direction: DVec3) -> Option<SurfacePoint> {
        self.0.intersect(from, direction)
    }
    fn visible(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        self.0.visible(a, b)
    }
    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_> {
        Plain(self.0.bsdf(x))
    }
    fn light_at(&self, x: &SurfacePoint) -> Option<LightId> {
        self.0.light_at(x)
    }
    fn environment(&self) -> Option<LightId> {
        self.0.environment()
    }
    fn light(&self, id: LightId) -> &AnyLight {
        self.0.light(id)
    }
    fn pick_light(&self, u: f64) -> Option<(LightId, f64)> {
        self.0.pick_light(u)
    }
    fn pick_pmf(&self, id: LightId) -> f64 {
        self.0.pick_pmf(id)
    }
    fn pick_light_for(&self, receiver: &SurfacePoint, u: f64) -> Option<(LightId, f64)> {
        self.0.pick_light_for(receiver, u)
    }
    fn pick_pmf_for(&self, receiver: &SurfacePoint, id: LightId) -> f64 {
        self.0.pick_pmf_for(receiver, id)
    }
    fn light_tree(&self) -> Option<&LightTree> {
        self.0.light_tree()
    }
    fn flat_surfaces(&self) -> Option<FlatSurfaces<'_>> {
        self.1
    }
    fn needs(&self) -> Needs {
        self.0.needs()
    }
}

/// The sums of a film, as bits.
type Sums = Vec<[u64; 3]>;

fn film<S: Scene>(
    scene: &S,
    of: &GalleryScene,
    integrator: &impl Render<S>,
) -> Result<Sums, Box<dyn Error>> {
    let settings = Settings { budget: Budget::Samples(16), seed: 3, ..Settings::default() };
    let rendering = integrator.render(scene, &*of.camera, &settings)?;
    Ok(rendering.film.sums().map(|sum| sum.0.map(f64::to_bits)).collect())
}

#[test]
fn films_are_those_of_the_open_traits() -> Result<(), Box<dyn Error>> {
    for name in gallery::NAMES {
        let scene = gallery::build(name, UVec2::splat(24))?;
        let depth = Depth { max_bounces: scene.max_bounces, ..Depth::default() };
        let formless = Formless(&scene.world, None);
        let path = PathTracer { depth, ..PathTracer::default() };
        let light = LightTracer { depth, ..LightTracer::default() };
        assert_eq!(film(&scene.world, &scene, &path)?, film(&formless, &scene, &path)?, "{name}");
        assert_eq!(film(&scene.world, &scene, &light)?, film(&formless, &scene, &light)?, "{name}");
        for heuristic in [Heuristic::default(), Heuristic::Balance] {
            let both = Bidirectional { depth, heuristic, ..Bidirectional::default() };
            let found = film(&scene.world, &scene, &both)?;
            assert_eq!(found, film(&formless, &scene, &both)?, "{name}, {heuristic:?}");
        }
    }
    Ok(())
}

/// A box that is open below, its faces two triangles each with texture coordinates, and with vertex
/// normals that are those of the faces up to single precision if `has_normals`.
fn tent(has_normals: bool) -> Mesh {
    let (mut mesh, mut normals, mut uvs) = (Mesh::default(), Vec::new(), Vec::new());
    for (n, u) in [(v(0.0, 0.0, 1.0), DVec3::X), (v(1.0, 0.0, 0.3), DVec3::Y)] {
        for side in [1.0, -1.0] {
            let n = (n * v(side, side, 1.0)).normalize();
            let w = n.cross(u);
            let first = mesh.positions.len() as u32;
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                mesh.positions.push(n + u * x + w * y);
                normals.push(n.as_vec3().as_dvec3());
                uvs.push(DVec2::new(x, 0.5 * y));
            }
            mesh.indices.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i: u32| first + i)));
        }
    }
    mesh.uvs = Some(uvs);
    mesh.normals = has_normals.then_some(normals);
    mesh
}

/// Worlds in which walks come into columns and leave them.
fn worlds() -> Vec<(&'static str, World)> {
    let at = |x, y, z| {
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.2),
            glam::DQuat::from_rotation_z(0.7),
            v(x, y, z),
        )
    };
    let mut lamp = Room::closed_above(lambert(0.5, 0.6, 0.7));
    lamp.lamp(0.4, 9.0);
    lamp.mesh(&tent(false), at(0.4, 0.2, 0.3), lambert(0.8, 0.3, 0.2));
    let mut many = Room::closed_above(lambert(0.5, 0.6, 0.7));
    many.lamp(0.4, 9.0);
    let second = many.quad(v(-0.9, 0.9, 0.3), DVec3::Z, v(0.2, 0.0, 0.0), Material::Black);
    many.emit(second, Rgb::new(1.0, 2.0, 5.0), false);
    many.light(PointLight::new(v(0.5, -0.5, 1.5), Rgb::splat(0.4)).unwrap());
    many.sphere(Sphere::new(v(0.4, 0.3, 0.3), 0.3), Material::Mirror { reflectance: Rgb::WHITE });
    many.sphere(Sphere::new(v(-0.6, 0.5, 0.2), 0.2), lambert(0.3, 0.9, 0.4));
    let mut sky = Room::open(lambert(0.5, 0.4, 0.3));
    sky.environment(ConstantEnvironment::new(Rgb::new(0.5, 0.6, 0.9)).unwrap());
    sky.mesh(&tent(true), at(0.4, 0.2, 0.3), lambert(0.8, 0.3, 0.2));
    // More primitives than a world keeps prepared, flat ones and smooth ones.
    let mut large = Room::closed_above(lambert(0.5, 0.6, 0.7));
    large.lamp(0.02, 4000.0);
    let mut ball = Mesh::icosphere(2);
    large.mesh(&ball, at(0.4, 0.2, 0.3), lambert(0.8, 0.3, 0.2));
    ball.normals = Some(ball.positions.clone());
    large.mesh(&ball, at(-0.5, 0.4, 0.3), lambert(0.3, 0.8, 0.2));
    [("lamp", lamp), ("many", many), ("sky", sky), ("large", large)]
        .map(|(name, room)| (name, room.build()))
        .into()
}

/// The sums of a film, and the counters.
fn drawn<S: Scene>(
    scene: &S,
    camera: &dyn Camera,
    integrator: &impl Render<S>,
    sampler: SamplerKind,
) -> Result<(Sums, Counters), Box<dyn Error>> {
    let filter = Filter::Gaussian { standard_deviation: 0.5 };
    let settings =
        Settings { budget: Budget::Samples(8), seed: 5, filter, sampler, ..Settings::default() };
    let rendering = integrator.render(scene, camera, &settings)?;
    let sums = rendering.film.sums().map(|sum| sum.0.map(f64::to_bits)).collect();
    Ok((sums, rendering.counters))
}

/// Films to the bit, all counts, and the ledger but for the order of its sums.
#[track_caller]
fn assert_equal(name: &str, a: (Sums, Counters), b: (Sums, Counters)) {
    assert!(a.0 == b.0, "{name}: films differ");
    let ledgers = [a.1.ledger, b.1.ledger];
    let [a, b] = [a.1, b.1].map(|counters| Counters { ledger: Default::default(), ..counters });
    assert_eq!(a, b, "{name}");
    let [a, b] = ledgers.map(|l| [l.emitted, l.absorbed, l.escaped, l.truncated, l.rejected]);
    for (a, b) in a.iter().zip(b) {
        assert!((*a - b).0.iter().all(|d| d.abs() <= 1e-9 * ledgers[0].emitted.mean()), "{name}");
    }
}

#[test]
fn odd_worlds_are_those_of_the_open_traits() -> Result<(), Box<dyn Error>> {
    let cameras: [(&str, &dyn Camera); 3] = [
        ("pinhole", &rooms::camera()),
        ("lens", &rooms::lens_camera()),
        ("parallel", &rooms::parallel_camera()),
    ];
    let depths = [
        Depth::default(),
        Depth::up_to(0),
        Depth::up_to(2),
        Depth { min_bounces: 2, max_bounces: Some(3) },
    ];
    let roulettes = [
        Roulette { start: 0, ..Roulette::default() },
        Roulette { survival: Survival::Fixed(0.7), ..Roulette::default() },
        Roulette { constant: Rgb::new(0.1, 0.2, 0.3), start: 1, ..Roulette::default() },
    ];
    let modes = [
        (PathTracing::Both, Heuristic::Balance),
        (PathTracing::Both, Heuristic::Power(1.5)),
        (PathTracing::EmissionOnly, Heuristic::default()),
        (PathTracing::NextEventOnly, Heuristic::default()),
    ];
    for (name, world) in worlds() {
        let formless = Formless(&world, None);
        let handing_on = Formless(&world, world.flat_surfaces());
        for (camera_name, camera) in cameras {
            let choices =
                depths.into_iter().flat_map(|d| roulettes.into_iter().map(move |r| (d, r)));
            for (i, (depth, roulette)) in choices.enumerate() {
                let name = format!("{name}, {camera_name}, {i}");
                let sampler = [SamplerKind::Independent, SamplerKind::Sobol][i % 2];
                let light = LightTracer { depth, roulette };
                let found = drawn(&world, camera, &light, sampler)?;
                let handed_on = drawn(&handing_on, camera, &light, sampler)?;
                assert_equal(&name, handed_on, drawn(&formless, camera, &light, sampler)?);
                assert_equal(&name, found, drawn(&formless, camera, &light, sampler)?);
                let heuristic = modes[i % 2].1;
                let both = Bidirectional { depth, roulette, heuristic, ..Bidirectional::default() };
                let found = drawn(&world, camera, &both, sampler)?;
                assert_equal(&name, found, drawn(&formless, camera, &both, sampler)?);
                for (mode, heuristic) in modes {
                    let path = PathTracer { mode, depth, roulette, heuristic };
                    let found = drawn(&world, camera, &path, sampler)?;
                    let name = format!("{name}, {mode:?}, {heuristic:?}");
                    assert_equal(&name, found, drawn(&formless, camera, &path, sampler)?);
                }
            }
        }
    }
    Ok(())
}
