//! E: what the camera alone decides.

use crate::entry::{Entry, RARE};
use crate::measure::Method::{self, Bidirectional, Emission, Light, Path, UniformArea};
use crate::scenes::{Stage, camera, furnace_sphere};
use pathspace::geometry::Quad;
use pathspace::glam::DVec3;
use pathspace::integrator::Depth;
use pathspace::scene::Material;

#[test]
fn e03_rectangle_in_view() {
    let mut stage = Stage::default();
    let quad = Quad {
        origin: DVec3::new(-0.25, -0.2, 2.0),
        edge_u: DVec3::Y * 0.4,
        edge_v: DVec3::X * 0.5,
    };
    let lamp = stage.face(quad, Material::Black);
    stage.glow(lamp, 1.0);
    let (world, eye) = (stage.build(), camera(DVec3::ZERO, DVec3::Z, 60.0));
    Entry::new("E03", &world, &eye, Depth::up_to(2))
        .within(RARE, 20_000_000)
        .check(&Method::ALL, "mean_pixel");
}

#[test]
fn e05_constant_radiance() {
    let world = furnace_sphere(DVec3::ZERO, 1.0, &Material::Black, 1.0);
    let eye = camera(DVec3::ZERO, DVec3::X, 60.0);
    Entry::new("E05", &world, &eye, Depth::default())
        .check(&[Emission, Path, UniformArea], "pixel");
    Entry::new("E05", &world, &eye, Depth::default())
        .within(RARE, 20_000_000)
        .check(&[Light, Bidirectional], "pixel");
}
