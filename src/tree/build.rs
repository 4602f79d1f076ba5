//! Puts the tree together: places shapes in the space of the boxes, takes them apart into facets,
//! and gives each facet a padded box.

use super::binary;
use super::bvh::Bvh;
use super::layout::{Facet, Wide};
use super::packet::Few;
use super::rounding::{self, PADDING};
use super::space::Space;
use crate::geometry::{Bounds, Shape};
use crate::lanes::level;
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use std::sync::Arc;

/// The second half of a quad; the first one and everything else are referred to by the primitive's
/// number.
const SECOND_HALF: u32 = 1 << 31;

impl Bvh {
    /// Builds the tree over some primitives, which are numbers of shapes, for the space of a box
    /// around them. Others are larger than the box, of which they are in the tree as far as they
    /// reach into it; they are in order.
    pub fn new(
        shapes: &Arc<[Shape]>,
        primitives: &[u32],
        intruders: &[u32],
        bounds: &Bounds,
    ) -> Self {
        let (center, extent) = cube(bounds);
        let inverse_extent = 1.0 / extent;
        let space = Space::new(center, extent);
        let place = |p| space.place(p);
        let facet = |reference: u32| {
            let primitive = reference & !SECOND_HALF;
            if intruders.binary_search(&primitive).is_ok() {
                return (primitive, Facet::Opaque);
            }
            let facet = match &shapes[primitive as usize] {
                Shape::Triangle(t) => {
                    let [a, b, c] = t.vertices;
                    let exact = [a, b, c]
                        .into_iter()
                        .all(|corner| space.world(place(corner), [0, 1, 2]) == corner);
                    Facet::Triangle { corners: [place(a), place(b), place(c)], exact }
                }
                Shape::Quad(q) => {
                    let [a, b, c, d] = q.corners();
                    let [second, third] = if reference == primitive { [b, c] } else { [c, d] };
                    Facet::Triangle {
                        corners: [place(a), place(second), place(third)],
                        exact: false,
                    }
                }
                Shape::Sphere(_) | Shape::Disk(_) => Facet::Opaque,
            };
            (primitive, facet)
        };
        let mut references: Vec<u32> = Vec::with_capacity(primitives.len() + intruders.len());
        for &primitive in primitives {
            references.push(primitive);
            if matches!(shapes[primitive as usize], Shape::Quad(_)) {
                references.push(primitive | SECOND_HALF);
            }
        }
        references.extend(intruders);
        let few = match intruders {
            [] => Few::new(shapes, primitives.iter().copied(), &space),
            // Every ray would test them exactly.
            _ => None,
        };
        let mut boxes: Vec<Aabb> = references
            .iter()
            .map(|&reference| {
                let bounds = match facet(reference) {
                    (_, Facet::Triangle { corners, .. }) => Bounds::of_points(corners),
                    (primitive, Facet::Opaque) => {
                        let b = shapes[primitive as usize].bounds();
                        let (min, max) = (place(b.min), place(b.max));
                        if intruders.is_empty() {
                            Bounds { min, max }
                        } else {
                            let blur = rounding::blur(min.abs().max(max.abs()).max_element());
                            Bounds {
                                min: (min - blur).max(place(bounds.min)),
                                max: (max + blur).min(place(bounds.max)),
                            }
                        }
                    }
                };
                let down = |x: f64| (x as f32).next_down();
                let up = |x: f64| (x as f32).next_up();
                let (min, max) = (bounds.min, bounds.max);
                Aabb::new(
                    Vec3A::new(down(min.x), down(min.y), down(min.z)),
                    Vec3A::new(up(max.x), up(max.y), up(max.z)),
                )
            })
            .collect();
        binary::split_large(&mut boxes, &mut references, facet);
        for b in &mut boxes {
            *b = Aabb::new(b.min - PADDING, b.max + PADDING);
        }
        let tree = binary::build(&boxes);
        drop(boxes);
        let references: Vec<u32> =
            tree.primitive_indices.iter().map(|&i| references[i as usize]).collect();
        let wide = Wide::collapse(&tree.nodes, &references, facet);
        Self {
            wide,
            few,
            shapes: Arc::clone(shapes),
            space,
            center,
            extent,
            inverse_extent,
            level: level(),
        }
    }
}

/// The middle and half the side of the cube around a box.
pub(super) fn cube(bounds: &Bounds) -> (DVec3, f64) {
    if bounds.is_empty() {
        return (DVec3::ZERO, 1.0);
    }
    (bounds.center(), 0.5 * (bounds.max - bounds.min).max_element())
}
