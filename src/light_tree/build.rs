//! The construction of a light tree: splits in bins by the surface area orientation heuristic.

use super::LightBounds;
use super::node::{CHILDREN, Node};
use std::collections::VecDeque;
use std::ops::Range;

/// Parts of an axis in which splits are looked for.
const BINS: usize = 12;
/// Levels that a way has room for, and those below which lights are split by number, so that the
/// rest, of a quarter of the lights each, always fits.
const LEVELS: u32 = 32;
const LEVELS_BY_COST: u32 = LEVELS - 16;

/// The nodes of a tree over the items of positive weight, the root first, and the way to each item.
pub(super) fn build(lights: &[LightBounds], weights: &[f64]) -> (Vec<Node>, Vec<u64>) {
    let largest = lights.iter().map(|l| l.intensity).fold(f64::MIN_POSITIVE, f64::max);
    let mut items: Vec<(u32, LightBounds)> = (0..)
        .zip(lights.iter().zip(weights))
        .filter(|(_, (_, weight))| **weight > 0.0)
        .map(|(i, (l, _))| (i, LightBounds { intensity: l.intensity / largest, ..*l }))
        .collect();
    // Those without bounds in front, for they have no place to be split by.
    items.sort_by_key(|(_, lights)| lights.is_bounded());
    let mut nodes = vec![Node::new(&union(&items))];
    let mut ways = vec![0; lights.len()];
    let mut open = VecDeque::from([(0, 0..items.len(), 0u32, 0u64)]);
    while let Some((node, range, level, way)) = open.pop_front() {
        if let [(item, _)] = items[range.clone()] {
            nodes[node].set_item(item);
            ways[item as usize] = way;
            continue;
        }
        let parts = parts(&mut items, range, level < LEVELS_BY_COST);
        let first = nodes.len();
        nodes[node].set_children(first as u32, parts.len());
        for (child, range) in parts.into_iter().enumerate() {
            nodes.push(Node::new(&union(&items[range.clone()])));
            let way = way | (child as u64).checked_shl(2 * level).unwrap_or(0);
            open.push_back((first + child, range, level + 1, way));
        }
    }
    (nodes, ways)
}

fn union(items: &[(u32, LightBounds)]) -> LightBounds {
    items.iter().fold(LightBounds::NONE, |all, (_, lights)| all.union(*lights))
}

/// Cuts a range of two or more items into up to four parts, the costliest first.
fn parts(
    items: &mut [(u32, LightBounds)],
    range: Range<usize>,
    by_cost: bool,
) -> Vec<Range<usize>> {
    let mut parts = vec![range];
    while parts.len() < CHILDREN {
        let largest = (0..parts.len()).filter(|i| parts[*i].len() > 1).max_by(|i, j| {
            let cost =
                |i: usize| if by_cost { cost(&union(&items[parts[i].clone()])) } else { 0.0 };
            (cost(*i).total_cmp(&cost(*j))).then(parts[*i].len().cmp(&parts[*j].len()))
        });
        let Some(largest) = largest else { break };
        let Range { start, end } = parts[largest].clone();
        let middle = if by_cost { partition(&mut items[start..end]) } else { None };
        let middle = start + middle.unwrap_or((end - start) / 2);
        parts[largest] = start..middle;
        parts.insert(largest + 1, middle..end);
    }
    parts
}

/// Intensity times surface area, of the sphere that stands for the box, times orientation.
fn cost(lights: &LightBounds) -> f64 {
    lights.intensity * lights.bounds.radius().powi(2) * lights.orientation()
}

/// Brings items into the order of the best split; returns its place. `None` if all are at the same
/// place.
fn partition(items: &mut [(u32, LightBounds)]) -> Option<usize> {
    let bounded = items.partition_point(|(_, lights)| !lights.is_bounded());
    if bounded > 0 {
        return (bounded < items.len()).then_some(bounded);
    }
    let middle = |lights: &LightBounds| lights.bounds.center();
    let (mut low, mut high) = (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY);
    for (_, lights) in &*items {
        (low, high) = (low.min(middle(lights)), high.max(middle(lights)));
    }
    let extent = high - low;
    let bin = |axis: usize, lights: &LightBounds| {
        let part = (middle(lights)[axis] - low[axis]) / extent[axis];
        ((part * BINS as f64) as usize).min(BINS - 1)
    };
    let mut best = (f64::INFINITY, 0, 0);
    for axis in (0..3).filter(|axis| extent[*axis] > 0.0) {
        let mut bins = [LightBounds::NONE; BINS];
        for (_, lights) in &*items {
            let bin = &mut bins[bin(axis, lights)];
            *bin = bin.union(*lights);
        }
        // Long boxes are cut across.
        let factor = extent.max_element() / extent[axis];
        let mut right = [0.0; BINS];
        let mut all = LightBounds::NONE;
        for i in (1..BINS).rev() {
            all = all.union(bins[i]);
            right[i] = cost(&all);
        }
        all = LightBounds::NONE;
        for i in 1..BINS {
            all = all.union(bins[i - 1]);
            let cost = factor * (cost(&all) + right[i]);
            if cost < best.0 && bins[i..].iter().any(|b| !b.bounds.is_empty()) {
                best = (cost, axis, i);
            }
        }
    }
    let (cost, axis, first) = best;
    cost.is_finite().then(|| {
        items.sort_by_key(|(_, lights)| bin(axis, lights) >= first);
        items.partition_point(|(_, lights)| bin(axis, lights) < first)
    })
}
