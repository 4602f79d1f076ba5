//! Agreement of integrators: tests of the difference of two images whose standard errors are known
//! from batches.
//!
//! Three tests per pair, each at the same small significance. The means of the images differ by
//! more than chance; the worst of all blocks of pixels does (Šidák's correction for their number);
//! or all blocks together do. The statistic is Welch's t, because the variances come from few
//! batches: with 16 of them its tails are much longer than a normal distribution's.
//!
//! An integrator with long tails (rare, very bright contributions) is tested for blocks that are
//! too bright only: a block that is too dark may just have missed them. What such a pair agrees on
//! is the mean of the image; that no light is missing anywhere needs more samples. If not even the
//! variance of the image is known, the same holds for its mean.
//!
//! A block that an integrator rarely reaches (some of its batches saw nothing) has no usable
//! variance. Such blocks are pooled into one.

use super::batches::{Batch, BatchMean, Layout};
use super::measured::Measured;
use crate::math::statistics::{sidak, two_sided_p_value};
use crate::math::student::student_t_p_value;
use serde::{Deserialize, Serialize};

/// Probability that one test rejects integrators that do agree.
pub const SIGNIFICANCE: f64 = 1e-4;

/// The test of all blocks together needs this many.
const FEWEST_BLOCKS: f64 = 16.0;

/// Welch's test of two means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Welch {
    /// Difference in standard errors.
    #[serde(with = "super::number")]
    pub t: f64,
    /// Degrees of freedom.
    #[serde(with = "super::number")]
    pub freedom: f64,
    /// Two-sided.
    pub p_value: f64,
}

impl Welch {
    /// Tests whether two independent means differ.
    #[must_use]
    pub fn test(a: &BatchMean, b: &BatchMean) -> Self {
        let difference = a.plus(*b, -1.0);
        let freedom = difference.freedom;
        // Two constants that differ by rounding only are equal, and of an infinite variance nothing
        // is known.
        if difference.mean.abs() <= 1e-9 * a.mean.abs().max(b.mean.abs())
            || difference.variance.is_infinite()
        {
            return Self { t: 0.0, freedom, p_value: 1.0 };
        }
        if difference.variance <= 0.0 {
            return Self { t: f64::INFINITY.copysign(difference.mean), freedom, p_value: 0.0 };
        }
        let t = difference.mean / difference.standard_error();
        Self { t, freedom, p_value: student_t_p_value(t, freedom) }
    }
}

/// The result for one pair of integrators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Their names.
    pub names: [String; 2],
    /// Test of the means of the images.
    pub mean: Welch,
    /// Test of the block with the smallest p-value.
    pub worst: Welch,
    /// Columns and rows of that block, `[[from, to], [from, to]]`; `None` for the pool of dark
    /// blocks, or if no block was tested.
    pub worst_block: Option<[[u32; 2]; 2]>,
    /// Its two means.
    pub worst_means: [f64; 2],
    /// Its p-value must be above this.
    pub worst_limit: f64,
    /// Blocks that were tested, the pool included.
    pub tested_blocks: usize,
    /// Blocks in the pool.
    pub pooled_blocks: usize,
    /// Mean of t² over the blocks, each divided by its expectation: 1 if the integrators agree.
    #[serde(with = "super::number")]
    pub mean_square: f64,
    /// Standard error of `mean_square`; infinite for fewer than 16 blocks and for samples that
    /// depend on one another: then blocks are not tested together.
    #[serde(with = "super::number")]
    pub mean_square_error: f64,
    /// Long tails of the first and of the second.
    pub long_tails: [bool; 2],
    /// True if the image that is darker on average is so noisy that this says nothing.
    pub mean_is_open: bool,
}

impl Pair {
    /// The outcomes of the three tests, true for passed: of the means, of the worst block, of all
    /// blocks together.
    #[must_use]
    pub fn verdicts(&self) -> [bool; 3] {
        // Only an excess speaks against agreement; long-tailed noise makes t too small, not too
        // large.
        let excess = (self.mean_square - 1.0) / self.mean_square_error;
        let all_blocks = self.long_tails != [false; 2]
            || excess < 0.0
            || excess.is_nan()
            || 0.5 * two_sided_p_value(excess) > SIGNIFICANCE;
        [
            self.mean.p_value > SIGNIFICANCE || self.mean_is_open,
            self.worst.p_value > self.worst_limit,
            all_blocks,
        ]
    }

