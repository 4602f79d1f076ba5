//! A view of a scene in which camera walks are guided.

use super::{Field, Quadtree};
use crate::bsdf::{Bsdf, BsdfSample, DiracValue, LaneForm, Lobes, TransportMode, shading};
use crate::geometry::{Frame, NormalOrigin, SurfacePoint};
use crate::math::{PerProjected, Rgb};
use crate::scene::{Needs, Scene, answers_of_scene};
use glam::{DVec2, DVec3};
use std::fmt;

/// A scene whose camera walks are guided by a field. It answers as the scene does, but for its
/// BSDFs.
pub struct Guided<'a, S: ?Sized> {
    scene: &'a S,
    field: &'a Field,
    alpha: f64,
}

impl<'a, S: ?Sized> Guided<'a, S> {
    /// A scene with a field; `alpha` is the probability with which a direction is drawn from the
    /// BSDF, `None` unless in (0, 1].
    #[must_use]
    pub fn new(scene: &'a S, field: &'a Field, alpha: f64) -> Option<Self> {
        (alpha > 0.0 && alpha <= 1.0).then_some(Self { scene, field, alpha })
    }
}

impl<S: ?Sized> fmt::Debug for Guided<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Guided").field("alpha", &self.alpha).finish_non_exhaustive()
    }
}

/// The BSDF of a point whose camera walks are guided.
///
/// Not guided are points with Dirac lobes alone, those where the field knows nothing, and those
/// whose shading normal a map has made, around which a camera may see the surface turned.
#[derive(Clone, Copy, Debug)]
pub struct GuidedBsdf<'a, B> {
    bsdf: B,
    guide: Option<Guide<'a>>,
}

#[derive(Clone, Copy, Debug)]
struct Guide<'a> {
    tree: &'a Quadtree,
    /// That of the model.
    frame: Frame,
    alpha: f64,
}

impl<'a, B: Bsdf> GuidedBsdf<'a, B> {
    /// A BSDF at a point, guided by a field; `alpha` as for [`Guided::new`].
    #[inline]
    #[must_use]
    pub fn new(bsdf: B, point: &SurfacePoint, field: &'a Field, alpha: f64) -> Self {
        let is_mapped = point.normal_origin == NormalOrigin::Map && !point.is_flat();
        let is_guided = bsdf.lobes().intersects(Lobes::FINITE) && !is_mapped && alpha < 1.0;
        let tree = if is_guided { field.at(point.position) } else { None };
        let guide = tree.map(|tree| Guide { tree, frame: shading::frame(&bsdf, point), alpha });
        Self { bsdf, guide }
    }

    /// The BSDF that is not guided.
    #[must_use]
    pub fn inner(&self) -> &B {
        &self.bsdf
    }

    /// The probability of drawing from the BSDF: 1 where walks are not guided.
    #[inline]
    #[must_use]
    pub fn alpha(&self) -> f64 {
        self.guide.map_or(1.0, |guide| guide.alpha)
    }

    /// A Dirac lobe's sample.
    fn of_dirac(&self, mut sample: BsdfSample, mode: TransportMode) -> BsdfSample {
        let alpha = self.alpha();
        match mode {
            TransportMode::Radiance => {
                (sample.weight, sample.pdf) = (sample.weight / alpha, sample.pdf * alpha);
            }
            TransportMode::Importance => sample.pdf_reverse = sample.pdf_reverse * alpha,
        }
        sample
    }
}

impl Guide<'_> {
    // ANCHOR: mixture
    /// The density of a direction with a density of the BSDF's.
    #[inline]
    fn mixed(&self, pdf: PerProjected, next: DVec3) -> PerProjected {
        let guided = self.tree.density(self.frame.to_world(next)).per_projected(next.z);
        PerProjected(self.alpha * pdf.value() + (1.0 - self.alpha) * guided.value())
    }
    // ANCHOR_END: mixture
}

