//! Damaged files: an error or a scene, soon, and never a panic.

use crate::files::{data, directory, load_bytes};
use pathspace::import::{Limits, Options};
use proptest::prelude::*;

const HOSTILE: [&str; 12] = [
    "0",
    "-1",
    "1",
    "7",
    "255",
    "65535",
    "4294967295",
    "18446744073709551615",
    "1e38",
    "-1e300",
    "null",
    "[[[[[[[[[[[[]]]]]]]]]]]]",
];

/// Replaces the k-th number of a text.
fn with_number(text: &str, k: usize, value: &str) -> String {
    let is_part = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
    let mut starts = Vec::new();
    let mut quoted = false;
    let mut previous = ' ';
    for (at, c) in text.char_indices() {
        quoted ^= c == '"';
        if !quoted && (c.is_ascii_digit() || c == '-') && !is_part(previous) {
            starts.push(at);
        }
        previous = c;
    }
    let start = starts[k % starts.len()];
    let end = text[start..].find(|c| !is_part(c)).map_or(text.len(), |length| start + length);
    format!("{}{value}{}", &text[..start], &text[end..])
}

const FILES: [&str; 11] = [
    "box.gltf",
    "box.glb",
    "lights.gltf",
    "materials.gltf",
    "textures.gltf",
    "meshes.gltf",
    "wraps.gltf",
    "nodes.gltf",
    "poses.gltf",
    "instances.gltf",
    "packed.gltf",
];

/// Reads damaged bytes; the only thing to check is that it returns, soon.
fn survive(name: &str, bytes: &[u8]) {
    for other in ["textures.bin", "two by two.png", "halves.jpg"] {
        let copy = directory(name).join(other);
        if !copy.exists() {
            std::fs::copy(data(other), copy).expect("copied");
        }
    }
    let mut limits = Limits::default();
    (limits.bytes, limits.elements, limits.triangles, limits.pixels) =
        (1 << 20, 10_000, 100_000, 1 << 20);
    let start = std::time::Instant::now();
    let result = load_bytes(name, bytes, &Options { limits, ..Options::default() });
    assert!(start.elapsed().as_secs() < 10, "{:?}", result.err());
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 400,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn damaged_files_never_panic(
        file in 0..FILES.len(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in prop::option::weighted(0.1, any::<prop::sample::Index>()),
    ) {
        let mut bytes = std::fs::read(data(FILES[file])).expect("readable");
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        survive("damaged", &bytes);
    }

    #[test]
    fn hostile_numbers_never_panic(
        file in 0..FILES.len(),
        numbers in prop::collection::vec((any::<u16>(), 0..HOSTILE.len()), 1..4),
    ) {
        let name = if FILES[file] == "box.glb" { "box.gltf" } else { FILES[file] };
        let mut text = std::fs::read_to_string(data(name)).expect("readable");
        for (k, value) in numbers {
            text = with_number(&text, usize::from(k), HOSTILE[value]);
        }
        survive("hostile", text.as_bytes());
    }
}
