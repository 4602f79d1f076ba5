//! Recording the numbers of a sample and playing them back, to reproduce one path.

use super::{Sampler, Stream};
use glam::DVec2;

/// Passes on the numbers of another sampler and remembers them.
#[derive(Clone, Debug)]
pub struct Recorder<P> {
    inner: P,
    numbers: Vec<f64>,
}

impl<P: Sampler> Recorder<P> {
    /// Records what `inner` gives.
    #[must_use]
    pub fn new(inner: P) -> Self {
        Self { inner, numbers: Vec::new() }
    }

    /// The numbers given so far, points as two numbers.
    #[must_use]
    pub fn numbers(&self) -> &[f64] {
        &self.numbers
    }

    /// A sampler that gives the same numbers again.
    #[must_use]
    pub fn into_replay(self) -> Replay {
        Replay::new(self.numbers)
    }
}

impl<P: Sampler> Sampler for Recorder<P> {
    fn next_1d(&mut self) -> f64 {
        let u = self.inner.next_1d();
        self.numbers.push(u);
        u
    }

    fn next_2d(&mut self) -> DVec2 {
        let u = self.inner.next_2d();
        self.numbers.extend([u.x, u.y]);
        u
    }

    fn stream(&mut self, stream: Stream) {
        self.inner.stream(stream);
    }
}

/// Gives prescribed numbers in turn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replay {
    numbers: Vec<f64>,
    position: usize,
}

impl Replay {
    /// Plays back the given numbers. Whatever is not in `[0, 1)` is moved to its nearest end, as
    /// samplers promise that range.
    #[must_use]
    pub fn new(mut numbers: Vec<f64>) -> Self {
        for u in &mut numbers {
            // What is not a number becomes 0; `clamp` would keep it.
            *u = if *u > 0.0 { u.min(super::hash::ONE_MINUS_ULP) } else { 0.0 };
        }
        Self { numbers, position: 0 }
    }

    /// Starts again with the first number.
    pub fn rewind(&mut self) {
        self.position = 0;
    }

    /// True if more numbers were asked for than there are; those were 0.
    #[must_use]
    pub fn overran(&self) -> bool {
        self.position > self.numbers.len()
    }
}

impl Sampler for Replay {
    fn next_1d(&mut self) -> f64 {
        let u = self.numbers.get(self.position).copied().unwrap_or(0.0);
        self.position = self.position.saturating_add(1);
        u
    }
}
