//! Axis-aligned bounding boxes.

use glam::DVec3;

/// An axis-aligned box; empty if `min > max` in any component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: DVec3,
    /// Largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around some points.
    #[must_use]
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True if the box contains nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The middle of the box.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.min + 0.5 * (self.max - self.min)
    }

    /// Radius of the sphere around `center` that contains the box, 0 for an empty one.
    #[must_use]
    pub fn radius(&self) -> f64 {
        if self.is_empty() { 0.0 } else { 0.5 * (self.max - self.min).length() }
    }
}
