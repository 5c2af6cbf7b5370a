//! The packet engine's painter: a tile's camera rays, its waves, its pixels.

use super::cells::Room;
use super::cost::{Cost, count};
use super::kept::Kept;
use super::levels::{Levels, waves};
use super::occlusion::occlusion;
use super::sights::Sights;
use super::stats::RenderStats;
use super::wave::{Colors, Engine, RayView};
use super::workers::Painter;
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_scene::camera::Camera;
use phalanx_scene::film::Pixels;
use phalanx_scene::film::Tile;
use phalanx_scene::film::{Aov, Aovs, Light};
use phalanx_scene::sampling::{
    BlockPixels, Gathered, Places, Purpose, Sampling, disc, points, seeds,
};
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::camera::{directions, through_lens};
use phalanx_trace::packet::{NO_PRIM, QueueColumns, RayQueue, packets_for};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};
use phalanx_trace::{Kernel, PacketTracer, Traversal};

/// Paints tiles with packets of eight rays.
pub struct PacketPainter<'a> {
    pub(super) camera: &'a Camera,
    pub(super) sampling: Sampling,
    aovs: Aovs,
    bvh: &'a Bvh,
    /// What counts nodes, if they are to be told.
    alone: Counter<'a>,
    /// Of each pixel of a tile, where it has several samples.
    pub(super) sums: Sums,
    /// Of each block of a tile, the pixels that get more samples.
    pub(super) open: Vec<BlockPixels>,
    /// Of samples that halve cells.
    pub(super) room: Room,
    engine: Engine<'a>,
    /// Whether rays have seeds.
    pub(super) seeded: bool,
    /// How far the sky is, where nothing but that is to be seen.
    sky: Option<f32>,
    /// Memory that lives as long as camera rays that are traced together, and as long as one wave of them.
    tile_arena: Bump,
    scratch: Bump,
    levels: Levels,
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
            aovs: Aovs::default(),
            bvh,
            alone: None,
            sums: Sums::default(),
            open: Vec::new(),
            room: Room::default(),
            engine: Engine {
                scene,
                traversal: Traversal::new(bvh, kernel),
                stats: RenderStats::default(),
                sample: 0,
                min_weight: 0.0,
                columns: QueueColumns::default(),
            },
            seeded: scene.has_chance(),
            sky: None,
            tile_arena: Bump::new(),
            scratch: Bump::new(),
            levels: Levels::new(scene, max_depth, 0.0),
        }
        .with_min_weight(0.0)
    }

    /// With bounces only where the product of the weights along the way is at least this in some component.
    pub fn with_min_weight(self, min_weight: f32) -> Self {
        let scene = self.engine.scene;
        let levels = Levels::new(scene, self.levels.max_depth(), min_weight);
        PacketPainter {
            engine: Engine {
                min_weight,
                columns: levels.columns(),
                ..self.engine
            },
            levels,
            ..self
        }
    }

    /// With other camera rays.
    pub fn with_sampling(self, sampling: Sampling) -> Self {
        PacketPainter { sampling, ..self }
    }

    /// With what else is to be told of each pixel.
    pub fn with_layers(self, aovs: Aovs) -> Self {
        let alone = aovs.has(Aov::Cost).then(|| PacketTracer::new(self.bvh));
        PacketPainter {
            aovs,
            alone,
            ..self
        }
    }

    /// With ambient occlusion in place of shading: a hit is white if one ray from it meets nothing within `reach`, and else black.
    pub fn with_occlusion(self, reach: f32) -> Self {
        PacketPainter {
            sky: Some(reach),
            seeded: true,
            ..self
        }
    }

    /// Traces camera rays, room for so many of which is in the queue that `push` fills, and tells `take` what came of them. Where rays
    /// have seeds, all are the `sample`-th of their pixels; with the first of them come hits, if they are wanted.
    pub(super) fn trace(
        &mut self,
        room: usize,
        sample: u32,
        keep_hits: bool,
        mut sights: Option<Sights>,
        push: impl FnOnce(&mut RayQueue, &Camera, &Sampling),
        take: impl FnOnce(&mut Sums, &Traced, &mut Counter),
    ) {
        self.tile_arena.reset();
        let arena = &self.tile_arena;
        let mut rays = RayQueue::seeded(arena, room, self.seeded);
        push(&mut rays, self.camera, &self.sampling);
        self.engine.sample = sample;
        self.engine.stats.rays.primary += rays.len() as u64;
        let packets = packets_for(rays.len());
        let colors = arena.alloc_slice_fill_copy(packets, Colors::BLACK);
        let surface = sample == 0 && (keep_hits || self.aovs.of_surface());
        let mut kept =
            (surface || self.aovs.of_light()).then(|| Kept::of(arena, packets, self.aovs));
        let most = self.levels.camera_packets();
        for first in (0..packets).step_by(most) {
            let part = first..packets.min(first + most);
            let colors = &mut colors[part.clone()];
            let mut kept = kept.as_mut().map(|kept| kept.part(part.clone()));
            let view = RayView {
                queue: &rays,
                packets: part,
            };
            let (engine, kept) = (&mut self.engine, kept.as_mut());
            match self.sky {
                Some(reach) => occlusion(engine, &mut self.scratch, view, reach, colors, kept),
                None => {
                    let room = (&mut self.scratch, &mut self.levels);
                    waves(engine, room, view, colors, kept, sights.as_mut());
                }
            }
        }
        let traced = Traced {
            rays: &rays,
            colors,
            first: surface,
            kept: kept.as_ref(),
        };
        take(&mut self.sums, &traced, &mut self.alone);
    }

    /// Traces the `sample`-th camera ray of each pixel of a tile.
    fn sample(
        &mut self,
        tile: Tile,
        sample: u32,
        keep_hits: bool,
        take: impl FnOnce(&mut Sums, &Traced, &mut Counter),
    ) {
        let push = |rays: &mut RayQueue, camera: &Camera, sampling: &Sampling| {
            push_camera_rays(rays, camera, tile, sampling, sample);
        };
        self.trace(tile.pixels() as usize, sample, keep_hits, None, push, take);
    }
}

