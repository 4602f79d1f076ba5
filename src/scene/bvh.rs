//! The acceleration structure: obvhs' binary tree over padded f32 boxes, with exact f64 tests in its leaves.
//!
//! Boxes live in a space of their own, `(p - center) / extent`, in which the scene fills [-1, 1]³. So neither the scene's scale nor its
//! distance from the origin reaches the f32 numbers. A ray from outside is first moved, in f64, to where it enters the scene; the
//! leaves see that moved ray too, so that a far origin's rounding is the same for all primitives and opens no gap between them.
//!
//! # Why no box is missed
//!
//! Let ε = 2⁻²⁴ be the rounding of f32. In the space of the boxes a ray travels at most 2√3 and at most 2 along any axis. Seen as a
//! displacement of the point at parameter t along one axis, what the f32 slab test adds is
//!
//! | from | at most |
//! |---|---|
//! | rounding the origin, with a component up to 1 | 1 ε |
//! | rounding the direction | 2 ε |
//! | rounding its reciprocal | 2 ε |
//! | the subtraction and the multiplication of the slab test, over a distance up to 2 | 4 ε |
//! | obvhs replaces components of the direction below 2 ε by ±2 ε | 4√3 ε |
//!
//! in all less than 16 ε = 2⁻²⁰, by which every box is padded after it was rounded outwards. Hence the interval of every box that
//! contains the hit at t contains t, and its entry is below any f32 number above t: what a leaf hands back is rounded up.

use crate::geometry::{Bounds, Contact, Intersection, Ray, Shape};
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::{Ray as BoxRay, RayHit};

/// Padding of the boxes; see the module's documentation.
const PADDING: f32 = 16.0 * 0.5 * f32::EPSILON;

/// Rays are moved to a cube that is larger than the scene by this much, so that moving does not cut off its boundary.
const CLIP: f64 = 1.0 + 4.0 * PADDING as f64;

/// A tree over all primitives of a scene.
pub(crate) struct Bvh {
    tree: Bvh2,
    /// Shapes in the order of the tree, with the primitives that they are.
    leaves: Vec<(Shape, u32)>,
    /// Index in `leaves` of each primitive.
    slots: Vec<u32>,
    center: DVec3,
    extent: f64,
    inverse_extent: f64,
}

/// What a ray knows about its ends: the primitives that they lie on, `SurfacePoint::NONE` for none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends {
    /// The primitive that the origin lies on.
    pub origin: u32,
    /// The primitive that the end of the segment lies on.
    pub end: u32,
}

/// The nearest hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit<'a> {
    /// The primitive that was hit.
    pub primitive: u32,
    /// Its shape.
    pub shape: &'a Shape,
    /// The ray that the intersection refers to, which may start further on than the one that was asked for.
    pub ray: Ray,
    /// Where it was hit.
    pub intersection: Intersection,
}

/// A ray that starts in or at the scene, in world space and in that of the boxes.
struct ClippedRay {
    ray: Ray,
    /// Distance by which the origin was moved, world units.
    moved: f64,
    box_origin: Vec3A,
    box_direction: Vec3A,
}

