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

use super::traverse::BoxRay;
use super::wide::{BinaryNode, Facet, Wide};
use crate::geometry::{Bounds, Contact, Intersection, Ray, Shape};
use fearless_simd::{Level, dispatch};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::splits::split_aabbs_precise;
use obvhs::triangle::Triangle;

/// Rounding of f32.
const ROUNDOFF: f32 = 0.5 * f32::EPSILON;

/// Padding of the boxes; see the module's documentation.
const PADDING: f32 = 32.0 * ROUNDOFF;

/// What a triangle's edge functions may be off by, in units of the sum of its edges' components.
pub(super) const EDGE_TOLERANCE: f64 = 64.0 * ROUNDOFF as f64;

/// What the distance to a triangle times the determinant may be off by, in units of the product of its edges' lengths.
pub(super) const DISTANCE_TOLERANCE: f64 = 96.0 * ROUNDOFF as f64;

/// What either may be off by in f64.
pub(super) const TOLERANCE_F64: f64 = 1.0 / (1u64 << 39) as f64;

/// Rays are moved to a cube that is larger than the scene by this much, so that moving does not cut off its boundary.
const CLIP: f64 = 1.0 + 4.0 * PADDING as f64;

/// A tree over all primitives of a scene.
pub(crate) struct Bvh {
    wide: Wide,
    /// All primitives, by their number.
    shapes: Vec<Shape>,
    center: DVec3,
    extent: f64,
    inverse_extent: f64,
    /// The instruction set that this processor has.
    level: Level,
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

/// The second half of a quad; the first one and everything else are referred to by the primitive's number.
const SECOND_HALF: u32 = 1 << 31;

impl Bvh {
    /// Builds the tree; primitives are numbered in the given order.
    pub fn new(shapes: Vec<Shape>, bounds: &Bounds) -> Self {
        let (center, extent) =
            if shapes.is_empty() { (DVec3::ZERO, 1.0) } else { (bounds.center(), 0.5 * (bounds.max - bounds.min).max_element()) };
        let inverse_extent = 1.0 / extent;
        let place = |p: DVec3| (p - center) * inverse_extent;
        let facet = |reference: u32| {
            let primitive = reference & !SECOND_HALF;
            let facet = match &shapes[primitive as usize] {
                Shape::Triangle(t) => {
                    let [a, b, c] = t.vertices;
                    Facet::Triangle([place(a), place(b), place(c)])
                }
                Shape::Quad(q) => {
                    let [a, b, c, d] = q.corners();
                    let [second, third] = if reference == primitive { [b, c] } else { [c, d] };
                    Facet::Triangle([place(a), place(second), place(third)])
                }
                Shape::Sphere(_) | Shape::Disk(_) => Facet::Opaque,
            };
            (primitive, facet)
        };
        let mut references: Vec<u32> = Vec::with_capacity(shapes.len());
        for (primitive, shape) in shapes.iter().enumerate() {
            references.push(primitive as u32);
            if matches!(shape, Shape::Quad(_)) {
                references.push(primitive as u32 | SECOND_HALF);
            }
        }
        let mut boxes: Vec<Aabb> = references
            .iter()
            .map(|&reference| {
                let bounds = match facet(reference) {
                    (_, Facet::Triangle(corners)) => Bounds::of_points(corners),
                    (primitive, Facet::Opaque) => {
                        let b = shapes[primitive as usize].bounds();
                        Bounds { min: place(b.min), max: place(b.max) }
                    }
                };
                let down = |x: f64| (x as f32).next_down();
                let up = |x: f64| (x as f32).next_up();
                let (min, max) = (bounds.min, bounds.max);
                Aabb::new(Vec3A::new(down(min.x), down(min.y), down(min.z)), Vec3A::new(up(max.x), up(max.y), up(max.z)))
            })
            .collect();
        let env = |n: &str, d: f32| std::env::var(n).ok().map_or(d, |v| v.parse().unwrap());
        let start = std::time::Instant::now();
        if env("SPLIT", 1.0) > 0.0 { split_large(&mut boxes, &mut references, &facet); }
        let t_split = start.elapsed();
        for b in &mut boxes {
            *b = Aabb::new(b.min - PADDING, b.max + PADDING);
        }
        let dist = match env("DIST", 6.0) as u32 { 1 => PlocSearchDistance::Minimum, 2 => PlocSearchDistance::VeryLow, 3 => PlocSearchDistance::Low, 6 => PlocSearchDistance::Medium, 14 => PlocSearchDistance::High, _ => PlocSearchDistance::VeryHigh };
        let mut tree = PlocBuilder::with_capacity(boxes.len()).build(dist, &boxes, references, SortPrecision::U128, env("THRESH", 2.0) as usize);
        let t_ploc = start.elapsed();
        ReinsertionOptimizer::default().run(&mut tree, env("REINS", 0.2), None);
        let t_reins = start.elapsed();
        let binary: Vec<BinaryNode> = tree
            .nodes
            .iter()
            .map(|node| {
                let Aabb { min, max } = *node.aabb();
                BinaryNode { min: min.to_array(), max: max.to_array(), first: node.first_index, count: node.prim_count }
            })
            .collect();
        let references = std::mem::take(&mut tree.primitive_indices);
        drop(tree);
        let wide = Wide::collapse(&binary, &references, facet);
        if std::env::var("STATS").is_ok() {
            eprintln!("boxes {} of {} shapes; split {:?} ploc {:?} reins {:?} collapse {:?}; nodes {} blocks {} -> {:.1} B/shape", boxes.len(), shapes.len(), t_split, t_ploc-t_split, t_reins-t_ploc, start.elapsed()-t_reins, wide.nodes.len(), wide.blocks.len(),
              (wide.nodes.len()*size_of::<super::wide::Node>() + wide.blocks.len()*size_of::<super::wide::Block>()) as f64 / shapes.len() as f64);
        }
        Self { wide, shapes, center, extent, inverse_extent, level: Level::new() }
    }

