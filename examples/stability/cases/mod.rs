//! The stress matrix: each case is a scene with an exact answer, pushed to an extreme.

mod energy;
mod film;
mod geometry;
mod lights;
mod materials;
mod normals;
mod photons;
mod placement;
mod stretched;

use crate::measure::Method::{self, Bidirectional, Emission, Light, Path};
use crate::scenes::{camera, cap_sphere, furnace_box, lambert, polygon_irradiance};
use pathspace::endpoint::{Camera, ConstantEnvironment};
use pathspace::glam::DVec3;
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::path::Roulette;
use pathspace::scene::World;
use std::f64::consts::PI;

/// A scene under stress.
pub struct Case {
    /// The row of the matrix.
    pub row: &'static str,
    /// The quantity that is pushed.
    pub family: &'static str,
    /// Its value; also the abscissa of a figure.
    pub value: f64,
    pub expected: [f64; 3],
    pub world: World,
    pub camera: Box<dyn Camera + Send>,
    pub depth: Depth,
    pub roulette: Roulette,
    /// The radius of merges.
    pub radius: f64,
    pub methods: &'static [Method],
    /// Integrators that must report exactly 0.
    pub blind: &'static [Method],
    /// Relative standard error that suffices.
    pub error: f64,
    /// The error of the answer, or the improbability of events that it contains and no sample may
    /// meet.
    pub tolerance: f64,
    pub twin: Option<Twin>,
}

/// The same scene without stress: with the same random numbers the images differ by a factor and by
/// rounding only.
pub struct Twin {
    pub world: World,
    pub camera: Box<dyn Camera + Send>,
    pub radius: f64,
    pub factor: f64,
}

/// Of merges, in scenes whose size is 1.
const RADIUS: f64 = 0.1;
const UNLIMITED: Depth = Depth { min_bounces: 0, max_bounces: None };
const ONE: Depth = Depth::exactly(1);
const WALKS: &[Method] = &[Emission, Path, Light, Bidirectional];
const FROM_CAMERA: &[Method] = &[Emission, Path, Bidirectional];
const CONNECTED: &[Method] = &[Path, Bidirectional];

impl Case {
    fn new(
        row: &'static str,
        family: &'static str,
        value: f64,
        expected: f64,
        world: World,
        camera: impl Camera + Send + 'static,
    ) -> Self {
        Self {
            row,
            family,
            value,
            expected: [expected; 3],
            world,
            camera: Box::new(camera),
            depth: UNLIMITED,
            roulette: Roulette::default(),
            radius: RADIUS,
            methods: WALKS,
            blind: &[],
            error: 0.005,
            tolerance: 1e-9,
            twin: None,
        }
    }

    fn by(self, methods: &'static [Method]) -> Self {
        Self { methods, ..self }
    }

    fn blind(self, blind: &'static [Method]) -> Self {
        Self { blind, ..self }
    }

    fn depth(self, depth: Depth) -> Self {
        Self { depth, ..self }
    }

    fn twin(self, world: World, camera: impl Camera + Send + 'static, factor: f64) -> Self {
        // The twin tells more than statistics can.
        let twin = Twin { world, camera: Box::new(camera), radius: RADIUS, factor };
        Self { twin: Some(twin), error: 0.02, ..self }
    }
}

fn sky() -> ConstantEnvironment {
    ConstantEnvironment::new(Rgb::WHITE).expect("valid")
}

/// The furnace of the box, seen from its middle.
fn boxed(
    row: &'static str,
    family: &'static str,
    value: f64,
    scale: f64,
    offset: DVec3,
    radiance: f64,
) -> Case {
    let at = |scale: f64, offset: DVec3, radiance: f64| {
        let world = furnace_box(offset, scale, &lambert(0.5), radiance);
        (
            world,
            camera(
                offset + DVec3::splat(0.5 * scale),
                offset + DVec3::new(1.0, 0.7, 0.4) * scale,
                80.0,
            ),
        )
    };
    let (world, eye) = at(scale, offset, radiance);
    let (twin, twin_eye) = at(1.0, DVec3::ZERO, 1.0);
    Case::new(row, family, value, 2.0 * radiance, world, eye).twin(twin, twin_eye, radiance)
}

fn capped(
    row: &'static str,
    family: &'static str,
    value: f64,
    scale: f64,
    offset: DVec3,
    radiance: f64,
) -> Case {
    let at = |scale: f64, offset: DVec3, radiance: f64| {
        (cap_sphere(offset, scale, 0.5, radiance), camera(offset, offset - DVec3::Z * scale, 53.0))
    };
    let (world, eye) = at(scale, offset, radiance);
    let (twin, twin_eye) = at(1.0, DVec3::ZERO, 1.0);
    let case = Case::new(row, family, value, 0.1 * radiance, world, eye);
    let case = case.by(&Method::SINGLE).twin(twin, twin_eye, radiance);
    Case { radius: RADIUS * scale, ..case }
}

fn lit_floor() -> f64 {
    let lamp =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 2.0));
    0.5 / PI * polygon_irradiance(DVec3::ZERO, DVec3::Z, &lamp)
}

/// Powers of ten.
fn decades(exponents: &'static [i32]) -> impl Iterator<Item = f64> {
    exponents.iter().map(|&e| 10f64.powi(e))
}

pub fn all() -> Vec<Case> {
    let mut cases = Vec::new();
    placement::placement(&mut cases);
    stretched::stretched(&mut cases);
    energy::energy(&mut cases);
    lights::lights(&mut cases);
    geometry::geometry(&mut cases);
    materials::materials(&mut cases);
    normals::normals(&mut cases);
    photons::photons(&mut cases);
    film::film(&mut cases);
    cases
}
