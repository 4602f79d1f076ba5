//! Studies: who is measured, for how long, against what; everything that renders.

mod cache;
mod compare;
mod machine;
mod method;
mod plan;
mod pyramid;
mod reference;
mod runs;
mod summary;
mod watch;

pub use cache::cached_reference;
pub use compare::study;
pub use method::{Contestant, Method, Probe};
pub use plan::{Plan, ReferencePlan, Step};
pub use pyramid::measure_pyramid;
