//! The host's material in a ready-made scene.

use super::material::RetroReflector;
use pathspace::geometry::{Disk, Quad};
use pathspace::glam::{DAffine3, DVec3};
use pathspace::math::Rgb;
use pathspace::scene::{Emission, Material, Mesh, SceneError, World, WorldBuilder};

/// A retro-reflective ball, a mesh with smooth normals, on a grey floor under a lamp.
pub fn world() -> Result<World, SceneError> {
    let mut builder = WorldBuilder::new();
    let floor = builder.add_material("floor", Material::Lambert { albedo: Rgb::splat(0.5) })?;
    let black = builder.add_material("black", Material::Black)?;
    // Any `Bsdf` will do. That it is diffuse and glossy, and no mirror, is what it says itself.
    let sign = RetroReflector {
        diffuse: Rgb::new(0.1, 0.25, 0.1),
        retro: Rgb::new(0.3, 0.5, 0.3),
        exponent: 8.0,
    };
    let sign = builder.add_material("sign", Material::custom(sign))?;

    let mut ball = Mesh::icosphere(4);
    ball.normals = Some(ball.positions.clone());
    builder.add_mesh("ball", &ball, DAffine3::from_translation(DVec3::Y), sign)?;
    let ground = Disk { center: DVec3::ZERO, normal: DVec3::Y, radius: 5.0 };
    builder.add_disk("ground", ground, floor)?;
    let lamp =
        Quad { origin: DVec3::new(0.5, 3.5, 0.0), edge_u: DVec3::X * 1.5, edge_v: DVec3::Z * 1.5 };
    let lamp = builder.add_quad("lamp", lamp, black)?;
    builder.set_emission(lamp, Emission { radiance: Rgb::splat(9.0), two_sided: false })?;
    builder.build()
}
