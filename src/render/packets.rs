//! The packet engine's painter: a tile's camera rays, its waves, its pixels.

use super::film::Pixels;
use super::occlusion::occlusion;
use super::stats::RenderStats;
use super::tiles::Tile;
use super::wave::{Colors, Engine, RayView, wave};
use super::workers::Painter;
use crate::bvh::Bvh;
use crate::camera::Camera;
use crate::lanes::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};
use crate::packet::{HitPacket, NO_PRIM, RayQueue, packets_for};
use crate::sampling::{Gathered, Places, Purpose, Sampling, disc, points, seeds};
use crate::scene::Scene;
use crate::trace::{Kernel, Traversal};
use bumpalo::Bump;

/// Paints tiles with packets of eight rays.
pub struct PacketPainter<'a> {
    camera: &'a Camera,
    sampling: Sampling,
    /// Of each pixel of a tile, where it has several samples.
    gathered: Vec<Gathered>,
    engine: Engine<'a>,
    /// Whether rays have seeds.
    seeded: bool,
    /// How far the sky is, where nothing but that is to be seen.
    sky: Option<f32>,
    /// The tile's own arena, then one for every depth of wave.
    tile_arena: Bump,
    arenas: Vec<Bump>,
}

impl<'a> PacketPainter<'a> {
    /// A painter for one worker, with one ray through the centre of each pixel. `max_depth` counts bounces after the primary ray.
    pub fn new(
        scene: &'a Scene,
        bvh: &'a Bvh,
        camera: &'a Camera,
        max_depth: u32,
        kernel: Kernel,
    ) -> Self {
        PacketPainter {
            camera,
            sampling: Sampling::CENTER,
            gathered: Vec::new(),
            engine: Engine {
                scene,
                traversal: Traversal::new(bvh, kernel),
                stats: RenderStats::default(),
                sample: 0,
            },
            seeded: seeded(scene),
            sky: None,
            tile_arena: Bump::new(),
            arenas: (0..=max_depth).map(|_| Bump::new()).collect(),
        }
    }

    /// With other camera rays.
    pub fn with_sampling(self, sampling: Sampling) -> Self {
        PacketPainter { sampling, ..self }
    }

    /// With ambient occlusion in place of shading: a hit is white if one ray from it meets nothing within `reach`, and else black.
    pub fn with_occlusion(self, reach: f32) -> Self {
        PacketPainter {
            sky: Some(reach),
            seeded: true,
            ..self
        }
    }

    /// Traces the `sample`-th camera ray of each pixel of a tile, and tells `take` rays, radiance and hits.
    fn sample(
        &mut self,
        tile: Tile,
        sample: u32,
        keep_hits: bool,
        take: impl FnOnce(&mut Vec<Gathered>, &RayQueue, &[Colors], Option<&[HitPacket]>),
    ) {
        self.tile_arena.reset();
        let arena = &self.tile_arena;
        let mut rays = RayQueue::seeded(arena, tile.pixels() as usize, self.seeded);
        push_camera_rays(&mut rays, self.camera, tile, &self.sampling, sample);
        self.engine.sample = sample;
        self.engine.stats.rays.primary += rays.len() as u64;
        let packets = packets_for(rays.len());
        let colors = arena.alloc_slice_fill_copy(packets, Colors::BLACK);
        let mut hits =
            keep_hits.then(|| &mut *arena.alloc_slice_fill_copy(packets, HitPacket::miss()));
        let view = RayView {
            queue: &rays,
            packets: 0..packets,
        };
        let (engine, keep) = (&mut self.engine, hits.as_deref_mut());
        match self.sky {
            Some(reach) => occlusion(engine, &mut self.arenas[0], view, reach, colors, keep),
            None => wave(engine, &mut self.arenas, view, colors, keep),
        }
        take(&mut self.gathered, &rays, colors, hits.as_deref());
    }
}

