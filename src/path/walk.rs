//! The one random walk of the crate: traces a ray, reports the vertex, samples the next direction.
//!
//! Every integrator that builds paths incrementally uses it, from the camera or from a light. The
//! estimate that a walk carries (its throughput) is the product of `f/p⊥` over its vertices:
//! geometry terms cancel against `p_area = p⊥ G`.

use super::connect::lens_numbers;
use super::{Counters, Edge, Roulette, Scattered, Stage, StartDensity, Vertex};
use crate::bsdf::shading::ShadedBsdf;
use crate::bsdf::{BsdfSample, TransportMode};
use crate::endpoint::{Camera, Endpoint, Light, LightId};
use crate::geometry::{Place, SurfacePoint};
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
    mode: TransportMode,
    from: SurfacePoint,
    direction: DVec3,
    /// Density of the direction.
    pdf: PerProjected,
    /// True if a Dirac lobe sent the walk into the direction.
    dirac: bool,
    /// Throughput at the vertex that comes next.
    throughput: Rgb,
    /// The reference of Russian roulette for the throughput: its largest component at the start,
    /// times refraction's n² on the way.
    reference: f64,
    /// Product of the probabilities 1 - q of surviving roulette so far.
    survival: f64,
    /// Number of scattering events so far.
    bounces: u32,
    /// The weight that steps carry from vertex to vertex, and with which
    /// [contributions](super::Visit::contribution) count; 1 at the start.
    pub weight: f64,
}

