//! Files that never end, are no files, or stand for more than there is memory for: each is refused
//! or left out with a warning within a second of processor time and in little memory.
#![cfg(target_os = "linux")]

#[path = "hostile_files/bits.rs"]
mod bits;
#[path = "hostile_files/bombs.rs"]
mod bombs;
#[path = "hostile_files/scenes.rs"]
mod scenes;

use scenes::{Directory, USES, load};
use std::process::Command;

/// What stands in the place of a file, and what is said of it.
const SPECIAL: [(&str, &str); 6] = [
    ("pipe", "is not a file"),
    ("link to a pipe", "is not a file"),
    ("link to a device", "is not a file"),
    ("directory", "is not a file"),
    ("link to a directory", "is not a file"),
    ("4 GB", "more bytes than the limit admits"),
];

fn run(command: &mut Command) {
    assert!(command.status().expect("a program of the system").success(), "{command:?}");
}

fn make_special(directory: &Directory, kind: &str, name: &str) {
    let path = directory.path(name);
    _ = std::fs::remove_file(&path);
    _ = std::fs::remove_dir(&path);
    let link = |target: &str| std::os::unix::fs::symlink(target, &path).expect("a link");
    match kind {
        "pipe" => run(Command::new("mkfifo").arg(&path)),
        "link to a pipe" => {
            let target = directory.path("a pipe");
            if !target.exists() {
                run(Command::new("mkfifo").arg(&target));
            }
            link("a pipe");
        }
        "link to a device" => link("/dev/zero"),
        "directory" => std::fs::create_dir(&path).expect("a directory"),
        "link to a directory" => link("."),
        // It takes no place on the disk.
        _ => std::fs::File::create(&path).and_then(|f| f.set_len(1 << 32)).expect("a hole"),
    }
}

#[test]
fn what_is_no_file_is_refused_at_once() {
    let directory = Directory::new("special");
    for (kind, expected) in SPECIAL {
        for (scene, text, part) in USES {
            directory.write(scene, text);
            make_special(&directory, kind, part);
            let said = load(&directory.path(scene));
            let is_said = said.iter().any(|sentence| sentence.contains(expected));
            assert!(is_said, "{kind} as {part} of {scene}: {said:?}");
        }
        for scene in ["scene.xml", "scene.gltf", "scene.glb", "scene.obj", "scene.pbrt"] {
            make_special(&directory, kind, scene);
            let said = load(&directory.path(scene));
            assert!(said.len() == 1 && said[0].contains(expected), "{kind} as {scene}: {said:?}");
        }
    }
}
