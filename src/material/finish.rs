//! Checked materials: what is the same everywhere is made into models once, and the rest is kept as
//! layers, of which models are made at each point.

use super::{CustomBsdf, Texture};
use crate::bsdf::{Bsdf, Coated, LEAST_ALPHA, Lambert, Lobes, Mixture, Model};
use crate::math::Rgb;

/// A checked material. Pairs are what the front shows and what the back shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Finish {
    /// Lambertian reflection on the sides that are not black.
    Lambert { lambert: Lambert, sides: [bool; 2] },
    /// The same with the product of some textures as albedo.
    TexturedLambert { albedo: Vec<Texture>, sides: [bool; 2] },
    /// One model on each side, the same everywhere.
    Models { sides: Box<[Model; 2]>, lobes: Lobes },
    /// The same, multiplied by some textures.
    Tinted { sides: Box<[Model; 2]>, tints: Vec<Texture>, lobes: Lobes },
    /// Two models on each side, the same everywhere.
    Mixtures { sides: Box<[Mixture<Model, 2>; 2]>, lobes: Lobes },
    /// Everything else: models that vary.
    Layers(Box<Layers>),
    /// A BSDF of a user's own.
    Custom(CustomBsdf),
    /// One that is not there for whoever looks at its back.
    Culled(Box<Finish>),
}

/// The layers that are seen from the front and from the back. Both transmit the same, or nothing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layers {
    sides: [[Layer; 2]; 2],
    /// The texture that varies, if there is only one.
    pub only: Option<Texture>,
    /// True if a texture asks for what a mesh has at its vertices.
    pub asks_vertices: bool,
    /// The lobes of both sides, anywhere.
    pub lobes: Lobes,
}

