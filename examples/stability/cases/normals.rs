//! Shading normals that differ from the geometric ones, and densities that differ forwards and
//! backwards.

use super::{Case, FROM_CAMERA, ONE, lit_floor, sky};
use crate::measure::Method::{self, Bidirectional, Emission, Light, Path, UniformArea};
use crate::scenes::{Stage, camera, footprint, lambert, mean_over_square, polygon_irradiance};
use pathspace::endpoint::DirectionalLight;
use pathspace::geometry::Sphere;
use pathspace::glam::{DAffine3, DVec2, DVec3};
use pathspace::integrator::Depth;
use pathspace::math::Rgb;
use pathspace::scene::{Material, Mesh, World};
use std::f64::consts::PI;

/// The square of half side `half` at a height, counter-clockwise as seen from below or above.
fn corners(z: f64, half: f64, up: bool) -> [DVec3; 4] {
    let [a, b, c, d] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]| DVec3::new(half * x, half * y, z));
    if up { [a, b, c, d] } else { [a, d, c, b] }
}

/// A square whose shading normals are what a function says.
fn bent(corners: [DVec3; 4], normal: impl Fn(DVec3) -> DVec3) -> Mesh {
    let normals = Some(corners.iter().map(|&p| normal(p)).collect());
    Mesh {
        positions: corners.to_vec(),
        normals,
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

pub(super) fn normals(cases: &mut Vec<Case>) {
    for tilt in [0.0, 50.0f64] {
        direct(cases, tilt);
        let (sin, cos) = tilt.to_radians().sin_cos();
        let mesh = bent(corners(2.0, 1.0, false), |_| DVec3::new(-sin, 0.0, -cos));
        // The plate is Lambertian, so it is as bright from everywhere: its shading normal towards
        // the sun decides.
        let (world, sun) = sunlit_plate(&mesh, lambert(0.5), 60.0);
        let radiance = 0.5 / PI * 3.0 * DVec3::new(-sin, 0.0, -cos).dot(sun);
        let plate = corners(2.0, 1.0, true);
        let expected = mean_over_square(0.5, |x, y| {
            0.5 / PI * radiance * polygon_irradiance(DVec3::new(x, y, 0.0), DVec3::Z, &plate)
        });
        let case = |world| {
            Case::new(
                "S25",
                "tilt of shading normals, two bounces",
                tilt,
                expected,
                world,
                footprint(DVec3::ZERO, 1.0, 0.5),
            )
        };
        let (by_light, _) = sunlit_plate(&mesh, lambert(0.5), 60.0);
        cases.extend(indirect([case(world), case(by_light)], 1e-5));
    }
    for tilt in [0.0, 60.0, 89.0, 89.999f64] {
        // What the shading normal sees below the horizon is lost, nothing is gained: (1 + cos tilt)
        // / 2 of a white floor.
        let (sin, cos) = tilt.to_radians().sin_cos();
        let mut stage = Stage::default();
        stage.mesh(
            &bent(corners(0.0, 10.0, true), |_| DVec3::new(sin, 0.0, cos)),
            DAffine3::IDENTITY,
            lambert(1.0),
        );
        stage.environment(sky());
        let (sin_half, cos_half) = (0.5 * tilt).to_radians().sin_cos();
        let eye = camera(DVec3::new(sin_half, 0.0, cos_half), DVec3::ZERO, 1e-3);
        let case = Case::new(
            "S26",
            "tilt beyond the horizon",
            tilt,
            0.5 * (1.0 + cos),
            stage.build(),
            eye,
        );
        cases.push(case.by(FROM_CAMERA).depth(ONE));
    }
    for bend in [0.0, 1.0, 100.0] {
        let mut stage = Stage::default();
        stage.square(0.0, 0.5, true, lambert(0.5));
        let lamp = bent(corners(2.0, 1.0, false), |p| DVec3::new(bend * p.x, bend * p.y, -1.0));
        let lamp = stage.mesh(&lamp, DAffine3::IDENTITY, Material::Black);
        stage.glow(lamp, 1.0);
        let eye = footprint(DVec3::ZERO, 1.0, 1e-4);
        cases.push(
            Case::new("S27", "bend of a light's normals", bend, lit_floor(), stage.build(), eye)
                .by(FROM_CAMERA)
                .depth(ONE),
        );
    }
    densities(cases);
}

/// A floor with tilted shading normals under a square light.
fn direct(cases: &mut Vec<Case>, tilt: f64) {
    let (sin, cos) = tilt.to_radians().sin_cos();
    let normal = DVec3::new(sin, 0.0, cos);
    let mut stage = Stage::default();
    stage.mesh(&bent(corners(0.0, 0.5, true), |_| normal), DAffine3::IDENTITY, lambert(0.5));
    let lamp = stage.square(2.0, 1.0, false, Material::Black);
    stage.glow(lamp, 1.0);
    let lamp = corners(2.0, 1.0, true);
    let expected = mean_over_square(0.5, |x, y| {
        0.5 / PI * polygon_irradiance(DVec3::new(x, y, 0.0), normal, &lamp)
    });
    let case = Case::new(
        "S25",
        "tilt of shading normals, one bounce",
        tilt,
        expected,
        stage.build(),
        footprint(DVec3::ZERO, 1.0, 0.5),
    );
    cases.push(Case { tolerance: 1e-5, ..case.by(&Method::SINGLE).depth(ONE) });
}

/// A plate that looks down, in the light of a sun that comes from below past the small floor that
/// looks up at it. Returns the direction to the sun.
fn sunlit_plate(plate: &Mesh, material: Material, degrees: f64) -> (World, DVec3) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let sun = DVec3::new(-sin, 0.0, -cos);
    let mut stage = Stage::default();
    stage.square(0.0, 0.5, true, lambert(0.5));
    stage.mesh(plate, DAffine3::IDENTITY, material);
    stage.light(DirectionalLight::new(-sun, Rgb::splat(3.0)).expect("valid"));
    (stage.build(), sun)
}

/// Most light walks miss plate and floor, so they may know the same less well than the others.
fn indirect([case, by_light]: [Case; 2], tolerance: f64) -> [Case; 2] {
    let depth = Depth::exactly(2);
    let case = Case {
        tolerance,
        ..case.by(&[Path, Bidirectional]).blind(&[Emission, UniformArea]).depth(depth)
    };
    [case, Case { tolerance, error: 0.03, ..by_light.by(&[Light]).depth(depth) }]
}

/// GGX of α = 1 has f = 1 / (2π (μ + μ')): its densities of the two directions differ by their
/// shadowing.
fn densities(cases: &mut Vec<Case>) {
    let rough = || Material::RoughMirror { reflectance: Rgb::WHITE, alpha: DVec2::ONE };
    for cosine in [0.5, 0.2f64] {
        let from_plate = |x: DVec3, y: DVec3| {
            let (distance, height) = (x.distance(y), (y - x).z);
            let mu = height / distance;
            3.0 * cosine / (2.0 * PI * (cosine + mu)) * mu * mu / (distance * distance)
        };
        // Four panels of five by five points each: relative errors below 1e-5.
        let panels = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        let panel = |x: DVec3, [u, v]: [f64; 2]| {
            mean_over_square(0.5, |a, b| from_plate(x, DVec3::new(u + a, v + b, 2.0)))
        };
        let expected = mean_over_square(0.5, |x, y| {
            0.5 / PI * panels.map(|p| panel(DVec3::new(x, y, 0.0), p)).iter().sum::<f64>()
        });
        let case = || {
            let (world, _) = sunlit_plate(
                &bent(corners(2.0, 1.0, false), |_| DVec3::NEG_Z),
                rough(),
                cosine.acos().to_degrees(),
            );
            Case::new(
                "S38",
                "sun's cosine at a rough mirror",
                cosine,
                expected,
                world,
                footprint(DVec3::ZERO, 1.0, 0.5),
            )
        };
        cases.extend(indirect([case(), case()], 1e-4));
    }
    // A speck in the middle of a furnace, too small to change it, seen at the cosine 0.1: the
    // directional albedo 1 - μ ln((1 + μ)/μ) once, then half as much with every bounce.
    for diffuse in [0.0, 0.5] {
        let mixture = Material::Mixture {
            components: Box::new([lambert(1.0), rough()]),
            weights: [diffuse, 1.0 - diffuse],
        };
        let mut stage = Stage::default();
        let walls =
            stage.sphere(Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) }, lambert(0.5));
        stage.glow(walls, 1.0);
        stage.square(0.0, 1e-4, true, mixture);
        let albedo = diffuse + (1.0 - diffuse) * (1.0 - 0.1 * 11f64.ln());
        let eye = camera(DVec3::new(0.99f64.sqrt(), 0.0, 0.1) * 1e-3, DVec3::ZERO, 1e-4);
        let case = Case::new(
            "S38",
            "diffuse share of a rough mirror",
            diffuse,
            1.75 * albedo,
            stage.build(),
            eye,
        );
        cases.push(Case { tolerance: 1e-5, ..case.by(FROM_CAMERA).depth(Depth::up_to(3)) });
    }
}
