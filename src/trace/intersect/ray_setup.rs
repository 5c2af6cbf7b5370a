//! Rays prepared for the tests.

use super::aabb::RaySlabs;
use super::shear::Shear;
use crate::packet::RayPacket;
use crate::simd::Lanes;

/// Rays with the values that the tests derive from them once.
#[derive(Clone, Copy)]
pub(crate) struct RaySetup<L: Lanes> {
    pub(crate) rays: RayPacket<L>,
    pub(crate) slabs: RaySlabs<L>,
    pub(crate) shear: Shear<L>,
}

impl<L: Lanes> RaySetup<L> {
    #[inline(always)]
    pub(crate) fn new(rays: &RayPacket<L>, active: L::Mask) -> RaySetup<L> {
        RaySetup {
            rays: *rays,
            slabs: RaySlabs::new(rays.org, rays.dir, active),
            shear: Shear::new(rays.org, rays.dir, active),
        }
    }
}
