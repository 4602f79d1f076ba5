//! A clear coat over another model: the clear coat of glTF (`KHR_materials_clearcoat`, Khronos
//! 2020), in a form that conserves energy and is reciprocal.
//!
//! With the share c of the surface that is coated, Schlick's F of a coat of index 1.5, and a GGX
//! micro-surface,
//!
//! ```text
//! f    = c F(o·h) D G2 / (4 o_z i_z) + T f_base,
//! T    = 1 - c (1 - κ (1 - F(min(|o_z|, |i_z|)))),      F(μ) = 0.04 + 0.96 (1 - μ)⁵,  κ = 0.997.
//! ```
//!
//! The extension's own example weighs the base by `1 - c F` of the viewer's side alone, which is not
//! reciprocal. A factor of the base that leaves each of its directions at most what the coat does
//! not reflect, whatever the base is, is at most `1 - c F` of either end, so that the smaller of
//! both is the largest that is symmetric. It is that of the extension where the viewer is the end
//! nearer to the surface, or where both are equally near, such as in a mirror. The albedo of a rough
//! coat exceeds F by at most 0.26 % of `1 - F`, for which κ makes room, as in
//! [`MetallicRoughness`](super::MetallicRoughness).

use super::metallic_roughness::{ROOM_FOR_ROUGH_COATS, schlick};
use super::mirror::mirrored;
use super::rough_conductor::{Pair, sample_reflection};
use super::{
    Bsdf, BsdfError, BsdfSample, Ggx, Lobes, Microfacets, TransportMode, finite_sample, same_side,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// Reflectance of the coat at normal incidence: that of the index 1.5.
const F0: f64 = 0.04;

/// The albedo that the base is taken to have where a lobe is chosen.
const ALBEDO_OF_BASE: f64 = 0.5;

/// A model under a clear coat, on both sides of the surface. Single scattering in the coat's
/// micro-surface; what the base lets through is attenuated as what it reflects.
///
/// A roughness below 0.01 (α = roughness² < [`LEAST_ALPHA`](super::ggx::LEAST_ALPHA)) makes the
/// coat's reflection a Dirac lobe. A coat of the share 0 leaves the base to the bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coated<B> {
    base: B,
    share: f64,
    distribution: Microfacets,
}

impl<B: Bsdf> Coated<B> {
    /// A model of which the part `share` is coated, with the coat's roughness, both in [0, 1].
    ///
    /// # Errors
    /// If one of them is not in [0, 1].
    pub fn new(base: B, share: f64, roughness: f64) -> Result<Self, BsdfError> {
        let unit = 0.0..=1.0;
        if !unit.contains(&share) || !unit.contains(&roughness) {
            return Err(BsdfError::ClearCoat(share, roughness));
        }
        Ok(Self::of_valid(base, share, roughness))
    }

    /// The same of numbers that are in the range, but for a rounding error.
    pub(crate) fn of_valid(base: B, share: f64, roughness: f64) -> Self {
        let distribution = Microfacets::Ggx(Ggx::of_valid(roughness * roughness));
        Self { base, share: share.clamp(0.0, 1.0), distribution }
    }

    /// The model under the coat.
    pub(crate) const fn base(&self) -> &B {
        &self.base
    }

    /// c F
    fn reflectance(&self, cosine: f64) -> f64 {
        self.share * (F0 + (1.0 - F0) * schlick(cosine))
    }

    /// T, which depends on the direction that is nearer to the surface.
    fn transmittance(&self, a: DVec3, b: DVec3) -> f64 {
        let passing = (1.0 - F0) * (1.0 - schlick(a.z.abs().min(b.z.abs())));
        1.0 - self.share * (1.0 - ROOM_FOR_ROUGH_COATS * passing)
    }

    /// The probability of sampling the coat, seen from one direction.
    fn coat_probability(&self, direction: DVec3) -> f64 {
        let coat = self.reflectance(direction.z.abs());
        if coat > 0.0 && self.base.lobes() == Lobes::NONE {
            return 1.0;
        }
        coat / (coat + ALBEDO_OF_BASE * self.transmittance(direction, direction))
    }

    fn pair(&self, fixed: DVec3, next: DVec3) -> Option<Pair> {
        let is_glossy = self.share > 0.0 && !self.distribution.is_smooth();
        if is_glossy { Pair::new(fixed, next) } else { None }
    }

    /// The density of a direction that has these densities under the coat and under the base.
    fn mixed_pdf(&self, fixed: DVec3, coat: PerProjected, base: PerProjected) -> PerProjected {
        let probability = self.coat_probability(fixed);
        PerProjected(probability * coat.value() + (1.0 - probability) * base.value())
    }

