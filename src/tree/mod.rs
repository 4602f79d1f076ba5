//! The ray kernel: a tree over numbered shapes that answers which of them a ray meets first and
//! whether anything lies on a segment.
//!
//! [`binary`] builds a tree over padded f32 boxes, [`Wide`](layout::Wide) makes nodes of eight
//! boxes and blocks of four triangles of it, and exact f64 tests decide what is hit.
//!
//! Boxes and blocks live in a [`Space`](space::Space) of their own, in which the scene lies in
//! [-1, 1]³. So neither the scene's scale nor its distance from the origin reaches the f32 numbers.
//! A ray from outside is first moved, in f64, to where it enters the cube around the scene; the
//! exact tests see that moved ray too, so that a far origin's rounding is the same for all
//! primitives and opens no gap between them. Since nothing that the exact test accepts is left out
//! ([`rounding`] has the proofs), the answer depends neither on the tree nor on the instruction
//! set.
//!
//! If the f32 numbers of a block tell the corners of a triangle exactly, the exact test takes
//! them from there, which saves fetching the shape. They do for most triangles whose positions are
//! f32 numbers: vertices stay such numbers in the space, and their differences are, too, unless an
//! edge is longer than its ends' distances from a plane through the space's origin, roughly.
//!
//! Top down: a [`forest`] has the trees of a scene, more than one if parts are tiny; [`many`]
//! answers many rays at once, by a [`packet`] or in [`flights`]; [`bvh`] answers one, [`traverse`]
//! walks through the tree, [`boxes`] and [`facets`] test what it meets and [`exact`] decides.

mod binary;
mod boxes;
mod build;
mod bvh;
mod collapse;
mod exact;
mod facets;
mod flights;
mod forest;
mod layout;
mod many;
mod packet;
mod query;
mod rounding;
mod space;
mod stack;
#[cfg(test)]
mod tests;
mod traverse;

pub(crate) use forest::Forest;
pub use forest::TreeStatistics;
pub(crate) use query::{Ends, Hit, LaneEnd, LaneSegment, Query, Segment};
