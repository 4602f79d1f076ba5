//! Materials: what a scene is told about how a surface scatters, checked and made a model when it
//! is added.

mod scattering;
#[cfg(test)]
mod tests;
mod texture;

pub(crate) use scattering::Scattering;
pub use scattering::SurfaceBsdf;
pub use texture::{Interpolation, Texture, TextureError, Wrap};

use crate::bsdf::{
    Beckmann, BsdfError, Conductor, Dielectric, Ggx, Lambert, Lobes, MetallicRoughness,
    Microfacets, Mirror, Mixture, Model, Null, Plastic, Reflectance, RoughConductor,
    RoughDielectric, SimpleModel, ThinDielectric,
};
use crate::math::Rgb;
use glam::DVec2;
use scattering::{Layer, LayerModel, Mix, Stack};

/// How a surface scatters.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Material {
    /// Absorbs everything.
    #[default]
    Black,
    /// Lets light pass straight through; counts as one scattering event.
    Null,
    /// Lambertian reflection on both sides.
    Lambert {
        /// Reflected fraction, 0 to 1.
        albedo: Rgb,
    },
    /// Perfect mirror on both sides.
    Mirror {
        /// Reflected fraction, 0 to 1.
        reflectance: Rgb,
    },
    /// Polished metal.
    Conductor {
        /// Real part of the index of refraction, relative to the outside.
        eta: Rgb,
        /// Imaginary part.
        k: Rgb,
    },
    /// Clear glass; the inside is the back of the surface.
    Dielectric {
        /// Index of refraction of the inside over that of the outside.
        relative_ior: f64,
    },
    /// A pane of clear glass as one surface, without refraction.
    ThinDielectric {
        /// Index of refraction of the pane over that of the outside.
        relative_ior: f64,
    },
    /// A diffuse body under a smooth clear coat; see [`Plastic`].
    Plastic {
        /// Reflected fraction of the body, 0 to 1.
        albedo: Texture,
        /// Scale of the coat's reflection, 0 to 1; physically 1.
        specular: Rgb,
        /// Index of refraction of the coat over that of the outside, at least 1.
        relative_ior: f64,
        /// Whether light that the coat throws back to the body is coloured again.
        colour_shift: bool,
    },
    /// Metal, or a diffuse body under a dielectric coat, or a mixture of both: the material of
    /// glTF; see [`MetallicRoughness`].
    MetallicRoughness {
        /// Reflectance of the metal at normal incidence, and albedo of the body, 0 to 1.
        base_color: Texture,
        /// Roughness (the root of α) in green, metalness in blue, each 0 to 1. Red has no meaning.
        metallic_roughness: Texture,
        /// Index of refraction of the coat over that of the outside.
        relative_ior: f64,
    },
    /// A rough mirror with the same reflectance at all angles: GGX.
    RoughMirror {
        /// Reflected fraction, 0 to 1.
        reflectance: Rgb,
        /// Roughness along the tangent and across it.
        alpha: DVec2,
    },
    /// Rough metal: GGX.
    RoughConductor {
        /// Real part of the index of refraction, relative to the outside.
        eta: Rgb,
        /// Imaginary part.
        k: Rgb,
        /// Roughness along the tangent and across it.
        alpha: DVec2,
    },
    /// Frosted glass: GGX.
    RoughDielectric {
        /// Index of refraction of the inside over that of the outside.
        relative_ior: f64,
        /// Roughness along the tangent and across it.
        alpha: DVec2,
    },
    /// A rough mirror, rough metal or frosted glass with Beckmann's distribution in place of GGX.
    Beckmann {
        /// One of the three.
        rough: Box<Material>,
    },
    /// A material in a colour: its BSDF is multiplied by a texture. Over a white Lambertian
    /// reflector that is a textured one.
    Tinted {
        /// The material.
        material: Box<Material>,
        /// The factor, 0 to 1.
        tint: Texture,
    },
    /// Two materials, one for the front and one for the back, each showing its own front. Neither
    /// transmits light.
    Sided {
        /// Seen from the side that the normal points to.
        front: Box<Material>,
        /// Seen from the other side.
        back: Box<Material>,
    },
    /// A blend of two of the others that may vary over the surface.
    Blend {
        /// The two; neither of them a mixture or a blend.
        components: Box<[Material; 2]>,
        /// Its luminance, 0 to 1, is the weight of the second; the rest of 1 is that of the first.
        amount: Texture,
    },
    /// A weighted sum of two of the others.
    Mixture {
        /// The two; neither of them a mixture.
        components: Box<[Material; 2]>,
        /// Their weights; a sum of at most 1 conserves energy.
        weights: [f64; 2],
    },
}

