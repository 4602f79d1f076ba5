//! Packets of segments: those that nothing lies on.

use super::rays::{Packet, RAYS, Rows, pays};
use crate::tree::bvh::Bvh;
use crate::tree::facets::Tested;
use crate::tree::layout::{Block, Candidate, LANES};
use crate::tree::query::Segment;
use crate::tree::rounding::FAR;
use crate::tree::stack::take;
use fearless_simd::{Simd, dispatch, prelude::*, u32x16};
use glam::DVec3;

/// The answers of [`Bvh::is_free`] for many segments in a scene of few facets. Returns true if that
/// pays.
#[inline(never)]
pub(in crate::tree) fn are_free(
    bvh: &Bvh,
    segments: &[Result<Segment, bool>],
    free: &mut [bool],
) -> bool {
    !bvh.few.is_empty()
        && dispatch!(bvh.level, simd => pays(simd) && are_free_with(simd, bvh, segments, free))
}

#[inline(always)]
fn are_free_with<S: Simd>(
    simd: S,
    bvh: &Bvh,
    segments: &[Result<Segment, bool>],
    free: &mut [bool],
) -> bool {
    for (segments, answers) in segments.chunks(RAYS).zip(free.chunks_mut(RAYS)) {
        let mut inside = [Segment::free(DVec3::ZERO, DVec3::ZERO, 0.0); RAYS];
        let (mut packet, mut free, mut unknown) = (Packet::new(), 0, 0);
        for (lane, segment) in segments.iter().enumerate() {
            match segment.and_then(|segment| bvh.part_inside(&segment).ok_or(true)) {
                Ok(segment) => {
                    packet.set(
                        lane,
                        bvh,
                        segment.origin,
                        segment.direction,
                        bvh.round_up(segment.length).min(FAR),
                    );
                    inside[lane] = segment;
                    unknown |= 1 << lane;
                }
                Err(known) => free |= u64::from(known) << lane,
            }
        }
        free |= unblocked(simd, bvh, &packet, &inside, unknown);
        for (lane, answer) in answers.iter_mut().enumerate() {
            *answer = free >> lane & 1 != 0;
        }
    }
    true
}

/// The segments of a packet, given by a bit for each, that nothing lies on.
#[inline(always)]
fn unblocked<S: Simd>(
    simd: S,
    bvh: &Bvh,
    packet: &Packet,
    segments: &[Segment; RAYS],
    mut free: u64,
) -> u64 {
    let (origin, direction, limit) = packet.load(simd);
    let origins = u32x16::from_fn(simd, |lane| segments[lane].ends.origin);
    let ends = u32x16::from_fn(simd, |lane| segments[lane].ends.end);
    for block in &bvh.few {
        let block = Block(block);
        let rows = Rows::new(simd, block);
        for lane in 0..LANES {
            let tested = Tested::new(simd, &origin, &direction, limit, rows.facet(simd, lane));
            let hits = tested.hits.to_bitmask() & free;
            if hits == 0 {
                continue;
            }
            let candidate = Candidate { block, lane };
            let primitive = u32x16::splat(simd, candidate.primitive());
            let touched = primitive.simd_eq(origins) | primitive.simd_eq(ends);
            let certain = (tested.certain_before(limit) & !touched).to_bitmask() & hits;
            free &= !certain;
            let mut unclear = hits & !certain;
            while unclear != 0 {
                let lane = take(&mut unclear) % RAYS;
                if bvh.blocks(candidate, &segments[lane]) {
                    free &= !(1 << lane);
                }
            }
            if free == 0 {
                return 0;
            }
        }
    }
    free
}
