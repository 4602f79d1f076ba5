//! Values out of range, tags of old versions, parameters without a value, and sizes of films.

use crate::files::{Directory, SENSOR, emitted_below};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3, UVec2};
use pathspace::bsdf::Bsdf;
use pathspace::endpoint::Camera;
use pathspace::film::{Image, ImageFile, linear_from_srgb};
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Import, Options, mitsuba};
use pathspace::math::Rgb;
use pathspace::scene::Scene;
use std::f64::consts::PI;

/// The reflectance of a diffuse rectangle at some point.
fn albedo(import: &Import, x: f64, y: f64) -> Rgb {
    let from = SurfacePoint::dirac(DVec3::new(x, y, 1.0));
    let point = import.world.intersect(&from, -DVec3::Z).expect("the rectangle");
    import.world.bsdf(&point).eval(DVec3::Z, DVec3::Z) * PI
}

fn rectangle(reflectance: &str) -> String {
    format!("{SENSOR}<shape type='rectangle'><bsdf type='diffuse'>{reflectance}</bsdf></shape>")
}

#[test]
fn reflectances_are_clamped_to_what_is_possible() {
    let directory = Directory::new("clamped");
    let bright = Image::from_fn(2, 1, |x, _| Rgb::new(if x == 0 { 2.0 } else { 0.25 }, 0.5, 0.0));
    ImageFile::from(bright).save(directory.0.join("bright.exr")).expect("writable");
    let nearest = "<string name='filter_type' value='nearest'/>";
    let bitmap = format!(
        "<texture type='bitmap' name='reflectance'><string name='filename' value='bright.exr'/>{nearest}</texture>"
    );
    let board = "<texture type='checkerboard' name='reflectance'><rgb name='color0' value='1.5 0.5 -0.5'/><float name='color1' value='0.25'/></texture>";
    let left = DVec2::new(-0.5, 0.5);
    for (reflectance, at, expected, said) in [
        (
            "<rgb name='reflectance' value='1.25 0.5 0'/>",
            left,
            Rgb::new(1.0, 0.5, 0.0),
            "reflectance must be in [0, 1], but is 1.25, 0.5, 0",
        ),
        (
            "<rgb name='reflectance' value='0.5 -0.5 0'/>",
            left,
            Rgb::new(0.5, 0.0, 0.0),
            "reflectance must be in [0, 1], but is 0.5, -0.5, 0",
        ),
        (
            "<float name='reflectance' value='7'/>",
            left,
            Rgb::WHITE,
            "reflectance must be in [0, 1], but is 7, 7, 7",
        ),
        (&bitmap, left, Rgb::new(1.0, 0.5, 0.0), "reflectance must be in [0, 1], but is 2, 0.5, 0"),
        (
            &bitmap,
            -left,
            Rgb::new(0.25, 0.5, 0.0),
            "reflectance must be in [0, 1], but is 2, 0.5, 0",
        ),
        (board, left, Rgb::splat(0.25), "reflectance must be in [0, 1]"),
        (board, DVec2::splat(0.5), Rgb::new(1.0, 0.5, 0.0), "reflectance must be in [0, 1]"),
    ] {
        let import = directory.left_out(&rectangle(reflectance), said);
        assert_eq!(import.warnings.len(), 1, "{:?}", import.warnings);
        let shown = albedo(&import, at.x, at.y);
        (0..3).for_each(|c| assert_relative_eq!(shown[c], expected[c], max_relative = 1e-12));
    }
    // What is emitted has no such bounds, nor have the indices of metals.
    let glow = "<emitter type='area'><rgb name='radiance' value='3 2 1'/></emitter>";
    let metal = "<bsdf type='conductor'><rgb name='eta' value='1.5 1.25 2'/><rgb name='k' value='3 2 1'/></bsdf>";
    let scene = format!("{SENSOR}<shape type='rectangle'>{glow}{metal}</shape>");
    assert!(directory.load(&scene).expect("valid").warnings.is_empty());
}

