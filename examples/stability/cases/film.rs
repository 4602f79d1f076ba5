//! Cases that push the film, the lens and the numbers that paths take.

use super::{Case, ONE, WALKS};
use crate::measure::Method;
use crate::scenes::{
    Stage, camera, footprint_of, furnace_sphere, lambert, mean_over_square, polygon_irradiance,
    square_light,
};
use pathspace::endpoint::ThinLensCamera;
use pathspace::geometry::Sphere;
use pathspace::glam::{DVec3, UVec2};
use pathspace::integrator::Depth;
use pathspace::scene::Material;
use std::f64::consts::PI;

pub(super) fn film(cases: &mut Vec<Case>) {
    let lamp =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 2.0));
    let expected = mean_over_square(0.5, |x, y| {
        0.5 / PI * polygon_irradiance(DVec3::new(x, y, 0.0), DVec3::Z, &lamp)
    });
    for (min, max) in [([0, 0], [2, 2]), ([0, 0], [1, 2]), ([1, 1], [2, 2])] {
        // By symmetry every quarter has the mean of the whole.
        let share = f64::from((max[0] - min[0]) * (max[1] - min[1])) / 4.0;
        let eye = footprint_of(UVec2::splat(2), DVec3::ZERO, 1.0, 0.5)
            .with_window(min.into(), max.into())
            .expect("inside");
        let world = square_light(0.5, DVec3::ZERO, 1.0, 1.0);
        let case = Case::new("S32", "rendered share of the film", share, expected, world, eye);
        cases.push(Case { tolerance: 1e-5, error: 0.0075, ..case.by(&Method::SINGLE).depth(ONE) });
    }
    for height in [1.0, 0.0] {
        // A shade just before the lens, over the half y > 0 or all of it.
        let mut stage = Stage::default();
        let wall =
            stage.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, Material::Black);
        stage.glow(wall, 1.0);
        stage.quad(
            DVec3::new(1e-3, -0.5 * height, -0.5),
            DVec3::Y * (0.5 + 0.5 * height),
            DVec3::Z,
            Material::Black,
        );
        let eye = ThinLensCamera::new(DVec3::ZERO, DVec3::X, DVec3::Z, 40.0, 0.1, 0.5, UVec2::ONE)
            .expect("valid");
        let case = Case::new(
            "S34",
            "blocked share of the lens",
            0.5 + 0.5 * height,
            0.5,
            stage.build(),
            eye,
        )
        .depth(Depth::up_to(1));
        let case = Case { error: 0.0075, ..case };
        cases.push(if height > 0.0 {
            case.by(&[]).blind(&Method::SINGLE)
        } else {
            case.by(&Method::SINGLE)
        });
    }
    for bounces in 0..4 {
        let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(0.8), 1.0);
        let eye = camera(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 80.0);
        let case = Case::new(
            "S49",
            "number of bounces, alone",
            f64::from(bounces),
            0.8f64.powi(bounces),
            world,
            eye,
        );
        cases.push(case.by(&Method::SINGLE).depth(Depth::exactly(bounces as u32)));
    }
    let world = furnace_sphere(DVec3::ZERO, 1.0, &lambert(0.8), 1.0);
    let eye = camera(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1), 80.0);
    let from_two_to_three = Depth { min_bounces: 2, max_bounces: Some(3) };
    let case = Case::new("S49", "least number of bounces", 2.0, 0.64 + 0.512, world, eye);
    cases.push(case.by(WALKS).depth(from_two_to_three));
}
