//! Many queries at once: sixteen rays are tested against one facet after the other. In a scene of
//! few facets that takes no tree.
//!
//! Rays of a camera, which visit mostly the same, walk through the tree sixteen at a time in larger
//! scenes on a processor with vectors of eight numbers or more: each node's boxes are tested one after
//! the other, and what any ray enters is visited. Each ray passes what it would pass alone, by the
//! same numbers.
//!
//! Nothing is missed that the exact test hits, hits are held back as in the walk through the tree,
//! and the exact tests are the same, eight at a time or alone. So the answers are, too.

mod ball;
mod eight;
mod few;
mod plane;
mod rays;
#[cfg(test)]
mod tests;
mod together;

pub(super) use eight::Corners;
pub(super) use few::{Few, are_free, are_free_in_columns, closest, closest_in_columns};
pub(super) use together::closest_together;

/// Rays of a packet.
pub(super) const RAYS: usize = 16;
