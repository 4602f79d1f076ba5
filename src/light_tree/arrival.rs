//! The part of each light that was seen to arrive.

use super::LightTree;
use super::node::{CHILDREN, Child};
use crate::math::distribution::{AliasTable, relative};
use std::collections::BTreeMap;

/// The share of the choice of where light walks start that all lights have alike: so none is
/// starved by what was seen by chance.
pub(crate) const FLOOR: f64 = 0.1;
/// Trials that what is known of a branch is worth for the parts of it; more where contributions of
/// very different size are counted.
const PRIOR: f64 = 4.0;
const PRIOR_OF_CONTRIBUTIONS: f64 = 16.0;
/// The probability that nothing at all of a branch arrives, before it was tried.
const HIDDEN: f64 = 0.1;

/// Trials of lights, and what came of them.
#[derive(Clone, Debug, Default)]
pub struct Trials {
    /// Of the items that were tried, in their order: sums do not depend on who drew what.
    of_items: BTreeMap<u32, Record>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Record {
    trials: f64,
    arrivals: f64,
    contribution: f64,
}

impl Record {
    fn plus(self, other: &Self) -> Self {
        Self {
            trials: self.trials + other.trials,
            arrivals: self.arrivals + other.arrivals,
            contribution: self.contribution + other.contribution,
        }
    }
}

impl Trials {
    /// Enters a trial of an item, with its contribution to the picture, 0 if no light arrived. It
    /// counts as its probability without an [`Arrival`] over that by which it was drawn.
    pub fn push(&mut self, item: u32, weight: f64, contribution: f64) {
        let arrivals = if contribution > 0.0 { weight } else { 0.0 };
        let record = self.of_items.entry(item).or_default();
        *record = record.plus(&Record { trials: weight, arrivals, contribution });
    }

    /// Adds the trials of another list.
    pub fn add(&mut self, other: &Self) {
        for (item, record) in &other.of_items {
            let sum = self.of_items.entry(*item).or_default();
            *sum = sum.plus(record);
        }
    }

    /// Number of trials, and of those that arrived.
    #[must_use]
    pub fn total(&self) -> [f64; 2] {
        let all = self.sum();
        [all.trials, all.arrivals]
    }

    fn sum(&self) -> Record {
        self.of_items.values().fold(Record::default(), Record::plus)
    }

    fn of(&self, item: u32) -> Record {
        self.of_items.get(&item).copied().unwrap_or_default()
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
    /// The part of a branch is that of the one that it belongs to, q, until trials say more: after n
    /// of them and k arrivals it is `(k + mq)/(n + m)`, m = 4. If nothing arrived where other branches
    /// had arrivals, it is q times the probability that this was chance, or times the mean that Bayes'
    /// rule gives to a part of which nothing is known; in both cases against a probability of 0.1 that
    /// the branch is hidden altogether.
    ///
    /// Where walks start, light counts by half by the part of its walks that arrive, and by half by
    /// what it contributed to the picture through connections, which see it sooner.
    #[must_use]
    pub fn new(tree: &LightTree, connections: &Trials, walks: &Trials) -> Self {
        let arrivals = |record: Record| [record.trials, record.arrivals];
        let parts = tree.parts(PRIOR, |item| arrivals(connections.of(item)));
        let regardless = tree.regardless.as_ref().and_then(|table| {
            let by_walks = tree.parts(PRIOR, |item| arrivals(walks.of(item)));
            let Record { trials, contribution, .. } = connections.sum();
            let mean = if contribution > 0.0 { contribution / trials } else { 1.0 };
            let by_contribution = tree.parts(PRIOR_OF_CONTRIBUTIONS, |item| {
                [trials * table.pmf(item as usize), connections.of(item).contribution / mean]
            });
            let shares = [by_walks, by_contribution].map(|parts| tree.scaled(table, &parts));
            let weights: Vec<f64> = shares[0].iter().zip(&shares[1]).map(|(a, b)| a + b).collect();
            AliasTable::new(&with_floor(&weights))
        });
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
    let weights = relative(weights);
    let total: f64 = weights.iter().sum();
    let count = weights.iter().filter(|weight| **weight > 0.0).count() as f64;
    let share = |weight: &f64| match *weight > 0.0 {
        true => (1.0 - FLOOR) * (weight / total) + FLOOR / count,
        false => 0.0,
    };
    weights.iter().map(share).collect()
}

impl LightTree {
    /// The part of each child of each node, by what is expected of each item and what was seen.
    fn parts(&self, prior: f64, of_item: impl Fn(u32) -> [f64; 2]) -> Vec<[f64; CHILDREN]> {
        let sum = |of_children: &[[f64; 2]; CHILDREN]| {
            of_children.iter().fold([0.0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]])
        };
        let mut sums = vec![[[0.0; 2]; CHILDREN]; self.nodes.len()];
        for (number, node) in self.nodes.iter().enumerate().rev() {
            for (i, child) in node.children() {
                sums[number][i] = match child {
                    Child::Item(item) => of_item(item),
                    Child::Node(child) => sum(&sums[child as usize]),
                };
            }
        }
        let mut parts = vec![[1.0; CHILDREN]; self.nodes.len()];
        let mut of_node = vec![1.0; self.nodes.len()];
        for (number, node) in self.nodes.iter().enumerate() {
            let [_, seen_of_all] = sum(&sums[number]);
            for (i, child) in node.children() {
                let [expected, seen] = sums[number][i];
                let part = match seen_of_all > 0.0 {
                    true => part(of_node[number], prior, expected, seen),
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

    /// The shares of items in a choice that is scaled by parts.
    fn scaled(&self, table: &AliasTable, parts: &[[f64; CHILDREN]]) -> Vec<f64> {
        let mut shares: Vec<f64> = (0..table.len()).map(|item| table.pmf(item)).collect();
        for (node, parts) in self.nodes.iter().zip(parts) {
            for (i, child) in node.children() {
                if let Child::Item(item) = child {
                    shares[item as usize] *= parts[i];
                }
            }
        }
        let total: f64 = shares.iter().sum();
        shares.iter().map(|share| share / total).collect()
    }
}

/// The part of a branch of one whose part is q; see [`Arrival::new`].
fn part(q: f64, prior: f64, expected: f64, seen: f64) -> f64 {
    if seen > 0.0 {
        return (seen + prior * q) / (expected + prior);
    }
    // Of parts q and, uniformly, 0 to 1.
    let shown = 1.0 - HIDDEN;
    let by_chance = shown * libm::exp(-q * expected);
    let rarely = shown / (HIDDEN * (expected + 1.0) + shown) / (expected + 2.0);
    q * (by_chance / (HIDDEN + by_chance)).max(rarely)
}
