//! Materials that differ from others in their roughness alone.

use super::{Material, Texture, TextureError};
use crate::math::Rgb;
use glam::DVec2;

impl Material {
    /// The same material with the roughness α in all directions, 0 for a smooth one: that of mirrors,
    /// metals and glass, of the coats of plastics, and of the materials that have textures for it.
    /// Diffuse bodies, panes and [custom](Self::custom) models have none and stay as they are.
    ///
    /// # Errors
    /// If the roughness is in a texture whose colours [cannot be changed](Texture::recoloured).
    pub fn with_roughness(self, alpha: f64) -> Result<Self, TextureError> {
        let alphas = DVec2::splat(alpha);
        let root = alpha.sqrt();
        let set_green = |texture: &Texture| texture.recoloured(|c| Rgb::new(c.0[0], root, c.0[2]));
        let inner = |material: Box<Self>| material.with_roughness(alpha).map(Box::new);
        let both = |pair: Box<[Self; 2]>| -> Result<_, TextureError> {
            let [a, b] = *pair;
            Ok(Box::new([a.with_roughness(alpha)?, b.with_roughness(alpha)?]))
        };
        Ok(match self {
            Self::Black | Self::Null | Self::Lambert { .. } => self,
            Self::ThinDielectric { .. } | Self::Custom(_) => self,
            Self::Mirror { reflectance } | Self::RoughMirror { reflectance, .. } => {
                Self::RoughMirror { reflectance, alpha: alphas }
            }
            Self::Conductor { eta, k } | Self::RoughConductor { eta, k, .. } => {
                Self::RoughConductor { eta, k, alpha: alphas }
            }
            Self::Dielectric { relative_ior } | Self::RoughDielectric { relative_ior, .. } => {
                Self::RoughDielectric { relative_ior, alpha: alphas }
            }
            Self::Plastic { albedo, specular, relative_ior, colour_shift }
            | Self::RoughPlastic { albedo, specular, relative_ior, colour_shift, .. } => {
                Self::RoughPlastic { albedo, specular, relative_ior, colour_shift, alpha }
            }
            Self::MetallicRoughness { base_color, metallic_roughness, relative_ior } => {
                let metallic_roughness = set_green(&metallic_roughness)?;
                Self::MetallicRoughness { base_color, metallic_roughness, relative_ior }
            }
            Self::Coated { base_color, metallic_roughness, relative_ior, coat } => {
                let metallic_roughness = set_green(&metallic_roughness)?;
                let [cover, roughness] = *coat;
                let coat = Box::new([cover, set_green(&roughness)?]);
                Self::Coated { base_color, metallic_roughness, relative_ior, coat }
            }
            Self::Principled { base_color, metalness, lobes, .. } => {
                let roughness = Rgb::splat(root).into();
                Self::Principled { base_color, metalness, roughness, lobes }
            }
            Self::Beckmann { rough } => Self::Beckmann { rough: inner(rough)? },
            Self::IndependentMasking { rough } => Self::IndependentMasking { rough: inner(rough)? },
            Self::VaryingRoughness { rough, .. } => *inner(rough)?,
            Self::Tinted { material, tint } => Self::Tinted { material: inner(material)?, tint },
            Self::Stained { glass, stain } => Self::Stained { glass: inner(glass)?, stain },
            Self::Sided { front, back } => Self::Sided { front: inner(front)?, back: inner(back)? },
            Self::Blend { components, amount } => {
                Self::Blend { components: both(components)?, amount }
            }
            Self::Culled { front } => Self::Culled { front: inner(front)? },
            Self::Mixture { components, weights } => {
                Self::Mixture { components: both(components)?, weights }
            }
        })
    }
}
