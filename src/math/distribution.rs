//! Discrete and piecewise-constant distributions: choosing a light, a triangle, a pixel of an
//! environment map.
//!
//! Each keeps the numbers it samples with and answers for its own probabilities, so sample and
//! density cannot disagree. What has zero weight is never chosen, and `u` outside `[0, 1)` is
//! clamped.

use glam::DVec2;

const BLOCK: usize = PiecewiseConstant2d::BLOCK;
/// The largest number below 1.
const ONE_MINUS_EPSILON: f64 = 1.0 - 0.5 * f64::EPSILON;

/// A number clamped to `[0, 1)`; not a number becomes 0.
#[inline]
fn unit(u: f64) -> f64 {
    if u > 0.0 { u.min(ONE_MINUS_EPSILON) } else { 0.0 }
}

/// The total of some weights, `None` unless they are non-negative, finite and not all zero.
fn total(weights: &[f64]) -> Option<f64> {
    let valid = weights.iter().all(|w| *w >= 0.0 && w.is_finite());
    let sum: f64 = weights.iter().sum();
    (valid && sum > 0.0 && sum.is_finite()).then_some(sum)
}

/// Weights relative to the largest, so that the sum of large ones does not overflow.
pub(crate) fn relative(weights: &[f64]) -> Vec<f64> {
    let largest = weights.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    weights.iter().map(|weight| weight / largest).collect()
}

/// Chooses an index in constant time with probabilities proportional to weights (Walker 1977, "An
/// Efficient Method for Generating Discrete Random Variables with General Distributions";
/// construction after Vose 1991).
#[derive(Clone, Debug, PartialEq)]
pub struct AliasTable {
    columns: Vec<Column>,
    pmf: Vec<f64>,
}

/// One column of the table: its own index below `threshold`, `alias` above.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Column {
    threshold: f64,
    alias: u32,
}

impl AliasTable {
    /// A table for the given weights. `None` if there are none, if one is negative or not finite,
    /// or if all are zero.
    #[must_use]
    pub fn new(weights: &[f64]) -> Option<Self> {
        let total = total(weights)?;
        let count = u32::try_from(weights.len()).ok()?;
        let pmf: Vec<f64> = weights.iter().map(|w| w / total).collect();
        let heaviest = (0..count).max_by(|a, b| pmf[*a as usize].total_cmp(&pmf[*b as usize]))?;

        // `level` is how full each column still is; light columns are topped up from heavy ones.
        let mut level: Vec<f64> = pmf.iter().map(|p| p * f64::from(count)).collect();
        let mut columns: Vec<Column> =
            (0..count).map(|alias| Column { threshold: 1.0, alias }).collect();
        let (mut light, mut heavy): (Vec<u32>, Vec<u32>) =
            (0..count).partition(|i| level[*i as usize] < 1.0);
        while let (Some(small), Some(large)) = (light.last().copied(), heavy.last().copied()) {
            light.pop();
            columns[small as usize] = Column { threshold: level[small as usize], alias: large };
            level[large as usize] -= 1.0 - level[small as usize];
            if level[large as usize] < 1.0 {
                heavy.pop();
                light.push(large);
            }
        }
        // Columns left over are full but for rounding, which must not give life to an index of zero
        // weight.
        for i in light.into_iter().filter(|i| weights[*i as usize] == 0.0) {
            columns[i as usize] = Column { threshold: 0.0, alias: heaviest };
        }
        Some(Self { columns, pmf })
    }

