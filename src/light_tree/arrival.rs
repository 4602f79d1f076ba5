//! The part of each light that was seen to arrive.

use super::LightTree;
use super::node::{CHILDREN, Child};
use crate::math::distribution::AliasTable;

/// The share of the choice of where light walks start that all lights have alike: so none is
/// starved by what was seen by chance.
pub(crate) const FLOOR: f64 = 0.1;

/// Trials of lights, and those that light came of.
#[derive(Clone, Debug, Default)]
pub struct Trials {
    /// Of each item: trials, and arrivals.
    counts: Vec<[f64; 2]>,
}

impl Trials {
    /// Enters a trial of an item. It counts as its probability without an [`Arrival`] over that by
    /// which it was drawn.
    pub fn push(&mut self, item: u32, weight: f64, arrives: bool) {
        let length = self.counts.len().max(item as usize + 1);
        self.counts.resize(length, [0.0; 2]);
        let [trials, arrivals] = &mut self.counts[item as usize];
        *trials += weight;
        *arrivals += if arrives { weight } else { 0.0 };
    }

    /// Adds the trials of another list.
    pub fn add(&mut self, other: &Self) {
        self.counts.resize(self.counts.len().max(other.counts.len()), [0.0; 2]);
        for (sum, count) in self.counts.iter_mut().zip(&other.counts) {
            *sum = [sum[0] + count[0], sum[1] + count[1]];
        }
    }

    /// Trials and arrivals of all items.
    #[must_use]
    pub fn total(&self) -> [f64; 2] {
        sum(&self.counts)
    }
}

/// The part of the light of each branch of a [`LightTree`] that arrives, as it was seen in trials.
/// A choice that is scaled by it is as right as the tree's own, whatever it says.
#[derive(Clone, Debug)]
pub struct Arrival {
    /// Of each child of each node.
    parts: Vec<[f32; CHILDREN]>,
    regardless: Option<AliasTable>,
}

impl Arrival {
    /// The parts that arrive, by trials of connections to a receiver and by trials of walks that
    /// start at lights.
    ///
    /// A branch that had n trials and k arrivals counts as `(k + q)/(n + 1)`, where q is what counts
    /// of the branch that it is part of. Within one of which nothing arrived all parts are alike: what
    /// was tried too rarely is not given up. Walks are few and go astray; so where they start the
    /// larger part of both kinds counts, and that of connections if no walk arrived.
    #[must_use]
    pub fn new(tree: &LightTree, connections: &Trials, walks: &Trials) -> Self {
        let parts = tree.parts(connections);
        let [_, arrivals] = walks.total();
        let of_walks = if arrivals > 0.0 { tree.parts(walks) } else { parts.clone() };
        let weights = tree.regardless.as_ref().map(|table| {
            let mut weights: Vec<f64> = (0..table.len()).map(|item| table.pmf(item)).collect();
            for (node, (by_walk, by_connection)) in
                tree.nodes.iter().zip(of_walks.iter().zip(&parts))
            {
                for (i, child) in node.children() {
                    if let Child::Item(item) = child {
                        weights[item as usize] *= by_walk[i].max(by_connection[i]);
                    }
                }
            }
            with_floor(&weights)
        });
        let regardless = weights.and_then(|weights| AliasTable::new(&weights));
        Self { parts: parts.into_iter().map(|of| of.map(|part| part as f32)).collect(), regardless }
    }

    #[inline]
    pub(super) fn of_children(&self, node: u32) -> &[f32; CHILDREN] {
        &self.parts[node as usize]
    }

    #[inline]
    pub(super) fn regardless(&self) -> Option<&AliasTable> {
        self.regardless.as_ref()
    }
}

/// Shares by weight, but for a floor that all of positive weight have alike.
pub(crate) fn with_floor(weights: &[f64]) -> Vec<f64> {
    // Scaled first: the sum of large weights must not overflow.
    let largest = weights.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let total: f64 = weights.iter().map(|weight| weight / largest).sum();
    let count = weights.iter().filter(|weight| **weight > 0.0).count() as f64;
    let share = |weight: &f64| match *weight > 0.0 {
        true => (1.0 - FLOOR) * (weight / largest / total) + FLOOR / count,
        false => 0.0,
    };
    weights.iter().map(share).collect()
}

impl LightTree {
    /// The part that arrives of the light of each child of each node.
    fn parts(&self, trials: &Trials) -> Vec<[f64; CHILDREN]> {
        let mut counts = vec![[[0.0; 2]; CHILDREN]; self.nodes.len()];
        for (number, node) in self.nodes.iter().enumerate().rev() {
            for (i, child) in node.children() {
                counts[number][i] = match child {
                    Child::Item(item) => {
                        trials.counts.get(item as usize).copied().unwrap_or_default()
                    }
                    Child::Node(child) => sum(&counts[child as usize]),
                };
            }
        }
        let mut parts = vec![[1.0; CHILDREN]; self.nodes.len()];
        let mut of_node = vec![1.0; self.nodes.len()];
        for (number, node) in self.nodes.iter().enumerate() {
            let [_, arrivals_of_all] = sum(&counts[number]);
            for (i, child) in node.children() {
                let [trials, arrivals] = counts[number][i];
                let part = match arrivals_of_all > 0.0 {
                    true => (arrivals + of_node[number]) / (trials + 1.0),
                    false => of_node[number],
                };
                parts[number][i] = part;
                if let Child::Node(child) = child {
                    of_node[child as usize] = part;
                }
            }
        }
        parts
    }
}

fn sum(counts: &[[f64; 2]]) -> [f64; 2] {
    counts.iter().fold([0.0; 2], |sum, count| [sum[0] + count[0], sum[1] + count[1]])
}
