//! Memory that integrators reuse from sample to sample.

use super::Counters;
use crate::scene::Scene;
use std::marker::PhantomData;

/// Buffers and counters of one thread; reused, so that nothing is allocated per sample once they have grown.
#[derive(Debug)]
pub struct Scratch<'s, S: Scene + ?Sized> {
    /// What was done so far.
    pub counters: Counters,
    scene: PhantomData<&'s S>,
}

impl<S: Scene + ?Sized> Default for Scratch<'_, S> {
    fn default() -> Self {
        Self { counters: Counters::default(), scene: PhantomData }
    }
}
