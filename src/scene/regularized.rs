//! A scene whose Dirac lobes are narrow glossy ones (Kaplanyan and Dachsbacher 2013), so that all of
//! its paths can be connected and hit.
//!
//! Let n be the index of refraction on the side of a direction ω, τ its tangential part, so that
//! dσ⊥ = dτ, and n_s the smaller index of the two sides that a lobe joins. Refraction and reflection
//! keep the *slope* `z = n τ / √(n_s² - n² |τ|²)`, that of the direction on the side of n_s, up to
//! the sign of what passes; and `dz = n²/n_s² (1 + |z|²)² dτ`. In place of the Dirac distribution
//! comes a uniform disc of radius ε in the plane of slopes, κ = 1/(π ε²):
//!
//! ```text
//! f  = value · n_l²/n_s² · κ · (1 + |z_l|²) (1 + |z_image|²)         if |z_l - z_image| < ε
//! p⊥ = P · n_next²/n_s² · κ · (1 + |z_next|²)²                       f/p⊥ = value/P · (1 + O(ε))
//! ```
//!
//! with value and P those of the image of `to_camera` and of the fixed direction: f is one function
//! of the labelled pair, reciprocal as far as both ends have images of the same value. Along the
//! normal the disc is a cone of the angular radius ε. Horizon and critical angle are infinitely far
//! away, so that nothing is cut off there: what a camera walk is to scatter changes by O(ε²),
//! uniformly in the angle.

use super::{FlatSurfaces, Needs, Scene, SurfaceArea, answers_of_scene};
use crate::bsdf::fresnel::difference_of_squares;
use crate::bsdf::{Bsdf, BsdfError, BsdfSample, LaneForm, Lobes, TransportMode, on_same_side};
use crate::geometry::SurfacePoint;
use crate::math::warp::square_to_disk;
use crate::math::{Fingerprint, PerProjected, Rgb};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// A scene with all Dirac lobes mollified, those of what passes straight through as well: nothing is
/// left that an integrator could not connect or hit. All else is the scene's own.
///
/// A lobe becomes a uniform disc around its image, in the plane of slopes tan θ on the side of the
/// smaller index (after Kaplanyan and Dachsbacher 2013).
#[derive(Debug)]
pub struct Regularized<'a, S: ?Sized> {
    scene: &'a S,
    epsilon: f64,
}

impl<'a, S: ?Sized> Regularized<'a, S> {
    /// A scene with mollifiers of the radius `epsilon`, in radians near the normal.
    ///
    /// # Errors
    /// If `epsilon` is not in (0, 1].
    pub fn new(scene: &'a S, epsilon: f64) -> Result<Self, BsdfError> {
        checked_radius(epsilon).map(|epsilon| Self::of_valid(scene, epsilon))
    }

    /// The same of a radius that is known to be valid.
    pub(crate) const fn of_valid(scene: &'a S, epsilon: f64) -> Self {
        Self { scene, epsilon }
    }
}

/// A radius of mollifiers, if it is one.
pub(crate) fn checked_radius(epsilon: f64) -> Result<f64, BsdfError> {
    if epsilon > 0.0 && epsilon <= 1.0 { Ok(epsilon) } else { Err(BsdfError::Mollifier(epsilon)) }
}

impl<S: Scene + ?Sized> Scene for Regularized<'_, S> {
    type Bsdf<'b>
        = RegularizedBsdf<S::Bsdf<'b>>
    where
        Self: 'b;
    type Light = S::Light;

    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_> {
        RegularizedBsdf { bsdf: self.scene.bsdf(x), epsilon: self.epsilon }
    }
    fn needs(&self) -> Needs {
        self.scene.needs().regularized()
    }
    fn fingerprint(&self) -> Option<u64> {
        let scene = self.scene.fingerprint()?;
        Some(Fingerprint::default().with(scene).with(self.epsilon).get())
    }

    answers_of_scene!();

    // Those that are flat and diffuse have no Dirac lobes; others ask for their BSDFs.
    fn flat_surfaces(&self) -> Option<FlatSurfaces<'_>> {
        self.scene.flat_surfaces()
    }
}

impl<S: SurfaceArea + ?Sized> SurfaceArea for Regularized<'_, S> {
    fn total_area(&self) -> f64 {
        self.scene.total_area()
    }
    fn sample_surface(&self, u1: f64, u2: DVec2) -> SurfacePoint {
        self.scene.sample_surface(u1, u2)
    }
}

/// A BSDF with its Dirac lobes mollified, as those of [`Regularized`] are.
#[derive(Clone, Copy, Debug)]
pub struct RegularizedBsdf<B> {
    bsdf: B,
    epsilon: f64,
}

