//! Materials as integrators meet them: the model at a point, with textures looked up there and with
//! the side that is seen.

use super::Texture;
use crate::bsdf::ggx::LEAST_ALPHA;
use crate::bsdf::{
    Bsdf, BsdfSample, DiracValue, Lobes, MetallicRoughness, Mixture, Model, Plastic, SimpleModel,
    Walk,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// A checked material.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "the usual variant must not be behind another pointer"
)]
pub(crate) enum Scattering {
    /// The same everywhere and on both sides.
    Uniform(Model),
    /// What is seen from the front and from the back. Both transmit the same, or nothing.
    Varying(Box<Sides>),
}

/// The front and the back of a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sides {
    pub stacks: [Stack; 2],
    /// Of both, anywhere.
    lobes: Lobes,
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
    pub model: LayerModel,
    /// Factors of the BSDF.
    pub tints: Vec<Texture>,
}

/// A model, or what it is made of at each point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LayerModel {
    /// The same everywhere.
    Uniform(SimpleModel),
    /// With the albedo of its body.
    Plastic(Plastic, Texture),
    /// Base colour; roughness in green and metalness in blue; reflectance of the coat at normal
    /// incidence.
    MetallicRoughness { base_color: Texture, surface: Texture, coat: f64 },
}

/// How two layers are mixed; ignored if there is one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mix {
    /// Their weights.
    Weights([f64; 2]),
    /// The luminance is the weight of the second, the rest of 1 that of the first.
    Amount(Texture),
}

impl LayerModel {
    fn at(&self, uv: DVec2) -> SimpleModel {
        match self {
            Self::Uniform(model) => *model,
            Self::Plastic(plastic, albedo) => plastic.with_albedo(albedo.at(uv)).into(),
            Self::MetallicRoughness { base_color, surface, coat } => {
                let [_, roughness, metalness] = surface.at(uv).0;
                MetallicRoughness::of_valid(base_color.at(uv), metalness, roughness, *coat).into()
            }
        }
    }

    /// The lobes that it has at some point.
    pub fn lobes(&self) -> Lobes {
        match self {
            Self::Uniform(model) => model.lobes(),
            Self::Plastic(plastic, albedo) => plastic.with_albedo(albedo.range()[1]).lobes(),
            Self::MetallicRoughness { base_color, surface, .. } => {
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
        }
    }
}

impl Layer {
    fn model(&self, uv: DVec2) -> SimpleModel {
        self.model.at(uv)
    }

    fn tint(&self, uv: DVec2) -> Rgb {
        self.tints.iter().fold(Rgb::WHITE, |product, tint| product * tint.at(uv))
    }

    fn is_uniform(&self) -> bool {
        matches!(self.model, LayerModel::Uniform(_))
            && self.tints.iter().all(|tint| tint.as_constant().is_some())
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
                Mixture::of_valid(
                    [first.model(uv), second.model(uv)],
                    colours,
                    weights.map(|weight| weight / total),
                )
                .into()
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
        let lobes = front.lobes() | back.lobes();
        Self::Varying(Box::new(Sides { stacks: [front, back], lobes }))
    }

    /// The lobes of both sides, anywhere.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        match self {
            Self::Uniform(model) => model.lobes(),
            Self::Varying(sides) => sides.lobes,
        }
    }

    /// Whether it differs from point to point.
    pub fn is_textured(&self) -> bool {
        match self {
            Self::Uniform(_) => false,
            Self::Varying(sides) => !sides.stacks.iter().all(Stack::is_uniform),
        }
    }
}

/// How one point of a [`World`](crate::scene::World) scatters. Textures are looked up when it is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceBsdf<'a> {
    scattering: &'a Scattering,
    uv: DVec2,
}

impl<'a> SurfaceBsdf<'a> {
    pub(crate) fn new(scattering: &'a Scattering, uv: DVec2) -> Self {
        Self { scattering, uv }
    }

    /// The model at this point, seen from the front or from the back.
    #[must_use]
    pub fn model(&self, front: bool) -> Model {
        match self.scattering {
            Scattering::Uniform(model) => *model,
            Scattering::Varying(sides) => sides.stacks[usize::from(!front)].at(self.uv),
        }
    }

    /// Asks the model on a direction's side.
    #[inline]
    fn ask<R>(&self, direction: DVec3, question: impl FnOnce(&Model) -> R) -> R {
        let varying;
        // One question, so that it is compiled in place.
        question(match self.scattering {
            Scattering::Uniform(model) => model,
            Scattering::Varying(_) => {
                varying = self.model(direction.z >= 0.0);
                &varying
            }
        })
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

    #[inline]
    fn is_anisotropic(&self) -> bool {
        self.lobes().intersects(Lobes::GLOSSY)
    }
}
