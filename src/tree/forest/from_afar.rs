//! Rays in the trees of spaces that they do not start in.

use crate::geometry::{Bounds, Ray};
use crate::lanes::dispatch;
use crate::tree::boxes::{BoxRay, Splat};
use crate::tree::bvh::Bvh;
use crate::tree::layout::{Candidate, Child, LANES, WIDTH};
use crate::tree::query::{Found, Segment};
use crate::tree::rounding::{NEAR, blur};
use crate::tree::stack::Stack;
use crate::tree::traverse::{Any, Nearest, Step};
use fearless_simd::Simd;
use glam::DVec3;

/// A ray that visits several trees.
pub(super) struct Line {
    /// The ray of the exact tests.
    pub ray: Ray,
    /// The reciprocals of its direction's components.
    inverse: DVec3,
    /// The primitive that it starts on.
    origin_primitive: u32,
}

impl Line {
    #[inline]
    pub fn new(origin: DVec3, direction: DVec3, origin_primitive: u32) -> Self {
        Self { ray: Ray::new(origin, direction), inverse: direction.recip(), origin_primitive }
    }
}

/// A box, which rays enter in f64.
#[derive(Clone, Copy)]
pub(super) struct Slabs {
    pub center: DVec3,
    /// Half the sides; negative for one that is empty.
    pub half: DVec3,
}

impl Slabs {
    /// A box that is so much larger on all sides.
    pub fn around(bounds: &Bounds, margin: f64) -> Self {
        if bounds.is_empty() {
            return Self { center: DVec3::ZERO, half: DVec3::NEG_ONE };
        }
        Self { center: bounds.center(), half: 0.5 * (bounds.max - bounds.min) + margin }
    }

    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.center - self.half, max: self.center + self.half }
    }

    #[inline(always)]
    pub fn contains(&self, p: DVec3) -> bool {
        (p - self.center).abs().cmple(self.half).all()
    }

    /// True for a point at a distance along a ray from inside that is inside, too.
    #[inline(always)]
    pub fn contains_end(&self, origin: DVec3, direction: DVec3, t: f64) -> bool {
        (origin - self.center + direction * t).abs().cmple(self.half).all()
    }

    /// The distance at which a ray enters, 0 from inside; `None` if it does not before a limit.
    pub fn entry(&self, line: &Line, limit: f64) -> Option<f64> {
        #[cfg(test)]
        crate::tree::tests::count(2);
        if self.half.x < 0.0 {
            return None;
        }
        let place = line.ray.origin - self.center;
        let half = self.half + blur(place.abs().max_element());
        let (mut near, mut far) = (0.0f64, limit);
        for axis in 0..3 {
            let a = (-half[axis] - place[axis]) * line.inverse[axis];
            let b = (half[axis] - place[axis]) * line.inverse[axis];
            (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
        }
        (near <= far).then_some(near)
    }
}

impl Bvh {
    /// True if a ray from there may be tested in f32.
    fn is_near(&self, origin: DVec3) -> bool {
        self.space.place(origin).abs().max_element() <= NEAR
    }

    /// The ray in the space of the boxes, moved to where it enters the region.
    #[inline(always)]
    fn moved_box_ray(&self, ray: &Ray, entry: f64) -> BoxRay {
        let place =
            self.space.place(ray.origin) + ray.direction * (entry * self.space.inverse_extent);
        BoxRay::new(place.as_vec3(), ray.direction.as_vec3())
    }

