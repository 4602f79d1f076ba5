//! Which ways of drawing paths an integrator runs.

/// The set of techniques that an integrator runs on a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TechniqueSet;
