//! The interface of primitives for the packet kernel, and for leaves without blocks in the wide
//! tree.

use super::hit::HitCandidate;
use super::ray_setup::RaySetup;
use crate::simd::Lanes;

/// Lanes that hit a primitive, if any does.
pub(crate) type Candidates<L> = Option<HitCandidate<L>>;

/// A primitive in leaf order, as rays are tested against it.
pub(crate) trait LeafPrim {
    /// `prim_id` of the stored primitive.
    fn prim_id(&self) -> u32;

    /// Lanes that hit the primitive at a positive distance, and the first such hits; with `FAR`,
    /// the second ones, on the far side of a curved primitive that a ray enters. `None` if there is
    /// none. Lanes that cannot hit it before `limit` may be left out.
    fn intersect<L: Lanes, const FAR: bool>(&self, rays: &RaySetup<L>, limit: L) -> Candidates<L>;
}
