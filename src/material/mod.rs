//! Materials: descriptions of the scattering of surfaces, in the words of a user.
//!
//! A [`Material`] is a description. When it is added to a scene its parameters are checked once,
//! and it becomes a model of [`bsdf`](crate::bsdf) for each side, a mixture of two, or layers of
//! which a mixture is made at each question; integrators ask these through a [`SurfaceBsdf`]. A
//! [`Texture`] varies a colour over a surface, a [`Relief`] its shading normal, and a
//! [`CustomBsdf`] brings a user's own model.

mod checked;
mod custom;
mod finish;
mod relief;
mod roughness;
mod surface_bsdf;
#[cfg(test)]
mod tests;
mod texture;
mod vertices;

pub use custom::CustomBsdf;
pub(crate) use finish::Finish;
pub(crate) use relief::Ground;
pub use relief::{GreenAxis, Relief};
pub use surface_bsdf::SurfaceBsdf;
pub use texture::{Bitmap, Interpolation, Texture, TextureError, VertexFactor, Wrap};
pub(crate) use vertices::{VertexSite, VertexValues};

use crate::bsdf::{Bsdf, PrincipledLobes};
use crate::math::Rgb;
use glam::DVec2;

/// The scattering of a surface, as it is described to a scene.
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
    /// A diffuse body under a smooth clear coat; see [`Plastic`](crate::bsdf::Plastic).
    Plastic {
        /// Reflected fraction of the body, 0 to 1.
        albedo: Texture,
        /// Scale of the coat's reflection, 0 to 1; physically 1.
        specular: Rgb,
        /// Index of refraction of the coat over that of the outside, at least 1.
        relative_ior: f64,
        /// True if light that the coat throws back to the body is coloured again.
        colour_shift: bool,
    },
    /// A diffuse body under a rough clear coat: GGX; see
    /// [`RoughPlastic`](crate::bsdf::RoughPlastic).
    RoughPlastic {
        /// Reflected fraction of the body, 0 to 1.
        albedo: Texture,
        /// Scale of the coat's reflection, 0 to 1; physically 1.
        specular: Rgb,
        /// Index of refraction of the coat over that of the outside, at least 1.
        relative_ior: f64,
        /// True if light that the coat throws back to the body is coloured again.
        colour_shift: bool,
        /// Roughness of the coat, in all directions.
        alpha: f64,
    },
    /// Metal, or a diffuse body under a dielectric coat, or a mixture of both: the material of
    /// glTF; see
    /// [`MetallicRoughness`](crate::bsdf::MetallicRoughness).
    MetallicRoughness {
        /// Reflectance of the metal at normal incidence, and albedo of the body, 0 to 1.
        base_color: Texture,
        /// Roughness (the root of α) in green, metalness in blue, each 0 to 1. Red has no meaning.
        metallic_roughness: Texture,
        /// Index of refraction of the coat over that of the outside.
        relative_ior: f64,
    },
    /// The same under a second, clear coat of index 1.5; see [`Coated`](crate::bsdf::Coated).
    Coated {
        /// Reflectance of the metal at normal incidence, and albedo of the body, 0 to 1.
        base_color: Texture,
        /// Roughness (the root of α) in green, metalness in blue, each 0 to 1. Red has no meaning.
        metallic_roughness: Texture,
        /// Index of refraction of the inner coat over that of the outside.
        relative_ior: f64,
        /// The share of the surface that the outer coat covers, in the red of the first texture,
        /// and its roughness (the root of α), in the green of the second, each 0 to 1.
        coat: Box<[Texture; 2]>,
    },
    /// The principled material of Burley; see [`Principled`](crate::bsdf::Principled).
    Principled {
        /// Colour of the body, and of metal at normal incidence, 0 to 1.
        base_color: Texture,
        /// Share of metal: the luminance of a texture, 0 to 1.
        metalness: Texture,
        /// Roughness, the root of α: the luminance of a texture, 0 to 1.
        roughness: Texture,
        /// The other parameters.
        lobes: Box<PrincipledLobes>,
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
    /// A rough mirror, rough metal, frosted glass or rough plastic with Beckmann's distribution in
    /// place of GGX.
    Beckmann {
        /// The rough material, one of the four, perhaps with independent masking.
        rough: Box<Material>,
    },
    /// One of the same four whose masking and shadowing are independent
    /// ([`Microfacets::with_independent_masking`](crate::bsdf::Microfacets::with_independent_masking)).
    IndependentMasking {
        /// The rough material. [`Beckmann`](Self::Beckmann) goes around, not inside.
        rough: Box<Material>,
    },
    /// A rough mirror, rough metal or frosted glass, perhaps with Beckmann's distribution or
    /// independent masking, whose roughness varies over the surface. It is never smooth: α is at
    /// least [`LEAST_ALPHA`](crate::bsdf::ggx::LEAST_ALPHA).
    VaryingRoughness {
        /// The rough material, whose own α has no meaning.
        rough: Box<Material>,
        /// α along the tangent and across it, 0 to 10: the luminance of two textures.
        alpha: Box<[Texture; 2]>,
    },
    /// A material in a colour: its BSDF is multiplied by a texture. Over a white Lambertian
    /// reflector that is a textured one.
    Tinted {
        /// The material.
        material: Box<Material>,
        /// The factor, 0 to 1.
        tint: Texture,
    },
    /// Glass, smooth, rough or a pane, that colours what it lets through and not what it reflects.
    Stained {
        /// The glass; what transmits otherwise is not stained.
        glass: Box<Material>,
        /// The share of light that passes, 0 to 1, each time that it goes through the surface.
        stain: Texture,
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
        /// The texture whose luminance, 0 to 1, is the weight of the second; the rest of 1 is that
        /// of the first.
        amount: Texture,
    },
    /// A material that is not there for whoever looks at its back; see
    /// [`Culled`](crate::bsdf::Culled). Not part of another.
    Culled {
        /// Seen from the side that the normal points to.
        front: Box<Material>,
    },
    /// A weighted sum of two of the others.
    Mixture {
        /// The two; neither of them a mixture.
        components: Box<[Material; 2]>,
        /// The weights; a sum of at most 1 conserves energy.
        weights: [f64; 2],
    },
    /// A BSDF of a user's own, the same everywhere and on both sides but for what it makes of the
    /// sign of z; see [`Material::custom`]. Tints, sides, blends and mixtures do not take it.
    Custom(CustomBsdf),
}

impl Material {
    /// A material of a BSDF of a user's own. What it says that it has
    /// ([`lobes`](Bsdf::lobes)) decides what integrators do about it.
    #[must_use]
    pub fn custom(bsdf: impl Bsdf + 'static) -> Self {
        Self::Custom(CustomBsdf::new(bsdf))
    }

    /// Absorbs on its back what would otherwise be scattered on both sides.
    #[must_use]
    pub fn one_sided(self) -> Self {
        Self::Sided { front: Box::new(self), back: Box::new(Self::Black) }
    }

    /// Is not there for whoever looks at its back.
    #[must_use]
    pub fn culled(self) -> Self {
        Self::Culled { front: Box::new(self) }
    }

    /// Glass that colours what it lets through; see [`Material::Stained`].
    #[must_use]
    pub fn stained(self, stain: impl Into<Texture>) -> Self {
        Self::Stained { glass: Box::new(self), stain: stain.into() }
    }

    /// The same material in a colour.
    #[must_use]
    pub fn tinted(self, tint: impl Into<Texture>) -> Self {
        Self::Tinted { material: Box::new(self), tint: tint.into() }
    }
}
