//! Numbers: from images, costs and batches to errors, intervals and tests. Nothing here renders.
//!
//! | number | item |
//! |---|---|
//! | error of an image against a reference | [`Errors`], [`Reference`] |
//! | fall of the error with cost, and the time to a target | [`Slope`], [`TimeToTarget`] |
//! | interval of a mean from few runs | [`Interval`] |
//! | variance and squared bias apart | [`Split`], in each [`Checkpoint`] |
//! | cost, and efficiency `1 / (variance × cost)` over a baseline's | [`Cost`], [`SpeedUp`] |
//! | order by what the same error costs | [`Ranking`] |
//! | evidence of an estimate that has met little | [`Undecided`] |
//! | agreement of two integrators | [`Pair`], [`Welch`] |
//! | bias against the reference | [`Bias`] |
//! | variance from independent batches | [`Batch`], [`Layout`] |
//! | tail of the contributions, whether the variance is finite | [`Tail`] |

mod agreement;
mod batches;
mod bias;
mod curve;
mod evidence;
mod interval;
mod measured;
mod metrics;
pub(super) mod number;
mod ranking;
mod reference;
mod regression;
mod tail;

pub use agreement::{Outcome, Pair, SIGNIFICANCE, Welch};
pub use batches::{BLOCK, Batch, BatchMean, Layout};
pub use bias::{BIAS_SIGNIFICANCE, Bias};
pub use curve::{Checkpoint, REFERENCE_SHARE, Slope, TimeToTarget};
pub use evidence::{FEWEST_CONTRIBUTIONS, Undecided};
pub use interval::{CONFIDENCE, Interval};
pub use measured::{Cost, SpeedUp, Split};
pub use metrics::{Errors, median_of_means};
pub use ranking::{Behind, Price, Ranking};
pub use reference::{RELATIVE_EPSILON, Reference};
pub use regression::{slope, time_to_error};
pub use tail::{Largest, Tail};

pub(super) use agreement::test_pairs;
pub(super) use measured::Measured;
pub(super) use reference::ratio;