impl Material {
    /// Absorbs on its back what would otherwise be scattered on both sides.
    #[must_use]
    pub fn one_sided(self) -> Self {
        Self::Sided { front: Box::new(self), back: Box::new(Self::Black) }
    }

    /// The same material in a colour.
    #[must_use]
    pub fn tinted(self, tint: impl Into<Texture>) -> Self {
        Self::Tinted { material: Box::new(self), tint: tint.into() }
    }

    /// Checks the parameters and makes the model of the front at uv = (0, 0).
    ///
    /// # Errors
    /// If a parameter is outside its range, a component of a mixture is a mixture, or a material
    /// with two different sides transmits light.
    pub fn model(&self) -> Result<Model, BsdfError> {
        Ok(match self.scattering()? {
            Scattering::Uniform(model) => model,
            Scattering::Varying(sides) => sides.stacks[0].at(DVec2::ZERO),
        })
    }

    /// Checks the parameters.
    pub(crate) fn scattering(&self) -> Result<Scattering, BsdfError> {
        match self {
            // Its probabilities are its weights, which need not sum to 1.
            Self::Mixture { components, weights } if components.iter().all(Self::is_simple) => {
                let components = [components[0].simple_model()?, components[1].simple_model()?];
                Ok(Scattering::Uniform(Model::Mixture(Mixture::new(components, *weights)?)))
            }
            _ if self.is_simple() => {
                self.simple_model().map(|model| Scattering::Uniform(model.into()))
            }
            _ => Ok(Scattering::new(self.side(true)?, self.side(false)?)),
        }
    }

    fn is_simple(&self) -> bool {
        match self {
            Self::Plastic { albedo, .. } => albedo.as_constant().is_some(),
            Self::MetallicRoughness { base_color, metallic_roughness, .. } => {
                base_color.as_constant().is_some() && metallic_roughness.as_constant().is_some()
            }
            _ => !matches!(
                self,
                Self::Tinted { .. }
                    | Self::Sided { .. }
                    | Self::Blend { .. }
                    | Self::Mixture { .. }
            ),
        }
    }

    /// What is seen from one side.
    fn side(&self, front: bool) -> Result<Stack, BsdfError> {
        let alone = |model: LayerModel| Stack {
            layers: vec![Layer { model, tints: Vec::new() }],
            mix: Mix::Weights([1.0, 0.0]),
        };
        match self {
            Self::Tinted { material, tint } => {
                checked_colours(tint)?;
                let mut stack = material.side(front)?;
                stack.layers.iter_mut().for_each(|layer| layer.tints.push(tint.clone()));
                Ok(stack)
            }
            Self::Sided { front: outer, back: inner } => {
                // Each shows its own front.
                let stacks = [outer.side(true)?, inner.side(true)?];
                let transmits = |stack: &Stack| {
                    stack
                        .layers
                        .iter()
                        .any(|layer| layer.model.lobes().intersects(Lobes::TRANSMISSION))
                };
                if stacks.iter().any(transmits) {
                    return Err(BsdfError::SidedTransmission);
                }
                let [outer, inner] = stacks;
                Ok(if front { outer } else { inner })
            }
            Self::Mixture { components, weights } => {
                // Checks the weights.
                Mixture::new([SimpleModel::Black; 2], *weights)?;
                Self::two_layers(components, front, Mix::Weights(*weights))
            }
            Self::Blend { components, amount } => {
                checked_colours(amount)?;
                Self::two_layers(components, front, Mix::Amount(amount.clone()))
            }
            Self::Plastic { albedo, specular, relative_ior, colour_shift } if !self.is_simple() => {
                checked_colours(albedo)?;
                // The brightest, so that the lobes are those that some point has.
                let plastic =
                    Plastic::new(albedo.range()[1], *specular, *relative_ior, *colour_shift)?;
                Ok(alone(LayerModel::Plastic(plastic, albedo.clone())))
            }
            Self::MetallicRoughness { base_color, metallic_roughness, relative_ior }
                if !self.is_simple() =>
            {
                checked_colours(base_color)?;
                let [least, greatest] = metallic_roughness.range();
                let coat = MetallicRoughness::coat(*relative_ior)?;
                for extreme in [least, greatest] {
                    MetallicRoughness::new(Rgb::BLACK, extreme.b(), extreme.g(), *relative_ior)?;
                }
                let (base_color, surface) = (base_color.clone(), metallic_roughness.clone());
                Ok(alone(LayerModel::MetallicRoughness { base_color, surface, coat }))
            }
            _ => Ok(alone(LayerModel::Uniform(self.simple_model()?))),
        }
    }

