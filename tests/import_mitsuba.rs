//! Scenes of Mitsuba 3: what each feature becomes, what is refused, and what hostile files do.

#![cfg(feature = "mitsuba")]

#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;

use approx::assert_relative_eq;
use compare::{Comparison, assert_agree};
use glam::{DVec2, DVec3, UVec2};
use pathspace::film::Filter;
use pathspace::geometry::SurfacePoint;
use pathspace::import::{Error, Import, Options, mitsuba};
use pathspace::integrator::{Bidirectional, Depth, PathTracer};
use pathspace::math::Rgb;
use pathspace::render::{Budget, Render, Settings, unattended};
use pathspace::scene::{Needs, Scene};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/mitsuba");

/// A directory that goes away with its owner, with a copy of the data's parts.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("pathspace-{}-{name}", std::process::id()));
        std::fs::create_dir_all(path.join("parts")).expect("a temporary directory");
        for entry in std::fs::read_dir(Path::new(DATA).join("parts")).expect("test data").flatten() {
            std::fs::copy(entry.path(), path.join("parts").join(entry.file_name())).expect("a copy");
        }
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).expect("a temporary file");
        path
    }

    /// Loads a scene of these elements.
    fn load(&self, elements: &str) -> Result<Import, Error> {
        self.load_with(elements, &Options::default())
    }

    fn load_with(&self, elements: &str, options: &Options) -> Result<Import, Error> {
        let text = format!("<scene version=\"3.0.0\">\n{elements}\n</scene>");
        mitsuba::load(self.write("scene.xml", text), options, [])
    }

    /// The message of the error that a scene gives.
    fn error(&self, elements: &str) -> String {
        self.load(elements).expect_err(elements).to_string()
    }

    /// The only warning of a scene, which is an error in strict mode.
    fn warning(&self, elements: &str) -> String {
        let import = self.load(elements).expect(elements);
        assert_eq!(import.warnings.len(), 1, "{elements}: {:?}", import.warnings);
        let warning = import.warnings[0].to_string();
        let strict = self.load_with(elements, &Options { strict: true, ..Options::default() });
        assert_eq!(strict.expect_err(elements).to_string(), warning);
        warning
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn load(name: &str) -> Import {
    let options = Options { strict: true, ..Options::default() };
    mitsuba::load(
        Path::new(DATA).join(name),
        &options,
        [("res".to_owned(), "16".to_owned())]
            .into_iter()
            .take(usize::from(!["thinlens.xml", "orthographic.xml", "shifted.xml"].contains(&name))),
    )
    .unwrap_or_else(|error| panic!("{error}"))
}

/// The radiance that a ray from above meets on a surface of the scene, as the camera of the first view would see it without light from elsewhere.
fn emitted_below(import: &Import, x: f64, y: f64) -> Rgb {
    let world = &import.world;
    let hit = world.intersect(&SurfacePoint::dirac(DVec3::new(x, y, 10.0)), -DVec3::Z).expect("a surface");
    world.light_at(&hit).map_or(Rgb::BLACK, |light| world.light(light).emit(&hit, DVec3::Z))
}

const SENSOR: &str = "<sensor type='perspective'><float name='fov' value='40'/></sensor>";
/// An emitting square of radiance 1 at z = 0, seen from above.
const GLOW: &str = "<emitter type='area'><rgb name='radiance' value='1'/></emitter>";

#[test]
fn every_file_renders_and_its_integrators_agree() {
    for entry in std::fs::read_dir(DATA).expect("test data").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !name.ends_with(".xml") {
            continue;
        }
        let import = load(&name);
        let settings = Settings { budget: Budget::Samples(8), ..Settings::default() };
        let depth = Depth::up_to(import.hints.max_bounces.expect("every file says"));
        let path = PathTracer { depth, ..PathTracer::default() };
        let rendering = Render::render(&path, &import.world, &*import.views[0].camera, &settings, &mut unattended).expect("valid");
        assert!(rendering.image.mean().0.iter().all(|c| *c > 1e-3), "{name} is dark: {:?}", rendering.image.mean());
        assert_eq!(rendering.counters.non_finite, 0, "{name}");
    }
    // One scene for each new model, with a light that both can see.
    for name in ["plastic.xml", "mixtures.xml", "textures.xml", "roughconductor.xml", "roughdielectric.xml"] {
        let import = load(name);
        let depth = Depth::up_to(3);
        let (path, both) = (PathTracer { depth, ..PathTracer::default() }, Bidirectional { depth, ..Bidirectional::default() });
        let members: [(&str, &dyn Render<_>); 2] = [("path", &path), ("bidirectional", &both)];
        let comparison = Comparison { target: 0.006, most: 512, blocks: false, ..Comparison::default() };
        assert_agree(name, &import.world, &*import.views[0].camera, &members, &comparison);
    }
}

