//! A few boxes that together cover many.

use crate::geometry::Bounds;
use glam::DVec3;

/// The largest number of boxes.
pub(super) const MAX_BOXES: usize = 8;
/// A sample has at least half as many boxes, if there are so many.
const SAMPLE: usize = 8192;
/// A box is split between two of so many slabs.
const SLABS: usize = 16;
/// Leaves are split together with the widest if their squared half-diagonals are so much of its own.
const NEARLY_AS_WIDE: f64 = 0.25;
/// Boxes take the place of one around them if their squared half-diagonals sum up to so much of its
/// own at most.
const WORTHWHILE: f64 = 0.5;

/// True for a box with a diagonal, or for a point.
pub(super) fn is_bounded(bounds: &Bounds) -> bool {
    !bounds.is_empty() && square(bounds).is_finite()
}

/// At most [`MAX_BOXES`] boxes around all bounded ones of the given, which are gone through a few
/// times and never kept: there may be many millions. If a sample of them says that one box does,
/// they are gone through once, because more boxes never have a smaller cover.
pub(super) fn cover(boxes: impl Iterator<Item = Bounds> + Clone) -> Vec<Bounds> {
    let boxes = boxes.filter(is_bounded);
    let (mut all, mut sample, mut stride) = (Bounds::EMPTY, Vec::new(), 1);
    for (index, bounds) in boxes.clone().enumerate() {
        all = all.union(bounds);
        if index % stride == 0 {
            sample.push(bounds);
        }
        if sample.len() == SAMPLE {
            let mut is_even = false;
            sample.retain(|_| {
                is_even = !is_even;
                is_even
            });
            stride *= 2;
        }
    }
    let of_sample = Tree::over(sample.iter().copied()).cover();
    let together: f64 = of_sample.iter().map(square).sum();
    if stride == 1 {
        of_sample
    } else if together <= WORTHWHILE * square(&all) {
        Tree::over(boxes).cover()
    } else {
        Vec::from_iter(Some(all).filter(is_bounded))
    }
}

/// The squared half-diagonal.
fn square(bounds: &Bounds) -> f64 {
    (0.5 * (bounds.max - bounds.min)).length_squared()
}

fn around(boxes: impl IntoIterator<Item = Bounds>) -> Bounds {
    boxes.into_iter().fold(Bounds::EMPTY, Bounds::union)
}

/// Made from the root down. The widest leaves are split next, whether or not that pays by itself:
/// what is far away in four directions takes more than one split.
struct Tree {
    nodes: Vec<Node>,
}

struct Node {
    bounds: Bounds,
    /// Slabs per length along each axis.
    slabs: DVec3,
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
        let slabs = SLABS as f64 / (bounds.max - bounds.min);
        Self { bounds, slabs, split: None, is_whole: false }
    }

    /// The slab that a point is in.
    fn slab(&self, axis: usize, point: DVec3) -> usize {
        // 0 times infinity where the node is flat; as an integer that is 0.
        let slab = (point[axis] - self.bounds.min[axis]) * self.slabs[axis];
        (slab as usize).min(SLABS - 1)
    }
}

impl Tree {
    fn over(boxes: impl Iterator<Item = Bounds> + Clone) -> Self {
        let mut tree = Self { nodes: vec![Node::leaf(around(boxes.clone()))] };
        while let Some(leaves) = tree.widest_leaves() {
            tree.split(&leaves, boxes.clone());
        }
        tree
    }

    /// The boxes of the nodes that take the place of their children, which are hardly smaller.
    fn cover(&self) -> Vec<Bounds> {
        let mut cover = Vec::new();
        self.cover_node(0, &mut cover);
        cover
    }

    /// The leaves to split next, as many as there may be.
    fn widest_leaves(&self) -> Option<Vec<usize>> {
        let leaves = self.nodes.iter().filter(|node| node.split.is_none()).count();
        let square = |&i: &usize| square(&self.nodes[i].bounds);
        let mut open: Vec<usize> = (0..self.nodes.len())
            .filter(|&i| self.nodes[i].split.is_none() && !self.nodes[i].is_whole)
            .filter(|i| square(i) > 0.0 && square(i).is_finite())
            .collect();
        open.sort_by(|a, b| square(b).total_cmp(&square(a)));
        let widest = square(open.first()?);
        open.retain(|i| square(i) >= NEARLY_AS_WIDE * widest);
        open.truncate(MAX_BOXES - leaves);
        (!open.is_empty()).then_some(open)
    }

    fn leaf_of(&self, point: DVec3) -> usize {
        let mut index = 0;
        while let Some(Split { axis, slab, near }) = self.nodes[index].split {
            index = near + usize::from(self.nodes[index].slab(axis, point) >= slab);
        }
        index
    }

    /// Splits leaves such that the halves of each have the smallest sum of squared half-diagonals.
    fn split(&mut self, leaves: &[usize], boxes: impl Iterator<Item = Bounds>) {
        let mut slabs = vec![[[Bounds::EMPTY; SLABS]; 3]; leaves.len()];
        for bounds in boxes {
            let center = bounds.center();
            let leaf = self.leaf_of(center);
            if let Some(place) = leaves.iter().position(|&it| it == leaf) {
                for (axis, slabs) in slabs[place].iter_mut().enumerate() {
                    let slab = &mut slabs[self.nodes[leaf].slab(axis, center)];
                    *slab = slab.union(bounds);
                }
            }
        }
        for (&leaf, slabs) in leaves.iter().zip(&slabs) {
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
    }

    /// Adds the boxes of a node; returns the sum of their squared half-diagonals.
    fn cover_node(&self, index: usize, cover: &mut Vec<Bounds>) -> f64 {
        let (node, before) = (&self.nodes[index], cover.len());
        let alone = square(&node.bounds);
        if let Some(Split { near, .. }) = node.split {
            let together = self.cover_node(near, cover) + self.cover_node(near + 1, cover);
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

    /// One of very many.
    #[test]
    fn what_is_far_away_is_in_no_sample() {
        let mut rng = random(2);
        let mut boxes: Vec<Bounds> =
            (0..100_000).map(|_| cube(DVec3::new(rng(), rng(), rng()), 0.001)).collect();
        assert_eq!(cover(boxes.iter().copied()), [around(boxes.clone())]);
        let pebble = cube(DVec3::X * 1e3, 0.1);
        let room = around(boxes.clone());
        boxes.insert(4321, pebble);
        assert_eq!(cover(boxes.into_iter()), [room, pebble]);
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
