//! The core: vertices, the one random walk, connections, paths, techniques and their weights.
//!
//! A pixel is an integral over paths `x_0 … x_k` from the lens to a light,
//!
//! ```text
//! I = ∫ We(x_0 → x_1) G(x_0, x_1) T(x_1 … x_k) Le(x_k → x_{k-1}) dμ(x̄),
//! T = Π_{i=1}^{k-1} f(x_{i+1} → x_i → x_{i-1}) G(x_i, x_{i+1}).
//! ```
//!
//! A technique (s, t) draws s of the k + 1 vertices as a light subpath and t as a camera subpath,
//! and connects the two; or it draws one vertex by both, and merges them. Its density `p_{s,t}` is a
//! product of densities per area, its contribution `w f/(n p)`. Everything an integrator does is made of these bricks:
//!
//! | what | item |
//! |---|---|
//! | geometry term `G = V \|cos θ cos θ'\| / r²` | [`Edge`] |
//! | vertices, and the random walk that finds them | [`Vertex`], [`RandomWalk`] |
//! | the loop over many walks, and its steps | [`advance`], [`Steps`] |
//! | next event estimation (s = 1) | [`NextEvent`] |
//! | connection of a light subpath to the lens (t = 1) | [`LensConnection`] |
//! | two subpaths joined to one path by an edge | [`Path`] |
//! | two subpaths whose ends are taken as one vertex | [`MergedPath`] |
//! | techniques of an integrator | [`TechniqueSet`] |
//! | densities of all techniques, and weights | [`PathDensities`], [`Heuristic`], [`Weighting`] |
//! | techniques that a scene rules out | [`LeftOut`], [`Reason`] |
//! | techniques that do not draw a path, and why | [`Obstacle`] |
//! | paths that a set of techniques cannot draw | [`MissingPaths`], [`PathClass`] |
//! | Russian roulette | [`Roulette`] |
//! | rays, vertices and flux, counted | [`Counters`], [`Ledger`] |
//! | the definitions, evaluated without anything cached | [`PathRecord`] |
//!
//! Sources: the integral is that of Veach 1997, section 8.2, which solves the rendering equation of
//! Kajiya 1986; bidirectional techniques are of Lafortune and Willems 1993 and of Veach 1997,
//! chapter 10.

mod batch;
mod columns;
mod connect;
mod counters;
mod depth;
mod diffuse;
mod draw;
mod edge;
mod left_out;
mod light_subpaths;
mod merged;
mod mis;
mod obstacle;
mod pairs;
mod path_class;
mod path_record;
pub mod roulette;
mod scratch;
mod shadow_rays;
mod stage;
mod steps;
mod subpaths;
mod technique;
mod vertex;
mod view;
mod walk;

pub use batch::{advance, join};
pub use columns::{Begin, DiffuseSteps};
pub use connect::{
    LensConnection, NextEvent, SampledEndpoint, sample_emitter, sample_lens, sample_lens_connection,
};
pub use counters::{Counters, Ledger};
pub use depth::Depth;
pub use draw::offer;
pub use edge::Edge;
pub use left_out::{Family, LeftOut, Reason};
pub use light_subpaths::LightSubpaths;
pub use merged::MergedPath;
pub use mis::{Ends, Heuristic, MergeSide, PathDensities, Weighting};
pub use obstacle::Obstacle;
pub use path_class::{DrawnBy, MissingPaths, PathClass};
pub use path_record::{PathRecord, Verification};
pub use roulette::{Roulette, Scattered, Survival, Termination};
pub use scratch::Scratch;
pub use shadow_rays::{End, Out};
pub use stage::{Plan, Stage};
pub use steps::{Site, Steps, Visit};
pub use subpaths::Subpaths;
pub use technique::{Excluded, TechniqueSet};
pub use vertex::{StartDensity, Vertex};
pub use view::Path;
pub use walk::{MAX_BOUNCES, RandomWalk};
