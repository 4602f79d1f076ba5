//! The views of cameras.

use crate::files::{Directory, GLOW, load};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3, UVec2};

#[test]
fn cameras_look_where_they_should() {
    // Directions of the upper left corner, measured with Mitsuba 3.9: (x to the left, y up, z
    // forward).
    let directory = Directory::new("cameras");
    let corner = |parameters: &str, kind: &str| {
        let film = "<film type='hdrfilm'><integer name='width' value='100'/><integer name='height' value='50'/></film>";
        let text = format!(
            "<sensor type='{kind}'>{parameters}{film}</sensor><shape type='sphere'>{GLOW}</shape>"
        );
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
        (
            "<float name='fov' value='60'/><string name='fov_axis' value='y'/>".to_owned(),
            DVec3::new(1.1547, 0.57735, 1.0),
        ),
        (
            "<float name='fov' value='60'/><string name='fov_axis' value='diagonal'/>".to_owned(),
            DVec3::new(0.516398, 0.258199, 1.0),
        ),
        (
            "<float name='fov' value='60'/><string name='fov_axis' value='smaller'/>".to_owned(),
            DVec3::new(1.1547, 0.57735, 1.0),
        ),
        (
            "<float name='fov' value='60'/><string name='fov_axis' value='larger'/>".to_owned(),
            DVec3::new(0.57735, 0.288675, 1.0),
        ),
        (
            "<string name='focal_length' value='50mm'/>".to_owned(),
            DVec3::new(0.386988, 0.193494, 1.0),
        ),
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

/// Rays from all over a thin lens meet at the distance of focus, which is that of the far plane
/// (10⁴ if it is not given) where there is none. A lens without extent is a pinhole.
#[test]
fn lenses_focus_where_they_should() {
    let directory = Directory::new("lenses");
    let load = |parameters: &str| {
        let text = format!(
            "<sensor type='thinlens'><float name='fov' value='40'/>{parameters}</sensor>\
             <shape type='sphere'>{GLOW}</shape>"
        );
        directory.load(&text).unwrap_or_else(|error| panic!("{error}"))
    };
    let float = |name: &str, value: f64| format!("<float name='{name}' value='{value}'/>");
    let radius = float("aperture_radius", 0.1);
    for (parameters, focus) in [
        (float("focus_distance", 5.0), 5.0),
        (float("focus_distance", 5.0) + &float("far_clip", 50.0), 5.0),
        (float("far_clip", 50.0), 50.0),
        (String::new(), 1e4),
    ] {
        let import = load(&format!("{radius}{parameters}"));
        assert_eq!(import.warnings, [], "{parameters}");
        let camera = &import.views[0].camera;
        let at = |u: f64| {
            let point = camera.sample_point(0.5, DVec2::new(u, 0.3)).expect("a point").point;
            let ray = camera.sample_direction(&point, DVec2::new(0.2, 0.9)).expect("a direction");
            let direction = ray.direction / ray.direction.z;
            (ray.from.position, ray.from.position + direction * (focus - ray.from.position.z))
        };
        let [(from, first), (other, second)] = [0.1, 0.8].map(at);
        assert!(from.distance(other) > 0.01);
        assert_relative_eq!(first, second, epsilon = 1e-9 * focus);
    }
    for (parameters, warnings) in [(float("aperture_radius", 0.0), 0), (String::new(), 1)] {
        let import = load(&parameters);
        assert_eq!(import.warnings.len(), warnings, "{:?}", import.warnings);
        assert!(import.views[0].camera.as_pinhole().is_some());
    }
}

/// A mirroring transform of a sensor exchanges left and right of its image, for every ray that it
/// sends and wherever a point is seen.
#[test]
fn mirrored_sensors_have_mirrored_images() {
    let directory = Directory::new("mirrored");
    let load = |kind: &str, parameters: &str, mirror: &str| {
        let film = "<film type='hdrfilm'><integer name='width' value='40'/>\
             <integer name='height' value='20'/></film>";
        let place = format!(
            "<transform name='to_world'>{mirror}<lookat origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/></transform>"
        );
        let text = format!(
            "<sensor type='{kind}'>{parameters}{place}{film}</sensor><shape type='sphere'>{GLOW}</shape>"
        );
        directory.load(&text).unwrap_or_else(|error| panic!("{error}")).views.remove(0).camera
    };
    let offset = "<float name='principal_point_offset_x' value='0.1'/>";
    let aperture =
        "<float name='aperture_radius' value='0.1'/><float name='focus_distance' value='3'/>";
    for (kind, parameters) in
        [("perspective", offset), ("thinlens", aperture), ("orthographic", "")]
    {
        let (plain, mirrored, upside_down) = (
            load(kind, parameters, ""),
            load(kind, parameters, "<scale x='-1'/>"),
            load(kind, parameters, "<scale y='-1'/>"),
        );
        let mirror = DVec3::new(-1.0, 1.0, 1.0);
        for u in [DVec2::new(0.1, 0.3), DVec2::new(0.9, 0.6)] {
            let [a, b, c] = [&plain, &mirrored, &upside_down].map(|camera| {
                let point = camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
                camera.sample_direction(&point, u).expect("a direction")
            });
            assert_relative_eq!(a.direction * mirror, b.direction, epsilon = 1e-12);
            assert_relative_eq!(a.from.position * mirror, b.from.position, epsilon = 1e-12);
            assert_relative_eq!(
                a.direction * DVec3::new(1.0, -1.0, 1.0),
                c.direction,
                epsilon = 1e-12
            );
            assert_relative_eq!(a.pdf.value(), b.pdf.value(), max_relative = 1e-12);
            // The pixel at which the direction is drawn is that at which it is seen.
            let raster = mirrored.raster(&b.from, b.direction).expect("in front");
            assert_relative_eq!(raster, u * DVec2::new(40.0, 20.0), epsilon = 1e-9);
        }
    }
    // The camera looks along -z: what is at +x is on the left of a mirrored image.
    let camera = load("perspective", "", "<scale x='-1'/>");
    let eye = camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
    let seen = camera.raster(&eye, DVec3::new(0.1, 0.0, -1.0).normalize()).expect("in front");
    assert!(seen.x < 20.0, "{seen}");
}

/// A sensor that is unknown or has values out of range is approximated, so that its scene has one.
#[test]
fn odd_sensors_are_replaced() {
    let directory = Directory::new("odd");
    let corner = |sensor: &str, expected: &str| {
        let film = "<film type='hdrfilm'><integer name='width' value='100'/>\
             <integer name='height' value='50'/></film>";
        let text = format!("{}{film}</sensor><shape type='sphere'>{GLOW}</shape>", sensor);
        let import = directory.left_out(&text, expected);
        let camera = &import.views[0].camera;
        let point = camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
        let sample = camera.sample_direction(&point, DVec2::ZERO).expect("a direction");
        (sample.from.position, sample.direction / sample.direction.z)
    };
    // That of a lens of 50 mm.
    let direction = DVec3::new(0.386988, 0.193494, 1.0);
    for (sensor, expected) in [
        ("<sensor type='fisheye'>", "sensors of type fisheye are not supported"),
        ("<sensor type='perspective'><float name='fov' value='180'/>", "fov is 180"),
        ("<sensor type='perspective'><float name='fov' value='x'/>", "is not a finite number"),
        ("<sensor type='thinlens'>", "aperture_radius is missing"),
        ("<sensor type='thinlens'><float name='aperture_radius' value='-1'/>", "or negative"),
    ] {
        assert_relative_eq!(corner(sensor, expected).1, direction, epsilon = 2e-6);
    }
    let scaled = "<transform name='to_world'><scale x='10' y='4'/></transform>";
    let (position, _) = corner(&format!("<sensor type='orthographic'>{scaled}"), "are square here");
    assert_relative_eq!(position.truncate(), DVec2::new(10.0, 5.0), epsilon = 1e-12);
    let sheared = "<transform name='to_world'><matrix value='1 0.5 0  0 1 0  0 0 1'/></transform>";
    let sensor = format!("<sensor type='perspective'>{sheared}");
    let up = DVec3::new(0.5, 1.0, 0.0).normalize();
    let turned = DVec3::Z + 0.386988 * up.cross(DVec3::Z) + 0.193494 * up;
    assert_relative_eq!(corner(&sensor, "must not shear").1, turned, epsilon = 2e-6);
}
