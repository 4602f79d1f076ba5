//! The models of this crate behind one type, without indirection.

use super::{
    Bsdf, BsdfSample, Coated, Conductor, Dielectric, Lambert, LaneForm, Lobes, MetallicRoughness,
    Mirror, Null, Plastic, Principled, RoughConductor, RoughDielectric, RoughPlastic,
    ThinDielectric, TransportMode,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// Every model that is not made of others; a [`Mixture`](super::Mixture) is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Model {
    /// Absorbs everything, such as the surface of a light that reflects nothing.
    #[default]
    Black,
    /// Lets everything pass straight through.
    Null(Null),
    /// Diffuse reflection.
    Lambert(Lambert),
    /// Perfect mirror.
    Mirror(Mirror),
    /// Polished metal.
    Conductor(Conductor),
    /// Clear glass.
    Dielectric(Dielectric),
    /// A pane of clear glass.
    ThinDielectric(ThinDielectric),
    /// A diffuse body under a clear coat.
    Plastic(Plastic),
    /// Body, main reflection, refraction, clear coat and sheen.
    Principled(Principled),
    /// Metal, or a diffuse body under a dielectric coat.
    MetallicRoughness(MetallicRoughness),
    /// The same under a clear coat.
    Coated(Coated<MetallicRoughness>),
    /// Rough metal.
    RoughConductor(RoughConductor),
    /// Frosted glass.
    RoughDielectric(RoughDielectric),
    /// A diffuse body under a rough coat.
    RoughPlastic(RoughPlastic),
}

impl Model {
    /// The same glass which lets through only a part, 0 to 1, of what it does not reflect; other
    /// models are the same.
    pub(crate) fn stained(self, share: Rgb) -> Self {
        match self {
            Self::Dielectric(glass) => glass.stained(share).into(),
            Self::ThinDielectric(pane) => pane.stained(share).into(),
            Self::RoughDielectric(glass) => glass.stained(share).into(),
            other => other,
        }
    }

    /// The same model with other roughnesses, at most 10; `None` if it has none that can vary.
    pub(crate) fn with_roughness(&self, alpha_x: f64, alpha_y: f64) -> Option<Self> {
        match self {
            Self::RoughConductor(metal) => Some(metal.with_roughness(alpha_x, alpha_y).into()),
            Self::RoughDielectric(glass) => Some(glass.with_roughness(alpha_x, alpha_y).into()),
            _ => None,
        }
    }
}

/// Runs an expression on the concrete model; black surfaces get the other expression.
macro_rules! dispatch {
    ($model:expr, $bsdf:ident => $scatters:expr, black => $absorbs:expr) => {
        match $model {
            Self::Black => $absorbs,
            Self::Null($bsdf) => $scatters,
            Self::Lambert($bsdf) => $scatters,
            Self::Mirror($bsdf) => $scatters,
            Self::Conductor($bsdf) => $scatters,
            Self::Dielectric($bsdf) => $scatters,
            Self::ThinDielectric($bsdf) => $scatters,
            Self::Plastic($bsdf) => $scatters,
            Self::Principled($bsdf) => $scatters,
            Self::MetallicRoughness($bsdf) => $scatters,
            Self::Coated($bsdf) => $scatters,
            Self::RoughConductor($bsdf) => $scatters,
            Self::RoughDielectric($bsdf) => $scatters,
            Self::RoughPlastic($bsdf) => $scatters,
        }
    };
}

impl Bsdf for Model {
    #[inline]
    fn lobes(&self) -> Lobes {
        dispatch!(self, bsdf => bsdf.lobes(), black => Lobes::NONE)
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        dispatch!(self, bsdf => bsdf.eval(to_light, to_camera), black => Rgb::BLACK)
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        dispatch!(self, bsdf => bsdf.pdf(fixed, next, mode), black => PerProjected::ZERO)
    }

    #[inline]
    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let nothing = (Rgb::BLACK, PerProjected::ZERO);
        dispatch!(self, bsdf => bsdf.eval_and_pdf(to_light, to_camera), black => nothing)
    }

    #[inline]
    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        dispatch!(self, bsdf => bsdf.sample(fixed, mode, u1, u2), black => None)
    }

    #[inline]
    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        dispatch!(self, bsdf => bsdf.dirac_images(fixed, mode, image), black => {});
    }

    #[inline]
    fn lane_form(&self, front: bool) -> Option<LaneForm> {
        dispatch!(self, bsdf => bsdf.lane_form(front), black => Some(LaneForm::Black))
    }
}

macro_rules! from_model {
    ($($model:ident),*) => {$(
        impl From<$model> for Model {
            fn from(model: $model) -> Self {
                Self::$model(model)
            }
        }
    )*};
}

impl From<Coated<MetallicRoughness>> for Model {
    fn from(model: Coated<MetallicRoughness>) -> Self {
        Self::Coated(model)
    }
}

from_model!(
    Null,
    Lambert,
    Mirror,
    Conductor,
    Dielectric,
    ThinDielectric,
    Plastic,
    Principled,
    MetallicRoughness,
    RoughConductor,
    RoughDielectric,
    RoughPlastic
);
