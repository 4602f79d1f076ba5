//! The smooth conductor (polished metal): a mirror with Fresnel's reflectance.

use super::fresnel::Reflectance;
use super::mirror::{eval_mirror, sample_mirror};
use super::{Bsdf, BsdfError, BsdfSample, DiracValue, Lobes, Walk};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// Dirac reflection on both sides of a sheet of metal; what is not reflected is absorbed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    reflectance: Reflectance,
}

impl Conductor {
    /// A conductor with the index of refraction `eta + i k` relative to the medium around it.
    ///
    /// # Errors
    /// If a component is not in [0, 1e6].
    pub fn new(eta: Rgb, k: Rgb) -> Result<Self, BsdfError> {
        Reflectance::conductor(eta, k).map(|reflectance| Self { reflectance })
    }
}

impl Bsdf for Conductor {
    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::DIRAC_REFLECTION
    }

    #[inline]
    fn eval(&self, _to_light: DVec3, _to_camera: DVec3) -> Rgb {
        Rgb::BLACK
    }

    #[inline]
    fn pdf(&self, _fixed: DVec3, _next: DVec3, _walk: Walk) -> PerProjected {
        PerProjected::ZERO
    }

    #[inline]
    fn sample(&self, fixed: DVec3, _walk: Walk, _u1: f64, _u2: DVec2) -> Option<BsdfSample> {
        sample_mirror(self.reflectance, fixed)
    }

    #[inline]
    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        eval_mirror(self.reflectance, to_light, to_camera)
    }
}
