//! Emitters with what they have by default.

use crate::files::{Directory, GLOW, SENSOR, emitted_below};
use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use pathspace::endpoint::Light;
use pathspace::film::{Image, ImageFile};
use pathspace::geometry::SurfacePoint;
use pathspace::import::Import;
use pathspace::math::Rgb;
use pathspace::scene::Scene;
use std::f64::consts::PI;

fn lamp(import: &Import) -> &dyn Light {
    import.world.light(import.world.light_by_name("lamp").expect("a lamp"))
}

fn load(directory: &Directory, emitter: &str) -> Import {
    let glow = format!("<shape type='rectangle'>{GLOW}</shape>");
    directory.load(&format!("{SENSOR}{glow}{emitter}")).expect(emitter)
}

/// Cut off at 20 degrees, or else where it is said, the same up to three quarters of that, and
/// linear in the angle between.
#[test]
fn spots_fall_off_between_their_angles() {
    let directory = Directory::new("spots");
    for (angles, inner, outer) in [
        ("", 15.0, 20.0),
        ("<float name='cutoff_angle' value='40'/>", 30.0, 40.0),
        ("<float name='beam_width' value='5'/>", 5.0, 20.0),
    ] {
        let spot = format!(
            "<emitter type='spot' id='lamp'><rgb name='intensity' value='2'/>{angles}</emitter>"
        );
        let import = load(&directory, &spot);
        let point = SurfacePoint::dirac(DVec3::ZERO);
        let at = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            lamp(&import).emit(&point, DVec3::new(0.6 * sin, 0.8 * sin, cos)).g()
        };
        for (share, expected) in [(0.0, 2.0), (0.25, 1.5), (0.5, 1.0), (0.75, 0.5), (1.001, 0.0)] {
            let degrees = inner + share * (outer - inner);
            assert_relative_eq!(at(degrees), expected, epsilon = 1e-6);
        }
        assert_eq!([at(0.0), at(inner - 0.01)], [2.0; 2], "{angles}");
    }
}

/// The transform places what has no place of its own: z turned to -y.
#[test]
fn transforms_place_lights() {
    let directory = Directory::new("placed");
    let turn = "<transform name='to_world'><matrix value='1 0 0 3  0 0 -1 4  0 1 0 5  0 0 0 1'/>\
                </transform>";
    for (kind, given) in [
        ("point", "<point name='position' x='3' y='4' z='5'/>"),
        ("directional", "<vector name='direction' x='0' y='-1' z='0'/>"),
    ] {
        let sample = |place: &str| {
            let import =
                load(&directory, &format!("<emitter type='{kind}' id='lamp'>{place}</emitter>"));
            let receiver = SurfacePoint::dirac(DVec3::new(1.0, 2.0, 3.0));
            lamp(&import).sample_from(&receiver, 0.3, DVec2::new(0.4, 0.7)).expect("a point").point
        };
        assert_eq!(sample(turn), sample(given), "{kind}");
    }
}

/// Rows at equal angles from pole to pole, times the scale; a transform may scale, too.
#[test]
fn environment_maps_reach_the_poles() {
    let directory = Directory::new("poles");
    let rows = [1.0, 5.0, 2.0, 8.0];
    let image = Image::from_fn(8, 4, |_, y| Rgb::splat(rows[y as usize]));
    ImageFile::from(image).save(directory.0.join("rows.exr")).expect("writable");
    let import = load(
        &directory,
        "<emitter type='envmap' id='lamp'><string name='filename' value='rows.exr'/>\
         <float name='scale' value='3'/>\
         <transform name='to_world'><scale value='2'/></transform></emitter>",
    );
    for (x, expected) in [(0.0, 1.0), (0.5, 3.0), (1.0, 5.0), (1.5, 3.5), (2.25, 3.5), (3.0, 8.0)] {
        let (sin, cos) = (PI * x / 3.0).sin_cos();
        let towards = DVec3::new(0.6 * sin, cos, 0.8 * sin).normalize();
        let point = SurfacePoint::infinite(DVec3::ZERO, -towards);
        let radiance = lamp(&import).emit(&point, -towards).g();
        assert_relative_eq!(radiance, 3.0 * expected, max_relative = 1e-6);
    }
}

#[test]
fn lights_of_no_colour_are_white() {
    let directory = Directory::new("white");
    let square = "<shape type='rectangle'><emitter type='area'/></shape>";
    let import = directory.load(&format!("{SENSOR}{square}")).expect("valid");
    assert_eq!(emitted_below(&import, 0.1, 0.2), Rgb::WHITE);
    let point = load(&directory, "<emitter type='point' id='lamp'/>");
    assert_eq!(lamp(&point).emit(&SurfacePoint::dirac(DVec3::ZERO), DVec3::Z), Rgb::WHITE);
}
