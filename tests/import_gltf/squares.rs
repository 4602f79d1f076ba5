//! Squares under a light: what is cut out, what has no back, and nodes and lists that say nothing.

use crate::compare::{Comparison, assert_agree};
use crate::files::{altered, load, load_text, render, seen};
use approx::assert_relative_eq;
use glam::{DVec3, UVec2};
use pathspace::bsdf::{Bsdf, Lobes, TransportMode};
use pathspace::endpoint::Endpoint;
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Environment, Import, Options};
use pathspace::integrator::{Bidirectional, Depth, PathTracer};
use pathspace::math::Rgb;
use pathspace::render::Render;
use pathspace::scene::Scene;
use serde_json::{Value, json};

/// Pixels of opacity 0, of opacity 0 beside 1, and of opacity 1/5.
const NOTHING: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP4//8/AwAI/AL+eMSysAAAAA\
                       BJRU5ErkJggg==";
const RIGHT_HALF: &str = "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAAEElEQVR42mP4//8/AxD/BwAe6gb60S\
                          rK5QAAAABJRU5ErkJggg==";
const VEIL: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP4//+/MQAJLwMxnNP8iAAAAABJ\
                    RU5ErkJggg==";

/// Squares from -1 to 1 that face z, mesh k of material k; an orthographic camera 1 wide; a point
/// light of 10 cd and a directional light of 2 lx.
fn squares(materials: Value, nodes: Value) -> Value {
    let count = materials.as_array().expect("a list").len();
    let primitive = |material| {
        let attributes = json!({"POSITION": 0, "TEXCOORD_0": 1});
        json!({"primitives": [{"attributes": attributes, "indices": 2, "material": material}]})
    };
    let images = [NOTHING, RIGHT_HALF, VEIL];
    let uri = |png| json!({"uri": format!("data:image/png;base64,{png}")});
    let textures = [0, 1, 2].map(|source| json!({"source": source, "sampler": 0}));
    let roots: Vec<usize> = (0..nodes.as_array().expect("a list").len()).collect();
    json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": roots}],
        "nodes": nodes,
        "materials": materials,
        "meshes": (0..count).map(primitive).collect::<Vec<_>>(),
        "images": images.map(uri),
        "samplers": [{"magFilter": 9728}],
        "textures": textures,
        "cameras": [{
            "type": "orthographic",
            "orthographic": {"xmag": 0.5, "ymag": 0.5, "znear": 0.01, "zfar": 100}
        }],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": 10}, {"type": "directional", "intensity": 2}
        ]}},
        "extensionsUsed": ["KHR_lights_punctual"],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 92, "uri": "data:;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAACAPw\
            AAgD8AAAAAAACAvwAAgD8AAAAAAAAAAAAAgD8AAIA/AACAPwAAgD8AAAAAAAAAAAAAAAAAAAEAAgAAAAIAAwA="}],
    })
}

fn light(index: u32) -> Value {
    json!({"KHR_lights_punctual": {"light": index}})
}

fn strict() -> Options {
    Options { strict: true, ..Options::default() }
}

fn read(document: &Value, options: &Options) -> Import {
    load_text("squares", &document.to_string(), options).unwrap_or_else(|error| panic!("{error}"))
}

/// The mean of the image with up to some scattering events.
fn mean(import: &Import, max_bounces: u32) -> f64 {
    let depth = Depth { max_bounces: Some(max_bounces), ..Depth::default() };
    let path = PathTracer { depth, ..PathTracer::default() };
    render(&import.world, &*import.views[0].camera, &path, 4).mean().r()
}

