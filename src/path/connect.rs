//! Points sampled on an endpoint for the sake of a given vertex: next event estimation and light
//! tracing.

use super::{Counters, Edge, End, Out, Plan, Stage, StartDensity, Vertex};
use crate::endpoint::{Camera, Endpoint, Light, LightId, PointSample};
use crate::film::{Contribution, FilmSample, Sample, Technique};
use crate::geometry::{Place, SurfacePoint};
use crate::math::{PerArea, Rgb};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use glam::DVec2;

/// A point sampled on a light or on the lens to connect a vertex to.
#[derive(Clone, Copy, Debug)]
pub struct SampledEndpoint {
    /// The point.
    pub point: SurfacePoint,
    /// The light that it belongs to; `None` on the lens.
    pub light: Option<LightId>,
    /// The density with which it was chosen, probability of the light included; not 0.
    pub pdf: PerArea,
    /// The radiance that it emits to the vertex, if the light has told it with the point.
    pub radiance: Option<Rgb>,
}

impl SampledEndpoint {
    /// A point sampled on an endpoint that was chosen with probability `pmf`. Borrowed, because
    /// points are large and copied only where they stay.
    #[inline(always)]
    fn new(
        PointSample { point, pdf }: &PointSample,
        radiance: Option<Rgb>,
        light: Option<LightId>,
        pmf: f64,
    ) -> Option<Self> {
        let pdf = *pdf * pmf;
        if pdf.value() > 0.0 { Some(Self { point: *point, light, pdf, radiance }) } else { None }
    }

    /// The inverse of the density with which it was chosen.
    #[inline]
    #[must_use]
    pub fn throughput(&self) -> f64 {
        1.0 / self.pdf.value()
    }

    /// The point as a vertex of a path.
    #[inline(always)]
    #[must_use]
    pub fn vertex<'s, S: Scene + ?Sized>(&self, stage: &Stage<'s, S>) -> Vertex<S::Bsdf<'s>> {
        let walk = match self.light {
            Some(id) => stage.scene.light(id).point_pdf(&self.point) * stage.pick_pmf(id),
            None => stage.camera.point_pdf(&self.point),
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
    stage: &Stage<'_, S>,
    receiver: &SurfacePoint,
    sampler: &mut P,
) -> Option<SampledEndpoint> {
    // All numbers are drawn first, so that later dimensions do not depend on the outcome.
    let (u0, (u1, u2)) = (sampler.next_1d(), sampler.next_1d_2d());
    let chosen = stage.pick_light_for(receiver, u0)?;
    emitter_at(stage, receiver, chosen, u1, u2)
}

/// The point on a light that was chosen with some probability for a receiver.
#[inline(always)]
pub(super) fn emitter_at<S: Scene + ?Sized>(
    stage: &Stage<'_, S>,
    receiver: &SurfacePoint,
    (id, pmf): (LightId, f64),
    u1: f64,
    u2: DVec2,
) -> Option<SampledEndpoint> {
    let light = stage.scene.light(id);
    if !light.can_be_connected() {
        return None;
    }
    let (sample, radiance) = light.sample_emission(receiver, u1, u2)?;
    SampledEndpoint::new(&sample, radiance, Some(id), pmf)
}

/// The numbers that a point on the lens is sampled with; a lens that is a point needs none.
#[inline]
pub(super) fn lens_numbers<P: Sampler>(camera: &dyn Camera, sampler: &mut P) -> (f64, DVec2) {
    if camera.place() == Place::Dirac {
        sampler.skip_1d();
        sampler.skip_2d();
        return (0.0, DVec2::ZERO);
    }
    (sampler.next_1d(), sampler.next_2d())
}

/// Samples a point on the lens to connect `receiver` to.
#[inline(always)]
pub fn sample_lens<P: Sampler>(
    camera: &dyn Camera,
    receiver: &SurfacePoint,
    sampler: &mut P,
) -> Option<SampledEndpoint> {
    let (u1, u2) = lens_numbers(camera, sampler);
    let sample = Endpoint::sample_from(camera, receiver, u1, u2)?;
    SampledEndpoint::new(&sample, None, None, 1.0)
}

/// A point on a light that a vertex of a camera subpath connects to: next event estimation.
#[derive(Clone, Copy, Debug)]
pub struct NextEvent {
    /// The point, as an end of shadow rays.
    pub end: End,
    /// The density with which it was chosen, probability of the light included.
    pub pdf: PerArea,
    /// The light.
    pub light: LightId,
    /// The edge from the vertex to the point.
    pub edge: Edge,
    /// Unweighted estimate `T f G Le / p` if the two see each other; not black.
    pub value: Rgb,
    /// The density with which the walk would hit the point instead; 0 if hits are not in the set of
    /// techniques, or if no ray can meet the light.
    pub pdf_of_hit: PerArea,
}

