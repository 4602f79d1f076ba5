//! The tree that rays walk through: nodes of eight boxes and leaves of four triangles, side by side
//! for SIMD.
//!
//! It is made from a binary tree by choosing, for every binary node, whether it becomes a leaf, a
//! node of its own, or dissolves into its parent, so that the expected cost by the surface area
//! heuristic is least (Ylitie, Karras and Laine 2017, section 3). All numbers are f32 in the space
//! of the boxes; [`super::bvh`] says what their rounding amounts to.

use super::bvh;
use glam::DVec3;
use obvhs::bvh2::node::Bvh2Node;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Triangles of a block.
pub(super) const LANES: usize = 4;

/// What testing a node's boxes costs, in tests of a block.
const NODE_COST: f32 = 1.0;

/// A cache line. Nodes and blocks are made of them and lie in one array, a node's blocks right
/// behind it, where the processor finds them soonest.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Line(pub [[u32; 8]; 2]);

/// Eight boxes and what they contain. A lane without child has an empty box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node<'a>(&'a [Line; Node::LINES]);

impl<'a> Node<'a> {
    const LINES: usize = 4;

    /// The lower or the upper planes along an axis.
    #[inline(always)]
    pub fn planes(self, axis: usize, upper: bool) -> &'a [u32; WIDTH] {
        &self.0[axis].0[usize::from(upper)]
    }

    /// Where a lane leads.
    #[inline(always)]
    pub fn child(self, lane: usize) -> Child {
        Child(self.0[3].0[0][lane % WIDTH])
    }
}

/// Where a lane of a node leads: to the first line of a node or of a block of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Child(pub u32);

impl Child {
    /// Where walks end: no node has as many before it.
    pub const NOWHERE: Self = Self(Self::LEAF - 1);

    const LEAF: u32 = 1 << 31;

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    #[inline(always)]
    pub fn line(self) -> usize {
        (self.0 & !Self::LEAF) as usize
    }
}

/// A facet in the space of the boxes, as the test in f32 sees it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Facet {
    /// A triangle.
    Triangle {
        /// Its corners.
        corners: [DVec3; 3],
        /// Whether they tell exactly where those of a primitive that is a triangle are.
        exact: bool,
    },
    /// Something that only its exact test can decide.
    Opaque,
}

/// Four triangles: for each axis a vertex and the edges to the others, by how much what is computed
/// from them may be off, and their primitives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<'a>(pub &'a [Line; Block::LINES]);

impl<'a> Block<'a> {
    pub const LINES: usize = 3;

    /// By how much the edge functions may be off: 0 for what is always a candidate, negative for a
    /// lane that is empty.
    const TOLERANCE: usize = 9;
    const DISTANCE_TOLERANCE: usize = 10;
    const PRIMITIVE: usize = 11;

    /// Marks the primitive of a triangle of which f32 tells the corners exactly.
    const EXACT: u32 = 1 << 31;

    #[inline(always)]
    pub fn row(self, row: usize) -> &'a [u32; LANES] {
        &self.0[row / 4].0.as_flattened().as_chunks().0[row % 4]
    }

    #[inline(always)]
    pub fn vertex(self) -> [&'a [u32; LANES]; 3] {
        [self.row(0), self.row(1), self.row(2)]
    }

    #[inline(always)]
    pub fn edge1(self) -> [&'a [u32; LANES]; 3] {
        [self.row(3), self.row(4), self.row(5)]
    }

    #[inline(always)]
    pub fn edge2(self) -> [&'a [u32; LANES]; 3] {
        [self.row(6), self.row(7), self.row(8)]
    }

    #[inline(always)]
    pub fn tolerance(self) -> &'a [u32; LANES] {
        self.row(Self::TOLERANCE)
    }

    /// By how much the distance times the determinant may be off.
    #[inline(always)]
    pub fn distance_tolerance(self) -> &'a [u32; LANES] {
        self.row(Self::DISTANCE_TOLERANCE)
    }
}

/// One of the triangles of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate<'a> {
    pub block: Block<'a>,
    pub lane: usize,
}

