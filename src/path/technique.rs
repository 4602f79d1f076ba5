//! Which ways of drawing paths an integrator runs.

use crate::film::Technique;
use crate::scene::Needs;
use std::fmt;

/// The set of techniques that an integrator runs on a scene, each with one sample per sample of the image.
///
/// A path with k edges can be drawn by the techniques (s, t) with s + t = k + 1 and t ≥ 1: the lens is never hit by chance. A
/// set is a union of the four families that need different code, less what the scene rules out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct TechniqueSet {
    /// s = 0: a camera walk hits a light.
    pub emitter_hits: bool,
    /// s = 1, t ≥ 2: a vertex of a camera walk connects to a point sampled on a light (next event estimation).
    pub emitter_sampling: bool,
    /// s ≥ 2, t ≥ 2: a vertex of a camera walk connects to one of a light walk.
    pub connections: bool,
    /// t = 1, s ≥ 1: a vertex of a light walk connects to the lens.
    pub lens_sampling: bool,
    /// Every vertex after the first surface uniform by area, the last one on a light: the lecture's estimator, no (s, t) technique.
    pub uniform_area: bool,
    /// If given, this technique alone.
    pub only: Option<Technique>,
    /// If given, all but this technique.
    pub without: Option<Technique>,
}

impl TechniqueSet {
    /// No technique.
    pub const NONE: Self = Self {
        emitter_hits: false,
        emitter_sampling: false,
        connections: false,
        lens_sampling: false,
        uniform_area: false,
        only: None,
        without: None,
    };
    /// Every technique (s, t) with t ≥ 1.
    pub const BIDIRECTIONAL: Self =
        Self { emitter_hits: true, emitter_sampling: true, connections: true, lens_sampling: true, ..Self::NONE };

    /// Leaves out what a scene cannot use; exactly, since what is left out would contribute nothing.
    #[must_use]
    pub fn pruned(mut self, needs: &Needs) -> Self {
        self.emitter_hits &= needs.contains(Needs::HITTABLE_LIGHTS);
        self.uniform_area &= needs.contains(Needs::HITTABLE_LIGHTS);
        self.emitter_sampling &= needs.contains(Needs::CONNECTIBLE_LIGHTS.union(Needs::FINITE_LOBES));
        self.connections &= needs.contains(Needs::FINITE_LOBES);
        self.lens_sampling &= needs.contains(Needs::FINITE_LOBES) || needs.contains(Needs::HITTABLE_LIGHTS);
        self
    }

    /// Whether a technique is in the set.
    #[inline]
    #[must_use]
    pub fn contains(&self, technique: Technique) -> bool {
        let family = match (technique.s, technique.t) {
            (_, 0) => false,
            (0, _) => self.emitter_hits,
            (_, 1) => self.lens_sampling,
            (1, _) => self.emitter_sampling,
            _ => self.connections,
        };
        family && self.only.is_none_or(|only| only == technique) && self.without != Some(technique)
    }

    /// Whether walks from the light are needed.
    #[must_use]
    pub fn has_light_walk(&self) -> bool {
        self.connections || self.lens_sampling
    }

    /// Whether walks from the camera are needed.
    #[must_use]
    pub fn has_camera_walk(&self) -> bool {
        self.emitter_hits || self.emitter_sampling || self.connections || self.uniform_area
    }
}

impl fmt::Display for TechniqueSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let families = [
            (self.uniform_area, "vertices uniform by area"),
            (self.emitter_hits, "s = 0 (hit a light)"),
            (self.emitter_sampling, "s = 1 (emitter sampling)"),
            (self.connections, "s ≥ 2, t ≥ 2 (connections)"),
            (self.lens_sampling, "t = 1 (lens sampling)"),
        ];
        let names: Vec<&str> = families.iter().filter(|(on, _)| *on).map(|(_, name)| *name).collect();
        if names.is_empty() {
            return f.write_str("none");
        }
        f.write_str(&names.join(", "))?;
        if let Some(Technique { s, t }) = self.only {
            write!(f, ", only ({s}, {t})")?;
        }
        if let Some(Technique { s, t }) = self.without {
            write!(f, ", without ({s}, {t})")?;
        }
        Ok(())
    }
}
