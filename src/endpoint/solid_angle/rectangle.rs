//! The spherical rectangle: what a receiver sees of a quad with perpendicular edges, sampled
//! uniformly by solid angle.
//!
//! The map is that of Ureña, Fajardo and King 2013 ("An Area-Preserving Parametrization for
//! Spherical Rectangles"): u selects a column x such that the part of the rectangle before it has
//! the share u of the solid angle, v a point of the column uniform in the sine of the elevation
//! above y = 0. It is derived here in a form without inverse functions in a sample.
//!
//! In coordinates of the rectangle around the receiver's foot, at height h, the solid angle between
//! x = 0 and x is
//!
//! ```text
//! T(x) = a_1(x) - a_0(x),   tan a_j = x y_j / (h √(x² + y_j² + h²))
//! ```
//!
//! `sin a_j = s y_j / ρ_j` with `s = x / √(x² + h²)` and `ρ_j = √(y_j² + h²)`, so the ratio of the
//! two sines is constant and T can be solved for s. With `C = lim cos T(x) for x → ∞ = (y_0 y_1 +
//! h²) / (ρ_0 ρ_1)` and `Q = cos T - C` the column is
//!
//! ```text
//! x = h sin T / √(Q (Q + 2 h² / (ρ_0 ρ_1)))
//! ```

use super::unit_interval;
use crate::geometry::{Quad, SurfacePoint};
use crate::math::angle::{atan2, sin_cos_of_turn};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Edges are perpendicular if the cosine between them is no more than this.
const PERPENDICULAR: f64 = 8.0 * f64::EPSILON;

/// See the module's documentation.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalRectangle<'s> {
    quad: &'s Quad,
    /// Lower bounds of x and y.
    start: DVec2,
    /// Lengths of the edges.
    size: DVec2,
    /// The receiver's distance from the plane.
    height: f64,
    /// T at the lower bound of x.
    first: f64,
    solid_angle: f64,
}

impl<'s> SphericalRectangle<'s> {
    /// A quad whose origin is at this offset from the receiver; `None` unless its edges are
    /// perpendicular.
    pub(super) fn new(quad: &'s Quad, origin: DVec3) -> Option<Self> {
        let size = DVec2::new(quad.edge_u.length(), quad.edge_v.length());
        let (x_axis, y_axis) = (quad.edge_u / size.x, quad.edge_v / size.y);
        if x_axis.dot(y_axis).abs() > PERPENDICULAR {
            return None;
        }
        let height = origin.dot(x_axis.cross(y_axis)).abs();
        let start = DVec2::new(origin.dot(x_axis), origin.dot(y_axis));
        let (y0, y1) = (start.y, start.y + size.y);
        let h2 = height * height;
        let turn = |x: f64| {
            let d2 = x * x + h2;
            let (r0, r1) = ((d2 + y0 * y0).sqrt(), (d2 + y1 * y1).sqrt());
            atan2(x * height * (y1 * r0 - y0 * r1), h2 * r0 * r1 + x * x * y0 * y1)
        };
        let first = turn(start.x);
        let solid_angle = turn(start.x + size.x) - first;
        Some(Self { quad, start, size, height, first, solid_angle })
    }

    /// The solid angle.
    pub(super) fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// The point seen in a direction uniform in the solid angle.
    pub(super) fn sample(&self, u: DVec2) -> SurfacePoint {
        let x = self.column(u.x).max(self.start.x).min(self.start.x + self.size.x);
        let p = (DVec2::new(x, self.row(x, u.y)) - self.start) / self.size;
        self.quad.point_at(unit_interval(p.x), unit_interval(p.y))
    }

    /// The x before which the share `u` of the solid angle lies.
    fn column(&self, u: f64) -> f64 {
        let [y0, y1] = [self.start.y, self.start.y + self.size.y];
        let h2 = self.height * self.height;
        let scale = 1.0 / ((y0 * y0 + h2) * (y1 * y1 + h2)).sqrt();
        // Sine and cosine of the limit of T.
        let (sin, cos) = (self.height * self.size.y * scale, (y0 * y1 + h2) * scale);
        let (sin_half, cos_half) =
            sin_cos_of_turn((self.first + u * self.solid_angle) / (4.0 * PI));
        // cos T - C, by the squares of halves of the smaller or of the larger angles.
        let q = if cos > 0.0 {
            sin * sin / (1.0 + cos) - 2.0 * sin_half * sin_half
        } else {
            2.0 * cos_half * cos_half - sin * sin / (1.0 - cos)
        };
        // Rounding may put the end beyond infinity.
        let q = q.max(0.0);
        self.height * 2.0 * sin_half * cos_half / (q * (q + 2.0 * h2 * scale)).sqrt()
    }

    /// The y of the column at `x` below which the share `v` of the column's solid angle lies.
    fn row(&self, x: f64, v: f64) -> f64 {
        let [y0, y1] = [self.start.y, self.start.y + self.size.y];
        let d2 = x * x + self.height * self.height;
        let elevation_sine = |y: f64| y / (d2 + y * y).sqrt();
        let (s0, s1) = (elevation_sine(y0), elevation_sine(y1));
        let s = s0 + v * (s1 - s0);
        s * (d2 / ((1.0 - s).max(0.0) * (1.0 + s))).sqrt()
    }
}
