//! The construction of a light tree: splits in bins by the surface area orientation heuristic.

use super::LightBounds;
use super::node::{CHILDREN, Child, Node, Place, Units};
use std::collections::VecDeque;
use std::ops::Range;

/// Parts of an axis in which splits are looked for.
const BINS: usize = 12;
/// Levels that a way has room for, and those that are split by cost: further down each level divides
/// the number of lights by four.
const LEVELS: u32 = 32;
const LEVELS_BY_COST: u32 = LEVELS - 16;

/// The nodes of a tree over items, the root first, and the place of each of `count`.
pub(super) fn build(
    mut items: Vec<(u32, LightBounds)>,
    count: usize,
    units: &Units,
) -> (Vec<Node>, Vec<Place>) {
    let (mut nodes, mut places) = (Vec::new(), vec![Place::default(); count]);
    if items.len() < 2 {
        return (nodes, places);
    }
    // Those without bounds in front, for they have no place to be split by.
    items.sort_by_key(|(_, lights)| lights.is_bounded());
    nodes.push(Node::around(&union(&items), units, Place::default()));
    let mut open = VecDeque::from([(0, 0..items.len(), 0)]);
    while let Some((node, range, level)) = open.pop_front() {
        let parts = parts(&mut items, range, level < LEVELS_BY_COST);
        for (i, range) in parts.into_iter().enumerate() {
            let place = Place::new(node, i);
            let lights = union(&items[range.clone()]);
            let child = if range.len() == 1 {
                let item = items[range.start].0;
                places[item as usize] = place;
                Child::Item(item)
            } else {
                let next = nodes.len();
                nodes.push(Node::around(&lights, units, place));
                open.push_back((next, range, level + 1));
                Child::Node(next as u32)
            };
            nodes[node].set(i, &lights, units, child);
        }
    }
    (nodes, places)
}

fn union(items: &[(u32, LightBounds)]) -> LightBounds {
    items.iter().fold(LightBounds::NONE, |all, (_, lights)| all.union(*lights))
}

/// Cuts a range of two or more items into up to four parts.
fn parts(
    items: &mut [(u32, LightBounds)],
    range: Range<usize>,
    by_cost: bool,
) -> Vec<Range<usize>> {
    // Up to four items are children themselves, more are cut until a node has room for each part.
    let whole = if range.len() > CHILDREN { CHILDREN } else { 1 };
    let mut parts = vec![(range, 0.0f64)];
    while parts.len() < CHILDREN {
        let costliest = (0..parts.len()).filter(|i| parts[*i].0.len() > whole).max_by(|i, j| {
            let [(a, cost_a), (b, cost_b)] = [*i, *j].map(|i| &parts[i]);
            cost_a.total_cmp(cost_b).then(a.len().cmp(&b.len()))
        });
        let Some(costliest) = costliest else { break };
        let (Range { start, end }, _) = parts.swap_remove(costliest);
        let middle = if by_cost { partition(&mut items[start..end]) } else { None };
        let middle = start + middle.unwrap_or((end - start) / 2);
        for part in [start..middle, middle..end] {
            let is_split = by_cost && part.len() > whole;
            let cost = if is_split { cost(&union(&items[part.clone()])) } else { 0.0 };
            parts.push((part, cost));
        }
    }
    parts.into_iter().map(|(part, _)| part).collect()
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
