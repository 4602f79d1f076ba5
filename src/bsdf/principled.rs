//! The principled BSDF (Burley 2012, 2015) in the form that Mitsuba 3 gives it (Jakob et al. 2022,
//! plug-in `principled`): a body, a main reflection that is metal's or a dielectric's, refraction,
//! a clear coat and sheen.
//!
//! With base colour b, metalness m, roughness r, the share t of refraction, Fresnel's F of the
//! dielectric, Schlick's weight `S(c) = (1 - c)⁵`, and GGX with masking and shadowing taken as
//! independent,
//!
//! ```text
//! f = F_s D G1 G1 / (4 o_z i_z)                                              main reflection
//!   + (1 - m)(1 - t) b/π · ((1 - S_o/2)(1 - S_i/2) + R (S_o + S_i + S_o S_i (R - 1)))   body
//!   + coat/4 · F_c D_c G_c  +  (1 - m) sheen · S(o·h)
//!   + (1 - m) t √b · refraction of rough glass,                  R = 2 r (o·h)²
//! ```
//!
//! where F_s mixes F with Schlick's approximations for metal (b at normal incidence) and for a
//! tinted dielectric; flatness replaces the body's last factor by an approximation of subsurface
//! scattering. From behind, where there is refraction, the surface is the glass alone.
//!
//! Every term is reciprocal. Energy is not conserved in general, here as in the sources: the body
//! does not know what the main reflection takes from it. Under an index of 1.5 a white surface
//! reflects 1.02 to 1.05 of the light at normal incidence, and up to 1.5 at a cosine of 0.05; one of
//! base colour 0.8 stays below 1 for cosines above 0.3.

use super::error::checked_reflectance;
use super::fresnel::{self, checked_relative_ior};
use super::rough_conductor::{Pair, is_above, reflect, upwards};
use super::rough_dielectric::{Refraction, refract};
use super::{
    Bsdf, BsdfError, BsdfSample, Ggx, Lobes, Microfacets, TransportMode, finite_sample, same_side,
    sample_diffuse,
};
use crate::math::angle::sin_cos_of_turn;
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, PI};

/// The parameters of a [`Principled`] BSDF besides base colour, metalness and roughness. All but
/// the index of refraction are in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledLobes {
    /// Index of refraction of the inside over that of the outside.
    pub relative_ior: f64,
    /// Share of refraction in what is not metal.
    pub transmission: f64,
    /// Stretch of the main lobe along the tangent.
    pub anisotropy: f64,
    /// Share of the base colour's hue in the dielectric reflection.
    pub specular_tint: f64,
    /// Strength of sheen.
    pub sheen: f64,
    /// Share of the base colour's hue in sheen.
    pub sheen_tint: f64,
    /// Share of the approximation of subsurface scattering in the body.
    pub flatness: f64,
    /// Strength of the clear coat.
    pub clearcoat: f64,
    /// Smoothness of the clear coat.
    pub clearcoat_gloss: f64,
}

impl Default for PrincipledLobes {
    /// An index of 1.5, and 0 for all others.
    fn default() -> Self {
        Self {
            relative_ior: 1.5,
            transmission: 0.0,
            anisotropy: 0.0,
            specular_tint: 0.0,
            sheen: 0.0,
            sheen_tint: 0.0,
            flatness: 0.0,
            clearcoat: 0.0,
            clearcoat_gloss: 0.0,
        }
    }
}

/// Roughness α to which the main lobe's is raised.
const LEAST_MAIN_ALPHA: f64 = 1e-3;

/// A surface of the principled BSDF: on both sides, or, if it transmits light, on its front, with
/// plain rough glass on its back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    lobes: PrincipledLobes,
    base_color: Rgb,
    /// The base colour's hue: of luminance 1.
    hue: Rgb,
    metalness: f64,
    roughness: f64,
    distribution: Microfacets,
}

/// The shares of samples of the main lobe, the clear coat and the body.
struct Shares {
    main: f64,
    coat: f64,
    body: f64,
}

