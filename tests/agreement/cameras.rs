//! Cameras, filters and crop windows.

use crate::compare::{self, Comparison, assert_agree, measure};
use crate::rooms::{Room, camera, lens_camera, parallel_camera, v};
use crate::team::{Team, black, grey, lit_room, sky};
use glam::UVec2;
use pathspace::endpoint::Lookup;
use pathspace::film::Filter;
use pathspace::integrator::{Depth, PathTracer};
use pathspace::math::Rgb;

#[test]
fn thin_lens() {
    let team = Team::with_light(Depth::up_to(2)).balance().general();
    assert_agree("thin lens", &lit_room(), &lens_camera(), &team.named(), &Comparison::default());
}

#[test]
fn orthographic() {
    let team = Team::with_light(Depth::up_to(2)).general();
    assert_agree(
        "orthographic",
        &lit_room(),
        &parallel_camera(),
        &team.named(),
        &Comparison::default(),
    );
}

/// A lens and a light at infinity: no technique may join them directly.
#[test]
fn orthographic_under_an_environment() {
    let mut room = Room::open(grey());
    room.environment(sky(Lookup::PiecewiseConstant));
    let team = Team::with_light(Depth::up_to(2));
    assert_agree(
        "orthographic, environment",
        &room.build(),
        &parallel_camera(),
        &team.named(),
        &Comparison::default(),
    );
}

/// The border pixels are blocks of their own in the comparison; light tracing must splat what is
/// outside of the film into it.
#[test]
fn filters() {
    let team = Team::new(Depth::up_to(1)).path().light().bidirectional();
    let world = lit_room();
    for filter in [Filter::Box, Filter::Tent, Filter::Gaussian { standard_deviation: 0.9 }] {
        let comparison = Comparison { filter, ..Comparison::default() };
        assert_agree(&format!("{filter:?}"), &world, &camera(), &team.named(), &comparison);
    }
}

/// A lamp seen directly, whose sharp edges the filter moves by half a block.
#[test]
fn filters_blur_alike() {
    let mut room = Room::default();
    let lamp = room.quad(v(-0.3, 0.0, 0.3), v(0.5, 0.0, 0.0), v(0.0, 0.0, 0.6), black());
    room.emit(lamp, Rgb::WHITE, false);
    let (world, team) = (room.build(), Team::with_light(Depth::up_to(0)));
    for filter in [Filter::Tent, Filter::Gaussian { standard_deviation: 1.5 }] {
        assert_agree(
            &format!("{filter:?}"),
            &world,
            &camera(),
            &team.named(),
            &Comparison { filter, ..Comparison::default() },
        );
    }
}

/// A rendering of a window is the same part of the whole image, for every camera.
#[test]
fn crop_windows() {
    let world = lit_room();
    let (min, max) = (UVec2::new(4, 8), UVec2::new(12, 16));
    let comparison = Comparison { filter: Filter::Tent, target: 0.0025, ..Comparison::default() };
    let team = Team::new(Depth::up_to(1)).path().light().bidirectional();
    let crop = |m: compare::Measured| compare::Measured {
        images: m
            .images
            .iter()
            .map(|image| image.crop(min.to_array(), max.to_array()).expect("inside"))
            .collect(),
        ..m
    };
    let window = |whole: &dyn pathspace::endpoint::Camera,
                  part: &dyn pathspace::endpoint::Camera,
                  case: &str| {
        let mut measured: Vec<_> =
            team.named().into_iter().map(|i| measure(&world, part, i, &comparison)).collect();
        let finer = Comparison { target: 0.001, ..comparison };
        measured.push(crop(measure(
            &world,
            whole,
            ("path, whole film", &PathTracer::up_to(1)),
            &finer,
        )));
        compare::assert_measurements_agree(case, &measured, &comparison);
    };
    window(&camera(), &camera().with_window(min, max).expect("inside"), "crop, pinhole");
    window(
        &lens_camera(),
        &lens_camera().with_window(min, max).expect("inside"),
        "crop, thin lens",
    );
    window(
        &parallel_camera(),
        &parallel_camera().with_window(min, max).expect("inside"),
        "crop, orthographic",
    );
}