impl Painter for PacketPainter<'_> {
    fn paint(&mut self, tile: Tile, pixels: &mut Pixels) {
        let keep_hits = pixels.record_hits();
        if self.sampling.spp == 1 {
            return self.sample(tile, 0, keep_hits, |_, rays, colors, hits| {
                develop(rays, colors, pixels);
                keep(rays, hits, pixels);
            });
        }
        self.gathered.clear();
        let count = tile.pixels() as usize;
        self.gathered.resize(count, Gathered::default());
        for sample in 0..self.sampling.spp {
            let first = keep_hits && sample == 0;
            self.sample(tile, sample, first, |gathered, rays, colors, hits| {
                gather(rays, colors, tile, gathered);
                keep(rays, hits, pixels);
            });
        }
        for (at, gathered) in (0..).zip(&self.gathered) {
            pixels.set(at % tile.width, at / tile.width, gathered.mean());
        }
    }

    fn stats(&self) -> RenderStats {
        RenderStats {
            packets: self.engine.traversal.work().packets,
            ..self.engine.stats
        }
    }
}

/// Whether anything in a scene is left to chance.
fn seeded(scene: &Scene) -> bool {
    let mut lights = 0..scene.lights.len();
    lights.any(|light| scene.lights.has_area(light))
        || scene.materials.gloss.iter().any(|&gloss| gloss > 0.0)
}

/// Appends the `sample`-th camera ray of each pixel of a tile, in 8×8 blocks of 4×2 pixels a packet. Their parent is the pixel's
/// place in the tile, row and column in sixteen bits each, and the first number of their weight what they count. If the queue has
/// seeds, theirs are the pixels'.
///
/// # Panics
/// If the queue has no room for them.
pub fn push_camera_rays(
    rays: &mut RayQueue,
    camera: &Camera,
    tile: Tile,
    sampling: &Sampling,
    sample: u32,
) {
    let eye = Vec3x8::splat(camera.eye.x, camera.eye.y, camera.eye.z);
    for block_y in (0..tile.height).step_by(8) {
        for block_x in (0..tile.width).step_by(8) {
            for packet in 0..8 {
                let (x, y) = (block_x + packet % 2 * 4, block_y + packet / 2 * 2);
                let inside = inside(tile, x, y);
                let columns = std::array::from_fn(|k| tile.x + x + k as u32 % 4);
                let rows = std::array::from_fn(|k| tile.y + y + k as u32 / 4);
                let Places {
                    row,
                    column,
                    weight,
                } = sampling.places::<LANES>(columns, rows, sample);
                let (row, column) = (F32x8::new(row), F32x8::new(column));
                let (org, dir) = if camera.has_lens() {
                    let seeds = seeds(columns, rows);
                    let at = disc(points(seeds, sample, Purpose::Lens)).map(F32x8::new);
                    camera.through_lens_wide(row, column, at)
                } else {
                    (eye, camera.directions(row, column))
                };
                if rays.has_seeds() {
                    rays.push_seeds(inside, &seeds(columns, rows));
                }
                let counts = Vec3x8::new(F32x8::new(weight), F32x8::ZERO, F32x8::ZERO);
                rays.push(inside, org, dir, counts, &block_of(x, y));
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

/// Which of the 4×2 pixels from (`x`, `y`) on lie in the tile.
fn inside(tile: Tile, x: u32, y: u32) -> Mask8 {
    let row = (1u32 << tile.width.saturating_sub(x).min(4)) - 1;
    Mask8::from_bits(match tile.height.saturating_sub(y) {
        0 => 0,
        1 => row,
        _ => row | row << 4,
    })
}

/// Adds the tile's samples to what its pixels have gathered.
fn gather(rays: &RayQueue, colors: &[Colors], tile: Tile, gathered: &mut [Gathered]) {
    for (packet, color) in colors.iter().enumerate() {
        let (counts, places) = rays.purpose(packet);
        for lane in rays.active(packet).lanes() {
            let (x, y) = place(places[lane]);
            gathered[(y * tile.width + x) as usize].add(color.lane(lane), counts[0][lane]);
        }
    }
}

/// Gives the tile's pixels their radiance.
fn develop(rays: &RayQueue, colors: &[Colors], pixels: &mut Pixels) {
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
    }
}

/// Keeps hits, if there are any.
fn keep(rays: &RayQueue, hits: Option<&[HitPacket]>, pixels: &mut Pixels) {
    for (packet, hit) in hits.unwrap_or_default().iter().enumerate() {
        let places = rays.purpose(packet).1;
        for lane in rays.active(packet).lanes() {
            let (x, y) = place(places[lane]);
            let prim_id = hit.prim_id.lane(lane);
            let t = match prim_id {
                NO_PRIM => 0.0,
                _ => hit.t.lane(lane),
            };
            pixels.set_hit(x, y, [t, hit.u.lane(lane), hit.v.lane(lane)], prim_id);
        }
    }
}
