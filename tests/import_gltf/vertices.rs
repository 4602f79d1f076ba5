//! What vertices give to textures: colours, and a second set of coordinates.

use crate::files::{data, directory, load_text, seen};
use approx::assert_relative_eq;
use glam::{DMat3, DVec3};
use pathspace::bsdf::{Bsdf, MetallicRoughness};
use pathspace::geometry::SurfacePoint;
use pathspace::import::Options;
use pathspace::math::Rgb;
use pathspace::scene::{Scene, World};
use serde_json::{Value, json};

/// A triangle from (-1, -1) over (1, -1) to (0, 1) with more attributes: the name, the numbers of
/// each vertex, and the vertices.
fn triangle(name: &str, material: Value, attributes: &[(&str, usize, &[f32])]) -> World {
    changed(name, material, attributes, |_| {})
}

/// The same in a file with something else changed.
fn changed(
    name: &str,
    material: Value,
    attributes: &[(&str, usize, &[f32])],
    change: impl Fn(&mut Value),
) -> World {
    let positions: &[f32] = &[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    let (mut bytes, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    let mut named = serde_json::Map::new();
    for &(attribute, width, values) in [("POSITION", 3, positions)].iter().chain(attributes) {
        let length = 4 * values.len();
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": length}));
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        let mut accessor = json!({"bufferView": accessors.len(), "componentType": 5126, "count": 3, "type": format!("VEC{width}")});
        if attribute == "POSITION" {
            accessor["min"] = json!([-1, -1, 0]);
            accessor["max"] = json!([1, 1, 0]);
        }
        named.insert(attribute.to_owned(), json!(accessors.len()));
        accessors.push(accessor);
    }
    let mut document = json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": named, "material": 0}]}],
        "materials": [material],
        "images": [{"uri": "two%20by%20two.png"}],
        "samplers": [{"magFilter": 9728}],
        "textures": [{"source": 0, "sampler": 0}],
        "buffers": [{"uri": "vertices.bin", "byteLength": bytes.len()}],
        "bufferViews": views,
        "accessors": accessors,
    });
    change(&mut document);
    std::fs::write(directory(name).join("vertices.bin"), bytes).expect("writable");
    std::fs::copy(data("two by two.png"), directory(name).join("two by two.png")).expect("copied");
    let import = load_text(name, &document.to_string(), &Options::default()).expect("valid");
    // Nothing is said but that there is no light.
    assert!(import.warnings.len() <= 1, "{:?}", import.warnings);
    import.world
}

/// What is seen at the point with these barycentric coordinates, times π.
fn value(world: &World, [a, b, c]: [f64; 3]) -> Rgb {
    let point = seen(world, DVec3::new(b - a, c - a - b, 1.0), -DVec3::Z);
    world.bsdf(&point).eval(DVec3::Z, DVec3::Z)
}

fn rough(color: [f64; 3], metalness: f64, roughness: f64) -> Rgb {
    let model = MetallicRoughness::new(Rgb(color), metalness, roughness, 1.5).expect("valid");
    model.eval(DVec3::Z, DVec3::Z)
}

fn assert_close(a: Rgb, b: Rgb) {
    for channel in 0..3 {
        assert_relative_eq!(a[channel], b[channel], max_relative = 1e-6);
    }
}

/// Red, green and blue corners, the last one half there, times a factor.
#[test]
fn colours_of_vertices_multiply_the_base_colour() {
    let colors: &[f32] = &[1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.5];
    let opaque: Vec<f32> = colors.chunks(4).flat_map(|color| color[..3].to_vec()).collect();
    let material = |mode: &str| {
        json!({"alphaMode": mode, "pbrMetallicRoughness":
            {"baseColorFactor": [1, 0.5, 1, 0.75], "metallicFactor": 0}})
    };
    let blend = triangle("colours", material("BLEND"), &[("COLOR_0", 4, colors)]);
    let three = triangle("opaque colours", material("BLEND"), &[("COLOR_0", 3, &opaque)]);
    let ignored = triangle("solid colours", material("OPAQUE"), &[("COLOR_0", 4, colors)]);
    for place @ [a, b, c] in [[0.5, 0.25, 0.25], [0.125, 0.125, 0.75]] {
        let expected = rough([a, 0.5 * b, c], 0.0, 1.0);
        assert_close(value(&blend, place), expected * (0.75 * (a + b + 0.5 * c)));
        assert_close(value(&three, place), expected * 0.75);
        assert_close(value(&ignored, place), expected);
    }
}

/// The base colour lies at the second set, which shows the blue texel, and metalness and roughness
/// at the first, which shows the green one.
#[test]
fn each_texture_has_its_own_coordinates() {
    let (green, blue) = ([0.75, 0.25].repeat(3), [0.25, 0.75].repeat(3));
    let sets: &[(&str, usize, &[f32])] = &[("TEXCOORD_0", 2, &green), ("TEXCOORD_1", 2, &blue)];
    let material = |base: u32, surface: u32| {
        json!({"pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0, "texCoord": base},
            "metallicRoughnessTexture": {"index": 0, "texCoord": surface}}})
    };
    let place = [0.25, 0.25, 0.5];
    for (base, surface, expected) in [
        (1, 0, rough([0.0, 0.0, 1.0], 0.0, 1.0)),
        (0, 1, rough([0.0, 1.0, 0.0], 1.0, 0.0)),
        (1, 1, rough([0.0, 0.0, 1.0], 1.0, 0.0)),
    ] {
        let world = triangle(&format!("sets {base}{surface}"), material(base, surface), sets);
        assert_close(value(&world, place), expected);
    }
}

