//! The effect of a shading normal that differs from the geometric one: the only place where
//! it is handled.
//!
//! With shading normal `n_s` the surface scatters `f |ω_light · n_s|` instead of `f |ω_light ·
//! n_g|`, so the path integral, whose geometry terms use geometric normals, sees the BSDF (Veach
//! 1997, section 5.3)
//!
//! ```text
//! f'(to_light, to_camera) = f(to_light, to_camera) · |to_light · n_s| / |to_light · n_g|
//! ```
//!
//! It is one function of the labelled pair, whichever way a path is traced. Densities per projected
//! solid angle change from the shading cosine to the geometric one by the same kind of factor,
//! `σ(ω) = |ω · n_s| / |ω · n_g|`, so that a camera walk's weight `f'/p⊥` is the model's own, and a
//! light walk's is the model's times `σ(to_light) / σ(to_camera)`.
//!
//! A direction that is on different sides of the two normals is in neither hemisphere: f' and the
//! densities are 0 there.
//!
//! A normal that a map has made is another function of the same labelled pair, see `map`.

mod map;

use super::{Bsdf, BsdfSample, DiracValue, LaneForm, Lobes, TransportMode};
use crate::geometry::{Frame, NormalOrigin, SurfacePoint, around};
use crate::lanes::{Lane, Mask, Vector};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// A BSDF at a point of a scene: takes world directions and accounts for the shading normal.
#[derive(Clone, Copy, Debug)]
pub struct ShadedBsdf<B> {
    bsdf: B,
    /// Around the shading normal.
    frame: Frame,
    geometric_normal: DVec3,
    /// True if the shading normal is that of a map and not the geometric one.
    is_mapped: bool,
}

impl<B: Bsdf> ShadedBsdf<B> {
    /// Places a BSDF at a surface point.
    #[inline(always)]
    #[must_use]
    pub fn new(bsdf: B, point: &SurfacePoint) -> Self {
        let frame = frame(&bsdf, point);
        let is_mapped = point.normal_origin == NormalOrigin::Map && !point.is_flat();
        Self { bsdf, frame, geometric_normal: point.geometric_normal, is_mapped }
    }

    /// The BSDF as its model defines it, in the local frame.
    #[must_use]
    pub fn model(&self) -> &B {
        &self.bsdf
    }

    /// The kinds of lobes at this point.
    #[inline]
    #[must_use]
    pub fn lobes(&self) -> Lobes {
        self.bsdf.lobes()
    }

    /// The form in which lanes can scatter what comes from or goes into a direction; `None` where
    /// the shading normal is not the geometric one.
    #[inline(always)]
    pub(crate) fn lane_form(&self, fixed: DVec3) -> Option<LaneForm> {
        if !self.is_flat() {
            return None;
        }
        self.bsdf.lane_form(self.frame.z.dot(fixed) >= 0.0)
    }

