//! The perfect mirror: `f = reflectance · δ⊥(to_light - mirrored(to_camera))`.

use super::fresnel::Reflectance;
use super::{
    Bsdf, BsdfError, BsdfSample, DIRAC_TOLERANCE, DiracValue, Lobes, Walk, same_side, sine,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// Dirac reflection on both sides of the surface with the same reflectance at all angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    reflectance: Reflectance,
}

impl Mirror {
    /// A mirror that reflects the fraction `reflectance` of the light.
    ///
    /// # Errors
    /// If a channel of `reflectance` is not in [0, 1].
    pub fn new(reflectance: Rgb) -> Result<Self, BsdfError> {
        Reflectance::constant(reflectance).map(|reflectance| Self { reflectance })
    }
}

impl Bsdf for Mirror {
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

/// The direction mirrored in the normal.
#[inline]
pub(super) fn mirrored(direction: DVec3) -> DVec3 {
    DVec3::new(-direction.x, -direction.y, direction.z)
}

/// Whether one direction is the mirror image of the other, up to rounding.
#[inline]
pub(super) fn is_mirrored(a: DVec3, b: DVec3) -> bool {
    same_side(a, b) && (a + b).truncate().length_squared() < DIRAC_TOLERANCE * DIRAC_TOLERANCE
}

/// [`Bsdf::sample`] of everything that only mirrors.
pub(super) fn sample_mirror(reflectance: Reflectance, fixed: DVec3) -> Option<BsdfSample> {
    same_side(fixed, fixed).then(|| BsdfSample {
        next: mirrored(fixed),
        weight: reflectance.at(fixed.z.abs(), sine(fixed)),
        pdf: PerProjected(1.0),
        pdf_reverse: PerProjected(1.0),
        dirac: true,
        relative_ior: 1.0,
    })
}

/// [`Bsdf::eval_dirac`] of everything that only mirrors.
pub(super) fn eval_mirror(
    reflectance: Reflectance,
    to_light: DVec3,
    to_camera: DVec3,
) -> DiracValue {
    if !is_mirrored(to_light, to_camera) {
        return DiracValue::default();
    }
    DiracValue {
        value: reflectance.at(to_camera.z.abs(), sine(to_camera)),
        pdf_to_light: PerProjected(1.0),
        pdf_to_camera: PerProjected(1.0),
    }
}
