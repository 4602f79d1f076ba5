//! Bodies that absorb.

use crate::files::{altered, data, directory, load_text, seen};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Import, Options};
use pathspace::math::Rgb;
use pathspace::scene::Scene;
use serde_json::{Value, json};

fn filled(name: &str, volume: Value) -> Import {
    for other in ["textures.bin", "two by two.png"] {
        std::fs::copy(data(other), directory(name).join(other)).expect("copied");
    }
    let extensions = json!({
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": volume,
    });
    let text = altered("textures.gltf", "/materials/0/extensions", extensions);
    let mut document: Value = serde_json::from_str(&text).expect("valid");
    document["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(0);
    load_text(name, &document.to_string(), &Options::default()).expect("valid")
}

/// The share of light that passes over a distance behind the surface, and in front of it.
fn passing(import: &Import, distance: f64) -> [Rgb; 2] {
    let surface = seen(&import.world, DVec3::new(-0.5, 0.5, 1.0), -DVec3::Z);
    [-distance, distance].map(|z| {
        let other = SurfacePoint::dirac(surface.position + DVec3::Z * z);
        import.world.transmittance(&surface, &other)
    })
}

#[test]
fn the_attenuation_colour_is_left_after_the_attenuation_distance() {
    let volume = json!({
        "thicknessFactor": 1,
        "attenuationDistance": 0.25,
        "attenuationColor": [0.5, 1, 0],
    });
    let import = filled("volume", volume);
    let [behind, before] = passing(&import, 0.5);
    assert_relative_eq!(behind.r(), 0.25, max_relative = 1e-12);
    assert_eq!([behind.g(), behind.b()], [1.0, 0.0]);
    assert_eq!(before, Rgb::WHITE);
}

#[test]
fn thin_walls_and_infinite_distances_absorb_nothing() {
    for (name, volume) in [
        ("thin", json!({"attenuationDistance": 0.25, "attenuationColor": [0.5, 0.5, 0.5]})),
        ("clear", json!({"thicknessFactor": 1, "attenuationColor": [0.5, 0.5, 0.5]})),
    ] {
        assert_eq!(passing(&filled(name, volume), 0.5), [Rgb::WHITE; 2], "{name}");
    }
}