    /// `f'(to_light, to_camera)` in 1/sr, without Dirac lobes.
    #[inline]
    #[must_use]
    pub fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        if self.is_mapped {
            return self.eval_mapped(to_light, to_camera);
        }
        self.eval_unmapped(to_light, to_camera)
    }

    #[inline(always)]
    fn eval_unmapped(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        let (light, camera) = (self.frame.to_local(to_light), self.frame.to_local(to_camera));
        match (self.ratio(to_light, light), self.ratio(to_camera, camera)) {
            (Some(ratio), Some(_)) => self.bsdf.eval(light, camera) * ratio,
            _ => Rgb::BLACK,
        }
    }

    /// Density of `next` given `fixed`, per projected solid angle with the geometric cosine,
    /// without Dirac lobes.
    #[inline]
    #[must_use]
    pub fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        if self.is_mapped {
            return self.pdf_mapped(fixed, next, mode);
        }
        self.pdf_unmapped(fixed, next, mode)
    }

    #[inline(always)]
    fn pdf_unmapped(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        let (local_fixed, local_next) = (self.frame.to_local(fixed), self.frame.to_local(next));
        match (self.ratio(fixed, local_fixed), self.ratio(next, local_next)) {
            (Some(_), Some(ratio)) => self.bsdf.pdf(local_fixed, local_next, mode) * ratio,
            _ => PerProjected::ZERO,
        }
    }

    /// Both `eval` and the density with which a camera walk would sample `to_light`.
    #[inline]
    #[must_use]
    pub fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        if self.is_mapped {
            let mode = TransportMode::Radiance;
            let pdf = self.pdf_mapped(to_camera, to_light, mode);
            return (self.eval_mapped(to_light, to_camera), pdf);
        }
        let (light, camera) = (self.frame.to_local(to_light), self.frame.to_local(to_camera));
        match (self.ratio(to_light, light), self.ratio(to_camera, camera)) {
            (Some(ratio), Some(_)) => {
                let (value, pdf) = self.bsdf.eval_and_pdf(light, camera);
                (value * ratio, pdf * ratio)
            }
            _ => (Rgb::BLACK, PerProjected::ZERO),
        }
    }

    /// Samples the next direction of a walk; `None` if the walk ends here.
    #[inline(always)]
    #[must_use]
    pub fn sample(
        &self,
        fixed: DVec3,
        mode: TransportMode,
        u1: f64,
        u2: DVec2,
    ) -> Option<BsdfSample> {
        if self.is_mapped {
            return self.sample_mapped(fixed, mode, u1, u2);
        }
        self.sample_unmapped(fixed, mode, u1, u2)
    }

    #[inline(always)]
    fn sample_unmapped(
        &self,
        fixed: DVec3,
        mode: TransportMode,
        u1: f64,
        u2: DVec2,
    ) -> Option<BsdfSample> {
        let local_fixed = self.frame.to_local(fixed);
        let ratio_fixed = self.ratio(fixed, local_fixed)?;
        let sample = self.bsdf.sample(local_fixed, mode, u1, u2)?;
        self.placed(sample, fixed, local_fixed, ratio_fixed, mode)
    }

    /// The images of a direction under the Dirac lobes: what `sample` may return with `dirac` set.
    pub fn dirac_images(
        &self,
        fixed: DVec3,
        mode: TransportMode,
        image: &mut dyn FnMut(BsdfSample),
    ) {
        if self.is_mapped {
            return self.dirac_images_mapped(fixed, mode, image);
        }
        self.dirac_images_unmapped(fixed, mode, image);
    }

    fn dirac_images_unmapped(
        &self,
        fixed: DVec3,
        mode: TransportMode,
        image: &mut dyn FnMut(BsdfSample),
    ) {
        let local_fixed = self.frame.to_local(fixed);
        if let Some(ratio) = self.ratio(fixed, local_fixed) {
            self.bsdf.dirac_images(local_fixed, mode, &mut |local| {
                self.placed(local, fixed, local_fixed, ratio, mode)
                    .into_iter()
                    .for_each(&mut *image);
            });
        }
    }

    /// A sample of the model in world space, with the factor of the shading normal.
    #[inline(always)]
    fn placed(
        &self,
        mut sample: BsdfSample,
        fixed: DVec3,
        local_fixed: DVec3,
        ratio_fixed: f64,
        mode: TransportMode,
    ) -> Option<BsdfSample> {
        let local_next = sample.next;
        // Through a null interface the direction must stay the same to the last bit, so that it
        // cannot drift.
        sample.next = if local_next == -local_fixed {
            -fixed
        } else {
            renormalized::<f64>(self.frame.to_world(local_next).into()).into()
        };
        if !self.is_flat() {
            let ratio_next = self.ratio(sample.next, local_next)?;
            let (ratio_light, ratio_camera) = match mode {
                TransportMode::Radiance => (ratio_next, ratio_fixed),
                TransportMode::Importance => (ratio_fixed, ratio_next),
            };
            let (scale_to_light, scale_to_camera) = if sample.dirac {
                (1.0, ratio_camera / ratio_light)
            } else {
                (ratio_light, ratio_camera)
            };
            let (scale, scale_reverse) = match mode {
                TransportMode::Radiance => (scale_to_light, scale_to_camera),
                TransportMode::Importance => (scale_to_camera, scale_to_light),
            };
            sample.pdf = sample.pdf * scale;
            sample.pdf_reverse = sample.pdf_reverse * scale_reverse;
            if mode == TransportMode::Importance {
                sample.weight *= ratio_light / ratio_camera;
            }
        }
        Some(sample)
    }

    /// Coefficients of the Dirac lobe of a pair of directions that is known to be one of a Dirac
    /// lobe up to rounding ([`Bsdf::eval_dirac`]), of the Dirac distribution with respect to the
    /// projected solid angle (geometric cosine) of `to_light`.
    #[must_use]
    pub fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        if self.is_mapped {
            return self.eval_dirac_mapped(to_light, to_camera);
        }
        self.eval_dirac_unmapped(to_light, to_camera)
    }

    fn eval_dirac_unmapped(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        let (light, camera) = (self.frame.to_local(to_light), self.frame.to_local(to_camera));
        match (self.ratio(to_light, light), self.ratio(to_camera, camera)) {
            (Some(ratio_light), Some(ratio_camera)) => {
                let value = self.bsdf.eval_dirac(light, camera);
                DiracValue {
                    pdf_to_camera: value.pdf_to_camera * (ratio_camera / ratio_light),
                    ..value
                }
            }
            _ => DiracValue::default(),
        }
    }

    /// `|ω · n_s| / |ω · n_g|`, or `None` if the two normals see ω on different sides.
    #[inline]
    fn ratio(&self, direction: DVec3, local: DVec3) -> Option<f64> {
        if self.is_flat() {
            return Some(1.0);
        }
        let geometric = self.geometric_normal.dot(direction);
        (local.z * geometric > 0.0).then(|| local.z / geometric)
    }

    /// True if the shading normal is the geometric one.
    #[inline]
    fn is_flat(&self) -> bool {
        self.frame.z == self.geometric_normal
    }
}

/// The local frame of a BSDF at a surface point: z is the shading normal, and x follows the tangent
/// if the BSDF [is anisotropic](Bsdf::is_anisotropic).
#[inline(always)]
#[must_use]
pub fn frame<B: Bsdf + ?Sized>(bsdf: &B, point: &SurfacePoint) -> Frame {
    if point.tangent == DVec3::ZERO || !bsdf.is_anisotropic() {
        Frame::from_normal(point.shading_normal)
    } else {
        Frame::from_normal_and_tangent(point.shading_normal, point.tangent)
    }
}

/// A vector of unit length up to rounding, as which a turned one is, to unit length again: one step
/// of Newton's method for the inverse square root. A model of a user's may be less exact.
#[inline(always)]
fn renormalized<L: Lane>(v: Vector<L>) -> Vector<L> {
    let square = v.length_squared();
    let excess = square - 1.0;
    let is_near = excess.abs().less(excess.constant(1e-9));
    let mut scale = -(excess * 0.5) + 1.0;
    if !is_near.all() {
        scale = is_near.choose(scale, square.constant(1.0) / square.sqrt());
    }
    v * scale
}

/// Directions of the local frame around a normal, in world space, in lanes.
#[inline(always)]
pub(crate) fn to_world<L: Lane>(normal: Vector<L>, local: Vector<L>) -> Vector<L> {
    let [x, y] = around(normal);
    renormalized(x * local.x + y * local.y + normal * local.z)
}
