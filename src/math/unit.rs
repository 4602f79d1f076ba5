use glam::DVec3;

/// The unit vector of a direction of any length, however small or large: `None` if it is zero or not
/// finite.
#[inline]
pub(crate) fn unit(direction: DVec3) -> Option<DVec3> {
    if has_exact_length(direction) {
        return Some(direction.normalize());
    }
    let largest = direction.abs().max_element();
    (direction.is_finite() && largest > 0.0).then(|| (direction / largest).normalize())
}

/// True if the square of a vector's length neither overflows nor is so small that it loses digits,
/// so that `normalize` gives a unit vector.
#[inline]
pub(crate) fn has_exact_length(v: DVec3) -> bool {
    v.length_squared().is_normal()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_every_length_become_unit_vectors() {
        let direction = DVec3::new(2.0, -3.0, 6.0) / 7.0;
        for exponent in -1060..1020 {
            let scaled = direction * libm::exp2(f64::from(exponent));
            let unit = unit(scaled).expect("neither zero nor infinite");
            assert!(unit.is_normalized(), "2^{exponent}: {unit}");
            let digits = f64::EPSILON.max(2f64.powi(-1072 - exponent));
            assert!((unit - direction).length() < 4.0 * digits, "2^{exponent}: {unit}");
        }
        for bad in [DVec3::ZERO, DVec3::INFINITY, DVec3::NAN, DVec3::new(0.0, f64::NAN, 1.0)] {
            assert_eq!(unit(bad), None);
        }
    }
}