#[test]
fn parameters_includes_references_and_hints() {
    let import = load("diffuse.xml");
    assert_eq!((import.hints.max_bounces, import.hints.samples_per_pixel), (Some(4), Some(16)));
    assert_eq!((import.hints.integrator.as_deref(), import.hints.sampler.as_deref()), (Some("path"), Some("independent")));
    assert_eq!((import.views[0].name.as_str(), import.views[0].filter), ("camera", Filter::Box));
    assert_eq!(import.views[0].camera.film().resolution, UVec2::splat(16));
    assert_eq!((import.world.light_count(), import.world.surface_count()), (1, 5));
    let directory = Directory::new("parameters");
    let with = |parameters: &[(&str, &str)], text: &str| {
        let path = directory.write("scene.xml", format!("<scene version='3.0.0'>{text}</scene>"));
        let set = parameters.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        mitsuba::load(path, &Options::default(), set)
    };
    let film =
        "<sensor type='perspective'><float name='fov' value='40'/><film type='hdrfilm'><integer name='width' value='$w0'/></film></sensor>";
    let scene = format!("<default name='w' value='3'/>{film}<shape type='sphere'>{GLOW}</shape>");
    let width = |import: Import| import.views[0].camera.film().resolution.x;
    assert_eq!(width(with(&[], &scene).expect("valid")), 30);
    assert_eq!(width(with(&[("w", "5")], &scene).expect("valid")), 50);
    assert_eq!(width(with(&[("w0", "7")], &scene).expect("valid")), 7);
    assert!(with(&[("v", "7")], &scene).expect("valid").warnings[0].to_string().contains("no file asks for the parameter v"));
    assert!(with(&[], film).expect_err("missing").to_string().contains("the parameter $w0 has no value"));
}

#[test]
fn shapes_are_where_they_belong() {
    let directory = Directory::new("shapes");
    let transform = "<transform name='to_world'><scale x='2' y='1' z='1'/><rotate z='1' angle='90'/><translate x='1'/></transform>";
    let area = |shape: &str| {
        let import = directory.load(&format!("{SENSOR}<shape type='{shape}")).unwrap_or_else(|error| panic!("{error}"));
        import.world.bounds()
    };
    let bounds = area(&format!("rectangle'>{transform}{GLOW}</shape>"));
    assert_relative_eq!(bounds.min, DVec3::new(0.0, -2.0, 0.0), epsilon = 1e-12);
    assert_relative_eq!(bounds.max, DVec3::new(2.0, 2.0, 0.0), epsilon = 1e-12);
    let bounds = area(&format!("cube'>{transform}{GLOW}</shape>"));
    assert_relative_eq!(bounds.max, DVec3::new(2.0, 2.0, 1.0), epsilon = 1e-12);
    let matrix = "<transform name='to_world'><matrix value='2 0 0 1  0 2 0 2  0 0 2 3  0 0 0 1'/></transform>";
    let bounds = area(&format!("sphere'><point name='center' x='1'/><float name='radius' value='0.5'/>{matrix}{GLOW}</shape>"));
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
        let import = directory.load(&format!("{SENSOR}<shape type='{kind}'>{parameters}{GLOW}</shape>")).expect("valid");
        let expected = if front { Rgb::WHITE } else { Rgb::BLACK };
        assert_eq!(emitted_below(&import, 0.1, 0.2), expected, "{kind} {parameters}");
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
        let import = directory.load(&format!("{SENSOR}<shape type='{shape}{GLOW}</shape>")).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(import.world.primitive_count(), 4, "{shape}");
        let bounds = import.world.bounds();
        assert_relative_eq!(bounds.min, DVec3::new(-0.4, -0.5, 0.0), epsilon = 1e-7);
        assert_relative_eq!(bounds.max, DVec3::new(0.5, 0.5, 0.9), epsilon = 1e-7);
        assert!(import.world.needs().contains(Needs::SMOOTH_NORMALS));
        assert_eq!(emitted_below(&import, 0.1, 0.02), Rgb::WHITE, "{shape}");
    }
    let missing =
        "<shape type='serialized'><string name='filename' value='parts/two.serialized'/><integer name='shape_index' value='2'/></shape>";
    assert!(directory.error(missing).contains("there is no shape 2; there are 2"));
}

