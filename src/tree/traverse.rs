//! The walk of a ray through the wide tree: front to back for the nearest hit, in any order to find
//! out whether there is one.
//!
//! Eight boxes or four triangles are tested at a time; what passes is handed to the caller, whose
//! exact test decides. Written once for all instruction sets; the caller chooses one at run time.

use super::boxes::{BoxRay, Splat, enter};
use super::facets::{Facets, Tested};
use super::layout::{Candidate, Child, LANES, Line, WIDTH, Wide};
use super::rounding::FAR;
use super::stack::{STACK, Stack, prefetch, take, take_last};
use fearless_simd::{Simd, f32x4, prelude::*};

/// Entry distance and child in one number, which sorts by distance.
#[inline(always)]
fn key(distance: i32, child: Child) -> u64 {
    u64::from(distance as u32) << 32 | u64::from(child.0)
}

/// The state of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// A walk at something that was just asked for and may take a while to come.
    Descended,
    /// A walk at something that was asked for earlier.
    Returned,
    /// A walk at its end.
    Done,
}

/// The walk of a ray to its nearest hit.
pub(super) struct Nearest<'a> {
    limit: f32,
    pub child: Child,
    length: usize,
    /// The hit that is certain and yet to be tested.
    pub held: Option<Candidate<'a>>,
    held_primitive: u32,
    held_near: f32,
}

impl Default for Nearest<'_> {
    #[inline(always)]
    fn default() -> Self {
        Self {
            limit: FAR,
            child: Child(0),
            length: 0,
            held: None,
            held_primitive: u32::MAX,
            held_near: f32::INFINITY,
        }
    }
}

impl Nearest<'_> {
    /// The walk of a ray up to a limit.
    #[inline(always)]
    pub fn before(limit: f32) -> Self {
        Self { limit: limit.min(FAR), ..Self::default() }
    }

    /// The walk of a ray without hits.
    #[inline(always)]
    pub fn ended() -> Self {
        Self { child: Child::NOWHERE, ..Self::default() }
    }
}

/// The walk of a ray to any hit.
pub(super) struct Any {
    limit: f32,
    pub child: Child,
    length: usize,
    /// True if there is one.
    pub hit: bool,
}

impl Any {
    #[inline(always)]
    pub fn new(limit: f32) -> Self {
        Self { limit: limit.min(FAR), child: Child(0), length: 0, hit: false }
    }

    /// A walk whose answer is known.
    #[inline(always)]
    pub fn ended(hit: bool) -> Self {
        Self { limit: 0.0, child: Child::NOWHERE, length: 0, hit }
    }
}

impl Wide {
    /// Asks for memory that a ray will visit later.
    #[inline(always)]
    pub fn prefetch<S: Simd>(&self, simd: S, child: Child) {
        prefetch(simd, self.lines.as_ptr().wrapping_add(child.line()).cast::<[Line; 4]>());
    }

