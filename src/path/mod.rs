//! The core: vertices, the one random walk, paths, techniques and their weights.
//!
//! A pixel is an integral over paths `x_0 … x_k` from the lens to a light, `∫ We · T · Le dμ`, with
//! the throughput `T = Π f Π G`. A technique (s, t) draws s of the k + 1 vertices from the light
//! and t from the camera. Everything an integrator does is made of these bricks:
//!
//! | what | where |
//! |---|---|
//! | geometry term G | [`Edge`] |
//! | vertices, and the walk that finds them | [`Vertex`], [`RandomWalk`] |
//! | joining a camera part and a light part | [`Path`], [`sample_emitter`], [`sample_lens`] |
//! | densities of all techniques, and weights | [`PathDensities`], [`Heuristic`], [`TechniqueSet`] |
//! | what a scene does not need | [`LeftOut`], [`Reason`] |
//! | Russian roulette | [`Roulette`] |
//! | the definitions, evaluated without anything cached | [`PathRecord`] |

mod connect;
mod counters;
mod depth;
mod draw;
mod edge;
mod light_subpaths;
mod mis;
mod path_record;
pub mod roulette;
mod scratch;
mod stage;
mod steps;
mod technique;
mod vertex;
mod view;
mod walk;

pub use connect::{
    LensConnection, NextEvent, SampledEndpoint, sample_emitter, sample_lens,
    sample_lens_connection, sample_next_event,
};
pub use counters::{Counters, Ledger};
pub use depth::Depth;
pub use edge::Edge;
pub use light_subpaths::LightSubpaths;
pub use mis::{Ends, Heuristic, PathDensities, Weighting};
pub use path_record::{PathRecord, Verification};
pub use roulette::{Roulette, Scattered, Survival, Termination};
pub use scratch::Scratch;
pub use stage::{Plan, Stage};
pub use steps::{End, Out, Site, Steps, Subpaths, Visit, advance, join};
pub use technique::{Excluded, Family, LeftOut, Reason, TechniqueSet};
pub use vertex::{StartDensity, Vertex};
pub use view::Path;
pub use walk::{MAX_BOUNCES, RandomWalk};
