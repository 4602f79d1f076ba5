//! Memory that integrators reuse from sample to sample.

use super::batch::Rooms;
use super::columns::Columns;
use super::pairs::Pairs;
use super::shadow_rays::Connections;
use super::steps::Drawn;
use super::{Counters, RandomWalk, Subpaths};
use crate::lanes::level;
use crate::scene::Scene;
use fearless_simd::Level;
use std::fmt;

/// Buffers and counters of one thread; reused, so that nothing is allocated per sample once they
/// have grown.
pub struct Scratch<'s, S: Scene + ?Sized + 's> {
    /// The counters of everything done so far.
    pub counters: Counters,
    /// The subpaths of the samples of a batch, by the samples' numbers.
    pub subpaths: Vec<Subpaths<'s, S>>,
    pub(super) walks: Vec<Advancing<'s, S>>,
    /// True of walks that go on no further.
    pub(super) has_ended: Vec<bool>,
    pub(super) drawn: Vec<Drawn>,
    pub(super) rooms: Rooms<'s>,
    pub(super) columns: Columns<'s>,
    pub(super) pairs: Pairs,
    pub(super) level: Level,
    pub(super) connections: Connections,
}

// Written by hand: derives would ask for bounds on `S`.
impl<'s, S: Scene + ?Sized + 's> Default for Scratch<'s, S> {
    fn default() -> Self {
        Self {
            counters: Counters::default(),
            subpaths: Vec::new(),
            walks: Vec::new(),
            has_ended: Vec::new(),
            drawn: Vec::new(),
            rooms: Rooms::default(),
            columns: Columns::default(),
            pairs: Pairs::default(),
            level: level(),
            connections: Connections::default(),
        }
    }
}

impl<'s, S: Scene + ?Sized + 's> Scratch<'s, S> {
    /// Makes room for the subpaths of so many samples.
    pub(super) fn make_room(&mut self, samples: usize) {
        self.subpaths.resize_with(self.subpaths.len().max(samples), Subpaths::default);
    }
}

impl<'s, S: Scene + ?Sized + 's> fmt::Debug for Scratch<'s, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scratch")
            .field("counters", &self.counters)
            .field("samples", &self.subpaths.len())
            .finish_non_exhaustive()
    }
}

/// A walk that advances.
pub(super) struct Advancing<'s, S: Scene + ?Sized + 's> {
    pub sample: usize,
    pub walk: RandomWalk<'s, S>,
    /// Index of the vertex that comes next in the subpath.
    pub next: u32,
}
