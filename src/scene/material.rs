//! Materials: the parameters that a scene stores, and the scattering model they become at a point.

use super::error::{SceneError, check_reflectance};
use crate::bsdf::{Bsdf, BsdfSample, Lobes, Walk};
use crate::geometry::SurfacePoint;
use crate::math::{PerProjected, Rgb, warp};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// How a surface scatters, before a point on it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Material {
    /// Absorbs everything.
    #[default]
    Black,
    /// Lambertian reflection on both sides.
    Lambert {
        /// Reflected fraction, 0 to 1.
        albedo: Rgb,
    },
}

impl Material {
    /// Checks the parameters.
    pub(crate) fn validate(&self, name: &str) -> Result<(), SceneError> {
        match self {
            Self::Black => Ok(()),
            Self::Lambert { albedo } => check_reflectance(name, "albedo", *albedo),
        }
    }

    /// All lobes that the material can have at any point.
    pub(crate) fn lobes(&self) -> Lobes {
        match self {
            Self::Black => Lobes::NONE,
            Self::Lambert { .. } => Lobes::DIFFUSE_REFLECTION,
        }
    }

    /// The model at a point.
    #[inline]
    pub(crate) fn model(&self, _point: &SurfacePoint) -> Model {
        match *self {
            Self::Black => Model::Black,
            Self::Lambert { albedo } => Model::Lambert { albedo },
        }
    }
}

/// The scattering model at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Model {
    /// Absorbs everything.
    Black,
    /// Lambertian reflection on both sides.
    Lambert {
        /// Reflected fraction.
        albedo: Rgb,
    },
}

impl Bsdf for Model {
    fn lobes(&self) -> Lobes {
        match self {
            Self::Black => Lobes::NONE,
            Self::Lambert { .. } => Lobes::DIFFUSE_REFLECTION,
        }
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        match *self {
            Self::Lambert { albedo } if to_light.z * to_camera.z > 0.0 => albedo * FRAC_1_PI,
            _ => Rgb::BLACK,
        }
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, _walk: Walk) -> PerProjected {
        let lambert = matches!(self, Self::Lambert { .. });
        if lambert && fixed.z * next.z > 0.0 { PerProjected(FRAC_1_PI) } else { PerProjected::ZERO }
    }

    fn sample(&self, fixed: DVec3, _walk: Walk, _u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let Self::Lambert { albedo } = *self else { return None };
        let mut next = warp::square_to_cosine_hemisphere(u2);
        next.z = next.z.copysign(fixed.z);
        let pdf = PerProjected(FRAC_1_PI);
        (fixed.z != 0.0 && next.z != 0.0).then_some(BsdfSample {
            next,
            weight: albedo,
            pdf,
            pdf_reverse: pdf,
            dirac: false,
            relative_ior: 1.0,
        })
    }
}
