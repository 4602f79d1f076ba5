//! Studies: the part of a report that renders.
//!
//! A [`Plan`] gives each [`Contestant`] budget and seeds; [`study`] renders its runs, watches error
//! and cost on the way, and hands images and costs to [`stats`](super::stats). A reference comes
//! from a file, from two integrators, or from the [cache](cached_reference); [`measure_pyramid`]
//! takes bidirectional path tracing apart technique by technique (Veach 1997, figure 10.3), and
//! [`measure_techniques`] any integrator.

mod cache;
mod compare;
mod machine;
mod method;
mod numbers;
mod observer;
mod plan;
mod pyramid;
mod reference;
mod run_file;
mod runs;
mod shards;
mod summary;
mod watch;

pub use cache::cached_reference;
pub use compare::study;
pub use method::{Contestant, Method, Probe};
pub use plan::{Plan, ReferencePlan, Step};
pub use pyramid::{measure_pyramid, measure_techniques};
pub use shards::{study_of_shards, study_shard};