    /// Visits one node or leaf on the way to the nearest hit, and offers candidates roughly from
    /// near to far. `test` gets one and returns the limit from then on if it has come down. A hit
    /// that is certain is held back, which `prepare` gets to know; the last one of them is yet to
    /// be tested at the end. The ray does not hit the primitive `origin` unless `test` says so.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub fn step_to_nearest<'a, S: Simd>(
        &'a self,
        simd: S,
        ray: &BoxRay,
        wide: &Splat<S>,
        walk: &mut Nearest<'a>,
        stack: &mut Stack<u64>,
        origin: u32,
        prepare: impl Fn(Candidate<'a>),
        mut test: impl FnMut(Candidate<'a>) -> Option<f32>,
    ) -> Step {
        if walk.child.is_leaf() {
            let Some(block) = self.block(walk.child.line()) else { return Step::Done };
            let limit = f32x4::splat(simd, walk.limit);
            let tested =
                Tested::new(simd, &wide.origin, &wide.direction, limit, Facets::new(simd, block));
            let mut hits = tested.hits.to_bitmask();
            if hits != 0 {
                let certain = tested.certain().to_bitmask();
                let (near, far) = tested.interval(simd);
                let (near, far) = (near.to_array(), far.to_array());
                while hits != 0 {
                    let lane = take(&mut hits) % LANES;
                    let candidate = Candidate { block, lane };
                    let primitive = candidate.primitive();
                    let certain = certain >> lane & 1 != 0;
                    if certain
                        && (primitive == walk.held_primitive
                            || primitive == origin
                            || near[lane] > walk.limit)
                    {
                        continue;
                    }
                    if certain && far[lane] < walk.held_near {
                        (walk.held, walk.held_primitive, walk.held_near) =
                            (Some(candidate), primitive, near[lane]);
                        walk.limit = walk.limit.min(far[lane]);
                        prepare(candidate);
                        continue;
                    }
                    if let Some(nearer) = test(candidate) {
                        walk.limit = walk.limit.min(nearer);
                    }
                }
            }
        } else {
            let Some(node) = self.node(walk.child.line()) else { return Step::Done };
            let (near, mut hits) = enter(simd, ray, wide, node, walk.limit);
            if hits != 0 {
                let lane = take(&mut hits) % WIDTH;
                walk.child = node.child(lane);
                self.prefetch(simd, walk.child);
                if hits == 0 {
                    return Step::Descended;
                }
                stack.reserve(&mut walk.length);
                let near = near.to_array();
                let mut best = key(near[lane], walk.child);
                let lane = take(&mut hits) % WIDTH;
                let other = key(near[lane], node.child(lane));
                self.prefetch(simd, node.child(lane));
                let first = walk.length;
                stack.entries[walk.length % STACK] = best.max(other);
                best = best.min(other);
                walk.length += 1;
                while hits != 0 {
                    let lane = take(&mut hits) % WIDTH;
                    let other = key(near[lane], node.child(lane));
                    self.prefetch(simd, node.child(lane));
                    let farther = best.max(other);
                    best = best.min(other);
                    // Insertion, farthest first.
                    let mut at = walk.length;
                    walk.length += 1;
                    while at > first && stack.entries[(at - 1) % STACK] < farther {
                        stack.entries[at % STACK] = stack.entries[(at - 1) % STACK];
                        at -= 1;
                    }
                    stack.entries[at % STACK] = farther;
                }
                walk.child = Child(best as u32);
                return Step::Descended;
            }
        }
        while let Some(next) = stack.pop(&mut walk.length) {
            if (next >> 32) as u32 <= walk.limit.to_bits() {
                walk.child = Child(next as u32);
                return Step::Returned;
            }
        }
        Step::Done
    }

    /// Visits one node or leaf until `test` is true of any candidate before the limit. It gets one
    /// and whether that is certainly hit well before the limit.
    #[inline(always)]
    pub fn step_to_any<'a, S: Simd>(
        &'a self,
        simd: S,
        ray: &BoxRay,
        wide: &Splat<S>,
        walk: &mut Any,
        stack: &mut Stack<u32>,
        mut test: impl FnMut(Candidate<'a>, bool) -> bool,
    ) -> Step {
        if walk.child.is_leaf() {
            let Some(block) = self.block(walk.child.line()) else { return Step::Done };
            let limit = f32x4::splat(simd, walk.limit);
            let tested =
                Tested::new(simd, &wide.origin, &wide.direction, limit, Facets::new(simd, block));
            let mut hits = tested.hits.to_bitmask();
            if hits != 0 {
                let certain = tested.certain_before(limit).to_bitmask();
                while hits != 0 {
                    let lane = take(&mut hits) % LANES;
                    if test(Candidate { block, lane }, certain >> lane & 1 != 0) {
                        walk.hit = true;
                        return Step::Done;
                    }
                }
            }
        } else {
            let Some(node) = self.node(walk.child.line()) else { return Step::Done };
            let mut hits = enter(simd, ray, wide, node, walk.limit).1;
            if hits != 0 {
                walk.child = node.child(take(&mut hits) % WIDTH);
                self.prefetch(simd, walk.child);
                stack.reserve(&mut walk.length);
                while hits != 0 {
                    let other = node.child(take_last(&mut hits) % WIDTH);
                    self.prefetch(simd, other);
                    stack.entries[walk.length % STACK] = other.0;
                    walk.length += 1;
                }
                return Step::Descended;
            }
        }
        let Some(next) = stack.pop(&mut walk.length) else { return Step::Done };
        walk.child = Child(next);
        Step::Returned
    }
}
