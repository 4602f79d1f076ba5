//! Scenes of Mitsuba 3: what each feature becomes, what is refused, and what hostile files do.

#[path = "import_mitsuba/cameras.rs"]
mod cameras;
#[path = "import_mitsuba/colours.rs"]
mod colours;
#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;
#[path = "import_mitsuba/elements.rs"]
mod elements;
#[path = "import_mitsuba/emitters.rs"]
mod emitters;
#[path = "import_mitsuba/files.rs"]
mod files;
#[path = "import_mitsuba/hostile.rs"]
mod hostile;
#[path = "import_mitsuba/images.rs"]
mod images;
#[path = "import_mitsuba/integrators.rs"]
mod integrators;
#[path = "import_mitsuba/leftovers.rs"]
mod leftovers;
#[path = "import_mitsuba/media.rs"]
mod media;
#[path = "import_mitsuba/plastics.rs"]
mod plastics;
#[path = "import_mitsuba/refusals.rs"]
mod refusals;
#[path = "import_mitsuba/reliefs.rs"]
mod reliefs;
