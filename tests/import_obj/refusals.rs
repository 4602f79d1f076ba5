//! What is left out, and files that are refused.

use crate::files::{CORNERS, Directory, below};
use glam::UVec2;
use pathspace::import::{Options, obj};
use pathspace::math::Rgb;
use pathspace::scene::{Material, Scene};

#[test]
fn one_bad_statement_does_not_cost_the_file() {
    let directory = Directory::new("faults");
    let square = format!("{CORNERS}f 1 2 3 4\n");
    for (statements, warning) in [
        ("f 1 2", "scene.obj:10: a face of less than three vertices"),
        ("f", "a face of less than three vertices"),
        ("f 1 2 x", "a face that is not made of vertices"),
        ("f 1 2 3/1/1/1", "a face that is not made of vertices"),
        ("f 1 2 0", "a face that is not made of vertices"),
        ("f 1 2 -0", "a face that is not made of vertices"),
        ("f 1 2 -5", "a face that is not made of vertices"),
        ("f 1 2 99999999999", "a face that is not made of vertices"),
        ("f /1 /2 /3", "a face that is not made of vertices"),
        ("f 1 2 5", "a vertex that is not there"),
        ("f 1/1 2/2 3/99", "texture coordinates that are not there"),
        ("vt nan 1\nf 1/1 2/2 3/-1", "texture coordinates that are not there"),
        ("f 1//1 2//1 3//1", "a normal that is not there"),
        ("vn inf 0 0\nf 1//1 2//1 3//1", "a normal that is not there"),
        ("v 0 0 x", "a vertex without three numbers"),
        ("v 0 0", "a vertex without three numbers"),
        ("v 0 nan 0\nf 1 2 -1", "a vertex that is not there or not finite"),
        ("v 0 1e39 0\nf 1 2 5", "a vertex that is not there or not finite"),
        ("v 0 0 0 1 0 0", "colours of vertices are left out"),
        ("l 1 2\np 1", "(× 2)"),
        ("curv 0 1 1 2", "the statement \"curv\" is not supported"),
        ("\u{1F600}\u{1F600}\u{1F600}\u{1F600}\u{1F600} 1", "is not supported"),
        ("usemtl nobody\nf 1 2 3", "group: there is no material nobody: it is grey"),
        ("mtllib none.mtl", "scene.obj:10: there is no file none.mtl; its materials are grey"),
        ("mtllib ../none.mtl", "may lie outside"),
    ] {
        let (world, warnings) = directory.load(&format!("{square}{statements}\n"));
        assert!(warnings.len() == 1 && warnings[0].contains(warning), "{statements}: {warnings:?}");
        let x = below(&world, 0.25, 0.75);
        assert_eq!(x.shading_normal.z, 1.0, "{statements}");
    }
    // A weight of a vertex is no fault.
    directory.world(&format!("{square}v 0 0 0 1\nvt 0.5\nvt 0 0 0\ns\ng\no\n#\n\\\n"));
    let (_, warnings) = directory.load(&format!("{square}{}", "f 1 2\n".repeat(100_000)));
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].ends_with("(× 100 000)"), "{warnings:?}");
}

/// The files with these faults that were found first.
#[test]
fn missing_libraries_and_invisible_squares_load() {
    let directory = Directory::new("reported");
    let square = format!("{CORNERS}usemtl a\nf 1/1 2/2 3/3 4/4\n");
    let (world, warnings) = directory.load(&format!("mtllib missing.mtl\n{square}"));
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("scene.obj:1: there is no file missing.mtl"));
    assert!(warnings[1].contains("there is no material a"));
    let grey = Material::Lambert { albedo: Rgb::splat(0.6) };
    let bsdf = world.bsdf(&below(&world, 0.5, 0.25));
    assert_eq!(bsdf.mixture(true), grey.mixture().expect("valid"));
    directory.write("black.tga", crate::files::tga(1, &[[0, 0, 0, 255]]));
    let (world, warnings) = directory.square("Kd 0.5 0.5 0.5\nmap_Kd black.tga\nd 0.0");
    assert!(warnings.is_empty(), "{warnings:?}");
    let bsdf = world.bsdf(&below(&world, 0.5, 0.25));
    assert_eq!(bsdf.mixture(true), Material::Null.mixture().expect("valid"));
}

#[test]
fn what_makes_no_scene_is_refused() {
    let directory = Directory::new("refused");
    let error = |text: &str, options: &Options| {
        directory.load_with(text, options).expect_err(text).to_string()
    };
    let whole = Options::default();
    for text in ["", "v 0 0 0\n", "v 0 0 0\nf 1 1 1\n", "f 1 2 3\n", "\0\0\0", "<html>"] {
        assert!(
            error(text, &whole).contains("scene.obj: it has no face that can be shown"),
            "{text}"
        );
    }
    let path = directory.write("scene.obj", format!("{CORNERS}f 1 2 3 4\n"));
    for size in [UVec2::new(0, 4), UVec2::new(1 << 16, 1 << 16)] {
        let error = obj::load(&path, size, &whole).expect_err("no film").to_string();
        assert!(error.contains("pixels must be at least 1"), "{error}");
    }
    assert!(obj::load(path.with_file_name("none.obj"), UVec2::ONE, &whole).is_err());
    let mut limited = whole.clone();
    limited.limits.triangles = 3;
    for faces in ["f 1 2 3\n".repeat(4), "f 1 2 3 4\n".repeat(2), format!("f{}", " 1".repeat(6))] {
        let error = error(&format!("{CORNERS}{faces}"), &limited);
        assert!(error.contains("more triangles than the limit admits"), "{error}");
    }
    directory.load_with(&format!("{CORNERS}{}", "f 1 2 3\n".repeat(3)), &limited).expect("three");
    let mut limited = whole.clone();
    limited.limits.elements = 3;
    let groups: String = (0..4).map(|k| format!("g {k}\nf 1 2 3\n")).collect();
    let error = error(&format!("{CORNERS}{groups}"), &limited);
    assert!(error.contains("more groups and materials than the limit admits"), "{error}");
    directory.write("a.mtl", "newmtl a\n".repeat(4));
    let text = format!("mtllib a.mtl\n{CORNERS}f 1 2 3\n");
    let error = directory.load_with(&text, &limited).expect_err("four materials").to_string();
    assert!(error.contains("a.mtl: it has more materials than the limit admits"), "{error}");
    let mut limited = whole;
    limited.limits.bytes = 100;
    directory.write("a.mtl", "#".repeat(100));
    let error = directory.load_with(&text, &limited).expect_err("too long").to_string();
    assert!(error.contains("more bytes than the limit admits"), "{error}");
}
