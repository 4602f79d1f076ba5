//! The grammar of files, and the state that directives change.

use crate::files::{Directory, PROBE, emitted, seen};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::import::Options;
use pathspace::math::Rgb;
use pathspace::scene::World;

/// The radiance of an emitting sphere around the origin.
fn glow(world: &World) -> Rgb {
    emitted(world, DVec3::Z * 5.0, DVec3::NEG_Z)
}

/// Different ways to write one file.
#[test]
fn one_scene_may_be_written_in_many_ways() {
    let directory = Directory::new("ways");
    directory.write("parts/light.pbrt", "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3]");
    let cases = [
        "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3]\nShape \"sphere\" \"float radius\" 2",
        "AreaLightSource \"diffuse\" \"color L\" [ 1.0 2. +3e0 ] Shape \"sphere\" \"float radius\"[2]",
        "AreaLightSource\"diffuse\"\"rgb L\"[1 2 3]#comment \"\nShape # \"disk\"\n\"sphere\"\"float radius\"2",
        "AreaLightSource \"diffuse\" \"bool twosided\" \"true\" \"rgb L\" [1 2 3]\n\tShape\r\n\"sphere\" \"float  radius\" .2e1",
        "AreaLightSource \"area\" \"bool twosided\" [true] \"rgb L\" [1 2 3]\nShape \"sphere\" \"float radius\" 2",
        "Include \"parts/light.pbrt\"\nShape \"sphere\" \"float radius\" 2",
        "Attribute \"shape\" \"float radius\" 2\nAttribute \"light\" \"rgb L\" [1 2 3]\nAreaLightSource \"diffuse\"\nShape \"sphere\"",
        "Attribute \"shape\" \"float radius\" 7\nAttribute \"shape\" \"float radius\" 3\nInclude \"parts/light.pbrt\"\nShape \"sphere\" \"float radius\" 2",
        "Attribute \"shape\" \"float radius\" 3\nAttribute \"shape\" \"float radius\" 2\nInclude \"parts/light.pbrt\"\nShape \"sphere\"",
        "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 1\nScale 2 2 2\nShape \"sphere\"\nWorldEnd",
    ];
    for text in cases {
        let world = directory.load(&format!("{PROBE}{text}")).world;
        assert_eq!(glow(&world), Rgb::new(1.0, 2.0, 3.0), "{text}");
        assert_relative_eq!(seen(&world, DVec3::Z * 5.0, DVec3::NEG_Z).position.z, 2.0);
    }
}

#[test]
fn imports_leave_the_state_alone() {
    let directory = Directory::new("imports");
    let part = "Translate 0 0 1\nAreaLightSource \"diffuse\"\nMakeNamedMaterial \"m\" \"string type\" \"diffuse\"";
    directory.write("parts/part.pbrt", part);
    let rest = "NamedMaterial \"m\"\nShape \"sphere\"";
    for (directive, height, radiance) in [("Import", 1.0, 0.0), ("Include", 2.0, 1.0)] {
        let text = format!("{PROBE}{directive} \"parts/part.pbrt\"\n{rest}");
        let world = directory.load(&text).world;
        assert_eq!(glow(&world), Rgb::splat(radiance));
        assert_relative_eq!(seen(&world, DVec3::Z * 5.0, DVec3::NEG_Z).position.z, height);
    }
}

