//! The interface of primitives for the packet kernel, and for leaves without blocks in the wide
//! tree.

use super::hit::HitCandidate;
use super::ray_setup::RaySetup;
use crate::simd::Lanes;

/// A primitive in leaf order, as rays are tested against it.
pub(crate) trait LeafPrim {
    /// `prim_id` of the stored primitive.
    fn prim_id(&self) -> u32;

    /// Lanes that hit the primitive at a positive distance, and the hits; `None` if there is none.
    /// Lanes that cannot hit it before `limit` may be left out.
    fn intersect<L: Lanes>(&self, rays: &RaySetup<L>, limit: L) -> Option<HitCandidate<L>>;
}
