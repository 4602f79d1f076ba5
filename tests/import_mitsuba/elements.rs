//! Parameters, references and shapes.

use crate::files::{Directory, GLOW, SENSOR, emitted_below, emitted_from, load};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3, UVec2};
use pathspace::film::Filter;
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Import, Options, mitsuba};
use pathspace::math::Rgb;
use pathspace::scene::{Scene, SurfaceArea};

#[test]
fn parameters_includes_references_and_hints() {
    let import = load("diffuse.xml");
    assert_eq!((import.hints.max_bounces, import.hints.samples_per_pixel), (Some(4), Some(16)));
    assert_eq!(
        (import.hints.integrator.as_deref(), import.hints.sampler.as_deref()),
        (Some("path"), Some("independent"))
    );
    assert_eq!((import.views[0].name.as_str(), import.views[0].filter), ("camera", Filter::Box));
    assert_eq!(import.views[0].camera.film().resolution, UVec2::splat(16));
    assert_eq!((import.world.light_count(), import.world.surface_count()), (1, 5));
    let directory = Directory::new("parameters");
    let with = |parameters: &[(&str, &str)], text: &str| {
        let path = directory.write("scene.xml", format!("<scene version='3.0.0'>{text}</scene>"));
        let set = parameters.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        mitsuba::load(path, &Options::default(), set)
    };
    let film = "<sensor type='perspective'><float name='fov' value='40'/><film type='hdrfilm'><integer name='width' value='$w0'/></film></sensor>";
    let scene = format!("<default name='w' value='3'/>{film}<shape type='sphere'>{GLOW}</shape>");
    let width = |import: Import| import.views[0].camera.film().resolution.x;
    assert_eq!(width(with(&[], &scene).expect("valid")), 30);
    assert_eq!(width(with(&[("w", "5")], &scene).expect("valid")), 50);
    assert_eq!(width(with(&[("w0", "7")], &scene).expect("valid")), 7);
    assert!(
        with(&[("v", "7")], &scene).expect("valid").warnings[0]
            .to_string()
            .contains("no file asks for the parameter v")
    );
    assert!(
        with(&[], film)
            .expect_err("missing")
            .to_string()
            .contains("the parameter $w0 has no value")
    );
}

#[test]
fn shapes_are_where_they_belong() {
    let directory = Directory::new("shapes");
    let transform = "<transform name='to_world'><scale x='2' y='1' z='1'/><rotate z='1' angle='90'/><translate x='1'/></transform>";
    let area = |shape: &str| {
        let import = directory
            .load(&format!("{SENSOR}<shape type='{shape}"))
            .unwrap_or_else(|error| panic!("{error}"));
        import.world.bounds()
    };
    let bounds = area(&format!("rectangle'>{transform}{GLOW}</shape>"));
    assert_relative_eq!(bounds.min, DVec3::new(0.0, -2.0, 0.0), epsilon = 1e-12);
    assert_relative_eq!(bounds.max, DVec3::new(2.0, 2.0, 0.0), epsilon = 1e-12);
    let bounds = area(&format!("cube'>{transform}{GLOW}</shape>"));
    assert_relative_eq!(bounds.max, DVec3::new(2.0, 2.0, 1.0), epsilon = 1e-12);
    let matrix = "<transform name='to_world'><matrix value='2 0 0 1  0 2 0 2  0 0 2 3  0 0 0 1'/></transform>";
    let bounds = area(&format!(
        "sphere'><point name='center' x='1'/><float name='radius' value='0.5'/>{matrix}{GLOW}</shape>"
    ));
    assert_relative_eq!(bounds.max, DVec3::new(4.0, 3.0, 4.0), epsilon = 1e-12);
    let bounds = area(&format!("disk'>{matrix}{GLOW}</shape>"));
    assert_relative_eq!(bounds.min, DVec3::new(-1.0, 0.0, 3.0), epsilon = 1e-12);
}

