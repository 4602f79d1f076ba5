//! The decision for an environment, and the options that make it.

use crate::files::{altered, directory, load, load_text};
use approx::assert_relative_eq;
use glam::{DVec3, UVec2};
use pathspace::endpoint::Endpoint;
use pathspace::film::{Image, ImageFile};
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Environment, Import, Options, mitsuba};
use pathspace::math::Rgb;
use pathspace::scene::Scene;
use serde_json::json;

/// The radiance that comes from a direction, if there is an environment.
fn radiance(import: &Import, from: DVec3) -> Option<Rgb> {
    let light = import.world.light(import.world.environment()?);
    Some(light.emit(&SurfacePoint::infinite(DVec3::ZERO, -from), -from))
}

/// A triangle that emits what an image of one pixel shows.
fn with_emissive_pixel(png: &str) -> String {
    json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}
        ]}],
        "materials": [{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}],
        "textures": [{"source": 0}],
        "images": [{"uri": format!("data:image/png;base64,{png}")}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 24},
        ],
        "buffers": [{"byteLength": 60, "uri": "data:;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAA\
            AAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAD8AAIA/"}],
    })
    .to_string()
}

const BLACK: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNgYGAAAAAEAAH2FzhVAAAAAEl\
                     FTkSuQmCC";
/// Two levels of 255.
const NEARLY_BLACK: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNgYmICAAAQAA\
                            ecKSGTAAAAAElFTkSuQmCC";

/// A lamp that is turned to the outside of its box shines at nothing.
fn with_label() -> String {
    altered("box.gltf", "/nodes/6/translation", json!([0, -3, 0]))
}

#[test]
fn files_that_nothing_lights_are_shown_in_a_white_environment() {
    let lights = |intensity: f64| {
        let lights = json!([
            {"type": "point", "intensity": intensity}, {"type": "directional", "intensity": 0},
            {"type": "spot", "intensity": 0, "spot": {}}
        ]);
        altered("lights.gltf", "/extensions/KHR_lights_punctual/lights", lights)
    };
    let cases = [
        ("no emission", altered("box.gltf", "/materials/3/emissiveFactor", json!([0, 0, 0]))),
        ("faint lamp", altered("box.gltf", "/materials/3/emissiveFactor", json!([0, 1e-4, 0]))),
        ("label", with_label()),
        ("black texture", with_emissive_pixel(BLACK)),
        ("nearly black texture", with_emissive_pixel(NEARLY_BLACK)),
        ("lights without intensity", lights(0.0)),
    ];
    for (name, text) in cases {
        let import = load_text("environment", &text, &Options::default()).expect(name);
        assert_eq!(radiance(&import, DVec3::Y), Some(Rgb::WHITE), "{name}");
        assert_eq!(import.warnings.len(), 1, "{name}: {:?}", import.warnings);
        let warning = import.warnings[0].to_string();
        assert!(warning.contains("it is shown in a white environment"), "{name}: {warning}");
        assert!(import.notes.is_empty(), "{name}: {:?}", import.notes);
        let strict = Options { strict: true, ..Options::default() };
        let error = load_text("environment", &text, &strict).expect_err(name).to_string();
        assert_eq!(error, warning, "{name}");
        // Who chooses loses nothing.
        let strict = Options { environment: Environment::None, ..strict };
        let import = load_text("environment", &text, &strict).expect(name);
        assert!(import.world.environment().is_none() && import.notes.is_empty(), "{name}");
    }
    let import = load_text("environment", &lights(1.0), &Options::default()).expect("a light");
    assert!(import.world.environment().is_none(), "one light is enough");
}

#[test]
fn lights_and_lamps_need_no_environment() {
    let strength = |strength: f64| {
        let pointer = "/materials/3/extensions/KHR_materials_emissive_strength/emissiveStrength";
        altered("box.gltf", pointer, json!(strength))
    };
    let glowing = altered("nodes.gltf", "/materials/0/emissiveFactor", json!([0.1, 0.1, 0.1]));
    let cases = [
        ("strong lamp", strength(16.0), "its emission lights it"),
        ("weak lamp", strength(1.0), "its emission lights it"),
        ("glow alone", glowing, "its emission lights it"),
        (
            "punctual lights",
            altered("lights.gltf", "/asset/version", json!("2.0")),
            "its own lights light it",
        ),
    ];
    for (name, text, note) in cases {
        let strict = Options { strict: true, ..Options::default() };
        let import = load_text("lamps", &text, &strict).expect(name);
        assert!(import.world.environment().is_none(), "{name}");
        assert_eq!(import.notes, [format!("{note}: no environment is added")], "{name}");
    }
}

#[test]
fn options_choose_the_environment() {
    let strict = Options { strict: true, ..Options::default() };
    let import = load("box.gltf", UVec2::splat(8));
    assert_eq!((radiance(&import, DVec3::Y), import.world.light_count()), (None, 1));

    let colour = Rgb::new(0.25, 0.5, 2.0);
    let path = directory("chosen").join("sky.hdr");
    // The upper half is bright; up is +y.
    let sky = Image::from_fn(4, 2, |_, y| Rgb::splat(if y == 0 { 4.0 } else { 1.0 }));
    ImageFile::from(sky).save(&path).expect("writable");
    let xml = directory("chosen").join("scene.xml");
    let emitter = "<emitter type='constant'><rgb name='radiance' value='7'/></emitter>";
    let sensor = "<sensor type='perspective'/>";
    std::fs::write(&xml, format!("<scene version='3.0.0'>{sensor}{emitter}</scene>"))
        .expect("writable");
    for (environment, up, down) in [
        (Environment::Colour(colour), colour, colour),
        (Environment::File(path.clone()), Rgb::splat(4.0), Rgb::splat(1.0)),
    ] {
        let options = Options { environment, ..strict.clone() };
        let text = altered("box.gltf", "/asset/version", json!("2.0"));
        let box_in_it = load_text("chosen", &text, &options).expect("valid");
        let in_place = mitsuba::load(&xml, &options, []).expect("valid");
        assert_eq!(box_in_it.world.light_count(), 2);
        assert_eq!(in_place.world.light_count(), 1);
        assert!(in_place.notes[0].contains("gives way"), "{:?}", in_place.notes);
        for import in [box_in_it, in_place] {
            for (direction, expected) in [(DVec3::Y, up), (-DVec3::Y, down)] {
                let seen = radiance(&import, direction).expect("an environment");
                (0..3).for_each(|c| assert_relative_eq!(seen[c], expected[c], max_relative = 1e-2));
            }
        }
    }
    let options = Options { environment: Environment::None, ..strict.clone() };
    let dark = mitsuba::load(&xml, &options, []).expect_err("nothing is left").to_string();
    assert!(dark.contains("empty") || dark.contains("no"), "{dark}");
    for path in [path.with_file_name("none.hdr"), path.with_extension("txt")] {
        let options = Options { environment: Environment::File(path), ..strict.clone() };
        let error = mitsuba::load(&xml, &options, []).expect_err("no image").to_string();
        assert!(error.contains("none.hdr") || error.contains("sky.txt"), "{error}");
    }
}