impl Principled {
    /// A surface with the given base colour, metalness and roughness, all in [0, 1]. The roughness
    /// is the root of α. Where light is transmitted an index within 0.001 of 1 is 1.001: a rough
    /// interface that bends no ray has no finite density.
    ///
    /// # Errors
    /// If a channel of the colour or a parameter is not in [0, 1], or the index of refraction is
    /// not in [1e-6, 1e6].
    pub fn new(
        base_color: Rgb,
        metalness: f64,
        roughness: f64,
        mut lobes: PrincipledLobes,
    ) -> Result<Self, BsdfError> {
        let base_color = checked_reflectance(base_color)?;
        checked_relative_ior(lobes.relative_ior)?;
        if lobes.transmission > 0.0 && (lobes.relative_ior - 1.0).abs() < 1e-3 {
            lobes.relative_ior = 1.001;
        }
        let shares = [
            lobes.transmission,
            lobes.anisotropy,
            lobes.specular_tint,
            lobes.sheen,
            lobes.sheen_tint,
            lobes.flatness,
            lobes.clearcoat,
            lobes.clearcoat_gloss,
        ];
        let unit = 0.0..=1.0;
        if let Some(bad) = shares.into_iter().find(|share| !unit.contains(share)) {
            return Err(BsdfError::Principled(bad));
        }
        if !unit.contains(&metalness) || !unit.contains(&roughness) {
            return Err(BsdfError::MetallicRoughness(metalness, roughness));
        }
        Ok(Self::of_valid(base_color, metalness, roughness, lobes))
    }

    fn of_valid(base_color: Rgb, metalness: f64, roughness: f64, lobes: PrincipledLobes) -> Self {
        let aspect = (1.0 - 0.9 * lobes.anisotropy).sqrt();
        let alpha = |stretch: f64| (roughness * roughness * stretch).max(LEAST_MAIN_ALPHA);
        let distribution = Ggx::raised(alpha(1.0 / aspect), alpha(aspect)).into();
        let luminance = base_color.luminance();
        let hue = if luminance > 0.0 { base_color / luminance } else { Rgb::WHITE };
        Self { lobes, base_color, hue, metalness, roughness, distribution }
    }

    /// The same surface with other parameters, which must be in [0, 1].
    pub(crate) fn with(self, base_color: Rgb, metalness: f64, roughness: f64) -> Self {
        // Interpolated textures may leave the range by a rounding error.
        let (metalness, roughness) = (metalness.clamp(0.0, 1.0), roughness.clamp(0.0, 1.0));
        Self::of_valid(base_color, metalness, roughness, self.lobes)
    }

    fn transmits(&self) -> bool {
        self.lobes.transmission > 0.0
    }

    /// True if a direction sees all lobes.
    fn is_front(&self, direction: DVec3) -> bool {
        direction.z > 0.0 || !self.transmits()
    }

    /// Index of refraction of the far side over that of the side of a direction.
    fn far_over_near(&self, direction: DVec3) -> f64 {
        let n = self.lobes.relative_ior;
        if self.is_front(direction) { n } else { 1.0 / n }
    }

    /// The share of the body.
    fn opaque(&self) -> f64 {
        (1.0 - self.metalness) * (1.0 - self.lobes.transmission)
    }

    /// The share of refraction.
    fn glass(&self) -> f64 {
        (1.0 - self.metalness) * self.lobes.transmission
    }

    /// The light that a micro-normal reflects, and its transmittance with the share of refraction.
    fn fresnel(&self, front: bool, cosine: f64, sine: f64, eta: f64) -> (Rgb, f64) {
        let interface = fresnel::dielectric(cosine, sine, eta);
        let transmitted = self.glass() * interface.transmittance;
        if !front {
            return (Rgb::splat(self.glass() * interface.reflectance), transmitted);
        }
        // On the thicker side of an interface Schlick's angle is that of the refracted ray.
        let weight = schlick(if eta > 1.0 { cosine } else { interface.refracted_cosine });
        let tint = (1.0 - self.metalness) * self.lobes.specular_tint;
        let plain = (1.0 - self.metalness - tint) * interface.reflectance;
        let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
        let mixed = |b: f64, hue: f64| {
            let approximated = |f0: f64| f0 + (1.0 - f0) * weight;
            let tinted = approximated((normal * hue).min(1.0));
            plain + self.metalness * approximated(b) + tint * tinted
        };
        let channel = |c: usize| mixed(self.base_color[c], self.hue[c]);
        (Rgb::new(channel(0), channel(1), channel(2)), transmitted)
    }

