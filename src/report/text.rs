//! The one way in which reports write numbers for people, on the page, in verdicts and in tables.
//! Files for programs (JSON, CSV) have all digits.

use super::stats::Interval;
use std::fmt;

/// Three significant digits, in scientific notation where it is shorter; `–` for NaN.
#[must_use]
pub fn number(x: f64) -> String {
    let size = x.abs();
    match size {
        _ if x.is_nan() => "–".to_owned(),
        _ if x.is_infinite() => if x > 0.0 { "∞" } else { "-∞" }.to_owned(),
        _ if size == 0.0 => "0".to_owned(),
        _ if !(0.001..100_000.0).contains(&size) => format!("{x:.2e}"),
        _ => format!("{x:.*}", (2 - exponent(size)).clamp(0, 6) as usize),
    }
}

/// [`number`] with its sign.
#[must_use]
pub fn signed(x: f64) -> String {
    let sign = if x > 0.0 { "+" } else { "" };
    format!("{sign}{}", number(x))
}

/// A share in per cent.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{} %", number(100.0 * share))
}

/// A number with its standard error, which has two significant digits; the number has as many
/// decimals.
#[must_use]
pub fn with_error(x: f64, error: f64) -> String {
    match 1 - exponent(error) {
        decimals @ 0..=7 if x.abs() < 1e5 => format!("{x:.0$} ± {error:.0$}", decimals as usize),
        _ => format!("{} ± {}", number(x), number(error)),
    }
}

/// A share with its sign and its standard error in per cent.
#[must_use]
pub fn percent_with_error(share: f64, error: f64) -> String {
    let sign = if share > 0.0 { "+" } else { "" };
    format!("{sign}{} %", with_error(100.0 * share, 100.0 * error))
}

/// The power of ten of the first digit; 0 for what has none.
fn exponent(x: f64) -> i32 {
    if x == 0.0 || !x.is_finite() { 0 } else { x.abs().log10().floor() as i32 }
}

/// The value with the interval in brackets, if there is one.
impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { value, low, high } = *self;
        match low < high {
            true => write!(f, "{} ({} … {})", number(value), number(low), number(high)),
            false => f.write_str(&number(value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_and_errors_two() {
        let numbers = [0.0, 1.0, -0.012_345, 12_345.6, 1e5, 9.87e-4, f64::NEG_INFINITY, f64::NAN];
        assert_eq!(
            numbers.map(number),
            ["0", "1.00", "-0.0123", "12346", "1.00e5", "9.87e-4", "-∞", "–"]
        );
        assert_eq!([signed(2.0), signed(-2.0), percent(0.5)], ["+2.00", "-2.00", "50.0 %"]);
        assert_eq!(with_error(0.158_262_3, 2.1e-5), "0.158262 ± 0.000021");
        assert_eq!(with_error(1234.5, 321.0), "1234 ± 321");
        assert_eq!(with_error(3e-7, 2e-9), "3.00e-7 ± 2.00e-9");
        assert_eq!(percent_with_error(0.0102, 0.0005), "+1.020 ± 0.050 %");
        let interval = Interval { value: 2.0, low: 1.5, high: f64::INFINITY };
        assert_eq!(interval.to_string(), "2.00 (1.50 … ∞)");
        assert_eq!(Interval { low: f64::NAN, ..interval }.to_string(), "2.00");
    }
}
