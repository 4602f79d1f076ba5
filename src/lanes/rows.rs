//! Numbers of many paths in the order in which lanes read them.

use super::LANES;
use fearless_simd::{Simd, f64x8, prelude::*};

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

    /// Adds the numbers of one more path.
    #[inline(always)]
    pub fn push(&mut self, numbers: [f64; N]) {
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

    /// The numbers of a path.
    #[inline(always)]
    pub fn get(&self, path: usize) -> [f64; N] {
        let group = &self.groups[path / LANES];
        std::array::from_fn(|row| group[row][path % LANES])
    }
}

/// The numbers of a group, as vectors.
#[inline(always)]
pub(crate) fn load<S: Simd, const N: usize>(simd: S, group: &Group<N>) -> [f64x8<S>; N] {
    std::array::from_fn(|row| f64x8::load_array_ref(simd, &group[row]))
}

/// Fills a group with vectors.
#[inline(always)]
pub(crate) fn store<S: Simd, const N: usize>(group: &mut Group<N>, numbers: [f64x8<S>; N]) {
    for (row, numbers) in group.iter_mut().zip(numbers) {
        *row = numbers.into();
    }
}
