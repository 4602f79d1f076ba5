//! Refusals, and warnings of what is left out.

use crate::files::{SQUARE, altered, data, directory, load_bytes, load_text};
use glam::UVec2;
use pathspace::import::{Limits, Options, gltf};

/// The reason for which an object is left out with a warning, or a file refused.
enum Reason {
    LeftOut(&'static str),
    Refused(&'static str),
}
use Reason::{LeftOut, Refused};

/// Loads a document with a fault; in strict mode that is an error in any case.
fn check(name: &str, text: &str, reason: Reason) {
    let (reason, is_refused) = match reason {
        LeftOut(reason) => (reason, false),
        Refused(reason) => (reason, true),
    };
    let strict = Options { strict: true, ..Options::default() };
    let error = load_text(name, text, &strict).expect_err(reason).to_string();
    assert!(error.contains(reason) && error.contains("scene.gltf"), "{reason}: {error}");
    let result = load_text(name, text, &Options::default());
    assert_eq!(result.is_err(), is_refused, "{reason}");
    let said: Vec<String> = match result {
        Ok(import) => import.warnings.iter().map(ToString::to_string).collect(),
        Err(error) => vec![error.to_string()],
    };
    assert!(said.iter().any(|said| said.contains(reason)), "{reason}: {said:?}");
}

#[test]
fn malformed_objects_are_left_out_and_malformed_files_refused() {
    use serde_json::json;
    let cases = [
        ("/nodes/8/children", json!([0]), LeftOut("node 0 \"room\": it is reached twice")),
        ("/nodes/1/children", json!([1]), LeftOut("it is reached twice")),
        ("/nodes/1/children", json!([77]), Refused("Index out of bounds")),
        ("/nodes/1/rotation", json!([1, 1, 1, 1]), LeftOut("not a unit quaternion")),
        (
            "/nodes/5/matrix",
            json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            LeftOut("not affine"),
        ),
        ("/scene", json!(3), Refused("Index out of bounds")),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(99), Refused("accessor 99")),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(2),
            LeftOut("accessor 2: Vec3 is needed"),
        ),
        (
            "/meshes/0/primitives/0/attributes/TEXCOORD_0",
            json!(3),
            LeftOut("accessor 3: Vec2 is needed"),
        ),
        ("/meshes/0/primitives/0/indices", json!(0), LeftOut("unsigned whole numbers")),
        ("/accessors/0/count", json!(5), LeftOut("do not fit")),
        ("/accessors/0/count", json!(u64::MAX), Refused("exceed the limits")),
        ("/accessors/0/count", json!(100_000_000), Refused("100000000 elements")),
        ("/accessors/0/byteOffset", json!(u64::MAX), LeftOut("do not fit")),
        ("/accessors/2/count", json!(5), LeftOut("whole triangles")),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), LeftOut("buffer view 0")),
        ("/bufferViews/0/byteStride", json!(4), LeftOut("do not fit")),
        ("/buffers/0/byteLength", json!(1_000_000), Refused("should have 1000000 bytes")),
        ("/buffers/0/uri", json!("data:;base64,%"), Refused("data URI")),
        ("/buffers/0/uri", json!("../scene.bin"), Refused("outside of the scene's directory")),
        ("/buffers/0/uri", json!("missing.bin"), Refused("missing.bin")),
        ("/buffers/0/uri", json!("."), Refused("is not a file")),
        ("/buffers/0/uri", json!("https://host/scene.bin"), Refused("only files and data URIs")),
        ("/buffers/0/uri", json!("file:///etc/passwd"), Refused("only files and data URIs")),
        ("/buffers/0/uri", serde_json::Value::Null, Refused("it has no uri")),
        (
            "/materials/0/pbrMetallicRoughness/roughnessFactor",
            json!(1.5),
            LeftOut("material 0 \"white\""),
        ),
        ("/materials/3/emissiveFactor", json!([-1, 0, 0]), LeftOut("radiance")),
        ("/cameras/0/perspective", json!({"yfov": 4, "znear": 1}), LeftOut("field of view")),
        ("/cameras/0/perspective/aspectRatio", json!(0), LeftOut("aspect ratio")),
        (
            "/cameras/0",
            json!({"type": "orthographic", "perspective": {"yfov": 1, "znear": 1}}),
            LeftOut("lacks the properties"),
        ),
        (
            "/extensionsRequired",
            json!(["KHR_animation_pointer"]),
            Refused("KHR_animation_pointer is required"),
        ),
    ];
    for (pointer, value, reason) in cases {
        check("malformed", &altered("box.gltf", pointer, value), reason);
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
        let error =
            load_bytes("malformed", bytes, &Options::default()).expect_err(reason).to_string();
        assert!(error.contains(reason), "{error}");
    }
    for text in ["2", "[]", "null", "true", "\"asset\"", "{}", "{\"asset\":2}"] {
        let error = load_text("malformed", text, &Options::default()).expect_err(text).to_string();
        assert!(error.contains("scene.gltf"), "{text}: {error}");
    }
    assert!(
        gltf::load(directory("malformed"), SQUARE, &Options::default()).is_err(),
        "a directory"
    );
    assert!(gltf::load(data("box.gltf"), UVec2::ZERO, &Options::default()).is_err(), "no pixels");
}

