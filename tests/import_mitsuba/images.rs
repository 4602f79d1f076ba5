//! Images of the files.

use crate::compare::{Comparison, assert_agree};
use crate::files::{DATA, load};
use pathspace::integrator::{Bidirectional, Depth, PathTracer};
use pathspace::render::{Budget, Render, Settings};

#[test]
fn every_file_renders() {
    for entry in std::fs::read_dir(DATA).expect("test data").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !name.ends_with(".xml") {
            continue;
        }
        let import = load(&name);
        let settings = Settings { budget: Budget::Samples(8), ..Settings::default() };
        let depth = Depth::up_to(import.hints.max_bounces.expect("every file says"));
        let path = PathTracer { depth, ..PathTracer::default() };
        let rendering = Render::render(&path, &import.world, &*import.views[0].camera, &settings)
            .expect("valid");
        assert!(
            rendering.image.mean().0.iter().all(|c| *c > 1e-3),
            "{name} is dark: {:?}",
            rendering.image.mean()
        );
        assert_eq!(rendering.counters.non_finite, 0, "{name}");
    }
}

/// One scene for each model, with a light that both can see.
#[test]
fn integrators_agree_on_files() {
    for name in [
        "plastic.xml",
        "roughplastic.xml",
        "mixtures.xml",
        "textures.xml",
        "roughconductor.xml",
        "roughdielectric.xml",
    ] {
        let import = load(name);
        let depth = Depth::up_to(3);
        let (path, both) = (
            PathTracer { depth, ..PathTracer::default() },
            Bidirectional { depth, ..Bidirectional::default() },
        );
        let members: [(&str, &dyn Render<_>); 2] = [("path", &path), ("bidirectional", &both)];
        assert_agree(
            name,
            &import.world,
            &*import.views[0].camera,
            &members,
            &Comparison::default(),
        );
    }
}
