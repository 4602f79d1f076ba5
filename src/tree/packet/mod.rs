//! Many queries at once on a processor with vectors of sixteen numbers: sixteen rays are tested
//! against one facet after the other. In a scene of few facets that takes no tree.
//!
//! Rays of a camera, which visit mostly the same, walk through the tree sixteen at a time in larger
//! scenes: each node's boxes are tested one after the other, and what any ray enters is visited.
//! Each ray passes what it would pass alone, by the same numbers.
//!
//! Tolerances, hits that are held back and exact tests are those of the walk through the tree, so
//! the answers are the same.

mod any;
mod closest;
mod rays;

pub(super) use any::are_free;
pub(super) use closest::{closest, closest_together};
pub(super) use rays::RAYS;
