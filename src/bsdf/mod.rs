//! Scattering of surfaces: the [`Bsdf`] trait and one file per model.
//!
//! All directions are unit vectors in the local frame of the surface point, z = shading normal, and
//! point *away* from the surface. The two neighbours of a vertex are labelled by the end of the
//! path they lead to, so that a BSDF has one value for a pair of directions whichever way the path
//! was traced:
//!
//! ```text
//! L(to_camera) = ∫ f(to_light, to_camera) L(to_light) dσ⊥(to_light)
//! ```
//!
//! Densities here are per projected solid angle with the *local* (shading) cosine |z|. The effect
//! of a difference between shading and geometric normal on f and on densities is applied to every
//! model alike, outside the models, in [`shading`].
//!
//! | surface | models |
//! |---|---|
//! | diffuse | [`Lambert`]; under a coat [`Plastic`], [`RoughPlastic`] |
//! | smooth, opaque (Dirac lobes) | [`Mirror`], [`Conductor`] |
//! | smooth, transmissive (Dirac lobes) | [`Dielectric`], [`ThinDielectric`], [`Null`] |
//! | rough | [`RoughConductor`], [`RoughDielectric`] with [`Ggx`] or [`Beckmann`] |
//! | metallic-roughness of glTF | [`MetallicRoughness`] |
//! | principled | [`Principled`] |
//! | sum of models; any model | [`Mixture`]; [`Model`] |
//! | under a clear coat | [`Coated`] |
//! | without a back | [`Culled`] |
//!
//! Sources: Veach 1997, chapter 5, for [transport modes](TransportMode) and non-symmetric
//! scattering; Walter et al. 2007 for rough surfaces; each model names its own.

use crate::lanes::Lane;
use crate::math::warp::square_to_cosine_hemisphere;
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

pub mod beckmann;
pub mod check;
pub mod coated;
pub mod conductor;
pub mod culled;
pub mod dielectric;
pub mod error;
pub mod fresnel;
pub mod ggx;
pub mod lambert;
pub mod metallic_roughness;
pub mod microfacets;
pub mod mirror;
pub mod mixture;
pub mod model;
pub mod null;
pub mod plastic;
pub mod principled;
pub mod rough_conductor;
pub mod rough_dielectric;
pub mod rough_plastic;
pub mod shading;
pub mod thin_dielectric;

pub use beckmann::Beckmann;
pub use coated::Coated;
pub use conductor::Conductor;
pub use culled::Culled;
pub use dielectric::Dielectric;
pub use error::BsdfError;
pub use fresnel::Reflectance;
pub use ggx::Ggx;
pub(crate) use ggx::{GREATEST_ALPHA, LEAST_ALPHA};
pub use lambert::Lambert;
pub use metallic_roughness::MetallicRoughness;
pub use microfacets::Microfacets;
pub use mirror::Mirror;
pub use mixture::Mixture;
pub use model::Model;
pub use null::Null;
pub use plastic::Plastic;
pub use principled::{Principled, PrincipledLobes};
pub use rough_conductor::RoughConductor;
pub(crate) use rough_dielectric::INDEX_MATCHED;
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::RoughPlastic;
pub use thin_dielectric::ThinDielectric;

/// The quantity that a walk estimates, and so the end that it starts at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransportMode {
    /// Radiance that arrives at the camera: a walk from the camera towards the lights, which
    /// samples `to_light` with `to_camera` fixed.
    Radiance,
    /// Importance of what a light sends out: a walk from a light towards the camera, which samples
    /// `to_camera` with `to_light` fixed.
    Importance,
}

impl TransportMode {
    /// The walk in the opposite direction.
    #[inline]
    #[must_use]
    pub const fn reversed(self) -> Self {
        match self {
            Self::Radiance => Self::Importance,
            Self::Importance => Self::Radiance,
        }
    }

