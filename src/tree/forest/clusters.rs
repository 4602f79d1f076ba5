//! The primitives that would be lost in the padding of a space, in clusters that are worth spaces
//! of their own.

use crate::geometry::{Bounds, Disk, Quad, Shape, Sphere, Triangle};
use crate::tree::binary;
use crate::tree::build::cube;
use crate::tree::rounding::{PADDING, blur};
use crate::tree::space::Space;
use glam::DVec3;
use obvhs::aabb::Aabb;

/// By how much of a space a triangle is larger for a ray: its box by the padding, and itself by the
/// tolerance of its edges, which is about six times as much.
const GROWTH: f32 = 6.0 * PADDING;

/// Primitives below this size are lost.
const LOST: f32 = 8.0 * GROWTH;

/// The most sides of a space that a cluster is wide.
const WIDEST: f64 = 1.0 / 16.0;

/// The fewest primitives that are lost in a cluster, and what is enough even if it is less than one
/// in so many.
const LEAST: usize = 4;
const ENOUGH: usize = 12;
const SHARE: usize = 8;

/// A cluster is isolated if it is part of something so many times as wide. Most rays that meet one
/// end in it, the next start there, and a space of its own costs them nothing.
const ISOLATED: f32 = 8.0;

/// The cost of rays that enter another cluster's space, in exact tests.
const ENTRY_COST: f32 = 16.0;

/// The primitives of a box that stay in its space, and clusters of those that do not; all in order.
pub(super) fn part(
    shapes: &[Shape],
    primitives: Vec<u32>,
    bounds: &Bounds,
) -> (Vec<u32>, Vec<Vec<u32>>) {
    let (center, extent) = cube(bounds);
    let space = Space::new(center, extent);
    let place = |primitive: u32| {
        let b = shapes[primitive as usize].bounds();
        let (min, max) = (space.place(b.min).as_vec3a(), space.place(b.max).as_vec3a());
        Aabb::new(min, max)
    };
    let smaller = |primitives: &[u32], size: f32| -> (Vec<u32>, Vec<Aabb>) {
        primitives
            .iter()
            .map(|&primitive| (primitive, place(primitive)))
            .filter(|(_, b)| (b.max - b.min).max_element() < size)
            .unzip()
    };
    let least = (primitives.len() / SHARE).clamp(LEAST, ENOUGH);
    let widest = (2.0 * WIDEST * extent * space.inverse_extent) as f32;
    // Those that are not lost make no cluster, but belong to it.
    let (_, boxes) = smaller(&primitives, LOST);
    if clusters(&boxes, widest, least).is_empty() {
        return (primitives, Vec::new());
    }
    let (small, boxes) = smaller(&primitives, widest);
    let mut clusters = clusters(&boxes, widest, least);
    for member in clusters.iter_mut().flatten() {
        *member = small[*member as usize];
    }
    clusters.iter_mut().for_each(|cluster| cluster.sort_unstable());
    let mut lost: Vec<u32> = clusters.concat();
    lost.sort_unstable();
    let mut lost = lost.into_iter().peekable();
    let rest = primitives.into_iter().filter(|p| lost.next_if_eq(p).is_none()).collect();
    (rest, clusters)
}

