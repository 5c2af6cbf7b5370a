//! Cost of tracing each pixel's camera ray with the packet engine, for heat maps.

use super::ray_cost::{RayCost, count_cost};
use super::stats::RenderStats;
use super::wavefront::push_camera_rays;
use super::workers::TileRenderer;
use bumpalo::Bump;
use phalanx_scene::RayCounts;
use phalanx_scene::camera::Camera;
use phalanx_scene::film::Tile;
use phalanx_scene::film::TileBuffer;
use phalanx_scene::sampling::Sampling;
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::LaneMask;
use phalanx_trace::stopwatch::Stopwatch;
use phalanx_trace::{Kernel, PacketTracer, Traversal};

/// Timed repeats of each pair of packets. The minimum counts, as interruptions of a thread only add
/// to the time.
const REPEATS: usize = 3;

/// Renders costs instead of radiance, the same in all three planes.
pub struct HeatmapRenderer<'a> {
    camera: &'a Camera,
    cost: RayCost,
    counting: PacketTracer<'a>,
    timed: Traversal<'a>,
    arena: Bump,
    primary: u64,
}

impl<'a> HeatmapRenderer<'a> {
    /// A renderer for one worker. Counts do not depend on the kernel, times do.
    pub fn new(
        bvh: &'a Bvh,
        camera: &'a Camera,
        cost: RayCost,
        kernel: Kernel,
    ) -> HeatmapRenderer<'a> {
        HeatmapRenderer {
            camera,
            cost,
            counting: PacketTracer::new(bvh),
            timed: Traversal::new(bvh, kernel),
            arena: Bump::new(),
            primary: 0,
        }
    }
}

impl TileRenderer for HeatmapRenderer<'_> {
    fn render_tile(&mut self, tile: Tile, pixels: &mut TileBuffer) {
        self.arena.reset();
        let mut rays = RayQueue::with_capacity(&self.arena, tile.pixels() as usize);
        push_camera_rays(&mut rays, self.camera, tile, &Sampling::CENTER, 0);
        self.primary += rays.len() as u64;
        // Two packets at a time, as the widest kernel takes them.
        for first in (0..rays.packets()).step_by(2) {
            let pair = first..rays.packets().min(first + 2);
            let time = match self.cost {
                RayCost::Time => measure_time(&mut self.timed, &rays, pair.clone()),
                _ => 0.0,
            };
            for packet in pair {
                for lane in rays.active(packet).lanes() {
                    let cost = match self.cost {
                        RayCost::Time => time,
                        cost => count_cost(&mut self.counting, &rays, packet, lane, cost),
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
            packets: self.timed.stats().packets,
            unseen_backs: 0,
        }
    }
}

/// Nanoseconds per ray.
fn measure_time(tracer: &mut Traversal, rays: &RayQueue, packets: std::ops::Range<usize>) -> f32 {
    let mut hits = [HitPacket::miss(); 2];
    let lanes = packets.clone().map(|p| rays.active(p).bits().count_ones());
    let lanes: u32 = lanes.sum();
    let times = (0..REPEATS).map(|_| {
        let start = Stopwatch::start();
        tracer.closest(rays, packets.clone(), &mut hits[..packets.len()]);
        std::hint::black_box(&hits);
        start.elapsed().as_nanos()
    });
    times.min().unwrap_or(0) as f32 / lanes.max(1) as f32
}
