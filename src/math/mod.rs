//! Mathematics that knows nothing of rendering.
//!
//! | what | module |
//! |---|---|
//! | densities that carry their measure, `p_A = p_ω \|cos θ'\| / r² = p⊥ G` | [`measure`] |
//! | linear RGB | [`spectrum`] |
//! | maps from the unit square to disks, spheres, cones and triangles | [`warp`] |
//! | discrete and piecewise-constant distributions | [`distribution`] |
//! | sums that never round | [`ExactSums`] |
//! | numbers that tell things apart | [`Fingerprint`] |
//! | hypothesis tests and running moments | [`statistics`] |
//! | Student's t distribution | [`student`] |
//! | sines, cosines and angles, the same on every platform | `angle` |
//! | binomial coefficients of real numbers | `binomial` |
//! | unit vectors of directions of any length | `unit` |
//!
//! Source: Veach 1997, chapter 8, for the measures.

pub(crate) mod angle;
pub(crate) mod binomial;
pub mod distribution;
pub(crate) mod erf;
mod exact_sums;
mod fingerprint;
pub mod measure;
pub mod spectrum;
pub mod statistics;
pub mod student;
mod unit;
pub mod warp;

pub use exact_sums::ExactSums;
pub use fingerprint::Fingerprint;
pub use measure::{PerArea, PerProjected, PerSolidAngle};
pub use spectrum::Rgb;
pub(crate) use unit::{has_exact_length, unit};
