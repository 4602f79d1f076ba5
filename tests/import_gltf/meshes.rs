//! Triangles and attributes of meshes, and where nodes put them.

use crate::files::{SQUARE, altered, data, directory, load, load_text, seen};
use approx::assert_relative_eq;
use glam::{DAffine3, DQuat, DVec2, DVec3, UVec2};
use pathspace::endpoint::Endpoint;
use pathspace::geometry::Shape;
use pathspace::import::{Options, gltf};
use pathspace::math::Rgb;
use pathspace::scene::Scene;

#[test]
fn meshes_of_all_kinds_have_their_triangles() {
    let import = gltf::load(data("meshes.gltf"), SQUARE, &Options::default()).expect("valid");
    assert_eq!(import.warnings.len(), 1, "no light: {:?}", import.warnings);
    assert_eq!(import.views[0].name, "whole scene");
    let world = &import.world;
    let v = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let expected = [
        [v(0.0, 0.0), v(1.0, 0.0), v(0.0, 1.0)],
        [v(1.0, 0.0), v(1.0, 1.0), v(0.0, 1.0)],
        [v(0.0, 1.0), v(1.0, 1.0), v(0.0, 2.0)],
        [v(1.0, 0.0), v(1.0, 1.0), v(0.0, 0.0)],
        [v(1.0, 1.0), v(0.0, 1.0), v(0.0, 0.0)],
        [v(0.0, 0.0), v(2.0, 0.0), v(0.0, 2.0)],
        [v(0.0, 0.0), v(2.0, 0.0), v(0.0, 2.0)],
        [v(0.0, 0.0), v(1.0, 0.0), v(0.0, 1.0)],
    ];
    assert_eq!(world.primitive_count(), expected.len());
    for (primitive, corners) in expected.into_iter().enumerate() {
        let Some(Shape::Triangle(triangle)) = world.shape(primitive as u32) else {
            panic!("primitive {primitive} is no triangle")
        };
        let rotations = [0, 1, 2].map(|k| [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]]);
        assert!(
            rotations.contains(&triangle.vertices),
            "primitive {primitive}: {:?}",
            triangle.vertices
        );
    }
}

/// The last primitive's normals, as bytes, and uv, as 16-bit numbers, lie between its positions.
#[test]
fn interleaved_attributes_are_told_apart() {
    let source = std::fs::read_to_string(data("meshes.gltf")).expect("readable");
    let mut document: serde_json::Value = serde_json::from_str(&source).expect("valid");
    document["meshes"][0]["primitives"] =
        serde_json::json!([document["meshes"][0]["primitives"][4]]);
    let world =
        load_text("interleaved", &document.to_string(), &Options::default()).expect("valid").world;
    let x = seen(&world, DVec3::new(0.5, 0.25, 1.0), -DVec3::Z);
    assert_relative_eq!(x.uv, DVec2::new(0.5, 0.25), epsilon = 1e-12);
    let (a, b, c) =
        (DVec3::Z, DVec3::new(1.0, 0.0, 1.0).normalize(), DVec3::new(0.0, 1.0, 1.0).normalize());
    assert_relative_eq!(
        x.shading_normal,
        (a * 0.25 + b * 0.5 + c * 0.25).normalize(),
        epsilon = 1e-12
    );
}

/// Normals are taken along by the inverse transpose, whether or not the transform mirrors, and
/// light leaves on that side only.
#[test]
fn uneven_and_mirroring_nodes_keep_normals_and_fronts() {
    let world = gltf::load(data("nodes.gltf"), SQUARE, &Options::default()).expect("valid").world;
    let turn = DQuat::from_rotation_x(30f64.to_radians());
    let inner =
        DAffine3::from_scale_rotation_translation(DVec3::new(1.0, 0.5, 1.0), turn, DVec3::ZERO);
    for (name, x, shift) in [("mirrored", -2.0, 1.0), ("plain", 2.0, 9.0)] {
        let outer = DAffine3::from_scale(DVec3::new(x, 1.0, 3.0))
            * DAffine3::from_translation(DVec3::new(shift, 2.0, 3.0));
        let transform = outer * inner;
        let taken_along =
            |normal: DVec3| (transform.matrix3.inverse().transpose() * normal).normalize();
        let (front, center) =
            (taken_along(DVec3::Z), transform.transform_point3(DVec3::new(0.25, 0.125, 0.0)));
        let lamp = world.light(world.light_by_name(name).expect("it emits"));
        for (side, emitted) in [(front, Rgb::WHITE), (-front, Rgb::BLACK)] {
            let hit = seen(&world, center + side, -side);
            assert_eq!(world.surface_name(&hit), Some(name));
            assert_relative_eq!(hit.position, center, epsilon = 1e-6);
            assert_relative_eq!(hit.geometric_normal, front, epsilon = 1e-6);
            assert_relative_eq!(
                hit.shading_normal,
                taken_along(DVec3::new(0.6, 0.0, 0.8)),
                epsilon = 1e-6
            );
            assert_eq!(lamp.emit(&hit, side), emitted, "{name}");
        }
    }
}

