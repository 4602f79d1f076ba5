//! Meshes at rest: morph targets, skins, and instances.

use crate::files::{SQUARE, altered, data, directory, load, load_text, seen};
use approx::assert_relative_eq;
use glam::{DAffine3, DMat4, DQuat, DVec2, DVec3, DVec4};
use pathspace::endpoint::Endpoint;
use pathspace::geometry::Triangle;
use pathspace::import::Options;
use pathspace::math::Rgb;
use pathspace::scene::{Scene, World};
use serde_json::json;
use std::f64::consts::FRAC_PI_2;

/// The triangles of a surface.
pub fn triangles(world: &World, name: &str) -> Vec<Triangle> {
    (0..world.primitive_count() as u32)
        .filter_map(|primitive| world.shape(primitive)?.as_triangle())
        .filter(|triangle| {
            let [a, b, c] = triangle.vertices;
            let (center, front) = ((a + b + c) / 3.0, triangle.cross().normalize());
            let at = seen(world, center + 1e-3 * front, -front);
            world.surface_name(&at) == Some(name)
        })
        .collect()
}

#[test]
fn morph_targets_have_the_weights_of_their_nodes() {
    let world = load("poses.gltf", SQUARE).world;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    for (name, shift, lift, tilt) in [
        ("default", DVec3::ZERO, 0.5, 0.375),
        ("aside", DVec3::new(2.0, 3.0, 0.0), 0.0, 0.0),
        ("plain", DVec3::new(0.0, 6.0, 0.0), 0.0, 0.0),
    ] {
        let p = corners.map(|(x, y)| DVec3::new(x, y, 0.0) + shift);
        let p = [p[0], p[1], p[2] + lift * DVec3::Z, p[3]];
        let found: Vec<_> = triangles(&world, name).iter().map(|t| t.vertices).collect();
        assert_eq!(found, [[p[0], p[1], p[2]], [p[0], p[2], p[3]]], "{name}");
        let x = seen(&world, (p[0] + p[1] + p[2]) / 3.0 + DVec3::Z, -DVec3::Z);
        let normal = DVec3::new(tilt, 0.0, 1.0).normalize();
        assert_relative_eq!(x.shading_normal, normal, epsilon = 1e-12);
    }
}

/// The morphed mesh is moved by the mean of the joints' matrices, its normals by the inverse
/// transpose; the nodes above the mesh do not count.
#[test]
fn skins_follow_their_joints() {
    let world = load("poses.gltf", SQUARE).world;
    let parent = DMat4::from_translation(10.0 * DVec3::X) * DMat4::from_scale(DVec3::splat(2.0));
    let first = parent * DMat4::from_translation(DVec3::Z);
    let second = DMat4::from_scale_rotation_translation(
        DVec3::new(1.0, 3.0, 0.5),
        DQuat::from_rotation_z(FRAC_PI_2),
        DVec3::Y,
    );
    let joints = [
        first * DMat4::from_translation(-0.5 * DVec3::Z),
        first * second * DMat4::from_translation(DVec3::new(-0.25, -1.0, 0.0)),
    ];
    let matrices = [0.0, 0.2, 1.0].map(|w| joints[0] * (1.0 - w) + joints[1] * w);
    let vertex = |k: usize| {
        matrices[k / 2].transform_point3(DVec3::new((k % 2) as f64, (k / 2) as f64, 0.25))
    };
    let normal = |k: usize| {
        let normal = DVec4::new(0.3, 0.0, 0.8, 0.0);
        (matrices[k / 2].inverse().transpose() * normal).truncate().normalize()
    };
    let strip = [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]];
    let found = triangles(&world, "bent");
    assert_eq!(found.len(), strip.len());
    for (triangle, corners) in found.iter().zip(strip) {
        let k = corners.iter().position(|&k| vertex(k).distance(triangle.vertices[0]) < 1e-5);
        let k = k.unwrap_or_else(|| panic!("{:?}", triangle.vertices));
        let corners: [usize; 3] = std::array::from_fn(|j| corners[(j + k) % 3]);
        for (found, k) in triangle.vertices.into_iter().zip(corners) {
            assert_relative_eq!(found, vertex(k), epsilon = 1e-5);
        }
        let front = triangle.cross().normalize();
        let x = seen(&world, triangle.vertices.iter().sum::<DVec3>() / 3.0 + front, -front);
        let expected = corners.map(normal).iter().sum::<DVec3>().normalize();
        assert_relative_eq!(x.shading_normal, expected, epsilon = 1e-5);
    }
}

