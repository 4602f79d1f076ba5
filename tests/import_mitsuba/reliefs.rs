//! Normal and bump maps.

use crate::files::{Directory, SENSOR};
use approx::assert_relative_eq;
use glam::DVec3;
use pathspace::geometry::SurfacePoint;
use pathspace::import::Import;
use pathspace::scene::Scene;

const DIFFUSE: &str = "<bsdf type='diffuse'/>";

fn normal_at(import: &Import, x: f64, y: f64) -> DVec3 {
    let from = SurfacePoint::dirac(DVec3::new(x, y, 5.0));
    import.world.intersect(&from, -DVec3::Z).expect("a surface").shading_normal
}

/// x = 0.6, y = 0.8 and z = 1 along the direction of u, here y, and across it.
#[test]
fn normal_maps_follow_the_parameters() {
    let directory = Directory::new("normal maps");
    let map =
        format!("<bsdf type='normalmap'><rgb name='normalmap' value='0.8 0.9 1'/>{DIFFUSE}</bsdf>");
    for bsdf in [map.clone(), format!("<bsdf type='twosided'>{map}</bsdf>")] {
        let turn = "<transform name='to_world'><rotate z='1' angle='90'/></transform>";
        let import = directory
            .load(&format!("{SENSOR}<shape type='rectangle'>{turn}{bsdf}</shape>"))
            .expect("valid");
        assert!(import.warnings.is_empty(), "{:?}", import.warnings);
        let expected = DVec3::new(-0.8, 0.6, 1.0).normalize();
        assert_relative_eq!(normal_at(&import, 0.3, 0.2), expected, max_relative = 1e-12);
    }
}

#[test]
fn bump_maps_have_slopes_in_proportion_to_their_scale() {
    let directory = Directory::new("bump maps");
    let slopes = |scale: &str| {
        let texture =
            "<texture type='bitmap'><string name='filename' value='parts/colours.png'/></texture>";
        let map = format!("<bsdf type='bumpmap'>{scale}{DIFFUSE}{texture}</bsdf>");
        let import = directory
            .load(&format!("{SENSOR}<shape type='rectangle'>{map}</shape>"))
            .expect("valid");
        assert!(import.warnings.is_empty(), "{:?}", import.warnings);
        [(0.3, 0.2), (-0.4, 0.1)].map(|(x, y)| {
            let normal = normal_at(&import, x, y);
            normal.truncate() / normal.z
        })
    };
    let (once, thrice) = (slopes(""), slopes("<float name='scale' value='3'/>"));
    for (once, thrice) in once.into_iter().zip(thrice) {
        assert!(once.length() > 1e-3, "{once}");
        assert_relative_eq!(thrice, once * 3.0, max_relative = 1e-9);
    }
}

#[test]
fn maps_that_cannot_be_laid_are_warned_about() {
    let directory = Directory::new("odd maps");
    let inner =
        format!("<bsdf type='normalmap'><rgb name='normalmap' value='0.8 0.9 1'/>{DIFFUSE}</bsdf>");
    for (bsdf, warning) in [
        (
            format!("<bsdf type='normalmap'><rgb name='normalmap' value='1 1 1'/>{inner}</bsdf>"),
            "another map",
        ),
        (
            format!(
                "<bsdf type='blendbsdf'><float name='weight' value='0.5'/>{inner}{DIFFUSE}</bsdf>"
            ),
            "laid on both",
        ),
        (
            inner
                .replace("</rgb>", "")
                .replace("<rgb", "<boolean name='use_shadowing_function' value='false'/><rgb"),
            "turned off",
        ),
        (format!("<bsdf type='bumpmap'>{DIFFUSE}</bsdf>"), "bumpmap has one texture"),
        (
            "<bsdf type='bumpmap'><texture type='checkerboard'/></bsdf>".to_owned(),
            "laid on one bsdf",
        ),
    ] {
        directory.left_out(&format!("{SENSOR}<shape type='rectangle'>{bsdf}</shape>"), warning);
    }
}
