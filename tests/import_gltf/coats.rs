//! Clear coats of files.

use crate::files::{altered, data, directory, load_text, seen};
use crate::materials::surface;
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::bsdf::{Bsdf, Coated};
use pathspace::import::{Import, Options};
use pathspace::scene::Scene;
use serde_json::{Value, json};

fn value(import: &Import, from: DVec3) -> [f64; 3] {
    let point = seen(&import.world, from, -DVec3::Z);
    let bsdf = import.world.bsdf(&point);
    bsdf.eval(DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.28, 0.96)).0
}

/// The file of textures, the first of whose materials is white, rough metal under a coat.
fn coated(name: &str, coat: Value, normals: Option<Value>) -> Import {
    for other in ["textures.bin", "two by two.png"] {
        std::fs::copy(data(other), directory(name).join(other)).expect("copied");
    }
    let mut material = json!({
        "pbrMetallicRoughness": {"roughnessFactor": 0.5},
        "extensions": {"KHR_materials_clearcoat": coat},
    });
    if let Some(normals) = normals {
        material["normalTexture"] = normals;
    }
    let text = altered("textures.gltf", "/materials/0", material);
    load_text(name, &text, &Options::default()).expect("valid")
}

fn reasons(import: &Import) -> Vec<&str> {
    import.warnings.iter().map(|warning| &*warning.reason).filter(|r| r.contains("coat")).collect()
}

/// The image of textures in linear numbers: red, green over blue, grey of 188.
#[test]
fn factors_and_textures_make_coats() {
    let texture = json!({"index": 0});
    let both = json!({
        "clearcoatFactor": 0.5, "clearcoatTexture": texture,
        "clearcoatRoughnessFactor": 0.8, "clearcoatRoughnessTexture": texture,
    });
    let plain = json!({"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.8});
    let grey = 188.0 / 255.0;
    let places = [
        (-0.5, 0.5, 1.0, 0.0),
        (0.5, 0.5, 0.0, 1.0),
        (-0.5, -0.5, 0.0, 0.0),
        (0.5, -0.5, grey, grey),
    ];
    let base = surface([1.0; 3], 1.0, 0.5, 1.5).mixture().expect("valid").expect("built in");
    for (name, coat, textured) in [("coat", plain, false), ("coat-textures", both, true)] {
        let import = coated(name, coat, None);
        assert_eq!(reasons(&import), [""; 0]);
        for (x, y, red, green) in places {
            let [red, green] = if textured { [red, green] } else { [1.0, 1.0] };
            let expected = Coated::new(base, 0.5 * red, 0.8 * green).expect("valid");
            let expected = expected.eval(DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.28, 0.96));
            for (here, there) in value(&import, DVec3::new(x, y, 1.0)).into_iter().zip(expected.0) {
                assert_relative_eq!(here, there, max_relative = 1e-6);
            }
        }
    }
}

#[test]
fn what_is_left_out_is_said() {
    let shared = "its clear coat has the normals of what is under it";
    let texture = json!({"index": 0});
    let normals = || json!({"clearcoatFactor": 1, "clearcoatNormalTexture": {"index": 0}});
    for (name, coat, base, expected) in [
        ("coat-normals", normals(), None, vec![shared]),
        ("base-normals", json!({"clearcoatFactor": 1}), Some(texture.clone()), vec![shared]),
        ("same-normals", normals(), Some(texture.clone()), vec![]),
        ("no-coat", json!({"clearcoatNormalTexture": {"index": 0}}), None, vec![]),
    ] {
        assert_eq!(reasons(&coated(name, coat, base)), expected, "{name}");
    }
    for (name, coat) in [
        ("coat-range", json!({"clearcoatFactor": 1.5})),
        ("coat-word", json!({"clearcoatFactor": "much"})),
        ("coat-index", json!({"clearcoatFactor": 1, "clearcoatTexture": {"index": 99}})),
        ("coat-info", json!({"clearcoatFactor": 1, "clearcoatRoughnessTexture": 3})),
    ] {
        let import = coated(name, coat, None);
        let [reason] = reasons(&import)[..] else { panic!("{name}: {:?}", import.warnings) };
        assert!(reason.starts_with("its clear coat is left out: clearcoat"), "{reason}");
    }
}