    /// Orders the pair (direction to the walk's start, direction to its next vertex) as
    /// (`to_light`, `to_camera`).
    #[inline]
    #[must_use]
    pub fn label(self, fixed: DVec3, next: DVec3) -> (DVec3, DVec3) {
        match self {
            Self::Radiance => (next, fixed),
            Self::Importance => (fixed, next),
        }
    }
}

/// The set of lobe kinds that a BSDF has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Lobes(u8);

impl Lobes {
    /// No lobe: the surface absorbs everything.
    pub const NONE: Self = Self(0);
    /// Diffuse reflection.
    pub const DIFFUSE_REFLECTION: Self = Self(1);
    /// Diffuse transmission.
    pub const DIFFUSE_TRANSMISSION: Self = Self(2);
    /// Glossy reflection.
    pub const GLOSSY_REFLECTION: Self = Self(4);
    /// Glossy transmission.
    pub const GLOSSY_TRANSMISSION: Self = Self(8);
    /// Dirac (perfectly specular) reflection.
    pub const DIRAC_REFLECTION: Self = Self(16);
    /// Dirac (perfectly specular) transmission.
    pub const DIRAC_TRANSMISSION: Self = Self(32);
    /// All Dirac lobes.
    pub const DIRAC: Self = Self(16 | 32);
    /// All lobes that are functions, not Dirac distributions; vertices with one of them can be
    /// connected.
    pub const FINITE: Self = Self(1 | 2 | 4 | 8);
    /// All glossy lobes.
    pub const GLOSSY: Self = Self(4 | 8);
    /// All transmissive lobes.
    pub const TRANSMISSION: Self = Self(2 | 8 | 32);
    /// All reflective lobes.
    pub const REFLECTION: Self = Self(1 | 4 | 16);

    /// Both sets together.
    #[inline]
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The same set with glossy lobes in place of Dirac ones.
    #[inline]
    pub(crate) const fn regularized(self) -> Self {
        Self((self.0 & Self::FINITE.0) | ((self.0 & Self::DIRAC.0) >> 2))
    }

    /// True if the sets have a lobe in common.
    #[inline]
    #[must_use]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

impl std::ops::BitOr for Lobes {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        self.union(other)
    }
}

/// A sampled direction with everything that the module that sampled it knows about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The new direction.
    pub next: DVec3,
    /// `f / p⊥` (dimensionless), of the Dirac coefficients if `dirac`.
    pub weight: Rgb,
    /// Density of `next` given `fixed`; for a Dirac lobe see [`DiracValue`].
    pub pdf: PerProjected,
    /// Density with which the walk in the opposite direction would sample `fixed` given `next`.
    pub pdf_reverse: PerProjected,
    /// True if a Dirac lobe was sampled.
    pub dirac: bool,
    /// Index of refraction of the medium that `next` is in over that of the medium that `fixed` is
    /// in; 1 for reflection.
    pub relative_ior: f64,
}

impl BsdfSample {
    /// A Dirac lobe's sample that stays in its medium, such as a reflection, chosen with a
    /// probability.
    #[inline]
    #[must_use]
    pub const fn of_dirac(next: DVec3, weight: Rgb, probability: f64) -> Self {
        let pdf = PerProjected(probability);
        Self { next, weight, pdf, pdf_reverse: pdf, dirac: true, relative_ior: 1.0 }
    }

    /// Probability with which this sample of a Dirac lobe is chosen: its density without
    /// refraction's n².
    #[inline]
    #[must_use]
    pub fn dirac_probability(&self, mode: TransportMode) -> f64 {
        match mode {
            TransportMode::Radiance => self.pdf.value(),
            TransportMode::Importance => self.pdf.value() / (self.relative_ior * self.relative_ior),
        }
    }

    /// The coefficients of the Dirac lobe that was sampled.
    #[inline]
    #[must_use]
    pub fn dirac_value(&self, mode: TransportMode) -> DiracValue {
        let (pdf_to_light, pdf_to_camera) = match mode {
            TransportMode::Radiance => (self.pdf, self.pdf_reverse),
            TransportMode::Importance => (self.pdf_reverse, self.pdf),
        };
        DiracValue { value: self.weight * self.pdf.value(), pdf_to_light, pdf_to_camera }
    }
}

