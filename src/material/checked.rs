//! Checks of descriptions, which make materials of them.

use super::finish::{Finish, Layer, Share, is_alone};
use super::{Material, SurfaceBsdf, Texture};
use crate::bsdf::{
    Beckmann, BsdfError, Coated, Conductor, Dielectric, GREATEST_ALPHA, Ggx, INDEX_MATCHED,
    Lambert, Lobes, MetallicRoughness, Microfacets, Mirror, Mixture, Model, Null, Plastic,
    Principled, Reflectance, RoughConductor, RoughDielectric, RoughPlastic, ThinDielectric,
};
use crate::math::Rgb;
use glam::DVec2;

impl Material {
    /// The models of the front at uv = (0, 0) and how they are mixed (one alone has the weight 1);
    /// `None` for a BSDF of a user's own.
    ///
    /// # Errors
    /// If a parameter is outside its range, a component of a mixture is a mixture or a BSDF of a
    /// user's own, or a material with two different sides transmits light.
    pub fn mixture(&self) -> Result<Option<Mixture<Model, 2>>, BsdfError> {
        self.finish().map(|finish| SurfaceBsdf::new(&finish, DVec2::ZERO, || None).mixture(true))
    }

    /// Checks the parameters.
    pub(crate) fn finish(&self) -> Result<Finish, BsdfError> {
        match self {
            Self::Custom(bsdf) => Ok(Finish::Custom(bsdf.clone())),
            Self::Culled { front } => Ok(Finish::Culled(Box::new(front.finish()?))),
            _ => Ok(Finish::of_sides([self.side(true)?, self.side(false)?])),
        }
    }

    /// The layers that are seen from one side.
    fn side(&self, front: bool) -> Result<[Layer; 2], BsdfError> {
        let alone = |layer: Layer| Ok([layer, Layer::nothing()]);
        match self {
            Self::Tinted { material, tint } => {
                checked_colours(tint)?;
                let mut layers = material.side(front)?;
                layers.iter_mut().for_each(|layer| layer.tints.push(tint.clone()));
                Ok(layers)
            }
            Self::Stained { glass, stain } => {
                checked_colours(stain)?;
                let mut layers = glass.side(front)?;
                for layer in &mut layers {
                    match stain.as_constant() {
                        Some(share) => layer.model = layer.model.stained(share),
                        None => layer.stains.push(stain.clone()),
                    }
                }
                Ok(layers)
            }
            Self::Sided { front: outer, back: inner } => {
                // Each shows its own front.
                let sides = [outer.side(true)?, inner.side(true)?];
                let transmits = |layer: &Layer| layer.lobes().intersects(Lobes::TRANSMISSION);
                if sides.as_flattened().iter().any(transmits) {
                    return Err(BsdfError::SidedTransmission);
                }
                let [outer, inner] = sides;
                Ok(if front { outer } else { inner })
            }
            Self::Mixture { components, weights } => {
                // Checks the weights.
                Mixture::new([Model::Black; 2], *weights)?;
                Self::two_layers(components, front, weights.map(Share::Constant))
            }
            Self::Blend { components, amount } => {
                checked_colours(amount)?;
                let shares = [Share::Rest(amount.clone()), Share::Amount(amount.clone())];
                Self::two_layers(components, front, shares)
            }
            Self::MetallicRoughness { base_color, metallic_roughness, .. } => {
                checked_colours(base_color)?;
                let textures = vec![base_color.clone(), metallic_roughness.clone()];
                alone(Layer::varying_in(self.model()?, textures))
            }
            Self::Coated { base_color, metallic_roughness, coat, .. } => {
                checked_colours(base_color)?;
                let mut textures = vec![base_color.clone(), metallic_roughness.clone()];
                textures.extend(coat.iter().cloned());
                alone(Layer::varying_in(self.model()?, textures))
            }
            Self::Principled { base_color, metalness, roughness, .. } => {
                let textures = vec![base_color.clone(), metalness.clone(), roughness.clone()];
                textures.iter().try_for_each(checked_colours)?;
                alone(Layer::varying_in(self.model()?, textures))
            }
            Self::VaryingRoughness { rough, alpha } => {
                let [x, y] = alpha.each_ref().map(|texture| texture.range()[1].luminance());
                if alpha.iter().any(|texture| !texture.is_within(0.0, GREATEST_ALPHA)) {
                    return Err(BsdfError::Roughness(x, y));
                }
                let model = rough.model()?.with_roughness(x, y).ok_or(BsdfError::NotRough)?;
                alone(Layer { textures: alpha.to_vec(), ..Layer::alone(model) })
            }
            _ => {
                // Of the brightest albedo, so that the lobes are those that some point has.
                let model = Layer::alone(self.model()?);
                let albedo = self.body().filter(|albedo| albedo.as_constant().is_none());
                albedo.map_or(Ok(()), checked_colours)?;
                alone(Layer { textures: albedo.into_iter().cloned().collect(), ..model })
            }
        }
    }

