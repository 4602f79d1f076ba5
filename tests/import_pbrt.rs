//! Scenes of pbrt: what each feature becomes, what is left out, and what hostile files do.

#[path = "import_pbrt/cameras.rs"]
mod cameras;
#[path = "import_pbrt/files.rs"]
mod files;
#[path = "import_pbrt/hostile.rs"]
mod hostile;
#[path = "import_pbrt/lights.rs"]
mod lights;
#[path = "import_pbrt/materials.rs"]
mod materials;
#[path = "import_pbrt/shapes.rs"]
mod shapes;
#[path = "import_pbrt/syntax.rs"]
mod syntax;
#[path = "import_pbrt/textures.rs"]
mod textures;
