//! The materials that scenes of the gallery use.

use super::GalleryError;
use crate::bsdf::{Dielectric, Ggx, Lambert, Model, Reflectance, RoughConductor};
use crate::math::Rgb;
use crate::scene::{Emission, Material, MaterialId, WorldBuilder};

/// Index of refraction of common glass.
const GLASS: f64 = 1.5;

pub(super) fn diffuse(builder: &mut WorldBuilder, name: &str, albedo: Rgb) -> Result<MaterialId, GalleryError> {
    add(builder, name, Lambert::new(albedo)?)
}

/// Clear glass behind the front side of a surface.
pub(super) fn glass(builder: &mut WorldBuilder, name: &str) -> Result<MaterialId, GalleryError> {
    add(builder, name, Dielectric::new(GLASS)?)
}

/// Metal of the given reflectance and GGX roughness.
pub(super) fn metal(builder: &mut WorldBuilder, name: &str, reflectance: Rgb, alpha: f64) -> Result<MaterialId, GalleryError> {
    add(builder, name, RoughConductor::new(Reflectance::constant(reflectance)?, Ggx::isotropic(alpha)?))
}

/// What lamps are made of: reflects nothing.
pub(super) fn black(builder: &mut WorldBuilder) -> Result<MaterialId, GalleryError> {
    add(builder, "black", Model::BLACK)
}

/// Emission from the front side.
pub(super) const fn emission(radiance: Rgb) -> Emission {
    Emission { radiance, two_sided: false }
}

fn add(builder: &mut WorldBuilder, name: &str, model: impl Into<Model>) -> Result<MaterialId, GalleryError> {
    Ok(builder.add_material(name, Material::from(model.into()))?)
}
