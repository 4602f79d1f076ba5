//! The findings of a study as plain data, serialised to JSON as they stand. docs/report.md
//! describes the fields.
//!
//! A [`Study`] is a [`Report`], all numbers, and the images of its methods. A report has a
//! [`MethodReport`] for each integrator, with its [`LedgerReport`] of flux, its [`Omission`]s, its
//! [`MissingReport`]s, its [`DecisionReport`]s and [`FindingsReport`]s, and a [`PyramidReport`] for the techniques of
//! bidirectional path tracing.

mod answer;
mod clocks;
mod findings;
mod left_out;
mod method;
mod missing;
mod pyramid;
mod report;
mod study;
mod verdict;

pub use findings::{FindingsReport, GuidanceReport, NormalizationReport};
pub use left_out::{CandidateReport, DecisionReport, Omission, WithoutTechnique};
pub use method::{LedgerReport, MethodReport, SharedReport};
pub use missing::MissingReport;
pub use pyramid::{Layer, Pyramid, PyramidReport, TechniqueShare};
pub use report::{Machine, ReferenceInfo, Report, SCHEMA, SceneInfo, Setup};
pub use study::{MethodImages, Snapshot, Study};

pub(super) use left_out::omissions;
pub(super) use study::SNAPSHOTS;
