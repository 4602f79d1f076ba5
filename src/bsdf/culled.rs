//! Surfaces without a back.

use super::{Bsdf, BsdfSample, Lobes, Null, TransportMode};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// A surface that is not there for whoever looks at its back: back-face culling as a BSDF.
///
/// The front shows the model, `f(to_light, to_camera)` with `to_camera` on the front. Seen from the
/// back it is `δ⊥(to_light + to_camera)`: light that falls on the front goes on to the camera
/// behind it, and what falls on the back is stopped unless the model lets it through. As a function
/// of the labelled pair that is the same for all integrators, but not reciprocal: light on the
/// front is both scattered and let through, so that light walks may gain energy. Radiance does
/// not grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Culled<B>(pub B);

/// The part of light walks that pass from the front: few of them meet a camera behind.
const PASSING: f64 = 0.25;

impl<B: Bsdf> Culled<B> {
    /// The probability with which a light walk asks the model where to go.
    fn asking(to_light: DVec3) -> f64 {
        if to_light.z > 0.0 { 1.0 - PASSING } else { 1.0 }
    }

    /// The image straight ahead.
    fn passed(fixed: DVec3, mode: TransportMode) -> BsdfSample {
        let probabilities = [PerProjected(1.0), PerProjected(PASSING)];
        let [pdf, pdf_reverse] = match mode {
            TransportMode::Radiance => probabilities,
            TransportMode::Importance => [probabilities[1], probabilities[0]],
        };
        let sample = BsdfSample::of_dirac(-fixed, Rgb::splat(1.0 / pdf.value()), pdf.value());
        BsdfSample { pdf_reverse, ..sample }
    }

    /// A sample of the model as one of the culled surface; `None` if nobody sees it.
    fn seen(sample: BsdfSample, fixed: DVec3, mode: TransportMode) -> Option<BsdfSample> {
        let (to_light, to_camera) = mode.label(fixed, sample.next);
        let asking = Self::asking(to_light);
        (to_camera.z > 0.0).then(|| match mode {
            TransportMode::Radiance => {
                BsdfSample { pdf_reverse: sample.pdf_reverse * asking, ..sample }
            }
            TransportMode::Importance => {
                BsdfSample { weight: sample.weight / asking, pdf: sample.pdf * asking, ..sample }
            }
        })
    }
}

impl<B: Bsdf> Bsdf for Culled<B> {
    fn lobes(&self) -> Lobes {
        self.0.lobes() | Null.lobes()
    }

    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        if to_camera.z > 0.0 { self.0.eval(to_light, to_camera) } else { Rgb::BLACK }
    }

    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        let (to_light, to_camera) = mode.label(fixed, next);
        let asking = match mode {
            TransportMode::Radiance => 1.0,
            TransportMode::Importance => Self::asking(to_light),
        };
        if to_camera.z > 0.0 { self.0.pdf(fixed, next, mode) * asking } else { PerProjected::ZERO }
    }

    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        if to_camera.z > 0.0 {
            self.0.eval_and_pdf(to_light, to_camera)
        } else {
            (Rgb::BLACK, PerProjected::ZERO)
        }
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let asking = match mode {
            TransportMode::Radiance => f64::from(u8::from(fixed.z > 0.0)),
            TransportMode::Importance => Self::asking(fixed),
        };
        if u1 >= asking {
            return (fixed.z != 0.0).then(|| Self::passed(fixed, mode));
        }
        let u1 = (u1 / asking).min(1.0f64.next_down());
        Self::seen(self.0.sample(fixed, mode, u1, u2)?, fixed, mode)
    }

    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        let passes = match mode {
            TransportMode::Radiance => fixed.z < 0.0,
            TransportMode::Importance => fixed.z > 0.0,
        };
        if passes {
            image(Self::passed(fixed, mode));
        }
        self.0.dirac_images(fixed, mode, &mut |sample| {
            Self::seen(sample, fixed, mode).into_iter().for_each(&mut *image);
        });
    }

    fn is_anisotropic(&self) -> bool {
        self.0.is_anisotropic()
    }
}
