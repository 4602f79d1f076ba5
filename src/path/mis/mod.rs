//! Multiple importance sampling: the weight of a technique within a set, as a sweep over the
//! densities of all of them ([`PathDensities::weight`], the definition), and from partial sums that
//! the vertices of subpaths keep ([`Weighting`], the same in constant time).

mod partials;
mod sweep;

pub use partials::Weighting;
pub use sweep::{Ends, Heuristic, PathDensities};
