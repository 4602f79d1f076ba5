//! Lanes and the open traits give the same films: a scene whose BSDFs say nothing of their forms is
//! shaded one vertex at a time.
#![allow(missing_docs, reason = "a test program")]

use glam::{DVec2, DVec3, UVec2};
use pathspace::bsdf::{Bsdf, BsdfSample, DiracValue, Lobes, TransportMode};
use pathspace::endpoint::{AnyLight, LightId};
use pathspace::gallery::{self, GalleryScene};
use pathspace::geometry::SurfacePoint;
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer};
use pathspace::light_tree::LightTree;
use pathspace::math::{PerProjected, Rgb};
use pathspace::path::Heuristic;
use pathspace::render::{Budget, Render, Settings, unattended};
use pathspace::scene::{Needs, Scene, World};

/// A world without forms.
struct Formless<'a>(&'a World);

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
    fn needs(&self) -> Needs {
        self.0.needs()
    }
}

/// The sums of a film, as bits.
fn film<S: Scene>(
    scene: &S,
    of: &GalleryScene,
    integrator: &impl Render<S>,
) -> Result<Vec<[u64; 3]>, Box<dyn std::error::Error>> {
    let settings = Settings { budget: Budget::Samples(16), seed: 3, ..Settings::default() };
    let rendering = integrator.render(scene, &*of.camera, &settings, &mut unattended)?;
    Ok(rendering.film.sums().iter().map(|sum| sum.0.map(f64::to_bits)).collect())
}

#[test]
fn films_are_those_of_the_open_traits() -> Result<(), Box<dyn std::error::Error>> {
    for name in gallery::NAMES {
        let scene = gallery::build(name, UVec2::splat(24))?;
        let depth = Depth { max_bounces: scene.max_bounces, ..Depth::default() };
        let formless = Formless(&scene.world);
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
