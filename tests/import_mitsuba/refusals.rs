//! Refusals, and warnings of what is left out.

use crate::files::{Directory, GLOW, SENSOR};
use glam::{DVec2, DVec3};
use pathspace::bsdf::{Bsdf, TransportMode};
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Options, mitsuba};
use pathspace::scene::Scene;

#[test]
fn what_is_not_supported_is_said() {
    let directory = Directory::new("warnings");
    let warning = |elements: &str| {
        directory.warning(&format!("{SENSOR}\n<shape type='sphere'>{GLOW}</shape>\n{elements}"))
    };
    let cases = [
        (
            "<shape type='sdfgrid' id='pipe'/>",
            "scene.xml:4: shape of type sdfgrid \"pipe\": shapes of type sdfgrid are not supported",
        ),
        ("<shape type='cube'><bsdf type='hair' id='x'/></shape>", "bsdf of type hair \"x\""),
        (
            "<shape type='cube'><bsdf type='conductor'><string name='material' value='Unobtainium'/></bsdf></shape>",
            "the conductor Unobtainium is not known",
        ),
        (
            "<shape type='cube'><bsdf type='diffuse'><float name='sheen' value='1'/></bsdf></shape>",
            "the parameter sheen (line 4) is not supported",
        ),
        (
            "<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>",
            "not scaled uniformly",
        ),
        (
            "<shape type='shapegroup' id='a'><shape type='instance'/></shape><shape type='instance'><ref id='a'/></shape>",
            "shapes of type instance in a shapegroup",
        ),
        ("<emitter type='projector'/>", "emitters of type projector are not supported"),
        ("<emitter type='area'/>", "belongs to no shape"),
        (
            "<integrator type='path'><boolean name='hide_emitters' value='true'/></integrator>",
            "hide_emitters",
        ),
        (
            "<shape type='cube'><bsdf type='dielectric'><float name='specular_transmittance' value='0.5'/><float name='specular_reflectance' value='0.7'/></bsdf></shape>",
            "differ",
        ),
        (
            "<sensor type='perspective'><film type='hdrfilm'><rfilter type='mitchell'/></film></sensor>",
            "the reconstruction filter mitchell",
        ),
        (
            "<sensor type='perspective'><float name='far_clip' value='0.5'/></sensor>",
            "near_clip or far_clip",
        ),
    ];
    for (elements, expected) in cases {
        let warning = warning(elements);
        assert!(warning.contains(expected), "{warning}");
    }
}

/// An object that makes no sense does not cost the scene, nor the objects beside it.
#[test]
fn what_makes_no_sense_is_left_out() {
    let directory = Directory::new("left-out");
    let cases = [
        ("<shape type='cube'><ref id='nobody'/></shape>", "there is no object with the id nobody"),
        (
            "<bsdf type='twosided' id='a'><ref id='a'/></bsdf><shape type='cube'><ref id='a'/></shape>",
            "contain each other",
        ),
        (
            "<bsdf type='mask' id='a'><ref id='b'/></bsdf><bsdf type='mask' id='b'><ref id='a'/></bsdf><shape type='cube'><ref id='a'/></shape>",
            "contain each other",
        ),
        ("<bsdf type='diffuse' id='a'/><bsdf type='diffuse' id='a'/>", "occurs twice"),
        ("<shape type='instance'/>", "an instance is of one shapegroup"),
        ("<shape type='instance'><ref id='nobody'/></shape>", "no object with the id nobody"),
        ("<shape type='cylinder'><point name='p1'/></shape>", "p0 and p1 are the same"),
        (
            "<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='1, 2, x'/></bsdf></shape>",
            "\"x\" is not a finite number",
        ),
        (
            "<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='1.5'/></bsdf></shape>",
            "bsdf of type diffuse: reflectance must be in [0, 1]",
        ),
        (
            "<shape type='cube'><bsdf type='twosided'><bsdf type='dielectric'/></bsdf></shape>",
            "must not transmit",
        ),
        (
            "<shape type='cube'><transform name='to_world'><scale x='0'/></transform></shape>",
            "normal of vertex 0 is zero",
        ),
        (
            "<shape type='obj'><string name='filename' value='none.obj'/></shape>",
            "there is no file none.obj",
        ),
        ("<include filename='none.xml'/>", "there is no file none.xml"),
        ("<include filename='../x.xml'/>", "outside of the scene's directory"),
        ("<path value='none'/>", "there is no file none"),
        (
            "<shape type='obj'><string name='filename' value='../x.obj'/></shape>",
            "outside of the scene's directory",
        ),
        (
            "<shape type='obj'><string name='filename' value='/etc/passwd'/></shape>",
            "outside of the scene's directory",
        ),
    ];
    for (elements, expected) in cases {
        let import = directory.left_out(
            &format!("{SENSOR}{elements}<shape type='rectangle'>{GLOW}</shape>"),
            expected,
        );
        assert_eq!(import.world.light_count(), 1, "{elements}");
    }
    // Of what is left of an object, too.
    let whole = |elements: &str, expected: &str| {
        let other = "<shape type='sphere'/>";
        let import = directory.left_out(&format!("{SENSOR}{other}{elements}"), expected);
        let surfaces = import.world.surface_count() - 1;
        (surfaces, import.world.light_count(), import.views.len())
    };
    let grey = "<bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='none.png'/></texture></bsdf>";
    assert_eq!(
        whole(&format!("<shape type='cube'>{grey}</shape>"), "there is no file none.png"),
        (1, 0, 1)
    );
    let dark = "<emitter type='area'><rgb name='radiance' value='-1'/></emitter>";
    assert_eq!(
        whole(&format!("<shape type='cube'>{dark}</shape>"), "shape of type cube"),
        (1, 0, 1)
    );
    assert_eq!(
        whole(
            "<emitter type='spot'><float name='cutoff_angle' value='x'/></emitter>",
            "is not a finite number"
        ),
        (0, 0, 1)
    );
    assert_eq!(
        whole(
            "<integrator type='path'><integer name='max_depth' value='x'/></integrator>",
            "must be an integer"
        ),
        (0, 0, 1)
    );
    let film = "<sensor type='perspective'><film type='hdrfilm'><rfilter type='gaussian'><float name='stddev' value='-1'/></rfilter></film></sensor>";
    assert_eq!(whole(film, "rfilter of type gaussian"), (0, 0, 2));
    let turned = |angle: &str| {
        format!(
            "<shape type='sphere'><transform name='to_world'><rotate angle='{angle}'/></transform></shape>"
        )
    };
    assert_eq!(whole(&turned("3"), "the axis has length zero"), (0, 0, 1));
    let import = directory.load(&format!("{SENSOR}{}", turned("0"))).expect("valid");
    assert_eq!((import.world.surface_count(), import.warnings), (1, vec![]));
}

