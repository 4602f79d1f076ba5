//! Wavefront OBJ files and their material libraries: triangles, materials and images against values
//! worked out by hand, and everything that can be wrong with them.

#[path = "import_obj/faces.rs"]
mod faces;
#[path = "import_obj/files.rs"]
mod files;
#[path = "import_obj/maps.rs"]
mod maps;
#[path = "import_obj/materials.rs"]
mod materials;
#[path = "import_obj/refusals.rs"]
mod refusals;