    /// The index that `u` in `[0, 1)` chooses, and its probability.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: f64) -> (usize, f64) {
        let (index, pmf, _) = self.sample_reuse(u);
        (index, pmf)
    }

    /// Like [`AliasTable::sample`]; also returns what is left of `u`, uniform in `[0, 1)` and
    /// independent of the index.
    #[inline]
    #[must_use]
    pub fn sample_reuse(&self, u: f64) -> (usize, f64, f64) {
        let scaled = unit(u) * self.columns.len() as f64;
        let index = (scaled as usize).min(self.columns.len() - 1);
        let fraction = scaled - index as f64;
        let Column { threshold, alias } = self.columns[index];
        let (chosen, rest) = if fraction < threshold {
            (index, fraction / threshold)
        } else {
            (alias as usize, (fraction - threshold) / (1.0 - threshold))
        };
        (chosen, self.pmf[chosen], unit(rest))
    }

    /// The probability of an index, 0 beyond the last.
    #[inline]
    #[must_use]
    pub fn pmf(&self, index: usize) -> f64 {
        self.pmf.get(index).copied().unwrap_or(0.0)
    }

    /// The number of weights.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pmf.len()
    }

    /// Always false: a table without weights cannot be made.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pmf.is_empty()
    }
}

/// The cell of running sums that contains `u` of the total, by bisection. Cells of width zero
/// contain nothing. Monotonic in `u`.
fn cell_containing(sums: &[f64], u: f64) -> usize {
    let last = sums.len() - 1;
    let x = unit(u) * sums[last];
    // The last cell that starts at or below x is the one of positive width, since the next one
    // starts above.
    sums.partition_point(|s| *s <= x).clamp(1, last) - 1
}

/// The number of equal parts of `[0, 1)` that a guide to `cells` tells apart: a power of two, so
/// that scaling by it is exact. Eight cells of running sums share a line of memory, so more parts
/// would only take more of the cache.
const fn guide_parts(cells: usize) -> usize {
    1 << (cells / 4 + 1).ilog2()
}

/// The cells that an entry of a guide stands for, so that its numbers fit into 16 bits.
const fn guide_stride(cells: usize) -> usize {
    (cells - 1) / (1 << 16) + 1
}

/// Appends the cells in which the parts of `[0, 1)` start, and the last cell, in strides (the
/// cutpoints of Chen and Asau 1974, "On Generating Random Variates from an Empirical
/// Distribution").
fn push_guide(guide: &mut Vec<u16>, sums: &[f64]) {
    let cells = sums.len() - 1;
    let (parts, stride) = (guide_parts(cells), guide_stride(cells));
    let start = |part| cell_containing(sums, part as f64 / parts as f64) / stride;
    guide.extend((0..=parts).map(|part| start(part) as u16));
}

/// The number of sums, in ascending order, that are at most x. A few are all looked at, so that
/// none waits for the answer to another.
#[inline]
fn cells_below(sums: &[f64], x: f64) -> usize {
    if sums.len() > 16 {
        return sums.partition_point(|s| *s <= x);
    }
    sums.iter().map(|s| usize::from(*s <= x)).sum()
}

/// The cell of running sums that contains `u` of the total, and that much of the total. Cells of
/// width zero contain nothing. Monotonic in `u`.
#[inline(always)]
fn locate(sums: &[f64], guide: &[u16], u: f64) -> (usize, f64) {
    let u = unit(u);
    let x = u * sums[sums.len() - 1];
    // Since `cell_containing` is monotonic, its answer lies between those for the ends of the part.
    let part = (u * (guide.len() - 1) as f64) as usize;
    let stride = guide_stride(sums.len() - 1);
    let first = usize::from(guide[part]) * stride;
    let last = (usize::from(guide[part + 1]) * stride + stride - 1).min(sums.len() - 2);
    (first + cells_below(&sums[first + 1..=last], x), x)
}

/// The part of a cell, given by its ends, that lies below x, in `[0, 1)`. Monotonic, so stratified
/// numbers stay stratified.
#[inline(always)]
fn part_of_cell([start, end]: [f64; 2], x: f64) -> f64 {
    let width = end - start;
    if width > 0.0 { unit((x - start) / width) } else { 0.0 }
}

/// A cell and the point in it, drawn by [`PiecewiseConstant2d::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridSample {
    /// Column of the chosen cell.
    pub column: usize,
    /// Row of the chosen cell.
    pub row: usize,
    /// Position inside the cell, each coordinate in `[0, 1)`.
    pub within: DVec2,
}

