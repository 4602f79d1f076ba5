//! Linear RGB, the spectrum of this crate: radiance, albedo, throughput and film sums.

use std::ops::{Add, AddAssign, Div, Index, Mul, MulAssign, Neg, Sub};

/// Three linear-light components, red, green and blue with the sRGB primaries.
///
/// The unit is that of what it describes: radiance (W/(m² sr)), a reflectance (1), a BSDF value
/// (1/sr) or a throughput.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb(pub [f64; 3]);

impl Rgb {
    /// (0, 0, 0).
    pub const BLACK: Self = Self([0.0; 3]);
    /// (1, 1, 1).
    pub const WHITE: Self = Self([1.0; 3]);

    /// A colour of red, green and blue.
    #[inline]
    #[must_use]
    pub const fn new(red: f64, green: f64, blue: f64) -> Self {
        Self([red, green, blue])
    }

    /// The same value in all three components.
    #[inline]
    #[must_use]
    pub const fn splat(value: f64) -> Self {
        Self([value; 3])
    }

    /// Red.
    #[inline]
    #[must_use]
    pub const fn r(self) -> f64 {
        self.0[0]
    }

    /// Green.
    #[inline]
    #[must_use]
    pub const fn g(self) -> f64 {
        self.0[1]
    }

    /// Blue.
    #[inline]
    #[must_use]
    pub const fn b(self) -> f64 {
        self.0[2]
    }

    /// Relative luminance with the weights of ITU-R BT.709.
    #[inline]
    #[must_use]
    pub fn luminance(self) -> f64 {
        0.2126 * self.0[0] + 0.7152 * self.0[1] + 0.0722 * self.0[2]
    }

    /// The arithmetic mean of the components.
    #[inline]
    #[must_use]
    pub fn mean(self) -> f64 {
        (self.0[0] + self.0[1] + self.0[2]) / 3.0
    }

    /// The largest component.
    #[inline]
    #[must_use]
    pub fn max_component(self) -> f64 {
        self.0[0].max(self.0[1]).max(self.0[2])
    }

    /// True if all components are exactly 0.
    #[inline]
    #[must_use]
    pub fn is_black(self) -> bool {
        self.0 == [0.0; 3]
    }

    /// True if no component is infinite or not a number.
    #[inline]
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|c| c.is_finite())
    }

    /// Applies a function to each component.
    #[inline]
    #[must_use]
    pub fn map(self, f: impl FnMut(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    #[inline]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1]), f(self.0[2], other.0[2])])
    }
}

/// The same value in all three components, as [`Rgb::splat`].
impl From<f64> for Rgb {
    #[inline]
    fn from(value: f64) -> Self {
        Self::splat(value)
    }
}

impl From<[f64; 3]> for Rgb {
    fn from(components: [f64; 3]) -> Self {
        Self(components)
    }
}

impl From<Rgb> for [f64; 3] {
    fn from(rgb: Rgb) -> Self {
        rgb.0
    }
}

impl Index<usize> for Rgb {
    type Output = f64;
    #[inline]
    fn index(&self, channel: usize) -> &f64 {
        &self.0[channel]
    }
}

impl Add for Rgb {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Rgb {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Mul<f64> for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        self.map(|c| c * factor)
    }
}

impl Mul<Rgb> for f64 {
    type Output = Rgb;
    #[inline]
    fn mul(self, rgb: Rgb) -> Rgb {
        rgb * self
    }
}

impl Div<f64> for Rgb {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        self.map(|c| c / divisor)
    }
}

impl Neg for Rgb {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.map(|c| -c)
    }
}

impl AddAssign for Rgb {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl MulAssign for Rgb {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl MulAssign<f64> for Rgb {
    #[inline]
    fn mul_assign(&mut self, factor: f64) {
        *self = *self * factor;
    }
}

impl std::iter::Sum for Rgb {
    fn sum<I: Iterator<Item = Self>>(values: I) -> Self {
        values.fold(Self::BLACK, Add::add)
    }
}
