//! The spherical triangle: what a receiver sees of a triangle, sampled uniformly by solid angle.
//!
//! The map is that of Arvo 1995 ("Stratified Sampling of Spherical Triangles"): u selects the end X
//! of an arc from the apex b to the opposite side ac, such that the triangle (a, b, X) has the share
//! u of the solid angle; v a point of the arc, uniform in the cosine of its angle to b. As in Peters
//! 2021 ("BRDF Importance Sampling for Polygonal Lights"), X follows from a condition linear in
//! a + X instead of from the angles of the triangle. It is the formula of Van Oosterom and Strackee
//! 1983,
//!
//! ```text
//! tan(ω/2) = det(a, b, X) / (1 + a·b + b·X + X·a),   1 + X·a = a·(a + X)
//! det(a, b, a + X) cos(ω/2) = (a + b)·(a + X) sin(ω/2)
//! ```
//!
//! The direction is found as a combination of the corners, and so are the barycentric coordinates
//! of the point: no ray is met with the plane, from which it would have few digits at grazing
//! angles.

use crate::math::angle::{atan2, sin_cos_of_turn};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The sine and cosine of a solid angle's half, but for a factor, mean nothing if they sum up to
/// less: directions have errors of 1e-16. It is so next to an edge, and everywhere along slivers.
const LEAST_SUM: f64 = 1e-10;

/// See the module's documentation.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalTriangle {
    /// The number of the corner a; b and c follow in cyclic order.
    first: usize,
    /// Directions to a, b and c.
    directions: [DVec3; 3],
    /// Distances of a, b and c.
    distances: [f64; 3],
    /// det(a, b, c).
    volume: f64,
    solid_angle: f64,
}

impl SphericalTriangle {
    /// The triangle whose corners are at these offsets from the receiver. `volume` is the absolute
    /// value of their determinant. `None` if rounding would decide about the solid angle.
    pub(super) fn new(corners: [DVec3; 3], volume: f64) -> Option<Self> {
        let distances = corners.map(DVec3::length);
        let at = |i: usize| corners[i] / distances[i];
        let (a, b, c) = (at(0), at(1), at(2));
        // The side opposite to the apex is the shortest, so that no sum of its ends cancels.
        let (ab, bc, ca) = (a.dot(b), b.dot(c), c.dot(a));
        let (first, directions) = if ca >= ab && ca >= bc {
            (0, [a, b, c])
        } else if ab >= bc {
            (1, [b, c, a])
        } else {
            (2, [c, a, b])
        };
        let volume = volume / distances.iter().product::<f64>();
        let sum = directions[0] + directions[1];
        let denominator = 1.0 + directions[0].dot(directions[1]) + sum.dot(directions[2]);
        (volume + denominator.abs() > LEAST_SUM).then(|| Self {
            first,
            directions,
            distances: [0, 1, 2].map(|i| distances[(first + i) % 3]),
            volume,
            solid_angle: 2.0 * atan2(volume, denominator),
        })
    }

    /// The solid angle.
    pub(super) fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// The barycentric coordinates of the point seen in a direction uniform in the solid angle.
    pub(super) fn sample(&self, u: DVec2) -> [f64; 3] {
        let [a, b, c] = self.directions;
        let (sin, cos) = sin_cos_of_turn(u.x * self.solid_angle / (4.0 * PI));
        // a + X = alpha a + gamma c, but for a factor.
        let alpha = self.volume * cos - (a + b).dot(c) * sin;
        let gamma = (1.0 + a.dot(b)) * sin;
        let ca = c.dot(a);
        let factor =
            2.0 * (alpha + gamma * ca) / (alpha * alpha + gamma * (gamma + 2.0 * alpha * ca));
        let (xa, xc) = (factor * alpha - 1.0, factor * gamma);
        let x = a * xa + c * xc;
        // 1 - cosine and 1 + cosine of the arc, and 1 - cosine of its part up to the point.
        let arc = 0.5 * (x - b).length_squared();
        let rest = 0.5 * (x + b).length_squared();
        let part = u.y * arc;
        let squares = part * (rest + (1.0 - u.y) * arc) / (arc * rest).max(f64::MIN_POSITIVE);
        let stretch = squares.sqrt();
        let weights = [stretch * xa, (1.0 - part) - stretch * (1.0 - arc), stretch * xc];
        let mut barycentric = [0.0; 3];
        for i in 0..3 {
            barycentric[(self.first + i) % 3] = weights[i].max(0.0) / self.distances[i];
        }
        let total: f64 = barycentric.iter().sum();
        barycentric.map(|b| b / total)
    }
}
