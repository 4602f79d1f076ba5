//! Mathematics that knows nothing of rendering: typed densities, colour, warps, distributions,
//! statistics.

pub(crate) mod angle;
pub mod distribution;
pub mod measure;
pub mod spectrum;
pub mod statistics;
pub mod student;
pub mod warp;

pub use measure::{PerArea, PerProjected, PerSolidAngle};
pub use spectrum::Rgb;