    /// The shape of a primitive.
    pub fn shape(&self, primitive: u32) -> Option<&Shape> {
        self.shapes.get(primitive as usize)
    }

    /// The nearest hit, of equally near ones that with the lowest primitive. `direction` is of unit length.
    #[inline]
    pub fn closest(&self, origin: DVec3, direction: DVec3, origin_primitive: u32) -> Option<Hit<'_>> {
        let (origin, box_origin, _) = self.clip(origin, direction)?;
        let ray = Ray::new(origin, direction);
        let box_ray = BoxRay::new(box_origin.as_vec3(), direction.as_vec3());
        let mut nearest = Intersection { t: f64::INFINITY, u: 0.0, v: 0.0 };
        let mut nearest_primitive = u32::MAX;
        let test = |primitive: u32| {
            let contact = if primitive == origin_primitive { Contact::Origin } else { Contact::None };
            let hit = self.shapes[primitive as usize].intersect_apart_from(&ray, contact)?;
            if hit.t > nearest.t || (hit.t == nearest.t && primitive >= nearest_primitive) {
                return None;
            }
            (nearest, nearest_primitive) = (hit, primitive);
            Some(self.round_up(hit.t))
        };
        dispatch!(self.level, simd => self.wide.closest(simd, &box_ray, test));
        let shape = self.shapes.get(nearest_primitive as usize)?;
        Some(Hit { primitive: nearest_primitive, shape, ray, intersection: nearest })
    }

