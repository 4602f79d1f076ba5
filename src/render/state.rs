//! The sums of a rendering between two passes: all that the next pass goes on from.

use super::target::Watch;
use crate::film::{ChunkFilm, Film, Image};
use crate::math::{ExactSums, Rgb};
use crate::path::{Counters, Ledger};
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

/// The sums over some passes, which do not depend on who drew them or in what order.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// The passes in the sums.
    pub passes: Range<u32>,
    pub film: Arc<Film>,
    pub counters: CounterSums,
    /// Counts of what was done before the first pass: the same for all passes.
    pub prepared: Counters,
    pub watch: Option<Watch>,
    pub times: Times,
}

/// Times that a rendering took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Times {
    /// On the wall.
    pub wall: Duration,
    /// The part of it before the first pass.
    pub preparation: Duration,
    /// Spent by all threads together.
    pub threads: Duration,
}

impl State {
    /// The state before a pass, of those of which nothing is drawn yet.
    pub fn before(pass: u32, film: Film) -> Self {
        Self {
            passes: pass..pass,
            film: Arc::new(film),
            counters: CounterSums::default(),
            prepared: Counters::default(),
            watch: None,
            times: Times::default(),
        }
    }

    /// Adds what a chunk recorded.
    pub fn add(&mut self, film: &ChunkFilm, counters: &Counters, time: Duration) {
        Arc::make_mut(&mut self.film).add(film);
        self.counters.add(counters);
        self.times.threads += time;
    }

    /// Adds the sums over other passes of the same rendering, but not their range.
    pub fn merge(&mut self, other: &Self) {
        Arc::make_mut(&mut self.film).merge(&other.film);
        self.counters.merge(&other.counters);
        self.times.wall += other.times.wall;
        self.times.preparation += other.times.preparation;
        self.times.threads += other.times.threads;
    }

    /// Counts of everything that was done.
    pub fn counters(&self) -> Counters {
        let mut counters = self.counters.total();
        counters += self.prepared;
        counters
    }

    /// The number of passes in the sums: samples per pixel.
    pub fn samples_per_pixel(&self) -> u32 {
        self.passes.end - self.passes.start
    }

    /// The mean of the passes.
    pub fn image(&self) -> Image {
        self.film.image(samples(&self.film, self.samples_per_pixel()))
    }
}

/// Samples over the whole window of a film after a number of passes.
pub(super) fn samples(film: &Film, passes: u32) -> u64 {
    u64::from(film.region().pixels()) * u64::from(passes)
}

/// Sums of counters, exact in the ledger too.
#[derive(Clone, Debug)]
pub(crate) struct CounterSums {
    /// All but the ledger, which is empty.
    pub counts: Counters,
    pub ledger: ExactSums,
}

impl Default for CounterSums {
    fn default() -> Self {
        Self { counts: Counters::default(), ledger: [[0.0; 2]; 18].into_iter().collect() }
    }
}

impl CounterSums {
    pub fn add(&mut self, counters: &Counters) {
        self.counts += Counters { ledger: Ledger::default(), ..*counters };
        let entries = counters.ledger.to_array().into_iter().flat_map(|entry| entry.0);
        entries.enumerate().for_each(|(index, entry)| self.ledger.add(index, entry));
    }

    fn merge(&mut self, other: &Self) {
        self.counts += other.counts;
        self.ledger.merge(&other.ledger);
    }

    pub fn total(&self) -> Counters {
        let entry =
            |entry: usize| Rgb([0, 1, 2].map(|channel| self.ledger.get(3 * entry + channel)));
        Counters { ledger: Ledger::from_array([0, 1, 2, 3, 4, 5].map(entry)), ..self.counts }
    }
}
