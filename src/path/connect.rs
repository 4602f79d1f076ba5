//! Points sampled on an endpoint for the sake of a given vertex: next event estimation and light
//! tracing.

use super::{StartDensity, Vertex};
use crate::endpoint::{Camera, Endpoint, Light, LightId, PointSample};
use crate::geometry::{Place, SurfacePoint};
use crate::math::{PerArea, Rgb};
use crate::sampler::Sampler;
use crate::scene::Scene;
use glam::DVec2;

/// A point sampled on a light or on the lens to connect a vertex to.
#[derive(Clone, Copy, Debug)]
pub struct SampledEndpoint {
    /// Where it is.
    pub point: SurfacePoint,
    /// Whose it is; `None` on the lens.
    pub light: Option<LightId>,
    /// The density with which it was chosen, probability of the light included; not 0.
    pub pdf: PerArea,
}

impl SampledEndpoint {
    /// What was sampled on an endpoint that was chosen with probability `pmf`. Borrowed, because
    /// points are large and copied only where they stay.
    #[inline(always)]
    fn new(sample: &Option<PointSample>, light: Option<LightId>, pmf: f64) -> Option<Self> {
        let PointSample { point, pdf } = sample.as_ref()?;
        let pdf = *pdf * pmf;
        if pdf.value() > 0.0 { Some(Self { point: *point, light, pdf }) } else { None }
    }

    /// The inverse of the density with which it was chosen.
    #[inline]
    #[must_use]
    pub fn throughput(&self) -> f64 {
        1.0 / self.pdf.value()
    }

    /// As a vertex of a path.
    #[inline]
    #[must_use]
    pub fn vertex<'s, S: Scene + ?Sized, C: Camera + ?Sized>(
        &self,
        scene: &'s S,
        camera: &C,
    ) -> Vertex<S::Bsdf<'s>> {
        let walk = match self.light {
            Some(id) => scene.light(id).point_pdf(&self.point) * scene.pick_pmf(id),
            None => camera.point_pdf(&self.point),
        };
        let start = StartDensity { walk, connection: self.pdf };
        Vertex {
            throughput: Rgb::splat(self.throughput()),
            ..Vertex::endpoint(self.point, self.light, start)
        }
    }
}

/// Samples a point on a light to connect `receiver` to.
///
/// `None` if there is no light, or if the one chosen has nothing to offer to the receiver.
#[inline(always)]
pub fn sample_emitter<S: Scene + ?Sized, P: Sampler>(
    scene: &S,
    receiver: &SurfacePoint,
    sampler: &mut P,
) -> Option<SampledEndpoint> {
    // All numbers are drawn first, so that later dimensions do not depend on the outcome.
    let (u0, u1, u2) = (sampler.next_1d(), sampler.next_1d(), sampler.next_2d());
    let (id, pmf) = scene.pick_light(u0)?;
    let light = scene.light(id);
    if !light.can_be_connected() {
        return None;
    }
    let sample = light.sample_from(receiver, u1, u2);
    SampledEndpoint::new(&sample, Some(id), pmf)
}

/// The numbers that a point on the lens is sampled with; a lens that is a point needs none.
#[inline]
pub(super) fn lens_numbers<C: Camera + ?Sized, P: Sampler>(
    camera: &C,
    sampler: &mut P,
) -> (f64, DVec2) {
    if camera.place() == Place::Dirac {
        sampler.skip_1d();
        sampler.skip_2d();
        return (0.0, DVec2::ZERO);
    }
    (sampler.next_1d(), sampler.next_2d())
}

/// Samples a point on the lens to connect `receiver` to.
#[inline(always)]
pub fn sample_lens<C: Camera + ?Sized, P: Sampler>(
    camera: &C,
    receiver: &SurfacePoint,
    sampler: &mut P,
) -> Option<SampledEndpoint> {
    let (u1, u2) = lens_numbers(camera, sampler);
    let sample = Endpoint::sample_from(camera, receiver, u1, u2);
    SampledEndpoint::new(&sample, None, 1.0)
}
