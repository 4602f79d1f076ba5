//! Queries to the tree and its answers: rays and segments that start and end where the primitives
//! that they lie on are not in the way.

use super::layout::Candidate;
use crate::geometry::{Intersection, Place, Ray, SurfacePoint, gamma, moved_towards};
use crate::lanes::{Lane, Vector};
use glam::DVec3;

/// The ends of a ray: the primitives that they lie on, `SurfacePoint::NONE` for none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends {
    /// The primitive that the origin lies on.
    pub origin: u32,
    /// The primitive that the end of the segment lies on.
    pub end: u32,
}

impl Ends {
    /// No primitives.
    pub const FREE: Self = Self { origin: SurfacePoint::NONE, end: SurfacePoint::NONE };
}

/// A ray to find the nearest hit of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Query {
    /// The start.
    pub origin: DVec3,
    /// The direction.
    pub direction: DVec3,
    /// The primitive that the origin lies on.
    pub origin_primitive: u32,
}

impl Query {
    /// A ray from an origin that lies on no surface.
    #[inline]
    pub fn free(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, origin_primitive: SurfacePoint::NONE }
    }

    /// A ray from a surface point.
    #[inline(always)]
    pub fn leaving(from: &SurfacePoint, direction: DVec3) -> Self {
        Self { origin: from.origin_towards(direction), direction, origin_primitive: contact(from) }
    }
}

/// A ray up to a distance, to find out whether anything is in its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// The start.
    pub origin: DVec3,
    /// The direction.
    pub direction: DVec3,
    /// The length.
    pub length: f64,
    /// The primitives at its ends.
    pub ends: Ends,
}

impl Segment {
    /// A segment up to a length, from and to points that lie on no surface.
    #[inline]
    pub fn free(origin: DVec3, direction: DVec3, length: f64) -> Self {
        Self { origin, direction, length, ends: Ends::FREE }
    }

    /// The segment to test for two points of a scene around `center` that may see each other, or
    /// the answer if that is clear without.
    #[inline(always)]
    pub fn between(a: &SurfacePoint, b: &SurfacePoint, center: DVec3) -> Result<Self, bool> {
        let (a, b) = match (a.place, b.place) {
            (Place::Infinite, Place::Infinite) => return Err(false),
            (Place::Infinite, _) => (b, a),
            (_, Place::Infinite) => (a, b),
            _ if starts_segment(a, b, center) => (a, b),
            _ => (b, a),
        };
        let (origin, direction, length) = if b.place == Place::Infinite {
            let direction = unit(-b.geometric_normal).unwrap_or_default();
            let origin = a.origin_towards(direction);
            (origin, direction, (b.position - origin).dot(direction))
        } else {
            let between = b.position - a.position;
            if between == DVec3::ZERO {
                return Err(false);
            }
            // Each end is moved towards the other, so that neither end's own surface is in the way.
            let (origin, end) = (a.origin_towards(between), b.origin_towards(-between));
            let segment = end - origin;
            if segment.dot(between) <= 0.0 {
                // Closer to each other than their error bounds: nothing can be in between.
                return Err(true);
            }
            let length = segment.length();
            (origin, segment / length, length)
        };
        if !(origin.is_finite()
            && direction.is_finite()
            && direction != DVec3::ZERO
            && length.is_finite())
        {
            return Err(false);
        }
        let length = length * SHORTENED;
        Ok(Self { origin, direction, length, ends: Ends { origin: contact(a), end: contact(b) } })
    }
}

/// The part of a segment to test: hits within the rounding of the distance itself belong to the
/// end.
const SHORTENED: f64 = 1.0 - gamma(8);

/// Ends of segments in lanes. One that lies on no surface has neither error bound nor normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneEnd<L> {
    /// Position.
    pub position: Vector<L>,
    /// Bound on the rounding error of the position.
    pub error: L,
    /// Geometric normal.
    pub normal: Vector<L>,
}

/// [`Segment`]s in lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneSegment<L: Lane> {
    /// The starts.
    pub origin: Vector<L>,
    /// The directions.
    pub direction: Vector<L>,
    /// The lengths.
    pub length: L,
    /// True where the segment starts at the first end.
    pub is_forward: L::Mask,
    /// True where this is the segment; elsewhere [`Segment::between`] decides.
    pub is_clear: L::Mask,
}

impl<L: Lane> LaneSegment<L> {
    /// [`Segment::between`] in lanes, of ends that are not at infinity.
    #[inline(always)]
    pub fn between(a: LaneEnd<L>, b: LaneEnd<L>, center: DVec3) -> Self {
        let center = Vector::constant(center, a.error);
        let to_a = (a.position - center).length_squared();
        let to_b = (b.position - center).length_squared();
        let is_forward = to_a.less(to_b);
        // Each end is moved towards the other; to turn the segment around takes less than to choose
        // between all of both.
        let between = b.position - a.position;
        let from = moved_towards(a.position, a.error, a.normal, between);
        let to = moved_towards(b.position, b.error, b.normal, -between);
        let (origin, end) =
            (Vector::choose(is_forward, from, to), Vector::choose(is_forward, to, from));
        let segment = end - origin;
        let between = Vector::choose(is_forward, between, -between);
        let length = segment.length_squared().sqrt();
        Self {
            origin,
            direction: segment / length,
            length: length * SHORTENED,
            is_forward,
            is_clear: !to_a.equals(to_b)
                & segment.dot(between).is_positive()
                & length.is_positive()
                & length.less(length.constant(f64::INFINITY)),
        }
    }
}

