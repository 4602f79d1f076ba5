//! glTF files against the same scenes built by hand, against closed forms, and against everything that can be wrong with them.
//! `tests/data/gltf/make.py` wrote the files.

#![cfg(feature = "gltf")]

#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;

use approx::assert_relative_eq;
use compare::{Comparison, assert_agree};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, UVec2};
use pathspace::bsdf::{Bsdf, MetallicRoughness, Model};
use pathspace::endpoint::{Camera, PinholeCamera};
use pathspace::film::Image;
use pathspace::geometry::{Shape, SurfacePoint};
use pathspace::import::{Error, Import, Limits, Options, gltf};
use pathspace::integrator::{Bidirectional, Depth, LightTracer, PathTracer};
use pathspace::math::Rgb;
use pathspace::render::{Budget, Render, Settings, unattended};
use pathspace::scene::{Emission, Material, Mesh, Scene, World, WorldBuilder};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

const SQUARE: UVec2 = UVec2::splat(16);

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf").join(name)
}

fn load(name: &str, resolution: UVec2) -> Import {
    gltf::load(data(name), resolution, &Options { strict: true, ..Options::default() }).unwrap_or_else(|error| panic!("{error}"))
}

fn render(world: &World, camera: &dyn Camera, integrator: &dyn Render<World>, samples: u32) -> Image {
    let settings = Settings { budget: Budget::Samples(samples), seed: 7, ..Settings::default() };
    let rendering = integrator.render(world, camera, &settings, &mut unattended).expect("valid settings");
    assert_eq!(rendering.counters.non_finite, 0);
    rendering.image
}

/// What a ray from a point sees.
fn seen(world: &World, from: DVec3, direction: DVec3) -> SurfacePoint {
    world.intersect(&SurfacePoint::dirac(from), direction.normalize()).expect("aimed at a surface")
}

// The box ---------------------------------------------------------------------------------------------------------------------------------

fn square() -> Mesh {
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        uvs: Some(vec![DVec2::new(0.0, 1.0), DVec2::new(1.0, 1.0), DVec2::new(1.0, 0.0), DVec2::new(0.0, 0.0)]),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn cube() -> Mesh {
    let sign = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
    let positions = (0..8).map(|k| DVec3::new(sign(k & 4), sign(k & 2), sign(k & 1))).collect();
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let indices = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, indices, ..Mesh::default() }
}

fn surface(color: [f64; 3], metalness: f64, roughness: f64, relative_ior: f64) -> Material {
    Material::MetallicRoughness {
        base_color: Rgb(color).into(),
        metallic_roughness: Rgb::new(0.0, roughness, metalness).into(),
        relative_ior,
    }
}

/// The number as a file in single precision holds it.
fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