/// The largest clusters of some boxes that pay. In isolated ones so many are lost; in others rays
/// meet more in vain, by the surface area heuristic, than entering a space costs.
fn clusters(boxes: &[Aabb], widest: f32, least: usize) -> Vec<Vec<u32>> {
    if boxes.len() < least {
        return Vec::new();
    }
    let tree = binary::build(boxes);
    let mut order = vec![0u32];
    let mut at = 0;
    while let Some(&index) = order.get(at) {
        let node = &tree.nodes[index as usize];
        if !node.is_leaf() {
            order.extend([node.first_index, node.first_index + 1]);
        }
        at += 1;
    }
    let width = |b: &Aabb| (b.max - b.min).max_element();
    let padded = |b: &Aabb| Aabb::new(b.min - GROWTH, b.max + GROWTH).half_area();
    // The numbers of primitives and of those that are lost, and what is met in vain.
    let mut sums = vec![(0usize, 0usize, 0.0f32); tree.nodes.len()];
    for &index in order.iter().rev() {
        let node = &tree.nodes[index as usize];
        sums[index as usize] = if node.is_leaf() {
            let b = node.aabb();
            (1, usize::from(width(b) < LOST), padded(b) - b.half_area())
        } else {
            let [a, b] = [0, 1].map(|i| sums[(node.first_index + i) as usize]);
            (a.0 + b.0, a.1 + b.1, a.2 + b.2)
        };
    }
    let mut found: Vec<Vec<u32>> = Vec::new();
    // Nodes with the widths of their parents and the places of the clusters that they belong to.
    let mut stack = vec![(0u32, f32::INFINITY, None)];
    while let Some((index, around, cluster)) = stack.pop() {
        let node = &tree.nodes[index as usize];
        let (count, lost, in_vain) = sums[index as usize];
        let wide = width(node.aabb());
        let pays = if around >= ISOLATED * wide {
            lost >= least.max(count / SHARE)
        } else {
            lost >= least && in_vain >= ENTRY_COST * padded(node.aabb())
        };
        let cluster = cluster.or_else(|| {
            (pays && wide <= widest).then(|| {
                found.push(Vec::new());
                found.len() - 1
            })
        });
        if !node.is_leaf() {
            let children = [node.first_index, node.first_index + 1];
            stack.extend(children.map(|child| (child, wide, cluster)));
        } else if let Some(cluster) = cluster {
            found[cluster].push(tree.primitive_indices[node.first_index as usize]);
        }
    }
    joined(boxes, found, widest)
}

/// Clusters with those that the tree has cut put together again: two that touch or nearly do.
fn joined(boxes: &[Aabb], clusters: Vec<Vec<u32>>, widest: f32) -> Vec<Vec<u32>> {
    let width = |b: &Aabb| (b.max - b.min).max_element();
    let mut parts: Vec<(Aabb, Vec<u32>)> = Vec::new();
    for mut cluster in clusters {
        let mut bounds = cluster.iter().fold(Aabb::empty(), |b, &i| b.union(&boxes[i as usize]));
        while let Some(other) = parts.iter().position(|(other, _)| {
            let both = width(&bounds.union(other));
            both <= widest.min(width(&bounds) + width(other) + PADDING)
        }) {
            let (other, members) = parts.swap_remove(other);
            bounds = bounds.union(&other);
            cluster.extend(members);
        }
        parts.push((bounds, cluster));
    }
    parts.into_iter().map(|(_, cluster)| cluster).collect()
}

/// True if a ray inside of a box, given by its middle and half its sides, may meet a shape there.
pub(super) fn reaches(shape: &Shape, center: DVec3, half: DVec3) -> bool {
    let bounds = shape.bounds();
    let (min, max) = (bounds.min - center, bounds.max - center);
    let most = min.abs().max(max.abs()).max_element();
    let half = half + blur(most);
    if !(min.cmple(half).all() && max.cmpge(-half).all()) {
        return false;
    }
    // The plane with a normal `a` × `b`.
    let plane = |point: DVec3, a: DVec3, b: DVec3| {
        let normal = a.cross(b);
        let rounding = blur(most) * a.length() * b.length();
        normal.dot(point - center).abs() <= normal.abs().dot(half) + rounding
    };
    match *shape {
        Shape::Triangle(Triangle { vertices: [a, b, c] }) => plane(a, b - a, c - a),
        Shape::Quad(Quad { origin, edge_u, edge_v }) => plane(origin, edge_u, edge_v),
        Shape::Disk(Disk { center: middle, normal, .. }) => {
            let (x, y) = normal.any_orthonormal_pair();
            plane(middle, x, y)
        }
        Shape::Sphere(Sphere { center: middle, radius, .. }) => {
            let offset = (middle - center).abs();
            (offset - half).max(DVec3::ZERO).length() <= radius + blur(most)
                && (offset + half).length() >= radius - blur(most)
        }
    }
}
