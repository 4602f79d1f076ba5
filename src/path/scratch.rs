//! Memory that integrators reuse from sample to sample.

use super::{Counters, Vertex, Walks, Wavefront};
use crate::scene::Scene;
use std::fmt;

/// Buffers and counters of one thread; reused, so that nothing is allocated per sample once they
/// have grown.
pub struct Scratch<'s, S: Scene + ?Sized + 's> {
    /// What was done so far.
    pub counters: Counters,
    /// Vertices of the camera walk, from the lens.
    pub camera: Vec<Vertex<S::Bsdf<'s>>>,
    /// Vertices of the light walk, from the light.
    pub light: Vec<Vertex<S::Bsdf<'s>>>,
    /// The same of the samples of a batch.
    pub(crate) walks: Vec<Walks<'s, S>>,
    pub(crate) wavefront: Wavefront<'s, S>,
}

// Written by hand: derives would ask for bounds on `S`.
impl<'s, S: Scene + ?Sized + 's> Default for Scratch<'s, S> {
    fn default() -> Self {
        Self {
            counters: Counters::default(),
            camera: Vec::new(),
            light: Vec::new(),
            walks: Vec::new(),
            wavefront: Wavefront::default(),
        }
    }
}

impl<'s, S: Scene + ?Sized + 's> fmt::Debug for Scratch<'s, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scratch")
            .field("counters", &self.counters)
            .field("camera_vertices", &self.camera.len())
            .field("light_vertices", &self.light.len())
            .finish_non_exhaustive()
    }
}
