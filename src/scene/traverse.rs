//! How a ray walks through the wide tree: front to back for the nearest hit, in any order to find
//! out whether there is one.
//!
//! Eight boxes or four triangles are tested at a time, in f32, with tolerances that let nothing
//! slip; what passes is handed to the caller, whose exact test decides. Written once for all
//! instruction sets; the caller chooses one at run time.

use super::bvh::ROUNDOFF;
use super::wide::{Block, Candidate, Child, LANES, Line, Node, WIDTH, Wide};
use fearless_simd::{Simd, f32x4, f32x8, i32x8, prelude::*, u32x4, u32x8};

/// A bound on the distance of any hit, since rays start in or at the cube [-1, 1]³.
pub(super) const FAR: f32 = 4.0;

/// Entries that a ray's stack holds before it moves some to the heap; few in tests, so that it
/// comes to that.
const STACK: usize = if cfg!(test) { 16 } else { 64 };

/// A ray in the space of the boxes.
pub(super) struct BoxRay {
    origin: [f32; 3],
    direction: [f32; 3],
    /// Of the direction's components.
    reciprocal: [f32; 3],
    /// Minus origin times reciprocal.
    offset: [f32; 3],
    /// For axes along which the ray runs downwards: which of a box's two planes it meets first.
    backwards: [bool; 3],
}

impl BoxRay {
    #[inline(always)]
    pub fn new(origin: glam::Vec3, direction: glam::Vec3) -> Self {
        let (origin, direction) = (origin.to_array(), direction.to_array());
        // A component too small to matter still needs a finite reciprocal.
        let reciprocal =
            direction.map(|d| 1.0 / if d.abs() < SMALLEST { SMALLEST.copysign(d) } else { d });
        let offset = [0, 1, 2].map(|i| -origin[i] * reciprocal[i]);
        let backwards = reciprocal.map(|r| r < 0.0);
        Self { origin, direction, reciprocal, offset, backwards }
    }
}

/// Smaller components of a direction count as this.
pub(super) const SMALLEST: f32 = 1.0 / (1u64 << 60) as f32;

/// Vectors that hold one number of the ray in each lane.
pub(super) struct Splat<S: Simd> {
    origin: [f32x4<S>; 3],
    direction: [f32x4<S>; 3],
    reciprocal: [f32x8<S>; 3],
    offset: [f32x8<S>; 3],
}

#[inline(always)]
fn splat<S: Simd, V: SimdBase<S, Element = f32>>(simd: S, v: &[f32; 3]) -> [V; 3] {
    [V::splat(simd, v[0]), V::splat(simd, v[1]), V::splat(simd, v[2])]
}

impl<S: Simd> Splat<S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &BoxRay) -> Self {
        Self {
            origin: splat(simd, &ray.origin),
            direction: splat(simd, &ray.direction),
            reciprocal: splat(simd, &ray.reciprocal),
            offset: splat(simd, &ray.offset),
        }
    }
}

/// The distances at which the ray enters a node's boxes, as bits, and a bit for each that it enters
/// before `limit`.
///
/// Floats that are not negative have the order of their bits, and finding the greater of two
/// integers takes less time. Negative ones have the reverse order, but since 0 is among the
/// distances of entry and a box that is left at a negative one is missed, it does not matter.
#[inline(always)]
fn enter<S: Simd>(
    simd: S,
    ray: &BoxRay,
    wide: &Splat<S>,
    node: Node<'_>,
    limit: f32,
) -> (i32x8<S>, u64) {
    let plane = |axis: usize, side: bool| {
        let plane = u32x8::load_array_ref(simd, node.planes(axis, side)).bitcast::<f32x8<S>>();
        plane.mul_add(wide.reciprocal[axis], wide.offset[axis]).bitcast::<i32x8<S>>()
    };
    let [x, y, z] = ray.backwards;
    let near = plane(0, x).max(plane(1, y)).max(plane(2, z).max(i32x8::splat(simd, 0)));
    let far = plane(0, !x)
        .min(plane(1, !y))
        .min(plane(2, !z).min(i32x8::splat(simd, limit.to_bits() as i32)));
    (near, near.simd_le(far).to_bitmask())
}

/// Triangles, in each lane the same or another: a vertex, edges and normal, by how much edge
/// functions and distance may be off.
pub(super) struct Facets<V> {
    pub vertex: [V; 3],
    pub edge1: [V; 3],
    pub edge2: [V; 3],
    pub normal: [V; 3],
    pub tolerance: V,
    pub slack: V,
}

