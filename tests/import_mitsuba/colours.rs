//! Spectra and what they become.

use crate::files::{Directory, SENSOR, emitted_below};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::bsdf::{Bsdf, TransportMode};
use pathspace::geometry::SurfacePoint;
use pathspace::math::Rgb;
use pathspace::scene::Scene;

/// Values of Mitsuba 3.9, whose quadrature and tables differ by up to 0.12 %: lists are
/// interpolated, cut off at their ends, and seen under D65 unless they are emitted.
#[test]
fn spectra_become_what_the_observer_sees() {
    let directory = Directory::new("spectra");
    let emitted = |value: &str| {
        let glow =
            format!("<emitter type='area'><spectrum name='radiance' value='{value}'/></emitter>");
        emitted_below(
            &directory
                .load(&format!("{SENSOR}<shape type='rectangle'>{glow}</shape>"))
                .expect("valid"),
            0.0,
            0.0,
        )
    };
    let near = |a: Rgb, b: [f64; 3]| {
        (0..3).for_each(|i| assert_relative_eq!(a[i], b[i], max_relative = 2e-3))
    };
    near(emitted("0.5"), [0.602_397, 0.474_146, 0.454_458]);
    near(emitted("400:0.78, 500:0.78, 600:0.78, 700:0.78"), [0.935_761, 0.740_626, 0.704_686]);
    near(emitted("400:0, 500:8, 600:15.6, 700:18.4"), [20.7108, 10.8546, 2.771_15]);
    let reflected = |value: &str| {
        let bsdf = format!(
            "<bsdf type='twosided'><bsdf type='diffuse'><spectrum name='reflectance' value='{value}'/></bsdf></bsdf>"
        );
        let import = directory
            .load(&format!("{SENSOR}<shape type='rectangle'>{bsdf}</shape>"))
            .expect("valid");
        let x = SurfacePoint::dirac(DVec3::Z);
        let hit = import.world.intersect(&x, -DVec3::Z).expect("the rectangle");
        import.world.bsdf(&hit).eval(DVec3::Z, DVec3::Z) * std::f64::consts::PI
    };
    near(reflected("0.3"), [0.3; 3]);
    near(reflected("400:0.78, 500:0.78, 600:0.78, 700:0.78"), [0.776_367, 0.779_81, 0.776_029]);
    near(reflected("400:0.2,700:0.8"), [0.681_557, 0.485_825, 0.280_607]);
}

/// A list, a file, and a name of what they say.
#[test]
fn conductors_reflect_what_their_spectra_reflect() {
    let directory = Directory::new("conductors");
    let (n, k) = ([2.27, 2.14, 1.74, 1.2, 1.32, 1.82], [1.23, 1.06, 1.04, 1.65, 2.69, 3.81]);
    let at = [309.950012, 354.229004, 413.266998, 495.920013, 619.900024, 826.53302];
    let list = |values: [f64; 6]| {
        (0..6).map(|i| format!("{}:{}", at[i], values[i])).collect::<Vec<_>>().join(", ")
    };
    let file = |name: &str, values: [f64; 6]| {
        let lines: Vec<String> =
            (0..6).map(|i| format!("{} {} # measured", at[i], values[i])).collect();
        directory.write(name, format!("# titanium nitride\n\n{}\n", lines.join("\n")));
    };
    file("n.spd", n);
    file("k.spd", k);
    let reflected = |parameters: &str| {
        let bsdf = format!("<bsdf type='conductor'>{parameters}</bsdf>");
        let import = directory
            .load(&format!("{SENSOR}<shape type='rectangle'>{bsdf}</shape>"))
            .unwrap_or_else(|error| panic!("{error}"));
        let hit = import
            .world
            .intersect(&SurfacePoint::dirac(DVec3::Z), -DVec3::Z)
            .expect("the rectangle");
        import
            .world
            .bsdf(&hit)
            .sample(DVec3::Z, TransportMode::Radiance, 0.5, DVec2::splat(0.5))
            .expect("a reflection")
            .weight
    };
    let lists = format!(
        "<spectrum name='eta' value='{}'/><spectrum name='k' value='{}'/>",
        list(n),
        list(k)
    );
    let from_list = reflected(&lists);
    assert_eq!(
        from_list,
        reflected("<spectrum name='eta' filename='n.spd'/><spectrum name='k' filename='k.spd'/>")
    );
    // Integrated by another program.
    let (exact, named) =
        ([0.61378, 0.46143, 0.23274], reflected("<string name='material' value='TiN'/>"));
    for c in 0..3 {
        assert_relative_eq!(from_list[c], exact[c], max_relative = 1e-3);
        assert_relative_eq!(named[c], exact[c], max_relative = 1e-3);
    }
}

