//! Materials and textures against those built by hand.

use crate::files::{SQUARE, altered, data, directory, load_text, seen};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3, UVec2};
use pathspace::bsdf::{Bsdf, MetallicRoughness, Mixture, Model};
use pathspace::endpoint::Endpoint;
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Options, gltf};
use pathspace::math::Rgb;
use pathspace::scene::{Material, Scene};

pub fn surface(color: [f64; 3], metalness: f64, roughness: f64, relative_ior: f64) -> Material {
    Material::MetallicRoughness {
        base_color: Rgb(color).into(),
        metallic_roughness: Rgb::new(0.0, roughness, metalness).into(),
        relative_ior,
    }
}

#[test]
fn materials_are_those_built_by_hand() {
    let import =
        gltf::load(data("materials.gltf"), UVec2::new(88, 88), &Options::default()).expect("valid");
    let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.is_empty(), "{warnings:?}");
    let film = import.views[0].camera.film().resolution;
    assert_eq!(film, UVec2::new(88, 8), "16.5 to 1.5");
    let white = |metalness, roughness| surface([1.0; 3], metalness, roughness, 1.5);
    let blend = |front: Material, amount: f64| Material::Blend {
        components: Box::new([Material::Null, front]),
        amount: Rgb::splat(amount).into(),
    };
    let glass = Material::Dielectric { relative_ior: 1.5 };
    // 1/4 of it is glass, and 1/2 of the whole, 2/3 of the rest, metal
    let partly = Material::Mixture {
        components: Box::new([white(0.5 / 0.75, 0.0), glass]),
        weights: [0.75, 0.25],
    };
    let expected = [
        ("default", white(1.0, 1.0)),
        ("smooth", surface([0.5, 0.25, 0.125], 0.5, 0.0, 1.5)),
        ("glass", Material::Dielectric { relative_ior: 1.25 }),
        ("frosted", Material::RoughDielectric { relative_ior: 1.5, alpha: DVec2::splat(0.25) }),
        ("pane", Material::ThinDielectric { relative_ior: 1.5 }),
        ("partly glass", partly),
        ("veil", blend(white(1.0, 1.0), 0.25)),
        ("cut away", Material::Null),
        ("kept", white(1.0, 1.0)),
        ("glow", white(1.0, 1.0)),
        ("none", white(1.0, 1.0)),
    ];
    for (k, (name, material)) in expected.into_iter().enumerate() {
        let x = seen(&import.world, DVec3::new(3.0 * k as f64 + 0.25, 0.125, 1.0), -DVec3::Z);
        assert_eq!(import.world.surface_name(&x), Some(name));
        let mixture = material.mixture().expect("valid");
        assert!(mixture.is_some());
        assert_eq!(import.world.bsdf(&x).mixture(true), mixture, "{name}");
        assert_eq!(import.world.bsdf(&x).mixture(false), mixture, "{name}");
    }
    let glow = import.world.light(import.world.light_by_name("glow").expect("it emits"));
    let x = seen(&import.world, DVec3::new(27.25, 0.125, 1.0), -DVec3::Z);
    for direction in [DVec3::Z, -DVec3::Z] {
        assert_eq!(glow.emit(&x, direction), Rgb::new(0.5, 0.25, 1.0));
    }
}

#[test]
fn textures_are_decoded_where_they_are_looked_up() {
    let import = gltf::load(data("textures.gltf"), SQUARE, &Options::default()).expect("valid");
    assert!(import.warnings.is_empty(), "{:?}", import.warnings);
    let world = &import.world;
    let decoded = pathspace::film::linear_from_srgb(188.0 / 255.0);
    // upper left, upper right, lower left, lower right; u also decides roughness and metalness
    let texels = [
        (-0.5, 0.5, [1.0, 0.0, 0.0], 1.0, (0.5, 0.0)),
        (0.5, 0.5, [0.0, 0.5, 0.0], 128.0 / 255.0, (0.1, 1.0)),
        (-0.5, -0.5, [0.0, 0.0, 1.0], 64.0 / 255.0, (0.5, 0.0)),
        (0.5, -0.5, [decoded, 0.5 * decoded, decoded], 0.0, (0.1, 1.0)),
    ];
    let lamp = world.light(world.light_by_name("painted").expect("it emits"));
    for (x, y, color, alpha, (roughness, metalness)) in texels {
        if alpha == 0.0 {
            let from = SurfacePoint::dirac(DVec3::new(x, y, 1.0));
            assert!(world.intersect(&from, -DVec3::Z).is_none(), "there is nothing");
            continue;
        }
        let point = seen(world, DVec3::new(x, y, 1.0), -DVec3::Z);
        let front = MetallicRoughness::new(Rgb(color), metalness, roughness, 1.5).expect("valid");
        let (a, b) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.28, 0.96));
        let value = world.bsdf(&point).eval(a, b);
        let emitted = lamp.emit(&point, DVec3::Z);
        for channel in 0..3 {
            assert_relative_eq!(
                value[channel],
                (front.eval(a, b) * alpha)[channel],
                max_relative = 1e-6
            );
            // The factor of the base colour does not apply to emission, its opacity does.
            let emission = 0.5 * color[channel] / if channel == 1 { 0.5 } else { 1.0 } * alpha;
            assert_relative_eq!(emitted[channel], emission, max_relative = 1e-12);
        }
    }
    // Only the lower left texel is in the range of the transform.
    for (x, y) in [(-0.5, 0.5), (0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)] {
        let point = seen(world, DVec3::new(3.0 + x, y, 1.0), -DVec3::Z);
        let expected =
            MetallicRoughness::new(Rgb::new(0.0, 0.0, 1.0), 0.0, 1.0, 1.5).expect("valid");
        assert_eq!(
            world.bsdf(&point).mixture(true),
            Some(Mixture::new([Model::from(expected), Model::Black], [1.0, 0.0]).expect("valid"))
        );
    }
}

