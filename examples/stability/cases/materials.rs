//! Roughness, grazing angles and indices of refraction.

use super::{Case, FROM_CAMERA, ONE, sky};
use crate::measure::Method::{self, Bidirectional, Emission, Light, Path, UniformArea};
use crate::scenes::{Stage, camera, footprint, fresnel, lambert};
use pathspace::endpoint::{DirectionalLight, PointLight};
use pathspace::glam::{DVec2, DVec3};
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::scene::Material;
use std::f64::consts::PI;

pub(super) fn materials(cases: &mut Vec<Case>) {
    let under_sky = |material: Material, cosine: f64| {
        let mut stage = Stage::default();
        stage.square(0.0, 10.0, true, material);
        stage.environment(sky());
        let eye = camera(
            DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine),
            DVec3::ZERO,
            1e-3 * cosine,
        );
        (stage.build(), eye)
    };
    let ggx =
        |x: f64, y: f64| Material::RoughMirror { reflectance: Rgb::WHITE, alpha: DVec2::new(x, y) };
    for alpha in [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-8] {
        let (world, eye) = under_sky(ggx(alpha, alpha), 0.5);
        // Known at 1 and 0.1. Below, G2/G1 = 1 - Λ(i) and Λ = α² tan² θ / 4 up to 5 %.
        let expected = match alpha {
            1.0 => 0.450_693_855_665_945_16,
            0.1 => 0.969_204_984_411_689_5,
            _ if alpha < 1e-4 => 1.0,
            _ => 1.0 - 0.75 * alpha * alpha,
        };
        let tolerance = if alpha < 0.1 { 0.05 * alpha * alpha + 1e-9 } else { 1e-9 };
        cases.push(Case {
            tolerance,
            ..Case::new("S20", "roughness", alpha, expected, world, eye).by(FROM_CAMERA).depth(ONE)
        });
    }
    for cosine in [1.0, 1e-2, 1e-4, 1e-6, 1e-8] {
        let (world, eye) = under_sky(lambert(0.6), cosine);
        cases.push(
            Case::new("S21", "grazing cosine, diffuse", cosine, 0.6, world, eye)
                .by(FROM_CAMERA)
                .depth(ONE),
        );
        let (world, eye) = under_sky(ggx(1e-5, 1e-5), cosine);
        cases.push(
            Case::new("S21", "grazing cosine, mirror limit", cosine, 1.0, world, eye)
                .by(FROM_CAMERA)
                .depth(ONE),
        );
    }
    interfaces(cases);
    // A pane between the camera and a wall: multiple reflections inside.
    for ior in [1e-3, 0.5, 1.0, 1.0 + 1e-7, 1.0001, 1.5, 10.0, 100.0] {
        let mut stage = Stage::default();
        let glass = Material::Dielectric { relative_ior: ior };
        stage.square(0.0, 10.0, false, glass.clone());
        stage.square(0.1, 10.0, true, glass);
        let wall = stage.square(1.0, 10.0, false, Material::Black);
        stage.glow(wall, 1.0);
        let reflectance = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let eye = camera(DVec3::NEG_Z, DVec3::ZERO, 1e-6);
        let expected = (1.0 - reflectance) / (1.0 + reflectance);
        let row = if (ior - 1.0f64).abs() < 1e-3 { "S22" } else { "S48" };
        let case =
            Case::new(row, "index of refraction of a pane", ior, expected, stage.build(), eye)
                .by(FROM_CAMERA);
        // The walks inside n = 100 go on for a thousand events, of which most bring nothing.
        let tolerance = if row == "S22" { 1e-8 } else { 1e-9 };
        cases.push(Case { error: if expected < 0.1 { 0.05 } else { 0.005 }, tolerance, ..case });
    }
    // From inside glass: just below the critical angle a little light gets in, above it none.
    for beyond in [1e-1, 1e-2, 1e-3, 1e-6, 0.0, -1e-7, -1e-2] {
        let mut stage = Stage::default();
        stage.square(0.0, 1e3, true, Material::Dielectric { relative_ior: 1.5 });
        stage.environment(sky());
        let far: f64 = beyond;
        let sine = if far >= 0.0 { (1.0 - far * far).sqrt() / 1.5 } else { (1.0 - far) / 1.5 };
        let near = ((1.0 - sine) * (1.0 + sine)).sqrt();
        let eye = camera(DVec3::new(-sine, 0.0, -near), DVec3::ZERO, 1e-12);
        // Inside, the sky is there too, above by refraction and below by reflection.
        let reflectance = if far > 0.0 { fresnel(near, far, 1.0 / 1.5) } else { 1.0 };
        let expected = 2.25 * (1.0 - reflectance) + reflectance;
        let case = Case::new(
            "S23",
            "cosine behind the critical angle",
            beyond,
            expected,
            stage.build(),
            eye,
        )
        .by(FROM_CAMERA);
        cases.push(Case {
            tolerance: if (0.0..1e-5).contains(&beyond) { 1e-5 } else { 1e-9 },
            ..case
        });
    }
    // The sun through the surface of glass onto a floor inside: the refraction of a light walk.
    // That of a camera walk is row S23.
    for ior in [0.8, 1.0, 1.5, 10.0] {
        let mut stage = Stage::default();
        stage.square(0.0, 0.5, true, lambert(0.5));
        stage.square(0.2, 0.9, true, Material::Dielectric { relative_ior: ior });
        let (sine, cosine) = (0.5f64.sqrt(), 0.5f64.sqrt());
        stage.light(
            DirectionalLight::new(DVec3::new(sine, 0.0, -cosine), Rgb::splat(3.0)).expect("valid"),
        );
        let refracted = (1.0 - (sine / ior).powi(2)).sqrt();
        let expected = 0.5 / PI * 3.0 * cosine * (1.0 - fresnel(cosine, refracted, ior));
        let eye = footprint(DVec3::ZERO, 0.19, 0.45);
        let case =
            Case::new("S24", "index of refraction over a floor", ior, expected, stage.build(), eye);
        let blind = if ior == 1.0 { &[UniformArea][..] } else { &[Emission, Path, UniformArea] };
        cases.push(Case {
            error: 0.01,
            ..case.by(&[Light, Bidirectional]).blind(blind).depth(Depth::exactly(2))
        });
    }
    // A point light on the floor of a pool, seen from above: nobody can draw such a path.
    let mut stage = Stage::default();
    stage.square(0.0, 100.0, true, lambert(0.5));
    stage.square(1.0, 100.0, true, Material::Dielectric { relative_ior: 1.33 });
    stage.light(PointLight::new(DVec3::Z * 3.0, Rgb::WHITE).expect("valid"));
    let eye = camera(DVec3::Z * 4.0, DVec3::ZERO, 20.0);
    cases.push(
        Case::new("S41", "point light, pool, pinhole", 1.33, 0.0, stage.build(), eye)
            .by(&[])
            .blind(&Method::SINGLE),
    );
}

