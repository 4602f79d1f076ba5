//! Multiple importance sampling: the weight of a technique within a set.
//!
//! ```text
//! w_i = (n_i p_i)^β / Σ_j (n_j p_j)^β        β = 1: balance heuristic, β = 2: power heuristic
//! ```
//!
//! [`PathDensities::weight`] is the definition: a sweep over the densities of all techniques, in
//! time proportional to the length of the path. [`Weighting`] gets the same weight in constant time
//! from MIS partial sums that the vertices of subpaths keep.
//!
//! Sources: Veach and Guibas 1995; Veach 1997, sections 9.2 and 10.2.

mod partials;
mod sweep;

pub(super) use partials::Side;
pub use partials::{MergeSide, Weighting};
pub use sweep::{Ends, Heuristic, PathDensities};
