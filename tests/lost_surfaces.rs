//! Scene files all of whose surfaces are left out: an error in every format, since the image would be
//! of nothing. One surface that is kept, or a file that wants none, makes a scene.

use glam::UVec2;
use pathspace::import::{Error, Import, Options, gltf, mitsuba, obj, pbrt};
use std::path::{Path, PathBuf};

/// A file that goes away with its owner.
struct File(PathBuf);

impl File {
    fn new(name: &str, text: &str) -> Self {
        let path = std::env::temp_dir().join(format!("pathspace-{}-{name}", std::process::id()));
        std::fs::write(&path, text).expect("a temporary file");
        Self(path)
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Loads a file with these objects, by its extension.
fn load(name: &str, text: &str) -> Result<Import, Error> {
    let file = File::new(name, text);
    let (path, options, size) = (file.0.as_path(), Options::default(), UVec2::splat(8));
    match Path::new(name).extension().and_then(|extension| extension.to_str()) {
        Some("gltf") => gltf::load(path, size, &options),
        Some("obj") => obj::load(path, size, &options),
        Some("xml") => mitsuba::load(path, &options, []),
        _ => pbrt::load(path, &options),
    }
}

#[track_caller]
fn check(name: &str, text: impl Fn(&str) -> String, nothing: bool, lost: &[&str], kept: &str) {
    assert_eq!(load(name, &text("")).is_ok(), nothing, "{name}");
    for lost in lost {
        let error = load(name, &text(lost)).expect_err(lost).to_string();
        assert!(error.contains(name) && error.contains("no surface is left"), "{error}");
        let import = load(name, &text(&format!("{lost}{kept}"))).expect(lost);
        assert!(!import.world.bounds().is_empty() && !import.warnings.is_empty(), "{lost}");
    }
}

#[test]
fn mitsuba_files() {
    let text = |shapes: &str| {
        format!(
            "<scene version='3.0.0'><sensor type='perspective'/><emitter type='constant'/>{shapes}\
             </scene>"
        )
    };
    let lost = [
        "<shape type='sdfgrid'/>",
        "<shape type='ply'><string name='filename' value='none.ply'/></shape>",
        "<shape type='rectangle'><transform name='to_world'><scale value='0'/></transform></shape>",
        "<shape type='merge'><shape type='hair'/></shape>",
        "<shape type='shapegroup' id='a'><shape type='hair'/></shape>\
         <shape type='instance'><ref id='a'/></shape>",
        "<shape type='merge'><ref id='nothing'/></shape>",
    ];
    check("lost.xml", text, true, &lost, "<shape type='sphere'/>");
}

#[test]
fn pbrt_files() {
    let text = |shapes: &str| {
        format!("Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n{shapes}\n")
    };
    let lost = [
        "Shape \"curve\" \"point3 P\" [0 0 0]\n",
        "Shape \"plymesh\" \"string filename\" \"none.ply\"\n",
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 0 0 0 0 0 0]\n",
        "Include \"none.pbrt\"\n",
        "ObjectInstance \"nothing\"\n",
    ];
    check("lost.pbrt", text, true, &lost, "Shape \"sphere\"\n");
}

#[test]
fn obj_files() {
    let text = |faces: &str| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
    let faces = ["f 1 2 9\n", "f 1 2\n", "f 1 1 1\n"];
    for faces in ["", faces[0], faces[1], faces[2]] {
        let error = load("lost.obj", &text(faces)).expect_err(faces).to_string();
        assert!(error.contains("lost.obj: it has no face that can be shown"), "{error}");
    }
    for lost in faces {
        load("lost.obj", &text(&format!("{lost}f 1 2 3\n"))).expect(lost);
    }
}

#[test]
fn gltf_files() {
    // A point and, in the same buffer, a triangle.
    let data = "data:application/octet-stream;base64,\
                AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let text = |nodes: &str| {
        let accessor = |count: u32| {
            format!(
                r#"{{"bufferView":0,"componentType":5126,"type":"VEC3","count":{count},"min":[0,0,0],
                "max":[1,1,0]}}"#
            )
        };
        let mesh = |accessor: u32, mode: u32| {
            format!(
                r#"{{"primitives":[{{"attributes":{{"POSITION":{accessor}}},"mode":{mode}}}]}}"#
            )
        };
        let accessors = [accessor(3), accessor(9)].join(",");
        let meshes = [mesh(0, 4), mesh(0, 0), mesh(1, 4)].join(",");
        let count = 1 + nodes.matches("mesh").count();
        let roots: Vec<String> = (0..count).map(|node| node.to_string()).collect();
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{}]}}],
            "nodes":[{{"camera":0}}{nodes}],
            "cameras":[{{"type":"perspective","perspective":{{"yfov":1,"znear":0.1}}}}],
            "buffers":[{{"byteLength":36,"uri":"{data}"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],
            "accessors":[{accessors}],"meshes":[{meshes}]}}"#,
            roots.join(",")
        )
    };
    let lost = [r#",{"mesh":1}"#, r#",{"mesh":2}"#, r#",{"mesh":0,"scale":[0,0,0]}"#];
    check("lost.gltf", text, true, &lost, r#",{"mesh":0}"#);
}
