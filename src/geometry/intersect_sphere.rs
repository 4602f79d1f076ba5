//! Intersections of rays with spheres and zones of spheres.

use super::{Contact, Intersection, Ray, Sphere};
use crate::lanes::{Lane, Mask, Vector};

impl Sphere {
    /// The nearest point in front of the ray's origin that belongs to the shape, on either side.
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Intersection> {
        self.intersect_apart_from(ray, Contact::None)
    }

    #[inline(never)]
    pub(super) fn intersect_apart_from(&self, ray: &Ray, contact: Contact) -> Option<Intersection> {
        let (from, d) = ((ray.origin - self.center).into(), ray.direction.into());
        let (hit, t) = match contact {
            Contact::None => self.meet(from, d),
            Contact::Origin => self.meet_again(from, d),
            Contact::End(end) => self.meet_before(from, d, end),
            Contact::Both => return None,
        };
        hit.then_some(Intersection { t, u: 0.0, v: 0.0 })
    }

    /// Where the mask keeps the point in direction `outward` (any length) from the centre.
    #[inline(always)]
    fn keeps<L: Lane>(&self, outward: Vector<L>) -> L::Mask {
        let Sphere { axis, cos_min, cos_max, .. } = *self;
        let along = outward.x * axis.x + outward.y * axis.y + outward.z * axis.z;
        let cos = along / outward.length_squared().sqrt();
        !(cos.less(cos.constant(cos_min)) | cos.more(cos.constant(cos_max)))
    }

    /// Where the point at this distance is in front of the ray's origin and not masked; `from` leads
    /// from the centre to the origin.
    #[inline(always)]
    fn accepts<L: Lane>(&self, from: Vector<L>, d: Vector<L>, t: L) -> L::Mask {
        let valid = t.is_positive() & t.less(t.constant(f64::INFINITY));
        if self.is_whole() { valid } else { valid & self.keeps(from + d * t) }
    }

    /// The rays, in lanes, that hit the shape, and where; `from` leads from the centre to the ray's
    /// origin.
    #[inline(always)]
    pub(crate) fn meet<L: Lane>(&self, from: Vector<L>, d: Vector<L>) -> (L::Mask, L) {
        let [near, far] = self.roots(from, d);
        let first = self.accepts(from, d, near);
        (first | self.accepts(from, d, far), first.choose(near, far))
    }

    /// The same for rays that start on the sphere: one root is the contact itself; the chord to the
    /// other one follows from the angle there.
    #[inline(always)]
    pub(crate) fn meet_again<L: Lane>(&self, from: Vector<L>, d: Vector<L>) -> (L::Mask, L) {
        let t = from.dot(d) * -2.0 / d.length_squared();
        (self.accepts(from, d, t), t)
    }

    /// The same for segments that end on the sphere.
    #[inline(always)]
    pub(crate) fn meet_before<L: Lane>(
        &self,
        from: Vector<L>,
        d: Vector<L>,
        end: L,
    ) -> (L::Mask, L) {
        let t = end - (from + d * end).dot(d) * 2.0 / d.length_squared();
        (self.accepts(from, d, t) & t.less(end), t)
    }

    /// Both roots of `|from + t d|² = r²` in order; no numbers if there are none.
    ///
    /// The discriminant is taken from the distance between centre and ray rather than from `b² -
    /// c`, and the root that would suffer from cancellation is computed as `c / q` (Haines et al.
    /// 2019, "Precision Improvements for Ray/Sphere Intersection").
    #[inline(always)]
    fn roots<L: Lane>(&self, from: Vector<L>, d: Vector<L>) -> [L; 2] {
        let (b, length_squared) = (-from.dot(d), d.length_squared());
        let radius = b.constant(self.radius);
        let closest = (from + d * (b / length_squared)).length_squared().sqrt();
        let discriminant = (radius - closest) * (radius + closest);
        let distance = from.length_squared().sqrt();
        let c = (distance - radius) * (distance + radius);
        let q = b + (length_squared * discriminant).sqrt().copysign(b);
        let (first, second) = (c / q, q / length_squared);
        let ordered = first.less(second);
        [ordered.choose(first, second), ordered.choose(second, first)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Shape;
    use approx::assert_relative_eq;
    use glam::DVec3;

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
