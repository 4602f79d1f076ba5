//! The choice of a light for a receiver: a tree of lights, which the receiver goes down by what
//! each part could send it (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with
//! Adaptive Tree Splitting").
//!
//! The same [`LightTree`] chooses among the lights of a scene and among the triangles of one
//! emissive mesh. Choices are a mixture with one that no receiver has part in,
//!
//! ```text
//! p(i | x) = (1 - δ) Π I(child)/Σ I(children)  +  δ p(i),        δ = 0.1, or 0.02,
//! ```
//!
//! which bounds what a wrong estimate can do: a light hidden from the receiver, a glossy receiver.
//! Probabilities are exact, so multiple importance sampling may ask for those of any light.
//!
//! An [`Arrival`] tells what part of each branch's light was seen to arrive, and scales the
//! choice by it: light that never gets into the picture is hardly ever chosen any more.

mod arrival;
mod bounds;
mod build;
mod node;

pub(crate) use arrival::with_floor;
pub use arrival::{Arrival, Trials};
pub use bounds::LightBounds;

use crate::geometry::SurfacePoint;
use crate::math::distribution::{AliasTable, relative};
use node::{CHILDREN, Child, Node, Place, Receiver, Units};

/// δ, the share of the choice that does not depend on the receiver; less if it is known what
/// arrives.
const REGARDLESS: f64 = 0.1;
const REGARDLESS_OF_KNOWN: f64 = 0.02;
/// The largest number below 1.
const BELOW_ONE: f64 = 1.0 - 0.5 * f64::EPSILON;

/// A tree over lights, or over the parts of one, numbered from 0.
///
/// Nodes have up to four children, whose importances are compared at a time; so up to four lights
/// are compared one by one. Takes at most 150 bytes a light where there are many.
#[derive(Clone, Debug)]
pub struct LightTree {
    /// The root first; empty if there are less than two items.
    nodes: Vec<Node>,
    units: Units,
    /// Number of items that may be chosen, and one of them.
    len: usize,
    only: u32,
    places: Vec<Place>,
    regardless: Option<AliasTable>,
}

impl LightTree {
    /// The most items that a tree can have: 2²⁸.
    pub const MOST_ITEMS: usize = 1 << 28;

    /// A tree over items of given bounds, and the weights of their choice without regard to a
    /// receiver; what has weight 0 is never chosen. Intensities and weights are relative.
    ///
    /// # Panics
    /// There are not as many weights as bounds, or more than [`MOST_ITEMS`](Self::MOST_ITEMS).
    #[must_use]
    pub fn new(lights: &[LightBounds], weights: &[f64]) -> Self {
        assert_eq!(lights.len(), weights.len(), "a weight for each light");
        assert!(lights.len() <= Self::MOST_ITEMS, "too many lights");
        let regardless = AliasTable::new(&relative(weights));
        let chosen = (0..).zip(lights).zip(weights).filter(|(_, weight)| **weight > 0.0);
        let chosen = chosen.filter(|_| regardless.is_some());
        let strongest =
            lights.iter().map(|light| light.intensity).fold(f64::MIN_POSITIVE, f64::max);
        let relative = |l: &LightBounds| LightBounds { intensity: l.intensity / strongest, ..*l };
        let items: Vec<_> = chosen.map(|((item, light), _)| (item, relative(light))).collect();
        let (len, only) = (items.len(), items.first().map_or(0, |(item, _)| *item));
        let units = Units::of(&items);
        let (nodes, places) = build::build(items, lights.len(), &units);
        Self { nodes, units, len, only, places, regardless }
    }

    /// Chooses an item for a receiver with a number in `[0, 1)`; returns its probability too.
    /// `None` if nothing can reach the receiver, or there is nothing.
    #[inline]
    #[must_use]
    pub fn sample(
        &self,
        x: &SurfacePoint,
        arrival: Option<&Arrival>,
        u: f64,
    ) -> Option<(u32, f64)> {
        let regardless = regardless(self, arrival)?;
        if self.len == 1 {
            return Some((self.only, 1.0));
        }
        let delta = delta(arrival);
        if u < delta {
            let (item, pmf) = regardless.sample(u / delta);
            return Some((item as u32, self.mixture(x, arrival, item as u32, pmf)));
        }
        let u = (u - delta) / (1.0 - delta);
        let (item, pmf) = self.find(self.by_receiver(x, arrival), u)?;
        Some((item, delta * regardless.pmf(item as usize) + (1.0 - delta) * pmf))
    }

    /// The probability with which [`sample`](Self::sample) chooses an item for the same receiver.
    #[inline]
    #[must_use]
    pub fn pmf(&self, x: &SurfacePoint, arrival: Option<&Arrival>, item: u32) -> f64 {
        let Some(table) = regardless(self, arrival) else { return 0.0 };
        if self.len == 1 {
            return if self.only == item { 1.0 } else { 0.0 };
        }
        self.mixture(x, arrival, item, table.pmf(item as usize))
    }

    /// Chooses an item without regard to a receiver.
    #[inline]
    #[must_use]
    pub fn sample_regardless(&self, arrival: Option<&Arrival>, u: f64) -> Option<(u32, f64)> {
        let (item, pmf) = regardless(self, arrival)?.sample(u);
        Some((item as u32, pmf))
    }