/// The coefficients of a Dirac lobe for one pair of directions.
///
/// A Dirac BSDF is `f(to_light, to_camera) = value · δ⊥(to_light - image(to_camera))`, the Dirac
/// distribution taken with respect to the projected solid angle of `to_light`. All three numbers
/// are coefficients of that same distribution, so their ratios are those of the densities. Because
/// `n² dσ⊥` is invariant under refraction, a lobe that a light walk chooses with probability `P`
/// has the coefficient `P · n_camera² / n_light²`, where `n_camera` is the index on the side of
/// `to_camera`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiracValue {
    /// Coefficient of f.
    pub value: Rgb,
    /// Coefficient of the density of `to_light`, sampled by a camera walk.
    pub pdf_to_light: PerProjected,
    /// Coefficient of the density of `to_camera`, sampled by a light walk.
    pub pdf_to_camera: PerProjected,
}

/// A model that many points are shaded with at a time, a point in each lane of a vector of f64:
/// what a [`Bsdf`] is as a whole to those who see one side of it. Values, densities and samples are
/// those of the model to the bit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LaneForm {
    /// Absorbs everything.
    Black,
    /// Diffuse reflection.
    Lambert(Lambert),
}

/// The scattering function of one surface point. Open for users to implement; [`check`] tests an
/// implementation.
///
/// Directions are in the local frame (z = shading normal), unit length, pointing away from the
/// surface. A model with finite lobes implements [`eval`](Self::eval), [`pdf`](Self::pdf) and
/// [`sample`](Self::sample), one with Dirac lobes [`dirac_images`](Self::dirac_images), which is
/// all that one needs that has no other.
pub trait Bsdf: Send + Sync {
    /// The kinds of lobes that this BSDF has at this point.
    fn lobes(&self) -> Lobes;

    /// `f(to_light, to_camera)` in 1/sr without Dirac lobes, refraction's `n_camera²/n_light²`
    /// included (Veach 1997, section 5.2).
    fn eval(&self, _to_light: DVec3, _to_camera: DVec3) -> Rgb {
        Rgb::BLACK
    }

    /// Density with which `sample` chooses `next`, per projected solid angle (local cosine),
    /// without Dirac lobes but with the probability of not choosing one.
    fn pdf(&self, _fixed: DVec3, _next: DVec3, _mode: TransportMode) -> PerProjected {
        PerProjected::ZERO
    }

    /// Both [`eval`](Self::eval) and the density with which a camera walk would sample `to_light`
    /// ([`pdf`](Self::pdf)). Optional, for speed alone, where the two have terms in common.
    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let pdf = self.pdf(to_camera, to_light, TransportMode::Radiance);
        (self.eval(to_light, to_camera), pdf)
    }

    /// A sampled direction given the one back to the walk's previous vertex; `None` if the light is
    /// absorbed. `u1` chooses among the Dirac lobes, and no Dirac sample depends on `u2`. Provided
    /// for models without finite lobes: one of the Dirac images, whose probabilities then sum to 1
    /// up to rounding; what is absorbed is in their weights.
    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, _u2: DVec2) -> Option<BsdfSample> {
        let (mut chosen, mut below) = (None, 0.0);
        self.dirac_images(fixed, mode, &mut |image| {
            if u1 >= below {
                chosen = Some(image);
            }
            below += image.dirac_probability(mode);
        });
        chosen
    }

    /// The images of a direction under the Dirac lobes, two or three at most: what `sample` may
    /// return with `dirac` set, each once and with a probability above 0.
    fn dirac_images(
        &self,
        _fixed: DVec3,
        _mode: TransportMode,
        _image: &mut dyn FnMut(BsdfSample),
    ) {
    }

    /// The Dirac lobe of a pair of directions that is known to be one of a Dirac lobe up to
    /// rounding, as in a recorded path: that of the nearest image on the same side of the surface;
    /// all zero if there is none.
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        // From the more grazing end the other one follows without loss of digits.
        let mode = if to_camera.z.abs() <= to_light.z.abs() {
            TransportMode::Radiance
        } else {
            TransportMode::Importance
        };
        let (fixed, next) = match mode {
            TransportMode::Radiance => (to_camera, to_light),
            TransportMode::Importance => (to_light, to_camera),
        };
        let (mut value, mut least) = (DiracValue::default(), f64::INFINITY);
        self.dirac_images(fixed, mode, &mut |image| {
            let distance = image.next.distance_squared(next);
            if same_side(image.next, next) && distance < least {
                (value, least) = (image.dirac_value(mode), distance);
            }
        });
        value
    }

    /// True if it matters how the local frame is turned around the normal. If so, x follows the
    /// surface's tangent, else any frame will do. That of the models here is roughness alone.
    fn is_anisotropic(&self) -> bool {
        self.lobes().intersects(Lobes::GLOSSY)
    }

    /// The form in which many points at a time can be shaded, if this is one: on the front (z ≥ 0),
    /// or on the back. Optional, for speed alone: whoever implements it gets the same image sooner.
    fn lane_form(&self, _front: bool) -> Option<LaneForm> {
        None
    }
}