impl<S: Simd> Facets<f32x4<S>> {
    /// Those of a block.
    #[inline(always)]
    pub fn new(simd: S, block: Block<'_>) -> Self {
        let row = |v: &[u32; LANES]| u32x4::load_array_ref(simd, v).bitcast::<f32x4<S>>();
        let load = |v: [&[u32; LANES]; 3]| [row(v[0]), row(v[1]), row(v[2])];
        let (edge1, edge2) = (load(block.edge1()), load(block.edge2()));
        Self {
            vertex: load(block.vertex()),
            edge1,
            edge2,
            normal: cross(edge1, edge2),
            tolerance: row(block.tolerance()),
            slack: row(block.distance_tolerance()),
        }
    }
}

#[inline(always)]
fn cross<S: Simd, V: SimdFloat<S>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [
        a[1].mul_sub(b[2], a[2] * b[1]),
        a[2].mul_sub(b[0], a[0] * b[2]),
        a[0].mul_sub(b[1], a[1] * b[0]),
    ]
}

#[inline(always)]
fn dot<S: Simd, V: SimdFloat<S>>(a: [V; 3], b: [V; 3]) -> V {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// What the test in f32 says about rays and triangles, in each lane one of each; see "Why no
/// triangle is missed" in [`super::bvh`].
pub(super) struct Tested<S: Simd, V: SimdBase<S>> {
    /// Which triangles the ray may hit before the limit.
    pub hits: V::Mask,
    tolerance: V,
    slack: V,
    /// The least and the greatest edge function.
    least: V,
    most: V,
    /// Positive, with the distance times it.
    determinant: V,
    t: V,
}

impl<S: Simd, V: SimdFloat<S, Element = f32>> Tested<S, V> {
    #[inline(always)]
    pub fn new(simd: S, origin: &[V; 3], direction: &[V; 3], limit: V, facets: Facets<V>) -> Self {
        let Facets { vertex, edge1, edge2, normal, tolerance, slack } = facets;
        let c = [vertex[0] - origin[0], vertex[1] - origin[1], vertex[2] - origin[2]];
        let r = cross(c, *direction);
        let determinant = dot(normal, *direction);
        let u = dot(r, edge2);
        let minus_v = dot(r, edge1);
        let w = determinant - u + minus_v;
        let v = -minus_v;
        let (least, most) = (u.min(v).min(w), u.max(v).max(w));
        let t = dot(normal, c);
        let sign = V::splat(simd, 1.0).copysign(determinant);
        let (t, determinant) = (t * sign, determinant * sign);
        let inside = least.simd_ge(-tolerance) | most.simd_le(tolerance);
        let reached = t.simd_ge(-slack) & t.simd_le(determinant.mul_add(limit, slack));
        Self { hits: inside & reached, tolerance, slack, least, most, determinant, t }
    }

    /// Which triangles the ray certainly hits somewhere.
    #[inline(always)]
    pub fn certain(&self) -> V::Mask {
        let inside = self.least.simd_gt(self.tolerance) | self.most.simd_lt(-self.tolerance);
        inside & self.t.simd_gt(self.slack)
    }

    /// The same for before the limit.
    #[inline(always)]
    pub fn certain_before(&self, limit: V) -> V::Mask {
        self.certain() & self.t.simd_lt(self.determinant * limit - self.slack)
    }

    /// Bounds on the distance to triangles that are certainly hit.
    #[inline(always)]
    pub fn interval(&self, simd: S) -> (V, V) {
        let reciprocal = V::splat(simd, 1.0) / self.determinant;
        let (near, far) = ((self.t - self.slack) * reciprocal, (self.t + self.slack) * reciprocal);
        (near * (1.0 - 6.0 * ROUNDOFF), far * (1.0 + 6.0 * ROUNDOFF))
    }
}

/// Entry distance and child in one number, which sorts by distance.
#[inline(always)]
fn key(distance: i32, child: Child) -> u64 {
    u64::from(distance as u32) << 32 | u64::from(child.0)
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
fn take_last(bits: &mut u64) -> usize {
    let lane = 63 - bits.leading_zeros() as usize;
    *bits ^= 1 << lane;
    lane
}

/// What a ray has yet to visit, the nearest last. How many of the entries count is told by the
/// walk, which the compiler keeps in registers that way.
pub(super) struct Stack<T> {
    entries: [T; STACK],
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

/// How far a walk is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// At something that was just asked for and may take a while to come.
    Descended,
    /// At something that was asked for earlier.
    Returned,
    /// At its end.
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
    /// That of a ray without hits.
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
    /// Whether there is one.
    pub hit: bool,
}

impl Any {
    #[inline(always)]
    pub fn new(limit: f32) -> Self {
        Self { limit: limit.min(FAR), child: Child(0), length: 0, hit: false }
    }

    /// One of which the answer is known.
    #[inline(always)]
    pub fn ended(hit: bool) -> Self {
        Self { limit: 0.0, child: Child::NOWHERE, length: 0, hit }
    }
}

impl Wide {
    /// Asks for what a ray will visit later.
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
