//! The distributions of directions over a scene: a binary tree of its space, which is divided where
//! many records are.

use super::Quadtree;
use super::quadtree::{Place, place};
use crate::geometry::Bounds;
use glam::DVec3;

/// Most leaves, and most nodes of all their quadtrees: 13 MB with those that are being learnt.
const LEAVES: usize = 1 << 11;
const NODES: usize = 1 << 17;
/// A leaf is divided if it has more than this times √n of n records: then leaves and the records in
/// each grow alike.
const RECORDS: f64 = 6.0;

/// Distributions of directions, one for each part of space.
#[derive(Clone, Debug)]
pub struct Field {
    parts: Vec<Part>,
    leaves: Vec<Leaf>,
}

/// A part of space.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// The number of a leaf.
    Leaf(u32),
    /// A plane across an axis; what is below it and what is not are two parts from `parts` on.
    Split { axis: usize, at: f64, parts: u32 },
}

#[derive(Clone, Debug)]
struct Leaf {
    /// The index of its part.
    part: u32,
    density: Option<Quadtree>,
    /// What has been learnt since: energies, and the number of records and the box around them.
    learnt: Quadtree,
    records: u64,
    bounds: Bounds,
}

/// An observation of what arrives at a point.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    leaf: u32,
    point: DVec3,
    place: Place,
    energy: f64,
}

impl Field {
    /// A field that knows nothing.
    #[must_use]
    pub fn unknown() -> Self {
        let learnt = Quadtree::empty();
        let leaf = Leaf { part: 0, density: None, learnt, records: 0, bounds: Bounds::EMPTY };
        Self { parts: vec![Part::Leaf(0)], leaves: vec![leaf] }
    }

    /// The number of distributions.
    #[must_use]
    pub fn known(&self) -> usize {
        self.leaves.iter().filter(|leaf| leaf.density.is_some()).count()
    }

    /// The distribution at a point; `None` where nothing is known.
    #[inline]
    #[must_use]
    pub fn at(&self, point: DVec3) -> Option<&Quadtree> {
        self.leaves[self.leaf(point) as usize].density.as_ref()
    }

    #[inline]
    fn leaf(&self, point: DVec3) -> u32 {
        let mut part = 0;
        loop {
            match self.parts[part as usize] {
                Part::Leaf(leaf) => return leaf,
                Part::Split { axis, at, parts } => part = parts + u32::from(point[axis] >= at),
            }
        }
    }

    /// The record of radiance that arrives at a point from a direction, over the density per solid
    /// angle with which that was sampled; `None` unless it is a number.
    #[inline]
    #[must_use]
    pub fn record(&self, point: DVec3, direction: DVec3, energy: f64) -> Option<Record> {
        let leaf = self.leaf(point);
        energy.is_finite().then(|| Record { leaf, point, place: place(direction), energy })
    }

    /// Takes in records of this field, in their order.
    pub fn learn(&mut self, records: &[Record]) {
        for &Record { leaf, point, place, energy } in records {
            let Some(leaf) = self.leaves.get_mut(leaf as usize) else { continue };
            leaf.records += 1;
            leaf.bounds = leaf.bounds.union(Bounds { min: point, max: point });
            if energy > 0.0 {
                leaf.learnt.add(place, energy);
            }
        }
    }

    /// Makes the distributions of what was learnt since the last time, and divides space and
    /// directions anew for what comes.
    pub fn update(&mut self) {
        let records: u64 = self.leaves.iter().map(|leaf| leaf.records).sum();
        let most = RECORDS * (records as f64).sqrt();
        for leaf in &mut self.leaves {
            leaf.density = leaf.learnt.normalized();
        }
        let mut index = 0;
        while index < self.leaves.len() {
            while self.leaves[index].records as f64 > most
                && self.leaves.len() < LEAVES
                && self.split(index)
            {}
            index += 1;
        }
        let most = NODES / self.leaves.len();
        for leaf in &mut self.leaves {
            leaf.learnt = leaf.learnt.divided(most);
            (leaf.records, leaf.bounds) = (0, Bounds::EMPTY);
        }
    }

    /// Divides a leaf across the longest side of the box around its records, half of which count for
    /// each part; false if it cannot be.
    fn split(&mut self, index: usize) -> bool {
        let (leaf, below) = (&mut self.leaves[index], self.parts.len() as u32);
        let (size, middle) = (leaf.bounds.max - leaf.bounds.min, leaf.bounds.center());
        let axis = size.max_position();
        let at = middle[axis];
        if !(leaf.bounds.min[axis] < at && at < leaf.bounds.max[axis]) {
            return false;
        }
        leaf.records /= 2;
        let mut above = Leaf { part: below + 1, ..leaf.clone() };
        above.bounds.min[axis] = at;
        leaf.bounds.max[axis] = at;
        let part = std::mem::replace(&mut leaf.part, below);
        self.parts[part as usize] = Part::Split { axis, at, parts: below };
        self.parts.extend([Part::Leaf(index as u32), Part::Leaf(self.leaves.len() as u32)]);
        self.leaves.push(above);
        true
    }
}
