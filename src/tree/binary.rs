//! The binary tree that the wide one is made from, built from the root downwards by the surface
//! area heuristic (MacDonald and Booth 1990).
//!
//! Blocks of triangles are counted, not triangles, since a block costs the same however full
//! it is; so leaves get full. Many references are put into bins along each axis (Wald 2007), few
//! are sorted.

use super::layout::{Facet, LANES};
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::splits::split_aabbs_precise;
use obvhs::triangle::Triangle;

/// Places along an axis where many references can be divided are fewer than this by one.
const BINS: usize = 32;

/// The most references that are sorted, and divided wherever it is best.
const FEW: usize = 32;

/// Below this depth nodes are halved, so that no arrangement of boxes makes a tree too deep.
const DEEP: usize = 80;

/// Subtrees of so many references are worth a task of their own.
#[cfg(feature = "parallel")]
const TASK: usize = 4096;

/// Share of the nodes that are moved to better places when the tree is done.
const MOVED: f32 = 0.1;

/// Replaces the boxes of large triangles by several smaller ones that cover their parts, which
/// saves rays that pass beside a long thin triangle from testing it.
pub(super) fn split_large(
    boxes: &mut Vec<Aabb>,
    references: &mut Vec<u32>,
    facet: impl Fn(u32) -> (u32, Facet),
) {
    let (sum, largest) = boxes
        .iter()
        .map(Aabb::half_area)
        .fold((0.0f64, 0.0f32), |(sum, largest), a| (sum + f64::from(a), largest.max(a)));
    let average = (sum / boxes.len() as f64) as f32;
    let mut large = Vec::new();
    let mut parts = Vec::new();
    let mut triangles = Vec::new();
    for (i, b) in boxes.iter().enumerate() {
        if b.half_area() > 3.0 * average
            && let (_, Facet::Triangle { corners: [v0, v1, v2], .. }) = facet(references[i])
        {
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

/// The tree over some boxes, one in each leaf. The root is the first node.
pub(super) fn build(boxes: &[Aabb]) -> Bvh2 {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default(); (2 * boxes.len()).saturating_sub(1)];
    if let Some((root, below)) = nodes.split_first_mut() {
        divide(boxes, Subtree { root, below, next: 1, order: &mut order, first: 0, depth: 0 });
    }
    let mut tree = Bvh2 { nodes, primitive_indices: order, ..Bvh2::default() };
    // A few of the largest nodes make a tenth of difference where long thin boxes cross each other
    // (Meister and Bittner 2022).
    ReinsertionOptimizer::default().run(&mut tree, MOVED, None);
    tree
}

/// A part of the tree that is to be built.
struct Subtree<'a> {
    root: &'a mut Bvh2Node,
    /// The nodes below the root, twice as many as references but for two, and the index of the
    /// first of them.
    below: &'a mut [Bvh2Node],
    next: u32,
    /// The references, and the index of the first of them.
    order: &'a mut [u32],
    first: u32,
    depth: usize,
}

fn divide(boxes: &[Aabb], Subtree { root, below, next, order, first, depth }: Subtree<'_>) {
    let whole = order.iter().fold(Aabb::empty(), |whole, &i| whole.union(&boxes[i as usize]));
    let [left, right, below @ ..] = below else {
        *root = Bvh2Node::new(whole, 1, first);
        return;
    };
    *root = Bvh2Node::new(whole, 0, next);
    let count = match order.len() {
        _ if depth >= DEEP => None,
        ..=FEW => sort(boxes, order),
        _ => bin(boxes, order),
    }
    .unwrap_or(order.len() / 2);
    let (left_below, right_below) = below.split_at_mut(2 * count - 2);
    let (left_order, right_order) = order.split_at_mut(count);
    let next = next + 2;
    let right_next = next + left_below.len() as u32;
    let depth = depth + 1;
    #[cfg(feature = "parallel")]
    let large = left_order.len().min(right_order.len()) >= TASK;
    let left = Subtree { root: left, below: left_below, next, order: left_order, first, depth };
    let right = Subtree {
        root: right,
        below: right_below,
        next: right_next,
        order: right_order,
        first: first + count as u32,
        depth,
    };
    #[cfg(feature = "parallel")]
    if large {
        rayon::join(|| divide(boxes, left), || divide(boxes, right));
        return;
    }
    divide(boxes, left);
    divide(boxes, right);
}

/// The expected cost of a leaf, but for the area of what is around it.
fn cost(bounds: &Aabb, count: usize) -> f32 {
    bounds.half_area() * count.div_ceil(LANES) as f32
}

/// Twice the centre of a box.
fn middle(b: &Aabb) -> Vec3A {
    b.min + b.max
}

/// Sorts references along the axis that is best to divide them; returns the number of those on the
/// one side.
fn sort(boxes: &[Aabb], order: &mut [u32]) -> Option<usize> {
    let mut best = (f32::INFINITY, 0, 1);
    let mut costs = [0.0; FEW];
    let along = |axis: usize| {
        move |&i: &u32, &j: &u32| {
            middle(&boxes[i as usize])[axis]
                .total_cmp(&middle(&boxes[j as usize])[axis])
                .then(i.cmp(&j))
        }
    };
    for axis in 0..3 {
        order.sort_unstable_by(along(axis));
        let mut bounds = Aabb::empty();
        for (k, &i) in order.iter().enumerate() {
            bounds = bounds.union(&boxes[i as usize]);
            costs[k] = cost(&bounds, k + 1);
        }
        let mut bounds = Aabb::empty();
        for k in (1..order.len()).rev() {
            bounds = bounds.union(&boxes[order[k] as usize]);
            let cost = costs[k - 1] + cost(&bounds, order.len() - k);
            if cost < best.0 {
                best = (cost, axis, k);
            }
        }
    }
    let (_, axis, count) = best;
    if axis != 2 {
        order.sort_unstable_by(along(axis));
    }
    Some(count)
}

/// Divides references between two bins along the best axis; returns the number of those on the one
/// side, or `None` if all have the same centre.
fn bin(boxes: &[Aabb], order: &mut [u32]) -> Option<usize> {
    let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    for &i in &*order {
        let middle = middle(&boxes[i as usize]);
        (low, high) = (low.min(middle), high.max(middle));
    }
    let scale = (BINS as f32) / (high - low).max(Vec3A::splat(f32::MIN_POSITIVE));
    let place =
        |i: u32| ((middle(&boxes[i as usize]) - low) * scale).min(Vec3A::splat((BINS - 1) as f32));
    let mut bins = [[(Aabb::empty(), 0); BINS]; 3];
    for &i in &*order {
        let place = place(i);
        for (axis, bins) in bins.iter_mut().enumerate() {
            let (bounds, count) = &mut bins[place[axis] as usize % BINS];
            *bounds = bounds.union(&boxes[i as usize]);
            *count += 1;
        }
    }
    let mut best = None;
    let mut best_cost = f32::INFINITY;
    for (axis, bins) in bins.iter().enumerate() {
        let mut costs = [f32::INFINITY; BINS];
        let (mut bounds, mut count) = (Aabb::empty(), 0);
        for k in 1..BINS {
            (bounds, count) = (bounds.union(&bins[k - 1].0), count + bins[k - 1].1);
            costs[k] = if count > 0 { cost(&bounds, count) } else { f32::INFINITY };
        }
        let (mut bounds, mut count) = (Aabb::empty(), 0);
        for k in (1..BINS).rev() {
            (bounds, count) = (bounds.union(&bins[k].0), count + bins[k].1);
            let cost = if count > 0 { costs[k] + cost(&bounds, count) } else { f32::INFINITY };
            if cost < best_cost {
                (best, best_cost) = (Some((axis, k)), cost);
            }
        }
    }
    let (axis, k) = best?;
    let mut count = 0;
    for j in 0..order.len() {
        if (place(order[j])[axis] as usize) < k {
            order.swap(j, count);
            count += 1;
        }
    }
    Some(count)
}