/// The nearest hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit<'a> {
    /// The primitive that was hit.
    pub primitive: u32,
    /// The place in the tree, if it was found there.
    pub(super) candidate: Option<Candidate<'a>>,
    /// How much further on than the start of the ray that was asked for the one starts that the
    /// intersection refers to.
    pub moved: f64,
    /// The intersection.
    pub intersection: Intersection,
}

impl Hit<'_> {
    /// The ray that the intersection refers to, from the one that was asked for.
    pub fn ray_of(&self, query: &Query) -> Option<Ray> {
        let direction = unit(query.direction)?;
        let is_moved = self.moved > 0.0;
        let origin = if is_moved { query.origin + direction * self.moved } else { query.origin };
        Some(Ray::new(origin, direction))
    }
}

/// The answer of the exact test.
pub(super) struct Found<'a> {
    pub primitive: u32,
    /// The place in a tree, if it was found by way of one.
    pub candidate: Option<Candidate<'a>>,
    pub intersection: Intersection,
}

impl<'a> Found<'a> {
    #[inline(always)]
    pub fn new(candidate: Candidate<'a>, intersection: Intersection) -> Self {
        Self { primitive: candidate.primitive(), candidate: Some(candidate), intersection }
    }

    /// True if this one is nearer; of equally near ones that is the one with the lower primitive.
    #[inline(always)]
    pub fn is_nearer(&self, other: &Self) -> bool {
        let (t, other_t) = (self.intersection.t, other.intersection.t);
        t < other_t || (t == other_t && self.primitive < other.primitive)
    }

    /// The nearer one of two, if any.
    #[inline(always)]
    pub fn nearer(late: Option<Self>, early: Option<Self>) -> Option<Self> {
        match (late, early) {
            (Some(late), Some(early)) if early.is_nearer(&late) => Some(early),
            (late, early) => late.or(early),
        }
    }

    /// The hit of a ray that was moved by so much.
    #[inline(always)]
    pub fn hit(self, moved: f64) -> Hit<'a> {
        let Found { primitive, candidate, intersection } = self;
        Hit { primitive, candidate, moved, intersection }
    }
}

/// The end of a segment at which to start the ray: the one closer to the scene's centre, whose
/// rounding is the smaller one. So the answer does not depend on the order of the ends.
#[inline]
fn starts_segment(a: &SurfacePoint, b: &SurfacePoint, center: DVec3) -> bool {
    let distance = |x: &SurfacePoint| x.position.distance_squared(center);
    let key = |x: &SurfacePoint| (x.position.to_array(), x.primitive);
    let (to_a, to_b) = (distance(a), distance(b));
    to_a < to_b || (to_a == to_b && key(a) <= key(b))
}

/// The primitive that a ray from a point must not hit again.
#[inline]
fn contact(x: &SurfacePoint) -> u32 {
    if x.place == Place::Area { x.primitive } else { SurfacePoint::NONE }
}

/// The length of a direction may be off by rounding, and by a little more where a user computed it;
/// anything else is made unit length. `None` if it has no length.
#[inline(always)]
pub(super) fn unit(direction: DVec3) -> Option<DVec3> {
    if is_about_unit(direction.into()) { Some(direction) } else { crate::math::unit(direction) }
}

/// True for a length that is off by no more than that.
#[inline(always)]
pub(super) fn is_about_unit<L: Lane>(direction: Vector<L>) -> L::Mask {
    let excess = direction.length_squared() - 1.0;
    excess.abs().less(excess.constant(1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Segments in lanes are, where they are clear, the segments between points, to the bit.
    #[test]
    fn segments_in_lanes_are_those_between_points() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
        let mut clear = 0;
        for round in 0..100_000 {
            let mut vector = |scale: f64| {
                DVec3::from_array([(); 3].map(|()| scale * rng.random_range(-1.0..1.0)))
            };
            // Ends that coincide, that are nearer than their errors, that are equally far away from
            // the centre, and others.
            let (center, a) = (vector(1.0), vector(1.0));
            let b = match round % 8 {
                0 => a,
                1 => a + vector(1e-9),
                2 => a + vector(1e-200),
                3 => center + (center - a),
                4 => vector(1e160),
                _ => vector(2.0),
            };
            let normals = [vector(1.0).normalize(), vector(1.0).normalize()];
            let error = [1e-9, 1e-16][round % 2];
            let [a, b] = [(a, normals[0], 1), (b, normals[1], 2)].map(|(x, normal, primitive)| {
                SurfacePoint { primitive, ..SurfacePoint::on_surface(x, error, normal) }
            });
            let b = if round % 5 == 0 { SurfacePoint::dirac(b.position) } else { b };
            let end = |x: &SurfacePoint| LaneEnd {
                position: Vector::from(x.position),
                error: x.error,
                normal: if x.place == Place::Area { x.geometric_normal } else { DVec3::ZERO }
                    .into(),
            };
            let lanes = LaneSegment::<f64>::between(end(&a), end(&b), center);
            if !lanes.is_clear {
                continue;
            }
            clear += 1;
            let expected = Segment::between(&a, &b, center).expect("a segment");
            let found: [DVec3; 2] = [lanes.origin.into(), lanes.direction.into()];
            assert_eq!(found, [expected.origin, expected.direction], "{a:?} {b:?}");
            assert_eq!(lanes.length, expected.length);
            let first = if lanes.is_forward { &a } else { &b };
            assert_eq!(contact(first), expected.ends.origin);
        }
        assert!(clear > 40_000, "{clear}");
    }
}