/// Values of Mitsuba 3.9, whose quadrature and tables differ by up to 0.12 %: lists are interpolated, cut off at their ends, and seen under D65 unless they are emitted.
#[test]
fn spectra_become_what_the_observer_sees() {
    let directory = Directory::new("spectra");
    let emitted = |value: &str| {
        let glow = format!("<emitter type='area'><spectrum name='radiance' value='{value}'/></emitter>");
        emitted_below(&directory.load(&format!("{SENSOR}<shape type='rectangle'>{glow}</shape>")).expect("valid"), 0.0, 0.0)
    };
    let near = |a: Rgb, b: [f64; 3]| (0..3).for_each(|i| assert_relative_eq!(a[i], b[i], max_relative = 2e-3));
    near(emitted("0.5"), [0.602_397, 0.474_146, 0.454_458]);
    near(emitted("400:0.78, 500:0.78, 600:0.78, 700:0.78"), [0.935_761, 0.740_626, 0.704_686]);
    near(emitted("400:0, 500:8, 600:15.6, 700:18.4"), [20.7108, 10.8546, 2.771_15]);
    let reflected = |value: &str| {
        let bsdf = format!("<bsdf type='twosided'><bsdf type='diffuse'><spectrum name='reflectance' value='{value}'/></bsdf></bsdf>");
        let import = directory.load(&format!("{SENSOR}<shape type='rectangle'>{bsdf}</shape>")).expect("valid");
        let x = SurfacePoint::dirac(DVec3::Z);
        let hit = import.world.intersect(&x, -DVec3::Z).expect("the rectangle");
        use pathspace::bsdf::Bsdf;
        import.world.bsdf(&hit).eval(DVec3::Z, DVec3::Z) * std::f64::consts::PI
    };
    near(reflected("0.3"), [0.3; 3]);
    near(reflected("400:0.78, 500:0.78, 600:0.78, 700:0.78"), [0.776_367, 0.779_81, 0.776_029]);
    near(reflected("400:0.2,700:0.8"), [0.681_557, 0.485_825, 0.280_607]);
}

