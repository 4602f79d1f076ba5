//! Numbers: from images, costs and batches to errors, intervals and tests. Nothing here renders.

mod agreement;
mod batches;
mod bias;
mod curve;
mod interval;
mod measured;
mod metrics;
pub(super) mod number;
mod reference;
mod regression;
mod tail;

pub use agreement::{Pair, SIGNIFICANCE, Welch};
pub use batches::{BLOCK, Batch, BatchMean, Layout};
pub use bias::{BIAS_SIGNIFICANCE, Bias};
pub use curve::{Checkpoint, REFERENCE_SHARE, Slope, TimeToTarget};
pub use interval::{CONFIDENCE, Interval};
pub use measured::{Cost, SpeedUp};
pub use metrics::{Errors, median_of_means};
pub use reference::{RELATIVE_EPSILON, Reference};
pub use regression::{slope, time_to_error};
pub use tail::{Largest, Tail};

pub(super) use agreement::test_pairs;
pub(super) use measured::Measured;
pub(super) use reference::ratio;
