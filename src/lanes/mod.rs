//! Numbers in lanes: the type that a formula is generic over, so that it is written once and gives
//! the same bits for one path and for eight.
//!
//! [`Lane`] is implemented by `f64` and by eight `f64` of an instruction set. All its operations
//! are those of IEEE 754 that are rounded correctly, none fuses a product and a sum, and choices
//! are made between numbers and not by branches.

mod level;
mod rows;
mod vector;

#[cfg(target_arch = "x86_64")]
pub(crate) use level::vectorized;
pub(crate) use level::{dispatch, level};
pub(crate) use rows::{Group, Rows, load, splat, splat_halves, store};
pub(crate) use vector::Vector;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Numbers of an `f64x8`.
pub(crate) const LANES: usize = 8;

/// A number, or several side by side.
pub(crate) trait Lane:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// Truths in the same number of lanes.
    type Mask: Mask<Self>;

    /// A number in all lanes, as many as these.
    fn constant(self, x: f64) -> Self;
    /// Square roots.
    fn sqrt(self) -> Self;
    /// Absolute values.
    fn abs(self) -> Self;
    /// Absolute values with the signs of others.
    fn copysign(self, sign: Self) -> Self;
    /// True where these are less; false where one is not a number.
    fn less(self, than: Self) -> Self::Mask;
    /// True where both are the same.
    fn equals(self, other: Self) -> Self::Mask;

    /// True where these are more.
    #[inline(always)]
    fn more(self, than: Self) -> Self::Mask {
        than.less(self)
    }

    /// True where these are above 0.
    #[inline(always)]
    fn is_positive(self) -> Self::Mask {
        self.more(self.constant(0.0))
    }

    /// True where these are below 0.
    #[inline(always)]
    fn is_negative(self) -> Self::Mask {
        self.less(self.constant(0.0))
    }

    /// The greater ones; the others where one is not a number.
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        self.more(other).choose(self, other)
    }
}

/// A truth, or several side by side.
pub(crate) trait Mask<L>:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// The first numbers where true, the others where false.
    fn choose(self, yes: L, no: L) -> L;
    /// True if all are.
    fn all(self) -> bool;
    /// 1 where true, 0 where false.
    #[inline(always)]
    fn indicator(self, like: L) -> L
    where
        L: Lane<Mask = Self>,
    {
        self.choose(like.constant(1.0), like.constant(0.0))
    }
}

impl Mask<f64> for bool {
    #[inline(always)]
    fn choose(self, yes: f64, no: f64) -> f64 {
        if self { yes } else { no }
    }

    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

impl<S: Simd> Mask<f64x8<S>> for mask64x8<S> {
    #[inline(always)]
    fn choose(self, yes: f64x8<S>, no: f64x8<S>) -> f64x8<S> {
        Select::select(self, yes, no)
    }

    #[inline(always)]
    fn all(self) -> bool {
        self.all_true()
    }
}

impl Lane for f64 {
    type Mask = bool;

    #[inline(always)]
    fn constant(self, x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        f64::copysign(self, sign)
    }
    #[inline(always)]
    fn less(self, than: Self) -> bool {
        self < than
    }
    #[inline(always)]
    fn equals(self, other: Self) -> bool {
        self == other
    }
}

impl<S: Simd> Lane for f64x8<S> {
    type Mask = mask64x8<S>;

    #[inline(always)]
    fn constant(self, x: f64) -> Self {
        SimdBase::splat(self.simd, x)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        SimdFloat::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.simd.abs_f64x8(self)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        SimdFloat::copysign(self, sign)
    }
    #[inline(always)]
    fn less(self, than: Self) -> mask64x8<S> {
        self.simd_lt(than)
    }
    #[inline(always)]
    fn equals(self, other: Self) -> mask64x8<S> {
        self.simd_eq(other)
    }
}
