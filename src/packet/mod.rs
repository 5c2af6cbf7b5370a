//! Packets of eight rays and of eight hits, and the arena-backed queues that keep them full.

mod queue;

pub use queue::RayQueue;

use crate::lanes::{F32x8, LANES, U32x8, Vec3x8};

/// `prim_id` of a lane that hit nothing.
pub const NO_PRIM: u32 = u32::MAX;

/// Eight rays as columns of lanes. Lanes at and above `count` carry no ray.
#[derive(Clone, Copy, Debug)]
pub struct RayPacket {
    /// Origins.
    pub org: Vec3x8,
    /// Directions, not necessarily of unit length.
    pub dir: Vec3x8,
    /// Hits count only below this distance (in units of `dir`).
    pub tmax: F32x8,
}

/// What eight rays hit.
#[derive(Clone, Copy, Debug)]
pub struct HitPacket {
    /// Distance in units of the ray's direction; `tmax` where nothing was hit.
    pub t: F32x8,
    /// Barycentric weight of a triangle's second corner, else 0.
    pub u: F32x8,
    /// Barycentric weight of a triangle's third corner, else 0.
    pub v: F32x8,
    /// Primitive in file order, or [`NO_PRIM`].
    pub prim_id: U32x8,
}

impl HitPacket {
    /// Nothing hit.
    pub fn miss() -> HitPacket {
        HitPacket {
            t: F32x8::splat(f32::INFINITY),
            u: F32x8::ZERO,
            v: F32x8::ZERO,
            prim_id: U32x8::splat(NO_PRIM),
        }
    }
}

/// Number of packets that hold `rays` rays.
pub fn packets_for(rays: usize) -> usize {
    rays.div_ceil(LANES)
}
