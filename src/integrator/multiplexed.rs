//! Bidirectional path tracing by one technique per sample, chosen at random with the length of the
//! path. [`Metropolis`](super::Metropolis) over it is multiplexed Metropolis light transport
//! (Hachisuka, Kaplanyan and Dachsbacher 2014): chains keep the length and move from technique to
//! technique, to those of high weight.
//!
//! ```text
//! w f / (p P(k) P(s, t | k))
//! ```
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

use super::any_run::on_world;
use super::{Bidirectional, Crew, Integrator, Notes, Run, Stage, StartOnWorld, Started};
use crate::bsdf::TransportMode;
use crate::film::{Contribution, Sample, Sink, Technique};
use crate::path::{
    Plan, RandomWalk, Roulette, Scratch, Site, Steps, TechniqueSet, Visit, Weighting, advance,
    join, offer,
};
use crate::sampler::{Sampler, Stream};
use crate::scene::Scene;
use std::ops::ControlFlow;

/// Bidirectional path tracing by one technique per sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Multiplexed {
    /// Techniques, path lengths and weights; there is no roulette.
    pub bidirectional: Bidirectional,
}

/// A rendering by one technique per sample.
pub struct Choices<'a, S: Scene + ?Sized> {
    plan: Plan<'a, S>,
    weighting: Weighting,
}

/// The technique of a sample, and one over the probability of choosing it.
type Choice = (Technique, f64);

/// The walk of one kind that each sample needs for its technique.
struct Subpath<'c>(TransportMode, &'c [Option<Choice>]);

/// Lengths that are equally likely, if there are no more.
const MOST_LENGTHS: u32 = 32;
/// If there are more, the length is at least k with probability (4/(4 + k))²: whatever is left of
/// the light at each bounce, all lengths together have a finite variance.
const SCALE: f64 = 4.0;

impl<S: Scene + ?Sized> Integrator<S> for Multiplexed {
    type Run<'a>
        = Choices<'a, S>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::multiplexed);

    fn name(&self) -> &'static str {
        "multiplexed"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<Choices<'a, S>> {
        let Bidirectional { techniques, depth, heuristic, .. } = self.bidirectional;
        let plan = Plan::new(stage, techniques, depth);
        let weighting = Weighting::new(plan.techniques, heuristic);
        Ok(Choices { plan, weighting })
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for Choices<'a, S> {
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
        let Self { plan, weighting } = self;
        scratch.counters.samples += samples.len() as u64;
        let choices: Vec<_> = samples.iter_mut().map(|s| self.choose(&mut s.sampler)).collect();
        for mode in [TransportMode::Radiance, TransportMode::Importance] {
            advance(plan, &Subpath(mode, &choices), samples, sink, scratch);
        }
        let mut choices = choices.iter();
        join(plan, samples, sink, scratch, |site| {
            let Some(Some((technique, scale))) = choices.next() else { return };
            let [from_light, from_camera] = subpaths(*technique);
            let (light, camera) = (&mut site.subpaths.light, &mut site.subpaths.camera);
            if light.len() < from_light || camera.len() < from_camera {
                return;
            }
            weighting.complete_camera_subpath(camera, plan.stage.camera);
            weighting.complete_light_subpath(light, &plan.stage);
            if from_light < usize::from(technique.s) {
                site.sample_emitters(weighting);
            }
            site.draw_path(*technique, weighting, &mut |out, path, found, counters| {
                let found = Contribution { value: found.value * *scale, ..found };
                offer(out, path, found, counters);
            });
        });
    }
}

impl<S: Scene + ?Sized> Choices<'_, S> {
    /// Chooses the length of a path, and one of the techniques that draw such paths.
    fn choose<P: Sampler>(&self, sampler: &mut P) -> Option<Choice> {
        let (shortest, limit) = (self.plan.depth.min_bounces, self.plan.depth.limit());
        let lengths = limit.checked_sub(shortest)?.saturating_add(1);
        sampler.stream(Stream::PathLength);
        let u = sampler.next_1d();
        let (more, probability) = if lengths <= MOST_LENGTHS {
            ((u * f64::from(lengths)) as u32, 1.0 / f64::from(lengths))
        } else {
            let more = (SCALE * ((1.0 - u).sqrt().recip() - 1.0)).floor();
            let at_least = |more: f64| (SCALE / (SCALE + more)).powi(2);
            (more as u32, at_least(more) - at_least(more + 1.0))
        };
        let bounces = u16::try_from(shortest.saturating_add(more)).ok()?;
        let drawn = || {
            let techniques = (0..=bounces + 1).map(|s| Technique::new(s, bounces + 2 - s));
            techniques.filter(|technique| self.plan.draws(*technique))
        };
        let count = drawn().count();
        sampler.stream(Stream::Technique);
        let chosen = drawn().nth((sampler.next_1d() * count as f64) as usize)?;
        Some((chosen, count as f64 / probability))
    }
}

/// The vertices that a technique takes of the subpaths from the light and from the camera; single
/// ones at the end of the other subpath are sampled for that.
fn subpaths(Technique { s, t, .. }: Technique) -> [usize; 2] {
    match (s, t) {
        (_, 1) => [s.into(), 0],
        (1, _) => [0, t.into()],
        _ => [s.into(), t.into()],
    }
}

impl Subpath<'_> {
    fn vertices(&self, sample: usize) -> usize {
        let choice = self.1.get(sample).copied().flatten();
        let [from_light, from_camera] = choice.map_or([0; 2], |(technique, _)| subpaths(technique));
        if self.0 == TransportMode::Radiance { from_camera } else { from_light }
    }
}

impl<'a, S: Scene + ?Sized + 'a> Steps<'a, S> for Subpath<'_> {
    const KEEPS: bool = true;

    fn begin<P: Sampler>(&self, site: &mut Site<'_, 'a, S, P>) -> Option<RandomWalk<'a, S>> {
        let vertices = self.vertices(site.out.sample());
        let Site { plan: Plan { stage, .. }, sample, subpaths, counters, .. } = site;
        let subpath = subpaths.of(self.0);
        subpath.clear();
        if vertices == 0 {
            return None;
        }
        let (walk, start) = match self.0 {
            TransportMode::Radiance => {
                let (walk, lens) = stage.camera_walk(sample)?;
                (Some(walk), lens)
            }
            TransportMode::Importance => {
                RandomWalk::from_light(stage, &mut sample.sampler, counters)?
            }
        };
        subpath.push(start);
        walk.filter(|_| vertices > 1)
    }

    fn leave<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        let has_all = visit.walk.bounces() as usize + 2 >= self.vertices(visit.out.sample());
        if has_all || visit.vertex.bsdf.is_none() {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn scatter<P: Sampler>(&self, visit: &mut Visit<'_, 'a, S, P>) -> ControlFlow<()> {
        visit.scatter(&Roulette::NEVER).flow()
    }
}
