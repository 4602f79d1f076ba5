//! The geometry term of the path integral, without visibility.
//!
//! ```text
//! G(a, b) = |cos θ_a cos θ_b| / |a - b|²        (Veach 1997, equation 8.2)
//! ```
//!
//! with geometric normals. Generalised to every [`Place`]: a Dirac position has no surface and no
//! cosine; a point at infinity has neither cosine nor distance, because its density is per solid
//! angle and its "direction" density per area perpendicular to the ray.

use crate::geometry::{Place, SurfacePoint};
use crate::lanes::{Lane, Vector};
use glam::DVec3;

/// Above it squares have lost nothing to underflow, not even those of components that are a
/// millionth of the largest.
const LEAST_SQUARE: f64 = 1e-270;

/// The straight line between two vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Unit direction from the first vertex to the second.
    pub direction: DVec3,
    /// The geometry term without visibility, in the product of the inverse measures of the two
    /// vertices' places.
    pub geometry: f64,
}

impl Edge {
    /// The edge between two points; `None` if they coincide or both are at infinity, where no
    /// direction exists.
    #[inline]
    #[must_use]
    pub fn between(a: &SurfacePoint, b: &SurfacePoint) -> Option<Self> {
        let direction = match (a.place, b.place) {
            (Place::Infinite, Place::Infinite) => return None,
            (Place::Infinite, _) => a.geometric_normal,
            (_, Place::Infinite) => -b.geometric_normal,
            _ => {
                let difference = b.position - a.position;
                let (direction, is_exact) = unit::<f64>(difference.into());
                if is_exact {
                    direction.into()
                } else {
                    // Scaled by the largest component, so that the square neither overflows nor
                    // underflows.
                    let scale = difference.abs().max_element();
                    if !(scale > 0.0 && scale.is_finite()) {
                        return None;
                    }
                    (difference / scale).normalize()
                }
            }
        };
        Some(Self::along(a, b, direction))
    }

    /// The edge between two points whose unit direction is known, as when it was sampled.
    #[inline]
    #[must_use]
    pub fn along(a: &SurfacePoint, b: &SurfacePoint, direction: DVec3) -> Self {
        // ANCHOR: geometry
        let cosines = a.cosine(direction) * b.cosine(direction);
        let geometry = if a.place == Place::Infinite || b.place == Place::Infinite {
            cosines
        } else {
            let distance = (b.position - a.position).dot(direction);
            // Else two divisions: the square of a distance can leave the range of f64 where the
            // quotient does not.
            let (geometry, is_exact) = over_square(cosines, distance);
            if is_exact { geometry } else { cosines / distance / distance }
        };
        Self { direction, geometry }
        // ANCHOR_END: geometry
    }
}

/// The vectors made unit length, and where that is exact because their squares have kept their
/// digits.
#[inline(always)]
fn unit<L: Lane>(difference: Vector<L>) -> (Vector<L>, L::Mask) {
    let square = difference.length_squared();
    (difference / square.sqrt(), is_safe(square))
}

/// Cosines over the square of a distance, and where that is exact.
#[inline(always)]
fn over_square<L: Lane>(cosines: L, distance: L) -> (L, L::Mask) {
    let square = distance * distance;
    (cosines / square, is_safe(square))
}

#[inline(always)]
fn is_safe<L: Lane>(square: L) -> L::Mask {
    square.more(square.constant(LEAST_SQUARE)) & square.less(square.constant(f64::INFINITY))
}

/// [`Edge::between`] points that are not at infinity, in lanes, given their cosines for the
/// directions: directions and geometry terms, and where they are exact.
#[inline(always)]
pub(super) fn between<L: Lane>(
    a: Vector<L>,
    b: Vector<L>,
    cosines: impl FnOnce(Vector<L>) -> L,
) -> (Vector<L>, L, L::Mask) {
    let difference = b - a;
    let (direction, is_unit) = unit(difference);
    let (geometry, is_exact) = over_square(cosines(direction), difference.dot(direction));
    (direction, geometry, is_unit & is_exact)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn point(x: f64, y: f64, z: f64, normal: DVec3) -> SurfacePoint {
        SurfacePoint::on_surface(DVec3::new(x, y, z), 0.0, normal)
    }

    #[test]
    fn between_surfaces_it_is_veachs() {
        let a = point(0.0, 0.0, 0.0, DVec3::Z);
        let b = point(3.0, 0.0, 4.0, -DVec3::X);
        let edge = Edge::between(&a, &b).unwrap();
        assert_relative_eq!(edge.geometry, 0.8 * 0.6 / 25.0, max_relative = 1e-15);
        assert_relative_eq!(edge.direction.x, 0.6, max_relative = 1e-15);
        assert_eq!(Edge::between(&b, &a).unwrap().geometry, edge.geometry);
    }

    #[test]
    fn dirac_positions_have_no_cosine_and_infinity_no_distance() {
        let surface = point(0.0, 0.0, 0.0, DVec3::Z);
        let dirac = SurfacePoint::dirac(DVec3::new(3.0, 0.0, 4.0));
        assert_relative_eq!(
            Edge::between(&surface, &dirac).unwrap().geometry,
            0.8 / 25.0,
            max_relative = 1e-15
        );
        let infinite =
            SurfacePoint::infinite(DVec3::new(0.0, 0.0, 1e9), DVec3::new(0.6, 0.0, -0.8));
        let edge = Edge::between(&surface, &infinite).unwrap();
        assert_eq!(edge.direction, DVec3::new(-0.6, 0.0, 0.8));
        assert_relative_eq!(edge.geometry, 0.8, max_relative = 1e-15);
        assert_eq!(Edge::between(&dirac, &infinite).unwrap().geometry, 1.0);
        assert_eq!(Edge::between(&infinite, &infinite), None);
    }

    #[test]
    fn coincident_points_have_no_edge_and_tiny_distances_do() {
        let a = point(1.0, 2.0, 3.0, DVec3::Z);
        assert_eq!(Edge::between(&a, &a), None);
        for exponent in [-150, -12, 12, 150] {
            let r = 10f64.powi(exponent);
            let (a, b) = (point(0.0, 0.0, 0.0, DVec3::Z), point(r, 0.0, r, DVec3::Z));
            let edge = Edge::between(&a, &b).unwrap();
            assert_relative_eq!(edge.geometry * r * r, 0.25, max_relative = 1e-13);
        }
    }
}