impl<B: Bsdf> Bsdf for GuidedBsdf<'_, B> {
    #[inline]
    fn lobes(&self) -> Lobes {
        self.bsdf.lobes()
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.bsdf.eval(to_light, to_camera)
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        let pdf = self.bsdf.pdf(fixed, next, mode);
        match &self.guide {
            Some(guide) if mode == TransportMode::Radiance => guide.mixed(pdf, next),
            _ => pdf,
        }
    }

    #[inline]
    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let (value, pdf) = self.bsdf.eval_and_pdf(to_light, to_camera);
        (value, self.guide.map_or(pdf, |guide| guide.mixed(pdf, to_light)))
    }

    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        let Some(guide) = &self.guide else { return self.bsdf.sample(fixed, mode, u1, u2) };
        if mode == TransportMode::Importance {
            let sample = self.bsdf.sample(fixed, mode, u1, u2)?;
            if sample.dirac {
                return Some(self.of_dirac(sample, mode));
            }
            let pdf_reverse = self.pdf(sample.next, fixed, mode.reversed());
            return Some(BsdfSample { pdf_reverse, ..sample });
        }
        let mut sample = if u1 < guide.alpha {
            let u1 = (u1 / guide.alpha).min(1.0f64.next_down());
            self.bsdf.sample(fixed, mode, u1, u2)?
        } else {
            let next = guide.frame.to_local(guide.tree.sample(u2));
            BsdfSample {
                next,
                weight: Rgb::BLACK,
                pdf: PerProjected::ZERO,
                pdf_reverse: self.bsdf.pdf(next, fixed, mode.reversed()),
                dirac: false,
                relative_ior: relative_ior(&self.bsdf, fixed, next),
            }
        };
        if sample.dirac {
            return Some(self.of_dirac(sample, mode));
        }
        let (value, pdf) = self.eval_and_pdf(sample.next, fixed);
        // One sample of two densities: both know of each other (Veach 1997, section 9.2.4).
        (sample.weight, sample.pdf) = (value / pdf.value(), pdf);
        (pdf.value() > 0.0 && pdf.value().is_finite()).then_some(sample)
    }

    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        self.bsdf.dirac_images(fixed, mode, &mut |sample| image(self.of_dirac(sample, mode)));
    }

    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        let value = self.bsdf.eval_dirac(to_light, to_camera);
        DiracValue { pdf_to_light: value.pdf_to_light * self.alpha(), ..value }
    }

    #[inline]
    fn is_anisotropic(&self) -> bool {
        self.bsdf.is_anisotropic()
    }

    #[inline]
    fn lane_form(&self, front: bool) -> Option<LaneForm> {
        if self.guide.is_none() { self.bsdf.lane_form(front) } else { None }
    }
}

/// The index of refraction on the side of a direction to the light over that on the side of one to
/// the camera, from what refraction does to f.
fn relative_ior(bsdf: &impl Bsdf, to_camera: DVec3, to_light: DVec3) -> f64 {
    if to_camera.z * to_light.z > 0.0 || !bsdf.lobes().intersects(Lobes::GLOSSY_TRANSMISSION) {
        return 1.0;
    }
    let there = bsdf.eval(to_light, to_camera).max_component();
    let ratio = bsdf.eval(to_camera, to_light).max_component() / there;
    if ratio > 0.0 && ratio.is_finite() { ratio.sqrt() } else { 1.0 }
}

impl<S: Scene + ?Sized> Scene for Guided<'_, S> {
    type Bsdf<'b>
        = GuidedBsdf<'b, S::Bsdf<'b>>
    where
        Self: 'b;
    type Light = S::Light;

    fn bsdf(&self, x: &SurfacePoint) -> Self::Bsdf<'_> {
        GuidedBsdf::new(self.scene.bsdf(x), x, self.field, self.alpha)
    }

    answers_of_scene!();

    fn fingerprint(&self) -> Option<u64> {
        self.scene.fingerprint()
    }
    fn needs(&self) -> Needs {
        self.scene.needs()
    }
}
