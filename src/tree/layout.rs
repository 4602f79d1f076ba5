//! The tree in memory: nodes of eight boxes and blocks of four triangles, side by side for SIMD.

use super::rounding::tolerances_of_triangle;
use glam::DVec3;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Triangles of a block.
pub(super) const LANES: usize = 4;

/// Facets up to which a tree does not pay, where it need not be walked for each ray.
pub(super) const FEW: usize = 48;

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

    /// The child in a lane.
    #[inline(always)]
    pub fn child(self, lane: usize) -> Child {
        Child(self.0[3].0[0][lane % WIDTH])
    }
}

/// A child of a node: the first line of a node or of a block of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Child(pub u32);

impl Child {
    /// The end of every walk: no node has as many before it.
    pub const NOWHERE: Self = Self(Self::LEAF - 1);

    pub const LEAF: u32 = 1 << 31;

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
        /// True if they are exactly those of a primitive that is a triangle.
        exact: bool,
    },
    /// Something that only its exact test can decide.
    Opaque,
}

/// Four triangles: for each axis a vertex and the edges to the others, the error bounds of the
/// numbers computed from them, and their primitives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<'a>(pub &'a [Line; Block::LINES]);

impl<'a> Block<'a> {
    pub const LINES: usize = 3;

    /// The row of the edge functions' error bounds: 0 for what is always a candidate, negative for
    /// a lane that is empty.
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

    /// The error bounds of the distance times the determinant.
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

    /// True if its corners are those of the shape.
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

impl Wide {
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

/// The block of up to four references.
pub(super) fn block_of(
    found: &[u32],
    facet: &impl Fn(u32) -> (u32, Facet),
) -> [Line; Block::LINES] {
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
        let [tolerance, slack] = tolerances_of_triangle(edge1, edge2);
        rows[Block::TOLERANCE][lane] = tolerance.to_bits();
        rows[Block::DISTANCE_TOLERANCE][lane] = slack.to_bits();
    }
    let half = |k: usize| {
        let ([a, b, c, d], [e, f, g, h]) = (rows[2 * k], rows[2 * k + 1]);
        [a, b, c, d, e, f, g, h]
    };
    [0, 1, 2].map(|line| Line([half(2 * line), half(2 * line + 1)]))
}
