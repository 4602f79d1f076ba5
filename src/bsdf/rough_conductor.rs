//! The rough conductor: a micro-surface of mirrors (Walter et al. 2007, eq. 20), `f = R D G2 / (4
//! o_z i_z)`.

use super::fresnel::Reflectance;
use super::ggx::LEAST_COSINE;
use super::microfacets::Masked;
use super::mirror::mirror_image;
use super::{Bsdf, BsdfSample, Lobes, Microfacets, TransportMode};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// Glossy reflection on both sides of the surface, single scattering: what hits the micro-surface
/// twice is lost.
///
/// A distribution that [is smooth](Microfacets::is_smooth) makes it the Dirac mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    reflectance: Reflectance,
    distribution: Microfacets,
}

impl RoughConductor {
    /// A rough mirror; the ingredients have been validated by their own constructors.
    #[must_use]
    pub fn new(reflectance: Reflectance, distribution: impl Into<Microfacets>) -> Self {
        Self { reflectance, distribution: distribution.into() }
    }

    /// The same metal with other roughnesses, at most 10; never smooth.
    pub(super) const fn with_roughness(self, alpha_x: f64, alpha_y: f64) -> Self {
        Self { distribution: self.distribution.with_roughness(alpha_x, alpha_y), ..self }
    }

    /// The pair seen from `fixed`'s side with its half vector; `None` where there is no finite
    /// reflection.
    #[inline]
    fn pair(&self, fixed: DVec3, next: DVec3) -> Option<Pair> {
        if self.distribution.is_smooth() { None } else { Pair::new(fixed, next) }
    }

    fn reflectance(&self, pair: &Pair) -> Rgb {
        self.reflectance.at(pair.cosine, pair.o.cross(pair.h).length())
    }
}

impl Bsdf for RoughConductor {
    #[inline]
    fn lobes(&self) -> Lobes {
        if self.distribution.is_smooth() {
            Lobes::DIRAC_REFLECTION
        } else {
            Lobes::GLOSSY_REFLECTION
        }
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.pair(to_camera, to_light)
            .map_or(Rgb::BLACK, |pair| self.reflectance(&pair) * pair.value(&self.distribution))
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        self.pair(to_camera, to_light).map_or((Rgb::BLACK, PerProjected::ZERO), |pair| {
            let lobe = pair.lobe(&self.distribution);
            (self.reflectance(&pair) * lobe.value(), lobe.pdf())
        })
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, _walk: TransportMode) -> PerProjected {
        self.pair(fixed, next).map_or(PerProjected::ZERO, |pair| pair.pdf(&self.distribution))
    }

    fn sample(
        &self,
        fixed: DVec3,
        _walk: TransportMode,
        _u1: f64,
        u2: DVec2,
    ) -> Option<BsdfSample> {
        if self.distribution.is_smooth() {
            return mirror_image(self.reflectance, fixed);
        }
        let next = sample_reflection(&self.distribution, fixed, u2)?;
        let pair = self.pair(fixed, next)?;
        let lobe = pair.lobe(&self.distribution);
        Some(BsdfSample {
            next,
            weight: self.reflectance(&pair) * lobe.shadowing(),
            pdf: lobe.pdf(),
            pdf_reverse: lobe.pdf_reverse(),
            dirac: false,
            relative_ior: 1.0,
        })
    }

    fn dirac_images(&self, fixed: DVec3, _walk: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        if self.distribution.is_smooth() {
            mirror_image(self.reflectance, fixed).into_iter().for_each(image);
        }
    }
}

/// Two directions on the same side, seen as the upper one, and the normal that mirrors one into the
/// other.
///
/// Sampling evaluates the direction that it returns through this, too: no rounding of the sampled
/// normal can then make its density differ from that of `pdf`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub o: DVec3,
    pub i: DVec3,
    pub h: DVec3,
    /// o · h = i · h
    pub cosine: f64,
}

impl Pair {
    #[inline]
    pub fn new(fixed: DVec3, next: DVec3) -> Option<Self> {
        let (o, i) = (upwards(fixed, fixed), upwards(next, fixed));
        if !is_above(o) || !is_above(i) {
            return None;
        }
        let h = (o + i).try_normalize()?;
        Some(Self { o, i, h, cosine: o.dot(h) })
    }

    pub fn swapped(self) -> Self {
        Self { o: self.i, i: self.o, ..self }
    }

    /// What a distribution makes of it.
    #[inline]
    pub fn lobe(&self, distribution: &Microfacets) -> Lobe {
        let density = distribution.density(self.h);
        Lobe { cosines: [self.o.z, self.i.z], density, masked: distribution.masked(self.o, self.i) }
    }

    #[inline]
    pub fn value(&self, distribution: &Microfacets) -> f64 {
        self.lobe(distribution).value()
    }

    #[inline]
    pub fn pdf(&self, distribution: &Microfacets) -> PerProjected {
        self.lobe(distribution).pdf()
    }
}

/// A pair under a distribution of micro-normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// o_z and i_z.
    cosines: [f64; 2],
    /// D(h).
    density: f64,
    masked: Masked,
}

impl Lobe {
    /// `D G2 / (4 o_z i_z)`
    #[inline]
    pub fn value(&self) -> f64 {
        0.5 * self.density * self.masked.correlation
    }

    /// `D G1 G1 / (4 o_z i_z)`: the value if masking and shadowing are independent.
    #[inline]
    pub fn value_of_independent(&self) -> f64 {
        0.25 * (self.density / self.masked.areas[0]) / self.masked.areas[1]
    }

    /// `D_o(h) / (4 (o·h)) / i_z`: the density of visible normals, the Jacobian of mirroring, and
    /// the local cosine.
    #[inline]
    pub fn pdf(&self) -> PerProjected {
        PerProjected(0.25 * (self.density / self.masked.areas[0]) / self.cosines[1])
    }

    /// The density of o given i.
    #[inline]
    pub fn pdf_reverse(&self) -> PerProjected {
        PerProjected(0.25 * (self.density / self.masked.areas[1]) / self.cosines[0])
    }

    /// `G2(o, i) / G1(o)`
    #[inline]
    pub fn shadowing(&self) -> f64 {
        2.0 * self.cosines[1] * self.masked.areas[0] * self.masked.correlation
    }
}

/// The direction with z seen from the side of `viewer`: positive if it is on the same side.
#[inline]
pub(super) fn upwards(direction: DVec3, viewer: DVec3) -> DVec3 {
    DVec3::new(direction.x, direction.y, if viewer.z < 0.0 { -direction.z } else { direction.z })
}

/// True if the rough models see a direction at all.
#[inline]
pub(super) fn is_above(direction: DVec3) -> bool {
    direction.z >= LEAST_COSINE
}

/// `fixed` mirrored in a visible normal.
pub(super) fn sample_reflection(
    distribution: &Microfacets,
    fixed: DVec3,
    u: DVec2,
) -> Option<DVec3> {
    let o = upwards(fixed, fixed);
    if !is_above(o) {
        return None;
    }
    let h = distribution.sample_visible(o, u)?;
    reflect(o, h).map(|i| upwards(i, fixed))
}

/// The mirror image of `o` in the normal `h`, if it leaves the surface.
#[inline]
pub(super) fn reflect(o: DVec3, h: DVec3) -> Option<DVec3> {
    let i = (2.0 * o.dot(h) * h - o).normalize();
    (i.z > 0.0).then_some(i)
}
