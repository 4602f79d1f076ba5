//! Slopes, and when a curve comes down to a value.

/// Weighted least-squares slope of y over x (points `[x, y, weight]`); `None` without two different
/// x.
#[must_use]
pub fn slope(points: &[[f64; 3]]) -> Option<f64> {
    let weight: f64 = points.iter().map(|p| p[2]).sum();
    let mean = |k: usize| points.iter().map(|p| p[2] * p[k]).sum::<f64>() / weight;
    let (x, y) = (mean(0), mean(1));
    let xx: f64 = points.iter().map(|p| p[2] * (p[0] - x).powi(2)).sum();
    let xy: f64 = points.iter().map(|p| p[2] * (p[0] - x) * (p[1] - y)).sum();
    let slope = xy / xx;
    (xx > 0.0 && slope.is_finite()).then_some(slope)
}

/// The time from which on a curve of (time, error) stays below `target`: the crossing after which
/// no point is above it, by interpolation in log-log. `Err` if its last point is above, with the
/// time at which it would get there if it went on falling as 1/t.
#[must_use = "says when the error is reached"]
pub fn time_to_error(curve: &[(f64, f64)], target: f64) -> Result<f64, Option<f64>> {
    let Some(above) = curve.iter().rposition(|(_, error)| error.is_nan() || *error > target) else {
        return curve.first().map(|(time, _)| *time).ok_or(None);
    };
    let (before, error) = curve[above];
    match curve.get(above + 1) {
        // An error from which that of the reference was subtracted may be negative, and one of an
        // image with a NaN is infinite.
        Some(&(time, reached)) if reached > 0.0 && error.is_finite() && before > 0.0 => {
            let part = (error / target).ln() / (error / reached).ln();
            Ok(before * (time / before).powf(part))
        }
        Some((time, _)) => Ok(*time),
        None => Err(Some(before * error / target).filter(|time| time.is_finite())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_of_a_power_law() {
        let points: Vec<[f64; 3]> =
            (1..6).map(|i| [f64::from(i), 3.0 - 0.75 * f64::from(i), f64::from(i)]).collect();
        assert!((slope(&points).unwrap() + 0.75).abs() < 1e-12);
        assert!(slope(&points[..1]).is_none());
    }

    #[test]
    fn time_to_an_error() {
        let curve = [(1.0, 1.0), (2.0, 0.5), (4.0, 0.25)];
        assert!((time_to_error(&curve, 0.4).unwrap() - 2.5).abs() < 1e-12);
        assert!((time_to_error(&curve, 0.1).unwrap_err().unwrap() - 10.0).abs() < 1e-12);
        assert_eq!(time_to_error(&curve, 2.0), Ok(1.0));
        assert_eq!(time_to_error(&[], 2.0), Err(None));
        // A curve that rises again has not reached it before.
        assert!(
            (time_to_error(&[(1.0, 0.1), (2.0, 1.0), (4.0, 0.25)], 0.5).unwrap() - 8f64.sqrt())
                .abs()
                < 1e-12
        );
        assert_eq!(time_to_error(&[(1.0, 1.0), (2.0, -0.1)], 0.5), Ok(2.0));
        assert_eq!(time_to_error(&[(1.0, f64::INFINITY), (2.0, 0.1)], 0.5), Ok(2.0));
        assert_eq!(time_to_error(&[(1.0, 0.1), (2.0, f64::INFINITY)], 0.5), Err(None));
    }
}