    /// True if the pair passes all three tests.
    #[must_use]
    pub fn agrees(&self) -> bool {
        self.verdicts().iter().all(|ok| *ok)
    }

    /// The pixels of the worst block, for people.
    #[must_use]
    pub fn place(&self) -> String {
        self.worst_block.map_or_else(
            || "the pool of dark blocks".to_owned(),
            |[x, y]| format!("pixels {}..{}, {}..{}", x[0], x[1], y[0], y[1]),
        )
    }
}

/// Tests all pairs of unbiased integrators that see everything.
pub(in crate::report) fn test_pairs(measured: &[&Measured], layout: Layout) -> Vec<Pair> {
    let tested: Vec<&Measured> = measured.iter().copied().filter(|run| run.is_tested()).collect();
    let pairs =
        tested.iter().enumerate().flat_map(|(i, a)| tested[i + 1..].iter().map(move |b| [*a, *b]));
    pairs.map(|pair| test(pair, layout)).collect()
}

fn test(pair: [&Measured; 2], layout: Layout) -> Pair {
    let batches = pair.map(|m| m.batches.as_slice());
    let long_tails = pair.map(Measured::has_long_tails);
    let of_blocks = |batches: &[Batch], blocks: &[usize]| {
        let pixels: f64 = blocks.iter().map(|b| layout.pixels(*b)).sum();
        let mean = |batch: &Batch| {
            blocks.iter().map(|b| batch.blocks[*b] * layout.pixels(*b)).sum::<f64>() / pixels
        };
        BatchMean::of(batches.iter().map(|batch| (batch.samples, mean(batch))))
    };
    let all = |block: usize, test: fn(f64) -> bool| {
        batches.iter().all(|side| side.iter().all(|batch| test(batch.blocks[block])))
    };
    let (mut tests, mut pool) = (Vec::new(), Vec::new());
    for block in 0..layout.blocks() {
        if all(block, |mean| mean == 0.0) {
            continue;
        }
        if all(block, |mean| mean != 0.0) {
            let means = batches.map(|side| of_blocks(side, &[block]));
            tests.push((
                Welch::test(&means[0], &means[1]),
                Some(layout.bounds(block)),
                means.map(|m| m.mean),
            ));
        } else {
            pool.push(block);
        }
    }
    let (count, sum, squares) = tests.iter().filter(|(w, ..)| w.freedom > 4.0).fold(
        (0.0, 0.0, 0.0),
        |(n, sum, squares), (w, ..)| {
            let ratio = w.t.powi(2) * (w.freedom - 2.0) / w.freedom;
            (n + 1.0, sum + ratio, squares + ratio * ratio)
        },
    );
    let mean_square: f64 = sum / f64::max(count, 1.0);
    // A few blocks do not know the error of their mean, nor do those of samples that depend on one
    // another.
    let is_known = count >= FEWEST_BLOCKS && !pair.iter().any(|m| m.is_correlated);
    let variance = if is_known { squares / count - mean_square.powi(2) } else { f64::INFINITY };
    let mean_square_error = (variance / f64::max(count, 1.0)).sqrt();
    if !pool.is_empty() {
        let means = batches.map(|side| of_blocks(side, &pool));
        tests.push((Welch::test(&means[0], &means[1]), None, means.map(|m| m.mean)));
    }
    // Too dark where its tails are long says nothing.
    tests.retain(|(welch, ..)| !(long_tails[0] && welch.t < 0.0 || long_tails[1] && welch.t > 0.0));
    let weights = layout.uniform_weights();
    let means = batches.map(|side| BatchMean::of_sum(side, &weights));
    let none = (Welch { t: 0.0, freedom: f64::INFINITY, p_value: 1.0 }, None, [0.0; 2]);
    let tested_blocks = tests.len();
    let (worst, worst_block, worst_means) =
        tests.into_iter().min_by(|x, y| x.0.p_value.total_cmp(&y.0.p_value)).unwrap_or(none);
    let darker = pair[usize::from(means[1].mean < means[0].mean)];
    Pair {
        names: pair.map(|m| m.name.clone()),
        mean: Welch::test(&means[0], &means[1]),
        worst,
        worst_block,
        worst_means,
        worst_limit: sidak(SIGNIFICANCE, tested_blocks.max(1)),
        tested_blocks,
        pooled_blocks: pool.len(),
        mean_square,
        mean_square_error,
        long_tails,
        mean_is_open: darker.has_open_mean(),
    }
}
