//! Photon mapping, vertex connection and merging, and instant radiosity: weights, exact answers, and
//! what happens at the limits.
#![allow(missing_docs, reason = "a test program")]

#[path = "merging/cap.rs"]
mod cap;
mod common;
#[path = "merging/dirac.rs"]
mod dirac;
#[path = "merging/excluded.rs"]
mod excluded;
#[path = "merging/limits.rs"]
mod limits;
#[path = "merging/passes.rs"]
mod passes;
#[path = "merging/plane.rs"]
mod plane;
#[path = "merging/weights.rs"]
mod weights;
mod worlds;