    /// Replaces the nearest hit of a ray that enters at a distance by what is nearer.
    #[inline(never)]
    pub(super) fn find_nearer<'a>(
        &'a self,
        line: &Line,
        entry: f64,
        limit: f64,
        nearest: &mut Option<Found<'a>>,
    ) {
        let Line { ray, origin_primitive, .. } = line;
        if self.is_near(ray.origin) {
            dispatch!(self.level, simd => self.find_nearer_with(simd, line, entry, limit, nearest));
        } else {
            self.visit_from_afar(ray, limit, |candidate| {
                self.test_early(candidate, ray, *origin_primitive, nearest)?;
                nearest.as_ref().map(|found| found.intersection.t)
            });
        }
    }

    #[inline(always)]
    fn find_nearer_with<'a, S: Simd>(
        &'a self,
        simd: S,
        line: &Line,
        entry: f64,
        limit: f64,
        nearest: &mut Option<Found<'a>>,
    ) {
        let Line { ray, origin_primitive, .. } = line;
        let box_ray = self.moved_box_ray(ray, entry);
        let wide = Splat::new(simd, &box_ray);
        let from_entry = |t: f64| self.round_up((t - entry).max(0.0));
        let (mut walk, mut stack) = (Nearest::before(from_entry(limit)), Stack::default());
        let mut test = |candidate: Candidate<'a>| {
            self.test_early(candidate, ray, *origin_primitive, nearest)?;
            nearest.as_ref().map(|found| from_entry(found.intersection.t))
        };
        while self.wide.step_to_nearest(
            simd,
            &box_ray,
            &wide,
            &mut walk,
            &mut stack,
            *origin_primitive,
            |_| {},
            &mut test,
        ) != Step::Done
        {}
        if let Some(held) = walk.held {
            test(held);
        }
    }

    /// True if anything lies on a segment that enters at a distance.
    #[inline(never)]
    pub(super) fn is_in_the_way(&self, line: &Line, entry: f64, segment: &Segment) -> bool {
        if self.is_near(segment.origin) {
            return dispatch!(self.level, simd => {
                self.is_in_the_way_with(simd, line, entry, segment)
            });
        }
        let mut blocked = false;
        self.visit_from_afar(&line.ray, segment.length, |candidate| {
            blocked = blocked || self.blocks(candidate, segment);
            blocked.then_some(f64::NEG_INFINITY)
        });
        blocked
    }

    #[inline(always)]
    fn is_in_the_way_with<S: Simd>(
        &self,
        simd: S,
        line: &Line,
        entry: f64,
        segment: &Segment,
    ) -> bool {
        let box_ray = self.moved_box_ray(&line.ray, entry);
        let wide = Splat::new(simd, &box_ray);
        let limit = self.round_up((segment.length - entry).max(0.0));
        let (mut walk, mut stack) = (Any::new(limit), Stack::default());
        while self.step_to_any(simd, &box_ray, &wide, &mut walk, &mut stack, segment) != Step::Done
        {
        }
        walk.hit
    }

    /// Visits, in f64, all leaves that a ray from so far away meets before a limit that f32 cannot
    /// tell. `test` gets what is in them and returns the limit from then on if it has come down.
    fn visit_from_afar<'a>(
        &'a self,
        ray: &Ray,
        limit: f64,
        mut test: impl FnMut(Candidate<'a>) -> Option<f64>,
    ) {
        let place = self.space.place(ray.origin).to_array();
        let inverse = ray.direction.recip().to_array();
        let padding = blur(place.iter().fold(1.0, |most, x| x.abs().max(most)));
        let in_space = |t: f64| t * self.space.inverse_extent + padding;
        let mut limit = in_space(limit);
        let mut stack = vec![Child(0)];
        while let Some(child) = stack.pop() {
            if child.is_leaf() {
                let Some(block) = self.wide.block(child.line()) else { return };
                for lane in 0..LANES {
                    let candidate = Candidate { block, lane };
                    if (candidate.primitive() as usize) < self.shapes.len()
                        && let Some(nearer) = test(candidate)
                    {
                        limit = in_space(nearer);
                    }
                }
                continue;
            }
            let Some(node) = self.wide.node(child.line()) else { return };
            for lane in (0..WIDTH).rev() {
                let (mut near, mut far) = (0.0f64, limit);
                for axis in 0..3 {
                    let plane = |upper: bool| {
                        let plane = f64::from(f32::from_bits(node.planes(axis, upper)[lane]));
                        let plane = if upper { plane + padding } else { plane - padding };
                        (plane - place[axis]) * inverse[axis]
                    };
                    let backwards = inverse[axis] < 0.0;
                    (near, far) = (near.max(plane(backwards)), far.min(plane(!backwards)));
                }
                if near <= far {
                    stack.push(node.child(lane));
                }
            }
        }
    }
}
