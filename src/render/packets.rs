//! The packet engine's painter: a tile's camera rays, its waves, its pixels.

use super::film::Pixels;
use super::stats::RenderStats;
use super::tiles::Tile;
use super::wave::{Colors, Engine, RayView, wave};
use super::workers::Painter;
use crate::bvh::Bvh;
use crate::camera::Camera;
use crate::lanes::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};
use crate::packet::{HitPacket, NO_PRIM, RayQueue, packets_for};
use crate::scene::Scene;
use crate::trace::{Kernel, Traversal};
use bumpalo::Bump;

/// Paints tiles with packets of eight rays.
pub struct PacketPainter<'a> {
    camera: &'a Camera,
    engine: Engine<'a>,
    /// The tile's own arena, then one for every depth of wave.
    tile_arena: Bump,
    arenas: Vec<Bump>,
}

impl<'a> PacketPainter<'a> {
    /// A painter for one worker. `max_depth` counts bounces after the primary ray.
    pub fn new(
        scene: &'a Scene,
        bvh: &'a Bvh,
        camera: &'a Camera,
        max_depth: u32,
        kernel: Kernel,
    ) -> Self {
        PacketPainter {
            camera,
            engine: Engine {
                scene,
                traversal: Traversal::new(bvh, kernel),
                stats: RenderStats::default(),
            },
            tile_arena: Bump::new(),
            arenas: (0..=max_depth).map(|_| Bump::new()).collect(),
        }
    }
}

impl Painter for PacketPainter<'_> {
    fn paint(&mut self, tile: Tile, pixels: &mut Pixels) {
        self.tile_arena.reset();
        let arena = &self.tile_arena;
        let mut rays = RayQueue::with_capacity(arena, tile.pixels() as usize);
        push_camera_rays(&mut rays, self.camera, tile);
        self.engine.stats.rays.primary += rays.len() as u64;
        let packets = packets_for(rays.len());
        let colors = arena.alloc_slice_fill_copy(packets, Colors::BLACK);
        let mut hits = pixels
            .record_hits()
            .then(|| &mut *arena.alloc_slice_fill_copy(packets, HitPacket::miss()));
        let view = RayView {
            queue: &rays,
            packets: 0..packets,
        };
        wave(
            &mut self.engine,
            &mut self.arenas,
            view,
            colors,
            hits.as_deref_mut(),
        );
        develop(&rays, colors, hits.as_deref(), pixels);
    }

    fn stats(&self) -> RenderStats {
        RenderStats {
            packets: self.engine.traversal.work().packets,
            ..self.engine.stats
        }
    }
}

/// Appends the camera rays of a tile through the pixel centres, in 8×8 blocks of 4×2 pixels a packet. Their parent is the
/// pixel's place in the tile, row and column in sixteen bits each.
///
/// # Panics
/// If the queue has no room for them.
pub fn push_camera_rays(rays: &mut RayQueue, camera: &Camera, tile: Tile) {
    let eye = Vec3x8::splat(camera.eye.x, camera.eye.y, camera.eye.z);
    for block_y in (0..tile.height).step_by(8) {
        for block_x in (0..tile.width).step_by(8) {
            for packet in 0..8 {
                let (x, y) = (block_x + packet % 2 * 4, block_y + packet / 2 * 2);
                let inside = inside(tile, x, y);
                let dir = camera.directions(
                    F32x8::splat((tile.y + y) as f32) + ROW_CENTRES,
                    F32x8::splat((tile.x + x) as f32) + COLUMN_CENTRES,
                );
                rays.push(inside, eye, dir, Vec3x8::ZERO, &block_of(x, y));
            }
        }
    }
}

/// The places in the tile of a packet's 4×2 pixels, the first of which is at (`x`, `y`).
fn block_of(x: u32, y: u32) -> [u32; LANES] {
    std::array::from_fn(|k| (y + k as u32 / 4) << 16 | (x + k as u32 % 4))
}

/// Column and row of a place.
fn place(place: u32) -> (u32, u32) {
    (place & 0xffff, place >> 16)
}

/// Centres of a packet's 4×2 pixels, relative to its first pixel.
const ROW_CENTRES: F32x8 = F32x8::new([0.5, 0.5, 0.5, 0.5, 1.5, 1.5, 1.5, 1.5]);
const COLUMN_CENTRES: F32x8 = F32x8::new([0.5, 1.5, 2.5, 3.5, 0.5, 1.5, 2.5, 3.5]);

/// Which of the 4×2 pixels from (`x`, `y`) on lie in the tile.
fn inside(tile: Tile, x: u32, y: u32) -> Mask8 {
    let row = (1u32 << tile.width.saturating_sub(x).min(4)) - 1;
    Mask8::from_bits(match tile.height.saturating_sub(y) {
        0 => 0,
        1 => row,
        _ => row | row << 4,
    })
}

/// Gives the tile's pixels their radiance, and their hits where they are kept.
fn develop(rays: &RayQueue, colors: &[Colors], hits: Option<&[HitPacket]>, pixels: &mut Pixels) {
    for (packet, color) in colors.iter().enumerate() {
        let (active, places) = (rays.active(packet), rays.purpose(packet).1);
        let (x, y) = place(places[0]);
        if active.bits() == 0xff && *places == block_of(x, y) {
            let row = |k: usize| color.plane_halves().map(|plane| plane[k]);
            pixels.set_run(x, y, row(0));
            pixels.set_run(x, y + 1, row(1));
        } else {
            for lane in active.lanes() {
                let (x, y) = place(places[lane]);
                pixels.set(x, y, color.lane(lane));
            }
        }
        if let Some(hits) = hits {
            keep(&hits[packet], active, places, pixels);
        }
    }
}

/// Keeps the hits of a packet.
fn keep(hit: &HitPacket, active: Mask8, places: &[u32; LANES], pixels: &mut Pixels) {
    for lane in active.lanes() {
        let (x, y) = place(places[lane]);
        let prim_id = hit.prim_id.lane(lane);
        let t = match prim_id {
            NO_PRIM => 0.0,
            _ => hit.t.lane(lane),
        };
        pixels.set_hit(x, y, [t, hit.u.lane(lane), hit.v.lane(lane)], prim_id);
    }
}
