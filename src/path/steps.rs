//! The one loop: subpaths of many samples that advance together, from vertex to vertex, so that a
//! scene gets many rays at a time (Laine, Karras and Aila 2013).
//!
//! An integrator says what a walk does where it begins, where it arrives and when it scatters
//! ([`Steps`]), each for a single path; [`advance`] traces the rays and tests the shadow rays of
//! all of them. The contributions of a sample do not depend on which others it advances with.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::scratch::Advancing;
use super::{
    Counters, End, NextEvent, Out, Plan, RandomWalk, Roulette, Scattered, Scratch, Subpaths,
    Vertex, sample_next_event,
};
use crate::endpoint::LightId;
use crate::film::{Contribution, Sample, Sink, Technique};
use crate::math::Rgb;
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
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
}

/// The steps of one walk.
pub trait Steps<'s, S: Scene + ?Sized + 's> {
    /// True if a subpath keeps all its vertices, so that they can be connected to when it is
    /// complete. Otherwise its list has the last one in the first place.
    const KEEPS: bool = false;

    /// Begins the walk of a sample; `None` if it has none. By default at the camera.
    #[inline(always)]
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 's, S, P>) -> Option<RandomWalk<'s, S>> {
        Some(site.plan.stage.camera_walk(site.sample)?.0)
    }

    /// Looks at the vertex where a walk has arrived, on a surface or an environment, before it
    /// scatters: what contributes, what is connected, whether the walk goes on.
    fn arrive<P: Sampler>(&self, _visit: &mut Visit<'_, 's, S, P>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Samples where the walk goes on, after the shadow rays from this vertex have been tested.
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 's, S, P>) -> ControlFlow<()>;
}

/// Draws one walk for each sample and lets all of them advance together until the steps end them or
/// no ray meets anything. Contributions go to the sink with the numbers of their samples.
#[inline]
pub fn advance<'s, S: Scene + ?Sized, W: Steps<'s, S>, P: Sampler>(
    plan: &Plan<'s, S>,
    steps: &W,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    scratch: &mut Scratch<'s, S>,
) {
    let scene = plan.stage.scene;
    begin(plan, steps, samples, sink, scratch);
    while !scratch.walks.is_empty() {
        trace::<S, W>(scene, scratch);
        arrive(plan, steps, samples, sink, scratch);
        scratch.connections.test(scene, &scratch.subpaths, sink);
        scatter(plan, steps, samples, sink, scratch);
    }
}

/// Shows `visit` each sample with its subpaths, and tests the shadow rays of all of them.
#[inline]
pub fn join<'s, S: Scene + ?Sized, P: Sampler>(
    plan: &Plan<'s, S>,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    scratch: &mut Scratch<'s, S>,
    mut visit: impl FnMut(&mut Site<'_, 's, S, P>),
) {
    let Scratch { counters, subpaths, connections, .. } = scratch;
    subpaths.resize_with(subpaths.len().max(samples.len()), Subpaths::default);
    for (number, (sample, subpaths)) in samples.iter_mut().zip(&mut *subpaths).enumerate() {
        let out = Out { sample: number, sink: &mut *sink, connections };
        visit(&mut Site { plan, sample, subpaths, out, counters });
    }
    connections.test(plan.stage.scene, subpaths, sink);
}

#[inline]
fn begin<'s, S: Scene + ?Sized, W: Steps<'s, S>, P: Sampler>(
    plan: &Plan<'s, S>,
    steps: &W,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    scratch: &mut Scratch<'s, S>,
) {
    let mut walks = std::mem::take(&mut scratch.walks);
    walks.clear();
    let mut sample = 0;
    join(plan, samples, sink, scratch, |site| {
        if let Some(walk) = steps.begin(site) {
            let next = if W::KEEPS { site.subpaths.of(walk.mode()).len() as u32 } else { 0 };
            walks.push(Advancing { sample, walk, next, has_ended: false });
        }
        sample += 1;
    });
    scratch.walks = walks;
}