/// A point of a small sphere after transforms, found from their definitions.
#[test]
fn transforms_apply_to_what_follows() {
    let directory = Directory::new("transforms");
    let center = |text: &str| {
        let world =
            directory.load(&format!("{PROBE}{text}\nShape \"sphere\" \"float radius\" 0.1")).world;
        let bounds = world.bounds();
        assert_eq!(world.surface_count(), 1);
        0.5 * (bounds.min + bounds.max)
    };
    let cases = [
        ("Translate 1 2 3", DVec3::new(1.0, 2.0, 3.0)),
        ("Scale 2 2 2 Translate 1 2 3", DVec3::new(2.0, 4.0, 6.0)),
        ("Rotate 90 0 0 1 Translate 1 0 0", DVec3::Y),
        ("Rotate 90 0 0 0.5 Rotate 0 0 0 0 Translate 1 0 0", DVec3::Y),
        ("Translate 1 0 0 Rotate 90 0 0 1", DVec3::X),
        ("Translate 9 9 9 Identity", DVec3::ZERO),
        (
            "Translate 9 9 9 Transform [0 1 0 0  -1 0 0 0  0 0 1 0  5 6 7 1] Translate 1 0 0",
            DVec3::new(5.0, 7.0, 7.0),
        ),
        (
            "Translate 1 0 0 ConcatTransform [0 1 0 0  -1 0 0 0  0 0 1 0  5 6 7 1]",
            DVec3::new(6.0, 6.0, 7.0),
        ),
        (
            "Translate 1 2 3 CoordinateSystem \"here\" Identity CoordSysTransform \"here\"",
            DVec3::new(1.0, 2.0, 3.0),
        ),
        ("Translate 1 2 3 CoordSysTransform \"world\"", DVec3::ZERO),
        // The camera is at (0, 0, 5), x to the left in the world, and looks down.
        ("CoordSysTransform \"camera\" Translate 1 2 3", DVec3::new(-1.0, 2.0, 2.0)),
        ("AttributeBegin Translate 9 9 9 AttributeEnd Translate 1 0 0", DVec3::X),
        ("TransformBegin Translate 9 9 9 TransformEnd Translate 1 0 0", DVec3::X),
        ("TransformTimes 0 1 ActiveTransform StartTime Translate 1 0 0", DVec3::X),
        ("LookAt 1 2 3  1 2 4  0 1 0", DVec3::new(-1.0, -2.0, -3.0)),
    ];
    for (text, expected) in cases {
        assert_relative_eq!(center(text), expected, epsilon = 1e-9);
    }
    let text = format!(
        "{PROBE}ActiveTransform EndTime\nTranslate 9 9 9\nActiveTransform All\nTranslate 1 0 0\nShape \"sphere\""
    );
    let world = directory.left_out(&text, "motion is not supported").world;
    assert_relative_eq!(world.bounds().min, DVec3::new(0.0, -1.0, -1.0), epsilon = 1e-9);
}

/// The end of a scope puts back material, light, orientation and attributes; that of a transform
/// only the transform.
#[test]
fn scopes_end() {
    let directory = Directory::new("scopes");
    let light = "AreaLightSource \"diffuse\" \"rgb L\" [2 2 2]";
    let radiance =
        |text: &str| glow(&directory.load(&format!("{PROBE}{text}\nShape \"sphere\"")).world);
    assert_eq!(radiance(light), Rgb::splat(2.0));
    assert_eq!(radiance(&format!("AttributeBegin {light} AttributeEnd")), Rgb::BLACK);
    assert_eq!(radiance(&format!("TransformBegin {light} TransformEnd")), Rgb::splat(2.0));
    assert_eq!(radiance(&format!("{light} ReverseOrientation")), Rgb::BLACK);
    assert_eq!(
        radiance(&format!("{light} ReverseOrientation ReverseOrientation")),
        Rgb::splat(2.0)
    );
    let scope = format!("{light} AttributeBegin ReverseOrientation AttributeEnd");
    assert_eq!(radiance(&scope), Rgb::splat(2.0));
    let defaults = "AttributeBegin Attribute \"light\" \"rgb L\" [5 5 5] AttributeEnd AreaLightSource \"diffuse\"";
    assert_eq!(radiance(defaults), Rgb::WHITE);
}

