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
//! A block of which an integrator has met too little ([`Undecided`]) has no usable variance. Such
//! blocks are pooled into one; if it has met too little of them all, they are undecided. If it has
//! met too little of the image, so is the pair.

use super::batches::{Batch, BatchMean, Layout};
use super::evidence::Undecided;
use super::measured::Measured;
use super::reference::ratio;
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
    /// Blocks that are not tested, because one of the two has met too little of them, even of all
    /// together.
    pub undecided_blocks: usize,
    /// The light in these blocks as a share of the image's, of the integrator with the larger one.
    pub undecided_light: f64,
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
    /// True of the first and of the second if it has met too little of the image for any test.
    pub undecided: [bool; 2],
}

/// The outcome of the tests of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It passes all three.
    Agree,
    /// It fails one of them.
    Disagree,
    /// One of the two has met too little to be tested.
    Undecided,
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

    /// The outcome of all three tests.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        if self.undecided != [false; 2] {
            Outcome::Undecided
        } else if self.verdicts() == [true; 3] {
            Outcome::Agree
        } else {
            Outcome::Disagree
        }
    }

    /// True if the pair passes all three tests: not, if it is undecided.
    #[must_use]
    pub fn agrees(&self) -> bool {
        self.outcome() == Outcome::Agree
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
    let is_evidence = |side: &[Batch], blocks: &[usize], mean: &BatchMean| {
        let values = side.iter().flat_map(|batch| blocks.iter().map(|b| batch.blocks[*b]));
        mean.mean != 0.0 && Undecided::of(mean, values).is_none()
    };
    let (mut tests, mut pool, mut undecided) = (Vec::new(), Vec::new(), Vec::new());
    let mut try_to_test = |blocks: &[usize], bounds| {
        let means = batches.map(|side| of_blocks(side, blocks));
        let is_tested = (0..2).all(|i| is_evidence(batches[i], blocks, &means[i]));
        if is_tested {
            tests.push((Welch::test(&means[0], &means[1]), bounds, means.map(|m| m.mean)));
        }
        is_tested
    };
    for block in 0..layout.blocks() {
        let is_black = batches.iter().all(|side| side.iter().all(|b| b.blocks[block] == 0.0));
        if !is_black && !try_to_test(&[block], Some(layout.bounds(block))) {
            pool.push(block);
        }
    }
    if !pool.is_empty() && !try_to_test(&pool, None) {
        undecided = std::mem::take(&mut pool);
    }
    let (count, sum, squares) = tests
        .iter()
        .filter(|(w, of, _)| w.freedom > 4.0 && of.is_some())
        .fold((0.0, 0.0, 0.0), |(n, sum, squares), (w, ..)| {
            let ratio = w.t.powi(2) * (w.freedom - 2.0) / w.freedom;
            (n + 1.0, sum + ratio, squares + ratio * ratio)
        });
    let mean_square: f64 = sum / f64::max(count, 1.0);
    // A few blocks do not know the error of their mean, nor do those of samples that depend on one
    // another.
    let is_known = count >= FEWEST_BLOCKS && !pair.iter().any(|m| m.is_correlated);
    let variance = if is_known { squares / count - mean_square.powi(2) } else { f64::INFINITY };
    let mean_square_error = (variance / f64::max(count, 1.0)).sqrt();
    // Too dark where its tails are long says nothing.
    tests.retain(|(welch, ..)| !(long_tails[0] && welch.t < 0.0 || long_tails[1] && welch.t > 0.0));
    let weights = layout.uniform_weights();
    let means = batches.map(|side| BatchMean::of_sum(side, &weights));
    let none = (Welch { t: 0.0, freedom: f64::INFINITY, p_value: 1.0 }, None, [0.0; 2]);
    let tested_blocks = tests.len();
    let (worst, worst_block, worst_means) =
        tests.into_iter().min_by(|x, y| x.0.p_value.total_cmp(&y.0.p_value)).unwrap_or(none);
    let darker = pair[usize::from(means[1].mean < means[0].mean)];
    let share = |side: usize| {
        let pixels: f64 = undecided.iter().map(|block| layout.pixels(*block)).sum();
        let all = f64::from(layout.width) * f64::from(layout.height);
        ratio(of_blocks(batches[side], &undecided).mean * pixels, means[side].mean * all)
    };
    Pair {
        names: pair.map(|m| m.name.clone()),
        mean: Welch::test(&means[0], &means[1]),
        worst,
        worst_block,
        worst_means,
        worst_limit: sidak(SIGNIFICANCE, tested_blocks.max(1)),
        tested_blocks,
        pooled_blocks: pool.len(),
        undecided_blocks: undecided.len(),
        undecided_light: if undecided.is_empty() { 0.0 } else { share(0).max(share(1)) },
        mean_square,
        mean_square_error,
        long_tails,
        mean_is_open: darker.has_open_mean(),
        undecided: pair.map(|m| m.undecided().is_some()),
    }
}
