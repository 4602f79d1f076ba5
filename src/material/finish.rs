//! Checked materials: models, and the layers that models are made of where colours vary or sides
//! differ.

use super::{CustomBsdf, Texture};
use crate::bsdf::{Bsdf, LEAST_ALPHA, Lobes, Mixture, Model};
use crate::math::Rgb;
use glam::DVec2;

/// A checked material.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "the usual variants must not be behind another pointer"
)]
pub(crate) enum Finish {
    /// One model, the same everywhere and on both sides.
    Model(Model),
    /// Two models, or one in a colour; the same everywhere and on both sides.
    Mixture(Mixture<Model, 2>),
    /// The layers that are seen from the front and from the back. Both transmit the same, or
    /// nothing.
    Layers {
        sides: Box<[[Layer; 2]; 2]>,
        /// The lobes of both sides, anywhere.
        lobes: Lobes,
    },
    /// A BSDF of a user's own.
    Custom(CustomBsdf),
}

/// A model whose colours may vary, and what share it has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layer {
    pub model: Model,
    /// The textures in place of the model's own colours: the albedo of plastic's body; of
    /// metallic-roughness its base colour, and roughness in green with metalness in blue.
    pub textures: Vec<Texture>,
    /// Factors of the BSDF.
    pub tints: Vec<Texture>,
    pub share: Share,
}

/// The weight of one of two layers; its share of the sum is the probability of sampling it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Share {
    Constant(f64),
    /// The luminance of a texture.
    Amount(Texture),
    /// 1 minus that luminance.
    Rest(Texture),
}

impl Share {
    fn at(&self, uv: DVec2) -> f64 {
        let luminance = |amount: &Texture| amount.at(uv).luminance().clamp(0.0, 1.0);
        match self {
            Self::Constant(weight) => *weight,
            Self::Amount(amount) => luminance(amount),
            Self::Rest(amount) => 1.0 - luminance(amount),
        }
    }

    fn is_uniform(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Amount(amount) | Self::Rest(amount) => amount.as_constant().is_some(),
        }
    }
}

impl Layer {
    /// A model alone.
    pub fn alone(model: impl Into<Model>) -> Self {
        Self {
            model: model.into(),
            textures: Vec::new(),
            tints: Vec::new(),
            share: Share::Constant(1.0),
        }
    }

    /// The empty layer beside a model that is alone.
    pub fn nothing() -> Self {
        Self { share: Share::Constant(0.0), ..Self::alone(Model::Black) }
    }

    fn model(&self, uv: DVec2) -> Model {
        match (&self.model, &self.textures[..]) {
            (Model::Plastic(plastic), [albedo]) => plastic.with_albedo(albedo.at(uv)).into(),
            (Model::MetallicRoughness(model), [base_color, surface]) => {
                let [_, roughness, metalness] = surface.at(uv).0;
                model.with(base_color.at(uv), metalness, roughness).into()
            }
            (model, _) => *model,
        }
    }

    fn tint(&self, uv: DVec2) -> Rgb {
        self.tints.iter().fold(Rgb::WHITE, |product, tint| product * tint.at(uv))
    }

    fn is_uniform(&self) -> bool {
        self.textures.is_empty()
            && self.share.is_uniform()
            && self.tints.iter().all(|tint| tint.as_constant().is_some())
    }

    /// The lobes that it has at some point.
    pub fn lobes(&self) -> Lobes {
        match (&self.model, &self.textures[..]) {
            (Model::Plastic(plastic), [albedo]) => plastic.with_albedo(albedo.range()[1]).lobes(),
            (Model::MetallicRoughness(_), [base_color, surface]) => {
                let [least, greatest] = surface.range();
                let when =
                    |condition: bool, lobes: Lobes| if condition { lobes } else { Lobes::NONE };
                when(least.g() * least.g() < LEAST_ALPHA, Lobes::DIRAC_REFLECTION)
                    | when(greatest.g() * greatest.g() >= LEAST_ALPHA, Lobes::GLOSSY_REFLECTION)
                    | when(
                        least.b() < 1.0 && !base_color.range()[1].is_black(),
                        Lobes::DIFFUSE_REFLECTION,
                    )
            }
            (model, _) => model.lobes(),
        }
    }
}

/// True if the first of two layers is a model alone, perhaps in a colour.
pub(super) fn is_alone([first, second]: &[Layer; 2]) -> bool {
    first.share == Share::Constant(1.0)
        && second.share == Share::Constant(0.0)
        && second.model == Model::Black
}

/// The mixture of two layers at a point.
pub(super) fn mixed([first, second]: &[Layer; 2], uv: DVec2) -> Mixture<Model, 2> {
    let weights = [first.share.at(uv), second.share.at(uv)];
    let total = weights[0] + weights[1];
    Mixture::of_valid(
        [first.model(uv), second.model(uv)],
        [first.tint(uv) * weights[0], second.tint(uv) * weights[1]],
        weights.map(|weight| weight / total),
    )
}

impl Finish {
    /// Absorbs everything.
    pub const BLACK: Self = Self::Model(Model::Black);

    /// The finish of a front and a back.
    pub fn of_sides(front: [Layer; 2], back: [Layer; 2]) -> Self {
        if front == back && front.iter().all(Layer::is_uniform) {
            return match front {
                layers if is_alone(&layers) && layers[0].tints.is_empty() => {
                    Self::Model(layers[0].model)
                }
                layers => Self::Mixture(mixed(&layers, DVec2::ZERO)),
            };
        }
        let sides = Box::new([front, back]);
        let lobes = sides.as_flattened().iter().fold(Lobes::NONE, |all, layer| all | layer.lobes());
        Self::Layers { sides, lobes }
    }

    /// The lobes of both sides, anywhere.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        match self {
            Self::Model(bsdf) => bsdf.lobes(),
            Self::Mixture(bsdf) => bsdf.lobes(),
            Self::Layers { lobes, .. } => *lobes,
            Self::Custom(bsdf) => bsdf.lobes(),
        }
    }

    /// The models at a point, seen from the front or from the back, and how they are mixed; `None`
    /// for a user's own.
    pub fn mixture(&self, uv: DVec2, front: bool) -> Option<Mixture<Model, 2>> {
        match self {
            Self::Model(model) => Some(mixed(&[Layer::alone(*model), Layer::nothing()], uv)),
            Self::Mixture(mixture) => Some(*mixture),
            Self::Layers { sides, .. } => Some(mixed(&sides[usize::from(!front)], uv)),
            Self::Custom(_) => None,
        }
    }
}
