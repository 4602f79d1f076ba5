//! Numbers that a Markov chain moves: the primary sample space of Metropolis sampling (Kelemen,
//! Szirmay-Kalos, Antal and Csonka 2002).

use super::dimension::Dimension;
use super::hash::{ONE_MINUS_ULP, combine, unit_interval};
use super::{Sampler, Stream};
use glam::DVec2;

/// The numbers of a Markov chain's state, and of the one that it proposes next.
///
/// A number is known by its dimension, stream and count, so that it keeps its meaning when a path
/// gets longer or shorter. Those that a path does not take cost nothing: when they are needed they
/// catch up with the steps that they missed, by one displacement of the same variance. All of them
/// follow from the keys of the steps.
#[derive(Clone, Debug, Default)]
pub struct ChainSampler {
    clock: Clock,
    before: Clock,
    /// The key of the first state, and of the proposal.
    seed: u64,
    key: u64,
    coordinates: Vec<Coordinate>,
    /// Number of coordinates before the proposal, and those of them that it has changed.
    known: usize,
    changed: Vec<(usize, Coordinate)>,
    cursor: usize,
    dimension: Dimension,
    is_fixed: bool,
}

/// A step of a Markov chain from the numbers of a state to those that it proposes. Each is as likely
/// as its reverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// All numbers anew.
    Large,
    /// A displacement of each number with this standard deviation, around the ends of `[0, 1)`.
    Small(f64),
}

/// The steps that numbers take part in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Clock {
    /// The count of large steps, and the key of the last one.
    epoch: u32,
    key: u64,
    /// The variance of all displacements since.
    moved: f64,
}

#[derive(Clone, Copy, Debug)]
struct Coordinate {
    id: u64,
    value: f64,
    epoch: u32,
    moved: f64,
}

impl ChainSampler {
    /// The chain whose first state has the independent uniform numbers of a key.
    #[must_use]
    pub fn new(key: u64) -> Self {
        let clock = Clock { epoch: 1, key, moved: 0.0 };
        Self { clock, before: clock, seed: key, key, ..Self::default() }
    }

    /// Proposes the next state: what is drawn from here on are its numbers.
    pub fn propose(&mut self, key: u64, step: Step) {
        (self.dimension, self.cursor, self.is_fixed) = (Dimension::default(), 0, false);
        self.known = self.coordinates.len();
        self.changed.clear();
        (self.key, self.before) = (key, self.clock);
        let Clock { epoch, moved, .. } = &mut self.clock;
        match step {
            Step::Large => self.clock = Clock { epoch: *epoch + 1, key, moved: 0.0 },
            Step::Small(deviation) => *moved += deviation * deviation,
        }
    }

    /// Makes the proposal the state.
    pub fn accept(&mut self) {
        let epoch = self.clock.epoch;
        if epoch > self.before.epoch {
            // Of the others nothing is left to remember.
            self.coordinates.retain(|coordinate| coordinate.epoch == epoch);
        }
    }

    /// Returns to the state before the proposal.
    pub fn reject(&mut self) {
        self.clock = self.before;
        self.coordinates.truncate(self.known);
        for (place, before) in self.changed.drain(..) {
            self.coordinates[place] = before;
        }
    }

    fn number(&mut self, n: u32) -> f64 {
        let id = self.dimension.id(n);
        if self.is_fixed {
            return fresh(self.seed, id);
        }
        let Clock { epoch, key, moved } = self.clock;
        let place = self.place(id);
        let coordinate = &mut self.coordinates[place];
        let before = *coordinate;
        if before.epoch < epoch {
            *coordinate = Coordinate { id, value: fresh(key, id), epoch, moved: 0.0 };
        }
        if coordinate.moved < moved {
            let deviation = (moved - coordinate.moved).sqrt();
            let value = coordinate.value + deviation * displacement(combine(self.key, id));
            coordinate.value = (value - value.floor()).min(ONE_MINUS_ULP);
            coordinate.moved = moved;
        }
        let value = coordinate.value;
        if place < self.known && (before.epoch, before.moved) != (epoch, moved) {
            self.changed.push((place, before));
        }
        value
    }

    /// The place of a coordinate: most paths ask for the same ones in the same order.
    fn place(&mut self, id: u64) -> usize {
        let is_this = |coordinate: &Coordinate| coordinate.id == id;
        let is_next = self.coordinates.get(self.cursor).is_some_and(is_this);
        let found =
            if is_next { Some(self.cursor) } else { self.coordinates.iter().position(is_this) };
        let place = found.unwrap_or_else(|| {
            self.coordinates.push(Coordinate { id, value: 0.0, epoch: 0, moved: 0.0 });
            self.coordinates.len() - 1
        });
        self.cursor = place + 1;
        place
    }
}

/// The number of a dimension where a key draws all anew.
fn fresh(key: u64, id: u64) -> f64 {
    unit_interval(combine(key, id))
}

/// A displacement of variance 1, of triangular distribution: what counts is that its opposite is as
/// likely.
fn displacement(hash: u64) -> f64 {
    let halves = [hash >> 32, hash & 0xffff_ffff].map(|half| half as f64 / f64::from(u32::MAX));
    6f64.sqrt() * (halves[0] + halves[1] - 1.0)
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