    fn two_layers(components: &[Self; 2], front: bool, mix: Mix) -> Result<Stack, BsdfError> {
        let mut layers = Vec::with_capacity(2);
        for component in components {
            let mut stack = component.side(front)?;
            layers.append(&mut stack.layers);
        }
        if layers.len() == 2 { Ok(Stack { layers, mix }) } else { Err(BsdfError::NestedMixture) }
    }

    fn simple_model(&self) -> Result<SimpleModel, BsdfError> {
        let ggx = |alpha: &DVec2| Ggx::new(alpha.x, alpha.y).map(Microfacets::Ggx);
        match self {
            Self::Beckmann { rough } => {
                let beckmann =
                    |alpha: &DVec2| Beckmann::new(alpha.x, alpha.y).map(Microfacets::Beckmann);
                rough.rough_model(beckmann)?.ok_or(BsdfError::NotRough)
            }
            Self::Black => Ok(SimpleModel::Black),
            Self::Null => Ok(SimpleModel::Null(Null)),
            Self::Lambert { albedo } => Lambert::new(*albedo).map(SimpleModel::Lambert),
            Self::Mirror { reflectance } => Mirror::new(*reflectance).map(SimpleModel::Mirror),
            Self::Conductor { eta, k } => Conductor::new(*eta, *k).map(SimpleModel::Conductor),
            Self::Dielectric { relative_ior } => {
                Dielectric::new(*relative_ior).map(SimpleModel::Dielectric)
            }
            Self::ThinDielectric { relative_ior } => {
                ThinDielectric::new(*relative_ior).map(SimpleModel::ThinDielectric)
            }
            Self::Plastic { albedo, specular, relative_ior, colour_shift } => {
                Plastic::new(albedo.range()[1], *specular, *relative_ior, *colour_shift)
                    .map(SimpleModel::Plastic)
            }
            Self::MetallicRoughness { base_color, metallic_roughness, relative_ior } => {
                let [_, roughness, metalness] = metallic_roughness.range()[1].0;
                MetallicRoughness::new(base_color.range()[1], metalness, roughness, *relative_ior)
                    .map(SimpleModel::MetallicRoughness)
            }
            // Everything else is made of others.
            _ => self.rough_model(ggx)?.ok_or(BsdfError::NestedMixture),
        }
    }

    /// The model of a rough material with the given distribution; `None` if it is none.
    fn rough_model(
        &self,
        distribution: impl Fn(&DVec2) -> Result<Microfacets, BsdfError>,
    ) -> Result<Option<SimpleModel>, BsdfError> {
        Ok(Some(match self {
            Self::RoughMirror { reflectance, alpha } => {
                RoughConductor::new(Reflectance::constant(*reflectance)?, distribution(alpha)?)
                    .into()
            }
            Self::RoughConductor { eta, k, alpha } => {
                RoughConductor::new(Reflectance::conductor(*eta, *k)?, distribution(alpha)?).into()
            }
            Self::RoughDielectric { relative_ior, alpha } => {
                RoughDielectric::new(*relative_ior, distribution(alpha)?)?.into()
            }
            _ => return Ok(None),
        }))
    }
}

/// Checks that a texture's colours are reflectances or weights.
fn checked_colours(texture: &Texture) -> Result<(), BsdfError> {
    let [least, greatest] = texture.range();
    if texture.is_within(0.0, 1.0) {
        return Ok(());
    }
    let outside = |colour: &Rgb| !colour.0.iter().all(|c| (0.0..=1.0).contains(c));
    Err(BsdfError::Reflectance(if outside(&least) { least } else { greatest }))
}
