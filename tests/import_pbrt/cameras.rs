//! Cameras, films, filters and what else precedes the world.

use crate::files::{DATA, Directory, raster, render};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3, UVec2};
use pathspace::film::Filter;
use pathspace::import::{Import, Options, pbrt};
use pathspace::math::Rgb;
use std::path::Path;

const BALL: &str = "WorldBegin\nShape \"sphere\"";

fn film(x: u32, y: u32) -> String {
    format!("Film \"rgb\" \"integer xresolution\" {x} \"integer yresolution\" {y}\n")
}

/// The window of pbrt's camera goes from -1 to 1 along the shorter side, which has the angle fov;
/// its space has x to the right and y up, and looks along z.
#[test]
fn cameras_look_where_they_should() {
    let directory = Directory::new("cameras");
    let at = |text: &str, target: DVec3| {
        let import = directory.load(&format!("{text}\n{BALL}"));
        raster(&*import.views[0].camera, target)
    };
    let tangent = 30f64.to_radians().tan();
    let perspective = "Camera \"perspective\" \"float fov\" 60";
    // The middle of the right edge, and of the upper one.
    let cases = [
        (film(200, 100), DVec3::new(2.0 * tangent, 0.0, 1.0), DVec2::new(200.0, 50.0)),
        (film(200, 100), DVec3::new(0.0, tangent, 1.0), DVec2::new(100.0, 0.0)),
        (film(100, 200), DVec3::new(tangent, 0.0, 1.0), DVec2::new(100.0, 100.0)),
        (film(100, 200), DVec3::new(0.0, 2.0 * tangent, 1.0), DVec2::new(50.0, 0.0)),
    ];
    for (film, target, expected) in cases {
        assert_relative_eq!(at(&format!("{film}{perspective}"), target), expected, epsilon = 1e-9);
    }
    let square = film(100, 100);
    let window = "Camera \"perspective\" \"float screenwindow\" [-0.5 1.5 -1.2 0.8]";
    let corner = at(&format!("{square}{window}"), DVec3::new(-0.5, 0.8, 1.0));
    assert_relative_eq!(corner, DVec2::ZERO, epsilon = 1e-9);
    let corner = at(&format!("{square}{window}"), DVec3::new(1.5, -1.2, 1.0));
    assert_relative_eq!(corner, DVec2::splat(100.0), epsilon = 1e-9);
    // From the side: up is y, and what is on the right is where up × forward goes.
    let look = "LookAt 3 1 2  3 1 1  0 1 0\n";
    let right = at(&format!("{look}{square}{perspective}"), DVec3::new(3.0 - tangent, 1.0, 1.0));
    assert_relative_eq!(right, DVec2::new(100.0, 50.0), epsilon = 1e-9);
    let upper = at(&format!("{look}{square}{perspective}"), DVec3::new(3.0, 1.0 + tangent, 1.0));
    assert_relative_eq!(upper, DVec2::new(50.0, 0.0), epsilon = 1e-9);
    let mirrored = format!("Scale -1 1 1\n{look}{square}{perspective}");
    assert_relative_eq!(
        at(&mirrored, DVec3::new(3.0 - tangent, 1.0, 1.0)),
        DVec2::new(0.0, 50.0),
        epsilon = 1e-9
    );
    // A scale of the world changes no direction.
    let scaled = format!("Scale 3 3 3\n{look}{square}{perspective}");
    assert_relative_eq!(
        at(&scaled, DVec3::new(3.0 - tangent, 1.0, 1.0)),
        DVec2::new(100.0, 50.0),
        epsilon = 1e-9
    );
}

/// Independent of the camera's own functions: the brightest pixel of a picture of a small lamp.
#[test]
fn lamps_are_seen_where_they_are() {
    let directory = Directory::new("lamps");
    let text = format!(
        "LookAt 1 2 3  1 2 4  0 1 0\n{}PixelFilter \"box\"\nCamera \"perspective\"\nWorldBegin\n\
         AreaLightSource \"diffuse\"\nTranslate 2.1 2.3 5\nShape \"sphere\" \"float radius\" 0.02",
        film(40, 20)
    );
    // x / z = 0.55 and y / z = 0.15 of a window of ±2 and ±1.
    let image = render(&directory.load(&text), 64);
    let brightest = (0..image.pixels().len())
        .max_by(|a, b| image.pixels()[*a].r().total_cmp(&image.pixels()[*b].r()));
    let brightest = brightest.expect("pixels") as u32;
    assert_eq!((brightest % 40, brightest / 40), (25, 8));
}

