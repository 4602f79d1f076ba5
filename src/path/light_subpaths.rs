//! The number of light subpaths that a sample has.

/// The number of light subpaths per camera subpath: a power of two, 1 unless said otherwise.
///
/// Each of 2ⁿ ≥ 1 light subpaths is connected to the one camera subpath and to the lens. With 2ⁿ <
/// 1 a sample has a light subpath with that probability.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightSubpaths(i8);

impl LightSubpaths {
    /// One light subpath for each camera subpath.
    pub const ONE: Self = Self(0);
    /// The largest exponent, and minus the smallest.
    pub const LARGEST_EXPONENT: i8 = 16;

    /// `2^exponent` light subpaths; `None` if that is not between 2⁻¹⁶ and 2¹⁶.
    #[must_use]
    pub const fn power_of_two(exponent: i8) -> Option<Self> {
        if exponent.unsigned_abs() <= Self::LARGEST_EXPONENT.unsigned_abs() {
            Some(Self(exponent))
        } else {
            None
        }
    }

    /// Twice as many, if that is not too many.
    #[must_use]
    pub const fn doubled(self) -> Option<Self> {
        Self::power_of_two(self.0.saturating_add(1))
    }

    /// Half as many, if that is not too few.
    #[must_use]
    pub const fn halved(self) -> Option<Self> {
        Self::power_of_two(self.0.saturating_sub(1))
    }

    /// The expected number.
    #[inline]
    #[must_use]
    pub const fn count(self) -> f64 {
        // The bits of a power of two: an exponent alone.
        f64::from_bits(((1023 + self.0 as i64) as u64) << 52)
    }

    /// The number in one sample; draws `xi` only if that is random.
    #[inline]
    #[must_use]
    pub fn draw(self, xi: impl FnOnce() -> f64) -> u32 {
        if self.0 >= 0 { 1 << self.0 } else { u32::from(xi() < self.count()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_powers_of_two() {
        for exponent in -16..=16i8 {
            let walks = LightSubpaths::power_of_two(exponent).unwrap();
            assert_eq!(walks.count(), 2f64.powi(i32::from(exponent)));
            if exponent >= 0 {
                assert_eq!(
                    f64::from(walks.draw(|| unreachable!("nothing is random"))),
                    walks.count()
                );
            } else {
                assert_eq!(
                    (walks.draw(|| walks.count()), walks.draw(|| 0.99 * walks.count())),
                    (0, 1)
                );
            }
        }
        assert_eq!(LightSubpaths::default().count(), 1.0);
        assert!(
            LightSubpaths::power_of_two(17).is_none()
                && LightSubpaths::power_of_two(-17).is_none()
                && LightSubpaths::power_of_two(-128).is_none()
        );
    }
}