    /// The albedo of the body under a coat.
    fn body(&self) -> Option<&Texture> {
        match self {
            Self::Plastic { albedo, .. } | Self::RoughPlastic { albedo, .. } => Some(albedo),
            Self::Beckmann { rough } | Self::IndependentMasking { rough } => rough.body(),
            _ => None,
        }
    }

    fn two_layers(
        components: &[Self; 2],
        front: bool,
        shares: [Share; 2],
    ) -> Result<[Layer; 2], BsdfError> {
        let [first, second] = [components[0].side(front)?, components[1].side(front)?];
        if !(is_alone(&first) && is_alone(&second)) {
            return Err(BsdfError::NestedMixture);
        }
        let ([first, _], [second, _]) = (first, second);
        let [share, other_share] = shares;
        Ok([Layer { share, ..first }, Layer { share: other_share, ..second }])
    }

    /// The model, of the largest values that textures have.
    fn model(&self) -> Result<Model, BsdfError> {
        let ggx = |alpha: &DVec2| Ggx::new(alpha.x, alpha.y).map(Microfacets::Ggx);
        match self {
            Self::Beckmann { rough } => {
                let beckmann =
                    |alpha: &DVec2| Beckmann::new(alpha.x, alpha.y).map(Microfacets::Beckmann);
                rough.rough_model(&beckmann)?.ok_or(BsdfError::NotRough)
            }
            Self::Black => Ok(Model::Black),
            Self::Null => Ok(Model::Null(Null)),
            Self::Lambert { albedo } => Lambert::new(*albedo).map(Model::Lambert),
            Self::Mirror { reflectance } => Mirror::new(*reflectance).map(Model::Mirror),
            Self::Conductor { eta, k } => Conductor::new(*eta, *k).map(Model::Conductor),
            Self::Dielectric { relative_ior } => {
                Dielectric::new(*relative_ior).map(Model::Dielectric)
            }
            Self::ThinDielectric { relative_ior } => {
                ThinDielectric::new(*relative_ior).map(Model::ThinDielectric)
            }
            Self::Plastic { albedo, specular, relative_ior, colour_shift } => {
                Plastic::new(albedo.range()[1], *specular, *relative_ior, *colour_shift)
                    .map(Model::Plastic)
            }
            Self::MetallicRoughness { base_color, metallic_roughness, relative_ior } => {
                let color = base_color.range()[1];
                greatest_metallic_roughness(color, metallic_roughness, *relative_ior)
                    .map(Model::MetallicRoughness)
            }
            Self::Coated { base_color, metallic_roughness, relative_ior, coat } => {
                let color = base_color.range()[1];
                let base = greatest_metallic_roughness(color, metallic_roughness, *relative_ior)?;
                let [share, roughness] = coat.each_ref().map(Texture::range);
                Coated::new(base, share[0].r(), roughness[0].g())?;
                Coated::new(base, share[1].r(), roughness[1].g()).map(Model::Coated)
            }
            Self::Principled { base_color, metalness, roughness, lobes } => {
                // Of the least metal, so that the lobes are those that some point has.
                let share = |colour: Rgb| colour.luminance().min(1.0);
                let (metalness, roughness) =
                    (share(metalness.range()[0]), share(roughness.range()[1]));
                Principled::new(base_color.range()[1], metalness, roughness, **lobes)
                    .map(Model::Principled)
            }
            Self::Custom(_) => Err(BsdfError::NestedCustom),
            // Everything else is made of others.
            _ => self.rough_model(&ggx)?.ok_or(BsdfError::NestedMixture),
        }
    }

    /// The model of a rough material with the given distribution; `None` if it is none.
    fn rough_model(
        &self,
        distribution: &dyn Fn(&DVec2) -> Result<Microfacets, BsdfError>,
    ) -> Result<Option<Model>, BsdfError> {
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
            Self::RoughPlastic { albedo, specular, relative_ior, colour_shift, alpha } => {
                let (albedo, n) = (albedo.range()[1], *relative_ior);
                let distribution = distribution(&DVec2::splat(*alpha))?;
                if distribution.is_smooth() || n - 1.0 < INDEX_MATCHED {
                    Plastic::new(albedo, *specular, n, *colour_shift)?.into()
                } else {
                    RoughPlastic::new(albedo, *specular, n, *colour_shift, distribution)?.into()
                }
            }
            Self::IndependentMasking { rough } => {
                let independent =
                    |alpha: &DVec2| distribution(alpha).map(Microfacets::with_independent_masking);
                return rough.rough_model(&independent)?.ok_or(BsdfError::NotRough).map(Some);
            }
            _ => return Ok(None),
        }))
    }
}

/// The model of the largest values of a texture, of which the smallest are checked, too.
fn greatest_metallic_roughness(
    base_color: Rgb,
    surface: &Texture,
    relative_ior: f64,
) -> Result<MetallicRoughness, BsdfError> {
    let [least, greatest] = surface
        .range()
        .map(|extreme| MetallicRoughness::new(base_color, extreme.b(), extreme.g(), relative_ior));
    least.and(greatest)
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