/// Evaluates everything but visibility between a vertex and a point that was sampled for it on a
/// light. `None` if nothing comes of it.
#[inline(always)]
pub(super) fn next_event_at<S: Scene + ?Sized>(
    Plan { stage, techniques, .. }: &Plan<'_, S>,
    vertex: &Vertex<S::Bsdf<'_>>,
    emitter: &SampledEndpoint,
    out: &mut Out<'_>,
    counters: &mut Counters,
) -> Option<NextEvent> {
    let (id, bsdf) = (emitter.light?, vertex.bsdf.as_ref()?);
    let edge = Edge::between(&vertex.point, &emitter.point)?;
    counters.connections += 1;
    let light = stage.scene.light(id);
    let radiance = emitter.radiance.unwrap_or_else(|| light.emit(&emitter.point, -edge.direction));
    // ANCHOR: next-event
    let incoming = edge.geometry * (radiance * emitter.throughput());
    if incoming.is_black() {
        return None;
    }
    let (f, pdf) = bsdf.eval_and_pdf(edge.direction, vertex.to_previous);
    let passing = stage.scene.transmittance(&vertex.point, &emitter.point);
    let value = vertex.throughput * f * incoming * passing;
    // ANCHOR_END: next-event
    if value.is_black() {
        return None;
    }
    let mut pdf_of_hit = PerArea::ZERO;
    if techniques.bsdf_sampling && light.can_be_hit() {
        pdf_of_hit = PerArea(pdf.value() * edge.geometry);
    }
    let end = out.keep(&emitter.point);
    Some(NextEvent { end, pdf: emitter.pdf, light: id, edge, value, pdf_of_hit })
}

/// The connection of a vertex of a light subpath to a point on the lens: light tracing.
#[derive(Clone, Copy, Debug)]
pub struct LensConnection {
    /// The ends of the shadow ray, the lens first.
    pub ends: [End; 2],
    /// The splat if the two see each other, unweighted: `T f G We / p`, not black. At the start of
    /// a walk Le takes the place of f.
    pub contribution: Contribution,
}

/// Samples a point on the lens for a vertex of a light subpath after so many scattering events, its
/// own included; 0 at the start. Evaluates everything but visibility. `None` if nothing comes of
/// it, or only outside the film's window. `end` is the vertex as an end of shadow rays; the start
/// of a walk has none, because its place can depend on the lens.
#[inline(always)]
pub fn sample_lens_connection<S: Scene + ?Sized, P: Sampler>(
    stage: &Stage<'_, S>,
    (vertex, end): (&Vertex<S::Bsdf<'_>>, Option<End>),
    bounces: u32,
    Sample { film, sampler }: &mut Sample<P>,
    out: &mut Out<'_>,
    counters: &mut Counters,
) -> Option<LensConnection> {
    sampler.stream(Stream::LensSampling(bounces));
    let lens = sample_lens(stage.camera, &vertex.point, sampler)?;
    lens_connection_at(stage, (vertex, end), bounces, film, &lens, out, counters)
}

/// [`sample_lens_connection`] with a point on the lens that was sampled.
#[inline(always)]
pub(super) fn lens_connection_at<S: Scene + ?Sized>(
    &Stage { scene, camera, .. }: &Stage<'_, S>,
    (vertex, end): (&Vertex<S::Bsdf<'_>>, Option<End>),
    bounces: u32,
    film: &FilmSample,
    lens: &SampledEndpoint,
    out: &mut Out<'_>,
    counters: &mut Counters,
) -> Option<LensConnection> {
    let edge = Edge::between(&lens.point, &vertex.point)?;
    let raster = camera.raster(&lens.point, edge.direction)? - film.offset;
    camera.film().pixel_index(raster)?;
    counters.connections += 1;
    let light_or_f = match &vertex.bsdf {
        Some(bsdf) => bsdf.eval(vertex.to_previous, -edge.direction),
        None => {
            let light = scene.light(vertex.light?);
            if !are_joinable(lens.point.place, vertex.point.place, light.can_be_hit()) {
                return None;
            }
            light.emit(&vertex.point, -edge.direction)
        }
    };
    if light_or_f.is_black() {
        return None;
    }
    // ANCHOR: lens
    let importance = camera.emit(&lens.point, edge.direction) * lens.throughput();
    let passing = scene.transmittance(&lens.point, &vertex.point);
    let value = (vertex.throughput * light_or_f) * (edge.geometry * importance) * passing;
    // ANCHOR_END: lens
    if value.is_black() {
        return None;
    }
    counters.shadow_rays += 1;
    let end = match (end, vertex.light) {
        (None, Some(id)) => out.keep(&scene.light(id).facing(&vertex.point, &lens.point)),
        (None, None) => out.keep(&vertex.point),
        (Some(end), _) => end,
    };
    let technique = Technique::new(bounces as u16 + 1, 1);
    let contribution = Contribution { raster, value, weight: 1.0, technique };
    Some(LensConnection { ends: [out.keep(&lens.point), end], contribution })
}

/// True if lens and light can be connected to each other: a Dirac lens would see a Dirac light as a
/// Dirac distribution on the film, and two points at infinity have no line between them.
pub(super) fn are_joinable(lens: Place, light: Place, hittable: bool) -> bool {
    (lens == Place::Area || hittable) && !(lens == Place::Infinite && light == Place::Infinite)
}
