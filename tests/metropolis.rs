//! Metropolis sampling: exact answers, the mean for chains of any length, agreement with the
//! integrator whose samples are mutated, and what stops or starves chains.
#![allow(missing_docs, reason = "a test program")]

#[path = "metropolis/chains.rs"]
mod chains;
#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;
#[path = "metropolis/exact.rs"]
mod exact;
#[path = "metropolis/gallery.rs"]
mod gallery;
#[path = "metropolis/measure.rs"]
mod measure;
#[path = "../examples/stability/scenes.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod scenes;
