//! Points of one shape, uniform in the solid angle under which a receiver sees it.
//!
//! Next event estimation divides by the density of its point, and the geometry term has `cos θ' /
//! r²` of the light's side. A density per area leaves both in the estimate, and near the light its
//! variance grows without bound; per solid angle, `p_A = p_σ cos θ' / r²`, they cancel and the
//! estimate is at most the radiance times the solid angle.
//!
//! [`Subtended::new`] is the one predicate that decides between solid angle and area, for samples
//! and for densities.

mod sphere_cone;

use crate::geometry::{Place, Shape, SurfacePoint};
use crate::math::{PerArea, PerSolidAngle};
use glam::DVec2;
use sphere_cone::SphereCone;

/// What a receiver sees of a shape.
#[derive(Clone, Copy, Debug)]
pub(super) enum Subtended {
    Cone(SphereCone),
}

impl Subtended {
    /// `None` where uniform area serves the receiver as well or better.
    #[inline]
    pub(super) fn new(shape: &Shape, receiver: &SurfacePoint) -> Option<Self> {
        if receiver.place == Place::Infinite {
            return None;
        }
        match shape {
            Shape::Sphere(sphere) => SphereCone::new(*sphere, receiver).map(Self::Cone),
            Shape::Triangle(_) | Shape::Quad(_) | Shape::Disk(_) => None,
        }
    }

    /// The point that the unit square's `u` maps to; primitive and surface ids are left to the
    /// caller.
    pub(super) fn sample(&self, u: DVec2) -> SurfacePoint {
        match self {
            Self::Cone(cone) => cone.sample(u),
        }
    }

    /// The density of `sample` at a point of the shape: 0 where the receiver sees its back.
    pub(super) fn pdf(&self, point: &SurfacePoint) -> PerArea {
        let Self::Cone(cone) = self;
        let (receiver, solid_angle) = (cone.receiver, cone.solid_angle());
        let to_receiver = receiver - point.position;
        let distance_squared = to_receiver.length_squared();
        let cosine = point.geometric_normal.dot(to_receiver) / distance_squared.sqrt();
        if cosine > 0.0 {
            PerSolidAngle(1.0 / solid_angle).per_area(cosine, distance_squared)
        } else {
            PerArea::ZERO
        }
    }
}
