//! The steps of one walk, of which an integrator is made.
//!
//! An integrator says what a walk does where it begins, where it arrives, what it is connected to
//! and when it scatters ([`Steps`]), each for a single path. [`advance`](super::advance), the one
//! loop, traces the rays, samples lights and BSDFs and tests the shadow rays of many paths at a
//! time. The contributions of a sample do not depend on which others it advances with.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::pairs::Pairs;
use super::{
    Counters, DiffuseSteps, End, LensConnection, NextEvent, Out, Plan, RandomWalk, Roulette,
    Scattered, Subpaths, Vertex,
};
use crate::bsdf::{BsdfSample, TransportMode};
use crate::endpoint::{Endpoint, Light, LightId};
use crate::film::{Contribution, Sample, Technique};
use crate::math::{PerArea, Rgb};
use crate::sampler::Sampler;
use crate::scene::Scene;
use fearless_simd::Level;
use std::ops::ControlFlow;

/// A sample before its walk begins, or after its subpaths are complete.
pub struct Site<'v, 's, S: Scene + ?Sized + 's, P> {
    /// The techniques and path lengths that are drawn, and the stage.
    pub plan: &'v Plan<'s, S>,
    /// The sample.
    pub sample: &'v mut Sample<P>,
    /// Its subpaths. A walk that keeps its vertices clears the list when it begins, and enters the
    /// one that it starts at.
    pub subpaths: &'v mut Subpaths<'s, S>,
    /// The way out for contributions.
    pub out: Out<'v>,
    /// Counts of what is done.
    pub counters: &'v mut Counters,
    pub(super) pairs: &'v mut Pairs<'s>,
    pub(super) level: Level,
}

/// A walk at a vertex.
pub struct Visit<'v, 's, S: Scene + ?Sized + 's, P> {
    /// The techniques and path lengths that are drawn, and the stage.
    pub plan: &'v Plan<'s, S>,
    /// The walk.
    pub walk: &'v mut RandomWalk<'s, S>,
    /// The vertex.
    pub vertex: &'v mut Vertex<S::Bsdf<'s>>,
    /// The vertex as an end of shadow rays.
    pub end: End,
    /// The sample that the walk belongs to.
    pub sample: &'v mut Sample<P>,
    /// The way out for contributions.
    pub out: Out<'v>,
    /// Counts of what is done.
    pub counters: &'v mut Counters,
    pub(super) drawn: &'v mut Drawn,
}

/// The point or direction that was drawn for a walk at a vertex.
#[derive(Clone, Copy)]
pub(super) enum Drawn {
    Nothing,
    NextEvent(NextEvent),
    LensConnection(LensConnection),
    /// The direction in which it goes on; `None` if it is absorbed.
    Direction(Option<BsdfSample>),
}

/// The steps of one walk.
pub trait Steps<'s, S: Scene + ?Sized + 's> {
    /// True if a subpath keeps all its vertices, so that they can be connected to when it is
    /// complete. Otherwise its list has the last one in the first place.
    const KEEPS: bool = false;

    /// True if vertices are connected: then [`connect`](Self::connect) is called.
    const CONNECTS: bool = false;

    /// The steps at flat diffuse vertices that emit nothing, if they are as simple as that: then
    /// many are taken at a time, and the walk is not shown where it visits such a vertex.
    fn at_diffuse(&self, _plan: &Plan<'s, S>) -> Option<DiffuseSteps> {
        None
    }

    /// Begins the walk of a sample; `None` if it has none. By default at the camera.
    #[inline(always)]
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 's, S, P>) -> Option<RandomWalk<'s, S>> {
        Some(site.plan.stage.camera_walk(site.sample)?.0)
    }

    /// Looks at the vertex where a walk has arrived, on a surface or an environment: what
    /// contributes, whether the walk ends here.
    fn arrive<P: Sampler>(&self, _visit: &mut Visit<'_, 's, S, P>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// True if a point is to be sampled that the vertex can be connected to.
    fn samples_point<P>(&self, _visit: &Visit<'_, 's, S, P>) -> bool {
        true
    }

    /// Connects the vertex to the point that was sampled for it
    /// ([`next_event`](Visit::next_event), [`lens_connection`](Visit::lens_connection)) and to
    /// whatever else.
    fn connect<P: Sampler>(&self, _visit: &mut Visit<'_, 's, S, P>) {}

    /// Decides whether the walk scatters at the vertex, once that has been connected.
    fn leave<P: Sampler>(&self, _visit: &mut Visit<'_, 's, S, P>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Follows the walk into the direction that was sampled, after the shadow rays from the vertex
    /// have been tested; by default with the default roulette.
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 's, S, P>) -> ControlFlow<()> {
        visit.scatter(&Roulette::default()).flow()
    }
}

impl<'s, S: Scene + ?Sized + 's, P> Visit<'_, 's, S, P> {
    /// Follows the walk into the direction that was sampled, and plays Russian roulette.
    #[inline(always)]
    pub fn scatter(&mut self, roulette: &Roulette) -> Scattered
    where
        P: Sampler,
    {
        let Self { walk, vertex, sample, counters, drawn, .. } = self;
        match drawn {
            Drawn::Direction(direction) => {
                let sampler = &mut sample.sampler;
                walk.follow(vertex, direction.as_ref(), roulette, sampler, counters)
            }
            _ => Scattered::ENDED,
        }
    }

