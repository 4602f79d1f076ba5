//! Refusals, and warnings of what is left out.

use crate::files::{Directory, GLOW, SENSOR};
use pathspace::import::{Options, mitsuba};

#[test]
fn what_is_not_supported_is_said() {
    let directory = Directory::new("warnings");
    let warning = |elements: &str| {
        directory.warning(&format!("{SENSOR}\n<shape type='sphere'>{GLOW}</shape>\n{elements}"))
    };
    let cases = [
        (
            "<shape type='cylinder' id='pipe'/>",
            "scene.xml:4: shape of type cylinder \"pipe\": shapes of type cylinder are not supported",
        ),
        (
            "<shape type='cube'><bsdf type='principled' id='x'/></shape>",
            "bsdf of type principled \"x\"",
        ),
        (
            "<shape type='cube'><bsdf type='conductor'><string name='material' value='Unobtainium'/></bsdf></shape>",
            "the conductor Unobtainium is not known",
        ),
        (
            "<shape type='cube'><bsdf type='diffuse'><float name='sheen' value='1'/></bsdf></shape>",
            "the parameter sheen (line 4) is not supported",
        ),
        (
            "<shape type='disk'><transform name='to_world'><scale x='2'/></transform></shape>",
            "not scaled uniformly",
        ),
        ("<emitter type='projector'/>", "emitters of type projector are not supported"),
        ("<emitter type='area'/>", "belongs to no shape"),
        ("<medium type='homogeneous'/>", "participating media"),
        (
            "<integrator type='path'><boolean name='hide_emitters' value='true'/></integrator>",
            "hide_emitters",
        ),
        (
            "<shape type='cube'><bsdf type='dielectric'><float name='specular_transmittance' value='0.5'/></bsdf></shape>",
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

#[test]
fn what_makes_no_sense_is_refused() {
    let directory = Directory::new("errors");
    let sphere = format!("<shape type='sphere'>{GLOW}</shape>");
    let cases = [
        (sphere.clone(), "no sensor"),
        (format!("{SENSOR}{sphere}<shape type='cube'><ref id='nobody'/></shape>"), "there is no object with the id nobody"),
        (
            format!("{SENSOR}<bsdf type='twosided' id='a'><ref id='a'/></bsdf><shape type='cube'><ref id='a'/></shape>"),
            "contain each other",
        ),
        (
            format!(
                "{SENSOR}<bsdf type='mask' id='a'><ref id='b'/></bsdf><bsdf type='mask' id='b'><ref id='a'/></bsdf><shape type='cube'><ref id='a'/></shape>"
            ),
            "contain each other",
        ),
        (format!("{SENSOR}<bsdf type='diffuse' id='a'/><bsdf type='diffuse' id='a'/>"), "occurs twice"),
        (
            format!("{SENSOR}<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='1, 2, x'/></bsdf></shape>"),
            "\"x\" is not a finite number",
        ),
        (
            format!("{SENSOR}<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='1.5'/></bsdf></shape>"),
            "bsdf of type diffuse: reflectance must be in [0, 1]",
        ),
        (format!("{SENSOR}<shape type='cube'><bsdf type='twosided'><bsdf type='dielectric'/></bsdf></shape>"), "must not transmit"),
        (format!("{SENSOR}<shape type='cube'><transform name='to_world'><scale x='0'/></transform></shape>"), "normal of vertex 0 is zero"),
        (format!("{SENSOR}<shape type='obj'><string name='filename' value='none.obj'/></shape>"), "there is no file none.obj"),
        (format!("{SENSOR}<shape type='obj'><string name='filename' value='../x.obj'/></shape>"), "outside of the scene's directory"),
        (format!("{SENSOR}<shape type='obj'><string name='filename' value='/etc/passwd'/></shape>"), "outside of the scene's directory"),
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