/// Where there is no image, colours are the factors: 1, 0.5, 1 with opacity 1, and metal of
/// roughness 0.1 and 0.5 of what it emits; the second image alone decides roughness and metalness.
#[test]
fn factors_hold_where_images_cannot_be_read() {
    use serde_json::json;
    for other in ["textures.bin", "two by two.png"] {
        std::fs::copy(data(other), directory("unreadable").join(other)).expect("copied");
    }
    let cases = [
        ("/images/0", json!({}), "image 0: it needs either a uri or a buffer view"),
        ("/images/0/uri", json!("nowhere.png"), "image 0: there is no file nowhere.png"),
        ("/images/0/uri", json!("textures.bin"), "image 0: it is neither PNG nor JPEG"),
        ("/images/0/uri", json!("%2e%2e/textures.bin"), "outside of the scene's directory"),
        (
            "/textures/0",
            json!({"extensions": {"EXT_texture_webp": {}}}),
            "texture 0: it has no image",
        ),
    ];
    for (pointer, value, reason) in cases {
        let text = altered("textures.gltf", pointer, value);
        let import = load_text("unreadable", &text, &Options::default()).expect(reason);
        let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
        assert!(warnings.iter().any(|warning| warning.contains(reason)), "{warnings:?}");
        let world = &import.world;
        for (x, y, roughness, metalness) in [(-0.5, 0.5, 0.5, 0.0), (0.5, -0.5, 0.1, 1.0)] {
            let point = seen(world, DVec3::new(x, y, 1.0), -DVec3::Z);
            let color = Rgb::new(1.0, 0.5, 1.0);
            let front = MetallicRoughness::new(color, metalness, roughness, 1.5).expect("valid");
            let (a, b) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.28, 0.96));
            let (value, expected) = (world.bsdf(&point).eval(a, b), front.eval(a, b));
            for channel in 0..3 {
                assert_relative_eq!(value[channel], expected[channel], max_relative = 1e-6);
            }
        }
        let strict = Options { strict: true, ..Options::default() };
        let error = load_text("unreadable", &text, &strict).expect_err(reason).to_string();
        assert!(error.contains(reason), "{error}");
    }
}

/// A factor that exceeds 1 by the last bit of a single-precision number is 1; the index of
/// refraction 0 stands for an infinite one, which reflects everything.
#[test]
fn factors_are_rounded_and_the_index_of_refraction_may_be_zero() {
    use serde_json::json;
    let above = f64::from(1f32.next_up());
    let factors = json!({
        "baseColorFactor": [above, 0.5, 0.25, 1],
        "metallicFactor": above,
        "roughnessFactor": above,
    });
    let cases = [
        ("/materials/0/pbrMetallicRoughness", factors, surface([1.0, 0.5, 0.25], 1.0, 1.0, 1.5)),
        (
            "/materials/0",
            json!({
                "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.5},
                "extensions": {"KHR_materials_ior": {"ior": 0}},
            }),
            surface([1.0; 3], 0.0, 0.5, 1e6),
        ),
    ];
    for (pointer, value, expected) in cases {
        let text = altered("box.gltf", pointer, value);
        let world = load_text("factors", &text, &Options::default()).expect(pointer).world;
        let point = seen(&world, DVec3::new(0.25, 0.125, 0.0), -DVec3::Z);
        let expected = expected.mixture().expect("valid");
        assert_eq!(world.bsdf(&point).mixture(true), expected, "{pointer}");
    }
}

/// A JPEG whose left half is grey and whose right half is pink, looked up from u = -1 to u = 2.
#[test]
fn jpegs_wrap_in_each_mode() {
    let world = gltf::load(data("wraps.gltf"), SQUARE, &Options::default()).expect("valid").world;
    let linear = |levels: [u8; 3]| {
        Rgb(levels.map(|level| pathspace::film::linear_from_srgb(f64::from(level) / 255.0)))
    };
    let halves = [linear([100; 3]), linear([220, 114, 150])];
    let modes = [[0, 1, 0, 1, 0, 1], [1, 0, 0, 1, 1, 0], [0, 0, 0, 1, 1, 1]];
    let (a, b) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.28, 0.96));
    for (k, mode) in modes.into_iter().enumerate() {
        for (step, half) in mode.into_iter().enumerate() {
            let x = 3.0 * k as f64 - 1.0 + (2.0 * step as f64 + 1.0) / 6.0;
            let point = seen(&world, DVec3::new(x, 0.125, 1.0), -DVec3::Z);
            let expected =
                MetallicRoughness::new(halves[half], 0.0, 1.0, 1.5).expect("valid").eval(a, b);
            let value = world.bsdf(&point).eval(a, b);
            // A decoder may round each channel to the next level.
            (0..3).for_each(|channel| {
                assert_relative_eq!(value[channel], expected[channel], max_relative = 0.02)
            });
        }
    }
}