#[test]
fn lenses_and_parallel_rays_are_as_large_as_they_say() {
    let directory = Directory::new("lenses");
    // In a world that the camera sees at half its size, everything is twice as large.
    let text = format!(
        "Scale 0.5 0.5 0.5\n{}Camera \"perspective\" \"float lensradius\" 0.25 \"float focaldistance\" 3\n{BALL}",
        film(50, 50)
    );
    let camera = directory.load(&text).views.remove(0).camera;
    let at = |u: f64| {
        let point = camera.sample_point(0.5, DVec2::new(u, 0.3)).expect("a point").point;
        let ray = camera.sample_direction(&point, DVec2::new(0.2, 0.9)).expect("a direction");
        let direction = ray.direction / ray.direction.z;
        (point.position, point.position + direction * (6.0 - point.position.z))
    };
    let [(from, first), (other, second)] = [0.1, 0.9].map(at);
    assert!(from.distance(other) > 0.3 && from.length() <= 0.5 && other.length() <= 0.5);
    assert_relative_eq!(first, second, epsilon = 1e-9);
    let text = format!(
        "Translate -4 0 0\n{}Camera \"orthographic\" \"float screenwindow\" [-1 3 -1 1]\n{BALL}",
        film(40, 20)
    );
    let camera = directory.load(&text).views.remove(0).camera;
    let point = camera.sample_point(0.5, DVec2::splat(0.5)).expect("a point").point;
    for (u, expected) in [
        (DVec2::ZERO, DVec2::new(3.0, 1.0)),
        (DVec2::ONE, DVec2::new(7.0, -1.0)),
        (DVec2::splat(0.5), DVec2::new(5.0, 0.0)),
    ] {
        let ray = camera.sample_direction(&point, u).expect("a ray");
        assert_relative_eq!(ray.from.position.truncate(), expected, epsilon = 1e-9);
        assert_relative_eq!(ray.direction, DVec3::Z, epsilon = 1e-12);
    }
}

#[test]
fn films_have_their_windows() {
    let directory = Directory::new("films");
    let window = |parameters: &str| {
        let film = film(100, 50);
        let import = directory.load(&format!("{}{parameters}\n{BALL}", film.trim_end()));
        let film = import.views[0].camera.film();
        assert_eq!(film.resolution, UVec2::new(100, 50));
        (film.window_min, film.window_max)
    };
    assert_eq!(window(""), (UVec2::ZERO, UVec2::new(100, 50)));
    let corners = (UVec2::new(26, 10), UVec2::new(50, 40));
    assert_eq!(window("\"float cropwindow\" [0.255 0.5 0.8 0.2]"), corners);
    assert_eq!(window("\"integer pixelbounds\" [26 50 10 40]"), corners);
    for (film, expected) in [
        ("", UVec2::new(1280, 720)),
        ("Film \"rgb\"", UVec2::new(1280, 720)),
        ("Film \"image\"", UVec2::new(640, 480)),
    ] {
        let import = directory.load(&format!("{film}\nCamera \"perspective\"\n{BALL}"));
        assert_eq!(import.views[0].camera.film().resolution, expected);
    }
}

/// The exposure is a factor of all light.
#[test]
fn films_scale_light() {
    let directory = Directory::new("exposure");
    let mean = |camera: &str, film: &str| {
        let text = format!(
            "Camera \"perspective\" {camera}\nFilm \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 {film}\n\
             WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 2 3]"
        );
        render(&directory.load(&text), 1).mean()
    };
    assert_eq!(mean("", ""), Rgb::new(1.0, 2.0, 3.0));
    let lens = "\"float shutteropen\" 0.5 \"float shutterclose\" 0.75";
    assert_eq!(mean(lens, "\"float iso\" 800"), Rgb::new(2.0, 4.0, 6.0));
}

#[test]
fn filters_have_their_variance() {
    let directory = Directory::new("filters");
    let filter = |text: &str| {
        directory.load(&format!("Camera \"perspective\"\n{text}\n{BALL}")).views[0].filter
    };
    assert_eq!(filter("PixelFilter \"box\""), Filter::Box);
    let tent = "PixelFilter \"triangle\" \"float xradius\" 1 \"float yradius\" 1";
    assert_eq!(filter(tent), Filter::Tent);
    // ∫ x² (e^(-2x²) - e^(-4.5)) dx / ∫ (e^(-2x²) - e^(-4.5)) dx over ±1.5, by another program.
    let Filter::Gaussian { standard_deviation } = filter("") else { panic!("a Gaussian") };
    assert_relative_eq!(standard_deviation, 0.479_014_5, max_relative = 1e-5);
    assert_eq!(filter("PixelFilter \"gaussian\""), filter(""));
    let wide =
        "PixelFilter \"gaussian\" \"float xradius\" 50 \"float yradius\" 50 \"float sigma\" 2";
    let Filter::Gaussian { standard_deviation } = filter(wide) else { panic!("a Gaussian") };
    assert_relative_eq!(standard_deviation, 2.0, max_relative = 1e-4);
    let import = directory.left_out(
        &format!("Camera \"perspective\"\nPixelFilter \"box\" \"float xradius\" 1 \"float yradius\" 1\n{BALL}"),
        "a box filter of this sort is a Gaussian instead",
    );
    let Filter::Gaussian { standard_deviation } = import.views[0].filter else {
        panic!("a Gaussian")
    };
    assert_relative_eq!(standard_deviation, (1.0f64 / 3.0).sqrt(), max_relative = 1e-12);
}

