//! All integrators estimate the same image: each kind of light, material, camera, filter and limit,
//! in tiny scenes; and the exact answers that they must not merely agree on. `analytic.json`
//! entries are named by their ids.
//!
//! `cargo test --release -p pathspace-tests --test agreement -- --nocapture --test-threads 1` prints
//! the numbers.

#[path = "agreement/cameras.rs"]
mod cameras;
#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared by several test programs")]
mod compare;
#[path = "agreement/custom.rs"]
mod custom;
#[path = "agreement/lights.rs"]
mod lights;
#[path = "agreement/materials.rs"]
mod materials;
#[path = "agreement/reliefs.rs"]
mod reliefs;
#[path = "common/rooms.rs"]
mod rooms;
#[path = "agreement/team.rs"]
mod team;
#[path = "agreement/techniques.rs"]
mod techniques;
