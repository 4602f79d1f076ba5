//! Bidirectional path tracing: one subpath from the camera and one from a light, and every way to
//! join a part of the one to a part of the other (Lafortune and Willems 1993; Veach and Guibas
//! 1994). Restricted to a set of techniques it is any of the incremental integrators: the general
//! form that the dedicated ones are tested against.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::any_run::on_world;
use super::shared::LightWalks;
use super::{Crew, Depth, Integrator, Notes, Run, Stage, StartOnWorld, Started};
use crate::film::{Contribution, Sample, Sink, Technique};
use crate::path::{
    Counters, Heuristic, Out, Path, Plan, RandomWalk, Roulette, Scratch, Site, Steps, TechniqueSet,
    Visit, Weighting, advance, join, offer,
};
use crate::sampler::Sampler;
use crate::scene::Scene;
use std::ops::{ControlFlow, Range};

/// Bidirectional path tracing over any set of techniques.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bidirectional {
    /// The techniques to run, before those that a scene cannot use are left out.
    pub techniques: TechniqueSet,
    /// The path lengths that count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
    /// The weights of the techniques.
    pub heuristic: Heuristic,
}

impl Bidirectional {
    /// All techniques up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    pub(super) fn run<S: Scene + ?Sized>(self, stage: Stage<'_, S>) -> Pairs<'_, S> {
        let plan = Plan::new(stage, self.techniques, self.depth);
        let weighting = Weighting::new(plan.techniques, self.heuristic);
        Pairs { plan, roulette: self.roulette.without_constant(), weighting }
    }
}

impl<S: Scene + ?Sized> Integrator<S> for Bidirectional {
    type Run<'a>
        = Pairs<'a, S>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::bidirectional);

    fn name(&self) -> &'static str {
        "bidirectional"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Pairs<'a, S>> {
        Ok(self.run(stage))
    }
}

/// A rendering by pairs of subpaths.
pub struct Pairs<'a, S: Scene + ?Sized> {
    pub(super) plan: Plan<'a, S>,
    pub(super) roulette: Roulette,
    pub(super) weighting: Weighting,
}

/// Samples that are drawn at a time, so few that their subpaths stay in a processor's caches.
const BATCH: usize = 128;

/// Walks from the camera.
struct CameraWalks<'r, 'a, S: Scene + ?Sized>(&'r Pairs<'a, S>);
impl<'a, S: Scene + ?Sized> Run<'a, S> for Pairs<'a, S> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.plan.techniques
    }

    fn notes(&self) -> Notes {
        Notes::of(&self.plan)
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        self.draw_and_merge(samples, sink, scratch, |_| {});
    }
}

impl<'a, S: Scene + ?Sized> Steps<'a, S> for CameraWalks<'_, 'a, S> {
    const KEEPS: bool = true;

    #[inline]
    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        site.subpaths.camera.clear();
        let Plan { stage, techniques, depth, .. } = site.plan;
        if !techniques.has_camera_subpath() {
            return None;
        }
        let (walk, lens) = stage.camera_walk(site.sample)?;
        site.subpaths.camera.push(lens);
        (techniques.bsdf_sampling || depth.limit() > 0).then_some(walk)
    }

    #[inline]
    fn leave<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        // The last vertex can only be hit: a connection needs one scattering event more.
        let connected = u32::from(!visit.plan.techniques.bsdf_sampling);
        visit.limit(visit.plan.depth.limit().saturating_sub(connected))
    }

    #[inline]
    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.scatter(&self.0.roulette).flow()
    }
}

impl<'a, S: Scene + ?Sized> Pairs<'a, S> {
    /// Draws samples, and shows `merge` each with its complete camera subpath.
    pub(super) fn draw_and_merge<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        scratch: &mut Scratch<'a, S>,
        mut merge: impl FnMut(&mut Site<'_, 'a, S, P>),
    ) {
        for (number, samples) in samples.chunks_mut(BATCH).enumerate() {
            let sink = &mut |i: usize, found: &Contribution| sink.add(number * BATCH + i, found);
            self.trace(samples, sink, scratch, &mut offer, &mut merge);
        }
    }

    /// Draws samples and offers each path that may contribute, with its contribution if it is
    /// visible.
    #[inline]
    pub(super) fn trace<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        scratch: &mut Scratch<'a, S>,
        offer: &mut impl FnMut(&mut Out<'_>, &Path<'_, 'a, S>, Contribution, &mut Counters),
        mut merge: impl FnMut(&mut Site<'_, 'a, S, P>),
    ) {
        let (Plan { stage, techniques, .. }, mut rounds) = (&self.plan, 0);
        // The shortest connection has one scattering event to the lens, two to a camera subpath.
        let shortest = if techniques.lens_sampling { 1 } else { 2 };
        scratch.counters.samples += samples.len() as u64;
        advance(&self.plan, &CameraWalks(self), samples, sink, scratch);
        join(&self.plan, samples, sink, scratch, |site| {
            self.weighting.complete_camera_subpath(&mut site.subpaths.camera, stage.camera);
            site.sample_emitters(&self.weighting);
            for t in 2..=site.subpaths.camera.len() {
                self.draw_paths(0..2, t, site, offer);
            }
            merge(site);
            let number = techniques.draw_light_subpaths(&mut site.sample.sampler);
            site.subpaths.light_subpaths = number;
            rounds = rounds.max(number);
        });
        for number in 0..rounds {
            let walks = LightWalks { roulette: &self.roulette, number, shortest };
            advance(&self.plan, &walks, samples, sink, scratch);
            join(&self.plan, samples, sink, scratch, |site| {
                self.weighting.complete_light_subpath(&mut site.subpaths.light, stage);
                site.connect_subpaths(&self.weighting);
                let last = site.subpaths.light.len();
                self.draw_paths(1..last + 1, 1, site, offer);
                for t in 2..=site.subpaths.camera.len() {
                    self.draw_paths(2..last + 1, t, site, offer);
                }
            });
        }
    }

    /// Draws paths by techniques (s, t) and offers them with their weights.
    #[inline(never)]
    fn draw_paths<P: Sampler>(
        &self,
        s: Range<usize>,
        t: usize,
        site: &mut Site<'_, 'a, S, P>,
        offer: &mut impl FnMut(&mut Out<'_>, &Path<'_, 'a, S>, Contribution, &mut Counters),
    ) {
        for technique in s.map(|s| Technique::new(s as u16, t as u16)) {
            if self.plan.draws(technique) {
                site.draw_path(technique, &self.weighting, offer);
            }
        }
    }
}