/// A density over the unit square that is constant in each cell of a grid: rows by their marginal,
/// then columns conditional on the row.
///
/// The weights of the cells stay with the caller, who tells them in blocks: closures get a row and
/// the first cell of a block of [`BLOCK`](Self::BLOCK) cells of it, and return their weights, 0 for
/// cells beyond the end of the row. They must be the same at every call. Of running sums one is
/// kept for each block, since most time goes by waiting for memory. A block is found in constant
/// time on average and by bisection at worst.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseConstant2d {
    width: usize,
    /// Running sums of the rows' totals.
    rows: Vec<f64>,
    row_guide: Vec<u16>,
    /// Running sums within each row: the start of each block, and the total.
    blocks: Vec<f64>,
    /// The guides to the blocks of each row, one after the other.
    block_guides: Vec<u16>,
}

impl PiecewiseConstant2d {
    /// Cells of a block.
    pub const BLOCK: usize = 8;

    /// The density of weights. `None` unless they are non-negative, finite and not all zero.
    #[must_use]
    pub fn new(
        width: usize,
        height: usize,
        weights: impl Fn(usize, usize) -> [f64; Self::BLOCK],
    ) -> Option<Self> {
        let mut grid = Self {
            width,
            rows: vec![0.0],
            row_guide: Vec::new(),
            blocks: Vec::new(),
            block_guides: Vec::new(),
        };
        for row in 0..height {
            let (first, mut sum) = (grid.blocks.len(), 0.0);
            grid.blocks.push(sum);
            for block in 0..grid.blocks_of_row() {
                let weights = weights(row, block * Self::BLOCK);
                if !weights.iter().all(|w| *w >= 0.0 && w.is_finite()) {
                    return None;
                }
                sum = running_sums(sum, weights)[Self::BLOCK];
                grid.blocks.push(sum);
            }
            grid.rows.push(grid.rows[row] + sum);
            if width > 0 {
                push_guide(&mut grid.block_guides, &grid.blocks[first..]);
            }
        }
        let all = grid.rows[height];
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        push_guide(&mut grid.row_guide, &grid.rows);
        Some(grid)
    }

    /// The cell that `u` chooses, and the place in it.
    #[inline(always)]
    #[must_use]
    pub fn sample(
        &self,
        u: DVec2,
        weights: impl Fn(usize, usize) -> [f64; Self::BLOCK],
    ) -> GridSample {
        let (row, y) = locate(&self.rows, &self.row_guide, u.y);
        let parts = guide_parts(self.blocks_of_row());
        let guide = &self.block_guides[row * (parts + 1)..][..parts + 1];
        let (block, x) = locate(self.block_sums(row), guide, u.x);
        let first = block * Self::BLOCK;
        let sums = running_sums(self.block_sums(row)[block], weights(row, first));
        let cell = cells_below(&sums[1..Self::BLOCK], x).min(self.width - 1 - first);
        GridSample {
            column: first + cell,
            row,
            within: DVec2::new(
                part_of_cell([sums[cell], sums[cell + 1]], x),
                part_of_cell([self.rows[row], self.rows[row + 1]], y),
            ),
        }
    }

    /// The probability of a cell, 0 outside of the grid.
    #[must_use]
    pub fn pmf(
        &self,
        column: usize,
        row: usize,
        weights: impl Fn(usize, usize) -> [f64; Self::BLOCK],
    ) -> f64 {
        let height = self.rows.len() - 1;
        if column >= self.width || row >= height {
            return 0.0;
        }
        let of_row = self.rows[row + 1] - self.rows[row];
        let total = self.block_sums(row)[self.blocks_of_row()];
        let first = column - column % Self::BLOCK;
        let weight = weights(row, first)[column - first];
        if total > 0.0 { of_row / self.rows[height] * (weight / total) } else { 0.0 }
    }

    #[inline]
    fn blocks_of_row(&self) -> usize {
        self.width.div_ceil(Self::BLOCK)
    }

    #[inline]
    fn block_sums(&self, row: usize) -> &[f64] {
        &self.blocks[row * (self.blocks_of_row() + 1)..][..self.blocks_of_row() + 1]
    }
}

