//! The distributions of directions over a scene: a binary tree of its space, which is divided where
//! many records are.

use super::Quadtree;
use super::quadtree::{Place, place};
use crate::geometry::Bounds;
use glam::DVec3;

/// Most leaves, and most nodes of all their quadtrees: 13 MB with those that are being learnt.
const LEAVES: usize = 1 << 11;
const NODES: usize = 1 << 17;
/// A leaf is divided if it has more than this times √n of n records with energy: then leaves and the
/// records in each grow alike.
const RECORDS: f64 = 6.0;
/// A leaf is guided unless the second moment without that is less than this part of that with it:
/// what was tried was learnt from fewer records than are there now.
const MARGIN: f64 = 0.8;

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
    /// True if walks are guided here.
    is_used: bool,
    /// Second moments of what was estimated here, without guiding and with it.
    moments: [f64; 2],
    /// Energies learnt since, and the number of records and the box around them.
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
    moments: [f64; 2],
}

impl Field {
    /// A field that knows nothing.
    #[must_use]
    pub fn unknown() -> Self {
        let learnt = Quadtree::empty();
        let leaf = Leaf {
            part: 0,
            density: None,
            is_used: false,
            moments: [0.0; 2],
            learnt,
            records: 0,
            bounds: Bounds::EMPTY,
        };
        Self { parts: vec![Part::Leaf(0)], leaves: vec![leaf] }
    }

    /// One distribution everywhere.
    #[cfg(test)]
    pub(super) fn of(density: Quadtree) -> Self {
        let mut field = Self::unknown();
        (field.leaves[0].density, field.leaves[0].is_used) = (Some(density), true);
        field
    }

    /// The number of distributions.
    #[must_use]
    pub fn known(&self) -> usize {
        self.leaves.iter().filter(|leaf| leaf.density.is_some() && leaf.is_used).count()
    }

    /// The distribution at a point; `None` where nothing is known.
    #[inline]
    #[must_use]
    pub fn at(&self, point: DVec3) -> Option<&Quadtree> {
        let leaf = &self.leaves[self.leaf(point) as usize];
        leaf.density.as_ref().filter(|_| leaf.is_used)
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

    /// The record of an estimate at a point, by a direction that was sampled with a density per
    /// solid angle, and that the BSDF would have sampled with another; `None` unless it is a number.
    #[inline]
    #[must_use]
    pub fn record(
        &self,
        point: DVec3,
        direction: DVec3,
        energy: f64,
        [pdf, plain]: [f64; 2],
        alpha: f64,
    ) -> Option<Record> {
        let leaf = self.leaf(point);
        let mut moments = [0.0; 2];
        if let Some(density) = &self.leaves[leaf as usize].density
            && energy > 0.0
        {
            let guided = alpha * plain + (1.0 - alpha) * density.density(direction).value();
            moments = [plain, guided].map(|p| energy * energy * pdf / p);
        }
        let is_finite = energy.is_finite() && moments.iter().all(|m| m.is_finite());
        is_finite.then(|| Record { leaf, point, place: place(direction), energy, moments })
    }

    /// Takes in records of this field, in their order.
    pub fn learn(&mut self, records: &[Record]) {
        for &Record { leaf, point, place, energy, moments } in records {
            let Some(leaf) = self.leaves.get_mut(leaf as usize) else { continue };
            if energy > 0.0 {
                leaf.records += 1;
                leaf.bounds = leaf.bounds.union(Bounds { min: point, max: point });
                leaf.learnt.add(place, energy);
                for (sum, moment) in leaf.moments.iter_mut().zip(moments) {
                    *sum += moment;
                }
            }
        }
    }

    /// Makes the distributions of what was learnt since the last time, and divides space and
    /// directions anew for what comes.
    pub fn update(&mut self) {
        let records: u64 = self.leaves.iter().map(|leaf| leaf.records).sum();
        let most = RECORDS * (records as f64).sqrt();
        for leaf in &mut self.leaves {
            let [plain, guided] = leaf.moments;
            leaf.is_used = plain > MARGIN * guided;
            leaf.density = leaf.learnt.normalized();
            leaf.moments = [0.0; 2];
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
