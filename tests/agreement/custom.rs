//! BSDFs of a user's own on the surfaces of a world.

use crate::rooms::{FILM, Room, camera, lambert, v};
use crate::team::{THREE, Team, grey};
use glam::{DAffine3, DVec2, DVec3};
use pathspace::bsdf::check::check;
use pathspace::bsdf::{Bsdf, BsdfSample, Lobes, TransportMode};
use pathspace::film::Image;
use pathspace::geometry::Frame;
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer, UniformArea};
use pathspace::math::warp::square_to_cosine_hemisphere;
use pathspace::math::{PerProjected, Rgb};
use pathspace::render::{Budget, Render, Settings};
use pathspace::sampler::{Independent, SampleSource};
use pathspace::scene::{Material, Mesh, Needs, Scene, World};
use std::f64::consts::{FRAC_1_PI, TAU};

/// A copy of [`pathspace::bsdf::Lambert`].
struct Diffuse(Rgb);

fn same_side(a: DVec3, b: DVec3) -> bool {
    a.z * b.z > 0.0
}

impl Bsdf for Diffuse {
    fn lobes(&self) -> Lobes {
        Lobes::DIFFUSE_REFLECTION
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        if same_side(to_light, to_camera) { self.0 * FRAC_1_PI } else { Rgb::BLACK }
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _: TransportMode) -> PerProjected {
        PerProjected(if same_side(fixed, next) { FRAC_1_PI } else { 0.0 })
    }

    fn sample(&self, fixed: DVec3, _: TransportMode, _: f64, u2: DVec2) -> Option<BsdfSample> {
        let mut next = square_to_cosine_hemisphere(u2);
        next.z = next.z.copysign(fixed.z);
        let pdf = PerProjected(FRAC_1_PI);
        same_side(fixed, next).then_some(BsdfSample {
            next,
            weight: self.0,
            pdf,
            pdf_reverse: pdf,
            dirac: false,
            relative_ior: 1.0,
        })
    }
}

/// A lobe of Phong's around the direction that light came from, normalised by the greater cosine
/// (Neumann, Neumann and Szirmay-Kalos 1999): `f = ρ (n+1)/(2π) cosⁿ(light, camera) / max(cos)`.
struct RetroReflector {
    color: Rgb,
    exponent: f64,
}

impl RetroReflector {
    /// Per solid angle; what it draws below the surface is absorbed.
    fn lobe(&self, a: DVec3, b: DVec3) -> f64 {
        if !same_side(a, b) {
            return 0.0;
        }
        (self.exponent + 1.0) / TAU * a.dot(b).max(0.0).powf(self.exponent)
    }
}

impl Bsdf for RetroReflector {
    fn lobes(&self) -> Lobes {
        Lobes::GLOSSY_REFLECTION
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.color * (self.lobe(to_light, to_camera) / to_light.z.abs().max(to_camera.z.abs()))
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _: TransportMode) -> PerProjected {
        PerProjected(self.lobe(fixed, next) / next.z.abs())
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, _: f64, u2: DVec2) -> Option<BsdfSample> {
        let cos = (1.0 - u2.x).powf(1.0 / (self.exponent + 1.0));
        let (sin, azimuth) = (((1.0 - cos) * (1.0 + cos)).sqrt(), TAU * u2.y);
        let around = DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
        let next = Frame::from_normal(fixed).to_world(around);
        let pdf = self.pdf(fixed, next, mode);
        (pdf.value() > 0.0).then(|| BsdfSample {
            next,
            weight: self.eval(next, fixed) / pdf.value(),
            pdf,
            pdf_reverse: self.pdf(next, fixed, mode.reversed()),
            dirac: false,
            relative_ior: 1.0,
        })
    }
}

/// A mirror in which everyone sees himself, as a corner reflector: all in its list of images.
struct CornerReflector(Rgb);

impl Bsdf for CornerReflector {
    fn lobes(&self) -> Lobes {
        Lobes::DIRAC_REFLECTION
    }

    fn dirac_images(&self, fixed: DVec3, _: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        image(BsdfSample::of_dirac(fixed, self.0, 1.0));
    }
}