#[test]
fn sparse_accessors_and_images_are_checked() {
    use serde_json::json;
    let cases = [
        ("meshes.gltf", "/accessors/3/count", json!(2_000_000), Refused("exceed the limits")),
        ("meshes.gltf", "/accessors/3/sparse/count", json!(4), LeftOut("4 sparse values")),
        ("meshes.gltf", "/accessors/2/sparse/values/byteOffset", json!(4), LeftOut("do not fit")),
        (
            "meshes.gltf",
            "/accessors/2/sparse/indices/componentType",
            json!(5126),
            Refused("Invalid value"),
        ),
        ("textures.gltf", "/textures/0/source", json!(9), Refused("Index out of bounds")),
        (
            "lights.gltf",
            "/extensions/KHR_lights_punctual/lights/0/intensity",
            json!(-1),
            LeftOut("intensity"),
        ),
        (
            "lights.gltf",
            "/extensions/KHR_lights_punctual/lights/2/spot/innerConeAngle",
            json!(1),
            LeftOut("inner angle"),
        ),
        ("lights.gltf", "/extensions", json!({}), Refused("Index out of bounds")),
    ];
    for (file, pointer, value, reason) in cases {
        for other in ["textures.bin", "two by two.png"] {
            std::fs::copy(data(other), directory("checked").join(other)).expect("copied");
        }
        check("checked", &altered(file, pointer, value), reason);
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
    for uri in ["../textures.bin", "%2E%2E/textures.bin", "./../../outside/textures.bin", &absolute]
    {
        std::fs::write(&path, altered("textures.gltf", "/buffers/0/uri", serde_json::json!(uri)))
            .expect("writable");
        let error = gltf::load(&path, SQUARE, &Options::default()).expect_err(uri).to_string();
        assert!(error.contains("outside of the scene's directory"), "{error}");
        gltf::load(&path, SQUARE, &allowed).unwrap_or_else(|error| panic!("{uri}: {error}"));
    }
}

#[test]
fn limits_hold() {
    let limited = |limits: Limits| {
        gltf::load(data("textures.gltf"), SQUARE, &Options { limits, ..Options::default() })
    };
    let with = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        limited(limits).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(with(|limits| limits.triangles = 3).contains("more than 3 triangles"));
    assert!(with(|limits| limits.triangles = 0).contains("exceed the limits"));
    assert!(with(|limits| limits.pixels = 255).contains("16 × 16 pixels"));
    assert!(with(|limits| limits.bytes = 255).contains("more bytes than the limit"));
    assert!(with(|limits| limits.elements = 5).contains("objects of JSON; the limit is 4 times 5"));
    assert!(with(|limits| limits.elements = 12).contains("the limit is 12"));
    assert_eq!(with(|_| {}), "");
    // Small files that would take much memory, or much time.
    let with = |elements: u64, triangles: u64, text: String| {
        let mut limits = Limits::default();
        (limits.elements, limits.triangles) = (elements, triangles);
        load_text("limits", &text, &Options { limits, ..Options::default() })
            .expect_err("too much")
            .to_string()
    };
    let start = std::time::Instant::now();
    let materials = format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"images\": [{}]}}",
        vec!["{}"; 401].join(",")
    );
    assert!(with(100, 1000, materials).contains("403 objects of JSON"));
    let points = vec![serde_json::json!({"attributes": {"POSITION": 0}, "mode": 0}); 1000];
    let mut many = serde_json::from_str::<serde_json::Value>(&altered(
        "box.gltf",
        "/meshes/0/primitives",
        points.into(),
    ))
    .expect("valid");
    many["nodes"] = vec![serde_json::json!({"mesh": 0}); 10_000].into();
    many["scenes"][0]["nodes"] = (0..10_000).collect::<Vec<usize>>().into();
    assert!(with(1_000_000, 100_000, many.to_string()).contains("more than 100000 triangles"));
    assert!(start.elapsed().as_secs() < 10);
}

#[test]
fn what_is_left_out_is_named_and_strict_readers_refuse_it() {
    use serde_json::json;
    let cases = [
        (
            "box.gltf",
            "/extensionsUsed",
            json!(["KHR_materials_sheen"]),
            "extension \"KHR_materials_sheen\": it is not supported",
        ),
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
            "node 1 \"back\": the attributes of EXT_mesh_gpu_instancing are missing",
        ),
        ("poses.gltf", "/skins/0/joints", json!([]), "node 4 \"bent\": its skin or its mesh has"),
        ("box.gltf", "/nodes/1/scale", json!([1, 0, 0]), "node 1 \"back\": its transform leaves"),
        ("box.gltf", "/nodes/9/scale", json!([-1, 1, 1]), "mirroring of a camera"),
        ("box.gltf", "/meshes/0/primitives/0/mode", json!(1), "points and lines"),
        ("box.gltf", "/meshes/0/primitives/0/attributes/COLOR_0", json!(1), "colours of vertices"),
        ("box.gltf", "/materials/3/emissiveFactor", json!([0, 0, 0]), "no light"),
        (
            "lights.gltf",
            "/extensions/KHR_lights_punctual/lights/0/range",
            json!(5),
            "the range of light 0",
        ),
        (
            "materials.gltf",
            "/materials/4/pbrMetallicRoughness/roughnessFactor",
            json!(0.5),
            "rough thin wall",
        ),
    ];
    for (file, pointer, value, reason) in cases {
        let text = altered(file, pointer, value);
        let import = load_text("warnings", &text, &Options::default())
            .unwrap_or_else(|error| panic!("{pointer}: {error}"));
        let warnings: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
        assert!(
            !warnings.is_empty() && warnings.iter().all(|warning| warning.contains(reason)),
            "{pointer}: {warnings:?}"
        );
        let error = load_text("warnings", &text, &Options { strict: true, ..Options::default() })
            .expect_err(pointer)
            .to_string();
        assert!(error.contains(reason), "{pointer}: {error}");
    }
}
