//! Shapes: where they are, which side is their front, and their texture coordinates.

use crate::files::{Directory, FLOOR, PROBE, emitted, seen};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::import::Options;
use pathspace::math::Rgb;
use pathspace::scene::{Scene, World};

const GLOW: &str = "AreaLightSource \"diffuse\"\n";

/// True if the surface that is seen along -z from above emits upwards.
fn faces_up(world: &World) -> bool {
    emitted(world, DVec3::new(0.1, 0.2, 9.0), DVec3::NEG_Z) == Rgb::WHITE
}

/// The front of a shape, with and without reversed orientation, normals and mirrors.
#[test]
fn fronts_are_where_normals_point() {
    let directory = Directory::new("fronts");
    let square = "\"point3 P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] \"integer indices\" [0 1 2  0 2 3]";
    let patch = "\"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]";
    let bent = "\"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0.5]";
    let down = "\"normal N\" [0 0 -1  0 0 -1  0 0 -1  0 0 -1]";
    let cases = [
        (format!("Shape \"trianglemesh\" {square}"), true),
        (format!("Shape \"trianglemesh\" {square} {down}"), false),
        (format!("Shape \"bilinearmesh\" {patch}"), true),
        (format!("Shape \"bilinearmesh\" {bent}"), true),
        (format!("Shape \"bilinearmesh\" {bent} {down}"), false),
        ("Shape \"disk\"".to_owned(), true),
        ("Shape \"sphere\"".to_owned(), true),
    ];
    for (shape, is_up) in cases {
        let up = |state: &str| {
            faces_up(&directory.load(&format!("{PROBE}{GLOW}{state}\n{shape}")).world)
        };
        assert_eq!(up(""), is_up, "{shape}");
        assert_eq!(up("ReverseOrientation"), !is_up, "{shape}");
        assert_eq!(up("Scale -1 1 1"), is_up, "{shape}");
        assert_eq!(up("Scale -1 1 1 ReverseOrientation"), !is_up, "{shape}");
        if !shape.contains("sphere") {
            assert_eq!(up("Rotate 180 1 0 0"), !is_up, "{shape}");
            assert_eq!(up("Scale 1 1 -1"), !is_up, "{shape}");
        }
    }
    let instance = format!(
        "{PROBE}ObjectBegin \"a\"\nShape \"trianglemesh\" {square}\nObjectEnd\nScale 1 1 -1\nObjectInstance \"a\""
    );
    let world = directory.load(&instance).world;
    assert_eq!(
        seen(&world, DVec3::new(0.1, 0.2, 9.0), DVec3::NEG_Z).geometric_normal,
        DVec3::NEG_Z
    );
}

/// An instance is transformed after the shape's own transform, wherever it was defined.
#[test]
fn instances_are_copies() {
    let directory = Directory::new("instances");
    let text = format!(
        "{PROBE}Translate 1 0 0\nObjectBegin \"pair\"\nShape \"sphere\" \"float radius\" 0.5\n\
         Translate 0 3 0\nShape \"disk\" \"float radius\" 0.5\nObjectEnd\nIdentity\n\
         ObjectInstance \"pair\"\nRotate 90 0 0 1\nScale 2 2 2\nObjectInstance \"pair\""
    );
    let world = directory.load(&text).world;
    assert_eq!(world.surface_count(), 4);
    // (x, y) of the four, and how high each is.
    for (x, y, z) in [(1.0, 0.0, 0.5), (1.0, 3.0, 0.0), (0.0, 2.0, 1.0), (-6.0, 2.0, 0.0)] {
        let hit = seen(&world, DVec3::new(x, y, 9.0), DVec3::NEG_Z);
        assert_relative_eq!(hit.position, DVec3::new(x, y, z), epsilon = 1e-9);
    }
    let glow = format!(
        "{PROBE}ObjectBegin \"a\"\n{GLOW}Shape \"sphere\"\nObjectEnd\nObjectInstance \"a\""
    );
    let import = directory.left_out(&glow, "lights are not supported in objects");
    assert_eq!(import.world.light_count(), 0);
}

