//! Light tracing: a walk from a light, every vertex of which is connected to the lens (t = 1), the
//! reverse of path tracing.
//!
//! ```text
//! T_s f G V We / p_lens         with T = Le / (p_light p⊥) · Π f/p⊥
//! ```
//!
//! The importance We is normalised over the whole film and recorded where the connection meets it
//! (Dutré and Willems 1994; Veach 1997, section 10.3.4). It sees caustics that path tracing cannot,
//! and nothing that a Dirac lobe shows to the camera.

use super::{Alone, Depth, Integrator};
use crate::endpoint::{Camera, Endpoint, Light};
use crate::film::{BatchSample, BatchSink, Contribution, FilmSample, Sink, Technique};
use crate::geometry::SurfacePoint;
use crate::path::{
    Counters, Edge, GrowingPath, RandomWalk, Roulette, Scattered, Scratch, TechniqueSet, Vertex,
    Wavefront, are_joinable, sample_lens,
};
use crate::sampler::{Sampler, Stream};
use crate::scene::{Needs, Scene};

/// Light tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightTracer {
    /// Which path lengths count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
}

impl LightTracer {
    /// Light tracing up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    /// One light walk for each sample that `has_walk`, with its connections: the sample or a part
    /// of it.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn walk<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler, K: BatchSink>(
        &self,
        scene: &'s S,
        camera: &C,
        samples: &mut [BatchSample<P>],
        has_walk: impl Fn(usize) -> bool,
        sink: &mut K,
        counters: &mut Counters,
        wavefront: &mut Wavefront<'s, S>,
    ) {
        let needs = scene.needs();
        if !Integrator::<S>::techniques(self, &needs).lens_sampling {
            return;
        }
        let depth = self.depth.within(&needs);
        let technique = |bounces: u32| Technique { s: bounces as u16 + 1, t: 1 };
        wavefront.paths.clear();
        for (number, sample) in
            samples.iter_mut().enumerate().filter(|(number, _)| has_walk(*number))
        {
            let Some((walk, vertex)) = RandomWalk::from_light(scene, &mut sample.sampler, counters)
            else {
                continue;
            };
            if depth.contains(0)
                && let Some(([lens, start], contribution)) =
                    self.connected(scene, camera, &vertex, technique(0), sample, counters)
            {
                let ends = [wavefront.segments.keep(&lens), wavefront.segments.keep(&start)];
                wavefront.segments.push(number, ends, contribution);
            }
            wavefront.paths.extend(walk.map(|walk| GrowingPath::new(number, walk)));
        }
        wavefront.test(scene, &[], sink);
        // Without a vertex that could be connected the walk would be for nothing.
        let limit = if needs.contains(Needs::FINITE_LOBES) { depth.limit() } else { 0 };
        for bounces in 1..=limit {
            if wavefront.paths.is_empty() {
                return;
            }
            wavefront.arrive(scene, counters, |path, vertex, here, segments, counters| {
                let sample = &mut samples[path.sample];
                if depth.contains(bounces)
                    && vertex.is_connectible()
                    && let Some(([lens, _], contribution)) =
                        self.connected(scene, camera, vertex, technique(bounces), sample, counters)
                {
                    let lens = segments.keep(&lens);
                    segments.push(path.sample, [lens, here], contribution);
                }
                true
            });
            wavefront.test(scene, &[], sink);
            wavefront.scatter(|path, vertex| {
                let sampler = &mut samples[path.sample].sampler;
                matches!(
                    path.walk.scatter(vertex, &self.roulette, sampler, counters),
                    Scattered::On { .. }
                )
            });
        }
        for path in &wavefront.paths {
            path.walk.truncate(counters);
        }
    }

    /// The connection of a vertex of the walk to the lens, with what it contributes if they see
    /// each other.
    fn connected<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler>(
        &self,
        scene: &'s S,
        camera: &C,
        vertex: &Vertex<S::Bsdf<'s>>,
        technique: Technique,
        BatchSample { film, sampler }: &mut BatchSample<P>,
        counters: &mut Counters,
    ) -> Option<([SurfacePoint; 2], Contribution)> {
        sampler.stream(Stream::LensSampling(u32::from(technique.s) - 1));
        let lens = sample_lens(camera, &vertex.point, sampler)?;
        let edge = Edge::between(&lens.point, &vertex.point)?;
        let raster = camera.raster(&lens.point, edge.direction)? - film.offset;
        camera.film().pixel_index(raster)?;
        counters.connections += 1;
        let mut end = vertex.point;
        let light_or_f = match &vertex.bsdf {
            Some(bsdf) => bsdf.eval(vertex.to_previous, -edge.direction),
            None => {
                let light = scene.light(vertex.light?);
                if !are_joinable(lens.point.place, end.place, light.can_be_hit()) {
                    return None;
                }
                end = light.facing(&end, &lens.point);
                light.emit(&end, -edge.direction)
            }
        };
        if light_or_f.is_black() {
            return None;
        }
        let importance = camera.emit(&lens.point, edge.direction);
        let value =
            (vertex.throughput * light_or_f) * (edge.geometry * (importance * lens.throughput()));
        if value.is_black() {
            return None;
        }
        let value = value / self.roulette.test_shadow(value, || 1.0, || sampler.next_1d())?;
        counters.shadow_rays += 1;
        Some(([lens.point, end], Contribution { raster, value, weight: 1.0, technique }))
    }
}

impl<S: Scene + ?Sized> Integrator<S> for LightTracer {
    fn name(&self) -> &'static str {
        "light-tracing"
    }

    fn techniques(&self, needs: &Needs) -> TechniqueSet {
        TechniqueSet { lens_sampling: true, ..TechniqueSet::NONE }.pruned(needs)
    }

    fn sample<'s, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        self.sample_batch(
            scene,
            camera,
            &mut [BatchSample { film, sampler }],
            &mut Alone(sink),
            scratch,
        );
    }

    fn sample_batch<'s, C: Camera + ?Sized, P: Sampler, K: BatchSink>(
        &self,
        scene: &'s S,
        camera: &C,
        samples: &mut [BatchSample<P>],
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        let Scratch { counters, wavefront, .. } = scratch;
        counters.samples += samples.len() as u64;
        self.walk(scene, camera, samples, |_| true, sink, counters, wavefront);
    }
}
