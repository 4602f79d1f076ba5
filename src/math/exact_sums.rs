//! Sums of f64 that never round.
//!
//! The sum of two f64 is a f64 and an error that is a f64 too (Knuth 1969, section 4.2.2, theorem
//! B). Errors are summed beside the sums; what their sum loses is rare, and kept as an expansion, a
//! list of numbers whose bits do not overlap (Shewchuk 1997, section 2). So a sum is known exactly
//! and does not depend on the order of its terms.

use std::collections::BTreeMap;
use std::collections::TryReserveError;

/// Exact sums of f64, many at a time: 16 bytes each, and a few more for those whose terms differ
/// by 2⁵⁰ and more in size.
///
/// A sum beyond the range of f64 is infinite.
#[derive(Clone, Debug, Default)]
pub struct ExactSums {
    /// Each sum, and what rounding took from it: neighbours in memory.
    sums: Vec<[f64; 2]>,
    /// The loss of the second number by rounding.
    rest: BTreeMap<usize, Vec<f64>>,
}

impl ExactSums {
    /// So many sums, all zero.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn new(count: usize) -> Result<Self, TryReserveError> {
        let mut sums = Vec::new();
        sums.try_reserve_exact(count)?;
        sums.resize(count, [0.0; 2]);
        Ok(Self { sums, rest: BTreeMap::new() })
    }

    /// The number of sums.
    #[must_use]
    pub fn len(&self) -> usize {
        self.sums.len()
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sums.is_empty()
    }

    /// Adds a term to a sum. There is no sum to add to from [`len`](Self::len) on.
    #[inline]
    pub fn add(&mut self, index: usize, term: f64) {
        self.add_all(index, [term]);
    }

    /// Adds terms to as many consecutive sums.
    #[inline]
    pub fn add_all<const N: usize>(&mut self, first: usize, terms: [f64; N]) {
        let Some(sums) = self.sums.get_mut(first..).and_then(|sums| sums.first_chunk_mut::<N>())
        else {
            return;
        };
        let mut rest = [0.0; N];
        for (([sum, lost], term), rest) in sums.iter_mut().zip(terms).zip(&mut rest) {
            let error;
            (*sum, error) = exact_sum(*sum, term);
            (*lost, *rest) = exact_sum(*lost, error);
        }
        // Not a number after an overflow.
        if rest.iter().any(|rest| *rest != 0.0) {
            (first..).zip(rest).for_each(|(index, rest)| self.keep(index, rest));
        }
    }

    /// A sum to within a few units in its last place; 0 from [`len`](Self::len) on.
    #[inline]
    pub(crate) fn rough(&self, index: usize) -> f64 {
        self.sums.get(index).map_or(0.0, |[sum, _]| *sum)
    }

    #[cold]
    fn keep(&mut self, index: usize, rest: f64) {
        if rest == 0.0 {
            return;
        }
        let [sum, lost] = &mut self.sums[index];
        if sum.is_finite() {
            grow(self.rest.entry(index).or_default(), rest);
        } else {
            *lost = 0.0;
            self.rest.remove(&index);
        }
    }

    /// Adds the sums of others, each to that of the same number.
    pub fn merge(&mut self, others: &Self) {
        for (index, terms) in others.sums.iter().enumerate() {
            terms.iter().for_each(|term| self.add(index, *term));
        }
        for (index, terms) in &others.rest {
            terms.iter().for_each(|term| self.add(*index, *term));
        }
    }

    /// The f64 nearest to a sum (to even, if two are): 0 from [`len`](Self::len) on.
    #[inline]
    #[must_use]
    pub fn get(&self, index: usize) -> f64 {
        let [sum, lost] = self.sums.get(index).copied().unwrap_or_default();
        match self.rest.is_empty() || !self.rest.contains_key(&index) {
            true => sum + lost,
            false => nearest(&self.expansion(index)),
        }
    }

    /// The first two of the [parts](Self::parts) of a sum, or zeros in their place.
    #[must_use]
    pub fn leading(&self, index: usize) -> [f64; 2] {
        if self.rest.contains_key(&index) {
            let parts = self.parts(index);
            return [0, 1].map(|part| parts.get(part).copied().unwrap_or(0.0));
        }
        let [sum, lost] = self.sums.get(index).copied().unwrap_or_default();
        if sum.is_finite() { exact_sum(sum, lost).into() } else { [sum, 0.0] }
    }

    /// The other [parts](Self::parts) of all sums that have more than two, each with the number of
    /// its sum.
    pub fn trailing(&self) -> impl Iterator<Item = (usize, f64)> {
        let parts = |index: usize| self.parts(index).into_iter().skip(2);
        self.rest.keys().flat_map(move |index| parts(*index).map(|part| (*index, part)))
    }

    /// The one expansion of a sum in which each number is the f64 nearest to all that is left: its
    /// first is [`get`](Self::get), and sums that are the same have the same one.
    #[must_use]
    pub fn parts(&self, index: usize) -> Vec<f64> {
        let mut left = self.expansion(index);
        let mut parts = Vec::new();
        while !left.is_empty() {
            let part = nearest(&left);
            parts.push(part);
            if !part.is_finite() {
                break;
            }
            grow(&mut left, -part);
        }
        parts
    }

    /// Numbers whose bits do not overlap, by size, that make up a sum.
    fn expansion(&self, index: usize) -> Vec<f64> {
        let mut expansion = self.rest.get(&index).cloned().unwrap_or_default();
        let [sum, lost] = self.sums.get(index).copied().unwrap_or_default();
        if !sum.is_finite() {
            return vec![sum];
        }
        grow(&mut expansion, lost);
        grow(&mut expansion, sum);
        expansion
    }
}

