//! The stack of nodes that a ray has yet to visit, and prefetches of memory that it will need.

use super::layout::WIDTH;
use fearless_simd::Simd;

/// Entries that a ray's stack holds before it moves some to the heap; few in tests, so that it
/// comes to that.
pub(super) const STACK: usize = if cfg!(test) { 16 } else { 64 };

/// The nodes that a ray has yet to visit, the nearest last. The number of entries that count is
/// kept by the walk, in a register.
pub(super) struct Stack<T> {
    pub entries: [T; STACK],
    heap: Vec<T>,
}

impl<T: Copy + Default> Default for Stack<T> {
    #[inline(always)]
    fn default() -> Self {
        Self { entries: [T::default(); STACK], heap: Vec::new() }
    }
}

impl<T: Copy> Stack<T> {
    /// Makes room for the children of a node.
    #[inline(always)]
    pub fn reserve(&mut self, length: &mut usize) {
        if *length > STACK - WIDTH {
            spill(&self.entries[..*length], &mut self.heap);
            *length = 0;
        }
    }

    #[inline(always)]
    pub fn push(&mut self, length: &mut usize, entry: T) {
        self.entries[*length % STACK] = entry;
        *length += 1;
    }

    #[inline(always)]
    pub fn pop(&mut self, length: &mut usize) -> Option<T> {
        if *length == 0 {
            return self.heap.pop();
        }
        *length -= 1;
        Some(self.entries[*length % STACK])
    }
}

/// Moves what a ray has yet to visit out of the array, for trees so deep that it does not suffice.
#[cold]
#[inline(never)]
fn spill<T: Copy>(stack: &[T], heap: &mut Vec<T>) {
    heap.extend_from_slice(stack);
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    #[inline(always)]
    fn prefetch_line(sse2: Sse2, address: *const i8) {
        let _ = sse2;
        std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(address);
    }
);

/// Asks for an item's memory, which will be needed soon.
#[cfg_attr(not(target_arch = "x86_64"), expect(unused_variables, reason = "a hint, no more"))]
#[inline(always)]
pub(super) fn prefetch<S: Simd, T>(simd: S, item: *const T) {
    #[cfg(target_arch = "x86_64")]
    if let Some(sse2) = simd.level().as_sse2() {
        for line in 0..size_of::<T>().div_ceil(64) {
            prefetch_line(sse2, item.cast::<i8>().wrapping_add(64 * line));
        }
    }
}

/// Takes the lowest lane out of a set of bits.
#[inline(always)]
pub(super) fn take(bits: &mut u64) -> usize {
    let lane = bits.trailing_zeros() as usize;
    *bits &= *bits - 1;
    lane
}

/// Takes the highest lane out of a set of bits.
#[inline(always)]
pub(super) fn take_last(bits: &mut u64) -> usize {
    let lane = 63 - bits.leading_zeros() as usize;
    *bits ^= 1 << lane;
    lane
}