/// Tangents that are made for a normal map make vertices of their own; joints are still found.
#[test]
fn skins_with_normal_maps_follow_their_joints() {
    let expected = load("poses.gltf", SQUARE).world.bounds();
    std::fs::copy(data("two by two.png"), directory("relief").join("two by two.png")).expect("ok");
    let source = std::fs::read_to_string(data("poses.gltf")).expect("readable");
    let mut document: serde_json::Value = serde_json::from_str(&source).expect("valid");
    let ladder = document["meshes"][1]["primitives"][0]["attributes"].clone();
    // Six pairs of the numbers of its positions.
    let positions = ladder["POSITION"].as_u64().expect("an index") as usize;
    let view = document["accessors"][positions]["bufferView"].clone();
    let pairs = json!({"bufferView": view, "componentType": 5126, "count": 6, "type": "VEC2"});
    let accessors = document["accessors"].as_array_mut().expect("a list");
    accessors.push(pairs);
    let uvs = accessors.len() - 1;
    document["meshes"][1]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs.into();
    document["images"] = json!([{"uri": "two by two.png"}]);
    document["textures"] = json!([{"source": 0}]);
    document["materials"][0]["normalTexture"] = json!({"index": 0});
    let import = load_text("relief", &document.to_string(), &Options::default()).expect("valid");
    let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    assert!(!warnings.iter().any(|warning| warning.contains("stored")), "{warnings:?}");
    assert_eq!(import.world.bounds(), expected);
}

#[test]
fn mirroring_joints_keep_the_front() {
    let world = load("poses.gltf", SQUARE).world;
    let lamp = world.light(world.light_by_name("mirrored").expect("it emits"));
    for (side, emitted) in [(DVec3::Z, Rgb::WHITE), (-DVec3::Z, Rgb::BLACK)] {
        let x = seen(&world, DVec3::new(-10.25, 0.5, 0.0) + side, -side);
        assert_eq!(world.surface_name(&x), Some("mirrored"));
        assert_eq!((x.geometric_normal, lamp.emit(&x, side)), (DVec3::Z, emitted));
        let normal = DVec3::new(-0.6, 0.0, 0.8);
        assert_relative_eq!(x.shading_normal, normal, epsilon = 1e-6);
    }
}

/// Whatever is wrong with a skin costs the skin alone.
#[test]
fn bad_skins_leave_the_mesh_as_it_is_stored() {
    let source = std::fs::read_to_string(data("poses.gltf")).expect("readable");
    let mut huge =
        serde_json::from_str::<serde_json::Value>(&source).expect("valid")["nodes"].take();
    for joint in 5..8 {
        huge[joint]["scale"] = json!([1e38, 1e38, 1e38]);
    }
    let cases = [
        ("/scenes/0/nodes", json!([0, 1, 2, 3, 8, 10]), "joint 6 of skin 0 is not in the scene"),
        ("/skins/0/joints", json!([]), "no joints"),
        ("/skins/0/joints", json!([6]), "it names joint 1 of 1"),
        ("/skins/0/joints", json!([6, 7, 8]), "2 inverse bind matrices for 3 joints"),
        ("/skins/0/inverseBindMatrices", json!(0), "Mat4 is needed"),
        ("/nodes", huge, "too far"),
    ];
    let stored = DAffine3::from_translation(100.0 * DVec3::X)
        * DAffine3::from_scale(DVec3::new(-5.0, 1.0, 1.0));
    for (pointer, value, reason) in cases {
        let text = altered("poses.gltf", pointer, value);
        let import = load_text("skins", &text, &Options::default()).expect(reason);
        let warning = import.warnings[0].to_string();
        assert!(warning.contains(reason) && warning.contains("as it is stored"), "{warning}");
        let from = stored.transform_point3(DVec3::new(0.5, 0.75, 1.0));
        let x = seen(&import.world, from, -DVec3::Z);
        assert_eq!(import.world.surface_name(&x), Some("bent"), "{reason}");
        assert_relative_eq!(x.position, from - 0.75 * DVec3::Z, epsilon = 1e-9);
    }
}