    /// The probability that a micro-normal reflects, given what [`fresnel`](Self::fresnel) says.
    fn reflected_share(reflected: Rgb, transmitted: f64) -> f64 {
        let reflected = reflected.mean();
        // Neither only where the main lobe is black.
        if reflected + transmitted > 0.0 { reflected / (reflected + transmitted) } else { 1.0 }
    }

    /// In proportion to what lobes would reflect if they were smooth.
    fn shares(&self, fixed: DVec3) -> Shares {
        if !self.is_front(fixed) {
            return Shares { main: 1.0, coat: 0.0, body: 0.0 };
        }
        let (cosine, sine) = (fixed.z.abs(), super::sine(fixed));
        let (reflected, transmitted) = self.fresnel(true, cosine, sine, self.far_over_near(fixed));
        let main = reflected.mean() + transmitted;
        let coat = self.lobes.clearcoat * coat_fresnel(cosine);
        let body = self.opaque() * self.base_color.mean()
            + 0.2 * self.lobes.sheen * (1.0 - self.metalness);
        let sum = main + coat + body;
        if sum > 0.0 {
            Shares { main: main / sum, coat: coat / sum, body: body / sum }
        } else {
            Shares { main: 1.0, coat: 0.0, body: 0.0 }
        }
    }

    /// Body and sheen.
    fn body(&self, pair: &Pair) -> Rgb {
        let [o, i] = [pair.o.z, pair.i.z];
        let [s_o, s_i] = [o, i].map(schlick);
        let retro = 2.0 * self.roughness * pair.cosine * pair.cosine;
        let rough =
            (1.0 - 0.5 * s_o) * (1.0 - 0.5 * s_i) + retro * (s_o + s_i + s_o * s_i * (retro - 1.0));
        let flat = {
            let edge = |s: f64| 1.0 + (0.5 * retro - 1.0) * s;
            1.25 * (edge(s_o) * edge(s_i) * (1.0 / (o + i) - 0.5) + 0.5)
        };
        let mixed = rough + (flat - rough) * self.lobes.flatness;
        let sheen = (1.0 - self.metalness) * self.lobes.sheen * schlick(pair.cosine);
        let tint = self.lobes.sheen_tint;
        self.base_color * (FRAC_1_PI * self.opaque() * mixed)
            + self.hue.map(|hue| sheen * (1.0 + (hue - 1.0) * tint))
    }

    /// Value and density of a reflection, seen from the first direction.
    fn reflection(&self, fixed: DVec3, next: DVec3) -> (Rgb, PerProjected) {
        let Some(pair) = Pair::new(fixed, next) else { return (Rgb::BLACK, PerProjected::ZERO) };
        let front = self.is_front(fixed);
        let sine = pair.o.cross(pair.h).length();
        let (reflected, transmitted) =
            self.fresnel(front, pair.cosine, sine, self.far_over_near(fixed));
        let lobe = pair.lobe(&self.distribution);
        let shares = self.shares(fixed);
        let main = shares.main * Self::reflected_share(reflected, transmitted);
        let mut value = reflected * lobe.value_of_independent();
        let mut pdf = main * lobe.pdf().value();
        if front {
            value += self.body(&pair);
            pdf += shares.body * FRAC_1_PI;
            if self.lobes.clearcoat > 0.0 {
                let coat = Coat::new(self.lobes.clearcoat_gloss);
                value += Rgb::splat(self.lobes.clearcoat * coat.value(&pair));
                pdf += shares.coat * coat.pdf(&pair);
            }
        }
        (value, PerProjected(pdf))
    }

    /// Value and density of a refraction, seen from the first direction, which is `to_camera`.
    fn refraction(&self, fixed: DVec3, next: DVec3) -> (Rgb, PerProjected) {
        let eta = self.far_over_near(fixed);
        let refraction = if self.transmits() { Refraction::new(fixed, next, eta) } else { None };
        let Some(refraction) = refraction else { return (Rgb::BLACK, PerProjected::ZERO) };
        let (cosine, sine) = (refraction.cosine_o, refraction.o.cross(refraction.h).length());
        let (reflected, transmitted) = self.fresnel(self.is_front(fixed), cosine, sine, eta);
        let share = self.shares(fixed).main * (1.0 - Self::reflected_share(reflected, transmitted));
        let value = self.glass()
            * refraction.transmittance
            * refraction.value_of_independent(&self.distribution);
        let pdf = refraction.pdf_of_normal(&self.distribution, share);
        (self.base_color.map(f64::sqrt) * value, pdf)
    }
}