    /// The point on a light that was sampled for this vertex of a camera walk. `None` if the vertex
    /// cannot be connected, if paths of that length do not count, if next event estimation is not
    /// in the set, or if nothing comes of it.
    #[inline(always)]
    pub fn next_event(&self) -> Option<NextEvent> {
        if let Drawn::NextEvent(next) = *self.drawn { Some(next) } else { None }
    }

    /// The connection to a point on the lens that was sampled for this vertex of a light walk.
    /// `None` for the same reasons as for [`next_event`](Self::next_event).
    #[inline(always)]
    pub fn lens_connection(&self) -> Option<LensConnection> {
        if let Drawn::LensConnection(found) = *self.drawn { Some(found) } else { None }
    }

    /// True if a point is sampled that the vertex can be connected to, as far as the plan and the
    /// vertex decide it.
    #[inline(always)]
    pub(super) fn is_connected(&self) -> bool {
        let Plan { techniques, depth, .. } = self.plan;
        let is_drawn = match self.walk.mode() {
            TransportMode::Radiance => techniques.next_event,
            TransportMode::Importance => techniques.lens_sampling,
        };
        is_drawn && depth.contains(self.walk.bounces() + 1) && self.vertex.is_connectible()
    }

    /// The light that the vertex belongs to, and the estimate `T Le` of hitting it, if paths of this
    /// length count and hits are in the set.
    #[inline(always)]
    pub fn emitted(&self) -> Option<(LightId, Rgb)> {
        let Plan { stage, techniques, depth, .. } = self.plan;
        if !(techniques.bsdf_sampling && depth.contains(self.walk.bounces())) {
            return None;
        }
        let (light, radiance) = self.vertex.emission(stage.scene)?;
        Some((light, self.vertex.throughput * radiance))
    }

    /// The same estimate, and the density with which the previous vertex would have been connected to
    /// this point instead, if it can be by a technique in the set.
    #[inline(always)]
    pub fn emitted_beside_connection(&self) -> Option<(Rgb, Option<PerArea>)> {
        let Self { plan: Plan { stage, techniques, depth, .. }, walk, vertex, .. } = self;
        let is_hit = techniques.bsdf_sampling && depth.contains(walk.bounces());
        let id = vertex.light.filter(|_| is_hit)?;
        let (light, from) = (stage.scene.light(id), walk.from());
        let connects = techniques.next_event && walk.is_from_connectible();
        let (radiance, pdf) = if connects && light.can_be_connected() {
            let (radiance, pdf) = light.emission_and_pdf(from, &vertex.point, vertex.to_previous);
            (radiance, Some(pdf))
        } else {
            (light.emit(&vertex.point, vertex.to_previous), None)
        };
        if radiance.is_black() {
            return None;
        }
        let value = vertex.throughput * radiance;
        Some((value, pdf.map(|pdf| pdf * stage.pick_pmf_for(from, id))))
    }

    /// Adds a point on a light that was sampled for this vertex, if the two see each other.
    #[inline(always)]
    pub fn connect(&mut self, next: &NextEvent, weight: f64) {
        self.counters.shadow_rays += 1;
        self.out.connect([self.end, next.end], self.contribution(1, next.value, weight));
    }

    /// A contribution of a camera walk by the technique that draws s vertices from the light and
    /// those up to this one from the camera; `weight` is that within the weight of the walk.
    #[inline]
    #[must_use]
    pub fn contribution(&self, s: u16, value: Rgb, weight: f64) -> Contribution {
        let technique = Technique::new(s, self.walk.bounces() as u16 + 2);
        let weight = self.walk.weight * weight;
        Contribution { raster: self.sample.film.raster, value, weight, technique }
    }

    /// Ends the walk where it cannot scatter, and where it has scattered as often as it may, which
    /// is counted.
    #[inline]
    pub fn limit(&mut self, most_bounces: u32) -> ControlFlow<()> {
        if self.vertex.bsdf.is_none() {
            return ControlFlow::Break(());
        }
        if self.walk.bounces() >= most_bounces {
            self.walk.truncate(self.counters);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}
