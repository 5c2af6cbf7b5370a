//! Cost of tracing single rays, counted.

use phalanx_trace::PacketTracer;
use phalanx_trace::packet::RayQueue;
use phalanx_trace::simd::{LaneMask, Mask8};

/// The kind of cost of a camera ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayCost {
    /// Nodes that the ray alone visits.
    Nodes,
    /// Primitives that the ray alone is tested against.
    Prims,
    /// Nanoseconds of its packets, by the kernel of a render, divided by their rays.
    Time,
}

impl RayCost {
    /// All of them with their names.
    pub const ALL: [(&'static str, RayCost); 3] = [
        ("nodes", RayCost::Nodes),
        ("prims", RayCost::Prims),
        ("time", RayCost::Time),
    ];

    /// Title of a map of these costs.
    pub fn title(self) -> &'static str {
        match self {
            RayCost::Nodes => "nodes visited by a camera ray",
            RayCost::Prims => "primitives tested by a camera ray",
            RayCost::Time => "nanoseconds a camera ray",
        }
    }
}

/// Cost of one lane, traced in a packet of its own.
pub(super) fn count_cost(
    tracer: &mut PacketTracer,
    rays: &RayQueue,
    packet: usize,
    lane: usize,
    cost: RayCost,
) -> f32 {
    let (packet, _) = rays.packet(packet, f32::INFINITY);
    tracer.take_stats();
    tracer.closest(&packet, Mask8::from_bits(1 << lane));
    let work = tracer.take_stats();
    let lanes = phalanx_trace::simd::LANES as u64;
    match cost {
        RayCost::Prims => (work.prim_tests / lanes) as f32,
        RayCost::Nodes | RayCost::Time => work.node_visits as f32,
    }
}
