//! Normal maps: what their texels mean, along the axes of the image or of a mesh's tangents.

use crate::files::{altered, data, directory, load_text, seen};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::import::Options;
use pathspace::scene::World;
use serde_json::{Value, json};

/// The file of two squares, of which one material has the blue image as its normal map: blue stands
/// for x = y = -1, the grey of 188 for x = y = z, and red and green for normals behind the surface.
fn mapped(name: &str, material: usize, normals: Value, change: impl Fn(&mut Value)) -> World {
    for other in ["textures.bin", "two by two.png"] {
        std::fs::copy(data(other), directory(name).join(other)).expect("copied");
    }
    let text = altered("textures.gltf", &format!("/materials/{material}/normalTexture"), normals);
    let mut document: Value = serde_json::from_str(&text).expect("valid");
    document["materials"][material]["alphaMode"] = json!("OPAQUE");
    change(&mut document);
    let import = load_text(name, &document.to_string(), &Options::default()).expect("valid");
    let about_normals = |warning: &&pathspace::import::Warning| warning.reason.contains("normal");
    assert_eq!(import.warnings.iter().find(about_normals), None);
    import.world
}

fn expect(world: &World, x: f64, y: f64, normal: [f64; 3]) {
    let point = seen(world, DVec3::new(x, y, 1.0), -DVec3::Z);
    assert_eq!(point.geometric_normal, DVec3::Z);
    let expected = DVec3::from_array(normal).normalize();
    assert_relative_eq!(point.shading_normal, expected, epsilon = 1e-6);
}

#[test]
fn texels_are_normals_along_the_axes_of_the_image() {
    let world = mapped("normals", 0, json!({"index": 0, "scale": 0.5}), |_| {});
    for (x, y, normal) in [
        (-0.5, 0.5, [0.0, 0.0, 1.0]),
        (0.5, 0.5, [0.0, 0.0, 1.0]),
        (-0.5, -0.5, [-0.5, -0.5, 1.0]),
        (0.5, -0.5, [0.5, 0.5, 1.0]),
    ] {
        expect(&world, x, y, normal);
    }
}

/// Only the blue texel is in the range of the transform, which turns the image's axes to -y and x.
#[test]
fn transforms_turn_the_axes() {
    let transform =
        json!({"offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5]});
    let normals = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    let world = mapped("turned-normals", 1, normals, |_| {});
    expect(&world, 3.5, -0.5, [-1.0, 1.0, 1.0]);
}

/// The tangent y with both signs of the bitangent, beside normals without which it would not count.
#[test]
fn tangents_of_a_mesh_are_its_axes() {
    for (side, normal) in [(1.0f32, [0.5, -0.5, 1.0]), (-1.0, [-0.5, -0.5, 1.0])] {
        let name = format!("tangents {side}");
        let vectors = |vector: &[f32]| vector.repeat(4).into_iter().flat_map(f32::to_le_bytes);
        let bytes = vectors(&[0.0, 0.0, 1.0]).chain(vectors(&[0.0, 1.0, 0.0, side]));
        std::fs::write(directory(&name).join("more.bin"), bytes.collect::<Vec<_>>())
            .expect("writable");
        let world = mapped(&name, 0, json!({"index": 0, "scale": 0.5}), |document| {
            let add = |document: &mut Value, list: &str, item: Value| {
                let list = document[list].as_array_mut().expect("a list");
                list.push(item);
                list.len() - 1
            };
            let buffer = add(document, "buffers", json!({"byteLength": 112, "uri": "more.bin"}));
            for (attribute, kind, offset, length) in
                [("NORMAL", "VEC3", 0, 48), ("TANGENT", "VEC4", 48, 64)]
            {
                let view = json!({"buffer": buffer, "byteOffset": offset, "byteLength": length});
                let view = add(document, "bufferViews", view);
                let accessor =
                    json!({"bufferView": view, "componentType": 5126, "count": 4, "type": kind});
                let accessor = add(document, "accessors", accessor);
                document["meshes"][0]["primitives"][0]["attributes"][attribute] = json!(accessor);
            }
        });
        expect(&world, -0.5, -0.5, normal);
    }
}
