//! Path tracing: a walk from the camera that collects light where it hits an emitter (s = 0) and where it connects to a point sampled
//! on one (s = 1).
//!
//! ```text
//! s = 0:  T_k Le                                    w = 1 / (1 + (p_connect / (p⊥ G))^β)
//! s = 1:  T_{k-1} f G V Le / p_connect              w = 1 / (1 + (p⊥ G / p_connect)^β)
//! ```
//!
//! with the walk's throughput T = Π f/p⊥ (Kajiya 1986; Veach 1997, section 10.2 for the weights).

use super::{Depth, Integrator};
use crate::bsdf::Walk;
use crate::endpoint::{Camera, Endpoint, Light};
use crate::film::{Contribution, FilmSample, Sink, Technique};
use crate::geometry::SurfacePoint;
use crate::math::{PerProjected, Rgb};
use crate::path::{Counters, Edge, Heuristic, RandomWalk, Roulette, Scattered, Scratch, TechniqueSet, Vertex, sample_emitter};
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

/// What the weight of a light that was hit has to know of the vertex before.
struct Previous<'a> {
    point: &'a SurfacePoint,
    pdf_next: PerProjected,
    /// Whether emitter sampling could have drawn the path from there.
    competes: bool,
}

impl PathTracer {
    /// Path tracing with both techniques up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    /// The contribution of a vertex that is on a light.
    fn emitted<'s, S: Scene + ?Sized>(&self, scene: &'s S, previous: &Previous<'_>, vertex: &Vertex<S::Bsdf<'s>>) -> Option<(Rgb, f64)> {
        let id = vertex.light?;
        let light = scene.light(id);
        let radiance = light.emit(&vertex.point, vertex.to_previous);
        if radiance.is_black() {
            return None;
        }
        let weight = if previous.competes && light.can_be_connected() {
            let connection = light.pdf_from(previous.point, &vertex.point).value() * scene.pick_pmf(id);
            self.heuristic.weight([connection / (previous.pdf_next.value() * vertex.geometry)])
        } else {
            1.0
        };
        Some((vertex.throughput * radiance, weight))
    }

    /// The contribution of a connection from a vertex to a point sampled on a light.
    fn connected<'s, S: Scene + ?Sized, P: Sampler>(
        &self,
        scene: &'s S,
        set: &TechniqueSet,
        vertex: &Vertex<S::Bsdf<'s>>,
        sampler: &mut P,
        counters: &mut Counters,
    ) -> Option<(Rgb, f64)> {
        let emitter = sample_emitter(scene, &vertex.point, sampler)?;
        let light = scene.light(emitter.light?);
        let bsdf = vertex.bsdf.as_ref()?;
        let edge = Edge::between(&vertex.point, &emitter.point)?;
        counters.connections += 1;
        let incoming = edge.geometry * (light.emit(&emitter.point, -edge.direction) * emitter.throughput());
        if incoming.is_black() {
            return None;
        }
        let value = vertex.throughput * bsdf.eval(edge.direction, vertex.to_previous) * incoming;
        if value.is_black() {
            return None;
        }
        let weight = || {
            if set.emitter_hits && light.can_be_hit() {
                let hit = bsdf.pdf(vertex.to_previous, edge.direction, Walk::Camera).value() * edge.geometry;
                self.heuristic.weight([hit / emitter.start.connection.value()])
            } else {
                1.0
            }
        };
        let probability = self.roulette.test_shadow(value, weight, || sampler.next_1d())?;
        counters.shadow_rays += 1;
        scene.visible(&vertex.point, &emitter.point).then(|| (value / probability, weight()))
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
        let counters = &mut scratch.counters;
        counters.samples += 1;
        let needs = scene.needs();
        let (set, depth) = (Integrator::<S>::techniques(self, &needs), self.depth.within(&needs));
        let mut add = |s: u16, bounces: u32, value: Rgb, weight: f64| {
            let technique = Technique { s, t: bounces as u16 + 2 - s };
            sink.add(&Contribution { raster: film.raster, value, weight, technique });
        };
        let u = camera.film().to_window(film.raster + film.offset);
        let Some((mut walk, _)) = RandomWalk::from_camera(scene, camera, u, sampler) else { return };
        let (mut competes, mut pdf_next) = (false, PerProjected::ZERO);
        // `bounces` is the number of scattering events of a path that ends on a light at the vertex just reached.
        for bounces in 0.. {
            let Some(mut vertex) = walk.arrive(counters) else { break };
            if set.emitter_hits
                && depth.contains(bounces)
                && let Some((value, weight)) = self.emitted(scene, &Previous { point: walk.from(), pdf_next, competes }, &vertex)
            {
                add(0, bounces, value, weight);
            }
            if vertex.bsdf.is_none() {
                break;
            }
            if bounces >= depth.limit() {
                walk.truncate(counters);
                break;
            }
            if set.emitter_sampling && depth.contains(bounces + 1) && vertex.is_connectible() {
                sampler.stream(Stream::EmitterSampling(bounces + 1));
                if let Some((value, weight)) = self.connected(scene, &set, &vertex, sampler, counters) {
                    add(1, bounces + 1, value, weight);
                }
            }
            if !set.emitter_hits && bounces + 1 >= depth.limit() {
                // The next vertex could only count by being hit.
                walk.truncate(counters);
                break;
            }
            match walk.scatter(&mut vertex, &self.roulette, sampler, counters) {
                Scattered::On { constant } => {
                    if !constant.is_black() {
                        add(0, bounces + 1, constant, 1.0);
                    }
                }
                Scattered::Ended { constant } => {
                    if !constant.is_black() {
                        add(0, bounces + 1, constant, 1.0);
                    }
                    break;
                }
            }
            (competes, pdf_next) = (set.emitter_sampling && !vertex.dirac, vertex.pdf_next);
        }
    }
}
