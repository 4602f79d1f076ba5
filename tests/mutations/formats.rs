//! The formats whose files are damaged, each in a scene that reads them.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::Value;
use std::path::Path;

/// Files of a format, and a scene around one of them.
pub struct Format {
    pub name: &'static str,
    /// The file that is damaged, and what it is without damage.
    pub target: &'static str,
    pub originals: Vec<Vec<u8>>,
    pub is_text: bool,
    /// The file that is loaded, the damaged one or one that refers to it.
    pub scene: &'static str,
    /// What else there is.
    pub others: Vec<(&'static str, Vec<u8>)>,
}

fn data(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)).expect(name)
}

/// All formats. Another one is an entry more.
pub fn formats() -> Vec<Format> {
    let mut formats = vec![
        Format {
            name: "mitsuba",
            target: "scene.xml",
            originals: MITSUBA.iter().map(|name| data(&format!("mitsuba/{name}.xml"))).collect(),
            is_text: true,
            scene: "scene.xml",
            others: mitsuba_parts(),
        },
        Format {
            name: "gltf",
            target: "scene.gltf",
            originals: GLTF.iter().map(|name| data(&format!("gltf/{name}"))).collect(),
            is_text: true,
            scene: "scene.gltf",
            others: gltf_parts(),
        },
        Format {
            name: "glb",
            target: "scene.glb",
            originals: vec![data("gltf/box.glb")],
            is_text: false,
            scene: "scene.glb",
            others: vec![],
        },
        Format {
            name: "gltf buffers",
            target: "textures.bin",
            originals: vec![data("gltf/textures.bin")],
            is_text: false,
            scene: "textures.gltf",
            others: gltf_parts(),
        },
        packed(),
        Format {
            name: "pbrt",
            target: "scene.pbrt",
            originals: vec![data("pbrt/room.pbrt"), PBRT.into()],
            is_text: true,
            scene: "scene.pbrt",
            others: ["parts/colours.png", "parts/materials.pbrt.gz", "parts/pyramid.ply.gz"]
                .map(|name| (name, data(&format!("pbrt/{name}"))))
                .into(),
        },
        Format {
            name: "obj",
            target: "scene.obj",
            originals: vec![OBJ.as_bytes().to_vec(), data("mitsuba/parts/tetrahedron.obj")],
            is_text: true,
            scene: "scene.obj",
            others: obj_parts(),
        },
        Format {
            name: "mtl",
            target: "scene.mtl",
            // What emits a texture takes a hundred times as long as the others.
            originals: [MTL, MTL, MTL, MTL, MTL, MTL, MTL, SCREEN].map(Into::into).into(),
            is_text: true,
            scene: "scene.obj",
            others: obj_parts(),
        },
    ];
    // Meshes and images of Mitsuba scenes.
    for (name, scene, target, originals, is_text) in [
        (
            "ply",
            "meshes.xml",
            "parts/tetrahedron.ply",
            vec![data("mitsuba/parts/tetrahedron.ply")],
            true,
        ),
        (
            "binary ply",
            "meshes.xml",
            "parts/binary.ply",
            vec![data("mitsuba/parts/binary.ply")],
            false,
        ),
        (
            "serialized",
            "meshes.xml",
            "parts/two.serialized",
            vec![data("mitsuba/parts/two.serialized"), serialized()],
            false,
        ),
        ("exr", "textures.xml", "parts/sky.exr", vec![data("mitsuba/parts/sky.exr")], false),
    ] {
        let mut others = mitsuba_parts();
        others.push((scene, data(&format!("mitsuba/{scene}"))));
        formats.push(Format { name, target, originals, is_text, scene, others });
    }
    // Images of OBJ files.
    for (name, original) in [
        ("png", data("mitsuba/parts/colours.png")),
        ("jpeg", data("gltf/halves.jpg")),
        ("hdr", hdr()),
        ("tga", tga()),
        ("bmp", bmp()),
    ] {
        formats.push(Format {
            name,
            target: "image",
            originals: vec![original],
            is_text: false,
            scene: "image.obj",
            others: vec![
                ("image.obj", IMAGE_OBJ.into()),
                ("image.mtl", "newmtl a\nmap_Kd image\nmap_Pr image\nmap_d image\n".into()),
            ],
        });
    }
    formats
}

