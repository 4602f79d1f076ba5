//! Four metal plates of different roughness under four spherical lights of very different size and
//! equal power, after Veach (1997, section 9.2.3). Sampling the lights is best for rough plates and
//! small lights, sampling the BSDF for smooth plates and large lights: the case for multiple
//! importance sampling.

use super::materials::{BLACK, diffuse, emission, metal};
use super::shapes::quadrilateral;
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::PinholeCamera;
use crate::geometry::{Quad, Sphere};
use crate::math::Rgb;
use crate::scene::WorldBuilder;
use glam::{DAffine3, DVec3, UVec2};

pub(super) const DESCRIPTION: &str =
    "Four metal plates of different roughness reflect four lights of different size, after Veach.";

const CAMERA: DVec3 = DVec3::new(0.0, 2.0, 15.0);
/// Height and depth of the plates' centres, and their GGX roughness.
const PLATES: [(f64, f64, f64); 4] =
    [(-1.5, 0.6, 0.005), (-2.5, 2.2, 0.02), (-3.2, 4.0, 0.06), (-3.7, 6.0, 0.15)];
const PLATE_SIZE: [f64; 2] = [8.0, 1.5];
/// Position along x, radius and colour of the lights.
const LIGHTS: [(f64, f64, Rgb); 4] = [
    (-3.6, 0.04, Rgb::new(1.0, 0.55, 0.3)),
    (-1.4, 0.12, Rgb::new(1.0, 0.9, 0.4)),
    (1.0, 0.35, Rgb::new(0.5, 1.0, 0.6)),
    (3.6, 0.9, Rgb::new(0.45, 0.65, 1.0)),
];
/// Radiance times the square of the radius.
const INTENSITY: f64 = 1.6;

pub(super) fn build(
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let black = builder.add_material("black", BLACK)?;
    let grey = builder.add_material("grey", diffuse(Rgb::splat(0.4)))?;

    let floor = quadrilateral([
        p(-12.0, -4.8, 14.0),
        p(12.0, -4.8, 14.0),
        p(12.0, -4.8, -4.0),
        p(-12.0, -4.8, -4.0),
    ]);
    builder.add_mesh("floor", &floor, DAffine3::IDENTITY, grey)?;
    let wall = quadrilateral([
        p(-12.0, -4.8, -4.0),
        p(12.0, -4.8, -4.0),
        p(12.0, 8.0, -4.0),
        p(-12.0, 8.0, -4.0),
    ]);
    builder.add_mesh("back wall", &wall, DAffine3::IDENTITY, grey)?;

    for (index, (height, depth, alpha)) in PLATES.into_iter().enumerate() {
        let material =
            builder.add_material(format!("metal {alpha}"), metal(Rgb::splat(0.85), alpha))?;
        let center = p(0.0, height, depth);
        // Half way between camera and lights, so that the plate mirrors the one in the other.
        let normal = ((CAMERA - center).normalize() - center.normalize()).normalize();
        let [edge_u, edge_v] =
            [DVec3::X * PLATE_SIZE[0], normal.cross(DVec3::X).normalize() * PLATE_SIZE[1]];
        let plate = Quad { origin: center - 0.5 * (edge_u + edge_v), edge_u, edge_v };
        builder.add_quad(format!("plate {index}"), plate, material)?;
    }
    for (index, (x, radius, color)) in LIGHTS.into_iter().enumerate() {
        let light = builder.add_sphere(
            format!("light {index}"),
            Sphere::new(p(x, 0.0, 0.0), radius),
            black,
        )?;
        builder.set_emission(light, emission(color * (INTENSITY / (radius * radius))))?;
    }

    let camera = PinholeCamera::new(CAMERA, p(0.0, -1.7, 2.0), DVec3::Y, 39.0, resolution)?;
    Ok(GalleryScene {
        name: "glossy-plates",
        description: DESCRIPTION,
        world: builder.build()?,
        camera: Box::new(camera),
        max_bounces: None,
        claims: Claims::ALL,
    })
}