impl Candidate<'_> {
    #[inline(always)]
    fn number(self, row: usize) -> u32 {
        self.block.row(row)[self.lane % LANES]
    }

    #[inline(always)]
    pub fn primitive(self) -> u32 {
        self.number(Block::PRIMITIVE) & !Block::EXACT
    }

    /// Whether its corners are those of the shape.
    #[inline(always)]
    pub fn is_exact(self) -> bool {
        self.number(Block::PRIMITIVE) & Block::EXACT != 0
    }

    /// The corners of one that is exact, with coordinates in the given order.
    #[inline(always)]
    pub fn corners(self, [i, j, k]: [usize; 3]) -> [DVec3; 3] {
        let x = |row| f64::from(f32::from_bits(self.number(row)));
        let (i, j, k) = (i % 3, j % 3, k % 3);
        let a = DVec3::new(x(i), x(j), x(k));
        [
            a,
            a + DVec3::new(x(3 + i), x(3 + j), x(3 + k)),
            a + DVec3::new(x(6 + i), x(6 + j), x(6 + k)),
        ]
    }
}

/// The wide tree. The root is the first node.
#[derive(Debug, Default)]
pub(super) struct Wide {
    pub lines: Vec<Line>,
    pub nodes: usize,
    pub blocks: usize,
}

/// Least costs of the subtree below a binary node: as one leaf or node, and as a forest of at most
/// 2, 3, … 7 of them.
type Costs = [f32; WIDTH - 1];

impl Wide {
    /// Collapses a binary tree, whose root is its first node. `facet` tells primitive and shape of
    /// a reference.
    pub fn collapse(
        tree: &[Bvh2Node],
        references: &[u32],
        facet: impl Fn(u32) -> (u32, Facet),
    ) -> Self {
        let mut wide = Self::default();
        if tree.is_empty() {
            return wide;
        }
        let (counts, costs) = costs(tree);
        let is_leaf = |index: u32| {
            counts[index as usize] as usize <= LANES && leaf_is_best(tree, &costs, index)
        };
        // Binary nodes to make wide ones of, with the line and lane of the parent that lead there.
        let mut work: Vec<(u32, Option<(usize, usize)>)> = vec![(0, None)];
        let mut children = Vec::new();
        while let Some((index, parent)) = work.pop() {
            let node = wide.lines.len();
            if let Some((line, lane)) = parent {
                wide.lines[line].0[0][lane] = node as u32;
            }
            children.clear();
            if tree[index as usize].is_leaf() || (parent.is_none() && is_leaf(index)) {
                children.push(index);
            } else {
                let first = tree[index as usize].first_index;
                let left = best_share(&costs, first, WIDTH).0;
                forest(tree, &costs, first, left, &mut children);
                forest(tree, &costs, first + 1, WIDTH - left, &mut children);
            }
            // What is likely to be in the way of a shadow ray first: leaves, then large boxes.
            children.sort_by_key(|&child| {
                (
                    !is_leaf(child),
                    std::cmp::Reverse(tree[child as usize].aabb().half_area().to_bits()),
                )
            });
            let nothing =
                Line([[f32::INFINITY.to_bits(); WIDTH], [f32::NEG_INFINITY.to_bits(); WIDTH]]);
            wide.lines.extend([nothing, nothing, nothing, Line([[0; WIDTH]; 2])]);
            wide.nodes += 1;
            for (lane, &child) in children.iter().enumerate() {
                let bounds = tree[child as usize].aabb();
                for axis in 0..3 {
                    let Line([low, high]) = &mut wide.lines[node + axis];
                    (low[lane], high[lane]) =
                        (bounds.min[axis].to_bits(), bounds.max[axis].to_bits());
                }
                if is_leaf(child) {
                    wide.lines[node + 3].0[0][lane] = Child::LEAF | wide.lines.len() as u32;
                    wide.lines.extend(block(tree, references, child, &facet));
                    wide.blocks += 1;
                } else {
                    work.push((child, Some((node + 3, lane))));
                }
            }
        }
        wide.lines.shrink_to_fit();
        wide
    }

    /// The node that starts at a line.
    #[inline(always)]
    pub fn node(&self, line: usize) -> Option<Node<'_>> {
        self.lines.get(line..)?.first_chunk().map(Node)
    }

    /// The block that starts at a line.
    #[inline(always)]
    pub fn block(&self, line: usize) -> Option<Block<'_>> {
        self.lines.get(line..)?.first_chunk().map(Block)
    }
}

