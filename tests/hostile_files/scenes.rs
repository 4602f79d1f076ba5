//! Scenes of every format around one file, and their reading.

use glam::UVec2;
use pathspace::import::{Options, gltf, mitsuba, obj, pbrt};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

/// A directory of its own for a test's files.
pub struct Directory(PathBuf);

impl Directory {
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hostile").join(name);
        _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("writable");
        std::fs::write(path.join("maps.mtl"), "newmtl a\nmap_Kd part.png\n").expect("writable");
        Self(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        _ = std::fs::remove_file(&path);
        _ = std::fs::remove_dir(&path);
        std::fs::write(&path, bytes).expect("writable");
        path
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The scene in which a file is used, its text, and the file.
pub const USES: [(&str, &str, &str); 14] = [
    ("image.xml", IMAGE, "part.png"),
    ("sky.xml", SKY, "part.png"),
    ("obj.xml", OBJ, "part.obj"),
    ("ply.xml", PLY, "part.ply"),
    ("serialized.xml", SERIALIZED, "part.serialized"),
    ("include.xml", INCLUDE, "part.xml"),
    ("spectrum.xml", SPECTRUM, "part.spd"),
    ("image.gltf", GLTF_IMAGE, "part.png"),
    ("buffer.gltf", GLTF_BUFFER, "part.bin"),
    ("library.obj", "mtllib part.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "part.mtl"),
    ("image.obj", OBJ_IMAGE, "part.png"),
    ("image.pbrt", PBRT_IMAGE, "part.png"),
    (
        "ply.pbrt",
        "WorldBegin\nShape \"sphere\"\nShape \"plymesh\" \"string filename\" \"part.ply\"\n",
        "part.ply",
    ),
    ("include.pbrt", "WorldBegin\nShape \"sphere\"\nInclude \"part.pbrt\"\n", "part.pbrt"),
];

const IMAGE: &str = "<scene version='3.0.0'><sensor type='perspective'/><shape type='cube'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='part.png'/></texture></bsdf></shape></scene>";
const SKY: &str = "<scene version='3.0.0'><sensor type='perspective'/><shape type='cube'/><emitter type='envmap'><string name='filename' value='part.png'/></emitter></scene>";
const OBJ: &str = "<scene version='3.0.0'><sensor type='perspective'/><shape type='cube'/><shape type='obj'><string name='filename' value='part.obj'/></shape></scene>";
const PLY: &str = "<scene version='3.0.0'><sensor type='perspective'/><shape type='cube'/><shape type='ply'><string name='filename' value='part.ply'/></shape></scene>";
pub const SERIALIZED: &str = "<scene version='3.0.0'><sensor type='perspective'/><shape type='cube'/><shape type='serialized'><string name='filename' value='part.serialized'/></shape></scene>";
const INCLUDE: &str = "<scene version='3.0.0'><include filename='part.xml'/></scene>";
const SPECTRUM: &str = "<scene version='3.0.0'><sensor type='perspective'/><shape type='cube'/><emitter type='constant'><spectrum name='radiance' filename='part.spd'/></emitter></scene>";
pub const GLTF_IMAGE: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],"accessors":[{"bufferView":0,"count":3,"type":"VEC3","componentType":5126}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"uri":"part.png"}]}"#;
const GLTF_BUFFER: &str =
    r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"part.bin","byteLength":36}]}"#;
const PBRT_IMAGE: &str = "WorldBegin\nTexture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"part.png\"\nMaterial \"diffuse\" \"texture reflectance\" \"a\"\nShape \"sphere\"\n";
pub const OBJ_IMAGE: &str =
    "mtllib maps.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";

/// Reads a scene in a thread of its own; everything that is said of it: the warnings, or the error.
pub fn load(path: &Path) -> Vec<String> {
    let mut options = Options::default();
    options.limits.outside_files = true;
    load_with(path, options)
}

pub fn load_with(path: &Path, options: Options) -> Vec<String> {
    let (sender, receiver) = mpsc::channel();
    let file = path.to_owned();
    let size = UVec2::splat(4);
    std::thread::spawn(move || {
        let before = processor_time();
        let import = match file.extension().and_then(|extension| extension.to_str()) {
            Some("xml") => mitsuba::load(&file, &options, []),
            Some("obj") => obj::load(&file, size, &options),
            Some("pbrt") => pbrt::load(&file, &options),
            _ => gltf::load(&file, size, &options),
        };
        let spent = processor_time() - before;
        let said: Vec<String> = match import {
            Ok(import) => import.warnings.iter().map(ToString::to_string).collect(),
            Err(error) => vec![error.to_string()],
        };
        _ = sender.send((said, spent));
    });
    // A thread that waits for a pipe takes no processor time.
    let answer = receiver.recv_timeout(Duration::from_secs(60));
    let (said, spent) = answer.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(spent < Duration::from_secs(1), "{} takes {spent:?}", path.display());
    let memory = most_memory();
    assert!(memory < 1 << 30, "{} takes {memory} bytes", path.display());
    said
}

/// The processor time of this thread.
fn processor_time() -> Duration {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    Duration::from_nanos(text.split(' ').next().and_then(|n| n.parse().ok()).expect("a number"))
}

/// The most memory that the process has had so far.
fn most_memory() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a line");
    1024 * line.trim().trim_end_matches(" kB").parse::<u64>().expect("a number")
}
