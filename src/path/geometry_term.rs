//! The geometry term of the path integral, without visibility.
//!
//! ```text
//! G(a, b) = |cos θ_a cos θ_b| / |a - b|²        (Veach 1997, equation 8.2)
//! ```
//!
//! with geometric normals. Generalised to every [`Place`]: a Dirac position has no surface and no cosine; a point at infinity has neither
//! cosine nor distance, because its density is per solid angle and its "direction" density per area perpendicular to the ray.

use crate::geometry::{Place, SurfacePoint};
use glam::DVec3;

/// The straight line between two vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Unit direction from the first vertex to the second.
    pub direction: DVec3,
    /// The geometry term without visibility, in the product of the inverse measures of the two vertices' places.
    pub geometry: f64,
}

impl Edge {
    /// The edge between two points; `None` if they coincide or both are at infinity, where no direction exists.
    #[inline]
    #[must_use]
    pub fn between(a: &SurfacePoint, b: &SurfacePoint) -> Option<Self> {
        let direction = match (a.place, b.place) {
            (Place::Infinite, Place::Infinite) => return None,
            (Place::Infinite, _) => a.geometric_normal,
            (_, Place::Infinite) => -b.geometric_normal,
            _ => {
                let difference = b.position - a.position;
                // Scaled by the largest component, so that the square neither overflows nor underflows.
                let scale = difference.abs().max_element();
                if !(scale > 0.0 && scale.is_finite()) {
                    return None;
                }
                (difference / scale).normalize()
            }
        };
        Some(Self::along(a, b, direction))
    }

    /// The edge between two points whose unit direction is known, as when it was sampled.
    #[inline]
    #[must_use]
    pub fn along(a: &SurfacePoint, b: &SurfacePoint, direction: DVec3) -> Self {
        let cosines = a.cosine(direction) * b.cosine(direction);
        let geometry = if a.place == Place::Infinite || b.place == Place::Infinite {
            cosines
        } else {
            let distance = (b.position - a.position).dot(direction);
            // Two divisions: the square of a distance can leave the range of f64 where the quotient does not.
            cosines / distance / distance
        };
        Self { direction, geometry }
    }
}
