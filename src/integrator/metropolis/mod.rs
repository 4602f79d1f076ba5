//! Metropolis sampling in primary sample space: Markov chains that move the random numbers of
//! another integrator's samples, and stay where those contribute much (Kelemen et al. 2002).
//!
//! With the numbers u of a sample, its contributions F(u) and I(u), their mean over the channels, a
//! chain that is at u proposes v, and M mutations give
//!
//! ```text
//! image = b/M Σ [ a F(v)/I(v) + (1 - a) F(u)/I(u) ],    a = min(1, I(v)/I(u)),    b = ∫ I
//! ```
//!
//! The constant b is estimated by the mean of I over independent candidates, and chains begin at
//! some of the same, chosen in proportion to I. So E[b h(start)] = ∫ I h for any h, which mutations
//! preserve: chains of any length are unbiased, as with a more exact b they would not be (Veach
//! 1997, section 11.3.1). After some passes new chains begin at new candidates, so that errors of b
//! average out.
#![allow(missing_debug_implementations, reason = "a view of a rendering under way")]

mod candidates;
mod chain;

pub use candidates::Normalization;

use super::any_run::on_world;
use super::{
    AnyIntegrator, BoxedRun, Crew, Integrator, IntegratorError, Notes, Run, Stage, StartOnWorld,
    Started,
};
use crate::film::{Contribution, FilmSample, Sample, Sink};
use crate::path::{Counters, Ledger, Scratch, TechniqueSet};
use crate::sampler::{AnySampler, IndependentSampler, Sampler};
use crate::scene::{Scene, World};
use candidates::Candidates;
use chain::Chain;
use std::sync::{Mutex, PoisonError};

/// Metropolis sampling over an integrator whose samples depend on nothing but their numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metropolis<I> {
    /// The integrator whose samples are mutated.
    pub integrator: I,
    /// Number of candidates; `None` for one per pixel, at least 4096.
    pub candidates: Option<u32>,
    /// Passes after which chains begin anew.
    pub restart: u32,
    /// Probability of a large step, which draws all numbers anew.
    pub large_step: f64,
    /// Standard deviation of the displacement of a number in a small step.
    pub size: f64,
}

/// A rendering by Markov chains.
pub struct Chains<'a, S: Scene + ?Sized> {
    stage: Stage<'a, S>,
    run: BoxedRun<'a, S, AnySampler>,
    settings: Metropolis<()>,
    candidates: Candidates,
    /// The number of the set of candidates, and its factor over the first.
    set: (u32, u32),
    normalization: Normalization,
    counters: Counters,
}

/// The chains of a chunk of the window.
#[derive(Debug, Default)]
pub struct ChunkChains {
    set: u32,
    chains: Vec<Chain>,
    drawn: usize,
}

/// Chains of a chunk, which take turns: so many that their samples can be drawn together.
const CHAINS: usize = 32;

/// The largest factor by which sets of candidates grow while they are black.
const GROWTH: u32 = 1 << 10;

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for Chains<'a, S> {
    type Chunk = ChunkChains;

    fn techniques(&self) -> TechniqueSet {
        self.run.techniques()
    }

    fn notes(&self) -> Notes {
        let (normalization, dependent_passes) = (Some(self.normalization), self.settings.restart);
        Notes { is_correlated: true, normalization, dependent_passes, ..self.run.notes() }
    }

    fn learns(&self) -> bool {
        true
    }

    fn take_preparation(&mut self) -> Counters {
        std::mem::take(&mut self.counters)
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        if pass.is_multiple_of(self.settings.restart) {
            self.draw_candidates(pass / self.settings.restart, crew).map_err(refused)?;
        }
        Ok(())
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        chunk: &mut ChunkChains,
        scratch: &mut Scratch<'a, S>,
    ) {
        // A mutation is a sample of the image, whatever it takes.
        let (drawn, ledger) = (scratch.counters.samples, scratch.counters.ledger);
        if chunk.set != self.set.0 {
            *chunk = ChunkChains { set: self.set.0, ..ChunkChains::default() };
        }
        let mut first = 0;
        while first < samples.len() && self.candidates.mean() > 0.0 {
            let place = chunk.drawn % CHAINS;
            let group = &mut samples[first..];
            let count = (CHAINS - place).min(group.len());
            let group = &mut group[..count];
            let new = (place + count).saturating_sub(chunk.chains.len());
            let number = |sample: &Sample<P>| self.stage.film.pixel_index(sample.film.raster);
            let starts = group[count - new..].iter().map(|s| number(s).unwrap_or_default());
            let keys = starts.map(|start| self.candidates.choose(start));
            chunk.chains.extend(self.begin(keys, scratch));
            let chains = &mut chunk.chains[place..place + count];
            self.mutate(chains, group, scratch, |i, found| sink.add(first + i, found));
            chunk.drawn += count;
            first += count;
        }
        scratch.counters.samples = drawn + samples.len() as u64;
        scratch.counters.ledger = ledger;
    }
}

impl<'a, S: Scene + ?Sized> Chains<'a, S> {
    /// Moves each chain by the numbers of a sample, and adds what it gives.
    fn mutate<P: Sampler>(
        &self,
        chains: &mut [Chain],
        samples: &mut [Sample<P>],
        scratch: &mut Scratch<'a, S>,
        mut add: impl FnMut(usize, &Contribution),
    ) {
        let random = samples.iter_mut().map(|s| IndependentSampler::seeded_by(&mut s.sampler));
        let mut random: Vec<_> = random.collect();
        for (chain, random) in chains.iter_mut().zip(&mut random) {
            let is_large = random.next_1d() < self.settings.large_step;
            chain.propose(random.next_u64(), is_large);
        }
        self.evaluate(chains, scratch);
        for (i, (chain, random)) in chains.iter_mut().zip(&mut random).enumerate() {
            chain.give(self.candidates.mean(), |found| add(i, found));
            let is_accepted = random.next_1d() < chain.acceptance();
            if is_accepted { chain.accept() } else { chain.reject() }
        }
    }

