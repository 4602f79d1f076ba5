//! Points sampled on an endpoint for the sake of a given vertex: next event estimation and light tracing.

use super::{StartDensity, Vertex};
use crate::endpoint::{Camera, Endpoint, Light, PointSample};
use crate::geometry::{Place, SurfacePoint};
use crate::math::Rgb;
use crate::sampler::Sampler;
use crate::scene::Scene;
use glam::DVec2;

/// Samples a point on a light to connect `receiver` to; the vertex's throughput is the inverse of its density.
///
/// `None` if there is no light, or if the one chosen has nothing to offer to the receiver.
#[inline]
pub fn sample_emitter<'s, S: Scene + ?Sized, P: Sampler>(
    scene: &'s S,
    receiver: &SurfacePoint,
    sampler: &mut P,
) -> Option<Vertex<S::Bsdf<'s>>> {
    // All numbers are drawn first, so that later dimensions do not depend on the outcome.
    let (u0, u1, u2) = (sampler.next_1d(), sampler.next_1d(), sampler.next_2d());
    let (id, pmf) = scene.pick_light(u0)?;
    let light = scene.light(id);
    if !light.can_be_connected() {
        return None;
    }
    let PointSample { point, pdf } = light.sample_from(receiver, u1, u2)?;
    let start = StartDensity { walk: light.point_pdf(&point) * pmf, connection: pdf * pmf };
    (start.connection.value() > 0.0)
        .then(|| Vertex { throughput: Rgb::splat(1.0 / start.connection.value()), ..Vertex::endpoint(point, Some(id), start) })
}

/// The numbers that a point on the lens is sampled with; a lens that is a point needs none.
#[inline]
pub(super) fn lens_numbers<C: Camera + ?Sized, P: Sampler>(camera: &C, sampler: &mut P) -> (f64, DVec2) {
    if camera.place() == Place::Dirac {
        sampler.skip_1d();
        sampler.skip_2d();
        return (0.0, DVec2::ZERO);
    }
    (sampler.next_1d(), sampler.next_2d())
}

/// Samples a point on the lens to connect `receiver` to; the vertex's throughput is the inverse of its density.
#[inline]
pub fn sample_lens<B: crate::bsdf::Bsdf, C: Camera + ?Sized, P: Sampler>(
    camera: &C,
    receiver: &SurfacePoint,
    sampler: &mut P,
) -> Option<Vertex<B>> {
    let (u1, u2) = lens_numbers(camera, sampler);
    let PointSample { point, pdf } = Endpoint::sample_from(camera, receiver, u1, u2)?;
    let start = StartDensity { walk: camera.point_pdf(&point), connection: pdf };
    (pdf.value() > 0.0).then(|| Vertex { throughput: Rgb::splat(1.0 / pdf.value()), ..Vertex::endpoint(point, None, start) })
}