/// The front side under mirrors and flips; all of it as Mitsuba 3.9 reports its shading normals.
#[test]
fn fronts_follow_normals() {
    let directory = Directory::new("fronts");
    let mirror = "<transform name='to_world'><scale x='-1'/></transform>";
    let flip = "<boolean name='flip_normals' value='true'/>";
    let uneven = "<transform name='to_world'><scale x='1.5' y='2'/></transform>";
    let obj = "<string name='filename' value='parts/up.obj'/>";
    directory.write("parts/up.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let faces = "<boolean name='face_normals' value='true'/>";
    let cases = [
        ("rectangle", String::new(), true),
        ("rectangle", mirror.to_owned(), true),
        ("rectangle", flip.to_owned(), false),
        ("rectangle", format!("{mirror}{flip}"), false),
        ("disk", String::new(), true),
        ("disk", mirror.to_owned(), true),
        ("disk", flip.to_owned(), false),
        ("cube", mirror.to_owned(), true),
        ("cube", flip.to_owned(), false),
        ("sphere", String::new(), true),
        ("sphere", mirror.to_owned(), false),
        ("sphere", flip.to_owned(), false),
        ("obj", obj.to_owned(), true),
        ("obj", format!("{obj}{mirror}"), false),
        ("obj", format!("{obj}{mirror}{faces}"), false),
        ("obj", format!("{obj}{flip}"), false),
        ("obj", format!("{obj}{flip}{faces}"), false),
    ];
    for (kind, parameters, front) in cases {
        let import = directory
            .load(&format!("{SENSOR}<shape type='{kind}'>{parameters}{GLOW}</shape>"))
            .expect("valid");
        let expected = if front { Rgb::WHITE } else { Rgb::BLACK };
        assert_eq!(emitted_below(&import, 0.1, 0.2), expected, "{kind} {parameters}");
        // An instance has the image of the front for its front.
        for transform in ["", mirror, uneven] {
            let import = directory
                .load(&format!(
                    "{SENSOR}<shape type='shapegroup' id='a'><shape type='{kind}'>{parameters}{GLOW}</shape></shape>\
                     <shape type='instance'>{transform}<ref id='a'/></shape>"
                ))
                .expect("valid");
            let found = emitted_below(&import, 0.1, 0.2);
            assert_eq!(found, expected, "{transform} of {kind} {parameters}");
        }
    }
}

/// Points, normals and texture coordinates that Mitsuba 3.9 reports where a ray hits.
#[test]
fn curved_shapes_are_met_where_mitsuba_meets_them() {
    let directory = Directory::new("curved");
    let scale = "<transform name='to_world'><scale x='2'/></transform>";
    let slanted = "cylinder'><point name='p0' x='0.1'/><point name='p1' x='1' y='2' z='1'/><float name='radius' value='0.5'/>";
    let downwards = "cylinder'><point name='p0' x='0.1'/><point name='p1' x='1' y='-2' z='-3'/><float name='radius' value='0.5'/>";
    let upright = "cylinder'><point name='p1' z='2'/><float name='radius' value='0.5'/>";
    let flip = "<boolean name='flip_normals' value='true'/>";
    let v = DVec3::new;
    let cases = [
        (
            slanted.to_owned(),
            v(3.0, 1.0, 0.4),
            -DVec3::X,
            v(1.06229, 1.0, 0.4),
            v(0.91271, -0.24858, -0.32429),
            (0.9907, 0.56214),
        ),
        (
            downwards.to_owned(),
            v(3.0, -1.0, -1.4),
            -DVec3::X,
            v(1.04139, -1.0, -1.4),
            v(0.96424, 0.0412, 0.2618),
            (0.00585, 0.5103),
        ),
        (
            format!("{upright}{scale}"),
            v(0.2, -3.0, 0.5),
            DVec3::Y,
            v(0.2, -0.4899, 0.5),
            v(0.10153, -0.99483, 0.0),
            (0.78205, 0.25),
        ),
        (
            format!("{upright}{scale}{flip}"),
            v(0.2, -3.0, 0.5),
            DVec3::Y,
            v(0.2, -0.4899, 0.5),
            v(-0.10153, 0.99483, 0.0),
            (0.78205, 0.25),
        ),
        (
            format!("disk'>{scale}"),
            v(1.5, 0.1, 5.0),
            -DVec3::Z,
            v(1.5, 0.1, 0.0),
            DVec3::Z,
            (0.75664, 0.0211),
        ),
        (
            format!(
                "shapegroup' id='a'><shape type='sphere'/></shape><shape type='instance'><ref id='a'/>{scale}"
            ),
            v(0.3, 0.1, 5.0),
            v(0.01, 0.0, -1.0),
            v(0.3402, 0.1, 0.9803),
            v(0.086, 0.1011, 0.9912),
            (0.0846, 0.0632),
        ),
    ];
    for (shape, from, direction, position, normal, uv) in cases {
        let import = directory
            .load(&format!("{SENSOR}<shape type='{shape}</shape>"))
            .unwrap_or_else(|error| panic!("{error}"));
        let hit = import.world.intersect(&SurfacePoint::dirac(from), direction.normalize());
        let hit = hit.expect("a hit");
        assert_relative_eq!(hit.position, position, epsilon = 3e-4);
        assert_relative_eq!(hit.shading_normal, normal, epsilon = 3e-4);
        // Between rim and centre angles are those of one of 256 sectors' sides in part.
        assert_relative_eq!(hit.uv, DVec2::new(uv.0, uv.1), epsilon = 0.25 / 256.0);
    }
}

#[test]
fn all_mesh_formats_hold_the_same_mesh() {
    let directory = Directory::new("meshes");
    for shape in [
        "obj'><string name='filename' value='parts/tetrahedron.obj'/>",
        "ply'><string name='filename' value='parts/tetrahedron.ply'/>",
        "ply'><string name='filename' value='parts/binary.ply'/>",
        "serialized'><string name='filename' value='parts/two.serialized'/><integer name='shape_index' value='1'/>",
        "serialized'><string name='filename' value='parts/two.serialized'/><transform name='to_world'><scale value='2'/></transform>",
    ] {
        let import = directory
            .load(&format!("{SENSOR}<shape type='{shape}{GLOW}</shape>"))
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(import.world.primitive_count(), 4, "{shape}");
        let bounds = import.world.bounds();
        assert_relative_eq!(bounds.min, DVec3::new(-0.4, -0.5, 0.0), epsilon = 1e-7);
        assert_relative_eq!(bounds.max, DVec3::new(0.5, 0.5, 0.9), epsilon = 1e-7);
        assert!(!import.world.sample_surface(0.3, DVec2::splat(0.4)).is_flat());
        assert_eq!(emitted_below(&import, 0.1, 0.02), Rgb::WHITE, "{shape}");
    }
    let missing = "<shape type='serialized'><string name='filename' value='parts/two.serialized'/><integer name='shape_index' value='2'/></shape>";
    let other = "<shape type='sphere'/>";
    directory.left_out(&format!("{SENSOR}{other}{missing}"), "there is no shape 2; there are 2");
}

/// A scene of each version, with the names that it has there.
#[test]
fn older_versions_are_read() {
    let directory = Directory::new("versions");
    let options = Options { strict: true, ..Options::default() };
    let load = |name: &str, version: &str, text: &str| {
        let text = format!("<scene version='{version}'>{text}</scene>");
        mitsuba::load(directory.write(name, text), &options, [])
            .unwrap_or_else(|error| panic!("{error}"))
    };
    let old = "<integrator type='path'><integer name='maxDepth' value='3'/></integrator>\
         <sensor type='perspective'><float name='fov' value='60'/><string name='fovAxis' value='y'/>\
         <transform name='toWorld'><lookAt origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/></transform>\
         <sampler type='independent'><integer name='sampleCount' value='7'/></sampler>\
         <film type='hdrfilm'><integer name='width' value='40'/><integer name='height' value='20'/>\
         <integer name='cropOffsetX' value='8'/></film></sensor>\
         <shape type='sphere'><transform name='toWorld'><scale value='2'/></transform>\
         <boolean name='flipNormals' value='true'/><bsdf type='dielectric'><float name='intIOR' value='1.3'/>\
         <float name='extIOR' value='1'/></bsdf></shape>\
         <shape type='rectangle'><emitter type='area'><texture type='checkerboard' name='radiance'>\
         <float name='uscale' value='2'/><float name='uoffset' value='0.25'/>\
         <rgb name='color0' value='1'/><rgb name='color1' value='3'/></texture></emitter></shape>";
    let new = old
        .replace("maxDepth", "max_depth")
        .replace("fovAxis", "fov_axis")
        .replace("toWorld", "to_world")
        .replace("lookAt", "lookat")
        .replace("sampleCount", "sample_count")
        .replace("cropOffsetX", "crop_offset_x")
        .replace("flipNormals", "flip_normals")
        .replace("intIOR", "int_ior")
        .replace("extIOR", "ext_ior")
        .replace(
            "<float name='uscale' value='2'/><float name='uoffset' value='0.25'/>",
            "<transform name='to_uv'><scale x='2'/><translate x='0.25'/></transform>",
        );
    let directions = |import: &Import| {
        let camera = &import.views[0].camera;
        let point = camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
        camera.sample_direction(&point, DVec2::ZERO).expect("a direction").direction
    };
    let expected = load("new.xml", "3.0.0", &new);
    directory.write("parts/old.xml", format!("<scene version='0.5.0'>{old}</scene>"));
    let include = "<include filename='parts/old.xml'/>";
    for (version, text) in [
        ("0.4.0", old),
        ("0.6.0", old),
        ("0.6.0", &new),
        ("1.0", old),
        ("2.0.0", &new),
        ("2.1.0", &new),
        ("3.0.0", include),
        ("0.6.0", include),
    ] {
        let import = load("scene.xml", version, text);
        assert_eq!(import.hints, expected.hints, "{version}");
        assert_eq!(import.world.bounds(), expected.world.bounds(), "{version}");
        assert_eq!(directions(&import), directions(&expected), "{version}");
        let film = import.views[0].camera.film();
        assert_eq!(film, expected.views[0].camera.film(), "{version}");
        for i in 0..8 {
            let (x, y) = (-0.9 + 0.25 * f64::from(i), 0.3);
            let [found, expected] = [&import, &expected]
                .map(|import| emitted_from(&import.world, DVec3::new(x, y, 1.0)));
            assert_eq!(found, expected, "{version} {x}");
        }
    }
}

#[test]
fn booleans_may_have_capitals() {
    let directory = Directory::new("booleans");
    for (value, seen) in
        [("true", 0.0), ("True", 0.0), (" TRUE ", 0.0), ("false", 1.0), ("False", 1.0)]
    {
        let flip = format!("<boolean name='flip_normals' value='{value}'/>");
        let import = directory
            .load(&format!("{SENSOR}<shape type='rectangle'>{flip}{GLOW}</shape>"))
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(emitted_below(&import, 0.1, 0.2), Rgb::splat(seen), "{value}");
    }
}

/// A triangle with each flag of precision, both, and none, which means single.
#[test]
fn serialized_meshes_need_no_flag_of_precision() {
    let directory = Directory::new("precision");
    let corners = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.5, 0.25];
    for flags in [0u32, 0x1000, 0x2000, 0x3000] {
        let mut mesh = flags.to_le_bytes().to_vec();
        mesh.push(0);
        [3u64, 1].iter().for_each(|count| mesh.extend(count.to_le_bytes()));
        for corner in corners {
            if flags & 0x2000 != 0 {
                mesh.extend(f64::to_le_bytes(corner));
            } else {
                mesh.extend((corner as f32).to_le_bytes());
            }
        }
        (0..3u32).for_each(|index| mesh.extend(index.to_le_bytes()));
        let mut file = b"\x1c\x04\x04\x00".to_vec();
        file.extend(stored(&mesh));
        file.extend(0u64.to_le_bytes());
        file.extend(1u32.to_le_bytes());
        directory.write("parts/one.serialized", file);
        let shape = "<shape type='serialized'><string name='filename' value='parts/one.serialized'/></shape>";
        let import = directory.load(&format!("{SENSOR}{shape}")).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(import.warnings, []);
        assert_eq!(import.world.primitive_count(), 1, "{flags:x}");
        let bounds = import.world.bounds();
        assert_eq!(bounds.min, DVec3::new(-1.0, -1.0, 0.0), "{flags:x}");
        assert_eq!(bounds.max, DVec3::new(1.0, 1.5, 0.25), "{flags:x}");
    }
}

/// A zlib stream of one block that is not compressed (RFC 1950 and 1951).
fn stored(bytes: &[u8]) -> Vec<u8> {
    let length = u16::try_from(bytes.len()).expect("short");
    let mut stream = vec![0x78, 0x01, 0x01];
    stream.extend(length.to_le_bytes());
    stream.extend((!length).to_le_bytes());
    stream.extend(bytes);
    let (a, b) = bytes.iter().fold((1u32, 0u32), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65521;
        (a, (a + b) % 65521)
    });
    stream.extend((b << 16 | a).to_be_bytes());
    stream
}
