//! Walks that hardly lose energy.

use super::{Case, FROM_CAMERA, WALKS};
use crate::measure::Method::{self, Emission, Light, Path};
use crate::scenes::{camera, furnace_sphere, lambert};
use pathspace::glam::DVec3;
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::path::Roulette;
use pathspace::scene::Material;

pub(super) fn energy(cases: &mut Vec<Case>) {
    let eye = || camera(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 80.0);
    for black in [1e-1, 1e-2, 1e-3] {
        let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(1.0 - black), 1.0);
        let methods: &[Method] = if black > 0.05 { WALKS } else { &[Emission, Light] };
        let error = if black < 0.005 { 0.03 } else { 0.01 };
        cases.push(Case {
            error,
            ..Case::new("S05", "1 - albedo", black, 1.0 / black, world, eye()).by(methods)
        });
    }
    for bounces in [10, 100, 1000] {
        let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(1.0), 1.0);
        let methods: &[Method] =
            if bounces > 10 { &[Emission, Path, Light] } else { &Method::SINGLE };
        let case = Case::new(
            "S06",
            "bounces at albedo 1",
            f64::from(bounces),
            f64::from(bounces) + 1.0,
            world,
            eye(),
        );
        cases.push(case.by(methods).depth(Depth::up_to(bounces)));
    }
    // Only the blue channel goes on: roulette must neither kill it by luminance nor couple the
    // channels.
    let wall = Material::Lambert { albedo: Rgb::new(0.0, 0.0, 0.9) };
    let world = furnace_sphere(DVec3::ZERO, 1.0, &wall, 1.0);
    let case = Case::new("S08", "albedo of one channel", 0.9, 1.0, world, eye());
    cases.push(Case {
        error: 0.02,
        expected: [1.0, 1.0, 10.0],
        roulette: Roulette { start: 0, ..Roulette::default() },
        ..case
    });
    let wall = Material::Mixture {
        components: Box::new([lambert(1.0), Material::Mirror { reflectance: Rgb::WHITE }]),
        weights: [0.4, 0.4],
    };
    let world = furnace_sphere(DVec3::ZERO, 1.0, &wall, 1.0);
    // Light tracing cannot see what the mirror shows.
    cases.push(
        Case::new("S37", "albedo of diffuse and mirror", 0.8, 5.0, world, eye()).by(FROM_CAMERA),
    );
}
