//! Files of a few bytes that ask for gigabytes.

use crate::bits::{exr, jpeg, piz, png, zlib_with_zeros};
use crate::scenes::{Directory, GLTF_IMAGE, OBJ_IMAGE, SERIALIZED, load, load_with};
use pathspace::import::Options;

const GIGABYTES: u64 = 2_400_000_000;

/// Something is said that contains one of some texts.
fn assert_said(said: &[String], expected: &str) {
    assert!(said.iter().any(|sentence| sentence.contains(expected)), "{expected}: {said:?}");
}

#[test]
fn compressed_meshes_do_not_expand_without_end() {
    let directory = Directory::new("serialized");
    directory.write("scene.xml", SERIALIZED);
    let file = |stream: &[u8]| {
        let mut bytes = vec![0x1C, 0x04, 4, 0];
        bytes.extend(stream);
        bytes.extend([0u64.to_le_bytes().as_slice(), &1u32.to_le_bytes()].concat());
        bytes
    };
    let header = |name: &[u8], vertices: u64, triangles: u64| {
        let flags = 0x1000u32.to_le_bytes();
        let counts = [vertices.to_le_bytes(), triangles.to_le_bytes()].concat();
        [&flags[..], name, &counts].concat()
    };
    for (first, zeros, expected) in [
        (header(b"\0", GIGABYTES / 12, 0), GIGABYTES, "more bytes than the limit admits"),
        (header(b"\0", 3, GIGABYTES / 12), GIGABYTES, "more bytes than the limit admits"),
        (header(b"\0", u64::MAX, u64::MAX), GIGABYTES, "more bytes than the limit admits"),
        (header(b"\0", 1000, 1 << 30), 1 << 20, "more bytes than the limit admits"),
        (header(b"\0", 1000, 1000), 0, "ends too early"),
        ([&[0; 4][..], &[b'x'; 60_000]].concat(), 0, "ends too early"),
    ] {
        directory.write("part.serialized", file(&zlib_with_zeros(&first, zeros)));
        assert_said(&load(&directory.path("scene.xml")), expected);
    }
    // A name of 2.4 GB: a block that is stored, and copies of its last byte.
    let name = [[0; 4].as_slice(), b"x"].concat();
    let mut stream = zlib_with_zeros(&name, GIGABYTES);
    // The literal behind it becomes an x, so that no name ends: 0x30 + 0x78 reversed.
    let at = 2 + 5 + name.len();
    let bits = (u32::from(stream[at]) | u32::from(stream[at + 1]) << 8) & !(0xFF << 3);
    let bits = bits | u32::from((0x30u8 + b'x').reverse_bits()) << 3;
    stream[at..at + 2].copy_from_slice(&bits.to_le_bytes()[..2]);
    directory.write("part.serialized", file(&stream));
    assert_said(&load(&directory.path("scene.xml")), "a name that does not end");
}

