//! Materials: what a scene is told about how a surface scatters, checked and made a model when it is added.

use crate::bsdf::{
    BsdfError, Conductor, Dielectric, Ggx, Lambert, Mirror, Mixture, Model, Null, Reflectance, RoughConductor, RoughDielectric, SimpleModel,
};
use crate::math::Rgb;
use glam::DVec2;

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
    /// A weighted sum of two of the others.
    Mixture {
        /// The two; neither of them a mixture.
        components: Box<[Material; 2]>,
        /// Their weights; a sum of at most 1 conserves energy.
        weights: [f64; 2],
    },
}

impl Material {
    /// Checks the parameters and makes the model.
    ///
    /// # Errors
    /// If a parameter is outside its range, or a component of a mixture is a mixture.
    pub fn model(&self) -> Result<Model, BsdfError> {
        match self {
            Self::Mixture { components, weights } => {
                let components = [components[0].simple_model()?, components[1].simple_model()?];
                Ok(Model::Mixture(Mixture::new(components, *weights)?))
            }
            _ => self.simple_model().map(Model::Simple),
        }
    }

    fn simple_model(&self) -> Result<SimpleModel, BsdfError> {
        let ggx = |alpha: &DVec2| Ggx::new(alpha.x, alpha.y);
        Ok(match self {
            Self::Black => SimpleModel::Black,
            Self::Null => SimpleModel::Null(Null),
            Self::Lambert { albedo } => SimpleModel::Lambert(Lambert::new(*albedo)?),
            Self::Mirror { reflectance } => SimpleModel::Mirror(Mirror::new(*reflectance)?),
            Self::Conductor { eta, k } => SimpleModel::Conductor(Conductor::new(*eta, *k)?),
            Self::Dielectric { relative_ior } => SimpleModel::Dielectric(Dielectric::new(*relative_ior)?),
            Self::RoughMirror { reflectance, alpha } => {
                SimpleModel::RoughConductor(RoughConductor::new(Reflectance::constant(*reflectance)?, ggx(alpha)?))
            }
            Self::RoughConductor { eta, k, alpha } => {
                SimpleModel::RoughConductor(RoughConductor::new(Reflectance::conductor(*eta, *k)?, ggx(alpha)?))
            }
            Self::RoughDielectric { relative_ior, alpha } => {
                SimpleModel::RoughDielectric(RoughDielectric::new(*relative_ior, ggx(alpha)?)?)
            }
            Self::Mixture { .. } => return Err(BsdfError::NestedMixture),
        })
    }
}
