//! The extent of the scene as lights at infinity see it.

use crate::geometry::{Bounds, Frame, SurfacePoint};
use crate::math::{PerProjected, warp::square_to_disk};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Relative margin against rounding: positions start this much farther out than needed. It changes
/// no expected value.
const MARGIN: f64 = 1e-3;

/// The scene's bounding box, seen from lights at infinity: which rays of a given direction can meet
/// it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SceneExtent {
    center: DVec3,
    half: DVec3,
}

impl SceneExtent {
    /// Empty and unbounded boxes count as a point: nothing there can be illuminated from a disk of
    /// finite radius.
    pub(super) fn new(bounds: &Bounds) -> Self {
        let half = 0.5 * (bounds.max - bounds.min);
        if bounds.is_empty() || !half.is_finite() {
            Self::default()
        } else {
            Self { center: bounds.center(), half }
        }
    }

    /// Radius of the sphere around the box.
    pub(super) fn radius(&self) -> f64 {
        self.half.length()
    }

    /// Area of the disk perpendicular to `direction` that covers the box as seen along it. Tight:
    /// an elongated scene seen along its axis gets a small one. 0 if there is nothing to cover.
    pub(super) fn disk_area(&self, direction: DVec3) -> f64 {
        PI * self.disk_radius_squared(direction)
    }

    fn disk_radius_squared(&self, direction: DVec3) -> f64 {
        let h = self.half;
        // The farthest corner from the axis; opposite corners are equally far.
        let corners =
            [h, DVec3::new(-h.x, h.y, h.z), DVec3::new(h.x, -h.y, h.z), DVec3::new(h.x, h.y, -h.z)];
        let widest =
            corners.iter().map(|c| c.cross(direction).length_squared()).fold(0.0, f64::max);
        widest * (1.0 + 1e-9)
    }

    /// Density per perpendicular area of the rays that [`SceneExtent::sample_ray`] makes; 0 if it
    /// makes none.
    pub(super) fn ray_pdf(&self, direction: DVec3) -> PerProjected {
        let area = self.disk_area(direction);
        PerProjected(if area > 0.0 { 1.0 / area } else { 0.0 })
    }

    /// The start, outside of the box, of a ray into `direction`, uniform on the disk that covers
    /// the box.
    pub(super) fn sample_ray(&self, direction: DVec3, u: DVec2) -> DVec3 {
        let p = square_to_disk(u) * self.disk_radius_squared(direction).sqrt();
        let frame = Frame::from_normal(direction);
        self.center + frame.x * p.x + frame.y * p.y - direction * (self.radius() * (1.0 + MARGIN))
    }

    /// The infinite `point`, placed where the segment from `receiver` towards it has certainly left
    /// the box.
    pub(super) fn facing(&self, point: &SurfacePoint, receiver: &SurfacePoint) -> SurfacePoint {
        let distance = (receiver.position.distance(self.center) + self.radius()) * (1.0 + MARGIN);
        // In a scene that is a single point any segment will do, but it must have a direction.
        let distance = if distance > 0.0 { distance } else { 1.0 };
        SurfacePoint { position: receiver.position - point.geometric_normal * distance, ..*point }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::testing::random;

    #[test]
    fn the_disk_covers_the_box_and_rays_start_outside() {
        let mut rng = random(3);
        let bounds = Bounds { min: DVec3::new(-1.0, 2.0, 5.0), max: DVec3::new(4.0, 2.5, 5.0) };
        let extent = SceneExtent::new(&bounds);
        for _ in 0..1000 {
            let w = crate::math::warp::square_to_sphere(DVec2::new(rng(), rng()));
            let radius = (extent.disk_area(w) / PI).sqrt();
            let inside = bounds.min + (bounds.max - bounds.min) * DVec3::new(rng(), rng(), rng());
            assert!((inside - extent.center).cross(w).length() <= radius);
            assert!(radius <= extent.radius() * (1.0 + 1e-9));
            let start = extent.sample_ray(w, DVec2::new(rng(), rng()));
            assert!((start - extent.center).dot(w) < -extent.radius());
            let receiver = SurfacePoint::on_surface(inside * 3.0, 0.0, DVec3::Z);
            let far = extent.facing(&SurfacePoint::infinite(DVec3::ZERO, w), &receiver);
            assert!(far.position.distance(extent.center) > extent.radius());
        }
    }

    #[test]
    fn nothing_to_cover_gives_no_ray() {
        for bounds in [
            Bounds::EMPTY,
            Bounds::of_points([DVec3::ONE]),
            Bounds { min: DVec3::ZERO, max: DVec3::INFINITY },
        ] {
            let extent = SceneExtent::new(&bounds);
            assert_eq!(extent.ray_pdf(DVec3::X), PerProjected::ZERO);
            assert!(
                extent
                    .facing(
                        &SurfacePoint::infinite(DVec3::ZERO, DVec3::X),
                        &SurfacePoint::dirac(extent.center)
                    )
                    .position
                    .is_finite()
            );
        }
    }
}