    /// Whether nothing lies between the origin and the point at distance `length`. `direction` is of unit length.
    #[inline]
    pub fn is_free(&self, origin: DVec3, direction: DVec3, length: f64, ends: Ends) -> bool {
        let Some((origin, box_origin, moved)) = self.clip(origin, direction) else { return true };
        let length = length - moved;
        if length.is_nan() || length <= 0.0 {
            return true;
        }
        let ray = Ray::new(origin, direction);
        let box_ray = BoxRay::new(box_origin.as_vec3(), direction.as_vec3());
        let blocks = |primitive: u32, certain: bool| {
            if certain && primitive != ends.origin && primitive != ends.end {
                return true;
            }
            let contact = match (primitive == ends.origin, primitive == ends.end) {
                (false, false) => Contact::None,
                (true, false) => Contact::Origin,
                (false, true) => Contact::End(length),
                (true, true) => Contact::Both,
            };
            self.shapes[primitive as usize].intersect_apart_from(&ray, contact).is_some_and(|hit| hit.t < length)
        };
        !dispatch!(self.level, simd => self.wide.any(simd, &box_ray, self.round_up(length), blocks))
    }

    /// A distance in the space of the boxes, rounded up far enough to exceed the entry of every box that contains a hit there.
    #[inline(always)]
    fn round_up(&self, t: f64) -> f32 {
        (t * self.inverse_extent * (1.0 + 4.0 * f64::from(ROUNDOFF))) as f32 + f32::MIN_POSITIVE
    }

    /// The origin, moved to where the ray enters the scene, in world space and in that of the boxes, and by how much it was moved; `None`
    /// if the ray does not enter, or is no ray.
    #[inline(always)]
    fn clip(&self, origin: DVec3, direction: DVec3) -> Option<(DVec3, DVec3, f64)> {
        let box_origin = (origin - self.center) * self.inverse_extent;
        if !(box_origin.is_finite() && direction.is_finite() && direction != DVec3::ZERO) {
            return None;
        }
        if box_origin.abs().max_element() > CLIP { self.enter(origin, box_origin, direction) } else { Some((origin, box_origin, 0.0)) }
    }

    /// The same for an origin outside of the scene.
    #[inline(never)]
    fn enter(&self, origin: DVec3, box_origin: DVec3, direction: DVec3) -> Option<(DVec3, DVec3, f64)> {
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
        let moved = near * self.extent;
        let origin = origin + direction * moved;
        Some((origin, (origin - self.center) * self.inverse_extent, moved))
    }
}

/// Replaces the boxes of large triangles by several smaller ones that cover their parts, which saves rays that pass beside a long thin
/// triangle from testing it.
fn split_large(boxes: &mut Vec<Aabb>, references: &mut Vec<u32>, facet: impl Fn(u32) -> (u32, Facet)) {
    let (sum, largest) = boxes.iter().map(Aabb::half_area).fold((0.0f64, 0.0f32), |(sum, largest), a| (sum + f64::from(a), largest.max(a)));
    let average = (sum / boxes.len() as f64) as f32;
    let mut large = Vec::new();
    let mut parts = Vec::new();
    let mut triangles = Vec::new();
    for (i, b) in boxes.iter().enumerate() {
        if b.half_area() > 3.0 * average && let (_, Facet::Triangle([v0, v1, v2])) = facet(references[i]) {
            parts.push(*b);
            large.push(i);
            triangles.push(Triangle { v0: v0.as_vec3a(), v1: v1.as_vec3a(), v2: v2.as_vec3a() });
        }
    }
    let mut owners: Vec<u32> = (0..large.len() as u32).collect();
    let high = (4.0 * average).max(0.9 * average + 0.1 * largest);
    split_aabbs_precise(&mut parts, &mut owners, &triangles, 3.0 * average, high, 1.8, 1.6, 12, 12);
    for (i, (part, owner)) in parts.into_iter().zip(owners).enumerate() {
        let original = large[owner as usize];
        if i < large.len() {
            boxes[original] = part;
        } else {
            boxes.push(part);
            references.push(references[original]);
        }
    }
}

/// The length of a direction may be off by rounding, and by a little more where a user computed it; anything else is made unit length.
pub(crate) fn unit(direction: DVec3) -> DVec3 {
    let length_squared = direction.length_squared();
    if (length_squared - 1.0).abs() <= 1e-9 { direction } else { direction.normalize_or_zero() }
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh").field("primitives", &self.shapes.len()).field("nodes", &self.wide.nodes.len()).finish_non_exhaustive()
    }
}
