//! The wide tree, made from a binary one by choosing, for every binary node, whether it becomes a
//! leaf, a node of its own, or dissolves into its parent, so that the expected cost by the surface
//! area heuristic is least (Ylitie, Karras and Laine 2017, section 3).

use super::layout::{Block, Child, Facet, LANES, Line, WIDTH, Wide, block_of};
use obvhs::bvh2::node::Bvh2Node;

/// The cost of testing a node's boxes, in tests of a block.
const NODE_COST: f32 = 1.0;

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

/// The share of `roots` that the first of two siblings has where both together cost least, and that
/// cost.
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

/// True if a subtree that fits into one leaf should be one.
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
