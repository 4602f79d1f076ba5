//! Files that want too much, and damaged files: an error, soon, and never a panic.

use crate::files::{DATA, Directory, SENSOR};
use pathspace::import::{Options, mitsuba};
use proptest::prelude::*;
use std::path::Path;

const SPHERE: &str = "<shape type='sphere'/>";

#[test]
fn hostile_files_are_refused_quickly() {
    let directory = Directory::new("hostile");
    let laughs = "<!DOCTYPE lolz [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;\">]>\n<scene version='3.0.0'>&b;</scene>";
    assert!(mitsuba::load(directory.write("laughs.xml", laughs), &Options::default(), []).is_err());
    let mut limited = Options::default();
    limited.limits.expansion = 1000;
    let mut doubling = String::from("<default name='p0' value='xxxxxxxx'/>");
    (1..60).for_each(|i| doubling += &format!("<default name='p{i}' value='$p{0}$p{0}'/>", i - 1));
    assert!(
        directory
            .load_with(&doubling, &limited)
            .expect_err("too long")
            .to_string()
            .contains("expand")
    );
    assert!(directory.error(&doubling).contains("expand"));
    let deep = format!("{}{}", "<bsdf type='twosided'>".repeat(5000), "</bsdf>".repeat(5000));
    assert!(directory.error(&deep).contains("nested too deeply"));
    limited = Options::default();
    limited.limits.elements = 100;
    assert!(directory.load_with(&"<bsdf type='null'/>".repeat(101), &limited).is_err());
    // Each file includes the next one twice.
    for i in 0..14 {
        let next = format!("<include filename='parts/{}.xml'/>", i + 1).repeat(2);
        directory
            .write(&format!("parts/{i}.xml"), format!("<scene version='3.0.0'>{next}</scene>"));
    }
    directory.write("parts/14.xml", "<scene version='3.0.0'/>");
    limited.limits.elements = 1000;
    assert!(
        directory
            .load_with("<include filename='parts/0.xml'/>", &limited)
            .expect_err("too many")
            .to_string()
            .contains("elements")
    );
    for header in
        ["element vertex 99999999999999", "element nothing 18446744073709551615\nelement vertex 1"]
    {
        let text = format!(
            "ply\nformat binary_little_endian 1.0\n{header}\nproperty float x\nproperty float y\nproperty float z\nend_header\nxxxxxxxxxxxx"
        );
        directory.write("parts/bomb.ply", text);
        let shape = "<shape type='ply'><string name='filename' value='parts/bomb.ply'/></shape>";
        directory.left_out(&format!("{SENSOR}{SPHERE}{shape}"), "bomb.ply");
    }
    let attributes: String = (0..300).map(|i| format!(" a{i}='1'")).collect();
    assert!(
        directory
            .error(&format!("<!-- {} --><bsdf{attributes}/>", "=".repeat(300)))
            .contains("more than 256 attributes")
    );
    assert!(
        directory.error(&"<path value='parts'/>".repeat(65)).contains("more than 64 directories")
    );
    limited = Options::default();
    limited.limits.triangles = 1000;
    directory.write(
        "parts/many.obj",
        format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", " f 1 2 3\n".repeat(1001)),
    );
    let many = "<shape type='obj'><string name='filename' value='parts/many.obj'/></shape>";
    assert!(
        directory
            .load_with(many, &limited)
            .expect_err("too many")
            .to_string()
            .contains("many.obj: it has more triangles than the limit admits")
    );
    #[cfg(unix)]
    {
        let _ = std::os::unix::fs::symlink("/etc/hostname", directory.0.join("parts/link.obj"));
        let shape = "<shape type='obj'><string name='filename' value='parts/link.obj'/></shape>";
        directory.left_out(
            &format!("{SENSOR}{SPHERE}{shape}"),
            "is a link out of the scene's directory",
        );
    }
}

/// Names of shapes without an id are told apart in a time that grows with their number.
#[test]
fn many_objects_in_one_line_take_a_moment() {
    let directory = Directory::new("many");
    let start = std::time::Instant::now();
    let import = directory
        .load(&format!("{SENSOR}{}", "<shape type='sphere'/>".repeat(30_000)))
        .expect("valid");
    assert_eq!(import.world.surface_count(), 30_000);
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}

/// Changes some bytes, and cuts off or repeats the end.
fn mutated(original: &[u8], changes: &[(u32, u8)], cut: u32) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for (at, value) in changes {
        let index = *at as usize % bytes.len();
        bytes[index] = *value;
    }
    if cut.is_multiple_of(3) {
        bytes.truncate(cut as usize % (bytes.len() + 1));
    }
    bytes
}

fn small_limits() -> Options {
    let mut options = Options::default();
    options.limits.bytes = 1 << 20;
    options.limits.triangles = 10_000;
    options.limits.pixels = 1 << 16;
    options.limits.elements = 1000;
    options
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 150,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn mutated_files_never_panic(
        changes in prop::collection::vec((any::<u32>(), any::<u8>()), 0..6),
        cut in any::<u32>(),
        which in 0usize..10,
    ) {
        let directory = Directory::new(&format!("fuzz-{which}"));
        let xml = ["diffuse.xml", "textures.xml", "mixtures.xml", "meshes.xml"];
        let parts = [
            "tetrahedron.obj",
            "tetrahedron.ply",
            "binary.ply",
            "two.serialized",
            "colours.png",
            "sky.exr",
        ];
        let mut scene = "textures.xml";
        if let Some(name) = xml.get(which) {
            scene = name;
        } else {
            let name = parts[which - xml.len()];
            let path = Path::new(DATA).join("parts").join(name);
            let original = std::fs::read(path).expect("test data");
            directory.write(&format!("parts/{name}"), mutated(&original, &changes, cut));
            if which < xml.len() + 4 {
                scene = "meshes.xml";
            }
        }
        let text = std::fs::read(Path::new(DATA).join(scene)).expect("test data");
        let text = if which < xml.len() { mutated(&text, &changes, cut) } else { text };
        let path = directory.write("scene.xml", text);
        let parameters = [("res".to_owned(), "8".to_owned())];
        if let Err(error) = mitsuba::load(path, &small_limits(), parameters) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
