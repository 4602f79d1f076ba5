//! How surfaces scatter: the [`Bsdf`] trait and one file per model.
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
//! Densities here are per projected solid angle with the *local* (shading) cosine |z|. What a
//! difference between shading and geometric normal does to f and to densities is applied to every
//! model alike, outside the models, in [`shading`].

use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

pub mod beckmann;
pub mod check;
pub mod conductor;
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
pub mod rough_conductor;
pub mod rough_dielectric;
pub mod shading;
pub mod thin_dielectric;

pub use beckmann::Beckmann;
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use error::BsdfError;
pub use fresnel::Reflectance;
pub use ggx::Ggx;
pub(crate) use ggx::LEAST_ALPHA;
pub use lambert::Lambert;
pub use metallic_roughness::MetallicRoughness;
pub use microfacets::Microfacets;
pub use mirror::Mirror;
pub use mixture::Mixture;
pub use model::{Model, SimpleModel};
pub use null::Null;
pub use plastic::Plastic;
pub use rough_conductor::RoughConductor;
pub(crate) use rough_dielectric::INDEX_MATCHED;
pub use rough_dielectric::RoughDielectric;
pub use thin_dielectric::ThinDielectric;

/// Which way a walk goes: what is at its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Walk {
    /// From the camera towards the lights: samples `to_light` with `to_camera` fixed, transports
    /// importance.
    Camera,
    /// From a light towards the camera: samples `to_camera` with `to_light` fixed, transports
    /// radiance.
    Light,
}

impl Walk {
    /// The walk in the opposite direction.
    #[inline]
    #[must_use]
    pub const fn reversed(self) -> Self {
        match self {
            Self::Camera => Self::Light,
            Self::Light => Self::Camera,
        }
    }

    /// Orders the pair (direction to the walk's start, direction to its next vertex) as
    /// (`to_light`, `to_camera`).
    #[inline]
    #[must_use]
    pub fn label(self, fixed: DVec3, next: DVec3) -> (DVec3, DVec3) {
        match self {
            Self::Camera => (next, fixed),
            Self::Light => (fixed, next),
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

    /// Whether the sets have a lobe in common.
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
    /// Whether a Dirac lobe was sampled.
    pub dirac: bool,
    /// Index of refraction of the medium that `next` is in over that of the medium that `fixed` is
    /// in; 1 for reflection.
    pub relative_ior: f64,
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

/// How one surface point scatters light. Open for users to implement.
///
/// Directions are in the local frame (z = shading normal), unit length, pointing away from the
/// surface.
pub trait Bsdf {
    /// The kinds of lobes that this BSDF has at this point.
    fn lobes(&self) -> Lobes;

    /// `f(to_light, to_camera)` in 1/sr without Dirac lobes, refraction's `n_camera²/n_light²`
    /// included (Veach 1997, section 5.2).
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb;

    /// Density with which `sample` chooses `next`, per projected solid angle (local cosine),
    /// without Dirac lobes but with the probability of not choosing one.
    fn pdf(&self, fixed: DVec3, next: DVec3, walk: Walk) -> PerProjected;

    /// Samples a direction given the one back to the walk's previous vertex; `None` if the light is
    /// absorbed.
    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, u2: DVec2) -> Option<BsdfSample>;

    /// The Dirac lobe that maps one direction into the other, if there is one; all zero otherwise.
    ///
    /// Only used to re-evaluate recorded paths: "maps" is decided up to rounding.
    fn eval_dirac(&self, _to_light: DVec3, _to_camera: DVec3) -> DiracValue {
        DiracValue::default()
    }

    /// Whether it matters how the local frame is turned around the normal. If so, x follows the
    /// surface's tangent, else any frame will do.
    fn is_anisotropic(&self) -> bool {
        true
    }
}

impl<B: Bsdf + ?Sized> Bsdf for &B {
    fn lobes(&self) -> Lobes {
        (**self).lobes()
    }
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        (**self).eval(to_light, to_camera)
    }
    fn pdf(&self, fixed: DVec3, next: DVec3, walk: Walk) -> PerProjected {
        (**self).pdf(fixed, next, walk)
    }
    fn sample(&self, fixed: DVec3, walk: Walk, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        (**self).sample(fixed, walk, u1, u2)
    }
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        (**self).eval_dirac(to_light, to_camera)
    }
    fn is_anisotropic(&self) -> bool {
        (**self).is_anisotropic()
    }
}

/// How far the tangential components of a pair of directions may miss the law of reflection or
/// refraction for `eval_dirac`.
///
/// Wide enough for directions recomputed from positions, where an edge that is short against the
/// coordinates has lost half the digits.
const DIRAC_TOLERANCE: f64 = 1e-6;

/// Both directions lie strictly on the same side of the surface.
#[inline]
fn same_side(a: DVec3, b: DVec3) -> bool {
    (a.z > 0.0 && b.z > 0.0) || (a.z < 0.0 && b.z < 0.0)
}

/// The directions lie strictly on opposite sides of the surface.
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
