//! Media inside of shapes.

use crate::files::{Directory, SENSOR};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::geometry::SurfacePoint;
use pathspace::import::Import;
use pathspace::math::Rgb;
use pathspace::scene::Scene;

fn scene(integrator: &str, medium: &str) -> String {
    format!(
        "{SENSOR}<integrator type='{integrator}'/>
        <shape type='sphere'><bsdf type='dielectric'/>{medium}</shape>"
    )
}

/// The share of light that passes from the middle of the unit sphere to its surface.
fn passing(import: &Import) -> Rgb {
    let middle = SurfacePoint::dirac(DVec3::ZERO);
    let surface = import.world.intersect(&middle, DVec3::X).expect("the sphere");
    import.world.transmittance(&middle, &surface)
}

#[test]
fn homogeneous_media_absorb() {
    let directory = Directory::new("media");
    let half = "<rgb name='sigma_t' value='0.5 1 2'/>";
    let (grey, black) = ("<float name='albedo' value='0'/>", "<rgb name='albedo' value='0'/>");
    for (parameters, sigma) in [
        (format!("{half}{black}"), [0.5, 1.0, 2.0]),
        (format!("{half}{grey}<float name='scale' value='3'/>"), [1.5, 3.0, 6.0]),
        ("<rgb name='sigma_a' value='0.5 1 2'/>".to_owned(), [0.5, 1.0, 2.0]),
        (
            format!(
                "<volume type='constvolume' name='sigma_t'>{}</volume>{black}",
                half.replace("sigma_t", "value")
            ),
            [0.5, 1.0, 2.0],
        ),
    ] {
        let medium = format!("<medium type='homogeneous' name='interior'>{parameters}</medium>");
        let import = directory.load(&scene("volpath", &medium)).expect("valid");
        assert!(import.warnings.is_empty(), "{:?}", import.warnings);
        let expected = sigma.map(|sigma: f64| (-sigma).exp());
        for (found, expected) in passing(&import).0.into_iter().zip(expected) {
            assert_relative_eq!(found, expected, max_relative = 1e-12);
        }
    }
}

#[test]
fn other_media_are_warned_about() {
    let directory = Directory::new("odd media");
    let medium = |name: &str, kind: &str, parameters: &str| {
        format!("<medium type='{kind}' name='{name}'>{parameters}</medium>")
    };
    let absorbing = "<float name='albedo' value='0'/>";
    for (integrator, medium, warning) in [
        ("volpath", medium("interior", "homogeneous", ""), "absorbs only"),
        ("volpath", medium("exterior", "homogeneous", absorbing), "around shapes"),
        ("volpath", medium("interior", "heterogeneous", ""), "of type heterogeneous"),
        ("path", medium("interior", "homogeneous", absorbing), "does not see media"),
        (
            "volpath",
            medium("interior", "homogeneous", "<rgb name='sigma_a' value='-1 0 0'/>"),
            "absorption is -1",
        ),
    ] {
        directory.left_out(&scene(integrator, &medium), warning);
    }
}