/// Instances are moved before their node is; the mirrored one keeps its front.
#[test]
fn instances_are_placed_by_their_attributes() {
    let world = load("instances.gltf", SQUARE).world;
    assert_eq!((world.primitive_count(), world.light_count()), (6, 3));
    for (name, center, half, mirrored) in [
        ("square[0]", DVec3::new(0.0, 0.0, 3.0), [2.0, 1.0], false),
        ("square[1]", DVec3::new(4.0, 0.0, 3.0), [1.0, 0.25], false),
        ("square[2]", DVec3::new(10.0, 0.0, 4.0), [2.0, 0.5], true),
    ] {
        let found = triangles(&world, name);
        let vertices = || found.iter().flat_map(|triangle| triangle.vertices);
        let (least, greatest) =
            vertices().fold((center, center), |(a, b), vertex| (a.min(vertex), b.max(vertex)));
        let extent = DVec3::new(half[0], half[1], 0.0);
        assert_relative_eq!(least, center - extent, epsilon = 1e-12);
        assert_relative_eq!(greatest, center + extent, epsilon = 1e-12);
        assert!(found.len() == 2 && found.iter().all(|t| t.cross().z > 0.0), "{name}");
        // The corner at u = 1, v = 0 shows which way it is turned.
        let near_one =
            if mirrored { DVec3::new(-0.9, 0.9, 0.0) } else { DVec3::new(0.9, 0.9, 0.0) };
        let near_one = if name == "square[1]" { DVec3::new(-0.9, 0.9, 0.0) } else { near_one };
        let x = seen(&world, center + near_one * extent + DVec3::Z, -DVec3::Z);
        assert_relative_eq!(x.uv, DVec2::new(0.95, 0.05), epsilon = 1e-6);
    }
}

#[test]
fn bad_instances_are_shown_once() {
    let attributes = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";
    for (value, reason) in [
        (json!({}), "missing"),
        (json!({"TRANSLATION": 99}), "missing"),
        (json!({"TRANSLATION": 0}), "Vec3 is needed"),
        (json!({"TRANSLATION": 1, "SCALE": 3}), "differ in number"),
        (json!({"ROTATION": 4}), "Vec4 is needed"),
    ] {
        let text = altered("instances.gltf", attributes, value);
        let import = load_text("instances", &text, &Options::default()).expect(reason);
        let warning = import.warnings[0].to_string();
        assert!(warning.contains(reason) && warning.contains("shown once"), "{warning}");
        assert_eq!(import.world.primitive_count(), 2, "{reason}");
    }
}

#[test]
fn instances_stay_within_the_limits() {
    let source = std::fs::read_to_string(data("instances.gltf")).expect("readable");
    let with = |elements, triangles, text: &str| {
        let mut options = Options::default();
        (options.limits.elements, options.limits.triangles) = (elements, triangles);
        load_text("limits", text, &options).map_err(|error| error.to_string())
    };
    assert!(with(9, 6, &source).is_ok());
    let error = with(9, 5, &source).expect_err("six triangles");
    assert!(error.contains("more than 5 triangles"), "{error}");
    let mut many: serde_json::Value = serde_json::from_str(&source).expect("valid");
    let zeros = json!({"componentType": 5126, "count": 1_000_000, "type": "VEC3"});
    many["accessors"][1] = zeros;
    many["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] =
        json!({"TRANSLATION": 1});
    let error = with(1000, 10_000_000, &many.to_string()).expect_err("a million");
    assert!(error.contains("more than 1000 instances"), "{error}");
}
