//! The tree that rays walk through: nodes of eight boxes and leaves of four triangles, side by side for SIMD.
//!
//! It is made from a binary tree by choosing, for every binary node, whether it becomes a leaf, a node of its own, or dissolves into its
//! parent, so that the expected cost by the surface area heuristic is least (Ylitie, Karras and Laine 2017, section 3). All numbers are
//! f32 in the space of the boxes; [`super::bvh`] says what their rounding amounts to.

use super::binary::BinaryNode;
use super::bvh;
use glam::DVec3;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Triangles of a block.
pub(super) const LANES: usize = 4;

/// What testing a node's boxes costs, in tests of a block.
const NODE_COST: f32 = 1.0;

/// Eight boxes and what they contain. A lane without child has an empty box.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    /// For each axis the lower and the upper planes.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    /// Where the lanes lead.
    pub children: [Child; WIDTH],
}

/// Where a lane of a node leads: to a node or to a block of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Child(pub u32);

impl Child {
    const LEAF: u32 = 1 << 31;

    /// The block, if it is a leaf.
    #[inline(always)]
    pub fn block(self) -> Option<usize> {
        (self.0 & Self::LEAF != 0).then_some((self.0 & !Self::LEAF) as usize)
    }
}

/// A facet in the space of the boxes, as the test in f32 sees it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Facet {
    /// A triangle.
    Triangle([DVec3; 3]),
    /// Something that only its exact test can decide.
    Opaque,
}

/// Four triangles: a vertex, the edges to the others, and by how much what is computed from them may be off.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    pub vertex: [[f32; LANES]; 3],
    pub edge1: [[f32; LANES]; 3],
    pub edge2: [[f32; LANES]; 3],
    /// Of the edge functions: 0 for what is always a candidate, negative for a lane that is empty.
    pub tolerance: [f32; LANES],
    /// Of the distance times the determinant.
    pub distance_tolerance: [f32; LANES],
    /// The primitive of each lane.
    pub primitive: [u32; LANES],
}

impl Block {
    const EMPTY: Self = Self {
        vertex: [[0.0; LANES]; 3],
        edge1: [[0.0; LANES]; 3],
        edge2: [[0.0; LANES]; 3],
        tolerance: [-1.0; LANES],
        distance_tolerance: [0.0; LANES],
        primitive: [u32::MAX; LANES],
    };

    fn set(&mut self, lane: usize, primitive: u32, facet: Facet) {
        self.primitive[lane] = primitive;
        self.tolerance[lane] = 0.0;
        let Facet::Triangle([a, b, c]) = facet else { return };
        let (edge1, edge2) = (b - a, c - a);
        for axis in 0..3 {
            self.vertex[axis][lane] = a[axis] as f32;
            self.edge1[axis][lane] = edge1[axis] as f32;
            self.edge2[axis][lane] = edge2[axis] as f32;
        }
        let up = |x: f64| (x as f32).next_up();
        let size = edge1.abs().element_sum() + edge2.abs().element_sum();
        self.tolerance[lane] = up(bvh::EDGE_TOLERANCE * size + bvh::TOLERANCE_F64);
        self.distance_tolerance[lane] = up(bvh::DISTANCE_TOLERANCE * edge1.length() * edge2.length() + bvh::TOLERANCE_F64);
    }
}

/// The wide tree. The root is the first node.
#[derive(Debug, Default)]
pub(super) struct Wide {
    pub nodes: Vec<Node>,
    pub blocks: Vec<Block>,
}

/// Least costs of the subtree below a binary node: as one leaf or node, and as a forest of at most 2, 3, … 7 of them.
type Costs = [f32; WIDTH - 1];

