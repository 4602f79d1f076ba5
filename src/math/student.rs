//! Student's t distribution: the error of a mean whose variance is estimated from few values.

use super::statistics::{Estimate, ln_gamma};

/// Two-sided p-value of a t statistic: the probability that a variable with `freedom` degrees of
/// freedom is at least that far from 0. Infinite degrees of freedom are the normal distribution;
/// NaN gives 0.
#[must_use]
pub fn student_t_p_value(t: f64, freedom: f64) -> f64 {
    if t.is_nan() || freedom.is_nan() || freedom <= 0.0 {
        return 0.0;
    }
    if freedom > 1e7 {
        return super::statistics::two_sided_p_value(t);
    }
    let x = freedom / (freedom + t * t);
    regularized_beta(0.5 * freedom, 0.5, x)
}

/// The distance from 0 that such a variable exceeds with probability `p` (both sides together);
/// infinite for p ≤ 0, 0 for p ≥ 1.
#[must_use]
pub fn student_t_quantile(p: f64, freedom: f64) -> f64 {
    if p.is_nan() || p <= 0.0 || freedom.is_nan() || freedom <= 0.0 {
        return f64::INFINITY;
    }
    if p >= 1.0 {
        return 0.0;
    }
    let mut high = 1.0;
    while student_t_p_value(high, freedom) > p && high < 1e300 {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if student_t_p_value(middle, freedom) > p { low = middle } else { high = middle }
    }
    high
}

/// Half the width of the interval that contains the mean with probability `confidence`; infinite
/// for fewer than two numbers.
#[must_use]
pub fn half_width(estimate: &Estimate, confidence: f64) -> f64 {
    if estimate.count() < 2 {
        return f64::INFINITY;
    }
    student_t_quantile(1.0 - confidence, (estimate.count() - 1) as f64) * estimate.standard_error()
}

/// Regularised incomplete beta function `I_x(a, b)` by its continued fraction (Abramowitz and
/// Stegun 1964, 26.5.8), Lentz's method.
fn regularized_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return (1.0 - regularized_beta(b, a, 1.0 - x)).clamp(0.0, 1.0);
    }
    let front =
        (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p()).exp() / a;
    const TINY: f64 = 1e-300;
    let keep_off_zero = |y: f64| if y.abs() < TINY { TINY } else { y };
    let mut c = 1.0;
    let mut d = 1.0 / keep_off_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    for m in 1..10_000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut factor = 1.0;
        for numerator in [even, odd] {
            d = 1.0 / keep_off_zero(1.0 + numerator * d);
            c = keep_off_zero(1.0 + numerator / c);
            factor = c * d;
            fraction *= factor;
        }
        if (factor - 1.0).abs() < 4.0 * f64::EPSILON {
            break;
        }
    }
    (front * fraction).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn limits() {
        assert_relative_eq!(
            student_t_quantile(0.05, f64::INFINITY),
            1.959_963_984_540_054,
            max_relative = 1e-9
        );
        assert_relative_eq!(
            student_t_quantile(0.05, 7.0),
            2.364_624_251_592_785,
            max_relative = 1e-9
        );
        assert_eq!(student_t_quantile(0.0, 5.0), f64::INFINITY);
        assert_eq!(student_t_p_value(f64::NAN, 5.0), 0.0);
        assert_eq!(student_t_p_value(f64::INFINITY, 5.0), 0.0);
        assert_eq!(half_width(&[1.0].into_iter().collect(), 0.95), f64::INFINITY);
    }
}
