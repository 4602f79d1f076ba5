//! Light tracing: a walk from a light, every vertex of which is connected to the lens (t = 1), the reverse of path tracing.
//!
//! ```text
//! T_s f G V We / p_lens         with T = Le / (p_light p⊥) · Π f/p⊥
//! ```
//!
//! The importance We is normalised over the whole film and recorded where the connection meets it (Dutré and Willems 1994; Veach 1997,
//! section 10.3.4). It sees caustics that path tracing cannot, and nothing that a Dirac lobe shows to the camera.

use super::{Depth, Integrator};
use crate::endpoint::{Camera, Endpoint, Light};
use crate::film::{Contribution, FilmSample, Sink, Technique};
use crate::path::{Edge, RandomWalk, Roulette, Scattered, Scratch, TechniqueSet, Vertex, are_joinable, sample_lens};
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

    /// One light walk with its connections, which is a sample or a part of one.
    pub(super) fn walk<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        let needs = scene.needs();
        if !Integrator::<S>::techniques(self, &needs).lens_sampling {
            return;
        }
        let depth = self.depth.within(&needs);
        let Some((walk, mut vertex)) = RandomWalk::from_light(scene, sampler, &mut scratch.counters) else { return };
        let mut connect = |bounces: u32, vertex: &Vertex<S::Bsdf<'s>>, sampler: &mut P, scratch: &mut Scratch<'s, S>| {
            sampler.stream(Stream::LensSampling(bounces));
            let contribution = self.connected(scene, camera, film, vertex, sampler, scratch);
            if let Some(contribution) = contribution {
                sink.add(&Contribution { technique: Technique { s: bounces as u16 + 1, t: 1 }, ..contribution });
            }
        };
        if depth.contains(0) {
            connect(0, &vertex, sampler, scratch);
        }
        let Some(mut walk) = walk else { return };
        // Without a vertex that could be connected the walk would be for nothing.
        let limit = if needs.contains(Needs::FINITE_LOBES) { depth.limit() } else { 0 };
        for bounces in 1.. {
            if bounces > limit {
                walk.truncate(&mut scratch.counters);
                break;
            }
            let Some(next) = walk.arrive(&mut scratch.counters) else { break };
            vertex = next;
            if depth.contains(bounces) && vertex.is_connectible() {
                connect(bounces, &vertex, sampler, scratch);
            }
            if let Scattered::Ended { .. } = walk.scatter(&mut vertex, &self.roulette, sampler, &mut scratch.counters) {
                break;
            }
        }
    }

    /// Connects a vertex of the walk to the lens.
    fn connected<'s, S: Scene + ?Sized, C: Camera + ?Sized, P: Sampler>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        vertex: &Vertex<S::Bsdf<'s>>,
        sampler: &mut P,
        scratch: &mut Scratch<'s, S>,
    ) -> Option<Contribution> {
        let lens = sample_lens(camera, &vertex.point, sampler)?;
        let edge = Edge::between(&lens.point, &vertex.point)?;
        let raster = camera.raster(&lens.point, edge.direction)? - film.offset;
        camera.film().pixel_index(raster)?;
        scratch.counters.connections += 1;
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
        let value = (vertex.throughput * light_or_f) * (edge.geometry * (importance * lens.throughput()));
        if value.is_black() {
            return None;
        }
        let value = value / self.roulette.test_shadow(value, || 1.0, || sampler.next_1d())?;
        scratch.counters.shadow_rays += 1;
        scene.visible(&lens.point, &end).then_some(Contribution { raster, value, weight: 1.0, technique: Technique { s: 0, t: 1 } })
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
        scratch.counters.samples += 1;
        self.walk(scene, camera, film, sampler, sink, scratch);
    }
}