fn retro_reflector() -> RetroReflector {
    RetroReflector { color: Rgb::new(0.9, 0.6, 0.7), exponent: 12.0 }
}

/// A closed room with a ball, a mesh with smooth normals, of a material.
fn room(ball: Material) -> Room {
    let mut room = Room::closed_above(grey());
    let mut mesh = Mesh::icosphere(2);
    mesh.normals = Some(mesh.positions.clone());
    let place =
        DAffine3::from_translation(v(0.3, -0.4, 1.0)) * DAffine3::from_scale(v(0.4, 0.4, 0.4));
    room.mesh(&mesh, place, ball);
    room
}

#[test]
fn a_custom_lambert_is_the_built_in_one_to_the_bit() {
    fn image(world: &World, integrator: &dyn Render<World>) -> Image {
        let settings = Settings { budget: Budget::Samples(4), ..Settings::default() };
        integrator.render(world, &camera(), &settings).expect("valid").image
    }
    let build = |ball: Material| {
        let mut room = room(ball);
        room.lamp(0.5, 4.0);
        room.build()
    };
    let albedo = Rgb::new(0.3, 0.8, 0.5);
    let own = build(Material::custom(Diffuse(albedo)));
    let built_in = build(Material::Lambert { albedo });
    assert_eq!(own.needs(), built_in.needs());
    let integrators: [&dyn Render<World>; 4] = [
        &PathTracer::up_to(3),
        &LightTracer::up_to(3),
        &UniformArea::up_to(3),
        &Bidirectional::up_to(3),
    ];
    for integrator in integrators {
        let pair = [image(&own, integrator), image(&built_in, integrator)];
        assert_eq!(pair[0].pixels().len(), (FILM.x * FILM.y) as usize);
        assert!(pair[0] == pair[1]);
    }
}

#[test]
fn custom_bsdfs_pass_the_check() {
    let bsdfs: [&dyn Bsdf; 3] =
        [&Diffuse(Rgb::splat(0.7)), &retro_reflector(), &CornerReflector(Rgb::splat(0.8))];
    let directions = [0.95, 0.6, 0.2].map(|z: f64| v((1.0 - z * z).sqrt(), 0.0, z));
    let cases = bsdfs.len() * directions.len() * 4;
    for (k, bsdf) in bsdfs.into_iter().enumerate() {
        for fixed in directions.into_iter().flat_map(|w| [w, -w]) {
            for mode in [TransportMode::Radiance, TransportMode::Importance] {
                let mut sampler = Independent { seed: k as u64 }.sampler(3, 0);
                let report = check(bsdf, fixed, mode, &mut sampler, 20_000);
                assert_eq!(report.verdict(0.01, cases), Ok(()), "{k} at {fixed}: {report:?}");
            }
        }
    }
}

/// Errors of 0.1 %: four standard errors of a difference are 0.5 %, half of a bias of 1 %.
#[test]
fn integrators_agree_on_a_custom_glossy_mesh() {
    let mut room = room(Material::custom(retro_reflector()));
    room.lamp(0.5, 4.0);
    Team::with_light(THREE).agree_within(0.001, "custom glossy", room);
}

#[test]
fn integrators_agree_on_a_custom_dirac_mesh() {
    let mut room = room(Material::custom(CornerReflector(Rgb::new(0.9, 0.6, 0.7))));
    room.lamp(0.5, 4.0);
    Team::standard(Depth::up_to(4)).balance().agree("custom Dirac", room);
}

/// The lobes that a BSDF says it has are what the world needs.
#[test]
fn needs_follow_from_the_lobes() {
    let needs = |ball: Material| {
        let mut room = room(ball);
        room.lamp(0.5, 4.0);
        room.build().needs()
    };
    let plain = needs(lambert(0.5, 0.5, 0.5));
    assert_eq!(needs(Material::custom(Diffuse(Rgb::WHITE))), plain);
    assert_eq!(needs(Material::custom(retro_reflector())), plain | Needs::GLOSSY_LOBES);
    assert_eq!(needs(Material::custom(CornerReflector(Rgb::WHITE))), plain | Needs::DIRAC_LOBES);
}
