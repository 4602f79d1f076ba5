//! glTF files against the same scenes built by hand, against closed forms, and against everything
//! that can be wrong with them.

#[path = "import_gltf/coats.rs"]
mod coats;
#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;
#[path = "import_gltf/damage.rs"]
mod damage;
#[path = "import_gltf/environment.rs"]
mod environment;
#[path = "import_gltf/files.rs"]
mod files;
#[path = "import_gltf/lights.rs"]
mod lights;
#[path = "import_gltf/materials.rs"]
mod materials;
#[path = "import_gltf/meshes.rs"]
mod meshes;
#[path = "import_gltf/packed.rs"]
mod packed;
#[path = "import_gltf/poses.rs"]
mod poses;
#[path = "import_gltf/refusals.rs"]
mod refusals;
#[path = "import_gltf/reliefs.rs"]
mod reliefs;
#[path = "import_gltf/room.rs"]
mod room;
#[path = "import_gltf/squares.rs"]
mod squares;
#[path = "import_gltf/vertices.rs"]
mod vertices;
#[path = "import_gltf/volumes.rs"]
mod volumes;