/// A value that is not known is replaced, not the whole object: what is left is that of the
/// default.
#[test]
fn unknown_values_have_their_default() {
    let directory = Directory::new("values");
    let reflected = |bsdf: &str| {
        let text = format!("{SENSOR}<shape type='rectangle'>{bsdf}</shape>");
        let import = directory.load(&text).unwrap_or_else(|error| panic!("{error}"));
        let x = SurfacePoint::dirac(DVec3::new(0.3, 0.1, 1.0));
        let hit = import.world.intersect(&x, -DVec3::Z).expect("a surface");
        let bsdf = import.world.bsdf(&hit);
        let wo = DVec3::new(0.6, 0.0, 0.8);
        let images = [0.01, 0.99].map(|u| {
            let sample = bsdf.sample(wo, TransportMode::Radiance, u, DVec2::splat(0.4));
            sample.map(|sample| (sample.weight, sample.next))
        });
        (bsdf.eval(DVec3::new(-0.6, 0.0, 0.8), wo), images, import.warnings)
    };
    let map = "<string name='filename' value='parts/colours.png'/>";
    let textured = |value: &str| {
        format!(
            "<bsdf type='diffuse'><texture type='bitmap' name='reflectance'>{map}{value}</texture></bsdf>"
        )
    };
    let rough = |value: &str| format!("<bsdf type='roughconductor'>{value}</bsdf>");
    let glass = |value: &str| format!("<bsdf type='dielectric'>{value}</bsdf>");
    let plastic = |value: &str| format!("<bsdf type='plastic'>{value}</bsdf>");
    let tint = format!("<texture type='bitmap' name='specular_reflectance'>{map}</texture>");
    for (odd, plain, expected) in [
        (textured("<string name='filter_type' value='ewa'/>"), textured(""), "\"ewa\" is bilinear"),
        (textured("<string name='wrap_mode' value='zero'/>"), textured(""), "\"zero\" is repeat"),
        (rough("<string name='distribution' value='phong'/>"), rough(""), "\"phong\" is beckmann"),
        (glass("<string name='int_ior' value='jelly'/>"), glass(""), "it is that of bk7"),
        (
            glass("<float name='ext_ior' value='-1'/>"),
            glass(""),
            "-1 is not positive; it is that of air",
        ),
        (plastic(&tint), plastic(""), "must not be a texture here"),
    ] {
        let (odd, plain) = (reflected(&odd), reflected(&plain));
        assert_eq!((odd.0, odd.1), (plain.0, plain.1), "{expected}");
        assert_eq!((odd.2.len(), plain.2.len()), (1, 0), "{:?}", odd.2);
        assert!(odd.2[0].to_string().contains(expected), "{}", odd.2[0]);
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let directory = Directory::new("errors");
    let sphere = format!("<shape type='sphere'>{GLOW}</shape>");
    let cases = [
        (sphere.clone(), "no sensor"),
        (
            format!("<sensor type='perspective'><transform name='to_world'><scale value='0'/></transform></sensor>{sphere}"),
            "no sensor can be used: ",
        ),
        ("<include filename='scene.xml'/>".to_owned(), "include each other"),
        (
            "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='2000000000'/></film></sensor>".to_owned(),
            "larger than the limit",
        ),
        ("<default name='a' value='$b'/>".to_owned(), "the parameter $b has no value"),
    ];
    for (elements, expected) in cases {
        let error = directory.error(&elements);
        assert!(error.contains(expected) && error.contains("scene.xml"), "{elements}: {error}");
    }
    for version in ["0.3.0", "4.0.0", "", "x"] {
        let other = directory.write("other.xml", format!("<scene version='{version}'/>"));
        assert!(
            mitsuba::load(other, &Options::default(), [])
                .expect_err(version)
                .to_string()
                .contains("is none from 0.4 to 3.x")
        );
    }
}