#[test]
fn images_have_the_size_that_the_limit_admits() {
    let directory = Directory::new("images");
    directory.write("image.gltf", GLTF_IMAGE);
    directory.write("image.obj", OBJ_IMAGE);
    let bomb = || zlib_with_zeros(b"name\0\0", GIGABYTES);
    let profile = |stream: Vec<u8>| [&b"name\0\0"[..], &stream].concat();
    let small = zlib_with_zeros(&[0; 4], 0);
    let window = |width: i32, height: i32| [0, 0, width - 1, height - 1];
    let small_window = window(1, 1);
    let files: Vec<(&str, Vec<u8>)> = vec![
        ("wide png", png(30_000, 30_000, &[], &bomb())),
        ("wider png", png(0x7FFF_FFFF, 0x7FFF_FFFF, &[], &small)),
        ("png without pixels", png(0, 5, &[], &small)),
        ("png of another size", png(1, 1, &[], &bomb())),
        ("colours of a png", png(1, 1, &[(b"iCCP", profile(bomb()))], &small)),
        ("text of a png", png(1, 1, &[(b"zTXt", profile(bomb()))], &small)),
        ("wide jpeg", jpeg(65535, 65535)),
        ("jpeg without pixels", jpeg(0, 65535)),
        ("wide hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n\x02\x02".to_vec()),
        ("long hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4000000000 +X 0\n".to_vec()),
        ("hdr of a line", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 4000000000\n".to_vec()),
        ("header of an hdr", [b"#?RADIANCE\n", "X".repeat(1 << 24).as_bytes()].concat()),
        ("wide exr", exr(window(60_000, 60_000), window(60_000, 60_000), 0, &[], None)),
        ("wider exr", exr(window(0x3FFF_FFFF, 0x3FFF_FFFF), window(0x3FFF_FFFF, 0x3FFF_FFFF), 0, &[], None)),
        ("exr of much that is not shown", exr(window(0x3FFF_FFFF, 0x3FFF_FFFF), small_window, 0, &[], None)),
        ("exr of much that is not there", exr(small_window, window(60_000, 60_000), 0, &[], None)),
        ("compressed exr of much that is not shown", exr(window(0x3FFF_FFFF, 30), small_window, 0, &[], Some(piz()))),
        ("exr of many channels", exr(window(1 << 20, 1), window(1 << 20, 1), 100_000, &[], Some(piz()))),
        ("exr far away", exr([i32::MIN, i32::MIN, i32::MIN, i32::MIN], small_window, 0, &[], None)),
        ("exr of nothing", exr([5, 5, -5, -5], small_window, 0, &[], None)),
        ("attribute of an exr", exr(small_window, small_window, 0, b"a\0string\0\xFF\xFF\xFF\x7F", None)),
        ("wide tga", vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 32, 0]),
        ("wide bmp", [&b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\xFF\xFF\xFF\x7F\xFF\xFF\xFF\x7F\x01\0\x18\0"[..], &[0; 24]].concat()),
    ];
    for (name, bytes) in files {
        directory.write("part.png", &bytes);
        for scene in ["image.gltf", "image.obj"] {
            let said = load(&directory.path(scene));
            let is_known = said
                .iter()
                .any(|s| s.contains("part.png") || s.contains("image 0") || s.contains("limit"));
            assert!(
                is_known || name == "text of a png" || name == "png of another size",
                "{name} in {scene}: {said:?}"
            );
        }
    }
}

#[test]
fn numbers_of_elements_are_not_believed() {
    let directory = Directory::new("counts");
    let gltf = |buffer: &str, accessor: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"buffers":[{buffer}],"bufferViews":[{{"buffer":0,"byteLength":36}}],"accessors":[{{"type":"VEC3","componentType":5126,{accessor}}}]}}"#
        )
    };
    let data = format!("data:;base64,{}", "AAAA".repeat(12));
    let plain = format!(r#"{{"byteLength":36,"uri":"{data}"}}"#);
    for (name, text) in [
        ("elements", gltf(&plain, r#""bufferView":0,"count":4000000000"#)),
        ("zeros", gltf(&plain, r#""count":4000000000"#)),
        ("most", gltf(&plain, r#""bufferView":0,"count":18446744073709551615"#)),
        ("strides", gltf(&plain, r#""bufferView":0,"count":3,"byteOffset":18446744073709551615"#)),
        (
            "sparse",
            gltf(
                &plain,
                r#""count":3,"sparse":{"count":4000000000,"indices":{"bufferView":0,"componentType":5125},"values":{"bufferView":0}}"#,
            ),
        ),
        (
            "buffer",
            gltf(
                &format!(r#"{{"byteLength":18446744073709551615,"uri":"{data}"}}"#),
                r#""bufferView":0,"count":3"#,
            ),
        ),
        (
            "data",
            gltf(r#"{"byteLength":36,"uri":"data:;base64,***"}"#, r#""bufferView":0,"count":3"#),
        ),
        ("empty data", gltf(r#"{"byteLength":36,"uri":"data:"}"#, r#""bufferView":0,"count":3"#)),
    ] {
        directory.write("scene.gltf", text);
        assert!(!load(&directory.path("scene.gltf")).is_empty(), "{name}");
    }
    // 26 MB of text are read, and 20 MB of data in it are too many more.
    let mut options = Options::default();
    options.limits.bytes = 40_000_000;
    let long = format!(r#"{{"byteLength":36,"uri":"data:;base64,{}"}}"#, "AAAA".repeat(6_500_000));
    directory.write("scene.gltf", gltf(&long, r#""bufferView":0,"count":3"#));
    let said = load_with(&directory.path("scene.gltf"), options);
    assert_said(&said, "more bytes than the limit admits");
    let xml = |kind: &str| {
        format!(
            "<scene version='3.0.0'><sensor type='perspective'/><shape type='cube'/><shape type='{kind}'><string name='filename' value='part'/></shape></scene>"
        )
    };
    for header in [
        "element vertex 4000000000\nproperty float x\nproperty float y\nproperty float z",
        "element nothing 18446744073709551615",
        "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uint uint vertex_indices",
        "element vertex 1\nproperty list uint double x",
    ] {
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let text = format!("ply\nformat {format} 1.0\n{header}\nend_header\n");
            directory.write("part", [text.as_bytes(), &[0xFF; 64]].concat());
            directory.write("scene.xml", xml("ply"));
            assert_said(&load(&directory.path("scene.xml")), "part: ");
        }
    }
    directory.write("part", "v 0 0 0\nf 4000000000 -4000000000 1\nf 1 1 4000000000\n");
    directory.write("scene.xml", xml("obj"));
    assert_said(&load(&directory.path("scene.xml")), "left out");
}

/// Each file includes the next one twice, or one file many.
#[test]
fn includes_do_not_multiply_without_end() {
    let directory = Directory::new("includes");
    let include = |k: usize| format!("<include filename='{k}.xml'/>");
    let scene = |elements: String| format!("<scene version='3.0.0'>{elements}</scene>");
    for k in 0..15 {
        directory.write(&format!("{k}.xml"), scene(include(k + 1).repeat(2)));
    }
    directory.write("15.xml", scene(String::new()));
    assert_said(&load(&directory.path("0.xml")), "more elements than the limit admits");
    directory.write("0.xml", scene(include(15).repeat(1_000_000)));
    assert_said(&load(&directory.path("0.xml")), "more elements than the limit admits");
    directory.write("0.xml", scene(include(0)));
    assert_said(&load(&directory.path("0.xml")), "include each other");
    for k in 0..15 {
        directory.write(&format!("{k}.pbrt"), format!("Include \"{}.pbrt\"\n", k + 1).repeat(2));
    }
    directory.write("15.pbrt", "");
    assert_said(&load(&directory.path("0.pbrt")), "limit");
    directory.write("0.pbrt", "Include \"15.pbrt\"\n".repeat(1_000_000));
    assert_said(&load(&directory.path("0.pbrt")), "limit");
    let libraries: String = (0..100_000).map(|k| format!("mtllib {}\n", k % 2)).collect();
    directory.write("0", "newmtl a\n");
    directory.write("scene.obj", format!("{libraries}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    assert_eq!(load(&directory.path("scene.obj")).len(), 1);
}