/// One rough interface under a white sky, from outside and from inside. Expected are `R + T/n²` of
/// first events, whose visible normals were integrated over slopes with the Beta function in T.
fn interfaces(cases: &mut Vec<Case>) {
    let glass =
        |alpha: f64| Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(alpha) };
    let beckmann = |alpha: f64| Material::Beckmann { rough: Box::new(glass(alpha)) };
    for (family, material, cosine, expected) in [
        ("cosine over rough glass, 0.5", glass(0.5), 0.2, 0.359_160_75),
        ("cosine over rough glass, 1", glass(1.0), 0.2, 0.149_121_63),
        ("cosine over rough glass, 1", glass(1.0), 0.02, 0.090_691_80),
        ("cosine over rough glass, 1", glass(1.0), 1e-4, 0.092_220),
        ("cosine under rough glass, 0.5", glass(0.5), -0.5, 0.908_168),
        ("cosine under rough glass, 1", glass(1.0), -0.2, 0.395_309),
        ("cosine over rough glass, Beckmann", beckmann(1.0), 0.2, 0.368_045_03),
    ] {
        // Hardly larger than what the camera sees, so that walks from the sky find it.
        let half = 1e-3 * f64::abs(cosine);
        let (along, across) = (1.1e-3, 1.1 * half);
        let case = || {
            let mut stage = Stage::default();
            stage.quad(
                DVec3::new(-along, -across, 0.0),
                DVec3::X * (2.0 * along),
                DVec3::Y * (2.0 * across),
                material.clone(),
            );
            stage.environment(sky());
            let position = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            let eye = camera(position, DVec3::ZERO, 2.0 * half.atan().to_degrees());
            let case = Case::new("S83", family, cosine.abs(), expected, stage.build(), eye);
            Case { tolerance: 2e-5, ..case.depth(ONE) }
        };
        let is_grazing = f64::abs(cosine) < 0.1;
        let error = if is_grazing { 0.005 } else { 0.002 };
        cases.push(Case { error, ..case().by(FROM_CAMERA) });
        if !is_grazing {
            cases.push(Case { error: 0.01, ..case().by(&[Light]) });
        }
    }
}
