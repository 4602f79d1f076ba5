//! A few boxes that together cover many.

use crate::geometry::Bounds;

/// The largest number of boxes.
pub(super) const MAX_BOXES: usize = 8;
/// A box is split between two of so many slabs.
const SLABS: usize = 16;
/// Boxes take the place of one around them if their squared half-diagonals sum up to so much of its
/// own at most.
const WORTHWHILE: f64 = 0.5;

/// True for a box with a diagonal, or for a point.
pub(super) fn is_bounded(bounds: &Bounds) -> bool {
    !bounds.is_empty() && square(bounds).is_finite()
}

/// At most [`MAX_BOXES`] boxes around all bounded ones of the given, which are gone through so many
/// times at most and never kept: there may be many millions.
///
/// First a tree is made from the root down, in which the widest leaf is split next, whether or not
/// that pays by itself: what is far away in four directions takes more than one split. Then nodes
/// take the place of their children where these are hardly smaller.
pub(super) fn cover(boxes: impl Iterator<Item = Bounds> + Clone) -> Vec<Bounds> {
    let boxes = boxes.filter(is_bounded);
    let mut tree = Tree { nodes: vec![Node::leaf(around(boxes.clone()))] };
    while tree.nodes.len() < 2 * MAX_BOXES - 1
        && let Some(widest) = tree.widest_leaf()
    {
        tree.split(widest, boxes.clone());
    }
    let mut cover = Vec::new();
    tree.cover(0, &mut cover);
    cover
}

/// The squared half-diagonal.
fn square(bounds: &Bounds) -> f64 {
    (0.5 * (bounds.max - bounds.min)).length_squared()
}

fn around(boxes: impl IntoIterator<Item = Bounds>) -> Bounds {
    boxes.into_iter().fold(Bounds::EMPTY, Bounds::union)
}

struct Tree {
    nodes: Vec<Node>,
}

struct Node {
    bounds: Bounds,
    split: Option<Split>,
    /// True for a leaf whose boxes have the same centre, nearly.
    is_whole: bool,
}

/// A plane between two slabs along an axis.
#[derive(Clone, Copy)]
struct Split {
    axis: usize,
    /// The first slab on the far side.
    slab: usize,
    /// The child on the near side; the other one comes next.
    near: usize,
}

impl Node {
    fn leaf(bounds: Bounds) -> Self {
        Self { bounds, split: None, is_whole: false }
    }

    /// The slab in which the centre of a box is.
    fn slab(&self, axis: usize, bounds: &Bounds) -> usize {
        let (min, max) = (self.bounds.min[axis], self.bounds.max[axis]);
        // 0/0 where the node is flat; as an integer that is 0.
        (((bounds.center()[axis] - min) / (max - min) * SLABS as f64) as usize).min(SLABS - 1)
    }
}

impl Tree {
    fn widest_leaf(&self) -> Option<usize> {
        (0..self.nodes.len())
            .filter(|&i| self.nodes[i].split.is_none() && !self.nodes[i].is_whole)
            .map(|i| (i, square(&self.nodes[i].bounds)))
            .filter(|(_, square)| *square > 0.0 && square.is_finite())
            .max_by(|(_, a), (_, b)| a.total_cmp(b))
            .map(|(i, _)| i)
    }

    fn leaf_of(&self, bounds: &Bounds) -> usize {
        let mut index = 0;
        while let Some(Split { axis, slab, near }) = self.nodes[index].split {
            index = near + usize::from(self.nodes[index].slab(axis, bounds) >= slab);
        }
        index
    }

    /// Splits a leaf such that its halves have the smallest sum of squared half-diagonals.
    fn split(&mut self, leaf: usize, boxes: impl Iterator<Item = Bounds>) {
        let mut slabs = [[Bounds::EMPTY; SLABS]; 3];
        for bounds in boxes.filter(|bounds| self.leaf_of(bounds) == leaf) {
            for (axis, slabs) in slabs.iter_mut().enumerate() {
                let slab = &mut slabs[self.nodes[leaf].slab(axis, &bounds)];
                *slab = slab.union(bounds);
            }
        }
        let near = self.nodes.len();
        let best = (0..3)
            .flat_map(|axis| (1..SLABS).map(move |slab| Split { axis, slab, near }))
            .map(|split| {
                let (nearer, farther) = slabs[split.axis].split_at(split.slab);
                (split, [nearer, farther].map(|slabs| around(slabs.iter().copied())))
            })
            .filter(|(_, halves)| !halves.iter().any(Bounds::is_empty))
            .map(|(split, halves)| (split, halves, square(&halves[0]) + square(&halves[1])))
            .min_by(|(.., a), (.., b)| a.total_cmp(b));
        match best {
            None => self.nodes[leaf].is_whole = true,
            Some((split, halves, _)) => {
                self.nodes[leaf].split = Some(split);
                self.nodes.extend(halves.map(Node::leaf));
            }
        }
    }

    /// Adds the boxes of a node; returns the sum of their squared half-diagonals.
    fn cover(&self, index: usize, cover: &mut Vec<Bounds>) -> f64 {
        let (node, before) = (&self.nodes[index], cover.len());
        let alone = square(&node.bounds);
        if let Some(Split { near, .. }) = node.split {
            let together = self.cover(near, cover) + self.cover(near + 1, cover);
            if together <= WORTHWHILE * alone {
                return together;
            }
        }
        cover.truncate(before);
        cover.extend(Some(node.bounds).filter(is_bounded));
        alone
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::testing::random;
    use glam::DVec3;

    fn cube(center: DVec3, half: f64) -> Bounds {
        Bounds { min: center - half, max: center + half }
    }

    #[test]
    fn ordinary_scenes_have_one_box() {
        let mut rng = random(1);
        let mut point = || DVec3::new(rng(), rng(), rng());
        for shape in [DVec3::ONE, DVec3::new(1.0, 1.0, 0.0), DVec3::new(3.0, 1.0, 1.0)] {
            let boxes: Vec<Bounds> = (0..1000).map(|_| cube(shape * point(), 0.01)).collect();
            assert_eq!(cover(boxes.iter().copied()), [around(boxes)]);
        }
        assert_eq!(cover([cube(DVec3::ONE, 0.0)].into_iter()).len(), 1);
        let unbounded = Bounds { min: DVec3::ZERO, max: DVec3::INFINITY };
        assert_eq!(cover([Bounds::EMPTY, unbounded].into_iter()), []);
    }

    #[test]
    fn what_is_far_away_has_a_box_of_its_own() {
        let walls = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
            [-axis, axis].map(|at| Bounds { min: at + axis - 1.0, max: at - axis + 1.0 })
        });
        for far in [1e1, 1e3, 1e6, 1e12] {
            for pebbles in [
                vec![DVec3::X],
                vec![DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y],
                vec![DVec3::X, DVec3::X * 1e3, DVec3::X * 1e6],
            ] {
                let pebbles = pebbles.iter().map(|&at| cube(at * far, 0.1));
                let boxes: Vec<Bounds> =
                    walls.into_iter().flatten().chain(pebbles.clone()).collect();
                let covers = cover(boxes.iter().copied());
                assert_eq!(covers.len(), 1 + pebbles.clone().count(), "{far}: {covers:?}");
                for expected in pebbles.chain([cube(DVec3::ZERO, 1.0)]) {
                    assert!(covers.contains(&expected), "{far}: {covers:?}");
                }
            }
        }
    }
}
