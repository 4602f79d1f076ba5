//! The one random walk of the crate: traces a ray, reports the vertex, samples the next direction.
//!
//! Every integrator that builds paths incrementally uses it, from the camera or from a light. The
//! estimate that a walk carries (its throughput) is the product of `f/p⊥` over its vertices:
//! geometry terms cancel against `p_area = p⊥ G`.

use super::connect::lens_numbers;
use super::{Counters, Edge, Roulette, StartDensity, Termination, Vertex};
use crate::bsdf::Walk;
use crate::bsdf::shading::ShadedBsdf;
use crate::endpoint::{Camera, Endpoint, LightId};
use crate::geometry::SurfacePoint;
use crate::math::{PerProjected, Rgb};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use glam::{DVec2, DVec3};

/// The largest number of scattering events of one walk, also where the depth is unbounded: a closed
/// scene without absorption would hold a walk for ever. What is cut off is reported in
/// [`Counters`].
pub const MAX_BOUNCES: u32 = 32_000;

/// A walk through the scene.
#[derive(Debug)]
pub struct RandomWalk<'s, S: Scene + ?Sized + 's> {
    scene: &'s S,
    walk: Walk,
    from: SurfacePoint,
    direction: DVec3,
    /// Throughput at the vertex that comes next.
    throughput: Rgb,
    /// What Russian roulette compares the throughput with: its largest component at the start,
    /// times refraction's n² on the way.
    reference: f64,
    /// Product of the probabilities 1 - q of surviving roulette so far.
    survival: f64,
    /// Number of surface vertices met so far.
    vertices: u32,
}

/// What [`RandomWalk::scatter`] decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scattered {
    /// The walk goes on. With a roulette constant c ≠ 0 survivors add `constant` to the estimate.
    On {
        /// `-q c / (1 - q)` times the throughput before roulette.
        constant: Rgb,
    },
    /// The walk ends. With a roulette constant c ≠ 0 this adds `constant` to the estimate.
    Ended {
        /// `c` times the throughput before roulette.
        constant: Rgb,
    },
}

