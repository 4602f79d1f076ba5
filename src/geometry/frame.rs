//! Orthonormal frames.

use crate::lanes::{Lane, Vector};
use glam::DVec3;

/// A right-handed orthonormal frame: x = tangent, y = bitangent, z = normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First axis.
    pub x: DVec3,
    /// Second axis.
    pub y: DVec3,
    /// Third axis.
    pub z: DVec3,
}

impl Frame {
    /// Some frame around a unit normal (Duff et al. 2017, "Building an Orthonormal Basis,
    /// Revisited", listing 3).
    #[inline]
    #[must_use]
    pub fn from_normal(normal: DVec3) -> Self {
        let [x, y] = around(normal.into());
        Self { x: x.into(), y: y.into(), z: normal }
    }

    /// The frame around a unit normal whose x axis is the given tangent, made orthogonal; some
    /// frame if they are parallel.
    #[inline]
    #[must_use]
    pub fn from_normal_and_tangent(normal: DVec3, tangent: DVec3) -> Self {
        let x = tangent - normal * normal.dot(tangent);
        let length_squared = x.length_squared();
        if length_squared > 1e-12 * tangent.length_squared() {
            let x = x / length_squared.sqrt();
            Self { x, y: normal.cross(x), z: normal }
        } else {
            Self::from_normal(normal)
        }
    }

    /// World to local coordinates.
    #[inline]
    #[must_use]
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// Local to world coordinates.
    #[inline]
    #[must_use]
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// The x and y axes of [`Frame::from_normal`], in lanes.
#[inline(always)]
pub(crate) fn around<L: Lane>(normal: Vector<L>) -> [Vector<L>; 2] {
    let sign = normal.z.constant(1.0).copysign(normal.z);
    let a = normal.z.constant(-1.0) / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        Vector::new(sign * normal.x * normal.x * a + 1.0, sign * b, -sign * normal.x),
        Vector::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}
