//! Sines, cosines and angles from polynomials, without branches and the same on every platform.
//!
//! Errors are about those of the standard library. It costs more: its functions are calls that also
//! serve huge angles, infinities and subnormal numbers.

use crate::lanes::Lane;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Sine and cosine of an angle in [-π/4, π/4] by their series, whose next terms are below 5e-17.
#[inline(always)]
pub(crate) fn sin_cos_of_octant<L: Lane>(angle: L) -> (L, L) {
    const SINE: [f64; 8] = inverse_factorials(1);
    const COSINE: [f64; 8] = inverse_factorials(2);
    let y = -angle * angle;
    let series = |coefficients: &[f64; 8]| {
        coefficients.iter().rev().fold(angle.constant(0.0), |sum, c| sum * y + *c)
    };
    (angle * series(&SINE), y * series(&COSINE) + 1.0)
}

/// `1 / n!` of every other number from `first` on.
const fn inverse_factorials(first: u32) -> [f64; 8] {
    let mut result = [0.0; 8];
    let (mut n, mut factorial, mut k) = (1, 1.0, 0);
    while k < 8 {
        while n < first + 2 * k {
            n += 1;
            factorial *= n as f64;
        }
        result[k as usize] = 1.0 / factorial;
        k += 1;
    }
    result
}

/// Sine and cosine of `2π turn`.
#[inline]
pub(crate) fn sin_cos_of_turn(turn: f64) -> (f64, f64) {
    // Adding it leaves no bits for a fraction: the sum is rounded to an integer, which its lowest
    // bits show.
    const ROUNDING: f64 = 1.5 / f64::EPSILON;
    let rounded = 4.0 * turn + ROUNDING;
    let quarter = rounded.to_bits();
    let (sin, cos) = sin_cos_of_octant(TAU * (turn - 0.25 * (rounded - ROUNDING)));
    let (y, x) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let negate_if = |bit: u64, v: f64| f64::from_bits(v.to_bits() ^ ((bit & 2) << 62));
    (negate_if(quarter, y), negate_if(quarter + 1, x))
}

/// `atan2(y, x)`, in [-π, π]; 0 or ±π at the origin.
#[inline]
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    const TAN_PI_8: f64 = std::f64::consts::SQRT_2 - 1.0;
    let (a, b) = (y.abs(), x.abs());
    let (small, large) = if a > b { (b, a) } else { (a, b) };
    // From π/8 on the difference to π/4, whose tangent is that small too.
    let is_far = small > TAN_PI_8 * large;
    let (numerator, denominator, base) =
        if is_far { (small - large, small + large, FRAC_PI_4) } else { (small, large, 0.0) };
    let octant = base + small_arctangent(numerator / denominator.max(f64::MIN_POSITIVE));
    let quadrant = if a > b { FRAC_PI_2 - octant } else { octant };
    (if x.is_sign_negative() { PI - quadrant } else { quadrant }).copysign(y)
}

/// `atan2(y, x) / 2π` in [0, 1].
#[inline]
pub(crate) fn turn(y: f64, x: f64) -> f64 {
    let turn = 0.5 * FRAC_1_PI * atan2(y, x);
    if turn < 0.0 { turn + 1.0 } else { turn }
}

/// The arctangent of a number up to tan(π/8) in size.
#[inline]
fn small_arctangent(t: f64) -> f64 {
    /// `(atan(√v)/√v - 1)/v` interpolated at the Chebyshev nodes of [0, tan²(π/8)]; the
    /// arctangent's relative error is below 8e-18.
    const ODD: [f64; 6] = [
        -0.333_333_333_333_333_3,
        -0.142_857_142_846_665_42,
        -0.090_909_045_781_239_03,
        -0.066_645_114_473_819_48,
        -0.050_854_497_379_402_6,
        -0.019_176_887_119_062_26,
    ];
    const EVEN: [f64; 5] = [
        0.199_999_999_999_955_2,
        0.111_111_110_152_563_61,
        0.076_921_831_908_270_86,
        0.058_581_489_128_022_1,
        0.039_231_658_295_587_19,
    ];
    let v = t * t;
    let v2 = v * v;
    // Two chains, which the processor can follow at once.
    let series = |coefficients: &[f64]| coefficients.iter().rev().fold(0.0, |sum, c| sum * v2 + c);
    t + t * v * (series(&ODD) + v * series(&EVEN))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    #[test]
    fn sine_and_cosine_are_those_of_the_standard_library() {
        for i in -1000..=1000 {
            let angle = FRAC_PI_4 * f64::from(i) / 1000.0;
            let (sin, cos) = sin_cos_of_octant(angle);
            assert_relative_eq!(sin, angle.sin(), max_relative = 5e-16);
            assert_relative_eq!(cos, angle.cos(), max_relative = 5e-16);
        }
        for i in -4000..=4000 {
            let turn = f64::from(i) / 1000.0;
            let (sin, cos) = sin_cos_of_turn(turn);
            let expected = (TAU * turn).sin_cos();
            assert_abs_diff_eq!(sin, expected.0, epsilon = 4e-15);
            assert_abs_diff_eq!(cos, expected.1, epsilon = 4e-15);
        }
        assert_eq!(
            [0.0, 0.25, 0.5, 0.75, 1.0].map(sin_cos_of_turn),
            [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)]
        );
        assert!(sin_cos_of_turn(f64::NAN).0.is_nan());
    }

    #[test]
    fn angles_are_those_of_the_standard_library() {
        for i in -20_000..=20_000 {
            let angle = PI * f64::from(i) / 20_000.0;
            for radius in [1.0, 1e-150, 1e150] {
                let (y, x) = (radius * angle.sin(), radius * angle.cos());
                assert_relative_eq!(atan2(y, x), y.atan2(x), max_relative = 5e-16);
                assert!((0.0..=1.0).contains(&turn(y, x)));
            }
        }
        for exponent in -320..300 {
            let small = 10f64.powi(exponent);
            for (y, x) in [
                (small, 1.0),
                (-small, 1.0),
                (small, -1.0),
                (-small, -1.0),
                (1.0, small),
                (1.0, -small),
                (-1.0, -small),
            ] {
                assert_relative_eq!(atan2(y, x), y.atan2(x), max_relative = 5e-16);
            }
        }
        for (y, x) in [
            (0.0, 0.0),
            (0.0, -0.0),
            (-0.0, -0.0),
            (-0.0, 0.0),
            (0.0, -1.0),
            (-0.0, -1.0),
            (1.0, 0.0),
            (1.0, 1.0),
            (1.0, -1.0),
        ] {
            assert_eq!(atan2(y, x).to_bits(), f64::atan2(y, x).to_bits(), "{y} {x}");
        }
        assert!(atan2(f64::NAN, 1.0).is_nan() && atan2(1.0, f64::NAN).is_nan());
    }
}
