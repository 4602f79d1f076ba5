//! Whether integrators agree: tests of the difference of two images whose standard errors are known from batches.
//!
//! Three tests per pair, each at the same small significance. The means of the images differ by more than chance; the worst of all blocks of
//! pixels does (Šidák's correction for their number); or all blocks together do. The statistic is Welch's t, because the variances come from
//! few batches: with 16 of them its tails are much longer than a normal distribution's.
//!
//! An integrator with long tails (rare, very bright contributions) is tested for blocks that are too bright only: a block that is too dark may
//! just have missed them. What such a pair agrees on is the mean of the image; that no light is missing anywhere needs more samples. If not even
//! the variance of the image is known, the same holds for its mean.
//!
//! A block that an integrator rarely reaches (some of its batches saw nothing) has no usable variance. Such blocks are pooled into one.

use super::measure::{BLOCK, BatchMean, Layout, Measured};
use pathspace::math::statistics::{sidak, two_sided_p_value};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Probability that one test rejects integrators that do agree.
const SIGNIFICANCE: f64 = 1e-4;

/// With a variance that is known no better than this, the noise of an image is dominated by a handful of contributions.
const LARGEST_RELATIVE_ERROR: f64 = 0.2;

/// Welch's test of two means.
#[derive(Clone, Copy, Debug)]
pub struct Welch {
    pub t: f64,
    pub freedom: f64,
    pub p_value: f64,
}

impl Welch {
    pub fn test(a: &BatchMean, b: &BatchMean) -> Self {
        let variance = a.variance + b.variance;
        let difference = a.mean - b.mean;
        // Two constants that differ by rounding only are equal.
        if difference.abs() <= 1e-9 * a.mean.abs().max(b.mean.abs()) {
            return Self { t: 0.0, freedom: a.freedom + b.freedom, p_value: 1.0 };
        }
        if variance <= 0.0 {
            return Self { t: f64::INFINITY.copysign(difference), freedom: a.freedom + b.freedom, p_value: 0.0 };
        }
        let t = difference / variance.sqrt();
        let freedom = variance.powi(2) / (a.variance.powi(2) / a.freedom + b.variance.powi(2) / b.freedom);
        let tail = StudentsT::new(0.0, 1.0, freedom).map_or(0.0, |student| student.sf(t.abs()));
        Self { t, freedom, p_value: 2.0 * tail }
    }
}

/// The result for one pair of integrators.
#[derive(Clone, Debug)]
pub struct Pair {
    pub names: [&'static str; 2],
    pub mean: Welch,
    /// Smallest p-value among the blocks, and where it is.
    pub worst: Welch,
    pub worst_place: String,
    pub worst_means: [f64; 2],
    pub worst_limit: f64,
    pub tested_blocks: usize,
    pub pooled_blocks: usize,
    /// Mean of t² over the blocks, each divided by its expectation: 1 if the integrators agree.
    pub mean_square: f64,
    pub mean_square_error: f64,
    /// Which of the two has long tails.
    pub long_tails: [bool; 2],
    /// Whether the image that is darker on average is so noisy that this says nothing.
    pub mean_is_open: bool,
}

impl Pair {
    fn verdicts(&self) -> [bool; 3] {
        // Only an excess speaks against agreement; long-tailed noise makes t too small, not too large.
        let excess = (self.mean_square - 1.0) / self.mean_square_error;
        let all_blocks = self.long_tails != [false; 2] || excess < 0.0 || excess.is_nan() || 0.5 * two_sided_p_value(excess) > SIGNIFICANCE;
        [self.mean.p_value > SIGNIFICANCE || self.mean_is_open, self.worst.p_value > self.worst_limit, all_blocks]
    }

