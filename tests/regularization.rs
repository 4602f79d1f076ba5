//! Regularisation: mollified lobes, their bias in closed form, and an integrator with a radius that
//! shrinks.
#![allow(missing_docs, reason = "a test program")]

mod common;
#[path = "common/compare.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod compare;
#[path = "../examples/stability/scenes.rs"]
#[allow(dead_code, reason = "shared with the example")]
mod scenes;
mod worlds;

#[path = "regularization/agreement.rs"]
mod agreement;
#[path = "regularization/bias.rs"]
mod bias;
#[path = "regularization/furnaces.rs"]
mod furnaces;
#[path = "regularization/lobes.rs"]
mod lobes;
#[path = "bsdf/models.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod models;
#[path = "regularization/quadrature.rs"]
mod quadrature;
#[path = "regularization/schedule.rs"]
mod schedule;
#[path = "regularization/weights.rs"]
mod weights;
