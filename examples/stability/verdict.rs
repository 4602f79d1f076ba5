//! The verdict of a case on an integrator.

use crate::cases::{Case, Twin};
use crate::measure::{Method, Probe};

/// The outcome of one case by one integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Within 4 standard errors, known well enough.
    Holds,
    /// Within 4 standard errors, which are larger than asked for.
    Imprecise,
    /// Exactly 0, as claimed.
    Blind,
    /// Off by more than 4 standard errors, not finite, or not 0 where 0 is claimed.
    Fails,
}

impl Verdict {
    pub fn is_good(self) -> bool {
        self != Self::Fails
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Imprecise => "noisy",
            Self::Blind => "blind",
            Self::Fails => "FAILS",
        }
    }
}

/// One line of the table: the channel that is farthest off.
#[derive(Clone, Debug)]
pub struct Line {
    pub row: &'static str,
    pub family: &'static str,
    pub value: f64,
    pub method: Method,
    pub expected: f64,
    pub mean: f64,
    pub standard_error: f64,
    /// Relative distance from the expected value.
    pub deviation: f64,
    /// Relative difference to the scene without stress under the same random numbers, if there is
    /// one.
    pub rounding: Option<f64>,
    pub samples: u64,
    pub non_finite: u64,
    pub verdict: Verdict,
}

impl Line {
    /// Decimal digits that agree with the answer: as many as noise lets one see, or with the scene
    /// without stress, where there is no noise.
    pub fn digits(&self) -> f64 {
        let error =
            self.rounding.unwrap_or(self.deviation.max(self.standard_error / self.expected.abs()));
        (-error.log10()).clamp(0.0, 15.9)
    }
}

/// Samples that are compared with the scene without stress.
const TWIN_SAMPLES: u64 = 2000;
/// The largest difference between them that passes: single walks may take another turn where a
/// comparison is decided by rounding.
const TWIN_TOLERANCE: f64 = 1e-3;
/// Squares of larger or smaller numbers leave the range of f64, and with them variances.
const RANGE: std::ops::Range<f64> = 1e-140..1e140;

pub fn judge(case: &Case, rays: u64, seed: u64) -> Vec<Line> {
    let probe = |world, camera, radius| Probe {
        roulette: case.roulette,
        radius,
        ..Probe::new(world, camera, case.depth)
    };
    let stressed = probe(&case.world, &*case.camera, case.radius);
    let measure = |&method: &Method| {
        // Where variances are out of range, the comparison with the twin has to do.
        let in_range = case.expected.iter().all(|e| RANGE.contains(e));
        let target = [case.error.min(0.001), case.error];
        let measured = if in_range {
            stressed.estimate(method, case.expected, target, (rays / 20, rays), seed)
        } else {
            stressed.sample(method, TWIN_SAMPLES, seed)
        };
        let rounding = case.twin.as_ref().map(|Twin { world, camera, radius, factor }| {
            let [a, b] = [&stressed, &probe(world, &**camera, *radius)]
                .map(|probe| probe.sample(method, TWIN_SAMPLES, seed));
            let difference =
                |i: usize| (a.channels[i].mean() / (factor * b.channels[i].mean()) - 1.0).abs();
            (0..3).map(difference).fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
        });
        let worst = (0..3).max_by(|&i, &j| {
            let off = |i: usize| {
                ((measured.channels[i].mean() - case.expected[i]) / case.expected[i]).abs()
            };
            off(i).total_cmp(&off(j))
        });
        let i = worst.unwrap_or(0);
        let agrees = !in_range || measured.agrees(case.expected, case.tolerance);
        let holds =
            agrees && measured.non_finite == 0 && rounding.is_none_or(|r| r <= TWIN_TOLERANCE);
        let precise = !in_range || measured.relative_error(case.expected) <= case.error;
        Line {
            row: case.row,
            family: case.family,
            value: case.value,
            method,
            expected: case.expected[i],
            mean: measured.channels[i].mean(),
            standard_error: measured.channels[i].standard_error(),
            deviation: measured.deviation(case.expected),
            rounding,
            samples: measured.samples,
            non_finite: measured.non_finite,
            verdict: match (holds, precise) {
                (false, _) => Verdict::Fails,
                (true, true) => Verdict::Holds,
                (true, false) => Verdict::Imprecise,
            },
        }
    };
    let claim = |&method: &Method| {
        let measured = stressed.sample(method, 10_000, seed);
        let dark = measured.deviation([0.0; 3]) == 0.0 && measured.non_finite == 0;
        Line {
            row: case.row,
            family: case.family,
            value: case.value,
            method,
            expected: 0.0,
            mean: measured.channels[0].mean(),
            standard_error: measured.channels[0].standard_error(),
            deviation: measured.deviation([0.0; 3]),
            rounding: None,
            samples: measured.samples,
            non_finite: measured.non_finite,
            verdict: if dark { Verdict::Blind } else { Verdict::Fails },
        }
    };
    case.methods.iter().map(measure).chain(case.blind.iter().map(claim)).collect()
}