#[test]
fn colours_of_old_versions_are_read() {
    let directory = Directory::new("old-colours");
    let old = |elements: &str| {
        let text = format!("<scene version=\"0.6.0\">\n{elements}\n</scene>");
        let path = directory.write("old.xml", text);
        mitsuba::load(path, &Options { strict: true, ..Options::default() }, []).expect(elements)
    };
    for text in ["#804020", "0.5019607843137255, 0.25098039215686274 0.12549019607843137"] {
        let reflectance = format!("<srgb name='reflectance' value='{text}'/>");
        let shown = albedo(&old(&rectangle(&reflectance)), 0.5, 0.5);
        for (c, level) in [128.0, 64.0, 32.0].into_iter().enumerate() {
            assert_relative_eq!(shown[c], linear_from_srgb(level / 255.0), max_relative = 1e-12);
        }
    }
    let glow = |radiance: &str| {
        let emitter = format!("<emitter type='area'>{radiance}</emitter>");
        emitted_below(&old(&format!("{SENSOR}<shape type='rectangle'>{emitter}</shape>")), 0.0, 0.0)
    };
    let tag = glow("<blackbody name='radiance' temperature='5000K' scale='2'/>");
    let plug_in = glow(
        "<spectrum type='blackbody' name='radiance'><float name='temperature' value='5000'/></spectrum>",
    );
    assert!(tag.r() > tag.b() && tag.b() > 0.0, "{tag:?}");
    (0..3).for_each(|c| assert_relative_eq!(tag[c], 2.0 * plug_in[c], max_relative = 1e-12));
}

/// Settings that are hints may lack a value; what is seen may not.
#[test]
fn hints_without_a_value_are_left_out() {
    let directory = Directory::new("undefined");
    let sphere = "<shape type='sphere'/>";
    let sampler =
        "<sampler type='independent'><integer name='sample_count' value='$spp'/></sampler>";
    let sensor = format!("<sensor type='perspective'>{sampler}</sensor>");
    let path = "<integrator type='path'><integer name='max_depth' value='$depth'/></integrator>";
    let scene = format!("{path}{sensor}{sphere}");
    let import = directory.left_out(&scene, "has no value; it gets one");
    assert_eq!((import.hints.samples_per_pixel, import.hints.max_bounces), (None, None));
    assert_eq!(import.warnings.len(), 2, "{:?}", import.warnings);
    assert!(import.warnings[0].to_string().contains("-D depth=VALUE"));
    let parameters = [("spp", "7"), ("depth", "3")].map(|(a, b)| (a.to_owned(), b.to_owned()));
    let path = directory.write("set.xml", format!("<scene version='3.0.0'>{scene}</scene>"));
    let import = mitsuba::load(path, &Options::default(), parameters).expect("valid");
    assert_eq!((import.hints.samples_per_pixel, import.hints.max_bounces), (Some(7), Some(2)));
    let seen = sphere.replace("'sphere'", "'$shape'");
    let error = directory.error(&format!("{sensor}{seen}"));
    assert!(error.contains("the parameter $shape has no value"), "{error}");
}

/// Films keep their shape and their window in the size that is wished for.
#[test]
fn films_fit_into_the_size_that_is_wished_for() {
    let directory = Directory::new("size");
    let number = |name: &str, value: u32| format!("<integer name='{name}' value='{value}'/>");
    let film = [
        ("width", 400),
        ("height", 200),
        ("crop_offset_x", 100),
        ("crop_offset_y", 50),
        ("crop_width", 200),
        ("crop_height", 100),
    ]
    .map(|(name, value)| number(name, value))
    .concat();
    let scene = |film: &str| {
        let film = format!("<film type='hdrfilm'>{film}</film>");
        let fov = "<float name='fov' value='40'/>";
        format!("<sensor type='perspective'>{fov}{film}</sensor><shape type='sphere'/>")
    };
    let sized = |size: UVec2, film: &str| {
        let options = Options { size: Some(size), ..Options::default() };
        directory.load_with(&scene(film), &options)
    };
    let corner = |camera: &dyn Camera| {
        let point = camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
        camera.sample_direction(&point, DVec2::ZERO).expect("a direction").direction
    };
    let own = directory.load(&scene(&film)).expect("valid");
    for (size, expected) in [
        (UVec2::new(200, 200), UVec2::new(200, 100)),
        (UVec2::new(1000, 100), UVec2::new(200, 100)),
        (UVec2::new(800, 800), UVec2::new(800, 400)),
    ] {
        let import = sized(size, &film).expect("valid");
        let region = import.views[0].camera.film();
        assert_eq!(region.resolution, expected);
        assert_eq!((region.window_min * 4, region.window_max * 4), (expected, expected * 3));
        let (ours, theirs) = (corner(&*import.views[0].camera), corner(&*own.views[0].camera));
        assert_relative_eq!(ours, theirs, epsilon = 1e-12);
    }
    let tiny = sized(UVec2::ONE, &film).expect("valid");
    assert_eq!(tiny.views[0].camera.film().window_size(), UVec2::ONE);
    assert!(sized(UVec2::new(0, 5), "").is_err() && sized(UVec2::splat(1 << 20), "").is_err());
}