const MITSUBA: [&str; 17] = [
    "conductor",
    "constant",
    "dielectric",
    "diffuse",
    "directional",
    "envmap",
    "mixtures",
    "meshes",
    "orthographic",
    "plastic",
    "point",
    "roughconductor",
    "roughdielectric",
    "shifted",
    "spectrum",
    "textures",
    "thinlens",
];

const GLTF: [&str; 7] = [
    "box.gltf",
    "lights.gltf",
    "materials.gltf",
    "meshes.gltf",
    "nodes.gltf",
    "textures.gltf",
    "wraps.gltf",
];

fn mitsuba_parts() -> Vec<(&'static str, Vec<u8>)> {
    [
        "parts/binary.ply",
        "parts/colours.png",
        "parts/floor.xml",
        "parts/lamp.xml",
        "parts/sky.exr",
        "parts/tetrahedron.obj",
        "parts/tetrahedron.ply",
        "parts/two.serialized",
        "parts/view.xml",
    ]
    .map(|name| (name, data(&format!("mitsuba/{name}"))))
    .into()
}

fn gltf_parts() -> Vec<(&'static str, Vec<u8>)> {
    ["textures.gltf", "textures.bin", "two by two.png", "halves.jpg"]
        .map(|name| (name, data(&format!("gltf/{name}"))))
        .into()
}

fn obj_parts() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("scene.obj", OBJ.into()),
        ("scene.mtl", MTL.into()),
        ("a.png", data("mitsuba/parts/colours.png")),
        ("b.jpg", data("gltf/halves.jpg")),
        ("c.exr", data("mitsuba/parts/sky.exr")),
    ]
}

/// Streams of compressed meshes, by meshoptimizer and Draco, in a buffer beside their document.
fn packed() -> Format {
    let mut document: Value = serde_json::from_slice(&data("gltf/packed.gltf")).expect("valid");
    let uri = document["buffers"][0]["uri"].take();
    let (_, text) = uri.as_str().expect("a data URI").split_once(',').expect("a data URI");
    let streams = BASE64_STANDARD.decode(text).expect("base 64");
    document["buffers"][0]["uri"] = "packed.bin".into();
    Format {
        name: "packed",
        target: "packed.bin",
        originals: vec![streams],
        is_text: false,
        scene: "packed.gltf",
        others: vec![("packed.gltf", document.to_string().into())],
    }
}

const PBRT: &str = r#"Scale -1 1 1
LookAt 0 -4 1.5  0 0 1  0 0 1
Camera "orthographic" "float screenwindow" [ -2 2 -1 1 ]
Film "gbuffer" "integer xresolution" 8 "integer yresolution" 6 "integer pixelbounds" [ 0 8 1 5 ]
PixelFilter "mitchell" "float B" 0.5
Integrator "path" "integer maxdepth" 3
WorldBegin
Texture "wood" "spectrum" "imagemap" "string filename" "parts/colours.png" "string wrap" "clamp"
  "float uscale" 2 "bool invert" true
Texture "grey" "float" "scale" "float tex" 0.5 "float scale" 0.25
Texture "both" "spectrum" "mix" "texture tex1" "wood" "rgb tex2" [ 0.1 0.2 0.3 ] "float amount" 0.5
MakeNamedMaterial "coat" "string type" "coateddiffuse" "texture reflectance" "both"
  "float roughness" 0.1 "spectrum eta" 1.5
MakeNamedMaterial "gold" "string type" "coatedconductor" "float interface.roughness" 0.01
MakeNamedMaterial "sum" "string type" "mix" "string materials" [ "coat" "gold" ] "float amount" 0.25
AttributeBegin
  NamedMaterial "sum"
  Shape "cylinder" "float radius" 0.5 "float zmin" -1 "float zmax" 1 "float phimax" 270
  Rotate 45 0 1 0
  Material "dielectric" "spectrum eta" "glass-BK7" "texture roughness" "grey"
  Shape "sphere" "float radius" 0.5 "float zmin" -0.25 "float alpha" 0.5
  Material "subsurface" "rgb reflectance" [ 0.5 0.6 0.7 ]
  Shape "loopsubdiv" "integer levels" 2 "integer indices" [ 0 1 2 ]
    "point3 P" [ 0 0 0 1 0 0 0 1 0 ]
  Shape "trianglemesh" "integer indices" [ 0 1 2 ] "point3 P" [ 0 0 2 1 0 2 0 1 2 ]
    "normal N" [ 0 0 1 0 0 1 0 1 1 ] "vector3 S" [ 1 0 0 1 0 0 1 0 0 ]