impl Bsdf for Principled {
    fn lobes(&self) -> Lobes {
        let when = |condition: bool, lobes: Lobes| if condition { lobes } else { Lobes::NONE };
        let has_body = self.opaque() > 0.0 && !self.base_color.is_black();
        let has_sheen = self.lobes.sheen > 0.0 && self.metalness < 1.0;
        Lobes::GLOSSY_REFLECTION
            | when(has_body || has_sheen, Lobes::DIFFUSE_REFLECTION)
            | when(self.glass() > 0.0, Lobes::GLOSSY_TRANSMISSION)
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.eval_and_pdf(to_light, to_camera).0
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _mode: TransportMode) -> PerProjected {
        self.eval_and_pdf(next, fixed).1
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        if same_side(to_light, to_camera) {
            self.reflection(to_camera, to_light)
        } else {
            self.refraction(to_camera, to_light)
        }
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let o = upwards(fixed, fixed);
        if !is_above(o) {
            return None;
        }
        let shares = self.shares(fixed);
        if u1 >= shares.main {
            let next = if u1 < shares.main + shares.coat {
                let h = Coat::new(self.lobes.clearcoat_gloss).sample(u2);
                upwards(reflect(o, h)?, fixed)
            } else {
                sample_diffuse(fixed, u2)
            };
            return finite_sample(self, fixed, next, mode);
        }
        let eta = self.far_over_near(fixed);
        let h = self.distribution.sample_visible(o, u2)?;
        let (cosine, sine) = (o.dot(h).max(0.0), o.cross(h).length());
        let (reflected, transmitted) = self.fresnel(self.is_front(fixed), cosine, sine, eta);
        if u1 < shares.main * Self::reflected_share(reflected, transmitted) {
            return finite_sample(self, fixed, upwards(reflect(o, h)?, fixed), mode);
        }
        let far = fresnel::dielectric(cosine, sine, eta).refracted_cosine;
        let next = upwards(refract(o, h, eta, far)?, fixed);
        let sample = finite_sample(self, fixed, next, mode)?;
        Some(BsdfSample { relative_ior: eta, ..sample })
    }
}

/// `(1 - c)⁵`
fn schlick(cosine: f64) -> f64 {
    (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

/// Schlick's approximation for a coat of index 1.5.
fn coat_fresnel(cosine: f64) -> f64 {
    0.04 + 0.96 * schlick(cosine)
}

/// The clear coat: the distribution `D(h) ∝ 1/(1 + (α² - 1) h_z²)` of Berry (1923), with α from 0.1
/// to 0.001, and masking as by GGX of roughness 0.25.
struct Coat {
    alpha_squared: f64,
}

impl Coat {
    fn new(gloss: f64) -> Self {
        let alpha = 0.1 + (0.001 - 0.1) * gloss;
        Self { alpha_squared: alpha * alpha }
    }

    /// D, 1/sr.
    fn density(&self, h: DVec3) -> f64 {
        let a2 = self.alpha_squared;
        let e = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
        (a2 - 1.0) / (PI * libm::log(a2) * e)
    }

    /// f of a coat of strength 1.
    fn value(&self, pair: &Pair) -> f64 {
        let masking = Ggx::of_valid(0.25);
        let visible = masking.masking(pair.o) * masking.masking(pair.i);
        0.25 * coat_fresnel(pair.cosine) * self.density(pair.h) * visible
    }

    /// Normals have the density `D h_z`.
    fn pdf(&self, pair: &Pair) -> f64 {
        self.density(pair.h) * pair.h.z / (4.0 * pair.cosine * pair.i.z)
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let a2 = self.alpha_squared;
        let z2 = ((1.0 - libm::pow(a2, 1.0 - u.y)) / (1.0 - a2)).clamp(0.0, 1.0);
        let (sin, cos) = sin_cos_of_turn(u.x);
        let r = (1.0 - z2).sqrt();
        DVec3::new(r * cos, r * sin, z2.sqrt())
    }
}