/// What makes no sense costs itself and no more, and its line is told.
#[test]
fn one_bad_directive_costs_no_other() {
    let directory = Directory::new("bad");
    let good = "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3]\nShape \"sphere\"\n";
    let bad = [
        ("Shape \"sphere\" \"float radius\" [1 \"a\"]", "of several sorts"),
        ("Shape \"sphere\" \"float radius\" nan", "not a finite number"),
        ("Shape \"sphere\" \"radius\" 1", "not a type and a name"),
        ("Shape \"sphere\" \"float radius\" ]", "bracket"),
        ("Shape \"sphere\" \"float radius\" [1 2]", "must be one number"),
        ("Shape \"sphere\" \"string radius\" \"1\"", "must have numbers"),
        ("Shape \"sphere\" \"float radius\" -1", "must be positive"),
        ("Shape \"torus\"", "not supported"),
        ("Shape sphere", "a text in quotes"),
        ("Shape \"sphere", "no closing quote"),
        ("Translate 1 2", "not a finite number"),
        ("Rotate 30 0 0 0", "length zero"),
        ("Translate 1e308 1e308 1e999", "finite number"),
        ("Scale 1e200 1 1 Scale 1e200 1 1", "not finite"),
        ("Transform [1 0 0 1  0 1 0 0  0 0 1 0  0 0 0 1]", "not affine"),
        ("LookAt 0 0 0  0 0 0  0 1 0", "the same"),
        ("CoordSysTransform \"nowhere\"", "no coordinate system"),
        ("AttributeEnd", "no scope"),
        ("ObjectInstance \"nothing\"", "there is no object"),
        ("ObjectBegin \"a\" ObjectBegin \"b\" ObjectEnd", "an object in an object"),
        ("AttributeBegin", "are not closed"),
        ("ColorSpace \"cmyk\"", "colour space"),
        ("Texture \"a\" \"normal\" \"constant\"", "not known"),
        ("Include \"parts/missing.pbrt\"", "there is no file"),
        ("Include \"../scene.pbrt\"", "outside of the scene's directory"),
        ("NoSuchThing \"a\" [1 2 3] 4", "no directive"),
        ("] ] ]", "a directive is wanted"),
        ("LightSource \"point\" \"blackbody I\" 0", "black body"),
        ("LightSource \"lava\"", "not supported"),
        (
            "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"fog\" \"\"",
            "only absorbs",
        ),
        ("Shape \"disk\" \"float colour\" 1", "parameter colour (line 6)"),
    ];
    for (text, expected) in bad {
        // The bad one is far away, and inside a scope of its own.
        let text = format!("{PROBE}{text}\nIdentity\n{good}");
        let import = directory.left_out(&text, expected);
        let found = import.warnings.iter().find(|warning| warning.to_string().contains(expected));
        if !expected.contains("closed") {
            assert_eq!(found.expect("a warning").location.line, Some(6), "{text}");
        }
        assert_eq!(glow(&import.world), Rgb::new(1.0, 2.0, 3.0), "{text}");
    }
    let nothing = directory.load_with(PROBE, &Options::default());
    assert!(nothing.is_err());
}

/// Colours of other spaces: (1, 0, 0) of each as sRGB, white as white.
#[test]
fn colour_spaces_are_those_of_their_primaries() {
    let directory = Directory::new("spaces");
    let radiance = |space: &str, colour: &str| {
        let text = format!(
            "{PROBE}ColorSpace \"{space}\"\nAreaLightSource \"diffuse\" \"rgb L\" [{colour}]\nShape \"sphere\""
        );
        glow(&directory.load(&text).world)
    };
    for space in ["srgb", "dci-p3", "rec2020", "aces2065-1"] {
        let white = radiance(space, "1 1 1");
        (0..3).for_each(|i| assert_relative_eq!(white[i], 1.0, max_relative = 1e-12));
    }
    assert_eq!(radiance("srgb", "0.2 0.5 0.7"), Rgb::new(0.2, 0.5, 0.7));
    // From the primaries by another program.
    let near = |found: Rgb, expected: [f64; 3]| {
        (0..3).for_each(|i| assert_relative_eq!(found[i], expected[i], epsilon = 1e-5));
    };
    near(radiance("rec2020", "0.5 0.5 0.3"), [0.514_57, 0.501_67, 0.276_25]);
    near(radiance("dci-p3", "0.5 0.5 0.3"), [0.5, 0.5, 0.280_35]);
}