impl<B: Bsdf + ?Sized> Bsdf for &B {
    fn lobes(&self) -> Lobes {
        (**self).lobes()
    }
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        (**self).eval(to_light, to_camera)
    }
    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        (**self).pdf(fixed, next, mode)
    }
    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        (**self).eval_and_pdf(to_light, to_camera)
    }
    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        (**self).sample(fixed, mode, u1, u2)
    }
    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        (**self).dirac_images(fixed, mode, image);
    }
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        (**self).eval_dirac(to_light, to_camera)
    }
    fn is_anisotropic(&self) -> bool {
        (**self).is_anisotropic()
    }
    fn lane_form(&self, front: bool) -> Option<LaneForm> {
        (**self).lane_form(front)
    }
}

/// The sample of a direction that `bsdf` has chosen by its density, a reflection; `None` where
/// rounding leaves no density.
fn finite_sample(
    bsdf: &impl Bsdf,
    fixed: DVec3,
    next: DVec3,
    mode: TransportMode,
) -> Option<BsdfSample> {
    let (to_light, to_camera) = mode.label(fixed, next);
    let pdf = bsdf.pdf(fixed, next, mode);
    (pdf.value() > 0.0).then(|| BsdfSample {
        next,
        weight: bsdf.eval(to_light, to_camera) / pdf.value(),
        pdf,
        pdf_reverse: bsdf.pdf(next, fixed, mode.reversed()),
        dirac: false,
        relative_ior: 1.0,
    })
}

/// A direction on the side of another with the density of Lambert's law.
fn sample_diffuse(fixed: DVec3, u: DVec2) -> DVec3 {
    let next = square_to_cosine_hemisphere(u);
    next.with_z(next.z.copysign(fixed.z))
}

/// True if both directions lie strictly on the same side of the surface.
#[inline]
fn same_side(a: DVec3, b: DVec3) -> bool {
    on_same_side(a.z, b.z)
}

/// True where both are strictly on the same side of the surface, given their local z.
#[inline(always)]
pub(crate) fn on_same_side<L: Lane>(a: L, b: L) -> L::Mask {
    (a.is_positive() & b.is_positive()) | (a.is_negative() & b.is_negative())
}

/// True if the directions lie strictly on opposite sides of the surface.
#[inline]
fn opposite_sides(a: DVec3, b: DVec3) -> bool {
    (a.z > 0.0 && b.z < 0.0) || (a.z < 0.0 && b.z > 0.0)
}

/// sin θ from the tangential components: exact near the normal, where `√(1 - cos²)` has lost all
/// digits.
#[inline]
fn sine(direction: DVec3) -> f64 {
    direction.truncate().length()
}