#[test]
fn cameras_look_where_they_should() {
    // Directions of the upper left corner, measured with Mitsuba 3.9: (x to the left, y up, z forward).
    let directory = Directory::new("cameras");
    let corner = |parameters: &str, kind: &str| {
        let film = "<film type='hdrfilm'><integer name='width' value='100'/><integer name='height' value='50'/></film>";
        let text = format!("<sensor type='{kind}'>{parameters}{film}</sensor><shape type='sphere'>{GLOW}</shape>");
        let import = directory.load(&text).unwrap_or_else(|error| panic!("{error}"));
        let camera = &import.views[0].camera;
        let point = camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
        let sample = camera.sample_direction(&point, DVec2::ZERO).expect("a direction");
        (sample.from.position, sample.direction / sample.direction.z)
    };
    let offset = "<float name='principal_point_offset_x' value='0.1'/><float name='principal_point_offset_y' value='0.2'/>";
    let cases = [
        (format!("<float name='fov' value='90'/>{offset}"), DVec3::new(0.8, 0.3, 1.0)),
        ("<float name='fov' value='60'/>".to_owned(), DVec3::new(0.57735, 0.288675, 1.0)),
        ("<float name='fov' value='60'/><string name='fov_axis' value='y'/>".to_owned(), DVec3::new(1.1547, 0.57735, 1.0)),
        ("<float name='fov' value='60'/><string name='fov_axis' value='diagonal'/>".to_owned(), DVec3::new(0.516398, 0.258199, 1.0)),
        ("<float name='fov' value='60'/><string name='fov_axis' value='smaller'/>".to_owned(), DVec3::new(1.1547, 0.57735, 1.0)),
        ("<float name='fov' value='60'/><string name='fov_axis' value='larger'/>".to_owned(), DVec3::new(0.57735, 0.288675, 1.0)),
        ("<string name='focal_length' value='50mm'/>".to_owned(), DVec3::new(0.386988, 0.193494, 1.0)),
        (String::new(), DVec3::new(0.386988, 0.193494, 1.0)),
    ];
    for (parameters, expected) in cases {
        assert_relative_eq!(corner(&parameters, "perspective").1, expected, epsilon = 2e-6);
    }
    let scaled = "<transform name='to_world'><scale x='10' y='10'/></transform>";
    let (position, direction) = corner(scaled, "orthographic");
    assert_relative_eq!(position.truncate(), DVec2::new(10.0, 5.0), epsilon = 1e-12);
    assert_eq!(direction, DVec3::Z);
    let crop = load("shifted.xml").views[0].camera.film();
    assert_eq!((crop.window_min, crop.window_max), (UVec2::new(8, 4), UVec2::new(40, 28)));
}

