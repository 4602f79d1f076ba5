//! Bidirectional path tracing with as much of it as pays: a pilot finds the set of techniques, and
//! the number of light subpaths per camera subpath, with the least variance × cost, from plain path
//! tracing to all techniques, and the rest of the budget goes to that (efficiency-aware multiple
//! importance sampling: Grittmann, Yazici, Georgiev and Slusallek 2022).
//!
//! The pilot is a race by successive halving (Karnin, Koren and Somekh 2013). Only sets that draw
//! every path take part, which is decided from what the scene needs and never from samples; the
//! pilot's samples have random numbers of their own and are not in the image. So the image is
//! unbiased whatever it finds. Costs are counted, not timed: the same seed decides the same.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

mod decision;
mod race;

pub use decision::{Candidate, Decision};

use super::any_run::on_world;
use super::bidirectional::Pairs;
use super::{
    Bidirectional, Crew, Depth, Integrator, LightTracer, Notes, PathTracer, PathTracing, Run,
    SingleWalk, Stage, StartOnWorld, Started,
};
use crate::film::{Sample, Sink};
use crate::math::Rgb;
use crate::path::{
    Counters, Heuristic, Ledger, LightSubpaths, Plan, Roulette, Scratch, TechniqueSet,
};
use crate::sampler::Sampler;
use crate::scene::Scene;
use race::Race;

/// Bidirectional path tracing that leaves out what does not pay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Adaptive {
    /// The path lengths that count.
    pub depth: Depth,
    /// Termination; the constant c is not used.
    pub roulette: Roulette,
    /// The weights of the techniques.
    pub heuristic: Heuristic,
}

/// Part of the rendering's budget for the pilot.
const PILOT: f64 = 0.03;

impl Adaptive {
    /// The adaptive integrator up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }

    /// The fastest run of a set of techniques.
    fn run<'a, S: Scene + ?Sized>(
        &self,
        stage: Stage<'a, S>,
        techniques: TechniqueSet,
    ) -> Chosen<'a, S> {
        let Self { depth, roulette, heuristic } = *self;
        match (techniques.has_camera_subpath(), techniques.has_light_subpath()) {
            (true, false) => {
                let both = techniques.next_event;
                let mode = if both { PathTracing::Both } else { PathTracing::EmissionOnly };
                // The other integrators have no use for the constant.
                let roulette = Roulette { constant: Rgb::BLACK, ..roulette };
                Chosen::Path(PathTracer { mode, depth, roulette, heuristic }.run(stage))
            }
            (false, true) => Chosen::Light(LightTracer { depth, roulette }.run(stage)),
            _ => Chosen::Both(self.bidirectional(techniques).run(stage)),
        }
    }

    fn bidirectional(&self, techniques: TechniqueSet) -> Bidirectional {
        let Self { depth, roulette, heuristic } = *self;
        Bidirectional { techniques, depth, roulette, heuristic }
    }
}

/// The sets that draw every path, the simplest first, all techniques last.
fn candidates<S: Scene + ?Sized>(stage: &Stage<'_, S>, all: TechniqueSet) -> Vec<TechniqueSet> {
    let Stage { needs, camera, .. } = stage;
    let lens = TechniqueSet { lens_sampling: true, ..TechniqueSet::NONE };
    let mut sets = vec![lens, TechniqueSet { bsdf_sampling: true, ..TechniqueSet::NONE }];
    for (connections, lens_sampling) in [(false, false), (false, true), (true, false), (true, true)]
    {
        let set = TechniqueSet { connections, lens_sampling, ..all };
        let walks = |exponent| LightSubpaths::power_of_two(exponent).unwrap_or_default();
        let exponents: &[i8] = if set.has_light_subpath() { &[-3, 0, 2] } else { &[0] };
        sets.extend(exponents.iter().map(|e| TechniqueSet { light_subpaths: walks(*e), ..set }));
    }
    let lens = camera.place();
    sets.retain(|set| set.pruned(needs) == *set && set.is_complete(needs, lens) && *set != all);
    sets.retain(|set| all.lens_sampling || !set.lens_sampling);
    sets.push(all);
    sets
}

/// The run of a set of techniques.
enum Chosen<'a, S: Scene + ?Sized> {
    Path(SingleWalk<'a, S, PathTracer>),
    Light(SingleWalk<'a, S, LightTracer>),
    Both(Pairs<'a, S>),
}

impl<'a, S: Scene + ?Sized> Chosen<'a, S> {
    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        scratch: &mut Scratch<'a, S>,
    ) {
        match self {
            Self::Path(run) => run.draw(samples, sink, &mut (), scratch),
            Self::Light(run) => run.draw(samples, sink, &mut (), scratch),
            Self::Both(run) => run.draw(samples, sink, &mut (), scratch),
        }
    }
}

/// A rendering by what the pilot chose.
pub struct Adapted<'a, S: Scene + ?Sized> {
    run: Chosen<'a, S>,
    decision: Decision,
    counters: Counters,
}

impl<S: Scene + ?Sized> Integrator<S> for Adaptive {
    type Run<'a>
        = Adapted<'a, S>
    where
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = Some(on_world::adaptive);

    fn name(&self) -> &'static str {
        "adaptive"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<Adapted<'a, S>> {
        let all = Plan::new(stage, TechniqueSet::BIDIRECTIONAL, self.depth);
        let sets = candidates(&stage, all.techniques);
        let race = Race::new(*self, stage, crew, &sets);
        let (mut candidates, winner, counters) = race.run(PILOT * stage.samples as f64);
        let chosen = candidates[winner];
        // Those tried last are no plainer than the plain one.
        candidates.sort_by_key(|candidate| Some(&candidate.set) == sets.last());
        let decision = Decision { left_out: all.left_out, candidates, chosen };
        Ok(Adapted { run: self.run(stage, chosen.set), decision, counters })
    }
}

impl<'a, S: Scene + ?Sized> Run<'a, S> for Adapted<'a, S> {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        self.decision.chosen.set
    }

    fn notes(&self) -> Notes {
        let decision = self.decision.clone();
        let chosen = match &self.run {
            Chosen::Path(run) => run.notes(),
            Chosen::Light(run) => run.notes(),
            Chosen::Both(run) => run.notes(),
        };
        Notes { left_out: decision.left_out, decision: Some(decision), ..chosen }
    }

    /// The pilot's energy is none of the image's.
    fn take_preparation(&mut self) -> Counters {
        let counters = std::mem::take(&mut self.counters);
        Counters { truncated_subpaths: 0, ledger: Ledger::default(), ..counters }
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        self.run.draw(samples, sink, scratch);
    }
}