fn placed(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> DAffine3 {
    let rotation = DQuat::from_array(rotation.map(single)).normalize();
    DAffine3::from_scale_rotation_translation(DVec3::from(scale), rotation, DVec3::from(translation))
}

fn box_by_hand() -> (World, PinholeCamera) {
    let mut builder = WorldBuilder::new();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let (one, none) = ([1.0; 3], [0.0, 0.0, 0.0, 1.0]);
    let right = DAffine3 { matrix3: DMat3::from_cols(DVec3::Z, DVec3::Y, -DVec3::X), translation: DVec3::X };
    let objects = [
        ("back", square(), surface([0.75; 3], 0.0, 1.0, 1.5), placed([0.0, 0.0, -1.0], none, one)),
        ("floor", square(), surface([0.75; 3], 0.0, 1.0, 1.5), placed([0.0, -1.0, 0.0], [-half, 0.0, 0.0, half], one)),
        ("ceiling", square(), surface([0.75; 3], 0.0, 1.0, 1.5), placed([0.0, 1.0, 0.0], [half, 0.0, 0.0, half], one)),
        ("left", square(), surface([0.625, 0.0625, 0.0625], 0.0, 1.0, 1.5), placed([-1.0, 0.0, 0.0], [0.0, half, 0.0, half], one)),
        ("right", square(), surface([0.125, 0.5, 0.125], 0.0, 1.0, 1.5), right),
        ("lamp", square(), surface([0.0; 3], 0.0, 1.0, 1.5), placed([0.0, 0.9375, 0.0], [half, 0.0, 0.0, half], [0.25; 3])),
        (
            "metal block",
            cube(),
            surface([0.875, 0.625, 0.25], 1.0, 0.5, 1.5),
            placed([-0.375, -0.5, -0.25], [0.0, 0.25, 0.0, 0.968_245_836_551_854_2], [0.25, 0.5, 0.25]),
        ),
        (
            "plastic block",
            cube(),
            surface([0.125, 0.25, 0.75], 0.25, 0.375, 1.75),
            placed([0.375, -0.75, 0.125], none, [-0.25, 0.25, 0.25]),
        ),
    ];
    for (name, mesh, material, transform) in objects {
        let material = builder.add_material(name, material).expect("valid");
        let id = builder.add_mesh(name, &mesh, transform, material).expect("valid");
        if name == "lamp" {
            builder.set_emission(id, Emission { radiance: Rgb::new(16.0, 12.0, 8.0), two_sided: false }).expect("valid");
        }
    }
    let fov = single(0.75).to_degrees();
    let camera = PinholeCamera::new(DVec3::new(0.0, 0.0, 3.5), DVec3::new(0.0, 0.0, 2.5), DVec3::Y, fov, UVec2::new(24, 16));
    (builder.build().expect("valid"), camera.expect("valid"))
}

#[test]
fn a_file_gives_the_image_of_the_scene_built_by_hand_to_the_bit() {
    let (world, camera) = box_by_hand();
    let expected = render(&world, &camera, &PathTracer::default(), 16);
    for name in ["box.gltf", "box.glb"] {
        let import = load(name, UVec2::splat(24));
        assert_eq!(import.views.len(), 1);
        assert_eq!((import.views[0].name.as_str(), import.views[0].camera.film()), ("eye", camera.film()));
        assert_eq!(render(&import.world, &*import.views[0].camera, &PathTracer::default(), 16), expected, "{name}");
    }
    assert!(expected.mean().luminance() > 0.1);
}

/// The front of a mirrored block is its outside.
#[test]
fn mirrored_nodes_keep_their_front_outside() {
    let world = load("box.gltf", SQUARE).world;
    let x = seen(&world, DVec3::new(0.375, -0.75, 3.0), -DVec3::Z);
    assert_eq!((world.surface_name(&x), x.geometric_normal), (Some("plastic block"), DVec3::Z));
}

#[test]
fn integrators_agree_on_a_file() {
    let import = load("box.gltf", UVec2::splat(12));
    let depth = Depth { max_bounces: Some(3), ..Depth::default() };
    let path = PathTracer { depth, ..PathTracer::default() };
    let light = LightTracer { depth, ..LightTracer::default() };
    let both = Bidirectional { depth, ..Bidirectional::default() };
    let integrators: [(&str, &dyn Render<World>); 3] = [("path", &path), ("light", &light), ("bidirectional", &both)];
    assert_agree("box.gltf", &import.world, &*import.views[0].camera, &integrators, &Comparison::default());
}

// Lights ----------------------------------------------------------------------------------------------------------------------------------

#[test]
fn punctual_lights_have_their_closed_form() {
    let to_light = DVec3::new(1.0, 0.0, 2.0).normalize();
    let model = MetallicRoughness::new(Rgb::splat(0.5), 0.0, 1.0, 1.5).expect("valid");
    let scattered = model.eval(to_light, DVec3::Z) * to_light.z;
    let expected = [Rgb::new(8.0, 4.0, 2.0) / 5.0, Rgb::new(0.75, 1.5, 3.0), Rgb::splat(8.0) / 5.0];
    let path = PathTracer { depth: Depth { max_bounces: Some(1), ..Depth::default() }, ..PathTracer::default() };
    for (index, irradiance) in expected.into_iter().enumerate() {
        // One light alone, since next-event estimation would choose the most powerful one nearly always.
        let nodes = serde_json::json!([3 * index, 3 * index + 1, 3 * index + 2]);
        let import = load_text("lights", &altered("lights.gltf", "/scenes/0/nodes", nodes), &Options::default()).expect("valid");
        assert_eq!((import.world.light_count(), import.warnings.len()), (1, 0));
        let mean = render(&import.world, &*import.views[0].camera, &path, 1).mean();
        for channel in 0..3 {
            assert_relative_eq!(mean[channel], (irradiance * scattered)[channel], max_relative = 1e-3);
        }
    }
    let import = load("lights.gltf", SQUARE);
    let spot = import.world.light(import.world.light_by_name("light 2").expect("named"));
    let axis = -to_light;
    let side = DVec3::Y;
    let outer = single(0.25);
    for angle in [0.0f64, 0.05, 0.2, 0.24, 0.26] {
        let t = ((angle.cos() - outer.cos()) / (1.0 - outer.cos())).max(0.0);
        let emitted = spot.emit(&SurfacePoint::dirac(DVec3::ZERO), axis * angle.cos() + side * angle.sin());
        assert_relative_eq!(emitted.r(), 8.0 * t * t, epsilon = 1e-5);
    }
    assert_relative_eq!(spot.power().r(), 8.0 * std::f64::consts::TAU * (1.0 - outer.cos()) / 3.0, max_relative = 1e-12);
}

// Materials -------------------------------------------------------------------------------------------------------------------------------

#[test]
fn materials_are_those_built_by_hand() {
    let import = gltf::load(data("materials.gltf"), UVec2::new(88, 88), &Options::default()).expect("valid");
    let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.is_empty(), "{warnings:?}");
    let film = import.views[0].camera.film().resolution;
    assert_eq!(film, UVec2::new(88, 8), "16.5 to 1.5");
    let white = |metalness, roughness| surface([1.0; 3], metalness, roughness, 1.5);
    let blend =
        |front: Material, amount: f64| Material::Blend { components: Box::new([Material::Null, front]), amount: Rgb::splat(amount).into() };
    let glass = Material::Dielectric { relative_ior: 1.5 };
    // 1/4 of it is glass, and 1/2 of the whole, 2/3 of the rest, metal
    let partly = Material::Mixture { components: Box::new([white(0.5 / 0.75, 0.0), glass]), weights: [0.75, 0.25] };
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
        assert_eq!(import.world.bsdf(&x).model(true), material.model().expect("valid"), "{name}");
        assert_eq!(import.world.bsdf(&x).model(false), material.model().expect("valid"), "{name}");
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
    let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    assert!(
        warnings.len() == 1 && warnings[0].ends_with("material 0 \"painted\": its emission is not reduced by its alpha"),
        "{warnings:?}"
    );
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
        let point = seen(world, DVec3::new(x, y, 1.0), -DVec3::Z);
        let front = MetallicRoughness::new(Rgb(color), metalness, roughness, 1.5).expect("valid");
        let (a, b) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.28, 0.96));
        let value = world.bsdf(&point).eval(a, b);
        let emitted = lamp.emit(&point, DVec3::Z);
        for channel in 0..3 {
            assert_relative_eq!(value[channel], (front.eval(a, b) * alpha)[channel], max_relative = 1e-6);
            // The factor of the base colour does not apply to emission.
            let emission = 0.5 * color[channel] / if channel == 1 { 0.5 } else { 1.0 };
            assert_relative_eq!(emitted[channel], emission, max_relative = 1e-12);
        }
    }
    // Only the lower left texel is in the range of the transform.
    for (x, y) in [(-0.5, 0.5), (0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)] {
        let point = seen(world, DVec3::new(3.0 + x, y, 1.0), -DVec3::Z);
        let expected = MetallicRoughness::new(Rgb::new(0.0, 0.0, 1.0), 0.0, 1.0, 1.5).expect("valid");
        assert_eq!(world.bsdf(&point).model(true), Model::from(pathspace::bsdf::SimpleModel::from(expected)));
    }
}

