//! Deferred triangle tests of shadow rays: the triangles of several blocks are culled together, and
//! then tested.
//!
//! For any hit the order does not matter, so blocks wait until there are [`BLOCKS`] of them. The
//! number of pairs of a sub-beam and a triangle that one block leaves is unpredictable, and a loop
//! with a mispredicted end takes as long as three culls.

use super::batch::BeamGroup;
use super::block::{RayTrianglePair, vertices};
use super::pairs::{BLOCKS, Pairs};
use super::shadow_cull::{ProjectedRays, ShadowCull};
use super::state::BeamTraversal;
use crate::bvh::{LeafKind, TriangleBlock};
use crate::intersect::shear::MIXED;
use crate::simd::{LANES, LaneMask, Lanes, NATIVE};
use crate::traverse::counters::Counters;
use crate::traverse::query::Query;

/// Blocks that wait for their tests.
pub(super) struct DeferredBlocks<'a> {
    /// Blocks, and the sub-beams that may hit them.
    blocks: [Option<&'a TriangleBlock>; BLOCKS],
    sub_beams: [u64; BLOCKS],
    count: usize,
    culls: [ShadowCull; BLOCKS],
    pub(super) pairs: Pairs,
}

impl DeferredBlocks<'_> {
    pub(super) fn none() -> Self {
        DeferredBlocks {
            blocks: [None; BLOCKS],
            sub_beams: [0; BLOCKS],
            count: 0,
            culls: [ShadowCull::NONE; BLOCKS],
            pairs: Pairs::none(),
        }
    }
}

impl<'a, L: Lanes, G: Query<L>, T: Counters> BeamTraversal<'_, 'a, L, G, T> {
    /// Defers a block that some sub-beams may hit.
    #[inline(always)]
    pub(super) fn defer(
        &mut self,
        block: &'a TriangleBlock,
        sub_beams: u64,
        deferred: &mut DeferredBlocks<'a>,
    ) {
        let slot = deferred.count % BLOCKS;
        (deferred.blocks[slot], deferred.sub_beams[slot]) = (Some(block), sub_beams);
        deferred.count += 1;
        if deferred.count == BLOCKS {
            self.test_deferred(deferred);
        }
    }

    /// Culls the triangles of the waiting blocks, and tests the remaining pairs.
    #[inline(never)]
    pub(super) fn test_deferred(&mut self, deferred: &mut DeferredBlocks<'a>) {
        deferred.pairs.count = 0;
        let waits = deferred
            .blocks
            .iter()
            .zip(deferred.sub_beams)
            .take(deferred.count);
        for (slot, (block, sub_beams)) in waits.enumerate() {
            let Some(block) = block else { continue };
            self.counters.block(LeafKind::TRIANGLE, 0);
            let stored = vertices(block);
            let seen = self.space.triangles(&stored, &self.space.relative(&stored));
            let cull = &mut deferred.culls[slot];
            *cull = ShadowCull::new(self.space, self.sub_beams.around(), &seen, &stored);
            let mut left = sub_beams;
            while left != 0 {
                let sub_beam = left.trailing_zeros() as usize;
                left &= left - 1;
                let lanes = self.sub_beams.may_hit(sub_beam, cull, &seen.own);
                deferred.pairs.add(sub_beam, slot, lanes);
            }
        }
        let (culls, pairs) = (&deferred.culls, &mut deferred.pairs);
        pairs.retain(|sub_beam, index| {
            let group = self.sub_beams.group(sub_beam);
            // SAFETY: a sub-beam is of a packet of this beam, each of which has its entry in all
            // three.
            let (rays, seen, query) = unsafe {
                (
                    self.groups.get_unchecked(group),
                    self.projected.get_unchecked(group),
                    self.queries.get_unchecked(group),
                )
            };
            let seen = ProjectedRays {
                p: seen[1],
                q: seen[2],
                org: &rays.rays.org,
            };
            let may = culls[index / NATIVE % BLOCKS].may_hit(index % NATIVE, &seen);
            (may & query.limit().gt(L::ZERO)).any()
        });
        let mut touched = 0u64;
        for k in 0..pairs.count {
            let (sub_beam, index) = pairs.get(k);
            let group = self.sub_beams.group(sub_beam);
            let (slot, lane) = (index / NATIVE % BLOCKS, index % NATIVE);
            let Some(block) = deferred.blocks[slot] else {
                continue;
            };
            // SAFETY: as above.
            let rays = unsafe { self.groups.get_unchecked(group) };
            // SAFETY: as above.
            let query = unsafe { self.queries.get_unchecked_mut(group) };
            let met = match rays.shear.axis {
                MIXED => test_apart(block, lane, rays, query),
                _ => test::<L, false>(block, lane, rays, query),
            };
            touched |= u64::from(met) << sub_beam;
        }
        self.counters
            .tests((pairs.count * L::PACKETS * LANES) as u64);
        deferred.count = 0;
        self.refresh_depths(touched);
    }
}

/// Tests a triangle against rays whose dominant axes differ. A separate function, because it is
/// rare and needs many registers.
#[cold]
#[inline(never)]
fn test_apart<L: Lanes>(
    block: &TriangleBlock,
    lane: usize,
    rays: &BeamGroup<L>,
    query: &mut impl Query<L>,
) -> bool {
    test::<L, true>(block, lane, rays, query)
}

/// Tests a triangle against a packet; returns true if the query accepted a hit.
#[inline(always)]
fn test<L: Lanes, const APART: bool>(
    block: &TriangleBlock,
    lane: usize,
    rays: &BeamGroup<L>,
    query: &mut impl Query<L>,
) -> bool {
    let corners = rays.shear.less_origins::<APART>(block, lane);
    RayTrianglePair { rays, block, lane }.intersect(corners, query)
}