/// All names that Mitsuba 3.9 knows.
#[test]
fn materials_are_known_by_name() {
    let directory = Directory::new("names");
    let conductors = "none Ag Al AlAs AlAs_palik AlSb Au Be Cr CsI Cu Cu_palik Cu2O CuO Hg HgTe Ir K Li MgO Mo Na_palik Nb Ni_palik Rh Se Se-e SiC SnTe Ta Te Te-e ThF4 TiC TiN \
         TiO2 TiO2-e VC V_palik VN W a-C d-C d-C_palik";
    let dielectrics = [
        "vacuum",
        "helium",
        "hydrogen",
        "air",
        "carbon dioxide",
        "water",
        "acetone",
        "ethanol",
        "carbon tetrachloride",
        "glycerol",
        "benzene",
        "silicone oil",
        "bromine",
        "water ice",
        "fused quartz",
        "pyrex",
        "acrylic glass",
        "polypropylene",
        "bk7",
        "sodium chloride",
        "amber",
        "pet",
        "diamond",
    ];
    let bsdf = |kind: &str, parameter: &str, name: &str| {
        format!(
            "<shape type='rectangle'><bsdf type='{kind}'><string name='{parameter}' value='{name}'/></bsdf></shape>"
        )
    };
    let shapes = conductors.split_whitespace().map(|name| bsdf("conductor", "material", name));
    let shapes: String =
        shapes.chain(dielectrics.map(|name| bsdf("dielectric", "int_ior", name))).collect();
    let import =
        directory.load(&format!("{SENSOR}{shapes}")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(import.warnings, []);
}

/// Spectra as plug-ins. Daylight is white, and a uniform spectrum has its value in each channel, as
/// Mitsuba renders RGB; lists are what they are in an attribute. The sun's colour was integrated
/// by another program, every 5 nm.
#[test]
fn spectra_are_plug_ins_too() {
    let directory = Directory::new("plug-ins");
    let load = |spectrum: &str| {
        let glow = format!("<emitter type='area'>{spectrum}</emitter>");
        let import = directory
            .load(&format!("{SENSOR}<shape type='rectangle'>{glow}</shape>"))
            .unwrap_or_else(|error| panic!("{error}"));
        (emitted_below(&import, 0.0, 0.0), import.warnings)
    };
    let emitted = |spectrum: &str| {
        let (colour, warnings) = load(spectrum);
        assert_eq!(warnings, [], "{spectrum}");
        colour
    };
    let plug_in = |kind: &str, parameters: &str| {
        let [spectrum, texture] = ["spectrum", "texture"].map(|tag| {
            emitted(&format!("<{tag} type='{kind}' name='radiance'>{parameters}</{tag}>"))
        });
        assert_eq!(spectrum, texture, "{kind}");
        spectrum
    };
    let float = |name: &str, value: f64| format!("<float name='{name}' value='{value}'/>");
    assert_eq!(plug_in("d65", ""), Rgb::WHITE);
    assert_eq!(plug_in("d65", &float("scale", 3.0)), Rgb::splat(3.0));
    assert_eq!(plug_in("uniform", &float("value", 2.0)), Rgb::splat(2.0));
    let colour = "<rgb name='color' value='0.2, 0.5, 0.7'/>";
    assert_eq!(plug_in("srgb", colour), Rgb::new(0.2, 0.5, 0.7));
    let constant = "<rgb name='value' value='4, 5, 6'/>";
    assert_eq!(plug_in("rawconstant", constant), Rgb::new(4.0, 5.0, 6.0));
    let list = emitted("<spectrum name='radiance' value='400:1, 500:3, 600:2'/>");
    let irregular =
        "<string name='wavelengths' value='400, 500 600'/><string name='values' value='1, 3, 2'/>";
    assert_eq!(plug_in("irregular", irregular), list);
    let regular = "<float name='wavelength_min' value='400'/><float name='wavelength_max' value='600'/>\
         <string name='values' value='1, 3, 2'/>";
    assert_eq!(plug_in("regular", regular), list);
    let sun = plug_in("blackbody", &float("temperature", 5772.0));
    for (c, expected) in [28_106.6, 24_638.0, 23_064.0].into_iter().enumerate() {
        assert_relative_eq!(sun[c], expected, max_relative = 2e-3);
    }
    let (grey, warnings) = load("<spectrum type='measured' name='radiance'/>");
    assert_eq!((grey, warnings.len()), (Rgb::splat(0.5), 1));
    assert!(warnings[0].to_string().contains("spectrum of type measured"), "{}", warnings[0]);
}

/// R = ((n - 1)² + k²)/((n + 1)² + k²) at normal incidence, with 0 for what is negative.
#[test]
fn negative_indices_are_zero() {
    let directory = Directory::new("negative");
    let reflected = |kind: &str, eta: &str, k: &str| {
        let bsdf = format!("<bsdf type='{kind}'>{eta}{k}</bsdf>");
        let import = directory
            .load(&format!("{SENSOR}<shape type='rectangle'>{bsdf}</shape>"))
            .unwrap_or_else(|error| panic!("{error}"));
        let hit = import
            .world
            .intersect(&SurfacePoint::dirac(DVec3::Z), -DVec3::Z)
            .expect("the rectangle");
        let sample = import
            .world
            .bsdf(&hit)
            .sample(DVec3::Z, TransportMode::Radiance, 0.5, DVec2::splat(0.5))
            .expect("a reflection");
        let warnings = import.warnings.into_iter().map(|warning| warning.to_string()).collect();
        (sample.weight, warnings)
    };
    let rgb = |name: &str, value: &str| format!("<rgb name='{name}' value='{value}'/>");
    let (colour, warnings): (Rgb, Vec<String>) =
        reflected("conductor", &rgb("eta", "-0.05, 4, 4"), &rgb("k", "-0.04, 0.1, 1.3"));
    let exact = [1.0, 9.01 / 25.01, (9.0 + 1.69) / (25.0 + 1.69)];
    (0..3).for_each(|c| assert_relative_eq!(colour[c], exact[c], max_relative = 1e-12));
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("conductor: eta has negative components"), "{warnings:?}");
    assert!(warnings[1].contains("conductor: k has negative components"), "{warnings:?}");
    let (colour, warnings) = reflected("conductor", &rgb("eta", "0.5"), &rgb("k", "0, 1, 2"));
    let exact = [0.25 / 2.25, 1.25 / 3.25, 4.25 / 6.25];
    (0..3).for_each(|c| assert_relative_eq!(colour[c], exact[c], max_relative = 1e-12));
    assert_eq!(warnings, [""; 0]);
    let list = |name: &str, value: &str| format!("<spectrum name='{name}' value='{value}'/>");
    let (white, warnings) =
        reflected("conductor", &list("eta", "400:-1, 700:-0.5"), &list("k", "400:2, 700:-0.1"));
    (0..3).for_each(|c| assert_relative_eq!(white[c], 1.0, max_relative = 1e-12));
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    let (rough, warnings) =
        reflected("roughconductor", &rgb("eta", "-0.05, 4, 4"), &rgb("k", "-0.04, 0.1, 1.3"));
    assert!(rough.is_finite() && rough[0] > rough[2] && rough[2] > rough[1], "{rough:?}");
    assert_eq!(warnings.len(), 2, "{warnings:?}");
}