#[inline]
fn arrive<'s, S: Scene + ?Sized, P: Sampler>(
    plan: &Plan<'s, S>,
    steps: &impl Steps<'s, S>,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    Scratch { counters, subpaths, walks, arrived, connections }: &mut Scratch<'s, S>,
) {
    for (Advancing { sample: number, walk, next, has_ended }, arrived) in
        walks.iter_mut().zip(arrived)
    {
        let mode = walk.mode();
        let vertex = subpaths[*number].of(mode).get_mut(*next as usize).filter(|_| *arrived);
        walk.count_vertex(vertex.as_deref(), counters);
        *has_ended = vertex.is_none_or(|vertex| {
            let (sample, end) = (&mut samples[*number], End::of(mode, *next));
            let out = Out { sample: *number, sink: &mut *sink, connections };
            steps.arrive(&mut Visit { plan, walk, vertex, end, sample, out, counters }).is_break()
        });
    }
}

/// Keeps the walks that go on.
#[inline]
fn scatter<'s, S: Scene + ?Sized, W: Steps<'s, S>, P: Sampler>(
    plan: &Plan<'s, S>,
    steps: &W,
    samples: &mut [Sample<P>],
    sink: &mut dyn Sink,
    Scratch { counters, subpaths, walks, connections, .. }: &mut Scratch<'s, S>,
) {
    for i in (0..walks.len()).rev() {
        let Advancing { sample: number, walk, next, has_ended } = &mut walks[i];
        let mode = walk.mode();
        let vertices = subpaths[*number].of(mode);
        let goes_on = !*has_ended
            && vertices.get_mut(*next as usize).is_some_and(|vertex| {
                let (sample, end) = (&mut samples[*number], End::of(mode, *next));
                let out = Out { sample: *number, sink: &mut *sink, connections };
                let visit = &mut Visit { plan, walk, vertex, end, sample, out, counters };
                steps.scatter(visit).is_continue()
            });
        if !goes_on {
            walks.swap_remove(i);
        } else if W::KEEPS {
            *next += 1;
        }
    }
}

/// Traces the next ray of each walk and enters what it meets in its subpath.
#[inline]
fn trace<'s, S: Scene + ?Sized, W: Steps<'s, S>>(
    scene: &'s S,
    Scratch { counters, subpaths, walks, arrived, .. }: &mut Scratch<'s, S>,
) {
    counters.closest_rays += walks.len() as u64;
    arrived.clear();
    arrived.resize(walks.len(), false);
    scene.intersect_many(walks.iter().map(|path| path.walk.ray()), |i, point| {
        let Advancing { sample, walk, next, .. } = &walks[i];
        let vertices = subpaths[*sample].of(walk.mode());
        if W::KEEPS {
            vertices.extend(walk.meet(point));
            arrived[i] = vertices.len() > *next as usize;
            return;
        }
        // Written where the one before was, because a vertex is large.
        if vertices.is_empty() {
            vertices.push(Vertex::blank());
        }
        if let Some(vertex) = walk.meet(point) {
            vertices[0] = vertex;
            arrived[i] = true;
        }
    });
}

impl<'s, S: Scene + ?Sized + 's, P> Visit<'_, 's, S, P> {
    /// Samples where the walk goes on and plays Russian roulette.
    #[inline(always)]
    pub fn scatter(&mut self, roulette: &Roulette) -> Scattered
    where
        P: Sampler,
    {
        self.walk.scatter(self.vertex, roulette, &mut self.sample.sampler, self.counters)
    }

    /// Samples a point on a light for a vertex of a camera walk, if the vertex can be connected,
    /// paths of that length count and next event estimation is in the set; see
    /// [`sample_next_event`].
    #[inline(always)]
    pub fn next_event(&mut self) -> Option<NextEvent>
    where
        P: Sampler,
    {
        let Plan { techniques, depth, .. } = self.plan;
        let wanted = techniques.next_event && depth.contains(self.walk.bounces() + 1);
        if !(wanted && self.vertex.is_connectible()) {
            return None;
        }
        let Self { plan, walk, vertex, sample, out, counters, .. } = self;
        sample.sampler.stream(Stream::NextEvent(walk.bounces() + 1));
        sample_next_event(&plan.stage, vertex, &mut sample.sampler, out, counters)
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
