//! Vectors in lanes.

use super::{Lane, Mask};
use glam::DVec3;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A vector, or several side by side. Sums have the order of `DVec3`'s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vector<L> {
    pub x: L,
    pub y: L,
    pub z: L,
}

impl<L: Lane> Vector<L> {
    #[inline(always)]
    pub fn new(x: L, y: L, z: L) -> Self {
        Self { x, y, z }
    }

    /// The same vector in all lanes, as many as those of `like`.
    #[inline(always)]
    pub fn constant(v: DVec3, like: L) -> Self {
        Self::new(like.constant(v.x), like.constant(v.y), like.constant(v.z))
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The dot product with one vector.
    #[inline(always)]
    pub fn dot_with(self, other: DVec3) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn length_squared(self) -> L {
        self.dot(self)
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// The first vectors where true, the others where false.
    #[inline(always)]
    pub fn choose(mask: L::Mask, yes: Self, no: Self) -> Self {
        Self::new(mask.choose(yes.x, no.x), mask.choose(yes.y, no.y), mask.choose(yes.z, no.z))
    }

    #[inline(always)]
    pub fn max_element(self) -> L {
        self.x.greater(self.y.greater(self.z))
    }
}

impl From<DVec3> for Vector<f64> {
    #[inline(always)]
    fn from(v: DVec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl From<Vector<f64>> for DVec3 {
    #[inline(always)]
    fn from(v: Vector<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<L: Lane> Neg for Vector<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<L: Lane> Add for Vector<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<L: Lane> Sub for Vector<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<L: Lane> Mul<L> for Vector<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: L) -> Self {
        Self::new(self.x * scale, self.y * scale, self.z * scale)
    }
}

/// Component by component, as for colours.
impl<L: Lane> Mul for Vector<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::new(self.x * other.x, self.y * other.y, self.z * other.z)
    }
}

impl<L: Lane> Div<L> for Vector<L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, scale: L) -> Self {
        Self::new(self.x / scale, self.y / scale, self.z / scale)
    }
}
