//! The vertices that the walks of a sample have found.

use super::Vertex;
use super::pairs::END;
use crate::bsdf::TransportMode;
use crate::lanes::Rows;
use crate::scene::Scene;
use std::fmt;

/// The subpaths of a sample.
pub struct Subpaths<'s, S: Scene + ?Sized + 's> {
    /// Vertices of the camera subpath, in the order of the walk.
    pub camera: Vec<Vertex<S::Bsdf<'s>>>,
    /// Vertices of the light subpath under way, in the order of the walk.
    pub light: Vec<Vertex<S::Bsdf<'s>>>,
    /// Number of light subpaths that the sample draws one after the other, if it draws several.
    pub light_subpaths: u32,
    /// The vertices of the complete camera subpath from its first surface on, as ends of
    /// connections in lanes.
    pub(super) camera_ends: Rows<END>,
}

impl<'s, S: Scene + ?Sized + 's> Subpaths<'s, S> {
    /// The subpath of walks of a kind.
    #[inline]
    pub fn of(&mut self, mode: TransportMode) -> &mut Vec<Vertex<S::Bsdf<'s>>> {
        match mode {
            TransportMode::Radiance => &mut self.camera,
            TransportMode::Importance => &mut self.light,
        }
    }
}

// Written by hand: derives would ask for bounds on `S`.
impl<'s, S: Scene + ?Sized + 's> Default for Subpaths<'s, S> {
    fn default() -> Self {
        Self {
            camera: Vec::new(),
            light: Vec::new(),
            light_subpaths: 0,
            camera_ends: Rows::default(),
        }
    }
}

impl<'s, S: Scene + ?Sized + 's> fmt::Debug for Subpaths<'s, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Subpaths")
            .field("camera", &self.camera.len())
            .field("light", &self.light.len())
            .field("light_subpaths", &self.light_subpaths)
            .finish()
    }
}
