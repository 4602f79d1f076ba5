//! Materials as integrators meet them: at a point, with textures looked up there and with the side
//! that is seen.

use super::finish::{Finish, Layer, mixed};
use crate::bsdf::{Bsdf, BsdfSample, DiracValue, Lobes, Mixture, Model, TransportMode};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// The BSDF of one point of a [`World`](crate::scene::World). Textures are looked up when it is
/// asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceBsdf<'a> {
    finish: &'a Finish,
    uv: DVec2,
}

impl<'a> SurfaceBsdf<'a> {
    pub(crate) fn new(finish: &'a Finish, uv: DVec2) -> Self {
        Self { finish, uv }
    }

    /// The models at this point, seen from the front or from the back, and how they are mixed (one
    /// alone has the weight 1); `None` for a BSDF of a user's own.
    #[must_use]
    pub fn mixture(&self, front: bool) -> Option<Mixture<Model, 2>> {
        self.finish.mixture(self.uv, front)
    }
}

/// The mixture of the layers on a direction's side.
fn layered(sides: &[[Layer; 2]; 2], direction: DVec3, uv: DVec2) -> Mixture<Model, 2> {
    mixed(&sides[usize::from(direction.z < 0.0)], uv)
}

/// Asks what there is on a direction's side.
macro_rules! ask {
    ($self:ident, $direction:ident, $bsdf:ident => $question:expr) => {
        match $self.finish {
            Finish::Model($bsdf) => $question,
            Finish::Mixture($bsdf) => $question,
            Finish::Layers { sides, .. } => {
                let $bsdf = &layered(sides, $direction, $self.uv);
                $question
            }
            Finish::Custom($bsdf) => $question,
        }
    };
}

impl Bsdf for SurfaceBsdf<'_> {
    #[inline]
    fn lobes(&self) -> Lobes {
        self.finish.lobes()
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        ask!(self, to_camera, bsdf => bsdf.eval(to_light, to_camera))
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        ask!(self, fixed, bsdf => bsdf.pdf(fixed, next, mode))
    }

    #[inline]
    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        ask!(self, fixed, bsdf => bsdf.sample(fixed, mode, u1, u2))
    }

    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        ask!(self, fixed, bsdf => bsdf.dirac_images(fixed, mode, image));
    }

    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        ask!(self, to_camera, bsdf => bsdf.eval_dirac(to_light, to_camera))
    }

    #[inline]
    fn is_anisotropic(&self) -> bool {
        match self.finish {
            Finish::Custom(bsdf) => bsdf.is_anisotropic(),
            _ => self.lobes().intersects(Lobes::GLOSSY),
        }
    }
}