/// A sum of each two numbers.
impl FromIterator<[f64; 2]> for ExactSums {
    fn from_iter<I: IntoIterator<Item = [f64; 2]>>(terms: I) -> Self {
        let sums = terms.into_iter().map(|[a, b]| exact_sum(a, b).into()).collect();
        Self { sums, rest: BTreeMap::new() }
    }
}

/// The sum of two numbers as it is rounded, and what rounding took from it.
#[inline]
fn exact_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_in_sum = sum - a;
    (sum, (a - (sum - b_in_sum)) + (b - b_in_sum))
}

/// Adds a number to an expansion, which is by size and without zeros.
fn grow(expansion: &mut Vec<f64>, term: f64) {
    let mut sum = term;
    expansion.retain_mut(|part| {
        (sum, *part) = exact_sum(sum, *part);
        *part != 0.0
    });
    if sum != 0.0 {
        expansion.push(sum);
    }
}

/// The f64 nearest to an expansion, to even if two are.
fn nearest(expansion: &[f64]) -> f64 {
    let mut parts = expansion.iter().rev().copied();
    let mut sum = parts.next().unwrap_or(0.0);
    while let Some(part) = parts.next() {
        let error;
        (sum, error) = exact_sum(sum, part);
        if error == 0.0 {
            continue;
        }
        // Half way between two, the rest decides; it is smaller than the error.
        let other = sum + 2.0 * error;
        let is_half_way = other - sum == 2.0 * error;
        if is_half_way && parts.next().is_some_and(|next| (next > 0.0) == (error > 0.0)) {
            sum = other;
        }
        break;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn sum_of(terms: impl IntoIterator<Item = f64>) -> ExactSums {
        let mut sums = ExactSums::new(1).unwrap();
        terms.into_iter().for_each(|term| sums.add(0, term));
        sums
    }

    /// Terms of all sizes, of both signs.
    fn terms(random: &mut Pcg64, exponents: i32) -> Vec<f64> {
        let term = |random: &mut Pcg64| {
            let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
            sign * random.random::<f64>()
                * f64::from(random.random_range(-exponents..=exponents)).exp2()
        };
        (0..200).map(|_| term(random)).collect()
    }

    #[test]
    fn sums_are_the_numbers_nearest_to_the_exact_ones() {
        for (terms, sum) in [
            (vec![], 0.0),
            (vec![1e308, 1.0, -1e308], 1.0),
            (vec![1.0, 2f64.powi(-53)], 1.0),
            // Just beside half way, by something far below.
            (vec![1.0, 2f64.powi(-53), f64::MIN_POSITIVE], 1.0 + f64::EPSILON),
            (vec![1.0, 2f64.powi(-53), -f64::MIN_POSITIVE], 1.0),
            (vec![1.0 + f64::EPSILON, 2f64.powi(-53), -f64::MIN_POSITIVE], 1.0 + f64::EPSILON),
            (vec![1.0 + f64::EPSILON, 2f64.powi(-53)], 1.0 + 2.0 * f64::EPSILON),
            (vec![5e-324; 3], 1.5e-323),
            (vec![1e100, 1.0, 1e-100, -1e100, -1.0], 1e-100),
            (vec![f64::MAX, f64::MAX, -1.0], f64::INFINITY),
        ] {
            assert_eq!(sum_of(terms.iter().copied()).get(0), sum, "{terms:?}");
            assert_eq!(sum_of(terms.iter().rev().copied()).get(0), sum, "{terms:?} reversed");
        }
    }

    #[test]
    fn sums_of_integers_are_those_of_integers() {
        let mut random = Pcg64::seed_from_u64(1);
        for _ in 0..100 {
            let terms: Vec<i128> = (0..100)
                .map(|_| i128::from(random.random::<i64>() >> 11) << random.random_range(0..60))
                .collect();
            let sum = sum_of(terms.iter().map(|term| *term as f64)).get(0);
            assert_eq!(sum, terms.iter().sum::<i128>() as f64);
        }
    }

    #[test]
    fn the_order_and_the_grouping_of_terms_do_not_matter() {
        let mut random = Pcg64::seed_from_u64(2);
        for exponents in [1, 30, 300, 900] {
            let terms = terms(&mut random, exponents);
            let all = sum_of(terms.iter().copied());
            for parts in [2, 7, 50] {
                let mut merged = ExactSums::new(1).unwrap();
                for first in (0..parts).rev() {
                    merged.merge(&sum_of(terms.iter().copied().skip(first).step_by(parts)));
                }
                assert_eq!(merged.get(0), all.get(0));
                assert_eq!(merged.parts(0), all.parts(0), "{exponents} {parts}");
            }
            let parts = all.parts(0);
            assert_eq!(sum_of(parts.iter().map(|part| -part)).get(0), -all.get(0));
            let nothing = sum_of(terms.iter().copied().chain(parts.iter().map(|part| -part)));
            assert!(nothing.parts(0).is_empty(), "{exponents}: {:?}", nothing.parts(0));
        }
    }

    #[test]
    fn there_are_as_many_sums_as_asked_for() {
        let mut sums = ExactSums::new(2).unwrap();
        sums.add(2, 1.0);
        assert_eq!((sums.len(), sums.is_empty(), sums.get(2)), (2, false, 0.0));
        assert!(ExactSums::new(usize::MAX / 64).is_err());
    }
}
