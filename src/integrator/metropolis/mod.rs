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
mod settings;

pub use candidates::Normalization;
pub use chain::ChunkChains;
pub use settings::Metropolis;

use super::{BoxedRun, Crew, IntegratorError, Notes, Run, Stage};
use crate::film::{Contribution, FilmSample, Sample, Sink};
use crate::path::{Counters, Scratch, TechniqueSet};
use crate::sampler::{AnySampler, ChainSampler, IndependentSampler, Sampler};
use crate::scene::Scene;
use candidates::Candidates;
use chain::Chain;
use settings::refused;

/// A rendering by Markov chains.
pub struct Chains<'a, S: Scene + ?Sized> {
    stage: Stage<'a, S>,
    run: BoxedRun<'a, S, AnySampler>,
    settings: Metropolis<()>,
    candidates: Candidates,
    set: u32,
    normalization: Normalization,
    counters: Counters,
}

/// Chains of a chunk, which take turns: so many that their samples can be drawn together.
const CHAINS: usize = 32;

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
        if chunk.set != self.set {
            *chunk = ChunkChains { set: self.set, ..ChunkChains::default() };
        }
        let mut first = 0;
        while first < samples.len() && self.candidates.mean() > 0.0 {
            let place = chunk.drawn % CHAINS;
            let group = &mut samples[first..];
            let count = (CHAINS - place).min(group.len());
            let group = &mut group[..count];
            let known = chunk.chains.len().saturating_sub(place).min(count);
            let new = (place + known..).zip(&group[known..]);
            let keys =
                new.map(|(place, sample)| self.candidates.choose(self.number(place, sample)));
            chunk.chains.extend(self.begin(keys, scratch));
            let chains = &mut chunk.chains[place..place + count];
            self.mutate(chains, group, scratch, |i, found| sink.add(first + i, found));
            chunk.drawn += count;
            first += count;
        }
        scratch.counters.samples = drawn + samples.len() as u64;
        scratch.counters.ledger = ledger;
    }

    /// Draws a sample of the integrator inside, which no chain moves.
    fn sample<P: Sampler>(
        &self,
        film: FilmSample,
        mut sampler: P,
        sink: &mut dyn Sink,
        scratch: &mut Scratch<'a, S>,
    ) {
        let key = IndependentSampler::seeded_by(&mut sampler).next_u64();
        let sampler = AnySampler::Chain(Box::new(ChainSampler::new(key)));
        self.run.sample(Sample { film, sampler }, sink, scratch);
    }
}

impl<'a, S: Scene + ?Sized> Chains<'a, S> {
    /// A number that the chain at this place of a chunk alone has, which begins at this sample.
    fn number<P>(&self, place: usize, sample: &Sample<P>) -> f64 {
        let pixel = self.stage.film.pixel_index(sample.film.raster).unwrap_or_default();
        f64::from(pixel) + place as f64 * f64::from(self.stage.film.pixels())
    }

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
            let step = self.settings.step(random.next_1d(), random.next_1d());
            chain.propose(random.next_u64(), step);
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
        let mut chains: Vec<_> = keys.map(Chain::new).collect();
        self.evaluate(&mut chains, scratch);
        chains.iter_mut().for_each(Chain::accept);
        chains
    }
}
