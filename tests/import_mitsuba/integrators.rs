//! Integrators, and how far they go.

use crate::files::Directory;
use approx::assert_relative_eq;
use pathspace::integrator::{Depth, PathTracer};
use pathspace::render::{Budget, Render, Settings};

/// In a closed sphere that emits 1 and reflects 0.8, n scattering events see 1 + 0.8 + … + 0.8ⁿ.
/// Sampling of lights and of directions have the same density there: there is no noise.
#[test]
fn integrators_go_as_far_as_they_should() {
    let directory = Directory::new("integrators");
    let scene = "<sensor type='perspective'><float name='fov' value='60'/>\
         <film type='hdrfilm'><integer name='width' value='4'/><integer name='height' value='4'/>\
         </film></sensor><shape type='sphere'><boolean name='flip_normals' value='true'/>\
         <bsdf type='diffuse'><rgb name='reflectance' value='0.8'/></bsdf>\
         <emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>";
    let depth = |edges: i32| format!("<integer name='max_depth' value='{edges}'/>");
    let path = |edges: i32| format!("<integrator type='path'>{}</integrator>", depth(edges));
    let cases = [
        (path(1), 1.0, vec![]),
        (path(3), 2.44, vec![]),
        (path(0), 0.0, vec!["integrator of type path: a max_depth of 0 sees nothing"]),
        ("<integrator type='direct'/>".to_owned(), 1.8, vec![]),
        (format!("<integrator type='direct'>{}</integrator>", depth(9)), 1.8, vec![]),
        (
            format!("<integrator type='aov'>{}</integrator>", path(3)),
            2.44,
            vec!["of the integrator aov only the one in it is taken"],
        ),
        (
            format!(
                "<integrator type='moment'><integrator type='aov'>{}{}</integrator></integrator>",
                path(2),
                path(3)
            ),
            1.8,
            vec![
                "of the integrator moment only the one in it",
                "of the integrator aov only the first one in it",
            ],
        ),
        (format!("<integrator type='guided'>{}</integrator>", depth(2)), 1.8, vec![]),
        (path(-1), 5.0, vec![]),
        (path(-2), 5.0, vec!["a max_depth of -2 is not known, and taken for no limit"]),
        (
            "<integrator type='depth'/>".to_owned(),
            5.0,
            vec!["the integrator depth is not known; light is taken without a limit"],
        ),
    ];
    for (integrator, expected, warnings) in cases {
        let import = directory.load(&format!("{scene}{integrator}")).expect(&integrator);
        let depth = Depth { min_bounces: 0, max_bounces: import.hints.max_bounces };
        assert_eq!(depth.max_bounces.is_none(), expected == 5.0, "{integrator}");
        // Without a limit roulette makes noise.
        if depth.max_bounces.is_some() {
            let mean = Render::render(
                &PathTracer { depth, ..PathTracer::default() },
                &import.world,
                &*import.views[0].camera,
                &Settings { budget: Budget::Samples(4), ..Settings::default() },
            )
            .expect("valid")
            .image
            .mean();
            (0..3).for_each(|c| assert_relative_eq!(mean[c], expected, max_relative = 1e-9));
        }
        assert_eq!(import.warnings.len(), warnings.len(), "{:?}", import.warnings);
        for (warning, expected) in import.warnings.iter().zip(warnings) {
            assert!(warning.to_string().contains(expected), "{warning}");
        }
    }
    let knot = "<integrator type='aov' id='a'><ref id='a'/></integrator>";
    let import = directory.load(&format!("{scene}{knot}")).expect("a scene");
    let last = import.warnings.last().expect("a warning").to_string();
    assert!(last.contains("contain each other; all light is taken"), "{last}");
}