    /// A sample of the base as one of the whole, of which the coat reflects a part in the same
    /// direction: its value, and its densities in both directions.
    fn joined(
        &self,
        fixed: DVec3,
        base: BsdfSample,
        (value, pdf, pdf_reverse): (f64, PerProjected, PerProjected),
    ) -> Option<BsdfSample> {
        let under = base.weight * (base.pdf.value() * self.transmittance(fixed, base.next));
        let pdf = self.mixed_pdf(fixed, pdf, base.pdf);
        let pdf_reverse = self.mixed_pdf(base.next, pdf_reverse, base.pdf_reverse);
        let weight = (under + Rgb::splat(value)) / pdf.value();
        (pdf.value() > 0.0).then_some(BsdfSample { weight, pdf, pdf_reverse, ..base })
    }

    /// The Dirac reflections of the coat and the base together.
    fn mirror_image(&self, fixed: DVec3, mode: TransportMode) -> Option<BsdfSample> {
        let mut base = BsdfSample::of_dirac(mirrored(fixed), Rgb::BLACK, 0.0);
        self.base.dirac_images(fixed, mode, &mut |image| {
            if image.next == base.next {
                base = image;
            }
        });
        self.joined(fixed, base, self.dirac_reflection(fixed))
    }

    /// The coat's Dirac reflection.
    fn dirac_reflection(&self, fixed: DVec3) -> (f64, PerProjected, PerProjected) {
        (self.reflectance(fixed.z.abs()), PerProjected(1.0), PerProjected(1.0))
    }

    /// True if an image is one of the coat's reflection.
    fn is_mirrored(&self, fixed: DVec3, next: DVec3) -> bool {
        self.share > 0.0 && self.distribution.is_smooth() && next == mirrored(fixed)
    }
}

impl<B: Bsdf> Bsdf for Coated<B> {
    fn lobes(&self) -> Lobes {
        let coat = match self.share {
            0.0 => Lobes::NONE,
            _ if self.distribution.is_smooth() => Lobes::DIRAC_REFLECTION,
            _ => Lobes::GLOSSY_REFLECTION,
        };
        coat | self.base.lobes()
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        let base = self.base.eval(to_light, to_camera) * self.transmittance(to_light, to_camera);
        self.pair(to_camera, to_light).map_or(base, |pair| {
            base + Rgb::splat(self.reflectance(pair.cosine) * pair.value(&self.distribution))
        })
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        let pair = self.pair(fixed, next);
        let coat = pair.map_or(PerProjected::ZERO, |pair| pair.pdf(&self.distribution));
        self.mixed_pdf(fixed, coat, self.base.pdf(fixed, next, mode))
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let (base, pdf) = self.base.eval_and_pdf(to_light, to_camera);
        let base = base * self.transmittance(to_light, to_camera);
        let (value, coat) =
            self.pair(to_camera, to_light).map_or((base, PerProjected::ZERO), |pair| {
                let lobe = pair.lobe(&self.distribution);
                let value = self.reflectance(pair.cosine) * lobe.value();
                (base + Rgb::splat(value), lobe.pdf())
            });
        (value, self.mixed_pdf(to_camera, coat, pdf))
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        if self.share == 0.0 {
            return self.base.sample(fixed, mode, u1, u2);
        }
        let coat = self.coat_probability(fixed);
        if u1 < coat {
            if !same_side(fixed, fixed) {
                return None;
            }
            if self.distribution.is_smooth() {
                return self.mirror_image(fixed, mode);
            }
            let next = sample_reflection(&self.distribution, fixed, u2)?;
            return finite_sample(self, fixed, next, mode);
        }
        let u1 = ((u1 - coat) / (1.0 - coat)).min(1.0f64.next_down());
        let base = self.base.sample(fixed, mode, u1, u2)?;
        let none = (0.0, PerProjected::ZERO, PerProjected::ZERO);
        let reflection = if base.dirac {
            if self.is_mirrored(fixed, base.next) { self.dirac_reflection(fixed) } else { none }
        } else {
            self.pair(fixed, base.next).map_or(none, |pair| {
                let lobe = pair.lobe(&self.distribution);
                let value = self.reflectance(pair.cosine) * lobe.value();
                (value, lobe.pdf(), pair.swapped().pdf(&self.distribution))
            })
        };
        self.joined(fixed, base, reflection)
    }

    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        if self.share == 0.0 {
            return self.base.dirac_images(fixed, mode, image);
        }
        if self.distribution.is_smooth() && same_side(fixed, fixed) {
            self.mirror_image(fixed, mode).into_iter().for_each(&mut *image);
        }
        self.base.dirac_images(fixed, mode, &mut |base| {
            if !self.is_mirrored(fixed, base.next) {
                let none = (0.0, PerProjected::ZERO, PerProjected::ZERO);
                self.joined(fixed, base, none).into_iter().for_each(&mut *image);
            }
        });
    }

    fn is_anisotropic(&self) -> bool {
        self.base.is_anisotropic()
    }
}