impl<B: Bsdf> RegularizedBsdf<B> {
    /// A BSDF with mollifiers of the radius `epsilon`.
    ///
    /// # Errors
    /// If `epsilon` is not in (0, 1].
    pub fn new(bsdf: B, epsilon: f64) -> Result<Self, BsdfError> {
        checked_radius(epsilon).map(|epsilon| Self { bsdf, epsilon })
    }

    fn has_dirac_lobes(&self) -> bool {
        self.bsdf.lobes().intersects(Lobes::DIRAC)
    }

    /// The density of `next` around the images of `fixed`, and the same of their values, which is f
    /// of a camera walk.
    fn around_images(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> (Rgb, f64) {
        let (mut value, mut pdf) = (Rgb::BLACK, 0.0);
        if !self.has_dirac_lobes() {
            return (value, pdf);
        }
        let square = self.epsilon * self.epsilon;
        self.bsdf.dirac_images(fixed, mode, &mut |image| {
            let ratio = smaller_over_next(&image);
            let slopes = [image.next, next].map(|direction| slope(direction, ratio));
            let [Some(center), Some(z)] = slopes else { return };
            if on_same_side(image.next.z, next.z) && center.distance_squared(z) < square {
                let [at_image, at_next] = [center, z].map(|z| 1.0 + z.length_squared());
                let kappa = at_next / (PI * square * ratio * ratio);
                // No density has digits for more than some 1e-75 from the horizon.
                if (kappa * at_image).is_finite() && (kappa * at_next).is_finite() {
                    value += image.dirac_value(mode).value * (kappa * at_image);
                    pdf += image.dirac_probability(mode) * (kappa * at_next);
                }
            }
        });
        (value, pdf)
    }

    /// A direction around an image.
    fn around(&self, image: &BsdfSample, u: DVec2) -> Option<DVec3> {
        let ratio = smaller_over_next(image);
        let z = slope(image.next, ratio)? + square_to_disk(u) * self.epsilon;
        let square = 1.0 + z.length_squared();
        let cosine = ((1.0 + (1.0 - ratio) * (1.0 + ratio) * z.length_squared()) / square).sqrt();
        Some((z * (ratio / square.sqrt())).extend(cosine.copysign(image.next.z)))
    }
}

/// n_s / n on the side of an image.
fn smaller_over_next(image: &BsdfSample) -> f64 {
    (1.0 / image.relative_ior).min(1.0)
}

/// The slope of a direction, given n_s / n; `None` from the critical angle on.
fn slope(direction: DVec3, ratio: f64) -> Option<DVec2> {
    let tangential = direction.truncate();
    let square = difference_of_squares(ratio, direction.z.abs(), tangential.length());
    (square > 0.0).then(|| tangential / square.sqrt())
}

impl<B: Bsdf> Bsdf for RegularizedBsdf<B> {
    fn lobes(&self) -> Lobes {
        self.bsdf.lobes().regularized()
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        let (mollified, _) = self.around_images(to_camera, to_light, TransportMode::Radiance);
        self.bsdf.eval(to_light, to_camera) + mollified
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        let (_, mollified) = self.around_images(fixed, next, mode);
        PerProjected(self.bsdf.pdf(fixed, next, mode).value() + mollified)
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let (value, pdf) = self.bsdf.eval_and_pdf(to_light, to_camera);
        let (mollified, more) = self.around_images(to_camera, to_light, TransportMode::Radiance);
        (value + mollified, PerProjected(pdf.value() + more))
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let sample = self.bsdf.sample(fixed, mode, u1, u2)?;
        if !self.has_dirac_lobes() {
            return Some(sample);
        }
        let next = if sample.dirac { self.around(&sample, u2)? } else { sample.next };
        let (to_light, to_camera) = mode.label(fixed, next);
        let there = self.around_images(fixed, next, mode);
        let back = self.around_images(next, fixed, mode.reversed());
        let mollified = if mode == TransportMode::Radiance { there.0 } else { back.0 };
        let pdf = self.bsdf.pdf(fixed, next, mode).value() + there.1;
        let pdf_reverse = self.bsdf.pdf(next, fixed, mode.reversed()).value() + back.1;
        (pdf > 0.0).then(|| BsdfSample {
            next,
            weight: (self.bsdf.eval(to_light, to_camera) + mollified) / pdf,
            pdf: PerProjected(pdf),
            pdf_reverse: PerProjected(pdf_reverse),
            dirac: false,
            relative_ior: sample.relative_ior,
        })
    }

    fn is_anisotropic(&self) -> bool {
        self.bsdf.is_anisotropic()
    }

    // A form of today has no Dirac lobes.
    fn lane_form(&self, front: bool) -> Option<LaneForm> {
        self.bsdf.lane_form(front)
    }
}
