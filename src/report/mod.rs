//! Error against run time: how integrators compare on a scene, with intervals on every number that
//! is compared.
//!
//! ```
//! use pathspace::glam::UVec2;
//! use pathspace::integrator::{Bidirectional, PathTracer};
//! use pathspace::render::{Budget, Settings};
//! use pathspace::report::{Contestant, Plan, Reference, ReferencePlan, SceneInfo, study};
//! use pathspace::scene::gallery;
//! use std::ops::ControlFlow;
//!
//! let scene = gallery::build("cornell-box", UVec2::new(16, 16))?;
//! let (paths, both_ends) = (PathTracer::up_to(3), Bidirectional::up_to(3));
//! let contestants = [
//!     Contestant::new("path tracing", &paths, true),
//!     Contestant::new("bidirectional", &both_ends, true),
//! ];
//! let quiet = &mut |_: &pathspace::report::Step<'_>| ControlFlow::Continue(());
//! let plan = ReferencePlan { budget: Budget::Samples(64), runs: 4, settings: Settings::default() };
//! let halves = [&contestants[0], &contestants[1]];
//! let reference = Reference::render(&scene.world, &*scene.camera, halves, &plan, quiet)?;
//! let info = SceneInfo { name: scene.name.to_owned(), max_bounces: Some(3), ..SceneInfo::default() };
//! let plan = Plan { budget: Budget::Samples(16), ..Plan::default() };
//! let study = study(&scene.world, &*scene.camera, &info, &contestants, reference, &plan, quiet)?;
//! assert_eq!(study.report.methods[1].name, "bidirectional");
//! let page: String = study.page();
//! # assert!(page.contains("bidirectional"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Definitions are in [`metrics`] and [`inference`]; the fields of the JSON file in
//! `docs/report.md`.

mod agreement;
mod analysis;
pub mod batches;
mod cache;
mod error;
pub mod inference;
mod leave_out;
mod method;
pub mod metrics;
mod number;
mod output;
mod page;
mod picture;
mod plot;
mod pyramid;
mod reference;
mod result;
mod runs;
mod study;
mod verdict;

pub use agreement::{Pair, SIGNIFICANCE, Welch};
pub use analysis::{BIAS_SIGNIFICANCE, REFERENCE_SHARE};
pub use cache::cached_reference;
pub use error::ReportError;
pub use inference::{Interval, Tail};
pub use leave_out::{DecisionReport, Omission, TechniqueDecision, WithoutTechnique};
pub use method::{Contestant, Method, Probe};
pub use metrics::{Errors, median_of_means};
pub use picture::{ERROR_SCALE, error_colour, exposure, signed_error_map};
pub use plot::{Axis, error_plot};
pub use pyramid::{Layer, Pyramid, PyramidReport, TechniqueShare, measure_pyramid};
pub use reference::{Reference, ReferencePlan};
pub use result::{
    Bias, Checkpoint, Cost, LedgerReport, MethodReport, ReferenceInfo, Report, SCHEMA, SceneInfo,
    Setup, Slope, SpeedUp, TimeToTarget,
};
pub use study::{MethodImages, Plan, Snapshot, Step, Study, study};
