//! State of a beam's traversal, shared with the deferred blocks.

use super::batch::BeamGroup;
use super::projection::BeamSpace;
use super::sub_beams::SubBeams;
use crate::bvh::WideBvh;
use crate::intersect::aabb::RaySlabs;
use crate::simd::Lanes;
use crate::traverse::packet::PacketKernel;
use crate::traverse::prefetch::PrefetchTable;
use crate::traverse::query::Query;

/// State of a beam's traversal.
pub(super) struct BeamTraversal<'d, 'a, L: Lanes, G, T> {
    pub(super) wide: &'a WideBvh,
    pub(super) rows: PrefetchTable,
    pub(super) space: &'d BeamSpace,
    pub(super) sub_beams: &'d mut SubBeams,
    pub(super) groups: &'d [BeamGroup<L>],
    pub(super) projected: &'d [[L; 3]],
    pub(super) slabs: &'d [RaySlabs<L>],
    pub(super) queries: &'d mut [G],
    pub(super) packets: &'d mut PacketKernel<'a, L, T>,
    pub(super) counters: &'d mut T,
}

impl<L: Lanes, G: Query<L>, T> BeamTraversal<'_, '_, L, G, T> {
    /// Shortens the search of sub-beams in which a ray hit something.
    #[inline(always)]
    pub(super) fn refresh_depths(&mut self, mut touched: u64) {
        while touched != 0 {
            let sub_beam = touched.trailing_zeros() as usize;
            touched &= touched - 1;
            // SAFETY: as for the tests.
            let query = unsafe { self.queries.get_unchecked(self.sub_beams.group(sub_beam)) };
            self.sub_beams.set_far(self.space, sub_beam, query.limit());
        }
    }
}