impl<'s, S: Scene + ?Sized + 's> RandomWalk<'s, S> {
    /// Starts a walk at the camera, through the point `u` of the film's window. Returns the vertex
    /// on the lens too.
    #[inline(always)]
    pub fn from_camera<C: Camera + ?Sized, P: Sampler>(
        scene: &'s S,
        camera: &C,
        u: DVec2,
        sampler: &mut P,
    ) -> Option<(Self, Vertex<S::Bsdf<'s>>)> {
        sampler.stream(Stream::Lens);
        let (u1, u2) = lens_numbers(camera, sampler);
        let lens = camera.sample_point(u1, u2)?;
        let start = StartDensity { walk: lens.pdf, connection: lens.pdf };
        let mut vertex = Vertex::endpoint(lens.point, None, start);
        Some((Self::start(scene, camera, Walk::Camera, &mut vertex, u)?, vertex))
    }

    /// Starts a walk at a light chosen by the scene. The vertex on the light is returned even if no
    /// ray leaves it, because it may still be connected to.
    pub fn from_light<P: Sampler>(
        scene: &'s S,
        sampler: &mut P,
        counters: &mut Counters,
    ) -> Option<(Option<Self>, Vertex<S::Bsdf<'s>>)> {
        sampler.stream(Stream::Emission);
        let (u0, u1, u2, u3) =
            (sampler.next_1d(), sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
        counters.light_walks += 1;
        let (id, pmf) = scene.pick_light(u0)?;
        let light = scene.light(id);
        let sample = light.sample_point(u1, u2)?;
        let pdf = sample.pdf * pmf;
        let mut vertex =
            Vertex::endpoint(sample.point, Some(id), StartDensity { walk: pdf, connection: pdf });
        let walk = Self::start(scene, light, Walk::Light, &mut vertex, u3);
        if let Some(walk) = &walk {
            counters.ledger.emitted += walk.throughput;
        }
        Some((walk, vertex))
    }

    #[inline(always)]
    fn start<E: Endpoint + ?Sized>(
        scene: &'s S,
        endpoint: &E,
        walk: Walk,
        vertex: &mut Vertex<S::Bsdf<'s>>,
        u: DVec2,
    ) -> Option<Self> {
        vertex.throughput = Rgb::splat(1.0 / vertex.start.walk.value());
        let ray = endpoint.sample_direction(&vertex.point, u)?;
        vertex.point = ray.from;
        vertex.pdf_next = ray.pdf;
        let throughput = ray.weight * vertex.throughput;
        Some(Self {
            scene,
            walk,
            from: ray.from,
            direction: ray.direction,
            throughput,
            reference: throughput.max_component(),
            survival: 1.0,
            vertices: 0,
        })
    }

    /// From which end it comes.
    #[inline]
    #[must_use]
    pub fn kind(&self) -> Walk {
        self.walk
    }

    /// Number of surface vertices met so far.
    #[inline]
    #[must_use]
    pub fn vertices(&self) -> u32 {
        self.vertices
    }

    /// Where the ray starts that leads to the next vertex, and after [`arrive`](Self::arrive) the
    /// one that led there.
    #[inline]
    #[must_use]
    pub fn from(&self) -> &SurfacePoint {
        &self.from
    }

    /// The throughput that the next vertex will have.
    #[must_use]
    pub fn throughput(&self) -> Rgb {
        self.throughput
    }

    /// The ray that leads to the next vertex.
    #[inline]
    #[must_use]
    pub fn ray(&self) -> (&SurfacePoint, DVec3) {
        (&self.from, self.direction)
    }

    /// Traces the ray. Returns the vertex that it meets: on a surface, or at infinity if a camera
    /// walk reaches an environment.
    #[inline(always)]
    pub fn arrive(&mut self, counters: &mut Counters) -> Option<Vertex<S::Bsdf<'s>>> {
        counters.closest_rays += 1;
        let vertex = self.vertex_at(self.scene.intersect(&self.from, self.direction));
        self.count_vertex(vertex.as_ref(), counters);
        vertex
    }

    /// The vertex at the point that the [ray](Self::ray) meets; if it meets none, at infinity or
    /// nowhere.
    #[inline(always)]
    pub(crate) fn vertex_at(&self, point: Option<SurfacePoint>) -> Option<Vertex<S::Bsdf<'s>>> {
        let Some(point) = point else {
            let id =
                if self.walk == Walk::Camera { self.scene.environment()? } else { return None };
            let point =
                SurfacePoint::infinite(self.from.position + self.direction, -self.direction);
            return Some(self.vertex(point, None, Some(id)));
        };
        let bsdf = ShadedBsdf::new(self.scene.bsdf(&point), &point);
        Some(self.vertex(point, Some(bsdf), self.scene.light_at(&point)))
    }

    /// Records what [`vertex_at`](Self::vertex_at) has found.
    #[inline(always)]
    pub(crate) fn count_vertex(
        &mut self,
        vertex: Option<&Vertex<S::Bsdf<'s>>>,
        counters: &mut Counters,
    ) {
        if vertex.is_some_and(|vertex| vertex.bsdf.is_some()) {
            self.vertices += 1;
        } else if self.walk == Walk::Light {
            counters.ledger.escaped += self.throughput;
        }
    }

    #[inline(always)]
    fn vertex(
        &self,
        point: SurfacePoint,
        bsdf: Option<ShadedBsdf<S::Bsdf<'s>>>,
        light: Option<LightId>,
    ) -> Vertex<S::Bsdf<'s>> {
        // Not by way of another vertex, which would be copied.
        Vertex {
            bsdf,
            light,
            throughput: self.throughput,
            survival: self.survival,
            to_previous: -self.direction,
            pdf_next: PerProjected::ZERO,
            pdf_back: PerProjected::ZERO,
            geometry: Edge::along(&self.from, &point, self.direction).geometry,
            dirac: false,
            start: StartDensity::default(),
            rivals: 0.0,
            point,
        }
    }

    /// Samples the next direction at the vertex that was just reached, records it there, and plays
    /// Russian roulette.
    #[inline]
    pub fn scatter<P: Sampler>(
        &mut self,
        vertex: &mut Vertex<S::Bsdf<'s>>,
        roulette: &Roulette,
        sampler: &mut P,
        counters: &mut Counters,
    ) -> Scattered {
        const ENDED: Scattered = Scattered::Ended { constant: Rgb::BLACK };
        let Some(bsdf) = &vertex.bsdf else { return ENDED };
        if self.vertices > MAX_BOUNCES {
            self.truncate(counters);
            return ENDED;
        }
        sampler.stream(match self.walk {
            Walk::Camera => Stream::CameraVertex(self.vertices),
            Walk::Light => Stream::LightVertex(self.vertices),
        });
        counters.scattered += 1;
        let sample = bsdf.sample(-self.direction, self.walk, sampler.next_1d(), sampler.next_2d());
        let before = self.throughput;
        let Some(sample) = sample else {
            if self.walk == Walk::Light {
                counters.ledger.absorbed += before;
            }
            return ENDED;
        };
        vertex.pdf_next = sample.pdf;
        vertex.pdf_back = sample.pdf_reverse;
        vertex.dirac = sample.dirac;
        self.throughput = before * sample.weight;
        if !self.throughput.is_finite() {
            counters.non_finite += 1;
            if self.walk == Walk::Light {
                counters.ledger.rejected += before;
            }
            return ENDED;
        }
        if self.walk == Walk::Light {
            counters.ledger.absorbed += before - self.throughput;
        } else {
            // Radiance grows by n² on entering a medium; only what is left beside that says how
            // much longer the walk is worth following.
            self.reference /= sample.relative_ior * sample.relative_ior;
        }
        if self.throughput.is_black() {
            return ENDED;
        }
        self.from = vertex.point;
        self.direction = sample.next;
        let relative = self.throughput.max_component() / self.reference;
        let constant = roulette.constant(self.walk) * self.throughput;
        match roulette.decide(self.vertices, relative, || sampler.next_1d()) {
            Termination::Continue => Scattered::On { constant: Rgb::BLACK },
            Termination::Survived { q } => {
                self.throughput = self.throughput / (1.0 - q);
                self.survival *= 1.0 - q;
                Scattered::On { constant: constant * (-q / (1.0 - q)) }
            }
            Termination::Terminated => Scattered::Ended { constant },
        }
    }

    /// Walks until absorption, escape, roulette or `max_bounces` scattering events, and appends
    /// every vertex to `vertices`. Roulette must have c = 0: nobody is there to add the constant.
    pub fn record<P: Sampler>(
        self,
        vertices: &mut Vec<Vertex<S::Bsdf<'s>>>,
        max_bounces: u32,
        roulette: &Roulette,
        sampler: &mut P,
        counters: &mut Counters,
    ) {
        self.record_while(vertices, max_bounces, roulette, sampler, counters, |_| true);
    }

    /// The same, but ends at the first surface unless `go_on` is true of what was found and sampled
    /// there.
    pub(crate) fn record_while<P: Sampler>(
        mut self,
        vertices: &mut Vec<Vertex<S::Bsdf<'s>>>,
        max_bounces: u32,
        roulette: &Roulette,
        sampler: &mut P,
        counters: &mut Counters,
        go_on: impl Fn(&Vertex<S::Bsdf<'s>>) -> bool,
    ) {
        while let Some(mut vertex) = self.arrive(counters) {
            let last = self.vertices > max_bounces;
            let ended = if last {
                self.truncate(counters);
                true
            } else {
                matches!(
                    self.scatter(&mut vertex, roulette, sampler, counters),
                    Scattered::Ended { .. }
                )
            };
            let is_end = ended || (self.vertices == 1 && !go_on(&vertex));
            vertices.push(vertex);
            if is_end {
                break;
            }
        }
    }

    /// Records that a limit on the number of bounces ends the walk here.
    pub fn truncate(&self, counters: &mut Counters) {
        counters.truncated_walks += 1;
        if self.walk == Walk::Light {
            counters.ledger.truncated += self.throughput;
        }
    }
}

/// The densities of a point of a light, as the start of a walk and as the point that `receiver`
/// connects to, each with the probability of choosing the light.
#[must_use]
pub(super) fn emission_density<S: Scene + ?Sized>(
    scene: &S,
    id: LightId,
    receiver: &SurfacePoint,
    point: &SurfacePoint,
) -> StartDensity {
    let (light, pmf) = (scene.light(id), scene.pick_pmf(id));
    StartDensity {
        walk: light.point_pdf(point) * pmf,
        connection: light.pdf_from(receiver, point) * pmf,
    }
}