// Meshes ----------------------------------------------------------------------------------------------------------------------------------

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
        let Some(Shape::Triangle(triangle)) = world.shape(primitive as u32) else { panic!("primitive {primitive} is no triangle") };
        let rotations = [0, 1, 2].map(|k| [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]]);
        assert!(rotations.contains(&triangle.vertices), "primitive {primitive}: {:?}", triangle.vertices);
    }
}

/// The last primitive's normals, as bytes, and uv, as 16-bit numbers, lie between its positions.
#[test]
fn interleaved_attributes_are_told_apart() {
    let source = std::fs::read_to_string(data("meshes.gltf")).expect("readable");
    let mut document: serde_json::Value = serde_json::from_str(&source).expect("valid");
    document["meshes"][0]["primitives"] = serde_json::json!([document["meshes"][0]["primitives"][4]]);
    let world = load_text("interleaved", &document.to_string(), &Options::default()).expect("valid").world;
    let x = seen(&world, DVec3::new(0.5, 0.25, 1.0), -DVec3::Z);
    assert_relative_eq!(x.uv, DVec2::new(0.5, 0.25), epsilon = 1e-12);
    let (a, b, c) = (DVec3::Z, DVec3::new(1.0, 0.0, 1.0).normalize(), DVec3::new(0.0, 1.0, 1.0).normalize());
    assert_relative_eq!(x.shading_normal, (a * 0.25 + b * 0.5 + c * 0.25).normalize(), epsilon = 1e-12);
}

