//! Materials as integrators meet them: the model at a point, with textures looked up there and with the side that is seen.

use crate::bsdf::{Bsdf, BsdfSample, DiracValue, Lobes, Mixture, Model, Plastic, SimpleModel, Walk};
use crate::math::{PerProjected, Rgb};
use crate::texture::Texture;
use glam::{DVec2, DVec3};

/// A checked material.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Scattering {
    /// The same everywhere and on both sides.
    Uniform(Model),
    /// What is seen from the front and from the back. Both transmit the same, or nothing.
    Varying(Box<[Stack; 2]>),
}

/// One or two layers that are mixed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stack {
    pub layers: Vec<Layer>,
    pub mix: Mix,
}

/// A model whose colours may vary.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layer {
    pub model: SimpleModel,
    /// Albedo of plastic's body.
    pub albedo: Option<Texture>,
    /// Factors of the BSDF.
    pub tints: Vec<Texture>,
}

/// How two layers are mixed; ignored if there is one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mix {
    /// Their weights.
    Weights([f64; 2]),
    /// The luminance is the weight of the second, the rest of 1 that of the first.
    Amount(Texture),
}

impl Layer {
    fn model(&self, uv: DVec2) -> SimpleModel {
        match (&self.model, &self.albedo) {
            (SimpleModel::Plastic(plastic), Some(albedo)) => Plastic::with_albedo(*plastic, albedo.at(uv)).into(),
            (model, _) => *model,
        }
    }

    fn tint(&self, uv: DVec2) -> Rgb {
        self.tints.iter().fold(Rgb::WHITE, |product, tint| product * tint.at(uv))
    }

    fn is_uniform(&self) -> bool {
        self.albedo.is_none() && self.tints.iter().all(|tint| tint.as_constant().is_some())
    }
}

impl Stack {
    /// The model at a point.
    pub fn at(&self, uv: DVec2) -> Model {
        match &self.layers[..] {
            [only] if only.tints.is_empty() => only.model(uv).into(),
            [only] => Mixture::of_valid([only.model(uv)], [only.tint(uv)], [1.0]).into(),
            [first, second, ..] => {
                let weights = match &self.mix {
                    Mix::Weights(weights) => *weights,
                    Mix::Amount(amount) => {
                        let amount = amount.at(uv).luminance().clamp(0.0, 1.0);
                        [1.0 - amount, amount]
                    }
                };
                let colours = [first.tint(uv) * weights[0], second.tint(uv) * weights[1]];
                let total = weights[0] + weights[1];
                Mixture::of_valid([first.model(uv), second.model(uv)], colours, weights.map(|weight| weight / total)).into()
            }
            [] => Model::BLACK,
        }
    }

    fn is_uniform(&self) -> bool {
        let fixed = match &self.mix {
            Mix::Weights(_) => true,
            Mix::Amount(amount) => amount.as_constant().is_some(),
        };
        fixed && self.layers.iter().all(Layer::is_uniform)
    }

    fn lobes(&self) -> Lobes {
        self.layers.iter().fold(Lobes::NONE, |lobes, layer| lobes | layer.model.lobes())
    }
}

impl Scattering {
    /// Absorbs everything.
    pub const BLACK: Self = Self::Uniform(Model::BLACK);

    pub fn new(front: Stack, back: Stack) -> Self {
        if front == back && front.is_uniform() {
            return Self::Uniform(front.at(DVec2::ZERO));
        }
        Self::Varying(Box::new([front, back]))
    }

    /// The lobes of both sides, anywhere.
    pub fn lobes(&self) -> Lobes {
        match self {
            Self::Uniform(model) => model.lobes(),
            Self::Varying(sides) => sides[0].lobes() | sides[1].lobes(),
        }
    }

    /// Whether it differs from point to point.
    pub fn is_textured(&self) -> bool {
        match self {
            Self::Uniform(_) => false,
            Self::Varying(sides) => !sides.iter().all(Stack::is_uniform),
        }
    }
}

/// How one point of a [`World`](super::World) scatters. Textures are looked up when it is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceBsdf<'a> {
    scattering: &'a Scattering,
    uv: DVec2,
}

impl<'a> SurfaceBsdf<'a> {
    pub(super) fn new(scattering: &'a Scattering, uv: DVec2) -> Self {
        Self { scattering, uv }
    }

    /// The model at this point, seen from the front or from the back.
    #[must_use]
    pub fn model(&self, front: bool) -> Model {
        match self.scattering {
            Scattering::Uniform(model) => *model,
            Scattering::Varying(sides) => sides[usize::from(!front)].at(self.uv),
        }
    }

    /// Asks the model on a direction's side.
    #[inline]
    fn ask<R>(&self, direction: DVec3, question: impl FnOnce(&Model) -> R) -> R {
        match self.scattering {
            Scattering::Uniform(model) => question(model),
            Scattering::Varying(_) => question(&self.model(direction.z >= 0.0)),
        }
    }
}

impl Bsdf for SurfaceBsdf<'_> {
    #[inline]
    fn lobes(&self) -> Lobes {
        self.scattering.lobes()
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.ask(to_camera, |model| model.eval(to_light, to_camera))
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, walk: Walk) -> PerProjected {
        self.ask(fixed, |model| model.pdf(fixed, next, walk))
    }

    #[inline]
    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        self.ask(fixed, |model| model.sample(fixed, walk, u1, u2))
    }

    #[inline]
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        self.ask(to_camera, |model| model.eval_dirac(to_light, to_camera))
    }
}
