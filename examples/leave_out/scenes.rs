//! Small scenes that need little, beside those of the gallery.

use super::common::{AnyCamera, FileOptions, NamedScene, scene_or_file};
use pathspace::endpoint::{ConstantEnvironment, PinholeCamera, PointLight, SpotLight};
use pathspace::film::Filter;
use pathspace::gallery::{self, Claims};
use pathspace::geometry::{Quad, Sphere};
use pathspace::glam::{DVec3, UVec2};
use pathspace::math::Rgb;
use pathspace::scene::{Emission, Material, WorldBuilder};
use std::error::Error;

const SMALL: [&str; 5] = ["furnace", "ball-under-sky", "point-light", "mirror-room", "narrow-spot"];

/// All names.
pub fn names() -> Vec<String> {
    gallery::NAMES.iter().chain(&SMALL).map(|name| (*name).to_owned()).collect()
}

/// Builds a scene by its name.
pub fn build(name: &str, size: UVec2) -> Result<NamedScene, Box<dyn Error>> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let mut b = WorldBuilder::new();
    let grey = b.add_material("grey", Material::Lambert { albedo: Rgb::splat(0.5) })?;
    let mut claims = Claims::ALL;
    let (mut eye, mut target, mut max_bounces) = (p(0.0, 0.2, 0.95), p(0.0, 0.0, 0.0), None);
    let description = match name {
        "furnace" => {
            let wall = b.add_sphere(
                "wall",
                Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) },
                grey,
            )?;
            b.set_emission(wall, Emission { radiance: Rgb::WHITE, two_sided: false })?;
            eye = p(0.1, 0.2, 0.3);
            "The inside of a sphere that emits everywhere."
        }
        "ball-under-sky" => {
            b.add_sphere("ball", Sphere::new(DVec3::ZERO, 1.0), grey)?;
            b.set_environment("sky", ConstantEnvironment::new(Rgb::new(0.4, 0.6, 1.0))?)?;
            eye = p(0.0, 1.0, 4.0);
            claims.uniform_area = false;
            "One diffuse ball under a uniform sky."
        }
        "point-light" => {
            room(&mut b, grey)?;
            b.add_light("lamp", PointLight::new(p(0.3, 0.6, 0.1), Rgb::WHITE)?)?;
            claims.uniform_area = false;
            "A closed diffuse room with a point light."
        }
        "mirror-room" => {
            let mirror =
                b.add_material("mirror", Material::Mirror { reflectance: Rgb::splat(0.8) })?;
            let black = b.add_material("black", Material::Black)?;
            room(&mut b, mirror)?;
            let lamp = b.add_sphere("lamp", Sphere::new(p(0.2, 0.3, -0.4), 0.3), black)?;
            b.set_emission(lamp, Emission { radiance: Rgb::WHITE, two_sided: false })?;
            (claims.uniform_area, claims.light_tracing, max_bounces) = (false, false, Some(12));
            "A room of mirrors."
        }
        "narrow-spot" => {
            room(&mut b, grey)?;
            b.add_light(
                "spot",
                SpotLight::new(p(0.0, 0.9, 0.0), p(0.3, -1.0, -0.4), Rgb::splat(20.0), 3.0, 4.0)?,
            )?;
            (claims.uniform_area, target) = (false, p(0.0, -0.4, -1.0));
            "A closed diffuse room with a narrow spot light."
        }
        _ => return scene_or_file(name, Some(size), &FileOptions::default()),
    };
    let camera = PinholeCamera::new(eye, target, DVec3::Y, 60.0, size)?;
    Ok(NamedScene {
        name: name.to_owned(),
        description: description.to_owned(),
        world: b.build()?,
        camera: AnyCamera(Box::new(camera)),
        max_bounces,
        claims: Some(claims),
        filter: Filter::Box,
        views: vec!["camera".to_owned()],
        messages: Vec::new(),
    })
}

/// The walls of the cube [-1, 1]³, front sides inside.
fn room(
    b: &mut WorldBuilder,
    material: pathspace::scene::MaterialId,
) -> Result<(), Box<dyn Error>> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for (i, name) in ["left", "floor", "back", "right", "ceiling", "front"].into_iter().enumerate()
    {
        let (n, u, v) = (axes[i % 3], axes[(i + 1) % 3], axes[(i + 2) % 3]);
        let (u, v, side) = if i < 3 { (u, v, -1.0) } else { (v, u, 1.0) };
        b.add_quad(
            name,
            Quad { origin: n * side - u - v, edge_u: u * 2.0, edge_v: v * 2.0 },
            material,
        )?;
    }
    Ok(())
}