/// The sums of a first number and all weights before each, and before the end.
#[inline(always)]
fn running_sums(first: f64, weights: [f64; BLOCK]) -> [f64; BLOCK + 1] {
    let mut sums = [first; BLOCK + 1];
    for i in 0..BLOCK {
        sums[i + 1] = sums[i] + weights[i];
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::testing::random;

    /// Appends the running sums of `weights`, starting with 0.
    fn push_cumulative(sums: &mut Vec<f64>, weights: impl Iterator<Item = f64>) -> f64 {
        sums.push(0.0);
        weights.fold(0.0, |sum, w| {
            sums.push(sum + w);
            sum + w
        })
    }

    /// Row-major weights in blocks.
    fn in_blocks(width: usize, weights: &[f64]) -> impl Fn(usize, usize) -> [f64; BLOCK] {
        move |row, first| {
            let cells = &weights[row * width..][..width][first..];
            std::array::from_fn(|i| cells.get(i).copied().unwrap_or(0.0))
        }
    }

    #[test]
    fn invalid_weights_are_refused() {
        for weights in [
            &[][..],
            &[0.0, 0.0],
            &[1.0, -1e-300],
            &[1.0, f64::NAN],
            &[f64::INFINITY],
            &[f64::MAX, f64::MAX],
        ] {
            assert_eq!(AliasTable::new(weights), None);
            let width = weights.len();
            assert_eq!(PiecewiseConstant2d::new(width, 1, in_blocks(width, weights)), None);
        }
        assert_eq!(PiecewiseConstant2d::new(0, 0, |_, _| [1.0; BLOCK]), None);
        assert_eq!(PiecewiseConstant2d::new(0, 3, |_, _| [1.0; BLOCK]), None);
    }

    #[test]
    fn alias_columns_add_up_to_the_probabilities() {
        let (mut rng, mut worst) = (random(1), 0.0f64);
        for n in 1..200 {
            let weights: Vec<f64> =
                (0..n).map(|i| if i % 3 == 1 { 0.0 } else { rng().powi(8) * 1e6 }).collect();
            let table = AliasTable::new(&weights).unwrap();
            let mut mass = vec![0.0; n];
            for (i, c) in table.columns.iter().enumerate() {
                mass[i] += c.threshold / n as f64;
                mass[c.alias as usize] += (1.0 - c.threshold) / n as f64;
            }
            for (i, m) in mass.iter().enumerate() {
                worst = worst.max((m - table.pmf(i)).abs());
                assert!(weights[i] > 0.0 || *m == 0.0, "index {i} of weight zero has mass {m}");
            }
        }
        assert!(worst < 1e-14, "{worst}");
    }

    #[test]
    fn alias_reuse_is_uniform_and_extremes_are_safe() {
        let table = AliasTable::new(&[0.0, 1.0, 7.0, 0.0, 1e-9, 0.0]).unwrap();
        for u in [0.0, ONE_MINUS_EPSILON, 1.0, -1.0, f64::NAN, 2.0 / 6.0, 5.0 / 6.0] {
            let (index, pmf, rest) = table.sample_reuse(u);
            assert!(pmf > 0.0 && pmf == table.pmf(index) && (0.0..1.0).contains(&rest), "{u}");
        }
        let n = 100_000;
        let (mut sums, mut counts) = ([0.0; 6], [0usize; 6]);
        for i in 0..n {
            let (index, _, rest) = table.sample_reuse((i as f64 + 0.5) / n as f64);
            counts[index] += 1;
            sums[index] += rest;
        }
        assert!((counts[1] as f64 / n as f64 - 0.125).abs() < 1e-4);
        // The mean of a regular partition is 1/2 up to the discretisation.
        assert!(
            (sums[1] / counts[1] as f64 - 0.5).abs() < 1e-3
                && (sums[2] / counts[2] as f64 - 0.5).abs() < 1e-3
        );
    }

    #[test]
    fn guides_find_the_cells_that_bisection_finds() {
        let mut rng = random(3);
        for count in [1, 2, 3, 4, 5, 7, 8, 9, 100, 255, 256, 257, 1000] {
            let one = |i: usize| move |j: usize| f64::from(u8::from(i == j));
            let shapes: [&mut dyn FnMut(usize) -> f64; 10] = [
                &mut |_| 1.0,
                &mut |_| rng(),
                &mut one(0),
                &mut one(count - 1),
                &mut one(count / 2),
                // Nearly all cells in one part of the guide.
                &mut |i| if i + 1 == count { 1.0 } else { 1e-12 },
                &mut |i| if i == 0 { 1.0 } else { 1e-300 },
                &mut |i| 10f64.powi(-3 * (i % 200) as i32),
                &mut |i| if i % 3 == 1 { f64::from(i as u32) } else { 0.0 },
                &mut |i| if i % 2 == 0 { 5e-324 } else { 0.0 },
            ];
            for (shape, weight) in shapes.into_iter().enumerate() {
                let (mut sums, mut guide) = (Vec::new(), Vec::new());
                let weights: Vec<f64> = (0..count).map(weight).collect();
                if push_cumulative(&mut sums, weights.iter().copied()) == 0.0 {
                    continue;
                }
                let weights = in_blocks(count, &weights);
                let grid = PiecewiseConstant2d::new(count, 1, &weights).unwrap();
                push_guide(&mut guide, &sums);
                assert!(
                    guide.len() <= count / 4 + 2
                        && guide.len() > count / 8
                        && (guide.len() - 1).is_power_of_two()
                );
                // Where cells and parts of the guide start, and next to it.
                let borders = sums
                    .iter()
                    .map(|s| s / sums[count])
                    .chain((0..=count).map(|i| i as f64 / (guide.len() - 1) as f64));
                let numbers: Vec<f64> =
                    borders.flat_map(|u| [u.next_down(), u, u.next_up()]).collect();
                let mut random = random(count as u64);
                for u in numbers
                    .into_iter()
                    .chain([-1.0, f64::NAN, 2.0])
                    .chain((0..1000).map(|_| random()))
                {
                    let cell = cell_containing(&sums, u);
                    let found = locate(&sums, &guide, u).0;
                    assert_eq!(found, cell, "{count} cells, shape {shape}, {u}");
                    let sample = grid.sample(DVec2::new(u, 0.0), &weights);
                    assert_eq!(sample.column, cell, "{count} cells, shape {shape}, {u}");
                }
            }
        }
    }

    #[test]
    fn grid_samples_have_the_probability_of_their_cell() {
        let (width, height) = (11, 5);
        let mut rng = random(2);
        let weights: Vec<f64> = (0..width * height)
            .map(|i| if i / width == 2 || i % width == 0 { 0.0 } else { 10f64.powf(6.0 * rng()) })
            .collect();
        let blocks = in_blocks(width, &weights);
        let grid = PiecewiseConstant2d::new(width, height, &blocks).unwrap();
        let sum: f64 = weights.iter().sum();
        let n = 1_000_000;
        let mut counts = vec![0usize; width * height];
        for _ in 0..n {
            let s = grid.sample(DVec2::new(rng(), rng()), &blocks);
            assert!(grid.pmf(s.column, s.row, &blocks) > 0.0);
            assert!(s.within.to_array().iter().all(|x| (0.0..1.0).contains(x)));
            counts[s.row * width + s.column] += 1;
        }
        for (i, w) in weights.iter().enumerate() {
            let p = w / sum;
            let pmf = grid.pmf(i % width, i / width, &blocks);
            approx::assert_relative_eq!(pmf, p, max_relative = 1e-9);
            let sigma = (p * (1.0 - p) / n as f64).sqrt();
            assert!((counts[i] as f64 / n as f64 - p).abs() <= 4.5 * sigma + 1e-6, "cell {i}");
        }
        for u in [0.0, ONE_MINUS_EPSILON, 1.0, f64::NAN] {
            let s = grid.sample(DVec2::splat(u), &blocks);
            assert!(grid.pmf(s.column, s.row, &blocks) > 0.0);
        }
        assert_eq!(grid.pmf(width, 1, &blocks), 0.0);
    }
}
