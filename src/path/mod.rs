//! The core: vertices, the one random walk, paths, techniques and their weights.

mod counters;
mod scratch;
mod technique;

pub use counters::{Counters, Ledger};
pub use scratch::Scratch;
pub use technique::TechniqueSet;
