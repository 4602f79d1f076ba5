//! Numbers that a Markov chain moves: the primary sample space of Metropolis sampling (Kelemen,
//! Szirmay-Kalos, Antal and Csonka 2002).

use super::dimension::Dimension;
use super::hash::{ONE_MINUS_ULP, combine, nth, unit_interval};
use super::{Sampler, Stream};
use glam::DVec2;
use std::f64::consts::TAU;

/// The numbers of a Markov chain's state, and of the one that is proposed next.
///
/// A number is known by its dimension, stream and count, so that it keeps its meaning when a path
/// gets longer or shorter. Those that a path does not take cost nothing: they catch up with the
/// steps that they missed when they are needed, by one normal displacement of the same variance.
/// All of them follow from the keys of the steps.
#[derive(Clone, Debug, Default)]
pub struct ChainSampler {
    /// The key of the first state.
    seed: u64,
    /// The key of the last step that drew all numbers anew, and its count.
    base: (u64, u32),
    before: (u64, u32),
    /// The key of the proposal, and its count among the steps that were accepted.
    key: u64,
    step: u32,
    /// Standard deviation of a small step.
    size: f64,
    coordinates: Vec<Coordinate>,
    /// The coordinates that the state before had, and those of them that the proposal has changed.
    known: usize,
    changed: Vec<(usize, Coordinate)>,
    cursor: usize,
    dimension: Dimension,
    is_fixed: bool,
}

/// A number, and the step that it was moved by last.
#[derive(Clone, Copy, Debug)]
struct Coordinate {
    id: u64,
    value: f64,
    step: u32,
}

impl ChainSampler {
    /// The chain whose first state has the independent uniform numbers of a key. Small steps move
    /// each number by a normal displacement of this standard deviation, around the ends of `[0, 1)`.
    #[must_use]
    pub fn new(key: u64, size: f64) -> Self {
        Self { seed: key, base: (key, 0), before: (key, 0), key, size, ..Self::default() }
    }

    /// Proposes the next state: independent numbers (a large step), or those of the state moved a
    /// little. What is drawn from here on are its numbers.
    pub fn propose(&mut self, key: u64, is_large: bool) {
        self.rewind();
        self.step += 1;
        self.key = key;
        self.before = self.base;
        if is_large {
            self.base = (key, self.step);
        }
        self.known = self.coordinates.len();
        self.changed.clear();
    }

    /// Makes the proposal the state.
    pub fn accept(&mut self) {
        let Self { base: (_, large), step, .. } = *self;
        if large == step {
            // All others are drawn anew, too, once they are needed.
            self.coordinates.retain(|coordinate| coordinate.step == step);
        }
    }

    /// Returns to the state before the proposal.
    pub fn reject(&mut self) {
        self.step -= 1;
        self.base = self.before;
        self.coordinates.truncate(self.known);
        for (place, before) in self.changed.drain(..) {
            self.coordinates[place] = before;
        }
    }

    /// Begins again with the first number of the state or proposal.
    pub fn rewind(&mut self) {
        (self.dimension, self.cursor, self.is_fixed) = (Dimension::default(), 0, false);
    }

    fn number(&mut self, n: u32) -> f64 {
        let id = self.dimension.id(n);
        if self.is_fixed {
            return unit_interval(combine(self.seed, id));
        }
        let (key, step, (base, large)) = (self.key, self.step, self.base);
        let place = self.place(id);
        let coordinate = &mut self.coordinates[place];
        if coordinate.step == step {
            return coordinate.value;
        }
        if place < self.known {
            self.changed.push((place, *coordinate));
        }
        if coordinate.step < large {
            (coordinate.value, coordinate.step) = (fresh(base, id), large);
        }
        if coordinate.step < step {
            let missed = f64::from(step - coordinate.step);
            let moved = coordinate.value + self.size * missed.sqrt() * normal(combine(key, id));
            coordinate.value = (moved - moved.floor()).min(ONE_MINUS_ULP);
            coordinate.step = step;
        }
        coordinate.value
    }

    /// The place of a coordinate: most paths ask for the same ones in the same order.
    fn place(&mut self, id: u64) -> usize {
        let is_this = |coordinate: &Coordinate| coordinate.id == id;
        let is_next = self.coordinates.get(self.cursor).is_some_and(is_this);
        let found =
            if is_next { Some(self.cursor) } else { self.coordinates.iter().position(is_this) };
        let place = found.unwrap_or_else(|| {
            let (base, step) = self.base;
            self.coordinates.push(Coordinate { id, value: fresh(base, id), step });
            self.coordinates.len() - 1
        });
        self.cursor = place + 1;
        place
    }
}

/// The number of a dimension in the state that a large step with this key draws.
fn fresh(key: u64, id: u64) -> f64 {
    unit_interval(combine(key, id))
}

/// A standard normal number (Box and Muller 1958).
fn normal(hash: u64) -> f64 {
    let (u1, u2) = (unit_interval(nth(hash, 0)), unit_interval(nth(hash, 1)));
    (-2.0 * (1.0 - u1).ln()).sqrt() * (TAU * u2).cos()
}

impl Sampler for ChainSampler {
    fn next_1d(&mut self) -> f64 {
        let n = self.dimension.number();
        self.number(n)
    }

    fn next_2d(&mut self) -> DVec2 {
        let n = self.dimension.point();
        DVec2::new(self.number(n), self.number(n + 1))
    }

    fn skip_1d(&mut self) {
        self.dimension.number();
    }

    fn skip_2d(&mut self) {
        self.dimension.point();
    }

    fn stream(&mut self, stream: Stream) {
        self.is_fixed = stream == Stream::PathLength;
        self.dimension.announce(stream);
    }
}