/// Both kinds of cameras look along -z of their node, y up; the scale of a node moves them and does
/// not change their view.
#[test]
fn cameras_look_out_of_their_nodes() {
    let import =
        gltf::load(data("nodes.gltf"), UVec2::new(40, 40), &Options::default()).expect("valid");
    let corner = |name: &str| {
        let view = import.views.iter().find(|view| view.name == name).expect("it is there");
        assert_eq!(view.camera.film().resolution, UVec2::new(40, 20), "{name}");
        let point = view.camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
        let sample = view.camera.sample_direction(&point, DVec2::ZERO).expect("a direction");
        (sample.from.position, sample.direction)
    };
    // The node is turned by a quarter from z towards x: forward is -x, right is -z.
    let (position, direction) = corner("perspective");
    let t = 0.5f64.tan();
    assert_relative_eq!(position, DVec3::new(2.0, 0.0, 0.0), epsilon = 1e-6);
    assert_relative_eq!(direction, DVec3::new(-1.0, t, 2.0 * t).normalize(), epsilon = 1e-6);
    let (position, direction) = corner("orthographic");
    assert_relative_eq!(position, DVec3::new(2.0, 1.5, 3.0), epsilon = 1e-6);
    assert_relative_eq!(direction, -DVec3::X, epsilon = 1e-6);
}

/// The back wall flattened along its normal stays where it is, and a block becomes a sheet.
#[test]
fn flattened_nodes_keep_what_has_an_area() {
    let cases = [
        ("/nodes/1/scale", [1, 1, 0], "back", DVec3::new(0.25, 0.125, -1.0)),
        ("/nodes/8/scale", [1, 1, 0], "plastic block", DVec3::new(0.25, -0.875, 0.125)),
    ];
    for (pointer, scale, name, expected) in cases {
        let text = altered("box.gltf", pointer, serde_json::json!(scale));
        let strict = Options { strict: true, ..Options::default() };
        let world = load_text("flattened", &text, &strict).expect(name).world;
        let point = seen(&world, expected + 0.25 * DVec3::Z, -DVec3::Z);
        assert_eq!(world.surface_name(&point), Some(name));
        assert_relative_eq!(point.position, expected, epsilon = 1e-12);
        assert_relative_eq!(point.geometric_normal.abs(), DVec3::Z, epsilon = 1e-12);
    }
}

/// Bounds of positions are not needed, and numbers that no bytes stand for are 0: every point shows
/// the upper left texel.
#[test]
fn accessors_may_lack_bounds_and_bytes() {
    let positions = serde_json::json!(
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}
    );
    let strict = Options { strict: true, ..Options::default() };
    let text = altered("box.gltf", "/accessors/0", positions);
    let bounds = load_text("accessors", &text, &strict).expect("valid").world.bounds();
    assert_eq!(bounds, load("box.gltf", SQUARE).world.bounds());

    for other in ["textures.bin", "two by two.png"] {
        std::fs::copy(data(other), directory("accessors").join(other)).expect("copied");
    }
    let zeros = serde_json::json!({"componentType": 5126, "count": 4, "type": "VEC2"});
    let text = altered("textures.gltf", "/accessors/1", zeros);
    let world = load_text("accessors", &text, &Options::default()).expect("valid").world;
    let lamp = world.light(world.light_by_name("painted").expect("it emits"));
    for (x, y) in [(-0.5, 0.5), (0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)] {
        let point = seen(&world, DVec3::new(x, y, 1.0), -DVec3::Z);
        assert_eq!(lamp.emit(&point, DVec3::Z), Rgb::new(0.5, 0.0, 0.0));
    }
}

#[test]
fn variants_of_materials_change_nothing() {
    let text =
        altered("box.gltf", "/extensionsUsed/1", serde_json::json!("KHR_materials_variants"));
    let strict = Options { strict: true, ..Options::default() };
    assert!(load_text("variants", &text, &strict).is_ok());
}
