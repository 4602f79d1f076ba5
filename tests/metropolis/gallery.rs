//! Metropolis sampling has the mean of bidirectional path tracing on the scenes of the gallery.

use crate::compare::{Comparison, assert_measurements_agree, measure};
use pathspace::gallery;
use pathspace::glam::UVec2;
use pathspace::integrator::{Bidirectional, Depth, Metropolis, Multiplexed};
use pathspace::render::Render;
use pathspace::sampler::SamplerKind;
use pathspace::scene::World;

/// Images over independent seeds, each set of chains with candidates of its own.
fn agree(name: &str, target: f64) {
    let scene = gallery::build(name, UVec2::splat(16)).expect("a scene of the gallery");
    let bidirectional = Bidirectional { depth: Depth::up_to(6), ..Bidirectional::default() };
    let multiplexed = Multiplexed { bidirectional };
    let members: [(&str, &dyn Render<World>); 3] = [
        ("bidirectional", &bidirectional),
        ("metropolis", &Metropolis { restart: 16, ..Metropolis::over(bidirectional) }),
        ("multiplexed", &Metropolis { restart: 16, ..Metropolis::over(multiplexed) }),
    ];
    let sampler = SamplerKind::Independent;
    let comparison = Comparison { target, sampler, most: 1 << 14, ..Comparison::default() };
    let measured: Vec<_> = members
        .into_iter()
        .map(|member| measure(&scene.world, &*scene.camera, member, &comparison))
        .collect();
    for one in &measured {
        println!("{name} {}: {} x {}", one.name, one.relative_error(), one.samples_per_pixel);
    }
    assert_measurements_agree(name, &measured, &Comparison { target: 2.0 * target, ..comparison });
}

#[test]
fn cornell_box() {
    agree("cornell-box", 0.004);
}

#[test]
fn sphere_cap() {
    agree("sphere-cap", 0.0025);
}

#[test]
fn lamp_room() {
    agree("lamp-room", 0.01);
}

#[test]
fn caustic() {
    agree("caustic", 0.01);
}

#[test]
fn glossy_plates() {
    agree("glossy-plates", 0.01);
}

#[test]
fn smooth_mesh() {
    agree("smooth-mesh", 0.005);
}