/// A normal map at the second set, in which u grows along y and v against x, is turned with it.
#[test]
fn normal_maps_have_their_own_coordinates() {
    let turned: &[f32] = &[-0.75, 1.1, -0.75, 0.1, 0.25, 0.6];
    let blue = [0.25f32, 0.75].repeat(3);
    let sets: &[(&str, usize, &[f32])] = &[("TEXCOORD_0", 2, &blue), ("TEXCOORD_1", 2, turned)];
    let material = json!({"normalTexture": {"index": 0, "texCoord": 1, "scale": 0.5},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let world = triangle("turned set", material, sets);
    // u = 0.1, v = 0.6: blue, x = y = -0.5 and z = 1 along y and x
    let point = seen(&world, DVec3::new(0.0, 0.7, 1.0), -DVec3::Z);
    let expected = DVec3::new(-0.5, -0.5, 1.0).normalize();
    assert_relative_eq!(point.shading_normal, expected, epsilon = 1e-6);
}

/// What is cut away is where the alpha of vertices times that of the image, 1 where it is red and
/// 1/4 where it is blue, is below the cutoff.
#[test]
fn alpha_of_vertices_cuts() {
    let colors: &[f32] = &[1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let material = json!({"alphaMode": "MASK", "alphaCutoff": 0.5,
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    for (name, v, alpha) in [("red", 0.25f32, 1.0), ("blue", 0.75, 0.25)] {
        let uvs = [0.25f32, v].repeat(3);
        let sets: &[(&str, usize, &[f32])] = &[("TEXCOORD_0", 2, &uvs), ("COLOR_0", 4, colors)];
        let world = triangle(&format!("{name} cut by vertices"), material.clone(), sets);
        for [a, b, c] in [[0.25, 0.25, 0.5], [0.75, 0.125, 0.125]] {
            let origin = SurfacePoint::dirac(DVec3::new(b - a, c - a - b, 1.0));
            let is_there = (1.0 - a) * alpha >= 0.5;
            assert_eq!(world.intersect(&origin, -DVec3::Z).is_some(), is_there, "{name} {a}");
        }
    }
}

/// A joint takes along the axes of normal maps, given or made, and what else vertices have.
#[test]
fn skins_keep_what_vertices_have() {
    let uvs: &[f32] = &[0.1, 0.9, 0.4, 0.9, 0.25, 0.6];
    let colors: &[f32] = &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let normals = [0.0f32, 0.6, 0.8].repeat(3);
    let tangents = [0.0f32, 0.8, -0.6, -1.0].repeat(3);
    let (joints, weights) = ([0.0f32; 12], [1.0f32, 0.0, 0.0, 0.0].repeat(3));
    let all: [(&str, usize, &[f32]); 6] = [
        ("TEXCOORD_1", 2, uvs),
        ("COLOR_0", 3, colors),
        ("NORMAL", 3, &normals),
        ("JOINTS_0", 4, &joints),
        ("WEIGHTS_0", 4, &weights),
        ("TANGENT", 4, &tangents),
    ];
    let material = json!({"normalTexture": {"index": 0, "texCoord": 1, "scale": 0.5},
        "pbrMetallicRoughness": {"metallicFactor": 0}});
    let half = 0.5f64.sqrt();
    for (kind, attributes) in [("given", &all[..]), ("made", &all[..5])] {
        let still = triangle(&format!("still {kind}"), material.clone(), attributes);
        for (name, joint, x_axis, y_axis) in [
            ("turned", json!({"rotation": [0, 0, half, half]}), DVec3::Y, -DVec3::X),
            ("mirrored", json!({"scale": [-1, 1, 1]}), -DVec3::X, DVec3::Y),
        ] {
            let name = format!("{name} {kind}");
            let moved = changed(&name, material.clone(), attributes, |document| {
                document["skins"] = json!([{"joints": [1]}]);
                document["nodes"] = json!([{"mesh": 0, "skin": 0}, joint]);
            });
            let matrix = DMat3::from_cols(x_axis, y_axis, DVec3::Z);
            let place = DVec3::new(0.1, -0.2, 1.0);
            let [still_point, point] = [(&still, place), (&moved, matrix * place)]
                .map(|(world, from)| seen(world, from, -DVec3::Z));
            let expected = matrix * still_point.shading_normal;
            assert!(still_point.shading_normal.distance(DVec3::new(0.0, 0.6, 0.8)) > 0.1);
            assert_relative_eq!(point.shading_normal, expected, epsilon = 1e-6);
            let [still_value, value] = [(&still, &still_point), (&moved, &point)]
                .map(|(world, point)| world.bsdf(point).eval(DVec3::Z, DVec3::Z));
            assert_close(value, still_value);
            assert!(value.r() != value.b());
        }
    }
}