impl Painter for PacketPainter<'_> {
    fn paint(&mut self, tile: Tile, pixels: &mut Pixels) {
        let keep_hits = pixels.record_hits();
        if let Some(adaptive) = self.sampling.adaptively() {
            return match self.seeded || self.camera.has_lens() {
                true => self.paint_adaptively(adaptive, tile, pixels),
                false => self.paint_by_cells(adaptive, tile, pixels),
            };
        }
        if self.sampling.spp == 1 {
            return self.sample(tile, 0, keep_hits, |_, traced, counter| {
                develop(traced, pixels);
                traced.keep(pixels, counter, Some);
            });
        }
        self.sums.fit(tile.pixels() as usize, self.aovs);
        for sample in 0..self.sampling.spp {
            self.sample(tile, sample, keep_hits, |sums, traced, counter| {
                sums.gather(traced, tile.width);
                traced.keep(pixels, counter, Some);
            });
        }
        for at in 0..tile.pixels() as u32 {
            let (x, y) = (at % tile.width, at / tile.width);
            self.sums.finish(at as usize, pixels, (x, y));
        }
    }

    fn stats(&self) -> RenderStats {
        RenderStats {
            packets: self.engine.traversal.stats().packets,
            ..self.engine.stats
        }
    }
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
    for block_y in (0..tile.height).step_by(8) {
        for block_x in (0..tile.width).step_by(8) {
            let corner = (block_x, block_y);
            push_block(rays, camera, tile, corner, !0, sampling, sample);
        }
    }
}

/// Those of the `open` pixels of one 8×8 block, whose upper left corner is there in the tile.
pub(super) fn push_block(
    rays: &mut RayQueue,
    camera: &Camera,
    tile: Tile,
    (block_x, block_y): (u32, u32),
    open: BlockPixels,
    sampling: &Sampling,
    sample: u32,
) {
    let eye = Vec3x8::splat(camera.eye.x, camera.eye.y, camera.eye.z);
    for packet in 0..8 {
        let (right, down) = (packet % 2 * 4, packet / 2 * 2);
        let (x, y) = (block_x + right, block_y + down);
        // Two rows of four.
        let asked = open >> (8 * down + right);
        let asked = Mask8::from_bits((asked & 0xf | asked >> 4 & 0xf0) as u32);
        let inside = inside(tile, x, y) & asked;
        let columns = std::array::from_fn(|k| tile.x + x + k as u32 % 4);
        let rows = std::array::from_fn(|k| tile.y + y + k as u32 / 4);
        let Places {
            row,
            column,
            weight,
        } = sampling.places::<LANES>(columns, rows, sample);
        let (row, column) = (F32x8::new(row), F32x8::new(column));
        let (org, dir) = if camera.has_lens() {
            let at = disc(points(seeds(columns, rows), sample, Purpose::Lens));
            through_lens(camera, row, column, at.map(F32x8::new))
        } else {
            (eye, directions(camera, row, column))
        };
        if rays.has_seeds() {
            rays.push_seeds(inside, &seeds(columns, rows));
        }
        let counts = Vec3x8::new(F32x8::new(weight), F32x8::ZERO, F32x8::ZERO);
        rays.push(inside, org, dir, counts, &block_of(x, y));
    }
}

/// Appends the camera rays of the first `count` of these places, all through one eye. Their parents are `pixels`.
pub(super) fn push_places(
    rays: &mut RayQueue,
    camera: &Camera,
    places: Places<LANES>,
    count: usize,
    pixels: &[u32; LANES],
) {
    let eye = Vec3x8::splat(camera.eye.x, camera.eye.y, camera.eye.z);
    let dir = directions(camera, F32x8::new(places.row), F32x8::new(places.column));
    let counts = Vec3x8::new(F32x8::new(places.weight), F32x8::ZERO, F32x8::ZERO);
    rays.push(Mask8::first(count), eye, dir, counts, pixels);
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

/// What counts nodes, where they are to be told.
type Counter<'a> = Option<PacketTracer<'a>>;

/// What came of some camera rays.
pub(super) struct Traced<'a> {
    rays: &'a RayQueue<'a>,
    colors: &'a [Colors],
    /// Whether they are the first of their pixels, and something about that is wanted.
    first: bool,
    kept: Option<&'a Kept<'a>>,
}

