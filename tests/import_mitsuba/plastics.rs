//! Rough plastic, by values.

use crate::files::{Directory, SENSOR};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::bsdf::Bsdf;
use pathspace::geometry::SurfacePoint;
use pathspace::math::Rgb;
use pathspace::scene::Scene;

fn direction(cosine: f64, azimuth: f64) -> DVec3 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine)
}

/// f for two directions of a surface with these parameters.
fn values(parameters: &str, pairs: &[[(f64, f64); 2]]) -> Vec<Rgb> {
    let directory = Directory::new("rough-plastic");
    let body = "<rgb name='diffuse_reflectance' value='0.9, 0.5, 0.1'/>";
    let bsdf = format!("<bsdf type='roughplastic'>{body}{parameters}</bsdf>");
    let import = directory.load(&format!("{SENSOR}<shape type='rectangle'>{bsdf}</shape>"));
    let import = import.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(import.warnings, []);
    let hit =
        import.world.intersect(&SurfacePoint::dirac(DVec3::Z), -DVec3::Z).expect("the rectangle");
    let bsdf = import.world.bsdf(&hit);
    pairs.iter().map(|[a, b]| bsdf.eval(direction(a.0, a.1), direction(b.0, b.1))).collect()
}

/// Values of Mitsuba 3.9, which interpolates linearly in a table over the cosine: within 0.5 %.
#[test]
fn rough_plastic_has_the_values_of_mitsuba() {
    let pairs = [
        [(1.0, 0.0), (0.5, 1.0)],
        [(0.8, 0.0), (0.8, std::f64::consts::PI)],
        [(0.3, 0.2), (0.6, 2.5)],
        [(0.1, 0.0), (0.2, 3.0)],
        [(0.9, 1.0), (0.05, 0.3)],
    ];
    let index =
        |n: f64| format!("<float name='int_ior' value='{n}'/><float name='ext_ior' value='1'/>");
    let ggx = "<string name='distribution' value='ggx'/><float name='alpha' value='0.3'/>";
    let saturated = "<float name='alpha' value='0.5'/><boolean name='nonlinear' value='true'/>\
                     <rgb name='specular_reflectance' value='0.2, 0.6, 1.0'/>";
    let cases = [
        (
            format!("{ggx}{}", index(1.49)),
            [
                [0.190399, 0.108166, 0.025933],
                [0.250532, 0.164681, 0.0788302],
                [0.173487, 0.101084, 0.0286812],
                [0.897705, 0.844132, 0.790559],
                [0.144602, 0.0820024, 0.0194031],
            ],
        ),
        (
            String::new(),
            [
                [0.265769, 0.147649, 0.0295299],
                [0.806649, 0.683079, 0.55951],
                [0.226086, 0.125603, 0.0251206],
                [0.108544, 0.0603023, 0.0120605],
                [0.129369, 0.0718717, 0.0143743],
            ],
        ),
        (
            format!("{saturated}{}", index(1.9)),
            [
                [0.144256, 0.0663669, 0.0361687],
                [0.15285, 0.0806478, 0.0576335],
                [0.134799, 0.0687693, 0.0464251],
                [0.447829, 1.05336, 1.69665],
                [0.122166, 0.0434953, 0.00686657],
            ],
        ),
    ];
    for (parameters, expected) in cases {
        for (value, expected) in values(&parameters, &pairs).into_iter().zip(expected) {
            for c in 0..3 {
                assert_relative_eq!(value[c], expected[c], max_relative = 5e-3);
            }
        }
    }
}
