//! The interface that tracers implement to be measured: peers, our own kernels and the oracle.
//!
//! A [`BenchEngine`] is one way to trace one set of rays: a tree, a kernel or mode, and the rays in
//! its own layout, all prepared before timing starts.

use phalanx_trace::packet::{HitPacket, NO_PRIM, RayQueue};
use phalanx_trace::simd::{F32x8, LANES, U32x8};
use std::ops::Range;

/// The reason why a peer does not trace a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{peer} does not trace this scene: {reason}")]
pub struct Unsupported {
    /// The peer's name for readers.
    pub peer: &'static str,
    /// Description of the obstacle.
    pub reason: String,
}

/// A set of rays for one query.
#[derive(Clone, Copy)]
pub struct RaySetRef<'a> {
    /// The rays; every packet but the last is full.
    pub queue: &'a RayQueue<'a>,
    /// Hits count only below this distance.
    pub tmax: f32,
}

/// One way to trace one set of rays, shared by the threads that trace them.
pub trait BenchEngine: Sync {
    /// The state that one thread needs.
    fn thread(&self) -> Box<dyn BenchEngineThread + '_>;
}

/// Name of the mode that traces one ray a call, ours as Embree's.
pub const ONE: &str = "one";

/// The modes of a tracer on a set of rays, by name.
pub type NamedEngines = Vec<(String, Box<dyn BenchEngine>)>;

/// A scene in another tracer's own form: the function from a set of rays to the peer's modes by
/// name, each with the rays laid out as it wants them.
pub type PeerScene = Box<dyn Fn(RaySetRef) -> NamedEngines>;

/// One thread's share of an engine. Packets are the set's, eight rays each; a range starts at an
/// even packet.
pub trait BenchEngineThread {
    /// The closest hits of some packets, one [`HitPacket`] each: `t` (a miss is at or above the
    /// limit) and `prim_id` as in the scene; `u` and `v` only where they cost nothing. Lanes beyond
    /// the last ray are undefined.
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]);
    /// Occluded lanes (as bits) of each of some packets. Lanes beyond the last ray are undefined.
    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]);
}

/// Closest hits of some packets of a set of `rays` rays, ray by ray: t, u and v, and the number of
/// the primitive.
#[inline(always)]
pub(crate) fn closest_each(
    packets: Range<usize>,
    rays: usize,
    hits: &mut [HitPacket],
    mut closest: impl FnMut(usize) -> Option<([f32; 3], u32)>,
) {
    for (packet, out) in packets.zip(hits) {
        let (mut t, mut u, mut v) = ([f32::INFINITY; LANES], [0.0; LANES], [0.0; LANES]);
        let mut prim_id = [NO_PRIM; LANES];
        let first = packet * LANES;
        for lane in 0..LANES.min(rays - first) {
            if let Some((hit, id)) = closest(first + lane) {
                ([t[lane], u[lane], v[lane]], prim_id[lane]) = (hit, id);
            }
        }
        *out = HitPacket {
            t: F32x8::new(t),
            u: F32x8::new(u),
            v: F32x8::new(v),
            prim_id: U32x8::new(prim_id),
        };
    }
}

/// Occluded rays of some packets of a set of `rays` rays, ray by ray.
#[inline(always)]
pub(crate) fn occluded_each(
    packets: Range<usize>,
    rays: usize,
    blocked: &mut [u8],
    mut occluded: impl FnMut(usize) -> bool,
) {
    for (packet, out) in packets.zip(blocked) {
        let first = packet * LANES;
        let lanes = 0..LANES.min(rays - first);
        *out = lanes.fold(0, |bits, lane| {
            bits | u8::from(occluded(first + lane)) << lane
        });
    }
}
