//! Packets of eight rays and of eight hits, and the arena-backed queues that keep them full.

pub mod camera;
mod queue;

pub use queue::{QueueColumns, QueueStorage, RayQueue};

use crate::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, U32x8, Vec3Lanes};

pub use phalanx_scene::NO_PRIM;

/// Rays as columns of lanes, eight by default.
#[derive(Clone, Copy, Debug)]
pub struct RayPacket<L = F32x8> {
    /// Origins.
    pub org: Vec3Lanes<L>,
    /// Directions, not necessarily of unit length.
    pub dir: Vec3Lanes<L>,
    /// Hits count only below this distance (in units of `dir`).
    pub tmax: L,
}

/// Hits of a packet of rays.
#[derive(Clone, Copy, Debug)]
pub struct HitPacket<L: Lanes = F32x8> {
    /// Distance in units of the ray's direction; `tmax` for a miss.
    pub t: L,
    /// Barycentric weight of a triangle's second vertex, else 0.
    pub u: L,
    /// Barycentric weight of a triangle's third vertex, else 0.
    pub v: L,
    /// Primitive in the scene's numbering, including instances, or [`NO_PRIM`].
    pub prim_id: L::U32,
}

impl HitPacket {
    /// Replaces one lane: distance, weights, number.
    #[inline]
    pub fn set(&mut self, lane: usize, [t, u, v]: [f32; 3], prim_id: u32) {
        self.t.set_lane(lane, t);
        self.u.set_lane(lane, u);
        self.v.set_lane(lane, v);
        self.prim_id.set_lane(lane, prim_id);
    }

    /// The lanes of `yes` where `mask` is set, and those of `no` elsewhere.
    #[inline]
    pub fn select(mask: Mask8, yes: &HitPacket, no: &HitPacket) -> HitPacket {
        HitPacket {
            t: mask.select(yes.t, no.t),
            u: mask.select(yes.u, no.u),
            v: mask.select(yes.v, no.v),
            prim_id: mask.select_u32(yes.prim_id, no.prim_id),
        }
    }

    /// A packet of misses.
    #[inline]
    pub fn miss() -> HitPacket {
        HitPacket {
            t: F32x8::splat(f32::INFINITY),
            u: F32x8::ZERO,
            v: F32x8::ZERO,
            prim_id: U32x8::splat(NO_PRIM),
        }
    }
}

impl<L: Lanes> HitPacket<L> {
    /// The k-th octet of lanes.
    #[inline(always)]
    pub fn octet(&self, k: usize) -> HitPacket {
        HitPacket {
            t: self.t.octet(k),
            u: self.u.octet(k),
            v: self.v.octet(k),
            prim_id: self.prim_id.octet(k),
        }
    }
}

/// Number of packets that `rays` rays need.
#[inline]
pub fn packets_for(rays: usize) -> usize {
    rays.div_ceil(LANES)
}