impl Bvh {
    /// Builds the tree; primitives are numbered in the given order.
    pub fn new(shapes: &[Shape], bounds: &Bounds) -> Self {
        let (center, extent) =
            if shapes.is_empty() { (DVec3::ZERO, 1.0) } else { (bounds.center(), 0.5 * (bounds.max - bounds.min).max_element()) };
        let inverse_extent = 1.0 / extent;
        let boxes: Vec<Aabb> = shapes
            .iter()
            .map(|shape| {
                let b = shape.bounds();
                let (min, max) = ((b.min - center) * inverse_extent, (b.max - center) * inverse_extent);
                let down = |x: f64| (x as f32).next_down() - PADDING;
                let up = |x: f64| (x as f32).next_up() + PADDING;
                Aabb::new(Vec3A::new(down(min.x), down(min.y), down(min.z)), Vec3A::new(up(max.x), up(max.y), up(max.z)))
            })
            .collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut std::time::Duration::default());
        let mut slots = vec![0; shapes.len()];
        let leaves = tree.primitive_indices.iter().map(|&primitive| (shapes[primitive as usize], primitive)).collect();
        for (slot, &primitive) in tree.primitive_indices.iter().enumerate() {
            slots[primitive as usize] = slot as u32;
        }
        Self { tree, leaves, slots, center, extent, inverse_extent }
    }

    /// The shape of a primitive.
    pub fn shape(&self, primitive: u32) -> Option<&Shape> {
        let slot = *self.slots.get(primitive as usize)?;
        self.leaves.get(slot as usize).map(|(shape, _)| shape)
    }

    /// The nearest hit, of equally near ones that with the lowest primitive. `direction` is of unit length.
    pub fn closest(&self, origin: DVec3, direction: DVec3, origin_primitive: u32) -> Option<Hit<'_>> {
        let clipped = self.clip(origin, direction)?;
        let ray = clipped.ray;
        let mut nearest = Intersection { t: f64::INFINITY, u: 0.0, v: 0.0 };
        let mut nearest_slot = usize::MAX;
        let mut nearest_primitive = u32::MAX;
        let box_ray = BoxRay::new(clipped.box_origin, clipped.box_direction, 0.0, f32::INFINITY);
        self.tree.ray_traverse(box_ray, &mut RayHit::none(), |_, slot| {
            let (shape, primitive) = &self.leaves[slot];
            let contact = if *primitive == origin_primitive { Contact::Origin } else { Contact::None };
            let Some(hit) = shape.intersect_apart_from(&ray, contact) else { return f32::INFINITY };
            if hit.t > nearest.t || (hit.t == nearest.t && *primitive > nearest_primitive) {
                return f32::INFINITY;
            }
            (nearest, nearest_slot, nearest_primitive) = (hit, slot, *primitive);
            self.round_up(hit.t)
        });
        let (shape, primitive) = self.leaves.get(nearest_slot)?;
        Some(Hit { primitive: *primitive, shape, ray, intersection: nearest })
    }

    /// Whether nothing lies between the origin and the point at distance `length`. `direction` is of unit length.
    pub fn is_free(&self, origin: DVec3, direction: DVec3, length: f64, ends: Ends) -> bool {
        let Some(clipped) = self.clip(origin, direction) else { return true };
        let (ray, length) = (clipped.ray, length - clipped.moved);
        if length.is_nan() || length <= 0.0 {
            return true;
        }
        let box_ray = BoxRay::new(clipped.box_origin, clipped.box_direction, 0.0, self.round_up(length));
        self.tree.ray_traverse_miss(box_ray, |_, slot| {
            let (shape, primitive) = &self.leaves[slot];
            let contact = match (*primitive == ends.origin, *primitive == ends.end) {
                (false, false) => Contact::None,
                (true, false) => Contact::Origin,
                (false, true) => Contact::End(length),
                (true, true) => Contact::Both,
            };
            let blocked = shape.intersect_apart_from(&ray, contact).is_some_and(|hit| hit.t < length);
            if blocked { f32::NEG_INFINITY } else { f32::INFINITY }
        })
    }

    /// A distance in the space of the boxes, rounded up far enough to exceed the entry of every box that contains a hit there.
    fn round_up(&self, t: f64) -> f32 {
        ((t * self.inverse_extent) as f32).next_up().next_up()
    }

    /// Moves the origin to where the ray enters the scene; `None` if it does not, or if the ray is no ray.
    fn clip(&self, origin: DVec3, direction: DVec3) -> Option<ClippedRay> {
        let mut origin = origin;
        let mut moved = 0.0;
        let mut box_origin = (origin - self.center) * self.inverse_extent;
        if !(box_origin.is_finite() && direction.is_finite() && direction != DVec3::ZERO) {
            return None;
        }
        if box_origin.abs().max_element() > CLIP {
            let (mut near, mut far) = (0.0f64, f64::INFINITY);
            for axis in 0..3 {
                let inverse = 1.0 / direction[axis];
                let (a, b) = ((-CLIP - box_origin[axis]) * inverse, (CLIP - box_origin[axis]) * inverse);
                near = near.max(a.min(b));
                far = far.min(a.max(b));
            }
            // A far origin is known to its own rounding only, which may exceed the cube's margin.
            let uncertainty = box_origin.abs().max_element() * (8.0 * f64::EPSILON);
            if near > far + uncertainty {
                return None;
            }
            moved = near * self.extent;
            origin += direction * moved;
            box_origin = (origin - self.center) * self.inverse_extent;
        }
        Some(ClippedRay { ray: Ray::new(origin, direction), moved, box_origin: box_origin.as_vec3a(), box_direction: direction.as_vec3a() })
    }
}

/// The length of a direction may be off by rounding, and by a little more where a user computed it; anything else is made unit length.
pub(crate) fn unit(direction: DVec3) -> DVec3 {
    let length_squared = direction.length_squared();
    if (length_squared - 1.0).abs() <= 1e-9 { direction } else { direction.normalize_or_zero() }
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh").field("primitives", &self.slots.len()).field("nodes", &self.tree.nodes.len()).finish_non_exhaustive()
    }
}