/// Numbers of references and least costs of all subtrees.
fn costs(tree: &[Bvh2Node]) -> (Vec<u32>, Vec<Costs>) {
    let mut order = Vec::with_capacity(tree.len());
    let mut stack = vec![0u32];
    while let Some(index) = stack.pop() {
        order.push(index);
        let node = &tree[index as usize];
        if !node.is_leaf() {
            stack.extend([node.first_index, node.first_index + 1]);
        }
    }
    let mut counts = vec![0u32; tree.len()];
    let mut costs = vec![[0.0; WIDTH - 1]; tree.len()];
    for &index in order.iter().rev() {
        let (i, node) = (index as usize, &tree[index as usize]);
        let area = node.aabb().half_area();
        if node.is_leaf() {
            counts[i] = 1;
            costs[i] = [area; WIDTH - 1];
            continue;
        }
        counts[i] = counts[node.first_index as usize] + counts[node.first_index as usize + 1];
        let inner = best_share(&costs, node.first_index, WIDTH).1 + NODE_COST * area;
        let mut best = if counts[i] as usize <= LANES { inner.min(area) } else { inner };
        costs[i][0] = best;
        for roots in 2..WIDTH {
            best = best.min(best_share(&costs, node.first_index, roots).1);
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
fn leaf_is_best(tree: &[Bvh2Node], costs: &[Costs], index: u32) -> bool {
    let node = &tree[index as usize];
    node.is_leaf() || costs[index as usize][0] >= node.aabb().half_area()
}

/// The binary nodes that become children when a subtree may take up to `roots` lanes.
fn forest(tree: &[Bvh2Node], costs: &[Costs], index: u32, roots: usize, found: &mut Vec<u32>) {
    let own = &costs[index as usize];
    let mut roots = roots;
    while roots > 1 && own[roots - 2] <= own[roots - 1] {
        roots -= 1;
    }
    if roots == 1 {
        found.push(index);
        return;
    }
    let first = tree[index as usize].first_index;
    let left = best_share(costs, first, roots).0;
    forest(tree, costs, first, left, found);
    forest(tree, costs, first + 1, roots - left, found);
}

/// The block of all references below a binary node; parts of the same facet are one.
fn block(
    tree: &[Bvh2Node],
    references: &[u32],
    index: u32,
    facet: &impl Fn(u32) -> (u32, Facet),
) -> [Line; Block::LINES] {
    let mut found: Vec<u32> = Vec::with_capacity(LANES);
    let mut stack = vec![index];
    while let Some(index) = stack.pop() {
        let node = &tree[index as usize];
        if node.is_leaf() {
            found.push(references[node.first_index as usize]);
        } else {
            stack.extend([node.first_index, node.first_index + 1]);
        }
    }
    found.sort_unstable();
    found.dedup();
    block_of(&found, facet)
}

/// Blocks of all references, without a tree.
pub(super) fn blocks(
    references: &[u32],
    facet: impl Fn(u32) -> (u32, Facet),
) -> Vec<[Line; Block::LINES]> {
    references.chunks(LANES).map(|found| block_of(found, &facet)).collect()
}

/// The block of up to four references.
fn block_of(found: &[u32], facet: &impl Fn(u32) -> (u32, Facet)) -> [Line; Block::LINES] {
    let mut rows = [[0u32; LANES]; 12];
    rows[Block::TOLERANCE] = [(-1.0f32).to_bits(); LANES];
    rows[Block::PRIMITIVE] = [u32::MAX; LANES];
    for (lane, &reference) in found.iter().enumerate() {
        let (primitive, facet) = facet(reference);
        rows[Block::PRIMITIVE][lane] = primitive;
        rows[Block::TOLERANCE][lane] = 0;
        let Facet::Triangle { corners: [a, b, c], exact } = facet else { continue };
        let (edge1, edge2) = (b - a, c - a);
        let held = |v: DVec3| v.as_vec3().as_dvec3();
        if exact && held(a) == a && a + held(edge1) == b && a + held(edge2) == c {
            rows[Block::PRIMITIVE][lane] |= Block::EXACT;
        }
        for axis in 0..3 {
            for (row, v) in [(0, a), (3, edge1), (6, edge2)] {
                rows[row + axis][lane] = (v[axis] as f32).to_bits();
            }
        }
        let up = |x: f64| (x as f32).next_up().to_bits();
        let size = edge1.abs().element_sum() + edge2.abs().element_sum();
        rows[Block::TOLERANCE][lane] = up(bvh::EDGE_TOLERANCE * size + bvh::TOLERANCE_F64);
        rows[Block::DISTANCE_TOLERANCE][lane] =
            up(bvh::DISTANCE_TOLERANCE * edge1.length() * edge2.length() + bvh::TOLERANCE_F64);
    }
    let half = |k: usize| {
        let ([a, b, c, d], [e, f, g, h]) = (rows[2 * k], rows[2 * k + 1]);
        [a, b, c, d, e, f, g, h]
    };
    [0, 1, 2].map(|line| Line([half(2 * line), half(2 * line + 1)]))
}
