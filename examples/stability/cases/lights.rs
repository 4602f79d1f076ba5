//! Lights that are tiny, huge, close, far or of no use.

use super::{CONNECTED, Case, FROM_CAMERA, ONE, decades, lit_floor, sky};
use crate::measure::Method::{Bidirectional, Emission, Light, Path, UniformArea};
use crate::scenes::{Stage, footprint, lambert, polygon_irradiance};
use pathspace::endpoint::{DirectionalLight, EnvironmentMap};
use pathspace::geometry::Sphere;
use pathspace::glam::DVec3;
use pathspace::math::Rgb;
use pathspace::scene::Material;
use std::f64::consts::PI;

pub(super) fn lights(cases: &mut Vec<Case>) {
    let floor_and = |radius: f64, distance: f64, radiance: f64| {
        let mut stage = Stage::default();
        stage.square(0.0, 1e-3 * distance, true, lambert(1.0));
        let sphere = stage.sphere(Sphere::new(DVec3::Z * distance, radius), Material::Black);
        stage.glow(sphere, radiance);
        stage.build()
    };
    for ratio in decades(&[-12, -9, -6, -3, -1]) {
        let world = floor_and(ratio, 1.0, 1.0 / (ratio * ratio));
        let eye = footprint(DVec3::ZERO, 0.5, 1e-6);
        cases.push(
            Case::new("S09", "radius / distance of a sphere light", ratio, 1.0, world, eye)
                .by(CONNECTED)
                .depth(ONE),
        );
    }
    for gap in decades(&[-12, -9, -6, -3, -1]) {
        let mut stage = Stage::default();
        stage.square(0.0, 1e-3, true, lambert(1.0));
        let sphere = stage.sphere(Sphere::new(DVec3::Z * (1.0 + gap), 1.0), Material::Black);
        stage.glow(sphere, 1.0);
        let eye = footprint(DVec3::ZERO, 0.5 * gap, 1e-3 * gap);
        let expected = 1.0 / (1.0 + gap).powi(2);
        cases.push(
            Case::new("S10", "gap before a sphere light", gap, expected, stage.build(), eye)
                .by(CONNECTED)
                .depth(ONE),
        );
    }
    for half in decades(&[-6, -4, -2, 2, 4]) {
        let mut stage = Stage::default();
        stage.square(0.0, 0.1, true, lambert(1.0));
        let lamp = stage.square(1.0, half, false, Material::Black);
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]]
            .map(|[x, y]| DVec3::new(x, y, 1.0));
        let irradiance = polygon_irradiance(DVec3::ZERO, DVec3::Z, &corners);
        stage.glow(lamp, PI / irradiance);
        let eye = footprint(DVec3::ZERO, 0.5, 1e-6);
        cases.push(
            Case::new("S40", "size of a square light", half, 1.0, stage.build(), eye)
                .by(CONNECTED)
                .depth(ONE),
        );
    }
    for ratio in decades(&[2, 4, 6]) {
        let mut stage = Stage::default();
        stage.square(0.0, 0.5, true, lambert(0.5));
        let lamp = stage.square(2.0, 1.0, false, Material::Black);
        stage.glow(lamp, 1.0);
        // Shines upwards, into nothing.
        let strong = stage.square(3.0, 1.0, true, Material::Black);
        stage.glow(strong, ratio);
        let eye = footprint(DVec3::ZERO, 1.0, 1e-4);
        let case =
            Case::new("S31", "power of a useless light", ratio, lit_floor(), stage.build(), eye);
        cases.push(case.by(FROM_CAMERA).depth(ONE));
    }
    for hot in decades(&[0, 6, 12]) {
        // Row 5 of 64: ∫ cos dσ / π over one of its 128 pixels is half the difference of cos² over
        // 64.
        let pixel = |i: u32| Rgb::splat(if (i / 128, i % 128) == (5, 17) { hot } else { 1.0 });
        let row = |i: f64| (PI * i / 64.0).cos().powi(2);
        let mut stage = Stage::default();
        stage.square(0.0, 0.5, true, lambert(1.0));
        stage.environment(
            EnvironmentMap::new(128, 64, (0..64 * 128).map(pixel).collect(), EnvironmentMap::Z_UP)
                .expect("valid"),
        );
        let expected = 1.0 + (hot - 1.0) * (row(5.0) - row(6.0)) / 128.0;
        let case = Case::new(
            "S28",
            "radiance of one pixel of the sky",
            hot,
            expected,
            stage.build(),
            footprint(DVec3::ZERO, 1.0, 0.5),
        );
        cases.push(case.by(&[Path, Light, Bidirectional]).depth(ONE));
    }
    for distance in decades(&[0, 1, 3, 6, 9]) {
        let floor = || {
            let mut stage = Stage::default();
            stage.square(0.0, 0.5, true, lambert(0.5));
            stage.sphere(Sphere::new(DVec3::new(0.6, 0.0, 0.8) * distance, 1e-4), lambert(0.5));
            stage
        };
        let white = vec![Rgb::WHITE; 8 * 4];
        let map = EnvironmentMap::new(8, 4, white, EnvironmentMap::Z_UP).expect("valid");
        let direction = DVec3::new(0.75f64.sqrt(), 0.0, -0.5);
        let sun = DirectionalLight::new(direction, Rgb::splat(3.0)).expect("valid");
        let mut stages = [floor(), floor(), floor()];
        stages[0].environment(sky());
        stages[1].environment(map);
        stages[2].light(sun);
        let families = [
            "distance of a pebble under a sky",
            "distance of a pebble under an environment map",
            "distance of a pebble under a sun",
        ];
        for ((stage, family), expected) in
            stages.into_iter().zip(families).zip([0.5, 0.5, 0.75 / PI])
        {
            let eye = footprint(DVec3::ZERO, 1.0, 0.5);
            let case = Case::new("S75", family, distance, expected, stage.build(), eye);
            // The pebble is met by 1e-8 of the walks at most.
            let case = Case { tolerance: 1e-7, ..case };
            cases.push(case.by(&[Path, Light, Bidirectional]).depth(ONE));
        }
    }
    for half in decades(&[0, 3, 6]) {
        let mut stage = Stage::default();
        stage.square(0.0, half, true, lambert(0.5));
        stage.light(
            DirectionalLight::new(DVec3::new(0.75f64.sqrt(), 0.0, -0.5), Rgb::splat(3.0))
                .expect("valid"),
        );
        let eye = footprint(DVec3::ZERO, half, half);
        let case = Case::new(
            "S52",
            "plane under a directional light",
            half,
            0.75 / PI,
            stage.build(),
            eye,
        );
        cases.push(
            case.by(&[Path, Light, Bidirectional]).blind(&[Emission, UniformArea]).depth(ONE),
        );
    }
}