impl Traced<'_> {
    /// The rays with their places, packet by packet.
    fn lanes(&self) -> impl Iterator<Item = (usize, usize, (u32, u32))> {
        (0..self.colors.len()).flat_map(|packet| {
            let places = self.rays.payload(packet).1;
            let lanes = self.rays.active(packet).lanes();
            lanes.map(move |lane| (packet, lane, place(places[lane])))
        })
    }

    /// Of each ray, its radiance, the same by the way it came, if that is wanted, and what it counts.
    pub(super) fn outcomes(&self) -> impl Iterator<Item = ([f32; 3], [[f32; 3]; 3], f32)> {
        let kept = self.kept.filter(|kept| !kept.light[0].is_empty());
        self.lanes().map(move |(packet, lane, _)| {
            let light = |kept: &Kept| kept.light.each_ref().map(|way| way[packet].lane(lane));
            let counts = self.rays.payload(packet).0[0][lane];
            let radiance = self.colors[packet].lane(lane);
            (radiance, kept.map_or([[0.0; 3]; 3], light), counts)
        })
    }

    /// Keeps hits and surfaces of first rays, where `pixel` gives a place in the tile for a place of the rays.
    pub(super) fn keep(
        &self,
        pixels: &mut Pixels,
        counter: &mut Counter,
        pixel: impl Fn((u32, u32)) -> Option<(u32, u32)>,
    ) {
        let Some(kept) = self.kept.filter(|_| self.first) else {
            return;
        };
        for (packet, lane, place) in self.lanes() {
            let Some((x, y)) = pixel(place) else {
                continue;
            };
            let hit = &kept.hits[packet];
            let prim_id = hit.prim_id.lane(lane);
            let t = match prim_id {
                NO_PRIM => 0.0,
                _ => hit.t.lane(lane),
            };
            pixels.set_hit(x, y, [t, hit.u.lane(lane), hit.v.lane(lane)], prim_id);
            if let Some(look) = kept.looks.get(packet * LANES + lane) {
                pixels.set_look(x, y, look);
            }
            if let Some(alone) = counter {
                let nodes = count(alone, self.rays, packet, lane, Cost::Nodes);
                pixels.set_layer(x, y, Aov::Cost, &[nodes]);
            }
        }
    }
}

/// What the pixels of a tile have gathered, row by row.
#[derive(Default)]
pub(super) struct Sums {
    pub(super) radiance: Vec<Gathered>,
    /// By the way it came; empty where nobody wants to know.
    light: [Vec<Gathered>; 3],
}

impl Sums {
    /// Nothing, for so many pixels.
    pub(super) fn fit(&mut self, count: usize, aovs: Aovs) {
        let clear = |all: &mut Vec<Gathered>, count: usize| {
            all.clear();
            all.resize(count, Gathered::default());
        };
        clear(&mut self.radiance, count);
        let count = if aovs.of_light() { count } else { 0 };
        self.light.iter_mut().for_each(|all| clear(all, count));
    }

    /// Adds samples of pixels, rows of which are so wide.
    pub(super) fn gather(&mut self, traced: &Traced, width: u32) {
        for (packet, lane, (x, y)) in traced.lanes() {
            let at = (y * width + x) as usize;
            let counts = traced.rays.payload(packet).0[0][lane];
            self.radiance[at].add(traced.colors[packet].lane(lane), counts);
            if let (Some(kept), false) = (traced.kept, self.light[0].is_empty()) {
                for (gathered, colors) in self.light.iter_mut().zip(&kept.light) {
                    gathered[at].add(colors[packet].lane(lane), counts);
                }
            }
        }
    }

    /// Gives a pixel of the tile what one of these has gathered.
    pub(super) fn finish(&self, at: usize, pixels: &mut Pixels, (x, y): (u32, u32)) {
        pixels.set(x, y, self.radiance[at].mean());
        let aovs = pixels.aovs();
        if aovs.is_empty() {
            return;
        }
        if aovs.of_light() {
            let light = self.light.each_ref().map(|all| all[at].mean());
            pixels.set_light(x, y, &Light(light));
        }
        if aovs.has(Aov::Samples) {
            let count = self.radiance[at].count() as u32;
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(count)]);
        }
    }
}

/// Gives the tile's pixels what their only camera rays gave.
fn develop(traced: &Traced, pixels: &mut Pixels) {
    for (packet, color) in traced.colors.iter().enumerate() {
        let (active, places) = (traced.rays.active(packet), traced.rays.payload(packet).1);
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
    let aovs = pixels.aovs();
    if !aovs.of_light() && !aovs.has(Aov::Samples) {
        return;
    }
    for (packet, lane, (x, y)) in traced.lanes() {
        if let (Some(kept), true) = (traced.kept, aovs.of_light()) {
            let light = kept.light.each_ref().map(|way| way[packet].lane(lane));
            pixels.set_light(x, y, &Light(light));
        }
        if aovs.has(Aov::Samples) {
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(1)]);
        }
    }
}
