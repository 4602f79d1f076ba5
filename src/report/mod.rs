//! Error against run time: how integrators compare on a scene, with intervals on every number that
//! is compared.
//!
//! ```
//! use pathspace::gallery;
//! use pathspace::glam::UVec2;
//! use pathspace::integrator::{Bidirectional, PathTracer};
//! use pathspace::render::{Budget, Settings};
//! use pathspace::report::{Contestant, Plan, Reference, ReferencePlan, SceneInfo, study};
//! use std::ops::ControlFlow;
//!
//! let scene = gallery::build("cornell-box", UVec2::new(16, 16))?;
//! let (paths, both_ends) = (PathTracer::up_to(3), Bidirectional::up_to(3));
//! let contestants = [
//!     Contestant::new("path tracing", &paths, true),
//!     Contestant::new("bidirectional", &both_ends, true),
//! ];
//! let quiet = &mut |_: &pathspace::report::Step<'_>| ControlFlow::Continue(());
//! let (budget, settings) = (Budget::Samples(64), Settings::default());
//! let plan = ReferencePlan { budget, runs: 4, settings };
//! let halves = [&contestants[0], &contestants[1]];
//! let reference = Reference::render(&scene.world, &*scene.camera, halves, &plan, quiet)?;
//! let name = scene.name.to_owned();
//! let info = SceneInfo { name, max_bounces: Some(3), ..SceneInfo::default() };
//! let plan = Plan { budget: Budget::Samples(16), ..Plan::default() };
//! let study = study(&scene.world, &*scene.camera, &info, &contestants, reference, &plan, quiet)?;
//! assert_eq!(study.report.methods[1].name, "bidirectional");
//! let page: String = study.page();
//! # assert!(page.contains("bidirectional"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Three parts: `study` renders, [`stats`] makes numbers, `page` shows them. The findings of a
//! study are the plain data of a [`Report`]; docs/report.md defines every number and lists the
//! fields of the JSON file.

mod error;
mod page;
mod result;
pub mod stats;
mod study;
pub mod text;

pub use error::ReportError;
pub use page::{Axis, ERROR_SCALE, error_colour, error_plot, exposure, signed_error_map};
pub use result::{
    CandidateReport, DecisionReport, FindingsReport, GuidanceReport, Layer, LedgerReport, Machine,
    MethodImages, MethodReport, MissingReport, NormalizationReport, Omission, Pyramid,
    PyramidReport, ReferenceInfo, Report, SCHEMA, SceneInfo, Setup, SharedReport, Snapshot, Study,
    TechniqueShare, WithoutTechnique,
};
pub use stats::{
    BIAS_SIGNIFICANCE, Behind, Bias, Checkpoint, Cost, Errors, Interval, Outcome, Pair, Price,
    REFERENCE_SHARE, Ranking, Reference, SIGNIFICANCE, Slope, SpeedUp, Split, Tail, TimeToTarget,
    Undecided, Welch, median_of_means,
};
pub use study::{
    Contestant, Method, Plan, Probe, ReferencePlan, Step, cached_reference, measure_pyramid,
    measure_techniques, study, study_of_shards, study_shard,
};
