//! The materials that scenes of the gallery use.

use crate::math::Rgb;
use crate::scene::{Emission, Material};
use glam::DVec2;

/// Common glass behind the front side of a surface.
pub(super) const GLASS: Material = Material::Dielectric { relative_ior: 1.5 };

/// The material of lamps: reflects nothing.
pub(super) const BLACK: Material = Material::Black;

pub(super) const fn diffuse(albedo: Rgb) -> Material {
    Material::Lambert { albedo }
}

/// Metal of the given reflectance and GGX roughness.
pub(super) const fn metal(reflectance: Rgb, alpha: f64) -> Material {
    Material::RoughMirror { reflectance, alpha: DVec2::splat(alpha) }
}

/// Emission from the front side.
pub(super) const fn emission(radiance: Rgb) -> Emission {
    Emission { radiance, two_sided: false }
}
