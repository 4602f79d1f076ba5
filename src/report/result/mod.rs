//! The findings of a study as plain data, serialised to JSON as they stand. docs/report.md
//! describes the fields.

mod left_out;
mod method;
mod pyramid;
mod report;
mod study;
mod verdict;

pub use left_out::{CandidateReport, DecisionReport, Omission, WithoutTechnique};
pub use method::{LedgerReport, MethodReport};
pub use pyramid::{Layer, Pyramid, PyramidReport, TechniqueShare};
pub use report::{ReferenceInfo, Report, SCHEMA, SceneInfo, Setup};
pub use study::{MethodImages, Snapshot, Study};

pub(super) use left_out::omissions;
pub(super) use study::SNAPSHOTS;
