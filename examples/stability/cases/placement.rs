//! Scale, place and brightness.

use super::{Case, FROM_CAMERA, ONE, boxed, capped, decades, lit_floor, sky};
use crate::scenes::{Stage, camera, lambert, square_light};
use pathspace::geometry::Sphere;
use pathspace::glam::DVec3;

pub(super) fn placement(cases: &mut Vec<Case>) {
    for scale in decades(&[-45, -30, -6, -3, 0, 3, 6, 30, 45]) {
        cases.push(boxed("S01", "scene scale, box", scale, scale, DVec3::ZERO, 1.0));
        cases.push(capped("S01", "scene scale, sphere", scale, scale, DVec3::ZERO, 1.0));
    }
    for offset in decades(&[1, 3, 6, 9]) {
        let by = DVec3::new(offset, -0.7 * offset, 0.3 * offset);
        cases.push(boxed("S02", "world offset, box", offset, 1.0, by, 1.0));
        cases.push(capped("S02", "world offset, sphere", offset, 1.0, by, 1.0));
    }
    for distance in decades(&[1, 2, 4, 6, 8]) {
        let eye = DVec3::new(0.8, 0.1, 0.4).normalize() * distance;
        let world = square_light(0.5, DVec3::ZERO, 1.0, 1.0);
        let eye = camera(eye, DVec3::ZERO, 2.0 * (1e-3 / distance).atan().to_degrees());
        cases.push(
            Case::new("S03", "camera distance", distance, lit_floor(), world, eye)
                .by(FROM_CAMERA)
                .depth(ONE),
        );
    }
    for radiance in decades(&[-150, -30, -6, 0, 6, 30, 150]) {
        cases.push(boxed("S04", "radiance", radiance, 1.0, DVec3::ZERO, radiance));
    }
    for scale in decades(&[-6, 0, 6]) {
        let at = |scale: f64| {
            let mut stage = Stage::default();
            stage.sphere(Sphere::new(DVec3::ZERO, scale), lambert(0.6));
            stage.environment(sky());
            (stage.build(), camera(DVec3::Z * 3.0 * scale, DVec3::ZERO, 20.0))
        };
        let ((world, eye), (twin, twin_eye)) = (at(scale), at(1.0));
        cases.push(
            Case::new("S30", "scale under an environment", scale, 0.6, world, eye)
                .twin(twin, twin_eye, 1.0),
        );
    }
}