#[test]
fn integrators_and_samplers_are_hints() {
    let directory = Directory::new("hints");
    let hints = |text: &str| {
        let import: Import = directory.load(&format!("Camera \"perspective\"\n{text}\n{BALL}"));
        (import.hints.max_bounces, import.hints.samples_per_pixel, import.hints.integrator)
    };
    assert_eq!(hints(""), (Some(5), None, None));
    let path = "Integrator \"path\" \"integer maxdepth\" 7\nSampler \"halton\" \"integer pixelsamples\" 64";
    assert_eq!(hints(path), (Some(7), Some(64), Some("path".to_owned())));
    let stratified =
        "Integrator \"bdpt\"\nSampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 2";
    assert_eq!(hints(stratified), (Some(5), Some(6), Some("bdpt".to_owned())));
    let import = directory.left_out(
        &format!("Camera \"perspective\"\nIntegrator \"ambientocclusion\"\n{BALL}"),
        "the integrator ambientocclusion is not supported",
    );
    assert_eq!(import.hints.max_bounces, Some(5));
}

/// In a closed room of albedo a that emits, n scattering events show L (1 + a + … + aⁿ).
#[test]
fn closed_rooms_have_the_radiance_of_their_depth() {
    let directory = Directory::new("closed");
    for (depth, expected) in [(0, 1.0), (1, 1.8), (3, 2.952)] {
        let text = format!(
            "{}Camera \"perspective\"\nIntegrator \"path\" \"integer maxdepth\" {depth}\nWorldBegin\n\
             Material \"diffuse\" \"rgb reflectance\" [0.8 0.8 0.8]\nReverseOrientation\n\
             AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\nShape \"sphere\" \"float radius\" 2",
            film(8, 8)
        );
        let mean = render(&directory.load(&text), 64).mean();
        assert_relative_eq!(mean.r(), expected, max_relative = 2e-3);
    }
}

#[test]
fn other_cameras_are_approximated() {
    let directory = Directory::new("others");
    let cases = [
        ("Camera \"spherical\" \"string mapping\" \"equirectangular\"", "a spherical camera"),
        ("Camera \"realistic\" \"string lensfile\" \"wide.dat\"", "a realistic camera"),
        ("Camera \"perspective\" \"float fov\" 180", "fov is 180"),
        ("Scale 1 2 1\nCamera \"perspective\"", "is no rotation"),
        ("Scale 1 0 1\nCamera \"perspective\"", "not invertible"),
        ("Camera \"perspective\" \"float frameaspectratio\" 1", "pixels are square"),
        ("Camera \"perspective\"\nFilm \"rgb\" \"string sensor\" \"nikon_d850\"", "sensor"),
        ("Camera \"perspective\"\nFilm \"rgb\" \"float cropwindow\" [0 0 0 1]", "window"),
        ("", "the scene has no camera"),
    ];
    for (text, expected) in cases {
        directory.left_out(&format!("{text}\n{BALL}"), expected);
    }
}

/// A file with all that is read has no warnings, and every part of it is there.
#[test]
fn the_room_is_read_as_a_whole() {
    let strict = Options { strict: true, ..Options::default() };
    let import = pbrt::load(Path::new(DATA).join("room.pbrt"), &strict)
        .unwrap_or_else(|error| panic!("{error}"));
    // Floor, wall, lamp, two times a ball and a pyramid, and a ball of gold.
    assert_eq!((import.world.surface_count(), import.world.light_count()), (8, 4));
    assert_eq!(import.world.primitive_count(), 2 + 1 + 1 + 2 * (1 + 6) + 1);
    assert_eq!(import.hints.max_bounces, Some(4));
    let image = render(&import, 16);
    assert!(image.mean().0.iter().all(|c| (0.2..2.0).contains(c)), "{:?}", image.mean());
}
