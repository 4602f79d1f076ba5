//! The metallic-roughness material of glTF 2.0 (Khronos 2021, appendix B), in a form that conserves
//! energy and is reciprocal.
//!
//! With base colour b, metalness m, a GGX micro-surface, and Schlick's weight `S(c) = (1 - c)⁵`, a
//! fraction m of the surface is metal and the rest is a diffuse body under a dielectric coat of
//! reflectance f at normal incidence:
//!
//! ```text
//! f_r     = F(o·h) D G2 / (4 o_z i_z) + diffuse,
//! diffuse = (1 - m) b/π · κ (1 - F_d(o_z)) (1 - F_d(i_z)) / (1 - F̄_d),
//! F(c)    = f0 + (1 - f0) S(c),    f0 = (1 - m) f + m b,
//! ```
//!
//! where F_d is F of the coat alone and F̄_d its mean f + (1 - f)/21. Both terms are symmetric in o
//! and i: `o·h = i·h`. The reflection is that of the specification, where Schlick's linearity in f0
//! makes the mix of both parts one term. The diffuse part is not: the specification's example
//! weighs it by `1 - F_d(o·h)`, whose sum with the reflection exceeds 1 (it is 1.89 at μ = 0.01
//! under a white body). It is weighed here as Kelemen and Szirmay-Kalos (2001) do, by what the coat
//! lets in and out at either end, with the coat's albedo taken to be its reflectance if it were
//! smooth. That makes the albedo of a smooth coat over a white body exactly κ (1 - F_d) + F_d; on
//! rough coats the reflection exceeds F_d by at most 0.26 % of `1 - F_d` (at α = 0.15), which κ =
//! 0.997 makes room for.

use super::error::checked_reflectance;
use super::fresnel::checked_relative_ior;
use super::mirror::mirrored;
use super::rough_conductor::{Pair, sample_reflection};
use super::{
    Bsdf, BsdfError, BsdfSample, Ggx, Lobes, Microfacets, TransportMode, finite_sample, same_side,
    sample_diffuse,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// κ: what the diffuse part leaves to rough coats, whose albedo is not quite that of smooth ones.
pub(super) const ROOM_FOR_ROUGH_COATS: f64 = 0.997;

/// Metal, or a diffuse body under a dielectric coat, or a mixture of both, on both sides of the
/// surface. Single scattering in the micro-surface.
///
/// A roughness below 0.01 (α = roughness² < [`LEAST_ALPHA`](super::ggx::LEAST_ALPHA)) makes the
/// reflection a Dirac lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetallicRoughness {
    distribution: Microfacets,
    /// Reflectance of metal and coat together at normal incidence.
    f0: Rgb,
    /// Diffuse albedo before Schlick's weights of both ends.
    body: Rgb,
    /// Reflectance of the coat at normal incidence.
    coat: f64,
}

impl MetallicRoughness {
    /// A surface with the given base colour, metalness and roughness, all in [0, 1]. `relative_ior`
    /// = n_coat / n_outside is 1.5 for most files.
    ///
    /// # Errors
    /// If a channel of the colour, the metalness, or the roughness is not in [0, 1], or
    /// `relative_ior` is not in [1e-6, 1e6].
    pub fn new(
        base_color: Rgb,
        metalness: f64,
        roughness: f64,
        relative_ior: f64,
    ) -> Result<Self, BsdfError> {
        let base_color = checked_reflectance(base_color)?;
        let relative_ior = checked_relative_ior(relative_ior)?;
        let unit = 0.0..=1.0;
        if !unit.contains(&metalness) || !unit.contains(&roughness) {
            return Err(BsdfError::MetallicRoughness(metalness, roughness));
        }
        let coat = ((relative_ior - 1.0) / (relative_ior + 1.0)).powi(2);
        let blank = Self {
            distribution: Microfacets::Ggx(Ggx::of_valid(0.0)),
            f0: Rgb::BLACK,
            body: Rgb::BLACK,
            coat,
        };
        Ok(blank.with(base_color, metalness, roughness))
    }

