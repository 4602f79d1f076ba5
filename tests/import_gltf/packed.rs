//! Compressed meshes and images.

use crate::files::{SQUARE, altered, data, directory, load, load_text, seen};
use crate::poses::triangles;
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::endpoint::Endpoint;
use pathspace::import::Options;
use pathspace::math::Rgb;
use pathspace::scene::Scene;
use serde_json::json;

#[test]
fn compressed_meshes_have_their_vertices() {
    let world = load("packed.gltf", SQUARE).world;
    for (name, shift) in [("meshopt", 0.0), ("draco", 3.0)] {
        let found = triangles(&world, name);
        assert_eq!(found.len(), 2, "{name}");
        let area: f64 = found.iter().map(|triangle| 0.5 * triangle.cross().z).sum();
        assert_relative_eq!(area, 4.0, epsilon = 1e-6);
        for vertex in found.iter().flat_map(|triangle| triangle.vertices) {
            assert_relative_eq!((vertex.x - shift).abs(), 1.0, epsilon = 1e-6);
            assert_relative_eq!(vertex.y.abs(), 1.0, epsilon = 1e-6);
            assert_eq!(vertex.z, 0.0);
        }
    }
    let normal = seen(&world, DVec3::new(0.25, 0.5, 1.0), -DVec3::Z).shading_normal;
    assert_relative_eq!(normal, DVec3::new(76.0, 0.0, 102.0).normalize(), epsilon = 1e-6);
}

/// A stream that cannot be read costs its mesh; strict readers refuse it.
#[test]
fn damaged_streams_leave_out_their_mesh() {
    let packed = |view: usize, key: &str| {
        format!("/bufferViews/{view}/extensions/EXT_meshopt_compression/{key}")
    };
    let cases = [
        (packed(0, "mode"), json!("STRIPS"), "unknown mode"),
        (packed(0, "buffer"), json!(7), "has no such bytes"),
        (packed(0, "byteLength"), json!(40), "too early"),
        (packed(0, "byteStride"), json!(10), "stride"),
        (packed(1, "filter"), json!("QUATERNION"), "stride"),
        (packed(2, "mode"), json!("INDICES"), "no stream of indices"),
        (packed(2, "count"), json!(9), "too early"),
        ("/bufferViews/3/byteLength".to_owned(), json!(40), "Draco stream cannot be"),
        ("/accessors/3/componentType".to_owned(), json!(5123), "is not what its Draco stream"),
        (
            "/meshes/1/primitives/0/extensions/KHR_draco_mesh_compression".to_owned(),
            json!({"bufferView": 3, "attributes": {"POSITION": 5}}),
            "no attribute 5",
        ),
    ];
    for (pointer, value, reason) in cases {
        let text = altered("packed.gltf", &pointer, value);
        let import = load_text("packed", &text, &Options::default()).expect(reason);
        let warning = import.warnings[0].to_string();
        assert!(warning.contains(reason) && warning.contains("mesh is left out"), "{warning}");
        assert_eq!(import.world.primitive_count(), 2, "{reason}");
        let strict = Options { strict: true, ..Options::default() };
        let error = load_text("packed", &text, &strict).expect_err(reason).to_string();
        assert!(error.contains(reason), "{error}");
    }
}

/// Half a gigabyte of zeros from a short stream counts as bytes of files.
#[test]
fn unpacked_bytes_are_limited() {
    let pointer = "/bufferViews/0/extensions/EXT_meshopt_compression/count";
    let text = altered("packed.gltf", pointer, json!(1_u64 << 40));
    let error =
        load_text("packed-limit", &text, &Options::default()).expect_err("12 TB").to_string();
    assert!(error.contains("more bytes than the limit"), "{error}");
}

/// A red and a blue half, in WebP.
const WEBP: &str = "data:image/webp;base64,UklGRh4AAABXRUJQVlA4TBEAAAAvAQAAAA8Q87//8x8OMqL/AQA=";

#[test]
fn images_may_be_in_webp() {
    for other in ["textures.bin", "two by two.png"] {
        std::fs::copy(data(other), directory("webp").join(other)).expect("copied");
    }
    let source = std::fs::read_to_string(data("textures.gltf")).expect("readable");
    let mut document: serde_json::Value = serde_json::from_str(&source).expect("valid");
    document["images"][1] = json!({"uri": WEBP});
    for texture in [
        json!({"source": 0, "sampler": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}),
        json!({"sampler": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}),
    ] {
        document["textures"][0] = texture;
        let import = load_text("webp", &document.to_string(), &Options::default()).expect("valid");
        let lamp = import.world.light_by_name("painted").expect("it emits");
        for (x, color) in [(-0.5, Rgb::new(0.5, 0.0, 0.0)), (0.5, Rgb::new(0.0, 0.0, 0.5))] {
            let point = seen(&import.world, DVec3::new(x, 0.5, 1.0), -DVec3::Z);
            assert_eq!(import.world.light(lamp).emit(&point, DVec3::Z), color);
        }
    }
    document["textures"][0] = json!({"extensions": {"KHR_texture_basisu": {"source": 1}}});
    let import = load_text("webp", &document.to_string(), &Options::default()).expect("valid");
    let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.iter().any(|w| w.contains("ktxdecompress")), "{warnings:?}");
}
