//! Files that want too much, and damaged files: an error, soon, and never a panic.

use crate::files::{DATA, Directory, FLOOR, PROBE};
use pathspace::import::{Options, pbrt};
use proptest::prelude::*;
use std::path::Path;
use std::time::Instant;

fn limited(change: impl Fn(&mut pathspace::import::Limits)) -> Options {
    let mut options = Options::default();
    change(&mut options.limits);
    options
}

/// What the limits do not admit is refused, and the error says so.
#[test]
fn limits_refuse() {
    let directory = Directory::new("limits");
    let refused = |text: &str, options: &Options, expected: &str| {
        let start = Instant::now();
        let error = directory.load_with(text, options).expect_err(text).to_string();
        assert!(error.contains(expected), "{error}");
        assert!(start.elapsed().as_secs() < 10, "{expected}: {:?}", start.elapsed());
    };
    let defaults = Options::default();
    refused("Include \"scene.pbrt\"", &defaults, "included too deeply");
    // Each file includes the next one twice.
    for i in 0..14 {
        let next = format!("Include \"parts/{}.pbrt\"\n", i + 1).repeat(2);
        directory.write(&format!("parts/{i}.pbrt"), next);
    }
    directory.write("parts/14.pbrt", "");
    refused("Include \"parts/0.pbrt\"", &defaults, "elements");
    let many = "AttributeBegin\n".repeat(101);
    refused(&many, &limited(|limits| limits.elements = 100), "elements");
    let parameters = format!("Shape \"sphere\" {}", "\"float a\" 1 ".repeat(101));
    refused(&parameters, &limited(|limits| limits.elements = 100), "elements");
    refused(FLOOR, &limited(|limits| limits.bytes = 20), "bytes");
    // A megabyte of zeros in a kilobyte.
    let packed = format!("{PROBE}Include \"parts/zeros.pbrt.gz\"");
    std::fs::copy(Path::new(DATA).join("zeros.pbrt.gz"), directory.0.join("parts/zeros.pbrt.gz"))
        .expect("a copy");
    refused(&packed, &limited(|limits| limits.bytes = 100_000), "bytes");
    let fan = format!(
        "{PROBE}ObjectBegin \"a\"\nShape \"plymesh\" \"string filename\" \"parts/pyramid.ply.gz\"\nObjectEnd\n{}",
        "ObjectInstance \"a\"\n".repeat(100)
    );
    refused(&fan, &limited(|limits| limits.triangles = 500), "triangles");
    refused(
        &fan.replace("ObjectInstance", "#"),
        &limited(|limits| limits.triangles = 5),
        "plymesh",
    );
    let film = format!(
        "Film \"rgb\" \"integer xresolution\" 4000000000 \"integer yresolution\" 4000000000\n{FLOOR}"
    );
    refused(&film, &defaults, "larger than the limit");
    let image = format!(
        "{PROBE}Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"parts/colours.png\"\n{FLOOR}"
    );
    refused(&image, &limited(|limits| limits.pixels = 15), "pixels");
}

/// Files that are no files of the scene are left out.
#[test]
fn other_files_are_not_read() {
    let directory = Directory::new("outside");
    for name in ["/etc/hostname", "../scene.pbrt", "parts/../../x", "", "parts"] {
        let text = format!("{PROBE}{FLOOR}Include \"{name}\"");
        assert!(!directory.left_out(&text, "left out").warnings.is_empty());
    }
    #[cfg(unix)]
    {
        let pipe = directory.0.join("parts/pipe.pbrt");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        if made.is_ok_and(|status| status.success()) {
            directory.left_out(&format!("{PROBE}{FLOOR}Include \"parts/pipe.pbrt\""), "not a file");
            assert!(pbrt::load(&pipe, &Options::default()).is_err());
        }
        let _ = std::os::unix::fs::symlink("/etc/hostname", directory.0.join("parts/link.pbrt"));
        directory.left_out(&format!("{PROBE}{FLOOR}Include \"parts/link.pbrt\""), "a link out of");
    }
}

/// Many attributes for many objects, and many warnings, take a moment.
#[test]
fn long_files_take_a_moment() {
    let directory = Directory::new("long");
    let start = Instant::now();
    let attributes: String = (0..60).map(|i| format!("\"float a{i}\" 1 ")).collect();
    let text =
        format!("{PROBE}Attribute \"shape\" {attributes}\n{}", "Shape \"sphere\"\n".repeat(20_000));
    let import = directory.load(&text);
    assert_eq!(import.world.surface_count(), 20_000);
    let text =
        format!("{PROBE}{FLOOR}{}", "Shape \"sphere\" \"float b\" 1\n] x Y\n".repeat(20_000));
    assert!(directory.load_with(&text, &Options::default()).is_ok());
    let attributes: String = (0..65).map(|i| format!("\"float a{i}\" 1 ")).collect();
    directory.left_out(
        &format!("{PROBE}{FLOOR}Attribute \"shape\" {attributes}"),
        "more than 64 attributes",
    );
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

fn small_limits() -> Options {
    limited(|limits| {
        limits.bytes = 1 << 20;
        limits.triangles = 10_000;
        limits.pixels = 1 << 16;
        limits.elements = 2000;
    })
}

/// The room, cut off after each of its bytes: something is left to see, or nothing is.
#[test]
fn files_may_end_anywhere() {
    let directory = Directory::new("cut");
    let text = std::fs::read(Path::new(DATA).join("room.pbrt")).expect("test data");
    let mut seen = 0;
    for length in 0..text.len() {
        let path = directory.write("scene.pbrt", &text[..length]);
        match pbrt::load(path, &small_limits()) {
            Ok(import) => {
                assert!(import.world.primitive_count() + import.world.light_count() > 0);
                seen += 1;
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
    assert!(seen > text.len() / 2 && seen < text.len());
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn mutated_files_never_panic(
        changes in prop::collection::vec((any::<u32>(), any::<u8>()), 0..8),
        moves in prop::collection::vec((any::<u32>(), any::<u32>()), 0..4),
        which in 0usize..4,
    ) {
        let directory = Directory::new(&format!("fuzz-{which}"));
        let name =
            ["room.pbrt", "parts/materials.pbrt.gz", "parts/pyramid.ply.gz", "parts/colours.png"][which];
        let read = |name: &str| std::fs::read(Path::new(DATA).join(name)).expect("test data");
        let mut bytes = read(name);
        let count = bytes.len();
        for (at, value) in changes {
            bytes[at as usize % count] = value;
        }
        // Words change places.
        for (from, to) in moves {
            let (from, to) = (from as usize % (count - 8), to as usize % (count - 8));
            bytes.copy_within(from..from + 8, to);
        }
        let scene = if which == 0 { bytes } else {
            directory.write(name, bytes);
            read("room.pbrt")
        };
        let path = directory.write("scene.pbrt", scene);
        if let Err(error) = pbrt::load(path, &small_limits()) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