    pub fn agrees(&self) -> bool {
        self.verdicts().iter().all(|ok| *ok)
    }
}

/// The pixels of a block.
fn place(layout: Layout, block: usize) -> String {
    let [x, y] = layout.corner(block);
    format!("pixels {x}..{}, {y}..{}", (x + BLOCK).min(layout.width), (y + BLOCK).min(layout.height))
}

/// Tests all pairs of integrators that see everything.
pub fn test_pairs(measured: &[Measured], layout: Layout) -> Vec<Pair> {
    let tested: Vec<&Measured> = measured.iter().filter(|run| run.sees_all).collect();
    let pairs = tested.iter().enumerate().flat_map(|(i, a)| tested[i + 1..].iter().map(move |b| (*a, *b)));
    pairs.map(|(a, b)| test(a, b, layout)).collect()
}

fn test(a: &Measured, b: &Measured, layout: Layout) -> Pair {
    let usable = |run: &Measured, block: usize| run.batch_blocks.iter().all(|means| means[block] != 0.0);
    let long_tails = [a.long_tails, b.long_tails];
    let (mut tests, mut pool) = (Vec::new(), Vec::new());
    for block in 0..layout.blocks() {
        let dark = [a, b].iter().all(|run| run.batch_blocks.iter().all(|means| means[block] == 0.0));
        if dark {
            continue;
        }
        if usable(a, block) && usable(b, block) {
            let means = [a, b].map(|run| run.block(&[block]));
            tests.push((Welch::test(&means[0], &means[1]), place(layout, block), means.map(|m| m.mean)));
        } else {
            pool.push(block);
        }
    }
    let (count, sum, squares) = tests.iter().filter(|(w, ..)| w.freedom > 4.0).fold((0.0, 0.0, 0.0), |(n, sum, squares), (w, ..)| {
        let ratio = w.t.powi(2) * (w.freedom - 2.0) / w.freedom;
        (n + 1.0, sum + ratio, squares + ratio * ratio)
    });
    let mean_square: f64 = sum / count;
    let mean_square_error = ((squares / count - mean_square.powi(2)) / count).sqrt();
    if !pool.is_empty() {
        let means = [a, b].map(|run| run.block(&pool));
        tests.push((Welch::test(&means[0], &means[1]), "the pool of dark blocks".to_owned(), means.map(|m| m.mean)));
    }
    // Too dark where its tails are long says nothing.
    tests.retain(|(welch, ..)| !(long_tails[0] && welch.t < 0.0 || long_tails[1] && welch.t > 0.0));
    let none = (Welch { t: 0.0, freedom: f64::INFINITY, p_value: 1.0 }, "no block".to_owned(), [0.0; 2]);
    let tested_blocks = tests.len();
    let (worst, worst_place, worst_means) = tests.into_iter().min_by(|x, y| x.0.p_value.total_cmp(&y.0.p_value)).unwrap_or(none);
    Pair {
        names: [a, b].map(|run| run.integrator.name()),
        mean: Welch::test(&a.mean, &b.mean),
        worst,
        worst_place,
        worst_means,
        worst_limit: sidak(SIGNIFICANCE, tested_blocks.max(1)),
        tested_blocks,
        pooled_blocks: pool.len(),
        mean_square,
        mean_square_error,
        long_tails,
        mean_is_open: (if a.mean.mean < b.mean.mean { a } else { b }).relative_error > LARGEST_RELATIVE_ERROR,
    }
}

pub fn print(pairs: &[Pair]) {
    if pairs.is_empty() {
        return;
    }
    println!(
        "\nagreement: t of the image means; worst of the blocks of {BLOCK} x {BLOCK} pixels; mean square of t over all blocks (1 expected)"
    );
    for pair in pairs {
        let [mean, worst, all] = pair.verdicts().map(|ok| if ok { "" } else { " (!)" });
        let mean = if pair.mean.p_value <= SIGNIFICANCE && pair.mean_is_open { " (?)" } else { mean };
        let name = format!("{} - {}", pair.names[0], pair.names[1]);
        println!(
            "  {name:<30} means {:+6.2}{mean}   worst block {:+6.2} (p {:.1e}, limit {:.1e}){worst} at {}: {:.4} and {:.4}   all {} blocks {:.2} ± {:.2}{all}   {}",
            pair.mean.t,
            pair.worst.t,
            pair.worst.p_value,
            pair.worst_limit,
            pair.worst_place,
            pair.worst_means[0],
            pair.worst_means[1],
            pair.tested_blocks,
            pair.mean_square,
            pair.mean_square_error,
            if pair.agrees() { "agree" } else { "DISAGREE" }
        );
    }
    if pairs.iter().any(|pair| pair.long_tails != [false; 2]) {
        println!(
            "  integrators marked ‡ have long tails: their blocks are tested for being too bright, not for being too dark; (?) not even the mean can be tested"
        );
    }
}