    /// The only item, if there is one and no other.
    #[inline]
    pub(crate) fn only(&self) -> Option<u32> {
        (self.len == 1).then_some(self.only)
    }

    /// The probability with which [`sample_regardless`](Self::sample_regardless) chooses an item.
    #[inline]
    #[must_use]
    pub fn pmf_regardless(&self, arrival: Option<&Arrival>, item: u32) -> f64 {
        regardless(self, arrival).map_or(0.0, |table| table.pmf(item as usize))
    }

    /// Chooses an item with the same chance for each child of a node, so that what is apart from many
    /// others is found among them.
    #[must_use]
    pub fn sample_evenly(&self, u: f64) -> Option<(u32, f64)> {
        if self.len < 2 {
            return (self.len == 1).then_some((self.only, 1.0));
        }
        self.find(|_, node| node.evenly(), u)
    }

    /// The probability with which [`sample_evenly`](Self::sample_evenly) chooses an item.
    #[must_use]
    pub fn pmf_evenly(&self, item: u32) -> f64 {
        if self.pmf_regardless(None, item) == 0.0 {
            return 0.0;
        }
        if self.len == 1 { 1.0 } else { self.probability(|_, node| node.evenly(), item) }
    }

    /// Number of items that may be chosen.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// True if there is nothing to choose.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Bytes that it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let table = self.regardless.as_ref().map_or(0, |table| table.len() * 24);
        size_of_val(&self.nodes[..]) + size_of_val(&self.places[..]) + table
    }

    /// The probability of an item, given the one without regard to the receiver.
    fn mixture(
        &self,
        x: &SurfacePoint,
        arrival: Option<&Arrival>,
        item: u32,
        regardless: f64,
    ) -> f64 {
        if regardless == 0.0 {
            return 0.0;
        }
        let delta = delta(arrival);
        delta * regardless + (1.0 - delta) * self.probability(self.by_receiver(x, arrival), item)
    }

    /// The shares of a node's children: what each could send to a receiver, and the part of it that
    /// arrives.
    #[inline]
    fn by_receiver<'t>(
        &self,
        x: &SurfacePoint,
        arrival: Option<&'t Arrival>,
    ) -> impl Fn(u32, &Node) -> [f64; CHILDREN] + use<'t> {
        let receiver = Receiver::new(x, &self.units);
        move |number, node| {
            let mut shares = node.importances(&receiver);
            if let Some(arrival) = arrival {
                let parts = arrival.of_children(number);
                shares = std::array::from_fn(|i| shares[i] * f64::from(parts[i]));
            }
            shares
        }
    }

    /// Goes down from the root with a number in `[0, 1)`, by the shares of children. Returns the item
    /// and its probability; `None` where no child has a share.
    #[inline]
    fn find(
        &self,
        shares: impl Fn(u32, &Node) -> [f64; CHILDREN],
        mut u: f64,
    ) -> Option<(u32, f64)> {
        self.descend(shares, |shares, total| {
            let (mut from, mut chosen) = (0.0, None);
            for (child, share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                chosen = Some((child, from, *share));
                if u * total < from + share {
                    break;
                }
                from += share;
            }
            let (child, from, share) = chosen?;
            u = ((u * total - from) / share).clamp(0.0, BELOW_ONE);
            Some(child)
        })
    }

    /// The probability of finding an item; to the bit that which is found with it.
    #[inline]
    fn probability(&self, shares: impl Fn(u32, &Node) -> [f64; CHILDREN], item: u32) -> f64 {
        // Two bits a level, those of the root in the lowest place.
        let mut place = self.places[item as usize];
        let mut way = place.child() as u64;
        while place.node() != 0 {
            place = self.nodes[place.node()].place;
            way = way << 2 | place.child() as u64;
        }
        let found = self.descend(shares, |_, _| {
            let child = (way & 3) as usize;
            way >>= 2;
            Some(child)
        });
        found.map_or(0.0, |(_, pmf)| pmf)
    }

    /// Goes down from the root by the children that are chosen, given the shares of all and their sum.
    #[inline]
    fn descend(
        &self,
        shares: impl Fn(u32, &Node) -> [f64; CHILDREN],
        mut choose: impl FnMut(&[f64; CHILDREN], f64) -> Option<usize>,
    ) -> Option<(u32, f64)> {
        let (mut number, mut pmf) = (0, 1.0);
        loop {
            let node = &self.nodes[number as usize];
            let shares = shares(number, node);
            let total: f64 = shares.iter().sum();
            if total.is_nan() || total <= 0.0 {
                return None;
            }
            let child = choose(&shares, total)?;
            pmf *= shares[child] / total;
            match node.child(child) {
                Child::Node(next) => number = next,
                Child::Item(item) => return Some((item, pmf)),
            }
        }
    }
}

#[inline]
fn delta(arrival: Option<&Arrival>) -> f64 {
    if arrival.is_some() { REGARDLESS_OF_KNOWN } else { REGARDLESS }
}

#[inline]
fn regardless<'t>(tree: &'t LightTree, arrival: Option<&'t Arrival>) -> Option<&'t AliasTable> {
    match arrival {
        Some(arrival) => arrival.regardless(),
        None => tree.regardless.as_ref(),
    }
}