impl Wide {
    /// Collapses a binary tree, whose root is its first node. `facet` tells primitive and shape of a reference.
    pub fn collapse(tree: &[BinaryNode], references: &[u32], facet: impl Fn(u32) -> (u32, Facet)) -> Self {
        let mut wide = Self::default();
        if tree.is_empty() {
            return wide;
        }
        let (counts, costs) = costs(tree);
        let is_leaf = |index: u32| counts[index as usize] as usize <= LANES && leaf_is_best(tree, &costs, index);
        // Binary nodes to make wide ones of, with the lane of the parent that leads there.
        let mut work: Vec<(u32, Option<(usize, usize)>)> = vec![(0, None)];
        let mut children = Vec::new();
        while let Some((index, parent)) = work.pop() {
            let node = wide.nodes.len();
            if let Some((parent, lane)) = parent {
                wide.nodes[parent].children[lane] = Child(node as u32);
            }
            children.clear();
            if tree[index as usize].leaf || (parent.is_none() && is_leaf(index)) {
                children.push(index);
            } else {
                let first = tree[index as usize].first;
                let left = best_share(&costs, first, WIDTH).0;
                forest(tree, &costs, first, left, &mut children);
                forest(tree, &costs, first + 1, WIDTH - left, &mut children);
            }
            let mut planes = [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3];
            let mut links = [Child(0); WIDTH];
            for (lane, &child) in children.iter().enumerate() {
                let binary = &tree[child as usize];
                for (axis, [near, far]) in planes.iter_mut().enumerate() {
                    near[lane] = binary.min[axis];
                    far[lane] = binary.max[axis];
                }
                if is_leaf(child) {
                    links[lane] = Child(Child::LEAF | wide.blocks.len() as u32);
                    wide.blocks.push(block(tree, references, child, &facet));
                } else {
                    work.push((child, Some((node, lane))));
                }
            }
            wide.nodes.push(Node { planes, children: links });
        }
        wide.nodes.shrink_to_fit();
        wide.blocks.shrink_to_fit();
        wide
    }
}

/// Half the area of a box.
fn half_area(node: &BinaryNode) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|axis| node.max[axis] - node.min[axis]);
    x * y + y * z + z * x
}

/// Numbers of references and least costs of all subtrees. Children come after their parents.
fn costs(tree: &[BinaryNode]) -> (Vec<u32>, Vec<Costs>) {
    let mut counts = vec![0u32; tree.len()];
    let mut costs = vec![[0.0; WIDTH - 1]; tree.len()];
    for (i, node) in tree.iter().enumerate().rev() {
        let area = half_area(node);
        if node.leaf {
            counts[i] = 1;
            costs[i] = [area; WIDTH - 1];
            continue;
        }
        counts[i] = counts[node.first as usize] + counts[node.first as usize + 1];
        let inner = best_share(&costs, node.first, WIDTH).1 + NODE_COST * area;
        let mut best = if counts[i] as usize <= LANES { inner.min(area) } else { inner };
        costs[i][0] = best;
        for roots in 2..WIDTH {
            best = best.min(best_share(&costs, node.first, roots).1);
            costs[i][roots - 1] = best;
        }
    }
    (counts, costs)
}

/// How many of `roots` to give to the first of two siblings, and what they cost then.
fn best_share(costs: &[Costs], first: u32, roots: usize) -> (usize, f32) {
    let (left, right) = (&costs[first as usize], &costs[first as usize + 1]);
    let mut best = (1, f32::INFINITY);
    for share in 1..roots {
        let cost = left[share - 1] + right[roots - share - 1];
        if cost < best.1 {
            best = (share, cost);
        }
    }
    best
}

/// Of a subtree that fits into one leaf, whether that is what it should be.
fn leaf_is_best(tree: &[BinaryNode], costs: &[Costs], index: u32) -> bool {
    let node = &tree[index as usize];
    node.leaf || costs[index as usize][0] >= half_area(node)
}

/// The binary nodes that become children when a subtree may take up to `roots` lanes.
fn forest(tree: &[BinaryNode], costs: &[Costs], index: u32, roots: usize, found: &mut Vec<u32>) {
    let own = &costs[index as usize];
    let mut roots = roots;
    while roots > 1 && own[roots - 2] <= own[roots - 1] {
        roots -= 1;
    }
    if roots == 1 {
        found.push(index);
        return;
    }
    let first = tree[index as usize].first;
    let left = best_share(costs, first, roots).0;
    forest(tree, costs, first, left, found);
    forest(tree, costs, first + 1, roots - left, found);
}

/// The block of all references below a binary node; parts of the same facet are one.
fn block(tree: &[BinaryNode], references: &[u32], index: u32, facet: &impl Fn(u32) -> (u32, Facet)) -> Block {
    let mut found: Vec<u32> = Vec::with_capacity(LANES);
    let mut stack = vec![index];
    while let Some(index) = stack.pop() {
        let node = &tree[index as usize];
        if node.leaf {
            found.push(references[node.first as usize]);
        } else {
            stack.extend([node.first, node.first + 1]);
        }
    }
    found.sort_unstable();
    found.dedup();
    let mut block = Block::EMPTY;
    for (lane, &reference) in found.iter().enumerate() {
        let (primitive, facet) = facet(reference);
        block.set(lane, primitive, facet);
    }
    block
}
