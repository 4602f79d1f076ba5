//! The complementary error function and the quantiles of a Gaussian.
//!
//! Polynomials in short chains, in place of functions of the standard library's kind that also
//! serve subnormal numbers; relative errors are below 1e-15.

/// The greatest |x| that [`complement`] is made for.
pub(crate) const FARTHEST: f64 = 6.5;

/// erfc x, given e^{-x²}, for |x| ≤ 6.5.
///
/// `(1 + 2x) e^{x²} erfc x` is a polynomial in `(x - 3.75)/(x + 3.75)` (Shepherd and Laframboise
/// 1981, "Chebyshev Approximation of (1 + 2x) exp(x²) erfc x in 0 ≤ x < ∞").
#[inline]
pub(crate) fn complement(x: f64, gaussian: f64) -> f64 {
    const EVEN: [f64; 10] = [
        1.237_512_630_837_827_5,
        0.003_585_415_485_460_560_4,
        -0.108_803_930_141_347_57,
        -0.058_693_398_604_345_48,
        -0.009_746_579_394_903_797,
        0.000_293_715_648_275_434_8,
        5.159_721_510_942_362e-05,
        -1.123_163_149_023_460_7e-05,
        2.517_909_510_524_040_7e-06,
        -1.390_815_621_036_547_8e-07,
    ];
    const ODD: [f64; 10] = [
        -0.140_240_598_585_546_97,
        0.082_276_738_490_136_8,
        0.092_304_321_161_878_02,
        0.028_362_277_337_499_943,
        0.001_755_627_685_041_525_5,
        -0.000_290_169_119_753_864_2,
        2.236_119_723_926_818_7e-05,
        -3.795_464_071_233_723e-07,
        4.597_379_665_408_805_6e-07,
        -4.011_551_978_896_898_7e-08,
    ];
    let t = x.abs();
    let tail = gaussian * polynomial(&EVEN, &ODD, (t - 3.75) / (t + 3.75)) / (1.0 + 2.0 * t);
    if x < 0.0 { 2.0 - tail } else { tail }
}

/// The x up to which the share `u` of the density e^{-x²}/√π lies, if it is in the middle 99.8 % or
/// so: a polynomial in the logarithm of `4u (1 - u)` (Giles 2010, "Approximating the erfinv
/// Function").
#[inline]
pub(crate) fn quantile(u: f64) -> Option<f64> {
    const EVEN: [f64; 12] = [
        1.623_542_006_464_829_8,
        -0.005_738_135_221_005_968,
        0.000_195_061_324_413_727_99,
        -1.748_002_096_703_034_2e-06,
        -2.368_872_626_492_295e-08,
        1.110_797_423_203_730_5e-09,
        -1.732_853_873_192_883_5e-11,
        6.190_781_479_406_349e-15,
        6.339_002_394_406_591e-15,
        -1.625_473_280_796_84e-16,
        2.041_128_987_471_692_4e-18,
        -1.020_857_918_406_964_3e-20,
    ];
    const ODD: [f64; 12] = [
        0.241_630_404_166_158_27,
        -0.000_836_181_776_909_316_6,
        -1.271_642_263_872_058_5e-05,
        4.499_854_254_571_833_3e-07,
        -5.467_178_984_218_900_4e-09,
        -3.142_555_127_994_938_3e-11,
        2.698_965_230_909_083_7e-12,
        -5.292_972_044_721_015e-14,
        2.740_593_757_649_366_5e-16,
        1.287_440_443_846_505_8e-17,
        -3.916_147_418_354_864e-19,
        4.336_510_872_807_658_4e-21,
    ];
    let log = libm::log(4.0 * u * (1.0 - u));
    (log > -6.0).then(|| (2.0 * u - 1.0) * polynomial(&EVEN, &ODD, -log - 3.0))
}

/// A polynomial from its coefficients of even and of odd powers: two chains, which the processor
/// can follow at once.
#[inline]
fn polynomial(even: &[f64], odd: &[f64], x: f64) -> f64 {
    let square = x * x;
    let series =
        |coefficients: &[f64]| coefficients.iter().rev().fold(0.0, |sum, c| sum * square + c);
    series(even) + x * series(odd)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_error_function_is_that_of_libm() {
        for i in -6500..=6500 {
            let x = f64::from(i) / 1000.0;
            let found = complement(x, (-x * x).exp());
            // The Gaussian of a number that is rounded has lost digits.
            let lost = 2e-16 * x * x;
            assert_relative_eq!(found, libm::erfc(x), max_relative = 1e-15 + lost);
        }
    }

    #[test]
    fn quantiles_invert_it() {
        assert_eq!(quantile(0.5), Some(0.0));
        assert!(quantile(0.0).is_none() && quantile(1.0).is_none() && quantile(f64::NAN).is_none());
        for i in 1..10_000 {
            let u = f64::from(i) / 10_000.0;
            let Some(x) = quantile(u) else {
                assert!(!(0.001..0.999).contains(&u));
                continue;
            };
            assert_relative_eq!(0.5 * libm::erfc(-x), u, max_relative = 4e-15);
        }
    }
}