    /// The same coat over another surface, with parameters that must be in [0, 1].
    pub(crate) fn with(self, base_color: Rgb, metalness: f64, roughness: f64) -> Self {
        let coat = self.coat;
        // Interpolated textures may leave the range by a rounding error.
        let metalness = metalness.clamp(0.0, 1.0);
        let alpha = roughness * roughness;
        let f0 =
            (Rgb::splat(coat) * (1.0 - metalness) + base_color * metalness).map(|f| f.min(1.0));
        // (1 - F_d)(1 - F_d)/(1 - F̄_d) with 1 - F_d = (1 - f)(1 - S) and 1 - F̄_d = (1 - f) 20/21
        let body =
            base_color * ((1.0 - metalness) * ROOM_FOR_ROUGH_COATS * (1.0 - coat) * (21.0 / 20.0));
        Self { distribution: Microfacets::Ggx(Ggx::of_valid(alpha)), f0, body, coat }
    }

    fn fresnel(&self, cosine: f64) -> Rgb {
        let weight = schlick(cosine);
        self.f0.map(|f0| f0 + (1.0 - f0) * weight)
    }

    /// The probability of sampling the reflection, seen from one direction: in proportion to how
    /// much it reflects if it is smooth.
    fn coat_probability(&self, direction: DVec3) -> f64 {
        let weight = schlick(direction.z.abs());
        let coat = self.f0.mean() * (1.0 - weight) + weight;
        let body = self.body.mean() * (1.0 - weight);
        // Neither only where nothing is reflected at all.
        if coat + body > 0.0 { coat / (coat + body) } else { 1.0 }
    }

    fn diffuse(&self, a: DVec3, b: DVec3) -> Rgb {
        self.body * (FRAC_1_PI * (1.0 - schlick(a.z.abs())) * (1.0 - schlick(b.z.abs())))
    }

    /// The density of the direction that has some density under the reflection alone.
    fn mixed_pdf(&self, fixed: DVec3, glossy: f64) -> PerProjected {
        let coat = self.coat_probability(fixed);
        PerProjected(coat * glossy + (1.0 - coat) * FRAC_1_PI)
    }

    fn glossy_pair(&self, fixed: DVec3, next: DVec3) -> Option<Pair> {
        if self.distribution.is_smooth() { None } else { Pair::new(fixed, next) }
    }

    /// The Dirac reflection, chosen with the probability `coat`.
    fn coat_image(&self, fixed: DVec3, coat: f64) -> BsdfSample {
        BsdfSample::of_dirac(mirrored(fixed), self.fresnel(fixed.z.abs()) / coat, coat)
    }
}

