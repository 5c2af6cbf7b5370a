//! What each pixel's camera ray costs the packet engine to trace, for pictures of it.

use super::packets::push_camera_rays;
use super::stats::{RayCounts, RenderStats};
use super::workers::Painter;
use bumpalo::Bump;
use phalanx_scene::camera::Camera;
use phalanx_scene::film::Pixels;
use phalanx_scene::film::Tile;
use phalanx_scene::sampling::Sampling;
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{LaneMask, Mask8};
use phalanx_trace::{Kernel, PacketTracer, Traversal};
use std::time::Instant;

/// What is counted of a camera ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Nodes that the ray alone visits.
    Nodes,
    /// Primitives that the ray alone is tested against.
    Prims,
    /// Nanoseconds of its packets, by the kernel of a render, divided by their rays.
    Time,
}

/// Times each pair of packets so often, and takes the least: what interrupts a thread only ever adds.
const REPEATS: usize = 3;

/// Paints costs in place of radiance, the same in all three planes.
pub struct CostPainter<'a> {
    camera: &'a Camera,
    cost: Cost,
    alone: PacketTracer<'a>,
    together: Traversal<'a>,
    arena: Bump,
    primary: u64,
}

impl<'a> CostPainter<'a> {
    /// A painter for one worker. Counts do not depend on the kernel, times do.
    pub fn new(bvh: &'a Bvh, camera: &'a Camera, cost: Cost, kernel: Kernel) -> CostPainter<'a> {
        CostPainter {
            camera,
            cost,
            alone: PacketTracer::new(bvh),
            together: Traversal::new(bvh, kernel),
            arena: Bump::new(),
            primary: 0,
        }
    }
}

impl Painter for CostPainter<'_> {
    fn paint(&mut self, tile: Tile, pixels: &mut Pixels) {
        self.arena.reset();
        let mut rays = RayQueue::with_capacity(&self.arena, tile.pixels() as usize);
        push_camera_rays(&mut rays, self.camera, tile, &Sampling::CENTER, 0);
        self.primary += rays.len() as u64;
        // Two at a time, as the widest kernel takes them.
        for first in (0..rays.packets()).step_by(2) {
            let pair = first..rays.packets().min(first + 2);
            let time = match self.cost {
                Cost::Time => time(&mut self.together, &rays, pair.clone()),
                _ => 0.0,
            };
            for packet in pair {
                for lane in rays.active(packet).lanes() {
                    let cost = match self.cost {
                        Cost::Time => time,
                        cost => count(&mut self.alone, &rays, packet, lane, cost),
                    };
                    let place = rays.payload(packet).1[lane];
                    pixels.set(place & 0xffff, place >> 16, [cost; 3]);
                }
            }
        }
    }

    fn stats(&self) -> RenderStats {
        RenderStats {
            rays: RayCounts {
                primary: self.primary,
                ..RayCounts::default()
            },
            packets: self.together.stats().packets,
        }
    }
}

/// Nanoseconds a ray.
fn time(tracer: &mut Traversal, rays: &RayQueue, packets: std::ops::Range<usize>) -> f32 {
    let mut hits = [HitPacket::miss(); 2];
    let lanes = packets.clone().map(|p| rays.active(p).bits().count_ones());
    let lanes: u32 = lanes.sum();
    let times = (0..REPEATS).map(|_| {
        let start = Instant::now();
        tracer.closest(rays, packets.clone(), &mut hits[..packets.len()]);
        std::hint::black_box(&hits);
        start.elapsed().as_nanos()
    });
    times.min().unwrap_or(0) as f32 / lanes.max(1) as f32
}

/// What one lane costs in a packet of its own.
pub(super) fn count(
    tracer: &mut PacketTracer,
    rays: &RayQueue,
    packet: usize,
    lane: usize,
    cost: Cost,
) -> f32 {
    let (packet, _) = rays.packet(packet, f32::INFINITY);
    tracer.take_work();
    tracer.closest(&packet, Mask8::from_bits(1 << lane));
    let work = tracer.take_work();
    let lanes = phalanx_trace::simd::LANES as u64;
    match cost {
        Cost::Prims => (work.prim_tests / lanes) as f32,
        _ => work.node_visits as f32,
    }
}
