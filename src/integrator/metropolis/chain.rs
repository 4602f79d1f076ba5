//! A Markov chain, its state and the one that it proposes.

use crate::film::Contribution;
use crate::math::Rgb;
use crate::sampler::{ChainSampler, Step};

/// The chains of a chunk of the window.
#[derive(Debug, Default)]
pub struct ChunkChains {
    /// The set of chains that they belong to.
    pub(super) set: u32,
    pub(super) chains: Vec<Chain>,
    /// Number of samples that they have drawn, in turns.
    pub(super) drawn: usize,
}

/// A chain.
#[derive(Debug, Default)]
pub(super) struct Chain {
    /// The numbers of the proposal.
    pub numbers: Box<ChainSampler>,
    pub proposal: Evaluated,
    state: Evaluated,
}

/// The contributions of a sample, F, and I, their mean over the channels.
#[derive(Debug, Default)]
pub(super) struct Evaluated {
    contributions: Vec<Contribution>,
    importance: f64,
}

impl Chain {
    /// A chain whose first proposal has the numbers of a key.
    pub fn new(key: u64) -> Self {
        Self { numbers: Box::new(ChainSampler::new(key)), ..Self::default() }
    }

    /// Begins a proposal.
    pub fn propose(&mut self, key: u64, step: Step) {
        self.numbers.propose(key, step);
        self.proposal.clear();
    }

    // ANCHOR: acceptance
    /// The probability a of accepting the proposal.
    pub fn acceptance(&self) -> f64 {
        let [from, to] = [self.state.importance, self.proposal.importance];
        if to < from { to / from } else { 1.0 }
    }

    /// Shows a share `total` of the image to `add`: a to the proposal, the rest to the state.
    pub fn give(&self, total: f64, mut add: impl FnMut(&Contribution)) {
        let a = self.acceptance();
        self.proposal.give(total * a, &mut add);
        self.state.give(total * (1.0 - a), &mut add);
    }
    // ANCHOR_END: acceptance

    pub fn accept(&mut self) {
        self.numbers.accept();
        std::mem::swap(&mut self.state, &mut self.proposal);
    }

    pub fn reject(&mut self) {
        self.numbers.reject();
    }

    /// I of the state.
    pub fn importance(&self) -> f64 {
        self.state.importance
    }
}

impl Evaluated {
    fn clear(&mut self) {
        self.contributions.clear();
        self.importance = 0.0;
    }

    pub fn add(&mut self, found: &Contribution) {
        let Rgb(value) = found.value * found.weight;
        self.importance += value.iter().map(|channel| channel.abs()).sum::<f64>() / 3.0;
        self.contributions.push(*found);
    }

    /// Returns true, and leaves nothing, if I is infinite or not a number: no chain may stay there.
    pub fn is_refused(&mut self) -> bool {
        let is_refused = !self.importance.is_finite();
        if is_refused {
            self.clear();
        }
        is_refused
    }

    /// Shows F/I times a share of the image.
    fn give(&self, share: f64, add: &mut impl FnMut(&Contribution)) {
        if share > 0.0 && self.importance > 0.0 {
            for found in &self.contributions {
                add(&Contribution { value: found.value / self.importance * share, ..*found });
            }
        }
    }
}
