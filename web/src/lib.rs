//! The engine of the lecture room, a page on which integrators of light transport render side by
//! side: scenes, renderings, the pyramid of techniques and single paths, for workers of a browser.
//!
//! Requests and answers are JSON; pictures are linear radiance, three numbers per pixel, the top row
//! first. `cargo run --release --package pathspace-web` builds the page.

#[cfg(target_family = "wasm")]
mod bindings;
mod board;
mod catalogue;
mod lesson;
mod outline;
mod race;
mod techniques;

pub use board::{Board, BoardJob};
pub use catalogue::{Catalogue, catalogue};
pub use lesson::{Lesson, SceneJob, Summary};
pub use race::{Effort, Finished, RaceJob, Report};
pub use techniques::{Layer, LayerReport, TechniquesJob};

/// The reason for which something could not be done, in words for who sees the page.
pub type Fallible<T> = Result<T, String>;