fn grey() -> Value {
    json!({"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0})
}

/// A floor under a square of which the left half is not there, under a light.
#[test]
fn light_passes_where_a_surface_is_cut_out() {
    for (mode, texture) in [("MASK", 1), ("BLEND", 1), ("MASK", 0), ("BLEND", 0)] {
        for index in [0, 1] {
            let cut = json!({
                "pbrMetallicRoughness": {"baseColorTexture": {"index": texture}},
                "alphaMode": mode
            });
            let document = |x: f64, square: bool| {
                let nodes = json!([
                    {"mesh": 0, "scale": [4, 4, 4]},
                    {"mesh": usize::from(square), "scale": [4, 4, 4],
                        "translation": [0, 0, if square { 1.0 } else { -1.0 }]},
                    {"extensions": light(index), "translation": [0, 0, 2]},
                    {"camera": 0, "translation": [x, 0, 0.5]}
                ]);
                squares(json!([{"pbrMetallicRoughness": grey()}, cut]), nodes)
            };
            for x in [-1.0, 1.0] {
                let lit = mean(&read(&document(x, false), &strict()), 1);
                let shown = mean(&read(&document(x, true), &strict()), 1);
                let is_cut_out = texture == 0 || x < 0.0;
                let expected = if is_cut_out { lit } else { 0.0 };
                assert!(lit > 0.1);
                assert_relative_eq!(shown, expected, max_relative = 1e-12);
            }
        }
    }
}

/// There is no emission where there is no surface, and as much as there is surface.
#[test]
fn emission_is_that_of_what_is_there() {
    let cases = [
        ("MASK", Some(0), 1.0, 0.0),
        ("MASK", Some(1), 1.0, 0.5),
        ("MASK", Some(2), 1.0, 0.0),
        ("MASK", None, 0.25, 0.0),
        ("MASK", None, 0.75, 1.0),
        ("BLEND", Some(0), 1.0, 0.0),
        ("BLEND", Some(1), 1.0, 0.5),
        ("BLEND", Some(1), 0.5, 0.25),
        ("BLEND", Some(2), 1.0, 0.2),
        ("BLEND", None, 0.25, 0.25),
        ("BLEND", None, 0.0, 0.0),
        ("OPAQUE", Some(0), 0.0, 1.0),
    ];
    for (mode, texture, factor, expected) in cases {
        let mut material = json!({
            "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, factor]},
            "emissiveFactor": [1, 1, 1],
            "alphaMode": mode
        });
        if let Some(texture) = texture {
            material["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": texture});
        }
        let nodes = json!([
            {"mesh": 0, "scale": [0.5, 0.5, 0.5]}, {"camera": 0, "translation": [0, 0, 1]}
        ]);
        let options = Options { environment: Environment::None, ..strict() };
        let shown = mean(&read(&squares(json!([material]), nodes), &options), 8);
        assert_relative_eq!(shown, expected, epsilon = 1e-6);
    }
}

#[test]
fn backs_of_single_sided_surfaces_are_not_there() {
    let turned = [0, 1, 0, 0];
    let from_behind = |double_sided: Value| {
        let material = json!({"pbrMetallicRoughness": grey(), "doubleSided": double_sided});
        let nodes = json!([
            {"mesh": 0, "rotation": turned}, {"camera": 0, "translation": [0, 0, 1]}
        ]);
        squares(json!([material]), nodes)
    };
    let white = Options { environment: Environment::Colour(Rgb::WHITE), ..strict() };
    let shown = Options { back_faces: true, ..white.clone() };
    assert_eq!(mean(&read(&from_behind(json!(false)), &white), 2), 1.0);
    let grey_square = mean(&read(&from_behind(json!(false)), &shown), 2);
    assert!((0.4..0.6).contains(&grey_square), "{grey_square}");
    assert_eq!(mean(&read(&from_behind(json!(true)), &white), 2), grey_square);

    // The default material is single-sided, too.
    let mut default = from_behind(json!(false));
    default["meshes"][0]["primitives"][0].as_object_mut().expect("an object").remove("material");
    assert_eq!(mean(&read(&default, &white), 2), 1.0);

    // A floor is seen through the back of a wall above the light, which counts as an event.
    let under_wall = |wall: bool| {
        let nodes = json!([
            {"mesh": 0, "scale": [2, 2, 2]},
            {"mesh": 0, "scale": [2, 2, 2], "rotation": turned,
                "translation": [0, 0, if wall { 2 } else { -2 }]},
            {"extensions": light(0), "translation": [0, 0, 1]},
            {"camera": 0, "translation": [0, 0, 4]}
        ]);
        squares(json!([{"pbrMetallicRoughness": grey()}]), nodes)
    };
    let floor = mean(&read(&under_wall(false), &strict()), 1);
    assert!(floor > 1.0);
    assert_eq!(mean(&read(&under_wall(true), &strict()), 1), 0.0);
    assert_relative_eq!(mean(&read(&under_wall(true), &strict()), 2), floor, max_relative = 1e-12);
}

/// The back of glass is where light leaves it.
#[test]
fn what_transmits_light_keeps_its_back() {
    let world = load("materials.gltf", UVec2::splat(8)).world;
    for (k, images) in [(0, 1), (2, 2), (4, 2), (5, 2)] {
        let x = seen(&world, DVec3::new(3.0 * f64::from(k) + 0.25, 0.125, 1.0), -DVec3::Z);
        let mut count = 0;
        let to_camera = DVec3::new(0.6, 0.0, -0.8);
        world.bsdf(&x).dirac_images(to_camera, TransportMode::Radiance, &mut |_| count += 1);
        assert_eq!(count, images, "{:?}", world.surface_name(&x));
    }
}

/// The box is seen through a fourth wall.
#[test]
fn integrators_agree_behind_a_culled_wall() {
    let mut document: Value =
        serde_json::from_str(&altered("box.gltf", "/asset/version", json!("2.0"))).expect("valid");
    let nodes = document["nodes"].as_array_mut().expect("a list");
    nodes.push(json!({"mesh": 0, "rotation": [0, 1, 0, 0], "translation": [0, 0, 1]}));
    let front = nodes.len() - 1;
    document["nodes"][0]["children"].as_array_mut().expect("a list").push(json!(front));
    let import = read(&document, &strict());
    let depth = Depth { max_bounces: Some(4), ..Depth::default() };
    let path = PathTracer { depth, ..PathTracer::default() };
    let both = Bidirectional { depth, ..Bidirectional::default() };
    let integrators: [(&str, &dyn Render<_>); 2] = [("path", &path), ("bidirectional", &both)];
    let camera = &*import.views[0].camera;
    assert_agree("fourth wall", &import.world, camera, &integrators, &Comparison::default());
}

/// Lights and cameras are turned as their node is, whatever its scale; without a direction they are
/// left out.
#[test]
fn nodes_without_a_size_keep_directions_or_lose_their_light() {
    let document = |scale: [f64; 3], what: Value| {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut node = json!({"scale": scale, "rotation": [half, 0, 0, half]});
        node.as_object_mut().expect("an object").extend(what.as_object().cloned().expect("it is"));
        let nodes = json!([{"mesh": 0}, {"extensions": light(0), "translation": [0, 0, 1]}, node]);
        squares(json!([{"pbrMetallicRoughness": grey()}]), nodes)
    };
    // A quarter around x takes -z to y.
    for scale in [[1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0], [1e-30; 3]] {
        let import = read(&document(scale, json!({"extensions": light(1)})), &strict());
        let sun = import.world.light(import.world.light_by_name("node 2").expect("it is there"));
        let from = |direction: DVec3| SurfacePoint::infinite(DVec3::ZERO, direction);
        let emitted = sun.sample_point(0.5, glam::DVec2::splat(0.5)).expect("a direction").point;
        assert_relative_eq!(emitted.geometric_normal, DVec3::Y, epsilon = 1e-6);
        assert_eq!(sun.emit(&from(DVec3::Y), DVec3::Y), sun.emit(&emitted, DVec3::Y));
        let import = read(&document(scale, json!({"camera": 0})), &strict());
        let camera = &import.views[0].camera;
        let point = camera.sample_point(0.5, glam::DVec2::splat(0.5)).expect("a point").point;
        let seen = camera.sample_direction(&point, glam::DVec2::splat(0.5)).expect("a direction");
        assert_relative_eq!(seen.direction, DVec3::Y, epsilon = 1e-6);
    }
    for (scale, what, lights, view, reason) in [
        ([0.0; 3], json!({"extensions": light(1)}), 1, "whole scene", "no direction"),
        ([0.0, 1.0, 0.0], json!({"extensions": light(1)}), 1, "whole scene", "no direction"),
        ([0.0; 3], json!({"camera": 0}), 1, "whole scene", "camera no direction"),
        ([0.0, 0.0, 1.0], json!({"camera": 0}), 1, "whole scene", "camera no direction"),
    ] {
        let document = document(scale, what);
        let import = read(&document, &Options::default());
        assert_eq!((import.world.light_count(), &*import.views[0].name), (lights, view));
        let warning = import.warnings[0].to_string();
        assert!(import.warnings.len() == 1 && warning.contains(reason), "{warning}");
        let error = load_text("squares", &document.to_string(), &strict()).expect_err(reason);
        assert_eq!(error.to_string(), warning);
    }
    // A point has no direction to lose.
    let import = read(&document([0.0; 3], json!({"extensions": light(0)})), &strict());
    assert_eq!(import.world.light_count(), 2);
}

/// Lists that are missing are empty, and a scene without nodes is one of all nodes.
#[test]
fn what_nothing_depends_on_may_be_missing() {
    let whole = load("box.gltf", UVec2::splat(8)).world.primitive_count();
    let cases = [
        ("/scenes/0", json!({}), whole, "scene 0: it has no nodes: all of the file are shown"),
        ("/scenes/0", json!({"nodes": []}), whole, "scene 0: it has no nodes"),
        ("/scenes", json!([]), whole, ""),
        ("/nodes", Value::Null, 32, "it has no nodes: its meshes are shown"),
        ("/asset", json!({}), whole, "its version is missing"),
        ("/asset", Value::Null, whole, "its version is missing"),
        ("/meshes/0/primitives", Value::Null, 30, "primitives of meshes[0] are missing"),
        ("/cameras/0/type", Value::Null, whole, "the type of cameras[0] is missing"),
        (
            "/materials/0/emissiveTexture",
            json!({}),
            whole,
            "a texture of materials[0] has no index",
        ),
        ("/nodes/1/name", Value::Null, whole, ""),
        (
            "/nodes/1/extensions",
            json!({"KHR_lights_punctual": {}}),
            whole,
            "nodes[1] has no number",
        ),
        ("/animations", json!([{}]), whole, "animations are left out"),
    ];
    for (pointer, value, triangles, reason) in cases {
        let mut text = altered("box.gltf", pointer, value);
        if pointer == "/nodes" {
            text = altered_again(&text, "scenes");
        }
        let import = load_text("missing", &text, &Options::default())
            .unwrap_or_else(|error| panic!("{pointer}: {error}"));
        assert_eq!(import.world.primitive_count(), triangles, "{pointer}");
        let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
        match reason {
            "" => assert!(warnings.is_empty(), "{pointer}: {warnings:?}"),
            _ => assert!(warnings.iter().any(|w| w.contains(reason)), "{pointer}: {warnings:?}"),
        }
    }
    let text = altered("box.gltf", "/asset/version", json!("2.0"));
    load_text("missing", &format!("\u{feff}{text}\0\0"), &strict()).expect("padded");
}

/// A document without one of its keys.
fn altered_again(text: &str, key: &str) -> String {
    let mut document: Value = serde_json::from_str(text).expect("valid");
    document.as_object_mut().expect("an object").remove(key);
    document.as_object_mut().expect("an object").remove("scene");
    document.to_string()
}

/// Equal warnings are one, of the first place.
#[test]
fn equal_warnings_are_counted() {
    let extensions = json!({"EXT_unknown": {}});
    let mut nodes = vec![json!({"extensions": extensions}); 1234];
    nodes.push(json!({"mesh": 0}));
    let import = read(&squares(json!([{}]), nodes.into()), &Options::default());
    let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(import.warnings[0].count, 1234);
    assert!(warnings[0].contains("node 0: the extension") && warnings[0].ends_with("(× 1 234)"));
    assert_eq!(warnings.len(), 2, "no light: {warnings:?}");
}

/// A block that is closed is culled only if a camera is in it.
#[test]
fn solids_seen_from_outside_need_no_culling() {
    let is_culled = |import: &Import, from: DVec3| {
        let x = seen(&import.world, from, -DVec3::Z);
        import.world.bsdf(&x).lobes().intersects(Lobes::DIRAC)
    };
    let before_block = DVec3::new(0.375, -0.75, 3.0);
    let import = load("box.gltf", UVec2::splat(8));
    assert!(!is_culled(&import, before_block));
    assert!(is_culled(&import, DVec3::new(0.0, 0.5, 0.5)), "a wall");
    let inside = altered("box.gltf", "/nodes/9/translation", json!([0.375, -0.75, 0.125]));
    let import = load_text("solids", &inside, &strict()).expect("valid");
    assert!(is_culled(&import, before_block));
}