// What can be wrong -----------------------------------------------------------------------------------------------------------------------

/// A directory of its own for a test's files.
fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gltf").join(name);
    std::fs::create_dir_all(&path).expect("writable");
    path
}

fn load_bytes(name: &str, bytes: &[u8], options: &Options) -> Result<Import, Error> {
    let path = directory(name).join("scene.gltf");
    std::fs::write(&path, bytes).expect("writable");
    gltf::load(path, SQUARE, options)
}

fn load_text(name: &str, text: &str, options: &Options) -> Result<Import, Error> {
    load_bytes(name, text.as_bytes(), options)
}

/// The box with a part replaced, given as a path of keys.
fn altered(file: &str, pointer: &str, value: serde_json::Value) -> String {
    let source = std::fs::read_to_string(data(file)).expect("readable");
    let mut document: serde_json::Value = serde_json::from_str(&source).expect("valid");
    let (parent, key) = pointer.rsplit_once('/').expect("a path");
    let parent = document.pointer_mut(parent).unwrap_or_else(|| panic!("no {parent}"));
    match parent {
        serde_json::Value::Array(list) => list[key.parse::<usize>().expect("an index")] = value,
        _ => parent[key] = value,
    }
    document.to_string()
}

#[test]
fn malformed_files_are_refused_for_their_reason() {
    use serde_json::json;
    let cases = [
        ("/nodes/8/children", json!([0]), "node 0 \"room\": it is reached twice"),
        ("/nodes/1/children", json!([1]), "it is reached twice"),
        ("/nodes/1/children", json!([77]), "Index out of bounds"),
        ("/nodes/1/rotation", json!([1, 1, 1, 1]), "not a unit quaternion"),
        ("/nodes/5/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "not affine"),
        ("/nodes/1/scale", json!([1, 0, 0]), "not invertible"),
        ("/scene", json!(3), "Index out of bounds"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(99), "accessor 99"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(2), "Missing data"),
        ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(3), "accessor 3: Vec2 is needed"),
        ("/meshes/0/primitives/0/indices", json!(0), "unsigned whole numbers"),
        ("/accessors/0/count", json!(5), "do not fit"),
        ("/accessors/0/count", json!(u64::MAX), "exceed the limits"),
        ("/accessors/0/count", json!(1_000_000_000), "do not fit"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "do not fit"),
        ("/accessors/2/count", json!(5), "whole triangles"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "buffer view 0"),
        ("/bufferViews/0/byteStride", json!(4), "do not fit"),
        ("/buffers/0/byteLength", json!(1_000_000), "should have 1000000 bytes"),
        ("/buffers/0/uri", json!("data:;base64,%"), "data URI"),
        ("/buffers/0/uri", json!("../scene.bin"), "outside of the scene's directory"),
        ("/buffers/0/uri", json!("missing.bin"), "missing.bin"),
        ("/buffers/0/uri", json!("."), "is not a file"),
        ("/buffers/0/uri", json!("https://host/scene.bin"), "only files and data URIs"),
        ("/buffers/0/uri", json!("file:///etc/passwd"), "only files and data URIs"),
        ("/buffers/0/uri", serde_json::Value::Null, "it has no uri"),
        ("/materials/0/pbrMetallicRoughness/roughnessFactor", json!(1.5), "material 0 \"white\""),
        ("/materials/3/emissiveFactor", json!([-1, 0, 0]), "radiance"),
        ("/cameras/0/perspective", json!({"yfov": 4, "znear": 1}), "field of view"),
        ("/cameras/0/perspective/aspectRatio", json!(0), "aspect ratio"),
        ("/cameras/0", json!({"type": "orthographic", "perspective": {"yfov": 1, "znear": 1}}), "lacks the properties"),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression is required"),
    ];
    for (pointer, value, reason) in cases {
        let text = altered("box.gltf", pointer, value.clone());
        let error = load_text("malformed", &text, &Options::default()).expect_err(pointer).to_string();
        assert!(error.contains(reason) && error.contains("scene.gltf"), "{pointer} = {value}: {error}");
    }
    let files: [(&[u8], &str); 6] = [
        (b"", "EOF"),
        (b"glTF", "version ?"),
        (b"glTF\x01\0\0\0\x0c\0\0\0", "version 1"),
        (b"glTF\x02\0\0\0\xff\0\0\0", "ends before"),
        (b"glTF\x02\0\0\0\x0c\0\0\0", "first chunk"),
        (b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON", "longer than the file"),
    ];
    for (bytes, reason) in files {
        let error = load_bytes("malformed", bytes, &Options::default()).expect_err(reason).to_string();
        assert!(error.contains(reason), "{error}");
    }
    assert!(gltf::load(directory("malformed"), SQUARE, &Options::default()).is_err(), "a directory");
    assert!(gltf::load(data("box.gltf"), UVec2::ZERO, &Options::default()).is_err(), "no pixels");
}

#[test]
fn sparse_accessors_and_images_are_checked() {
    use serde_json::json;
    let cases = [
        ("meshes.gltf", "/accessors/3/count", json!(2_000_000), "exceed the limits"),
        ("meshes.gltf", "/accessors/3/sparse/count", json!(4), "4 sparse values"),
        ("meshes.gltf", "/accessors/2/sparse/values/byteOffset", json!(4), "do not fit"),
        ("meshes.gltf", "/accessors/2/sparse/indices/componentType", json!(5126), "Invalid value"),
        ("textures.gltf", "/images/0/uri", json!("textures.bin"), "neither PNG nor JPEG"),
        ("textures.gltf", "/images/0/uri", json!("%2e%2e/textures.bin"), "outside of the scene's directory"),
        ("textures.gltf", "/images/0", json!({}), "either a uri or a buffer view"),
        ("textures.gltf", "/textures/0/source", json!(9), "Index out of bounds"),
        ("lights.gltf", "/extensions/KHR_lights_punctual/lights/0/intensity", json!(-1), "intensity"),
        ("lights.gltf", "/extensions/KHR_lights_punctual/lights/2/spot/innerConeAngle", json!(1), "inner angle"),
        ("lights.gltf", "/extensions", json!({}), "Index out of bounds"),
    ];
    for (file, pointer, value, reason) in cases {
        for other in ["textures.bin", "two by two.png"] {
            std::fs::copy(data(other), directory("checked").join(other)).expect("copied");
        }
        let error = load_text("checked", &altered(file, pointer, value.clone()), &Options::default()).expect_err(pointer).to_string();
        assert!(error.contains(reason), "{file} {pointer} = {value}: {error}");
    }
}

#[test]
fn files_outside_are_read_only_if_allowed() {
    let inner = directory("outside/inner");
    std::fs::copy(data("textures.bin"), directory("outside").join("textures.bin")).expect("copied");
    std::fs::copy(data("two by two.png"), inner.join("two by two.png")).expect("copied");
    let path = inner.join("scene.gltf");
    let mut allowed = Options::default();
    allowed.limits.outside_files = true;
    let absolute = directory("outside").join("textures.bin").display().to_string();
    for uri in ["../textures.bin", "%2E%2E/textures.bin", "./../../outside/textures.bin", &absolute] {
        std::fs::write(&path, altered("textures.gltf", "/buffers/0/uri", serde_json::json!(uri))).expect("writable");
        let error = gltf::load(&path, SQUARE, &Options::default()).expect_err(uri).to_string();
        assert!(error.contains("outside of the scene's directory"), "{error}");
        gltf::load(&path, SQUARE, &allowed).unwrap_or_else(|error| panic!("{uri}: {error}"));
    }
}

#[test]
fn limits_hold() {
    let limited = |limits: Limits| gltf::load(data("textures.gltf"), SQUARE, &Options { limits, ..Options::default() });
    let with = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        limited(limits).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(with(|limits| limits.triangles = 3).contains("more than 3 triangles"));
    assert!(with(|limits| limits.triangles = 0).contains("exceed the limits"));
    assert!(with(|limits| limits.pixels = 255).contains("16 × 16 pixels"));
    assert!(with(|limits| limits.bytes = 255).contains("more bytes than the limit"));
    assert!(with(|limits| limits.elements = 5).contains("the limit is 5"));
    assert_eq!(with(|_| {}), "");
}

#[test]
fn what_is_left_out_is_named_and_strict_readers_refuse_it() {
    use serde_json::json;
    let cases = [
        ("box.gltf", "/extensionsUsed", json!(["KHR_materials_sheen"]), "extension \"KHR_materials_sheen\": it is not supported"),
        (
            "box.gltf",
            "/materials/0/extensions",
            json!({"KHR_materials_unlit": {}}),
            "material 0 \"white\": the extension KHR_materials_unlit",
        ),
        (
            "box.gltf",
            "/nodes/1/extensions",
            json!({"EXT_mesh_gpu_instancing": {}}),
            "node 1 \"back\": the extension EXT_mesh_gpu_instancing",
        ),
        ("box.gltf", "/nodes/1/weights", json!([0.5]), "morph targets"),
        ("box.gltf", "/nodes/9/scale", json!([-1, 1, 1]), "mirroring of a camera"),
        ("box.gltf", "/meshes/0/primitives/0/mode", json!(1), "points and lines"),
        ("box.gltf", "/meshes/0/primitives/0/attributes/COLOR_0", json!(0), "colours of vertices"),
        ("box.gltf", "/materials/3/emissiveFactor", json!([0, 0, 0]), "no light"),
        ("lights.gltf", "/extensions/KHR_lights_punctual/lights/0/range", json!(5), "the range of light 0"),
        ("materials.gltf", "/materials/4/pbrMetallicRoughness/roughnessFactor", json!(0.5), "rough thin wall"),
        ("materials.gltf", "/materials/2/pbrMetallicRoughness/baseColorFactor", json!([1, 0.5, 1, 1]), "colours its reflections, too"),
        (
            "materials.gltf",
            "/materials/2/extensions/KHR_materials_volume",
            json!({"thicknessFactor": 1, "attenuationDistance": 1, "attenuationColor": [1, 0, 0]}),
            "absorption",
        ),
    ];
    for (file, pointer, value, reason) in cases {
        let text = altered(file, pointer, value);
        let import = load_text("warnings", &text, &Options::default()).unwrap_or_else(|error| panic!("{pointer}: {error}"));
        let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
        assert!(!warnings.is_empty() && warnings.iter().all(|warning| warning.contains(reason)), "{pointer}: {warnings:?}");
        let error = load_text("warnings", &text, &Options { strict: true, ..Options::default() }).expect_err(pointer).to_string();
        assert!(error.contains(reason), "{pointer}: {error}");
    }
}

// Damage ----------------------------------------------------------------------------------------------------------------------------------

const HOSTILE: [&str; 12] =
    ["0", "-1", "1", "7", "255", "65535", "4294967295", "18446744073709551615", "1e38", "-1e300", "null", "[[[[[[[[[[[[]]]]]]]]]]]]"];

/// Replaces the k-th number of a text.
fn with_number(text: &str, k: usize, value: &str) -> String {
    let is_part = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
    let mut starts = Vec::new();
    let mut quoted = false;
    let mut previous = ' ';
    for (at, c) in text.char_indices() {
        quoted ^= c == '"';
        if !quoted && (c.is_ascii_digit() || c == '-') && !is_part(previous) {
            starts.push(at);
        }
        previous = c;
    }
    let start = starts[k % starts.len()];
    let end = text[start..].find(|c| !is_part(c)).map_or(text.len(), |length| start + length);
    format!("{}{value}{}", &text[..start], &text[end..])
}

const FILES: [&str; 6] = ["box.gltf", "box.glb", "lights.gltf", "materials.gltf", "textures.gltf", "meshes.gltf"];

/// Reads damaged bytes; the only thing to check is that it returns, soon.
fn survive(name: &str, bytes: &[u8]) {
    for other in ["textures.bin", "two by two.png"] {
        let copy = directory(name).join(other);
        if !copy.exists() {
            std::fs::copy(data(other), copy).expect("copied");
        }
    }
    let mut limits = Limits::default();
    (limits.bytes, limits.elements, limits.triangles, limits.pixels) = (1 << 20, 10_000, 100_000, 1 << 20);
    let start = std::time::Instant::now();
    let result = load_bytes(name, bytes, &Options { limits, ..Options::default() });
    assert!(start.elapsed().as_secs() < 10, "{:?}", result.err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_never_panic(
        file in 0..FILES.len(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in prop::option::weighted(0.1, any::<prop::sample::Index>()),
    ) {
        let mut bytes = std::fs::read(data(FILES[file])).expect("readable");
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        survive("damaged", &bytes);
    }

    #[test]
    fn hostile_numbers_never_panic(file in 0..FILES.len(), numbers in prop::collection::vec((any::<u16>(), 0..HOSTILE.len()), 1..4)) {
        let name = if FILES[file] == "box.glb" { "box.gltf" } else { FILES[file] };
        let mut text = std::fs::read_to_string(data(name)).expect("readable");
        for (k, value) in numbers {
            text = with_number(&text, usize::from(k), HOSTILE[value]);
        }
        survive("hostile", text.as_bytes());
    }
}