/// `(1 - c)⁵`
pub(super) fn schlick(cosine: f64) -> f64 {
    (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

impl Bsdf for MetallicRoughness {
    #[inline]
    fn lobes(&self) -> Lobes {
        let coat = if self.distribution.is_smooth() {
            Lobes::DIRAC_REFLECTION
        } else {
            Lobes::GLOSSY_REFLECTION
        };
        if self.body.is_black() { coat } else { coat | Lobes::DIFFUSE_REFLECTION }
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        if !same_side(to_light, to_camera) {
            return Rgb::BLACK;
        }
        let glossy = self
            .glossy_pair(to_camera, to_light)
            .map_or(Rgb::BLACK, |pair| self.fresnel(pair.cosine) * pair.value(&self.distribution));
        glossy + self.diffuse(to_light, to_camera)
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _mode: TransportMode) -> PerProjected {
        if !same_side(fixed, next) {
            return PerProjected::ZERO;
        }
        let glossy =
            self.glossy_pair(fixed, next).map_or(0.0, |pair| pair.pdf(&self.distribution).value());
        self.mixed_pdf(fixed, glossy)
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        if !same_side(to_light, to_camera) {
            return (Rgb::BLACK, PerProjected::ZERO);
        }
        let (glossy, pdf) =
            self.glossy_pair(to_camera, to_light).map_or((Rgb::BLACK, 0.0), |pair| {
                let lobe = pair.lobe(&self.distribution);
                (self.fresnel(pair.cosine) * lobe.value(), lobe.pdf().value())
            });
        (glossy + self.diffuse(to_light, to_camera), self.mixed_pdf(to_camera, pdf))
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        if !same_side(fixed, fixed) {
            return None;
        }
        let coat = self.coat_probability(fixed);
        if u1 < coat && self.distribution.is_smooth() {
            return Some(self.coat_image(fixed, coat));
        }
        let next = if u1 < coat {
            sample_reflection(&self.distribution, fixed, u2)?
        } else {
            sample_diffuse(fixed, u2)
        };
        finite_sample(self, fixed, next, mode)
    }

    fn dirac_images(&self, fixed: DVec3, _mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        if self.distribution.is_smooth() && same_side(fixed, fixed) {
            let coat = self.coat_probability(fixed);
            if coat > 0.0 {
                image(self.coat_image(fixed, coat));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    fn towards(cosine: f64) -> DVec3 {
        DVec3::new(((1.0 - cosine) * (1.0 + cosine)).sqrt(), 0.0, cosine)
    }

    /// Albedo of the reflection alone: the mean weight of visible normals, by the midpoint rule.
    fn coat_albedo(bsdf: &MetallicRoughness, fixed: DVec3) -> f64 {
        const N: usize = 96;
        let at = |i: usize| (i as f64 + 0.5) / N as f64;
        let weight = |u: DVec2| {
            let next = sample_reflection(&bsdf.distribution, fixed, u)?;
            let pair = Pair::new(fixed, next)?;
            Some(bsdf.fresnel(pair.cosine).mean() * bsdf.distribution.shadowing(pair.o, pair.i))
        };
        (0..N * N).filter_map(|cell| weight(DVec2::new(at(cell / N), at(cell % N)))).sum::<f64>()
            / (N * N) as f64
    }

    /// The largest excess that the module's comment speaks of, over all angles and roughnesses: κ
    /// makes room for it, and not for much more.
    #[test]
    fn white_bodies_reflect_almost_everything_and_never_more() {
        let mut largest: f64 = 0.0;
        for relative_ior in [1.0, 1.5, 3.0] {
            for alpha in [1e-4, 0.02, 0.05, 0.1, 0.13, 0.15, 0.17, 0.2, 0.3, 0.5, 0.7, 1.0f64] {
                let bsdf =
                    MetallicRoughness::new(Rgb::WHITE, 0.0, alpha.sqrt(), relative_ior).unwrap();
                for k in 1..=25 {
                    let fixed = towards(f64::from(k) / 25.0);
                    // ∫ 2 μ (1 - S(μ)) dμ = 20/21
                    let diffuse = bsdf.body.mean() * (1.0 - schlick(fixed.z)) * (20.0 / 21.0);
                    largest = largest.max(diffuse + coat_albedo(&bsdf, fixed));
                }
            }
        }
        assert!((0.9985..=1.0).contains(&largest), "{largest}");
    }

    #[test]
    fn values_are_those_of_the_formula() {
        let base = Rgb::new(0.9, 0.5, 0.1);
        let (o, i) = (DVec3::new(0.48, 0.36, 0.8), DVec3::new(-0.6, 0.0, 0.8));
        let h = (o + i).normalize();
        let (alpha, metalness) = (0.36f64, 0.25);
        let e = (1.0 - h.z * h.z) + (alpha * h.z).powi(2);
        let d = alpha * alpha / (PI * e * e);
        let lambda =
            |w: DVec3| 0.5 * ((1.0 + alpha * alpha * (1.0 - w.z * w.z) / (w.z * w.z)).sqrt() - 1.0);
        let specular = d / (1.0 + lambda(o) + lambda(i)) / (4.0 * o.z * i.z);
        let coat = |f: f64, c: f64| f + (1.0 - f) * (1.0 - c).powi(5);
        let bsdf = MetallicRoughness::new(base, metalness, 0.6, 1.5).unwrap();
        for c in 0..3 {
            let under = base[c] / PI * 0.997 * (1.0 - coat(0.04, o.z)) * (1.0 - coat(0.04, i.z))
                / (1.0 - (0.04 + 0.96 / 21.0));
            let mixed = (1.0 - metalness) * (under + coat(0.04, o.dot(h)) * specular)
                + metalness * coat(base[c], o.dot(h)) * specular;
            assert_relative_eq!(bsdf.eval(i, o)[c], mixed, max_relative = 1e-12);
        }
    }
}