/// A model whose colours may vary, and what share it has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layer {
    pub model: Model,
    /// The textures in place of the model's own colours: the albedo of plastic's body; of
    /// metallic-roughness its base colour, and roughness in green with metalness in blue, and of
    /// a clear coat over it share and roughness, too; of the principled BSDF its base colour, metalness and roughness; of rough metal and glass α
    /// along x and along y.
    pub textures: Vec<Texture>,
    /// Factors of the BSDF.
    pub tints: Vec<Texture>,
    /// Shares of what glass lets through.
    pub stains: Vec<Texture>,
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
    fn value(&self, look_up: impl Fn(&Texture) -> Rgb) -> f64 {
        let luminance = |amount: &Texture| look_up(amount).luminance().clamp(0.0, 1.0);
        match self {
            Self::Constant(weight) => *weight,
            Self::Amount(amount) => luminance(amount),
            Self::Rest(amount) => 1.0 - luminance(amount),
        }
    }

    fn texture(&self) -> Option<&Texture> {
        match self {
            Self::Constant(_) => None,
            Self::Amount(amount) | Self::Rest(amount) => Some(amount),
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
            stains: Vec::new(),
            share: Share::Constant(1.0),
        }
    }

    /// A model alone, made anew of textures where one of them varies.
    pub fn varying_in(model: Model, textures: Vec<Texture>) -> Self {
        let varies = textures.iter().any(|texture| texture.as_constant().is_none());
        Self { textures: if varies { textures } else { Vec::new() }, ..Self::alone(model) }
    }

    /// The empty layer beside a model that is alone.
    pub fn nothing() -> Self {
        Self { share: Share::Constant(0.0), ..Self::alone(Model::Black) }
    }

    fn model(&self, look_up: impl Fn(&Texture) -> Rgb) -> Model {
        let model = self.unstained(&look_up);
        self.stains.iter().fold(model, |model, stain| model.stained(look_up(stain)))
    }

    fn unstained(&self, look_up: impl Fn(&Texture) -> Rgb) -> Model {
        match (&self.model, &self.textures[..]) {
            (Model::Plastic(plastic), [albedo]) => plastic.with_albedo(look_up(albedo)).into(),
            (Model::RoughPlastic(plastic), [albedo]) => plastic.with_albedo(look_up(albedo)).into(),
            (Model::MetallicRoughness(model), [base_color, surface]) => {
                let [_, roughness, metalness] = look_up(surface).0;
                model.with(look_up(base_color), metalness, roughness).into()
            }
            (Model::Coated(model), [base_color, surface, share, roughness]) => {
                let [_, base_roughness, metalness] = look_up(surface).0;
                let base = model.base().with(look_up(base_color), metalness, base_roughness);
                Coated::of_valid(base, look_up(share).r(), look_up(roughness).g()).into()
            }
            (Model::Principled(model), [base_color, metalness, roughness]) => {
                let [metalness, roughness] =
                    [metalness, roughness].map(|texture| look_up(texture).luminance());
                model.with(look_up(base_color), metalness, roughness).into()
            }
            (model, [x, y]) => {
                let [x, y] = [x, y].map(|alpha| look_up(alpha).luminance());
                model.with_roughness(x, y).unwrap_or(*model)
            }
            (model, _) => *model,
        }
    }

    /// The textures that are not constant.
    fn varying(&self) -> impl Iterator<Item = &Texture> {
        let all =
            self.textures.iter().chain(&self.tints).chain(&self.stains).chain(self.share.texture());
        all.filter(|texture| texture.as_constant().is_none())
    }

    /// The lobes that it has at some point.
    pub fn lobes(&self) -> Lobes {
        let when = |condition: bool, lobes: Lobes| if condition { lobes } else { Lobes::NONE };
        let reflection = |roughness: &Texture| {
            let [least, greatest] = roughness.range().map(|surface| surface.g() * surface.g());
            when(least < LEAST_ALPHA, Lobes::DIRAC_REFLECTION)
                | when(greatest >= LEAST_ALPHA, Lobes::GLOSSY_REFLECTION)
        };
        let metallic_roughness = |base_color: &Texture, surface: &Texture| {
            let has_body = surface.range()[0].b() < 1.0 && !base_color.range()[1].is_black();
            reflection(surface) | when(has_body, Lobes::DIFFUSE_REFLECTION)
        };
        match (&self.model, &self.textures[..]) {
            (Model::MetallicRoughness(_), [base_color, surface]) => {
                metallic_roughness(base_color, surface)
            }
            (Model::Coated(_), [base_color, surface, share, roughness]) => {
                let coat = when(share.range()[1].r() > 0.0, reflection(roughness));
                coat | metallic_roughness(base_color, surface)
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

/// The product of some textures, given what they show.
#[inline]
pub(super) fn product(tints: &[Texture], look_up: impl Fn(&Texture) -> Rgb) -> Rgb {
    tints.iter().fold(Rgb::WHITE, |product, tint| product * look_up(tint))
}

/// The mixture of two layers, given what their textures show.
fn mixed([first, second]: &[Layer; 2], look_up: impl Fn(&Texture) -> Rgb) -> Mixture<Model, 2> {
    let weights = [first.share.value(&look_up), second.share.value(&look_up)];
    let total = weights[0] + weights[1];
    Mixture::of_valid(
        [first.model(&look_up), second.model(&look_up)],
        [
            product(&first.tints, &look_up) * weights[0],
            product(&second.tints, &look_up) * weights[1],
        ],
        weights.map(|weight| weight / total),
    )
}

/// The colour of a texture that is known to be constant; of one that is not, the given one.
fn constant_or(colour: Rgb) -> impl Fn(&Texture) -> Rgb {
    move |texture| texture.as_constant().unwrap_or(colour)
}

/// The models of sides that show one each, and the tints that all but black ones have in common.
fn models(sides: &[[Layer; 2]; 2]) -> Option<([Model; 2], &[Texture])> {
    let models = sides.each_ref().map(|[layer, _]| layer.model);
    let shown = || sides.iter().zip(models).filter(|(_, model)| *model != Model::Black);
    let tints = shown().next().map_or(&[][..], |([layer, _], _)| &layer.tints);
    let is_plain = |layer: &Layer| {
        layer.textures.is_empty() && layer.stains.is_empty() && layer.tints == tints
    };
    (sides.iter().all(is_alone) && shown().all(|([layer, _], _)| is_plain(layer)))
        .then_some((models, tints))
}

/// The albedo before it is multiplied by tints, if all sides but black ones are Lambertian. Only if
/// the product is the same to the bit as that with f.
fn lambertian(sides: &[Model; 2], tints: &[Texture]) -> Option<Rgb> {
    let shown = sides.iter().find(|model| **model != Model::Black)?;
    let Model::Lambert(lambert) = shown else { return None };
    let is_exact = tints.is_empty() || lambert.albedo() == Rgb::WHITE;
    let is_same = sides.iter().all(|model| model == shown || *model == Model::Black);
    (is_exact && is_same).then_some(lambert.albedo())
}

impl Layers {
    /// The mixture that a side shows, given what its textures show.
    pub fn mixture(&self, side: usize, look_up: impl Fn(&Texture) -> Rgb) -> Mixture<Model, 2> {
        mixed(&self.sides[side], look_up)
    }

    /// The mixture that a side shows, given the colour of the only texture that varies.
    pub fn coloured(&self, side: usize, colour: Rgb) -> Mixture<Model, 2> {
        self.mixture(side, constant_or(colour))
    }
}

impl Finish {
    /// The finish of a front and a back.
    pub fn of_sides(sides: [[Layer; 2]; 2]) -> Self {
        let layers = sides.as_flattened();
        let first = layers.iter().flat_map(Layer::varying).next().cloned();
        let is_uniform = first.is_none();
        if let Some((models, tints)) = models(&sides) {
            return Self::of_models(models, tints, is_uniform);
        }
        if is_uniform {
            let mixtures = sides.each_ref().map(|side| mixed(side, constant_or(Rgb::WHITE)));
            let lobes = mixtures[0].lobes() | mixtures[1].lobes();
            return Self::Mixtures { sides: Box::new(mixtures), lobes };
        }
        let lobes = layers.iter().fold(Lobes::NONE, |all, layer| all | layer.lobes());
        let is_only = |first: &Texture| layers.iter().flat_map(Layer::varying).all(|t| t == first);
        let only = first.filter(is_only);
        let asks_vertices = layers.iter().flat_map(Layer::varying).any(Texture::asks_vertices);
        Self::Layers(Box::new(Layers { sides, only, asks_vertices, lobes }))
    }

    fn of_models(models: [Model; 2], tints: &[Texture], is_uniform: bool) -> Self {
        let lobes = models[0].lobes() | models[1].lobes();
        let shown = models.map(|model| model != Model::Black);
        match lambertian(&models, tints) {
            Some(albedo) if is_uniform => {
                let albedo = product(tints, constant_or(Rgb::WHITE)) * albedo;
                Self::Lambert { lambert: Lambert::of_valid(albedo), sides: shown }
            }
            Some(_) => Self::TexturedLambert { albedo: tints.to_vec(), sides: shown },
            None if tints.is_empty() => Self::Models { sides: Box::new(models), lobes },
            None => Self::Tinted { sides: Box::new(models), tints: tints.to_vec(), lobes },
        }
    }

    /// The albedos of front and back of a material that reflects by Lambert's law, the same
    /// everywhere; black where it reflects nothing.
    pub fn diffuse(&self) -> Option<[Rgb; 2]> {
        let Self::Lambert { lambert, sides } = self else { return None };
        Some(sides.map(|is_lit| if is_lit { lambert.albedo() } else { Rgb::BLACK }))
    }

    /// The BSDF of a user's own, if it is one.
    pub fn as_custom(&self) -> Option<&CustomBsdf> {
        match self {
            Self::Custom(bsdf) => Some(bsdf),
            Self::Culled(front) => front.as_custom(),
            _ => None,
        }
    }

    /// The lobes of both sides, anywhere.
    pub fn lobes(&self) -> Lobes {
        match self {
            Self::Lambert { lambert, .. } => lambert.lobes(),
            Self::TexturedLambert { .. } => Lobes::DIFFUSE_REFLECTION,
            Self::Models { lobes, .. }
            | Self::Tinted { lobes, .. }
            | Self::Mixtures { lobes, .. } => *lobes,
            Self::Layers(layers) => layers.lobes,
            Self::Custom(bsdf) => bsdf.lobes(),
            Self::Culled(front) => front.lobes() | Lobes::DIRAC_TRANSMISSION,
        }
    }
}
