//! Path tracing: a walk from the camera that collects light where it hits an emitter (s = 0) and
//! where it connects to a point sampled on one (s = 1).
//!
//! ```text
//! s = 0:  T_k Le                                    w = 1 / (1 + (p_connect / (p⊥ G))^β)
//! s = 1:  T_{k-1} f G V Le / p_connect              w = 1 / (1 + (p⊥ G / p_connect)^β)
//! ```
//!
//! with the walk's throughput T = Π f/p⊥ (Kajiya 1986; Veach 1997, section 10.2 for the weights).

use super::{Alone, Depth, Integrator};
use crate::bsdf::Walk;
use crate::endpoint::{Camera, Endpoint, Light};
use crate::film::{BatchSample, BatchSink, Contribution, FilmSample, Sink, Technique};
use crate::geometry::SurfacePoint;
use crate::math::Rgb;
use crate::path::{
    Counters, Edge, GrowingPath, Heuristic, RandomWalk, Roulette, Scattered, Scratch, TechniqueSet,
    Vertex, sample_emitter,
};
use crate::sampler::{Sampler, Stream};
use crate::scene::{Needs, Scene};

/// Which of its two techniques a path tracer runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PathTracing {
    /// Both, with weights: sees everything but Dirac lights through Dirac lobes.
    #[default]
    Both,
    /// s = 0 alone: no light is sampled. Cannot see Dirac lights.
    EmissionOnly,
    /// s = 1 alone. Cannot see lights directly or through Dirac lobes.
    NextEventOnly,
}

/// Path tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathTracer {
    /// Which techniques to run.
    pub mode: PathTracing,
    /// Which path lengths count.
    pub depth: Depth,
    /// Termination.
    pub roulette: Roulette,
    /// How the two techniques are weighted.
    pub heuristic: Heuristic,
}

impl PathTracer {
    /// Path tracing with both techniques up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }
}

/// What does not change in the course of a batch, and the steps of a path. `bounces` is the number
/// of scattering events of a path that ends on a light at the vertex just reached.
struct Kernel<'s, S: ?Sized> {
    scene: &'s S,
    set: TechniqueSet,
    depth: Depth,
    roulette: Roulette,
    heuristic: Heuristic,
}

impl<'s, S: Scene + ?Sized> Kernel<'s, S> {
    fn new(tracer: &PathTracer, scene: &'s S) -> Self {
        let needs = scene.needs();
        let set = Integrator::<S>::techniques(tracer, &needs);
        Self {
            scene,
            set,
            depth: tracer.depth.within(&needs),
            roulette: tracer.roulette,
            heuristic: tracer.heuristic,
        }
    }

    /// The contribution of a vertex that is on a light (s = 0).
    #[inline]
    fn emitted(
        &self,
        path: &GrowingPath<'s, S>,
        vertex: &Vertex<S::Bsdf<'s>>,
        bounces: u32,
    ) -> Option<(Rgb, f64)> {
        if !(self.set.emitter_hits && self.depth.contains(bounces)) {
            return None;
        }
        let id = vertex.light?;
        let light = self.scene.light(id);
        let radiance = light.emit(&vertex.point, vertex.to_previous);
        if radiance.is_black() {
            return None;
        }
        let weight = if path.competes && light.can_be_connected() {
            let connection =
                light.pdf_from(path.walk.from(), &vertex.point).value() * self.scene.pick_pmf(id);
            self.heuristic.weight([connection / (path.pdf_next.value() * vertex.geometry)])
        } else {
            1.0
        };
        Some((vertex.throughput * radiance, weight))
    }

    /// Whether the path goes on from a vertex.
    #[inline]
    fn goes_on(
        &self,
        path: &GrowingPath<'s, S>,
        vertex: &Vertex<S::Bsdf<'s>>,
        bounces: u32,
        counters: &mut Counters,
    ) -> bool {
        let truncated = vertex.bsdf.is_some() && bounces >= self.depth.limit();
        if truncated {
            path.walk.truncate(counters);
        }
        vertex.bsdf.is_some() && !truncated
    }