impl<'s, S: Scene + ?Sized + 's> RandomWalk<'s, S> {
    /// Starts a walk at the camera, through the point `u` of the film's window. Returns the vertex
    /// on the lens too.
    #[inline(always)]
    pub fn from_camera<P: Sampler>(
        scene: &'s S,
        camera: &dyn Camera,
        u: DVec2,
        sampler: &mut P,
    ) -> Option<(Self, Vertex<S::Bsdf<'s>>)> {
        sampler.stream(Stream::Lens);
        let (u1, u2) = lens_numbers(camera, sampler);
        let lens = camera.sample_point(u1, u2)?;
        let start = StartDensity { walk: lens.pdf, connection: lens.pdf };
        let mut vertex = Vertex::endpoint(lens.point, None, start);
        Some((Self::start(scene, camera, TransportMode::Radiance, &mut vertex, u)?, vertex))
    }

    /// Starts a walk at a light chosen by the scene. The vertex on the light is returned even if no
    /// ray leaves it, because it may still be connected to.
    #[inline(always)]
    pub fn from_light<P: Sampler>(
        stage: &Stage<'s, S>,
        sampler: &mut P,
        counters: &mut Counters,
    ) -> Option<(Option<Self>, Vertex<S::Bsdf<'s>>)> {
        sampler.stream(Stream::Emission);
        let (u0, u1, u2, u3) =
            (sampler.next_1d(), sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
        counters.light_subpaths += 1;
        let (id, pmf) = stage.pick_light(u0)?;
        let light = stage.scene.light(id);
        let sample = light.sample_point(u1, u2)?;
        let pdf = sample.pdf * pmf;
        let mut vertex =
            Vertex::endpoint(sample.point, Some(id), StartDensity { walk: pdf, connection: pdf });
        let walk = Self::start(stage.scene, light, TransportMode::Importance, &mut vertex, u3);
        if let Some(walk) = &walk {
            counters.ledger.emitted += walk.throughput;
        }
        Some((walk, vertex))
    }

    #[inline(always)]
    fn start<E: Endpoint + ?Sized>(
        scene: &'s S,
        endpoint: &E,
        mode: TransportMode,
        vertex: &mut Vertex<S::Bsdf<'s>>,
        u: DVec2,
    ) -> Option<Self> {
        vertex.throughput = Rgb::splat(1.0 / vertex.start.walk.value());
        let medium = scene.medium_at(&vertex.point);
        vertex.point.medium = medium;
        let ray = endpoint.sample_direction(&vertex.point, u)?;
        vertex.point = SurfacePoint { medium, ..ray.from };
        vertex.pdf_next = ray.pdf;
        let throughput = ray.weight * vertex.throughput;
        Some(Self {
            scene,
            mode,
            from: vertex.point,
            direction: ray.direction,
            pdf: ray.pdf,
            dirac: false,
            throughput,
            reference: throughput.max_component(),
            survival: 1.0,
            bounces: 0,
            weight: 1.0,
        })
    }

    /// A walk under way on a ray of some density, with throughput, reference and survival, after so
    /// many scattering events, none of which was that of a Dirac lobe.
    pub(super) fn under_way(
        scene: &'s S,
        mode: TransportMode,
        (from, direction, pdf): (SurfacePoint, DVec3, PerProjected),
        [red, green, blue, reference, survival]: [f64; 5],
        bounces: u32,
    ) -> Self {
        Self {
            scene,
            mode,
            from,
            direction,
            pdf,
            dirac: false,
            throughput: Rgb::new(red, green, blue),
            reference,
            survival,
            bounces,
            weight: 1.0,
        }
    }

    /// Throughput, reference and survival, as for [`under_way`](Self::under_way).
    #[inline(always)]
    pub(super) fn carried(&self) -> [f64; 5] {
        let [red, green, blue] = self.throughput.0;
        [red, green, blue, self.reference, self.survival]
    }

    /// The quantity that it estimates, and so the end that it comes from.
    #[inline]
    #[must_use]
    pub fn mode(&self) -> TransportMode {
        self.mode
    }

    /// Number of scattering events so far.
    #[inline]
    #[must_use]
    pub fn bounces(&self) -> u32 {
        self.bounces
    }

    /// Density of the direction under way, given the vertex where it was sampled.
    #[inline]
    #[must_use]
    pub fn pdf(&self) -> PerProjected {
        self.pdf
    }

    /// True if the vertex before this direction could have been connected to what it leads to: a
    /// surface that scattered by a lobe which is a function.
    #[inline]
    #[must_use]
    pub fn is_from_connectible(&self) -> bool {
        self.bounces > 0 && !self.dirac
    }

    /// The start of the ray that leads to the next vertex; at a vertex that was just reached, of the
    /// one that led there.
    #[inline]
    #[must_use]
    pub fn from(&self) -> &SurfacePoint {
        &self.from
    }

    /// The throughput that the next vertex will have, but for what is absorbed on the way.
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

    /// Enters the vertex at the point that the [ray](Self::ray) meets; if it meets none, at
    /// infinity, where a camera walk reaches an environment. Returns false if there is neither.
    #[inline(always)]
    pub(super) fn meet(
        &self,
        point: Option<SurfacePoint>,
        vertex: &mut Vertex<S::Bsdf<'s>>,
    ) -> bool {
        let Some(point) = point else { return self.meet_environment(vertex) };
        vertex.bsdf = Some(ShadedBsdf::new(self.scene.bsdf(&point), &point));
        self.enter(vertex, point, self.scene.light_at(&point));
        true
    }

    #[inline(never)]
    fn meet_environment(&self, vertex: &mut Vertex<S::Bsdf<'s>>) -> bool {
        let light = self.scene.environment().filter(|_| self.mode == TransportMode::Radiance);
        if light.is_some() {
            let infinite = self.from.position + self.direction;
            let point = SurfacePoint::infinite(infinite, -self.direction);
            vertex.bsdf = None;
            self.enter(vertex, point, light);
        }
        light.is_some()
    }

    /// Records that nothing was met.
    #[inline]
    pub(super) fn count_escape(&self, counters: &mut Counters) {
        counters.escape(self.mode, self.throughput);
    }

    /// Enters all but the BSDF in a vertex, field by field, because it is large.
    #[inline(always)]
    fn enter(&self, vertex: &mut Vertex<S::Bsdf<'s>>, point: SurfacePoint, light: Option<LightId>) {
        vertex.geometry = Edge::along(&self.from, &point, self.direction).geometry;
        vertex.point = point;
        vertex.point.medium = self.scene.medium_towards(&self.from, self.direction);
        vertex.light = light;
        vertex.throughput = self.throughput * self.scene.transmittance(&self.from, &vertex.point);
        vertex.survival = self.survival;
        vertex.to_previous = -self.direction;
        (vertex.pdf_next, vertex.pdf_back) = (PerProjected::ZERO, PerProjected::ZERO);
        vertex.dirac = false;
        vertex.start = StartDensity::default();
        vertex.partial = 0.0;
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
        let Some(bsdf) = &vertex.bsdf else { return Scattered::ENDED };
        let Some((u1, u2)) = self.begin_scattering(sampler, counters) else {
            return Scattered::ENDED;
        };
        let sample = bsdf.sample(-self.direction, self.mode, u1, u2);
        self.follow(vertex, sample.as_ref(), roulette, sampler, counters)
    }

    /// Counts a scattering event and draws its numbers; `None` if it is one too many.
    #[inline(always)]
    pub(super) fn begin_scattering<P: Sampler>(
        &self,
        sampler: &mut P,
        counters: &mut Counters,
    ) -> Option<(f64, DVec2)> {
        if self.bounces >= MAX_BOUNCES {
            self.truncate(counters);
            return None;
        }
        sampler.stream(match self.mode {
            TransportMode::Radiance => Stream::CameraVertex(self.bounces + 1),
            TransportMode::Importance => Stream::LightVertex(self.bounces + 1),
        });
        counters.scattered += 1;
        Some(sampler.next_1d_2d())
    }

    /// Follows a direction that was sampled at the vertex, records it there, and plays Russian
    /// roulette.
    #[inline(always)]
    pub(super) fn follow<P: Sampler>(
        &mut self,
        vertex: &mut Vertex<S::Bsdf<'s>>,
        sample: Option<&BsdfSample>,
        roulette: &Roulette,
        sampler: &mut P,
        counters: &mut Counters,
    ) -> Scattered {
        self.bounces += 1;
        let before = self.throughput;
        let Some(sample) = sample else {
            if self.mode == TransportMode::Importance {
                counters.ledger.absorbed += before;
            }
            return Scattered::ENDED;
        };
        (vertex.pdf_next, vertex.pdf_back) = (sample.pdf, sample.pdf_reverse);
        vertex.dirac = sample.dirac;
        // ANCHOR: throughput
        self.throughput = vertex.throughput * sample.weight;
        // ANCHOR_END: throughput
        if !self.throughput.is_finite() {
            counters.non_finite += 1;
            if self.mode == TransportMode::Importance {
                counters.ledger.rejected += before;
            }
            return Scattered::ENDED;
        }
        if self.mode == TransportMode::Importance {
            counters.ledger.absorbed += before - self.throughput;
        } else {
            // Radiance grows by n² on entering a medium; only what is left beside that says how
            // much longer the walk is worth following.
            self.reference /= sample.relative_ior * sample.relative_ior;
        }
        if self.throughput.is_black() {
            return Scattered::ENDED;
        }
        (self.from, self.direction) = (vertex.point, sample.next);
        (self.pdf, self.dirac) = (sample.pdf, sample.dirac);
        let relative = self.throughput.max_component() / self.reference;
        let xi = || sampler.next_1d();
        let scattered = roulette.play(self.mode, self.bounces, relative, &mut self.throughput, xi);
        self.survival *= scattered.survival;
        scattered
    }

    /// The walk if it is of use; else it is recorded as one that a limit ends.
    #[must_use]
    pub fn if_useful(self, is_useful: bool, counters: &mut Counters) -> Option<Self> {
        if !is_useful {
            self.truncate(counters);
        }
        is_useful.then_some(self)
    }

    /// Records that a limit on the number of bounces ends the walk here.
    pub fn truncate(&self, counters: &mut Counters) {
        counters.truncate(self.mode, self.throughput, self.bounces);
    }
}

/// The density of the direction from a point of a light to `receiver`.
pub(super) fn emission_pdf(
    light: &(impl Light + ?Sized),
    point: &SurfacePoint,
    receiver: &SurfacePoint,
    direction: DVec3,
) -> f64 {
    if point.place == Place::Infinite {
        // It has no position of its own, and may have been placed on another ray.
        let on_ray = SurfacePoint { position: receiver.position, ..*point };
        light.direction_pdf(&on_ray, direction).value()
    } else {
        light.direction_pdf(point, direction).value()
    }
}

/// The densities of a point of a light, as the start of a walk and as the point that `receiver`
/// connects to, each with the probability of choosing the light.
#[must_use]
pub(super) fn emission_density<S: Scene + ?Sized>(
    stage: &Stage<'_, S>,
    id: LightId,
    receiver: &SurfacePoint,
    point: &SurfacePoint,
) -> StartDensity {
    let light = stage.scene.light(id);
    StartDensity {
        walk: light.point_pdf(point) * stage.pick_pmf(id),
        connection: light.pdf_from(receiver, point) * stage.pick_pmf_for(receiver, id),
    }
}
