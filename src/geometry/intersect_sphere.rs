//! Intersections of rays with spheres and zones of spheres.

use super::{Contact, Intersection, Ray, Sphere};
use glam::DVec3;

impl Sphere {
    /// The nearest point in front of the ray's origin that belongs to the shape, on either side.
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Intersection> {
        self.intersect_apart_from(ray, Contact::None)
    }

    /// True if the mask keeps the point in direction `outward` (any length) from the centre.
    #[inline]
    fn keeps(&self, outward: DVec3) -> bool {
        if self.is_whole() {
            return true;
        }
        let cos = outward.dot(self.axis) / outward.length();
        cos >= self.cos_min && cos <= self.cos_max
    }

    #[inline(never)]
    pub(super) fn intersect_apart_from(&self, ray: &Ray, contact: Contact) -> Option<Intersection> {
        let d = ray.direction;
        let length_squared = d.length_squared();
        let from_center = ray.origin - self.center;
        let accept = |t: f64| {
            let valid = t > 0.0 && t < f64::INFINITY && self.keeps(from_center + d * t);
            valid.then_some(Intersection { t, u: 0.0, v: 0.0 })
        };
        match contact {
            Contact::None => {
                let [near, far] = self.roots(from_center, d, length_squared)?;
                accept(near).or_else(|| accept(far))
            }
            // One root is the contact itself; the chord to the other one follows from the angle
            // there.
            Contact::Origin => accept(-2.0 * from_center.dot(d) / length_squared),
            Contact::End(end) => {
                accept(end - 2.0 * (from_center + d * end).dot(d) / length_squared)
                    .filter(|hit| hit.t < end)
            }
            Contact::Both => None,
        }
    }

    /// Both roots of `|f + t d|² = r²` in order.
    ///
    /// The discriminant is taken from the distance between centre and ray rather than from `b² -
    /// c`, and the root that would suffer from cancellation is computed as `c / q` (Haines et al.
    /// 2019, "Precision Improvements for Ray/Sphere Intersection").
    #[inline]
    fn roots(&self, f: DVec3, d: DVec3, length_squared: f64) -> Option<[f64; 2]> {
        let b = -f.dot(d);
        let closest = (f + d * (b / length_squared)).length();
        let discriminant = (self.radius - closest) * (self.radius + closest);
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let distance = f.length();
        let c = (distance - self.radius) * (distance + self.radius);
        let q = b + (length_squared * discriminant).sqrt().copysign(b);
        let (first, second) = (c / q, q / length_squared);
        Some(if first < second { [first, second] } else { [second, first] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Shape;
    use approx::assert_relative_eq;

    #[test]
    fn roots_keep_their_digits() {
        // A sphere of radius 1 at the distance 1e9: b² - c would have no correct digit.
        let s = Sphere::new(DVec3::Z * 1e9, 1.0);
        let hit = s.intersect(&Ray::new(DVec3::new(0.6, 0.0, 0.0), DVec3::Z)).expect("aimed at it");
        assert_relative_eq!(hit.t - 1e9, -0.8, epsilon = 2e-7);
        // Close to the surface of a unit sphere, the gap is resolved to rounding.
        let s = Sphere::new(DVec3::ZERO, 1.0);
        let hit = s.intersect(&Ray::new(DVec3::Z * (1.0 + 1e-9), -DVec3::Z)).expect("aimed at it");
        assert_relative_eq!(hit.t, 1e-9, max_relative = 1e-6);
    }

    #[test]
    fn a_ray_that_leaves_a_sphere_never_meets_the_contact_again() {
        let s = Shape::Sphere(Sphere::new(DVec3::new(0.3, -2.0, 5.0), 0.7));
        let Shape::Sphere(sphere) = s else { unreachable!() };
        for i in 1..2000 {
            let a = f64::from(i);
            let n = DVec3::new(a.sin(), (1.7 * a).cos(), (0.3 * a).sin()).normalize();
            let d = DVec3::new((2.1 * a).cos(), (0.9 * a).sin(), (1.3 * a).sin()).normalize();
            let x = sphere.point_at(n);
            let hit = s.intersect_apart_from(&Ray::new(x.origin_towards(d), d), Contact::Origin);
            let chord = -2.0 * 0.7 * n.dot(d);
            assert_eq!(hit.is_some(), chord > 0.0);
            if let Some(hit) = hit {
                assert_relative_eq!(hit.t, chord, max_relative = 1e-12, epsilon = 1e-14);
                let back = s.intersect_apart_from(
                    &Ray::new(x.position + d * (hit.t + 1.0), -d),
                    Contact::End(hit.t + 1.0),
                );
                assert_relative_eq!(
                    back.expect("the far side blocks").t,
                    1.0,
                    max_relative = 1e-12
                );
            }
        }
    }

    #[test]
    fn the_mask_lets_rays_through() {
        let cap = Sphere { cos_min: 0.5, ..Sphere::new(DVec3::ZERO, 1.0) };
        let down = Ray::new(DVec3::Z * 3.0, -DVec3::Z);
        assert_relative_eq!(cap.intersect(&down).expect("the pole").t, 2.0);
        let up = Ray::new(DVec3::Z * -3.0, DVec3::Z);
        assert_relative_eq!(cap.intersect(&up).expect("the pole from inside").t, 4.0);
        let zone = Sphere { cos_min: -0.5, cos_max: 0.5, ..cap };
        assert!(zone.intersect(&up).is_none());
    }
}