#[test]
fn what_is_not_supported_is_said() {
    let directory = Directory::new("warnings");
    let warning = |elements: &str| directory.warning(&format!("{SENSOR}\n<shape type='sphere'>{GLOW}</shape>\n{elements}"));
    let cases = [
        ("<shape type='cylinder' id='pipe'/>", "scene.xml:4: shape of type cylinder \"pipe\": shapes of type cylinder are not supported"),
        ("<shape type='cube'><bsdf type='principled' id='x'/></shape>", "bsdf of type principled \"x\""),
        (
            "<shape type='cube'><bsdf type='conductor'><string name='material' value='Unobtainium'/></bsdf></shape>",
            "the metal Unobtainium is not known",
        ),
        (
            "<shape type='cube'><bsdf type='diffuse'><float name='sheen' value='1'/></bsdf></shape>",
            "the parameter sheen (line 4) is not supported",
        ),
        ("<shape type='disk'><transform name='to_world'><scale x='2'/></transform></shape>", "not scaled uniformly"),
        ("<emitter type='projector'/>", "emitters of type projector are not supported"),
        ("<emitter type='area'/>", "belongs to no shape"),
        ("<medium type='homogeneous'/>", "participating media"),
        ("<integrator type='path'><boolean name='hide_emitters' value='true'/></integrator>", "hide_emitters"),
        ("<shape type='cube'><bsdf type='dielectric'><float name='specular_transmittance' value='0.5'/></bsdf></shape>", "differ"),
        (
            "<sensor type='perspective'><film type='hdrfilm'><rfilter type='mitchell'/></film></sensor>",
            "the reconstruction filter mitchell",
        ),
        ("<sensor type='perspective'><float name='far_clip' value='0.5'/></sensor>", "near_clip or far_clip"),
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
    let old = directory.write("old.xml", "<scene version='0.6.0'/>");
    assert!(mitsuba::load(old, &Options::default(), []).expect_err("old").to_string().contains("version"));
}

#[test]
fn hostile_files_are_refused_quickly() {
    let directory = Directory::new("hostile");
    let laughs = "<!DOCTYPE lolz [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;\">]>\n<scene version='3.0.0'>&b;</scene>";
    assert!(mitsuba::load(directory.write("laughs.xml", laughs), &Options::default(), []).is_err());
    let mut limited = Options::default();
    limited.limits.expansion = 1000;
    let mut doubling = String::from("<default name='p0' value='xxxxxxxx'/>");
    (1..60).for_each(|i| doubling += &format!("<default name='p{i}' value='$p{0}$p{0}'/>", i - 1));
    assert!(directory.load_with(&doubling, &limited).expect_err("too long").to_string().contains("expand"));
    assert!(directory.error(&doubling).contains("expand"));
    let deep = format!("{}{}", "<bsdf type='twosided'>".repeat(5000), "</bsdf>".repeat(5000));
    assert!(directory.error(&deep).contains("nested too deeply"));
    limited = Options::default();
    limited.limits.elements = 100;
    assert!(directory.load_with(&"<bsdf type='null'/>".repeat(101), &limited).is_err());
    // Each file includes the next one twice.
    for i in 0..14 {
        let next = format!("<include filename='parts/{}.xml'/>", i + 1).repeat(2);
        directory.write(&format!("parts/{i}.xml"), format!("<scene version='3.0.0'>{next}</scene>"));
    }
    directory.write("parts/14.xml", "<scene version='3.0.0'/>");
    limited.limits.elements = 1000;
    assert!(directory.load_with("<include filename='parts/0.xml'/>", &limited).expect_err("too many").to_string().contains("elements"));
    for header in ["element vertex 99999999999999", "element nothing 18446744073709551615\nelement vertex 1"] {
        let text = format!(
            "ply\nformat binary_little_endian 1.0\n{header}\nproperty float x\nproperty float y\nproperty float z\nend_header\nxxxxxxxxxxxx"
        );
        directory.write("parts/bomb.ply", text);
        let error = directory.error("<shape type='ply'><string name='filename' value='parts/bomb.ply'/></shape>");
        assert!(error.contains("bomb.ply"), "{error}");
    }
    #[cfg(unix)]
    {
        let _ = std::os::unix::fs::symlink("/etc/hostname", directory.0.join("parts/link.obj"));
        assert!(directory.error("<shape type='obj'><string name='filename' value='parts/link.obj'/></shape>").contains("link"));
    }
}

/// Changes some bytes, and cuts off or repeats the end.
fn mutated(original: &[u8], changes: &[(u32, u8)], cut: u32) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for (at, value) in changes {
        let index = *at as usize % bytes.len();
        bytes[index] = *value;
    }
    if cut % 3 == 0 {
        bytes.truncate(cut as usize % (bytes.len() + 1));
    }
    bytes
}

fn small_limits() -> Options {
    let mut options = Options::default();
    options.limits.bytes = 1 << 20;
    options.limits.triangles = 10_000;
    options.limits.pixels = 1 << 16;
    options.limits.elements = 1000;
    options
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_never_panic(changes in prop::collection::vec((any::<u32>(), any::<u8>()), 0..6), cut in any::<u32>(), which in 0usize..10) {
        let directory = Directory::new(&format!("fuzz-{which}"));
        let xml = ["diffuse.xml", "textures.xml", "mixtures.xml", "meshes.xml"];
        let parts = ["tetrahedron.obj", "tetrahedron.ply", "binary.ply", "two.serialized", "colours.png", "sky.exr"];
        let mut scene = "textures.xml";
        if let Some(name) = xml.get(which) {
            scene = name;
        } else {
            let name = parts[which - xml.len()];
            let original = std::fs::read(Path::new(DATA).join("parts").join(name)).expect("test data");
            directory.write(&format!("parts/{name}"), mutated(&original, &changes, cut));
            if which < xml.len() + 4 {
                scene = "meshes.xml";
            }
        }
        let text = std::fs::read(Path::new(DATA).join(scene)).expect("test data");
        let text = if which < xml.len() { mutated(&text, &changes, cut) } else { text };
        let path = directory.write("scene.xml", text);
        if let Err(error) = mitsuba::load(path, &small_limits(), [("res".to_owned(), "8".to_owned())]) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
