//! Numbers of many paths in the order in which lanes read them.

use super::LANES;
use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec3;

/// `N` numbers of each of many paths. Those of eight paths lie side by side, so that a lane is a
/// path; the last group may have lanes that belong to none.
#[derive(Clone, Debug)]
pub(crate) struct Rows<const N: usize> {
    groups: Vec<Group<N>>,
    len: usize,
}

/// The numbers of eight paths.
pub(crate) type Group<const N: usize> = [[f64; LANES]; N];

impl<const N: usize> Default for Rows<N> {
    fn default() -> Self {
        Self { groups: Vec::new(), len: 0 }
    }
}

impl<const N: usize> Rows<N> {
    /// Forgets all paths.
    #[inline]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds vectors, and the numbers behind them, of one more path.
    #[inline(always)]
    pub fn push<const V: usize, const R: usize>(&mut self, vectors: [DVec3; V], rest: [f64; R]) {
        const { assert!(3 * V + R == N, "as many numbers as rows") };
        let (group, lane) = (self.len / LANES, self.len % LANES);
        if group == self.groups.len() {
            self.groups.push([[0.0; LANES]; N]);
        }
        let rows = &mut self.groups[group];
        for (i, vector) in vectors.iter().enumerate() {
            (rows[3 * i][lane], rows[3 * i + 1][lane]) = (vector.x, vector.y);
            rows[3 * i + 2][lane] = vector.z;
        }
        for (i, number) in rest.iter().enumerate() {
            rows[3 * V + i][lane] = *number;
        }
        self.len += 1;
    }

    /// Adds the numbers of one more path.
    #[inline(always)]
    pub fn push_row(&mut self, numbers: [f64; N]) {
        let (group, lane) = (self.len / LANES, self.len % LANES);
        if group == self.groups.len() {
            self.groups.push([[0.0; LANES]; N]);
        }
        for (row, number) in self.groups[group].iter_mut().zip(numbers) {
            row[lane] = number;
        }
        self.len += 1;
    }

    /// Room for the numbers of so many paths.
    pub fn resize(&mut self, len: usize) {
        let groups = len.div_ceil(LANES);
        if groups > self.groups.len() {
            self.groups.resize(groups, [[0.0; LANES]; N]);
        }
        self.len = len;
    }

    /// The groups of paths.
    #[inline(always)]
    pub fn groups(&self) -> &[Group<N>] {
        &self.groups[..self.len.div_ceil(LANES)]
    }

    /// The groups of paths, to be filled.
    #[inline(always)]
    pub fn groups_mut(&mut self) -> &mut [Group<N>] {
        &mut self.groups[..self.len.div_ceil(LANES)]
    }

    /// A number of a path.
    #[inline(always)]
    pub fn number(&self, path: usize, row: usize) -> f64 {
        self.groups[path / LANES][row][path % LANES]
    }

    /// The numbers of a path.
    #[inline(always)]
    pub fn get(&self, path: usize) -> [f64; N] {
        let group = &self.groups[path / LANES];
        std::array::from_fn(|row| group[row][path % LANES])
    }
}

// Loops, since what arrays are mapped by does not get inlined with an instruction set.

/// The numbers of a group, as vectors.
#[inline(always)]
pub(crate) fn load<S: Simd, const N: usize>(simd: S, group: &Group<N>) -> [f64x8<S>; N] {
    let mut numbers = [f64x8::splat(simd, 0.0); N];
    for row in 0..N {
        numbers[row] = f64x8::load_array_ref(simd, &group[row]);
    }
    numbers
}

/// Numbers that are the same in all lanes.
#[inline(always)]
pub(crate) fn splat<S: Simd, const N: usize>(simd: S, numbers: &[f64; N]) -> [f64x8<S>; N] {
    let mut all = [f64x8::splat(simd, 0.0); N];
    for row in 0..N {
        all[row] = f64x8::splat(simd, numbers[row]);
    }
    all
}

/// Fills a group with vectors.
#[inline(always)]
pub(crate) fn store<S: Simd, const N: usize>(group: &mut Group<N>, numbers: [f64x8<S>; N]) {
    for row in 0..N {
        group[row] = numbers[row].into();
    }
}