AttributeEnd
MediumInterface "fog" ""
LightSource "spot" "rgb I" [ 5 5 5 ] "float coneangle" 20 "point3 from" [ 0 0 5 ]
LightSource "infinite" "string filename" "parts/colours.png" "float scale" 0.5
LightSource "goniometric" "float power" 10
"#;

const OBJ: &str = "mtllib scene.mtl
o box
v -1 -1 0
v 1 -1 0
v 1 1 0 1.0
v -1 1 0 0.5 0.5 0.5
v 0 0 1.5
vt 0 0
vt 1 0
vt 1 1 0
vt 0.5
vn 0 0 1
vn 0.6 0 0.8
s 1
usemtl paint
f 1/1/1 2/2/1 3/3/2 4/4/2
g top
usemtl glass
f 1/1 2/2 5/3
f 2//1 3//2 5//1
s off
usemtl lamp
f -3/-1/-1 -2/-2/-2 -1/-3/-1
usemtl screen
f 4 1 5
l 1 2
v 3 0 0
v 5 0 0
v 5 2 0
v 4 1 0
v 3 2 0
usemtl metal
f 6/1 7/2 8/3 9/4 10/1
";

const MTL: &str = "newmtl paint
Ka 0 0 0
Kd 0.5 0.25 0.125
Ks 0.25
Ns 30
illum 2
map_Kd -s 2 2 1 -o 0.5 -clamp on a.png
map_Ks b.jpg
map_Ns -imfchan g a.png
newmtl glass
illum 7
Ni 1.5
Pr 0.1
newmtl lamp
Kd 0
Ke 3 2 1
newmtl screen
Kd 0.5
d 0.5
map_d -imfchan m a.png
bump -bm 0.5 a.png
newmtl metal
Pr 0.25
Pm 1
map_Pr a.png
map_Pm b.jpg
Tr 0.1
";

const SCREEN: &str = "newmtl screen\nKe 3 2 1\nmap_Ke -s 2 2 c.exr\nmap_Kd b.jpg\n";

const IMAGE_OBJ: &str = "mtllib image.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";

/// A mesh whose numbers are not compressed, so that damage is to them.
fn serialized() -> Vec<u8> {
    let mut mesh = [&0x1003u32.to_le_bytes()[..], b"mesh\0"].concat();
    mesh.extend([3u64.to_le_bytes(), 1u64.to_le_bytes()].concat());
    let floats = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]
        .into_iter()
        .chain([0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    mesh.extend(floats.flat_map(f32::to_le_bytes));
    mesh.extend([0u32, 1, 2].map(u32::to_le_bytes).concat());
    let length = mesh.len() as u16;
    let mut bytes = Vec::new();
    let mut offsets = Vec::new();
    for _ in 0..2 {
        offsets.extend((bytes.len() as u64).to_le_bytes());
        bytes.extend([0x1C, 0x04, 4, 0, 0x78, 0x01, 1]);
        bytes.extend([length.to_le_bytes(), (!length).to_le_bytes()].concat());
        bytes.extend(&mesh);
    }
    bytes.extend(offsets);
    bytes.extend(2u32.to_le_bytes());
    bytes
}

/// Two rows, one with run lengths and one without.
fn hdr() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n-Y 2 +X 8\n".to_vec();
    bytes.extend([2, 2, 0, 8]);
    (0..4).for_each(|channel| bytes.extend([136, 128 + channel]));
    (0..8).for_each(|x| bytes.extend([x * 20, 100, 50, 129]));
    bytes
}

/// Two rows with run lengths.
fn tga() -> Vec<u8> {
    let mut bytes = vec![0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 2, 0, 32, 0x28];
    bytes.extend([0x83, 10, 20, 30, 255, 0x01, 1, 2, 3, 4, 5, 6, 7, 8, 0x81, 9, 10, 11, 0]);
    bytes
}

/// Two rows of two pixels.
fn bmp() -> Vec<u8> {
    let mut bytes = b"BM".to_vec();
    for word in [70u32, 0, 54, 40, 2, 2, 0x18_0001, 0, 16, 2835, 2835, 0, 0] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend([0, 0, 255, 0, 255, 0, 0, 0, 255, 0, 0, 255, 255, 255, 0, 0]);
    bytes
}
