//! Binomial coefficients of real numbers.

/// `1 / C(a + b, a) = Γ(1 + a) Γ(1 + b) / Γ(1 + a + b) = (1 + a + b) B(1 + a, 1 + b)`, in [0, 1],
/// for a, b in [0, 1e18].
///
/// The relative error is below 2e-13 where the value is above 1e-300, and 0 for a = 0 or b = 0. The
/// function is symmetric to the bit.
///
/// Euler's product `Π k (a + b + k) / ((a + k) (b + k))` over all k ≥ 1; the factors behind the
/// eighth are again such a ratio, of arguments that are 8 larger, for which Stirling's series holds
/// (NIST Digital Library of Mathematical Functions, 5.8.2 and 5.11.1). Logarithms of Γ itself
/// would cancel: at 1e14 they are 3e15.
#[must_use]
pub(crate) fn inverse_binomial(a: f64, b: f64) -> f64 {
    const N: f64 = 8.0;
    let (small, large) = (a.min(b), a.max(b));
    let sum = small + large;
    let (mut above, mut below) = (1.0, 1.0);
    for k in 1..=N as u32 {
        let k = f64::from(k);
        above *= k * (sum + k);
        below *= (small + k) * (large + k);
    }
    let (s, l, both) = (small + N, large + N, sum + N);
    // Both logarithms to the power of their own factor alone, which is small where the ratio is
    // near 1.
    let log = large * libm::log1p(-small / both) + small * libm::log(s / both);
    let remainders = (stirling(s) - stirling(N)) + (stirling(l) - stirling(both));
    let ratio = s * l / (both * N);
    let value = above / below * ratio.powi(N as i32) * ratio.sqrt() * libm::exp(log + remainders);
    // above 1 only by rounding
    value.min(1.0)
}

/// `ln Γ(1 + x) - (x + 1/2) ln x + x - ln(2π)/2`, within 2e-14 for x ≥ 8.
fn stirling(x: f64) -> f64 {
    const SERIES: [f64; 6] =
        [1.0 / 12.0, -1.0 / 360.0, 1.0 / 1260.0, -1.0 / 1680.0, 1.0 / 1188.0, -691.0 / 360_360.0];
    let square = 1.0 / (x * x);
    SERIES.iter().rev().fold(0.0, |sum, term| sum * square + term) / x
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn values_are_those_of_the_gamma_function() {
        // By 60 digits of ln Γ.
        for (a, b, expected, tolerance) in [
            (0.5, 0.5, std::f64::consts::FRAC_PI_4, 2e-14),
            (1e-3, 7.25, 0.997_378_599_303_148_1, 2e-14),
            (0.3, 0.7, 0.815_476_636_264_696, 2e-14),
            (12.125, 0.0625, 0.825_630_679_551_826, 2e-14),
            (3.5, 4.25, 0.017_282_881_803_897_347, 2e-14),
            (30.0, 50.0, 1.127_216_208_323_903e-22, 1e-13),
            (150.5, 170.25, 1.146_902_061_737_33e-95, 1e-13),
            (300.0, 500.0, 4.843_143_545_730_49e-229, 1e-12),
            (1e5, 0.75, 1.634_339_242_691_93e-4, 1e-13),
            (1e5, 3.5, 3.677_985_836_833_674e-17, 1e-13),
            (5e14, 1e-3, 0.966_163_675_475_165_6, 2e-14),
            (5e14, 2.5, 5.944_990_946_408_965e-37, 1e-13),
            (5e14, 10.0, 3.715_891_199_999_591e-141, 1e-13),
            (1e10, 25.0, 1.551_120_953_921_667e-225, 1e-12),
        ] {
            let value = inverse_binomial(a, b);
            assert_eq!(value, inverse_binomial(b, a), "{a} {b}");
            assert_relative_eq!(value, expected, epsilon = 0.0, max_relative = tolerance);
        }
    }

    #[test]
    fn integers_count_subsets() {
        for n in 0..=60u64 {
            let mut subsets = 1u64;
            for k in 0..=n {
                let value = inverse_binomial(k as f64, (n - k) as f64);
                let expected = 1.0 / subsets as f64;
                assert_relative_eq!(value, expected, epsilon = 0.0, max_relative = 1e-13);
                subsets = (u128::from(subsets) * u128::from(n - k) / u128::from(k + 1)) as u64;
            }
        }
    }

    #[test]
    fn ends_of_the_range_are_exact() {
        for large in [0.0, 1e-300, 1e-9, 0.3, 7.0, 1e6, 5e14, 1e18] {
            assert_eq!(inverse_binomial(0.0, large), 1.0);
            assert!((0.0..=1.0).contains(&inverse_binomial(large, large)), "{large}");
            // 1 - a H(b) for small a, with the harmonic numbers, which grow like a logarithm.
            assert!(inverse_binomial(1e-12, large) > 1.0 - 1e-10, "{large}");
        }
        assert_eq!(inverse_binomial(1e18, 1e18), 0.0);
    }
}