/// Parts of round shapes have the area that they should have, exactly or by many triangles.
#[test]
fn round_shapes_have_their_area() {
    let directory = Directory::new("round");
    // π A of radiance 1.
    let area = |text: &str, is_exact: bool| {
        let text = format!("{PROBE}{GLOW}{text}");
        let import =
            if is_exact { directory.load(&text) } else { directory.left_out(&text, "triangles") };
        let light = import.world.light(pathspace::endpoint::LightId(0));
        pathspace::endpoint::Light::power(light).r() / std::f64::consts::PI
    };
    let pi = std::f64::consts::PI;
    let exact = [
        ("Shape \"sphere\" \"float radius\" 2", 16.0 * pi),
        ("Shape \"sphere\" \"float radius\" 2 \"float zmin\" -1 \"float zmax\" 0.5", 6.0 * pi),
        ("Scale 3 3 3 Shape \"disk\" \"float radius\" 2", 36.0 * pi),
        ("Scale 3 3 7 Shape \"disk\" \"float height\" 1", 9.0 * pi),
        ("Scale 2 3 4 Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0]", 6.0),
    ];
    for (text, expected) in exact {
        assert_relative_eq!(area(text, true), expected, max_relative = 1e-9);
    }
    let made = [
        ("Shape \"sphere\" \"float radius\" 2 \"float phimax\" 90", 4.0 * pi),
        ("Shape \"disk\" \"float radius\" 2 \"float innerradius\" 1", 3.0 * pi),
        ("Shape \"disk\" \"float phimax\" 180", 0.5 * pi),
        ("Scale 2 1 1 Shape \"disk\"", 2.0 * pi),
        ("Shape \"cylinder\" \"float radius\" 2 \"float zmin\" 0 \"float zmax\" 3", 12.0 * pi),
    ];
    for (text, expected) in made {
        assert_relative_eq!(area(text, false), expected, max_relative = 2e-3);
    }
    // An ellipsoid reaches as far as it should, its front outside.
    let world = directory
        .left_out(&format!("{PROBE}{GLOW}Scale 1 2 3 Shape \"sphere\""), "triangles")
        .world;
    assert_relative_eq!(world.bounds().max, DVec3::new(1.0, 2.0, 3.0), epsilon = 1e-9);
    assert_eq!(emitted(&world, DVec3::Z * 9.0, DVec3::NEG_Z + DVec3::X * 1e-3), Rgb::WHITE);
    assert_eq!(emitted(&world, DVec3::ZERO, DVec3::new(0.1, 0.2, 0.9)), Rgb::BLACK);
    let cylinder = format!("{PROBE}{GLOW}Shape \"cylinder\"");
    let world = directory.left_out(&cylinder, "triangles").world;
    assert_eq!(emitted(&world, DVec3::Y * 9.0, DVec3::new(0.001, -1.0, 0.002)), Rgb::WHITE);
    assert_eq!(emitted(&world, DVec3::ZERO, DVec3::new(0.1, 0.9, 0.05)), Rgb::BLACK);
}

/// Meshes of files, compressed or not, with quadrilaterals.
#[test]
fn meshes_are_read_from_files() {
    let directory = Directory::new("meshes");
    let text = format!("{PROBE}Shape \"plymesh\" \"string filename\" \"parts/pyramid.ply.gz\"");
    let world = directory.load(&text).world;
    assert_eq!(world.primitive_count(), 6);
    assert_relative_eq!(world.bounds().max, DVec3::new(0.2, 0.2, 0.4), epsilon = 1e-7);
    directory.write(
        "parts/cut.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nend_header\n1",
    );
    for (shape, expected) in [
        ("plymesh\" \"string filename\" \"parts/cut.ply\"", "cut.ply"),
        ("plymesh\" \"string filename\" \"parts/none.ply\"", "there is no file"),
        ("plymesh\"", "filename is missing"),
        (
            "trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
            "refers to vertex 3",
        ),
        (
            "trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 -2]",
            "whole numbers",
        ),
        (
            "trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1]",
            "3 does not divide",
        ),
        (
            "trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1] \"integer indices\" [0 1 2]",
            "3 does not divide",
        ),
        (
            "trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1]",
            "1 attributes of 3",
        ),
        ("trianglemesh\" \"integer indices\" [0 1 2]", "P is missing"),
        (
            "bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 9]",
            "refers to vertex",
        ),
        ("curve\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]", "not supported"),
        ("sphere\" \"float zmin\" 0 \"float zmax\" 0", "no area"),
    ] {
        let text = format!("{PROBE}{FLOOR}Shape \"{shape}");
        assert_eq!(directory.left_out(&text, expected).world.surface_count(), 1, "{shape}");
    }
    let text = format!(
        "{PROBE}Shape \"loopsubdiv\" \"integer levels\" 2 \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]"
    );
    directory.left_out(&text, "its control mesh is taken");
    // A normal of length zero becomes that of the triangle.
    let text = format!(
        "{PROBE}Shape \"trianglemesh\" \"point3 P\" [-1 -1 0 1 -1 0 0 1 0] \"normal N\" [0 0 1 0 0 0 0 0 1]"
    );
    let hit = seen(&directory.load(&text).world, DVec3::Z, DVec3::NEG_Z);
    assert_eq!(hit.shading_normal, DVec3::Z);
}

