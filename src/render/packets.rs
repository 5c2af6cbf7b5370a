//! The packet engine's painter: a tile's camera rays, its waves, its pixels.

use super::film::SharedFilm;
use super::stats::RenderStats;
use super::tiles::Tile;
use super::wave::{Colors, Engine, RayView, wave};
use super::workers::Painter;
use crate::bvh::Bvh;
use crate::camera::Camera;
use crate::lanes::{F32x8, LaneMask, Lanes, Mask8, Vec3x8};
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
    fn paint(&mut self, tile: Tile, film: &SharedFilm) {
        self.tile_arena.reset();
        let arena = &self.tile_arena;
        let mut rays = RayQueue::with_capacity(arena, tile.pixels() as usize);
        push_camera_rays(&mut rays, self.camera, tile);
        self.engine.stats.rays.primary += rays.len() as u64;
        let packets = packets_for(rays.len());
        let colors = arena.alloc_slice_fill_copy(packets, Colors::BLACK);
        let mut hits = film
            .records_hits()
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
        develop(&rays, tile, colors, hits.as_deref(), film);
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
                let pixel = std::array::from_fn(|k| (y + k as u32 / 4) << 16 | (x + k as u32 % 4));
                rays.push(inside, eye, dir, Vec3x8::ZERO, &pixel);
            }
        }
    }
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

/// Puts the tile's pixels onto the film.
fn develop(
    rays: &RayQueue,
    tile: Tile,
    colors: &[Colors],
    hits: Option<&[HitPacket]>,
    film: &SharedFilm,
) {
    for (packet, color) in colors.iter().enumerate() {
        let pixels = rays.purpose(packet).1;
        for lane in rays.active(packet).lanes() {
            let (x, y) = (
                tile.x + (pixels[lane] & 0xffff),
                tile.y + (pixels[lane] >> 16),
            );
            film.set(x, y, color.lane(lane));
            let Some(hits) = hits else { continue };
            let hit = &hits[packet];
            let prim_id = hit.prim_id.lane(lane);
            let t = if prim_id == NO_PRIM {
                0.0
            } else {
                hit.t.lane(lane)
            };
            film.set_hit(x, y, [t, hit.u.lane(lane), hit.v.lane(lane)], prim_id);
        }
    }
}
