//! Tests of statistical hypotheses, for checking samplers, BSDFs and integrators.
//!
//! A p-value is the probability of a result at least as extreme as the observed one if the
//! hypothesis holds. Whoever makes many tests lowers the significance level of each by [`sidak`],
//! or one in twenty correct samplers fails at 5 %.

use std::f64::consts::PI;

/// Running mean and variance of a sequence of numbers, in one pass and without cancellation
/// (Welford 1962).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    count: u64,
    mean: f64,
    /// Σ (x - mean)²
    squares: f64,
}

impl Estimate {
    /// Adds one number.
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        let delta = x - self.mean;
        self.mean += delta / self.count as f64;
        self.squares += delta * (x - self.mean);
    }

    /// Adds all numbers of another sequence (Chan, Golub and LeVeque 1979).
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let delta = other.mean - self.mean;
        self.count += other.count;
        self.mean += delta * (m / (n + m));
        self.squares += other.squares + delta * delta * (n * m / (n + m));
    }

    /// The number of values.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The mean; 0 for an empty sequence.
    #[must_use]
    pub const fn mean(&self) -> f64 {
        self.mean
    }

    // ANCHOR: standard-error
    /// Unbiased estimate of the variance of one number; 0 for fewer than two.
    #[must_use]
    pub fn variance(&self) -> f64 {
        if self.count < 2 { 0.0 } else { self.squares / (self.count - 1) as f64 }
    }

    /// Standard error of the mean, `√(variance / count)`.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        if self.count == 0 { 0.0 } else { (self.variance() / self.count as f64).sqrt() }
    }
    // ANCHOR_END: standard-error

    /// Distance of the mean from its expected value in standard errors; 0 if they are equal to
    /// rounding, infinite if they differ without any variance.
    #[must_use]
    pub fn z_score(&self, expected: f64) -> f64 {
        let difference = self.mean - expected;
        if difference.abs() <= 1e-12 * expected.abs() {
            0.0
        } else {
            difference / self.standard_error()
        }
    }
}

impl Extend<f64> for Estimate {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, numbers: I) {
        numbers.into_iter().for_each(|x| self.push(x));
    }
}

impl FromIterator<f64> for Estimate {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        let mut estimate = Self::default();
        estimate.extend(numbers);
        estimate
    }
}

/// The result of a χ² test of goodness of fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// `Σ (observed - expected)² / expected` over the pooled cells.
    pub statistic: f64,
    /// Pooled cells - 1.
    pub degrees_of_freedom: u32,
    /// Probability of a statistic at least as large if the observations do follow the expected
    /// frequencies.
    pub p_value: f64,
}

/// χ² test of counts against expected counts with the same sum (Pearson 1900).
///
/// The test needs some expected counts in each cell: those below `least_expected` (5 is the usual
/// number) are pooled, smallest first. Cells in which nothing is expected are pooled too, so that
/// counts there are held against the distribution. With a single pooled cell the p-value is 1.
///
/// Expected counts that are negative or not a number, and slices of different lengths, give the
/// p-value 0.
#[must_use]
pub fn chi_square(observed: &[f64], expected: &[f64], least_expected: f64) -> ChiSquare {
    let failed = ChiSquare { statistic: f64::INFINITY, degrees_of_freedom: 0, p_value: 0.0 };
    if observed.len() != expected.len() || expected.iter().any(|e| !e.is_finite() || *e < 0.0) {
        return failed;
    }
    let mut cells: Vec<(f64, f64)> =
        expected.iter().copied().zip(observed.iter().copied()).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pooled: Vec<(f64, f64)> = Vec::with_capacity(cells.len());
    let mut pool = (0.0, 0.0);
    for cell in cells {
        pool = (pool.0 + cell.0, pool.1 + cell.1);
        if pool.0 >= least_expected {
            pooled.push(pool);
            pool = (0.0, 0.0);
        }
    }
    // cells are sorted, so only a pool that never got full is left
    match pooled.last_mut() {
        Some(last) => *last = (last.0 + pool.0, last.1 + pool.1),
        None => pooled.push(pool),
    }
    let statistic = pooled
        .iter()
        .filter(|cell| cell.0 > 0.0 || cell.1 > 0.0)
        .map(|(e, o)| (o - e) * (o - e) / e)
        .sum::<f64>();
    if !statistic.is_finite() {
        return failed;
    }
    let degrees_of_freedom = (pooled.len() - 1) as u32;
    let p_value = if degrees_of_freedom == 0 {
        1.0
    } else {
        regularized_gamma_q(0.5 * f64::from(degrees_of_freedom), 0.5 * statistic)
    };
    ChiSquare { statistic, degrees_of_freedom, p_value }
}

/// Two-sided p-value of a z-score: the probability that a normal variable is at least that far from
/// its mean, in standard deviations.
#[must_use]
pub fn two_sided_p_value(z: f64) -> f64 {
    if z.is_nan() { 0.0 } else { regularized_gamma_q(0.5, 0.5 * z * z) }
}