/// What is seen of an image on shapes: its four corners are black, red, green and white.
#[test]
fn texture_coordinates_are_those_of_pbrt() {
    let directory = Directory::new("coordinates");
    // The lower row first: v goes upwards.
    let image = pathspace::film::Image::new(
        2,
        2,
        vec![Rgb::new(0.0, 1.0, 0.0), Rgb::WHITE, Rgb::BLACK, Rgb::new(1.0, 0.0, 0.0)],
    )
    .expect("four pixels");
    let path = directory.0.join("parts/corners.png");
    pathspace::film::ImageFile::from(image).save(path).expect("saved");
    let expected = |uv: DVec2| {
        let (u, v) = (f64::from(u8::from(uv.x > 0.5)), f64::from(u8::from(uv.y > 0.5)));
        let both = u * v;
        Rgb::new(u, v, both)
    };
    let texture = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"parts/corners.png\" \"string filter\" \"point\"\n\
        Material \"diffuse\" \"texture reflectance\" \"t\"\n";
    let albedo = |text: &str, from: DVec3, to: DVec3| {
        let text = format!("{PROBE}{texture}{text}");
        let import = directory.load_with(&text, &Options::default()).expect("valid");
        let hit = seen(&import.world, from, to - from);
        import.world.bsdf(&hit).eval(DVec3::Z, DVec3::Z) * std::f64::consts::PI
    };
    // On a sphere u is the azimuth from x towards y, and v goes from the lower pole to the upper
    // one.
    let on_sphere = |uv: DVec2| {
        let (azimuth, polar) = (uv.x * std::f64::consts::TAU, std::f64::consts::PI * (1.0 - uv.y));
        DVec3::new(azimuth.cos() * polar.sin(), azimuth.sin() * polar.sin(), polar.cos())
    };
    let near = |found: Rgb, expected: Rgb, what: &str| {
        (0..3).for_each(|i| assert!((found[i] - expected[i]).abs() < 1e-9, "{what}: {found:?}"));
    };
    for uv in [(0.2, 0.3), (0.7, 0.2), (0.3, 0.8), (0.9, 0.6)].map(DVec2::from) {
        let what = format!("{uv:?}");
        let flat = DVec3::new(uv.x, uv.y, 0.0);
        let above = flat + DVec3::Z;
        for shape in [
            "Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0]",
            "ReverseOrientation Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0]",
            "Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0  3 3 0  4 3 0  3 4 0  4 4 0] \"integer indices\" [0 1 2 3  4 5 6 7]",
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  1 1 0  0 1 0] \"integer indices\" [0 1 2 0 2 3] \"point2 uv\" [0 0 1 0 1 1 0 1]",
        ] {
            near(albedo(shape, above, flat), expected(uv), &format!("{what} {shape}"));
        }
        let p = on_sphere(uv);
        for (transform, to) in [
            ("", p),
            ("Rotate 40 0 0 1", glam::DQuat::from_rotation_z(40f64.to_radians()) * p),
            (
                "Rotate 70 1 1 0",
                glam::DQuat::from_axis_angle(
                    DVec3::new(1.0, 1.0, 0.0).normalize(),
                    70f64.to_radians(),
                ) * p,
            ),
            ("Scale -1 1 1", p * DVec3::new(-1.0, 1.0, 1.0)),
            ("Scale 1 1 -1", p * DVec3::new(1.0, 1.0, -1.0)),
        ] {
            let found = albedo(&format!("{transform} Shape \"sphere\""), to * 3.0, to);
            near(found, expected(uv), &format!("{what} sphere {transform}"));
        }
        // A zone has all of the image.
        let (low, high) = ((-0.6f64).acos(), 0.5f64.acos());
        let polar = low + uv.y * (high - low);
        let azimuth = uv.x * std::f64::consts::TAU;
        let p = DVec3::new(azimuth.cos() * polar.sin(), azimuth.sin() * polar.sin(), polar.cos());
        let zone = "Shape \"sphere\" \"float zmin\" -0.6 \"float zmax\" 0.5";
        near(albedo(zone, p * 3.0, p), expected(uv), &format!("{what} zone"));
        // On a disk v is 0 at the edge.
        let radius = 1.0 - uv.y;
        let p = DVec3::new(radius * azimuth.cos(), radius * azimuth.sin(), 0.0);
        near(albedo("Shape \"disk\"", p + DVec3::Z, p), expected(uv), &format!("{what} disk"));
        let p = DVec3::new(azimuth.cos(), azimuth.sin(), -1.0 + 2.0 * uv.y);
        let from = p + 2.0 * p.with_z(0.0);
        near(albedo("Shape \"cylinder\"", from, p), expected(uv), &format!("{what} cylinder"));
    }
    // Triangles without coordinates have (0, 0), (1, 0) and (1, 1).
    let mesh =
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  1 1 0] \"integer indices\" [0 1 2]";
    for uv in [(0.4, 0.2), (0.8, 0.3), (0.9, 0.8)].map(DVec2::from) {
        let p = uv.extend(0.0);
        near(albedo(mesh, p + DVec3::Z, p), expected(uv), "no coordinates");
    }
}