/// Corners of a triangle in red, green and blue, as floats and as bytes, times a scale.
#[test]
fn colours_of_vertices_are_interpolated() {
    let directory = crate::files::Directory::new("vertex colours");
    for (kind, names, one) in [
        ("float", ["color_0", "color_1", "color_2"], "1"),
        ("uchar", ["red", "green", "blue"], "255"),
    ] {
        let header: String = names.iter().map(|name| format!("property {kind} {name}\n")).collect();
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{header}element face 1\nproperty list uchar int vertex_indices\nend_header\n-1 -1 0 {one} 0 0\n1 -1 0 0 {one} 0\n0 1 0 0 0 {one}\n3 0 1 2\n"
        );
        directory.write("triangle.ply", ply);
        let texture = "<texture name='reflectance' type='mesh_attribute'><string name='name' value='vertex_color'/><float name='scale' value='0.5'/></texture>";
        let import = directory
            .load(&format!("{}<shape type='ply'><string name='filename' value='triangle.ply'/><bsdf type='diffuse'>{texture}</bsdf></shape>", crate::files::SENSOR))
            .expect("valid");
        assert!(import.warnings.is_empty(), "{:?}", import.warnings);
        let from = SurfacePoint::dirac(DVec3::new(-0.25, 0.0, 1.0));
        let point = import.world.intersect(&from, -DVec3::Z).expect("the triangle");
        let value = import.world.bsdf(&point).eval(DVec3::Z, DVec3::Z) * std::f64::consts::PI;
        for (channel, share) in [0.375, 0.125, 0.5].into_iter().enumerate() {
            assert_relative_eq!(value[channel], 0.5 * share, max_relative = 1e-12);
        }
    }
}
