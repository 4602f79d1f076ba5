//! Punctual lights against their closed forms.

use crate::files::{SQUARE, altered, load, load_text, render, single};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::bsdf::{Bsdf, MetallicRoughness};
use pathspace::endpoint::{Endpoint, Light};
use pathspace::geometry::SurfacePoint;
use pathspace::import::Options;
use pathspace::integrator::{Depth, PathTracer};
use pathspace::math::Rgb;
use pathspace::scene::Scene;

#[test]
fn punctual_lights_have_their_closed_form() {
    let to_light = DVec3::new(1.0, 0.0, 2.0).normalize();
    let model = MetallicRoughness::new(Rgb::splat(0.5), 0.0, 1.0, 1.5).expect("valid");
    let scattered = model.eval(to_light, DVec3::Z) * to_light.z;
    let expected = [Rgb::new(8.0, 4.0, 2.0) / 5.0, Rgb::new(0.75, 1.5, 3.0), Rgb::splat(8.0) / 5.0];
    let path = PathTracer {
        depth: Depth { max_bounces: Some(1), ..Depth::default() },
        ..PathTracer::default()
    };
    for (index, irradiance) in expected.into_iter().enumerate() {
        // One light alone, since next-event estimation would choose the most powerful one nearly
        // always.
        let nodes = serde_json::json!([3 * index, 3 * index + 1, 3 * index + 2]);
        let import = load_text(
            "lights",
            &altered("lights.gltf", "/scenes/0/nodes", nodes),
            &Options::default(),
        )
        .expect("valid");
        assert_eq!((import.world.light_count(), import.warnings.len()), (1, 0));
        let mean = render(&import.world, &*import.views[0].camera, &path, 1).mean();
        for channel in 0..3 {
            assert_relative_eq!(
                mean[channel],
                (irradiance * scattered)[channel],
                max_relative = 1e-3
            );
        }
    }
    let import = load("lights.gltf", SQUARE);
    let spot = import.world.light(import.world.light_by_name("light 2").expect("named"));
    let axis = -to_light;
    let side = DVec3::Y;
    let outer = single(0.25);
    for angle in [0.0f64, 0.05, 0.2, 0.24, 0.26] {
        let t = ((angle.cos() - outer.cos()) / (1.0 - outer.cos())).max(0.0);
        let emitted =
            spot.emit(&SurfacePoint::dirac(DVec3::ZERO), axis * angle.cos() + side * angle.sin());
        assert_relative_eq!(emitted.r(), 8.0 * t * t, epsilon = 1e-5);
    }
    assert_relative_eq!(
        spot.power().r(),
        8.0 * std::f64::consts::TAU * (1.0 - outer.cos()) / 3.0,
        max_relative = 1e-12
    );
}