    /// The connection of a vertex to a point sampled on a light (s = 1), with the contribution and
    /// its weight if they see each other.
    #[inline]
    fn connected<P: Sampler>(
        &self,
        vertex: &Vertex<S::Bsdf<'s>>,
        bounces: u32,
        sampler: &mut P,
        counters: &mut Counters,
    ) -> Option<(SurfacePoint, Rgb, f64)> {
        if !(self.set.emitter_sampling
            && self.depth.contains(bounces + 1)
            && vertex.is_connectible())
        {
            return None;
        }
        sampler.stream(Stream::EmitterSampling(bounces + 1));
        let emitter = sample_emitter(self.scene, &vertex.point, sampler)?;
        let light = self.scene.light(emitter.light?);
        let bsdf = vertex.bsdf.as_ref()?;
        let edge = Edge::between(&vertex.point, &emitter.point)?;
        counters.connections += 1;
        let incoming =
            edge.geometry * (light.emit(&emitter.point, -edge.direction) * emitter.throughput());
        if incoming.is_black() {
            return None;
        }
        let value = vertex.throughput * bsdf.eval(edge.direction, vertex.to_previous) * incoming;
        if value.is_black() {
            return None;
        }
        let weight = if self.set.emitter_hits && light.can_be_hit() {
            let hit =
                bsdf.pdf(vertex.to_previous, edge.direction, Walk::Camera).value() * edge.geometry;
            self.heuristic.weight([hit / emitter.pdf.value()])
        } else {
            1.0
        };
        let probability = self.roulette.test_shadow(value, || weight, || sampler.next_1d())?;
        counters.shadow_rays += 1;
        Some((emitter.point, value / probability, weight))
    }

    /// Samples where the path goes on; returns whether it does, and what roulette's constant
    /// contributes.
    #[inline]
    fn scatter<P: Sampler>(
        &self,
        path: &mut GrowingPath<'s, S>,
        vertex: &mut Vertex<S::Bsdf<'s>>,
        bounces: u32,
        sampler: &mut P,
        counters: &mut Counters,
    ) -> (bool, Rgb) {
        if !self.set.emitter_hits && bounces + 1 >= self.depth.limit() {
            // The next vertex could only count by being hit.
            path.walk.truncate(counters);
            return (false, Rgb::BLACK);
        }
        let scattered = path.walk.scatter(vertex, &self.roulette, sampler, counters);
        (path.competes, path.pdf_next) =
            (self.set.emitter_sampling && !vertex.dirac, vertex.pdf_next);
        match scattered {
            Scattered::On { constant } => (true, constant),
            Scattered::Ended { constant } => (false, constant),
        }
    }
}

/// A contribution by the technique with `s` vertices from the light.
fn contribution(film: &FilmSample, s: u16, bounces: u32, value: Rgb, weight: f64) -> Contribution {
    Contribution {
        raster: film.raster,
        value,
        weight,
        technique: Technique { s, t: bounces as u16 + 2 - s },
    }
}

impl<S: Scene + ?Sized> Integrator<S> for PathTracer {
    fn name(&self) -> &'static str {
        "path-tracing"
    }

    fn techniques(&self, needs: &Needs) -> TechniqueSet {
        TechniqueSet {
            emitter_hits: self.mode != PathTracing::NextEventOnly,
            emitter_sampling: self.mode != PathTracing::EmissionOnly,
            ..TechniqueSet::NONE
        }
        .pruned(needs)
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
        let kernel = Kernel::new(self, scene);
        wavefront.paths.clear();
        wavefront.paths.extend(samples.iter_mut().enumerate().filter_map(
            |(number, BatchSample { film, sampler })| {
                let u = camera.film().to_window(film.raster + film.offset);
                RandomWalk::from_camera(scene, camera, u, sampler)
                    .map(|(walk, _)| GrowingPath::new(number, walk))
            },
        ));
        for bounces in 0.. {
            if wavefront.paths.is_empty() {
                break;
            }
            wavefront.arrive(scene, counters, |path, vertex, here, segments, counters| {
                let BatchSample { film, sampler } = &mut samples[path.sample];
                if let Some((value, weight)) = kernel.emitted(path, vertex, bounces) {
                    sink.add(path.sample, &contribution(film, 0, bounces, value, weight));
                }
                let goes_on = kernel.goes_on(path, vertex, bounces, counters);
                if goes_on
                    && let Some((end, value, weight)) =
                        kernel.connected(vertex, bounces, sampler, counters)
                {
                    let contribution = contribution(film, 1, bounces + 1, value, weight);
                    let end = segments.keep(&end);
                    segments.push(path.sample, [here, end], contribution);
                }
                goes_on
            });
            wavefront.test(scene, &[], sink);
            wavefront.scatter(|path, vertex| {
                let BatchSample { film, sampler } = &mut samples[path.sample];
                let (goes_on, constant) = kernel.scatter(path, vertex, bounces, sampler, counters);
                if !constant.is_black() {
                    sink.add(path.sample, &contribution(film, 0, bounces + 1, constant, 1.0));
                }
                goes_on
            });
        }
    }
}
