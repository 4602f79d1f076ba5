//! Path guiding as a view of a scene: where a camera walk goes on is drawn from the scene's BSDF or
//! from a distribution learnt from earlier walks (Müller, Gross and Novák 2017).
//!
//! | item | contents |
//! |---|---|
//! | [`Guided`] | the view; its BSDFs mix the two densities for camera walks |
//! | [`Field`] | the distributions: a binary tree of the space, with one of directions in each leaf |
//! | [`Quadtree`] | a distribution of directions |
//!
//! ```text
//! p⊥(next) = α p⊥_bsdf(next) + (1 - α) g(ω) / |cos θ|
//! ```
//!
//! A view is a scene like others, and a density is the same whoever asks for it. So the weights of
//! all techniques hold, and the image has the same mean, whatever the field is.
//! [`Guiding`](crate::integrator::Guiding) learns a field and renders in it.

mod field;
mod guided;
mod quadtree;
#[cfg(test)]
mod tests;

pub use field::{Field, Record};
pub use guided::{Guided, GuidedBsdf};
pub use quadtree::Quadtree;
