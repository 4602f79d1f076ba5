//! A distribution of directions: constant in the cells of a quadtree over the square of longitude
//! and height (φ, cos θ), which maps areas of the sphere to equal areas.

use crate::math::PerSolidAngle;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Levels of the tree: the most that a density can be is `4^20 / 4π`.
const DEPTH: u32 = 20;
/// A cell is divided if it has more than this share of the energy.
const SHARE: f64 = 0.01;
/// And at least so many records.
const FEWEST: u32 = 8;

/// A density of directions over the whole sphere, or the energies of which one is to be made.
#[derive(Clone, Debug)]
pub struct Quadtree {
    nodes: Vec<Node>,
}

/// Four quarters of a square, the second one right of the first, the last two above them.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    /// The share of each quarter, or its energy.
    shares: [f64; 4],
    /// The number of records of each.
    records: [u32; 4],
    /// The node that divides each quarter; 0 for none.
    nodes: [u32; 4],
}

/// A direction in the square, in units of 2^-32.
pub(super) type Place = [u32; 2];

/// The place of a unit vector.
#[inline]
pub(super) fn place(direction: DVec3) -> Place {
    let turn = 0.5 + libm::atan2(direction.y, direction.x) / TAU;
    // The cast stops at the largest number.
    [turn, 0.5 + 0.5 * direction.z].map(|x| (x * (1u64 << 32) as f64) as u32)
}

/// The quarter that contains a place, on a level.
#[inline]
fn quarter([x, y]: Place, level: u32) -> usize {
    let bit = |x: u32| (x >> (31 - level) & 1) as usize;
    bit(x) + 2 * bit(y)
}

impl Quadtree {
    /// A tree without energy, undivided.
    pub(super) fn empty() -> Self {
        Self { nodes: vec![Node::default()] }
    }

    /// The density in proportion to a function of the middles of cells, so many levels deep where
    /// that is not 0.
    #[cfg(test)]
    pub(super) fn of(levels: u32, energy: &dyn Fn(DVec2) -> f64) -> Self {
        fn grow(
            nodes: &mut Vec<Node>,
            corner: DVec2,
            levels: u32,
            size: f64,
            energy: &dyn Fn(DVec2) -> f64,
        ) -> f64 {
            let index = nodes.len();
            nodes.push(Node::default());
            let half = 0.5 * size;
            for i in 0..4usize {
                let corner = corner + half * DVec2::new((i & 1) as f64, (i >> 1) as f64);
                nodes[index].shares[i] = if levels == 1 {
                    energy(corner + 0.5 * half)
                } else {
                    let below = nodes.len();
                    let sum = grow(nodes, corner, levels - 1, half, energy);
                    if sum == 0.0 {
                        nodes.truncate(below);
                    } else {
                        nodes[index].nodes[i] = below as u32;
                    }
                    sum
                };
            }
            nodes[index].shares.iter().sum()
        }
        let mut nodes = Vec::new();
        grow(&mut nodes, DVec2::ZERO, levels, 1.0, energy);
        Self { nodes }.normalized().expect("some energy")
    }

    /// Density of a unit vector.
    #[inline]
    #[must_use]
    pub fn density(&self, direction: DVec3) -> PerSolidAngle {
        let (place, mut density, mut node) = (place(direction), 0.25 / PI, &self.nodes[0]);
        for level in 0.. {
            let quarter = quarter(place, level);
            density *= 4.0 * node.shares[quarter];
            match node.nodes[quarter] {
                0 => break,
                below => node = &self.nodes[below as usize],
            }
        }
        PerSolidAngle(density)
    }

    /// A unit vector drawn by the density, with numbers in `[0, 1)`.
    #[inline]
    #[must_use]
    pub fn sample(&self, mut u: DVec2) -> DVec3 {
        let (mut corner, mut size, mut node) = (DVec2::ZERO, 1.0, &self.nodes[0]);
        loop {
            let [a, b, c, d] = node.shares;
            let right = choose(&mut u.x, a + c, b + d);
            let above = if right { choose(&mut u.y, b, d) } else { choose(&mut u.y, a, c) };
            size *= 0.5;
            corner += size * DVec2::new(f64::from(u8::from(right)), f64::from(u8::from(above)));
            match node.nodes[usize::from(right) + 2 * usize::from(above)] {
                0 => break,
                below => node = &self.nodes[below as usize],
            }
        }
        let DVec2 { x: turn, y: height } = corner + size * u;
        let cos = 2.0 * height - 1.0;
        // 1 - cos² without loss of digits near the poles.
        let sin = 2.0 * (height * (1.0 - height)).sqrt();
        let (y, x) = libm::sincos(TAU * (turn - 0.5));
        DVec3::new(sin * x, sin * y, cos)
    }

    /// Adds energy where a direction is.
    #[inline]
    pub(super) fn add(&mut self, place: Place, energy: f64) {
        let mut index = 0;
        for level in 0.. {
            let (node, quarter) = (&mut self.nodes[index], quarter(place, level));
            node.shares[quarter] += energy;
            node.records[quarter] = node.records[quarter].saturating_add(1);
            match node.nodes[quarter] {
                0 => break,
                below => index = below as usize,
            }
        }
    }

    /// The density in proportion to the energies; `None` if there are none.
    pub(super) fn normalized(&self) -> Option<Self> {
        let mut tree = self.clone();
        for node in &mut tree.nodes {
            let total: f64 = node.shares.iter().sum();
            node.shares = node.shares.map(|energy| if total > 0.0 { energy / total } else { 0.25 });
        }
        let total = self.total();
        (total > 0.0 && total.is_finite()).then_some(tree)
    }

    fn total(&self) -> f64 {
        self.nodes[0].shares.iter().sum()
    }

    /// A tree without energy that is divided where this one has much, into so many nodes at most.
    pub(super) fn divided(&self, most: usize) -> Self {
        let least = SHARE * self.total();
        let mut nodes = vec![Node::default()];
        // Of each new node the one that it is made of, or the energy of a quarter of it.
        let mut origins = vec![(Some(0), (0.0, 0), 1)];
        let mut index = 0;
        while let Some(&(origin, quarter, depth)) = origins.get(index) {
            let origin = origin.map(|origin: u32| &self.nodes[origin as usize]);
            for i in 0..4 {
                let (energy, records) =
                    origin.map_or(quarter, |node| (node.shares[i], node.records[i]));
                let is_known = energy > least && records >= FEWEST;
                if is_known && depth < DEPTH && nodes.len() < most {
                    let below = origin.map(|node| node.nodes[i]).filter(|below| *below > 0);
                    nodes[index].nodes[i] = nodes.len() as u32;
                    nodes.push(Node::default());
                    origins.push((below, (0.25 * energy, records / 4), depth + 1));
                }
            }
            index += 1;
        }
        Self { nodes }
    }
}

/// Chooses the second of two shares, or the first, and stretches the number over the part of
/// `[0, 1)` that stands for it. A share of 0 is never chosen.
#[inline]
fn choose(u: &mut f64, first: f64, second: f64) -> bool {
    let part = first / (first + second);
    let is_second = *u >= part;
    *u = if is_second { (*u - part) / (1.0 - part) } else { *u / part };
    *u = u.min(1.0f64.next_down());
    is_second
}
