//! The models of this crate behind one type, without indirection.

use super::{
    Bsdf, BsdfSample, Conductor, Dielectric, DiracValue, Lambert, Lobes, MetallicRoughness, Mirror,
    Mixture, Null, Plastic, RoughConductor, RoughDielectric, ThinDielectric, Walk,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// Every model that is not made of others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SimpleModel {
    /// Absorbs everything, such as the surface of a light that reflects nothing.
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
    /// Metal, or a diffuse body under a dielectric coat.
    MetallicRoughness(MetallicRoughness),
    /// Rough metal.
    RoughConductor(RoughConductor),
    /// Frosted glass.
    RoughDielectric(RoughDielectric),
}

/// Every model, a blend of two among them. Larger mixtures are a [`Mixture`] of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Model {
    /// One model.
    Simple(SimpleModel),
    /// One model in a colour.
    Tinted(Mixture<SimpleModel, 1>),
    /// A weighted sum of two.
    Mixture(Mixture<SimpleModel, 2>),
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
            Self::MetallicRoughness($bsdf) => $scatters,
            Self::RoughConductor($bsdf) => $scatters,
            Self::RoughDielectric($bsdf) => $scatters,
        }
    };
}

impl Bsdf for SimpleModel {
    #[inline]
    fn lobes(&self) -> Lobes {
        dispatch!(self, bsdf => bsdf.lobes(), black => Lobes::NONE)
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        dispatch!(self, bsdf => bsdf.eval(to_light, to_camera), black => Rgb::BLACK)
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, walk: Walk) -> PerProjected {
        dispatch!(self, bsdf => bsdf.pdf(fixed, next, walk), black => PerProjected::ZERO)
    }

    #[inline]
    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        dispatch!(self, bsdf => bsdf.sample(fixed, walk, u1, u2), black => None)
    }

    #[inline]
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        dispatch!(self, bsdf => bsdf.eval_dirac(to_light, to_camera), black => DiracValue::default())
    }

    /// Roughness alone has directions.
    #[inline]
    fn is_anisotropic(&self) -> bool {
        self.lobes().intersects(Lobes::GLOSSY)
    }
}

impl Bsdf for Model {
    #[inline]
    fn lobes(&self) -> Lobes {
        match self {
            Self::Simple(bsdf) => bsdf.lobes(),
            Self::Tinted(bsdf) => bsdf.lobes(),
            Self::Mixture(bsdf) => bsdf.lobes(),
        }
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        match self {
            Self::Simple(bsdf) => bsdf.eval(to_light, to_camera),
            Self::Tinted(bsdf) => bsdf.eval(to_light, to_camera),
            Self::Mixture(bsdf) => bsdf.eval(to_light, to_camera),
        }
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, walk: Walk) -> PerProjected {
        match self {
            Self::Simple(bsdf) => bsdf.pdf(fixed, next, walk),
            Self::Tinted(bsdf) => bsdf.pdf(fixed, next, walk),
            Self::Mixture(bsdf) => bsdf.pdf(fixed, next, walk),
        }
    }

    #[inline]
    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        match self {
            Self::Simple(bsdf) => bsdf.sample(fixed, walk, u1, u2),
            Self::Tinted(bsdf) => bsdf.sample(fixed, walk, u1, u2),
            Self::Mixture(bsdf) => bsdf.sample(fixed, walk, u1, u2),
        }
    }

    #[inline]
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        match self {
            Self::Simple(bsdf) => bsdf.eval_dirac(to_light, to_camera),
            Self::Tinted(bsdf) => bsdf.eval_dirac(to_light, to_camera),
            Self::Mixture(bsdf) => bsdf.eval_dirac(to_light, to_camera),
        }
    }

    #[inline]
    fn is_anisotropic(&self) -> bool {
        self.lobes().intersects(Lobes::GLOSSY)
    }
}

impl Model {
    /// Absorbs everything.
    pub const BLACK: Self = Self::Simple(SimpleModel::Black);
}

macro_rules! from_model {
    ($($model:ident),*) => {$(
        impl From<$model> for SimpleModel {
            fn from(model: $model) -> Self {
                Self::$model(model)
            }
        }

        impl From<$model> for Model {
            fn from(model: $model) -> Self {
                Self::Simple(model.into())
            }
        }
    )*};
}

from_model!(
    Null,
    Lambert,
    Mirror,
    Conductor,
    Dielectric,
    ThinDielectric,
    Plastic,
    MetallicRoughness,
    RoughConductor,
    RoughDielectric
);

impl From<SimpleModel> for Model {
    fn from(model: SimpleModel) -> Self {
        Self::Simple(model)
    }
}

impl From<Mixture<SimpleModel, 1>> for Model {
    fn from(tinted: Mixture<SimpleModel, 1>) -> Self {
        Self::Tinted(tinted)
    }
}

impl From<Mixture<SimpleModel, 2>> for Model {
    fn from(mixture: Mixture<SimpleModel, 2>) -> Self {
        Self::Mixture(mixture)
    }
}
