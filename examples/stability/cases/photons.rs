//! Photons that are far apart, grazing, or on the other side of something.

use super::{Case, ONE, capped, decades};
use crate::measure::Method::{self, Light, Merging, PhotonMap};
use crate::scenes::{Beam, Stage, camera, cap_sphere, footprint, lambert};
use pathspace::endpoint::DirectionalLight;
use pathspace::glam::DVec3;
use pathspace::math::Rgb;
use pathspace::scene::Material;
use std::f64::consts::PI;

pub(super) fn photons(cases: &mut Vec<Case>) {
    for cosine in decades(&[-12, -9, -6, -3, 0]) {
        let mut stage = Stage::default();
        stage.square(0.0, 2.0, true, lambert(0.5));
        stage.light(Beam::onto_floor(1.0, cosine, 1.0 / cosine));
        let eye = footprint(DVec3::ZERO, 1.0, 0.5);
        let case = Case::new("S43", "cosine of a beam", cosine, 0.5 / PI, stage.build(), eye);
        cases.push(Case { error: 0.01, ..case.by(&[Light, PhotonMap, Merging]).depth(ONE) });
    }
    for (radius, methods) in [
        (1e-300, &[Merging][..]),
        (1e-12, &[Merging]),
        (1e-3, &[Merging]),
        (0.05, &Method::SHARED[..2]),
        (0.1, &Method::SHARED[..2]),
    ] {
        let world = cap_sphere(DVec3::ZERO, 1.0, 0.5, 1.0);
        let eye = camera(DVec3::ZERO, DVec3::NEG_Z, 53.0);
        let case = Case::new("S53", "radius of merges", radius, 0.1, world, eye).by(methods);
        // Of the light that has scattered r²/8 is below the horizons of other photons.
        let case = Case { radius, tolerance: 1e-3, error: 0.0075, ..case };
        cases.push(if radius < 1e-3 { case.blind(&[PhotonMap]) } else { case });
    }
    for distance in decades(&[-6, -1]) {
        // Two walls that face each other nearer than the radius reaches.
        let (radius, mut stage) = (0.3, Stage::default());
        let gap = distance * radius;
        for (z, up) in [(0.0, true), (gap, false)] {
            let wall = stage.square(z, 1.0, up, lambert(0.5));
            stage.glow(wall, 1.0);
        }
        let eye = footprint(DVec3::ZERO, 0.5 * gap, gap);
        let case =
            Case::new("S42", "distance of walls, in radii", distance, 2.0, stage.build(), eye);
        cases.push(Case { radius, error: 0.01, ..case.by(&[PhotonMap, Merging]) });
    }
    for gap in decades(&[-12, -9]) {
        // The shaded face of a wall.
        let mut stage = Stage::default();
        stage.square(0.0, 1.0, true, lambert(0.5));
        stage.square(-gap, 1.0, false, lambert(0.5));
        let lamp = stage.square(2.0, 1.0, false, Material::Black);
        stage.glow(lamp, 1.0);
        let eye = camera(DVec3::NEG_Z * 0.5, DVec3::ZERO, 40.0);
        let case = Case::new("S55", "thickness of a wall", gap, 0.0, stage.build(), eye);
        cases.push(case.by(&[]).blind(&Method::ALL));
    }
    for distance in [1e-9, 0.5, 2.0] {
        // Two veils, half of each white on both sides, under parallel light. Of each one's photons
        // the disc around a point of the other has the share (r² - d²)/r².
        let (radius, mut stage) = (0.1, Stage::default());
        for z in [0.0, -distance * radius] {
            let components = Box::new([lambert(1.0), Material::Null]);
            stage.square(z, 1.0, true, Material::Mixture { components, weights: [0.5, 0.5] });
        }
        stage.light(DirectionalLight::new(DVec3::NEG_Z, Rgb::WHITE).expect("valid"));
        let share = (1.0 - distance * distance).max(0.0);
        let [upper, lower] = [1.0, 0.5 / (1.0 - 0.25)];
        let seen = 0.5 * (upper + share * lower) + 0.5 * 0.5 * (lower + share * upper);
        let eye = footprint(DVec3::ZERO, 1.0, 0.2);
        let case = Case::new(
            "S55",
            "distance of veils, in radii",
            distance,
            seen / PI,
            stage.build(),
            eye,
        );
        cases.push(Case { radius, error: 0.01, ..case.by(&[PhotonMap]) });
    }
    for scale in decades(&[-6, -3, 3, 6]) {
        let case = capped("S56", "scale of shared walks", scale, scale, DVec3::ZERO, 1.0);
        cases.push(case.by(&Method::SHARED));
    }
    for offset in decades(&[3, 6]) {
        let by = DVec3::new(offset, -0.7 * offset, 0.3 * offset);
        let case = capped("S56", "offset of shared walks", offset, 1.0, by, 1.0);
        cases.push(case.by(&Method::SHARED));
    }
}
