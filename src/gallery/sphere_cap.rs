//! The inside of a diffuse unit sphere of albedo 1/2 whose cap z > 0.8, a tenth of its area, emits
//! radiance 1. Seen from the centre away from the cap, every pixel has the radiance `f_e ρ / (1 -
//! ρ) = 0.1`: k bounces contribute `f_e ρ^k` to every point of the wall, since the geometry term
//! between any two points of a sphere is the same.

use super::materials::{diffuse, emission};
use super::{Claims, GalleryError, GalleryScene};
use crate::endpoint::PinholeCamera;
use crate::geometry::Sphere;
use crate::math::Rgb;
use crate::scene::WorldBuilder;
use glam::{DVec3, UVec2};

pub(super) const DESCRIPTION: &str =
    "A diffuse sphere from inside with an emissive cap; every pixel is exactly 0.1.";

const ALBEDO: f64 = 0.5;
const CAP_COSINE: f64 = 0.8;

pub(super) fn build(
    resolution: UVec2,
    mut builder: WorldBuilder,
) -> Result<GalleryScene, GalleryError> {
    let grey = builder.add_material("grey", diffuse(Rgb::splat(ALBEDO)))?;
    let sphere = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) };
    builder.add_sphere("wall", Sphere { cos_max: CAP_COSINE, ..sphere }, grey)?;
    let cap = builder.add_sphere("cap", Sphere { cos_min: CAP_COSINE, ..sphere }, grey)?;
    builder.set_emission(cap, emission(Rgb::WHITE))?;
    Ok(GalleryScene {
        name: "sphere-cap",
        description: DESCRIPTION,
        world: builder.build()?,
        camera: Box::new(PinholeCamera::new(
            DVec3::ZERO,
            DVec3::NEG_Z,
            DVec3::Y,
            60.0,
            resolution,
        )?),
        max_bounces: None,
        claims: Claims::ALL,
    })
}