    /// Draws the samples of proposals.
    fn evaluate(&self, chains: &mut [Chain], scratch: &mut Scratch<'a, S>) {
        let Stage { film: region, kernel, .. } = &self.stage;
        let sample = |chain: &mut Chain| {
            let mut sampler = AnySampler::Chain(std::mem::take(&mut chain.numbers));
            Sample { film: FilmSample::draw_anywhere(region, kernel, &mut sampler), sampler }
        };
        let mut samples: Vec<_> = chains.iter_mut().map(sample).collect();
        let mut add = |i: usize, found: &Contribution| chains[i].proposal.add(found);
        self.run.draw(&mut samples, &mut add, 0, scratch);
        for (chain, Sample { sampler, .. }) in chains.iter_mut().zip(samples) {
            if let AnySampler::Chain(numbers) = sampler {
                chain.numbers = numbers;
            }
            scratch.counters.non_finite += u64::from(chain.proposal.is_refused());
        }
    }

    /// The chains that begin at candidates of some keys.
    fn begin(&self, keys: impl Iterator<Item = u64>, scratch: &mut Scratch<'a, S>) -> Vec<Chain> {
        let mut chains: Vec<_> = keys.map(|key| Chain::new(key, self.settings.size)).collect();
        self.evaluate(&mut chains, scratch);
        chains.iter_mut().for_each(Chain::accept);
        chains
    }

    fn draw_candidates(&mut self, set: u32, crew: &dyn Crew) -> Result<(), String> {
        let (_, factor) = self.set;
        let number = self.settings.candidates.unwrap_or(self.stage.film.pixels().max(1 << 12));
        let counted = Mutex::new(Counters::default());
        let (candidates, found) = Candidates::draw(
            (self.stage.seed, set),
            number.saturating_mul(factor),
            crew,
            |keys| {
                let mut scratch = Scratch::default();
                let chains = self.begin(keys, &mut scratch);
                let mut counted = counted.lock().unwrap_or_else(PoisonError::into_inner);
                *counted += Counters { ledger: Ledger::default(), ..scratch.counters };
                chains.iter().map(Chain::importance).collect()
            },
        )?;
        self.counters += counted.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.normalization.add(&found);
        self.candidates = candidates;
        let is_black = found.black > 0;
        self.set = (set, if is_black { (4 * factor).min(GROWTH) } else { factor });
        Ok(())
    }
}

impl<I> Metropolis<I> {
    /// Metropolis sampling over an integrator: chains of 16 passes, with large steps of probability
    /// 0.3 and small ones of 0.01.
    pub const fn over(integrator: I) -> Self {
        Self { integrator, candidates: None, restart: 16, large_step: 0.3, size: 0.01 }
    }

    fn check(&self) -> Result<(), String> {
        let Self { candidates, restart, large_step, size, .. } = *self;
        let is_in = |value: f64| value > 0.0 && value <= 1.0;
        match () {
            () if candidates == Some(0) => Err("no candidates: at least 1 is needed".to_owned()),
            () if restart == 0 => Err("chains of 0 passes: at least 1 is needed".to_owned()),
            () if !is_in(large_step) => {
                Err(format!("probability {large_step} of large steps: it must be in (0, 1]"))
            }
            () if !is_in(size) => Err(format!("small steps of {size}: they must be in (0, 1]")),
            () => Ok(()),
        }
    }

    fn run<'a, S: Scene + ?Sized>(
        &self,
        stage: Stage<'a, S>,
        run: BoxedRun<'a, S, AnySampler>,
    ) -> Started<Chains<'a, S>> {
        self.check().map_err(refused)?;
        if run.prepares() {
            return Err(refused("passes that share what is made for each have no chains".into()));
        }
        let &Self { candidates, restart, large_step, size, .. } = self;
        let settings = Metropolis { integrator: (), candidates, restart, large_step, size };
        let (candidates, normalization) = (Candidates::default(), Normalization::default());
        let (set, counters) = ((0, 1), Counters::default());
        Ok(Chains { stage, run, settings, candidates, set, normalization, counters })
    }
}

impl<I: Default> Default for Metropolis<I> {
    fn default() -> Self {
        Self::over(I::default())
    }
}

const NAME: &str = "metropolis";

fn refused(reason: String) -> IntegratorError {
    IntegratorError { integrator: NAME, reason }
}

impl<S: Scene + ?Sized, I: Integrator<S>> Integrator<S> for Metropolis<I> {
    type Run<'a>
        = Chains<'a, S>
    where
        Self: 'a,
        S: 'a;

    const ON_WORLD: Option<StartOnWorld<Self>> = match I::ON_WORLD {
        Some(_) => Some(start_on_world::<S, I>),
        None => None,
    };

    fn name(&self) -> &'static str {
        NAME
    }

    fn chooses_lights(&self) -> bool {
        self.integrator.chooses_lights()
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<Chains<'a, S>> {
        self.run(stage, AnyIntegrator::start(&self.integrator, stage, crew)?)
    }
}

fn start_on_world<'a, S: Scene + ?Sized, I: Integrator<S>>(
    metropolis: &'a Metropolis<I>,
    stage: Stage<'a, World>,
    crew: &dyn Crew,
) -> Started<BoxedRun<'a, World, AnySampler>> {
    let start = const { I::ON_WORLD.expect("asked for where it is") };
    Ok(on_world::chains(metropolis.run(stage, start(&metropolis.integrator, stage, crew)?)?))
}
