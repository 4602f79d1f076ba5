//! Light transport as one integral over paths, and four interchangeable ways to sample it.

pub mod bsdf;
pub mod endpoint;
pub mod film;
pub mod geometry;
pub mod integrator;
pub mod math;
pub mod path;
pub mod render;
pub mod sampler;
pub mod scene;

pub use glam;