/// The significance level for each of `tests` independent tests so that all together have the level
/// `significance` (Šidák 1967).
#[must_use]
pub fn sidak(significance: f64, tests: usize) -> f64 {
    // 1 - (1 - significance)^(1/tests), which would cancel
    -((-significance).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// Regularised upper incomplete gamma function `Q(a, x) = Γ(a, x) / Γ(a)` for a > 0 and x ≥ 0; NaN
/// elsewhere.
///
/// Series for x < a + 1, continued fraction elsewhere (Abramowitz and Stegun 1964, 6.5.29 and
/// 6.5.31).
#[must_use]
pub fn regularized_gamma_q(a: f64, x: f64) -> f64 {
    if !(a > 0.0 && x >= 0.0 && a.is_finite()) {
        return f64::NAN;
    }
    if x == 0.0 {
        return 1.0;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        (1.0 - front * lower_series(a, x)).clamp(0.0, 1.0)
    } else {
        (front * upper_fraction(a, x)).clamp(0.0, 1.0)
    }
}

/// `Σ x^n / (a (a+1) … (a+n))`
fn lower_series(a: f64, x: f64) -> f64 {
    let mut term = 1.0 / a;
    let mut sum = term;
    let mut n = a;
    for _ in 0..MOST_TERMS {
        n += 1.0;
        term *= x / n;
        sum += term;
        if term < sum * f64::EPSILON {
            break;
        }
    }
    sum
}

/// `1/(x + 1 - a - 1(1 - a)/(x + 3 - a - 2(2 - a)/(x + 5 - a - …)))` by Lentz's method.
fn upper_fraction(a: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for n in 1..MOST_TERMS {
        let n = f64::from(n);
        let numerator = n * (a - n);
        b += 2.0;
        let keep_off_zero = |y: f64| if y.abs() < TINY { TINY } else { y };
        d = 1.0 / keep_off_zero(numerator * d + b);
        c = keep_off_zero(b + numerator / c);
        let factor = c * d;
        fraction *= factor;
        if (factor - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    fraction
}

/// The most terms of either expansion, which needs about √a of them near x = a.
const MOST_TERMS: u32 = 100_000;

/// `ln Γ(x)` for x > 0 by Stirling's series (Abramowitz and Stegun 1964, 6.1.41), after moving x to
/// where it converges.
pub(super) fn ln_gamma(x: f64) -> f64 {
    let mut x = x;
    let mut product = 1.0;
    while x < 12.0 {
        product *= x;
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = (1.0 / 12.0
        + y * (-1.0 / 360.0 + y * (1.0 / 1260.0 + y * (-1.0 / 1680.0 + y * (1.0 / 1188.0)))))
        / x;
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * PI).ln() + series - f64::ln(product)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn logarithm_of_the_gamma_function() {
        let root = PI.sqrt().ln();
        for (a, expected) in [
            (0.1, 2.252_712_651_734_206),
            (0.5, root),
            (1.0, 0.0),
            (2.5, root + f64::ln(0.75)),
            (10.0, f64::ln(362_880.0)),
            (100.0, 359.134_205_369_575_4),
            (1000.0, 5_905.220_423_209_181),
        ] {
            assert_relative_eq!(ln_gamma(a), expected, max_relative = 1e-12, epsilon = 1e-13);
        }
    }

    #[test]
    fn estimate_of_shifted_numbers() {
        let numbers: Vec<f64> = (0..1000).map(|i| 1e6 + f64::from(i % 10)).collect();
        let whole: Estimate = numbers.iter().copied().collect();
        assert_relative_eq!(whole.mean(), 1e6 + 4.5, max_relative = 1e-15);
        assert_relative_eq!(whole.variance(), 8.25 * 1000.0 / 999.0, max_relative = 1e-9);
        let mut merged: Estimate = numbers[..300].iter().copied().collect();
        merged.merge(&numbers[300..].iter().copied().collect());
        merged.merge(&Estimate::default());
        assert_eq!(merged.count(), 1000);
        assert_relative_eq!(merged.variance(), whole.variance(), max_relative = 1e-9);
        assert_relative_eq!(
            whole.z_score(whole.mean() + 2.0 * whole.standard_error()),
            -2.0,
            max_relative = 1e-6
        );
        assert_eq!([1.0, 1.0].into_iter().collect::<Estimate>().z_score(1.0), 0.0);
        assert_eq!([1.0, 1.0].into_iter().collect::<Estimate>().z_score(0.5), f64::INFINITY);
    }

    #[test]
    fn chi_square_by_hand() {
        let test = chi_square(&[10.0, 20.0, 30.0, 2.0, 1.0], &[15.0, 20.0, 25.0, 1.5, 1.5], 5.0);
        // the two small cells (3 expected) join with the next larger one: (18, 20, 25) against (13,
        // 20, 30)
        assert_eq!(test.degrees_of_freedom, 2);
        assert_relative_eq!(test.statistic, 25.0 / 18.0 + 1.0, max_relative = 1e-14);
        assert_relative_eq!(test.p_value, (-0.5 * test.statistic).exp(), max_relative = 1e-12);
        assert_eq!(chi_square(&[1.0], &[1.0], 5.0).p_value, 1.0);
        assert_eq!(chi_square(&[1.0], &[1.0, 2.0], 5.0).p_value, 0.0);
        assert_eq!(chi_square(&[1.0, 1.0], &[f64::NAN, 1.0], 5.0).p_value, 0.0);
        assert_eq!(chi_square(&[0.0, 1.0], &[0.0, 0.0], 5.0).p_value, 0.0);
    }

    #[test]
    fn sidak_of_many_tests() {
        assert_relative_eq!(sidak(0.05, 1), 0.05, max_relative = 1e-14);
        assert_relative_eq!((1.0 - sidak(0.05, 100)).powi(100), 0.95, max_relative = 1e-12);
        assert_relative_eq!(sidak(1e-12, 1_000_000), 1e-18, max_relative = 1e-9);
    }
}
