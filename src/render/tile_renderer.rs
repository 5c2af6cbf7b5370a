//! The packet engine's tile renderer: a tile's camera rays, its waves, its pixels.

use super::adaptive_edges::Scratch;
use super::ambient_occlusion::ambient_occlusion;
use super::aov_buffer::AovBuffer;
use super::heatmap::{RayCost, count_cost};
use super::levels::{Levels, trace_waves};
use super::shadow_cache::ShadowCache;
use super::stats::RenderStats;
use super::wavefront::{QueueSlice, RadianceX8, WavefrontContext};
use super::workers::TileRenderer;
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_scene::camera::Camera;
use phalanx_scene::film::Tile;
use phalanx_scene::film::TileBuffer;
use phalanx_scene::film::{Aov, Aovs, RadianceAovs};
use phalanx_scene::sampling::{
    BlockPixels, Dimension, FilmSamples, PixelAccumulator, Sampling, concentric_disk, points, seeds,
};
use phalanx_trace::bvh::Bvh;
use phalanx_trace::packet::camera::{directions, through_lens};
use phalanx_trace::packet::{NO_PRIM, QueueColumns, RayQueue, packets_for};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};
use phalanx_trace::{Kernel, PacketTracer, Traversal};

/// Renders tiles with packets of eight rays.
pub struct WavefrontRenderer<'a> {
    pub(super) camera: &'a Camera,
    pub(super) sampling: Sampling,
    aovs: Aovs,
    bvh: &'a Bvh,
    /// Tracer that counts nodes, if an AOV needs their count.
    counter: Counter<'a>,
    /// Accumulators of the pixels of a tile, where pixels have several samples.
    pub(super) accumulators: PixelAccumulators,
    /// Pixels that get more samples, one entry per block of a tile.
    pub(super) active_pixels: Vec<BlockPixels>,
    /// Buffers for samples that halve cells.
    pub(super) scratch_buffers: Scratch,
    context: WavefrontContext<'a>,
    /// True if rays have seeds.
    pub(super) seeded: bool,
    /// Distance to the sky, where only ambient occlusion is rendered.
    ao_distance: Option<f32>,
    /// Memory that lives as long as a group of camera rays that are traced together. `scratch`
    /// lives as long as one wave of them.
    tile_arena: Bump,
    scratch: Bump,
    levels: Levels,
}

impl<'a> WavefrontRenderer<'a> {
    /// A renderer for one worker, with one ray through the centre of each pixel. `max_depth` counts
    /// bounces after the primary ray.
    pub fn new(
        scene: &'a Scene,
        bvh: &'a Bvh,
        camera: &'a Camera,
        max_depth: u32,
        kernel: Kernel,
    ) -> Self {
        WavefrontRenderer {
            camera,
            sampling: Sampling::CENTER,
            aovs: Aovs::default(),
            bvh,
            counter: None,
            accumulators: PixelAccumulators::default(),
            active_pixels: Vec::new(),
            scratch_buffers: Scratch::default(),
            context: WavefrontContext {
                scene,
                traversal: Traversal::new(bvh, kernel),
                stats: RenderStats::default(),
                sample: 0,
                min_weight: 0.0,
                columns: QueueColumns::default(),
            },
            seeded: scene.is_stochastic(),
            ao_distance: None,
            tile_arena: Bump::new(),
            scratch: Bump::new(),
            levels: Levels::new(scene, max_depth, 0.0),
        }
        .with_min_weight(0.0)
    }

    /// Traces bounces only where the product of the weights along the path is at least this in some
    /// component.
    pub fn with_min_weight(self, min_weight: f32) -> Self {
        let scene = self.context.scene;
        let levels = Levels::new(scene, self.levels.max_depth(), min_weight);
        WavefrontRenderer {
            context: WavefrontContext {
                min_weight,
                columns: levels.columns(),
                ..self.context
            },
            levels,
            ..self
        }
    }

    /// Replaces the sampling of camera rays.
    pub fn with_sampling(self, sampling: Sampling) -> Self {
        WavefrontRenderer { sampling, ..self }
    }

    /// Sets the further outputs of each pixel.
    pub fn with_aovs(self, aovs: Aovs) -> Self {
        let alone = aovs.has(Aov::Cost).then(|| PacketTracer::new(self.bvh));
        WavefrontRenderer {
            aovs,
            counter: alone,
            ..self
        }
    }

    /// Renders ambient occlusion in place of shading: a hit is white if one ray from it meets
    /// nothing within `reach`, and else black.
    pub fn with_ambient_occlusion(self, reach: f32) -> Self {
        WavefrontRenderer {
            ao_distance: Some(reach),
            seeded: true,
            ..self
        }
    }

    /// Traces up to `room` camera rays, which `push` adds to the queue, and passes the results to
    /// `take`. Where rays have seeds, all are the `sample`-th of their pixels. The first rays of
    /// pixels also give hits, if they are recorded.
    pub(super) fn trace(
        &mut self,
        room: usize,
        sample: u32,
        keep_hits: bool,
        mut cache: Option<ShadowCache>,
        push: impl FnOnce(&mut RayQueue, &Camera, &Sampling),
        take: impl FnOnce(&mut PixelAccumulators, &TracedSamples, &mut Counter),
    ) {
        self.tile_arena.reset();
        let arena = &self.tile_arena;
        let mut rays = RayQueue::seeded(arena, room, self.seeded);
        push(&mut rays, self.camera, &self.sampling);
        self.context.sample = sample;
        self.context.stats.rays.primary += rays.len() as u64;
        let packets = packets_for(rays.len());
        let radiance = arena.alloc_slice_fill_copy(packets, RadianceX8::BLACK);
        let surface = sample == 0 && (keep_hits || self.aovs.of_surface());
        let mut aovs =
            (surface || self.aovs.of_light()).then(|| AovBuffer::of(arena, packets, self.aovs));
        let most = self.levels.camera_packets();
        for first in (0..packets).step_by(most) {
            let part = first..packets.min(first + most);
            let radiance = &mut radiance[part.clone()];
            let mut aovs = aovs.as_mut().map(|aovs| aovs.part(part.clone()));
            let view = QueueSlice {
                queue: &rays,
                packets: part,
            };
            let (engine, aovs) = (&mut self.context, aovs.as_mut());
            match self.ao_distance {
                Some(reach) => {
                    ambient_occlusion(engine, &mut self.scratch, view, reach, radiance, aovs)
                }
                None => {
                    let room = (&mut self.scratch, &mut self.levels);
                    trace_waves(engine, room, view, radiance, aovs, cache.as_mut());
                }
            }
        }
        let traced = TracedSamples {
            rays: &rays,
            radiance,
            first: surface,
            aovs: aovs.as_ref(),
        };
        take(&mut self.accumulators, &traced, &mut self.counter);
    }

    /// Traces the `sample`-th camera ray of each pixel of a tile.
    fn sample(
        &mut self,
        tile: Tile,
        sample: u32,
        keep_hits: bool,
        take: impl FnOnce(&mut PixelAccumulators, &TracedSamples, &mut Counter),
    ) {
        let push = |rays: &mut RayQueue, camera: &Camera, sampling: &Sampling| {
            push_camera_rays(rays, camera, tile, sampling, sample);
        };
        self.trace(tile.pixels() as usize, sample, keep_hits, None, push, take);
    }
}

impl TileRenderer for WavefrontRenderer<'_> {
    fn render_tile(&mut self, tile: Tile, pixels: &mut TileBuffer) {
        let keep_hits = pixels.record_hits();
        if let Some(adaptive) = self.sampling.adaptively() {
            return match self.seeded || self.camera.has_lens() {
                true => self.render_adaptively(adaptive, tile, pixels),
                false => self.render_by_cells(adaptive, tile, pixels),
            };
        }
        if self.sampling.spp == 1 {
            return self.sample(tile, 0, keep_hits, |_, traced, counter| {
                write_pixels(traced, pixels);
                traced.keep(pixels, counter, Some);
            });
        }
        self.accumulators.fit(tile.pixels() as usize, self.aovs);
        for sample in 0..self.sampling.spp {
            self.sample(tile, sample, keep_hits, |sums, traced, counter| {
                sums.add(traced, tile.width);
                traced.keep(pixels, counter, Some);
            });
        }
        for at in 0..tile.pixels() as u32 {
            let (x, y) = (at % tile.width, at / tile.width);
            self.accumulators.write_pixel(at as usize, pixels, (x, y));
        }
    }

    fn stats(&self) -> RenderStats {
        RenderStats {
            packets: self.context.traversal.stats().packets,
            ..self.context.stats
        }
    }
}

/// Appends the `sample`-th camera ray of each pixel of a tile, in 8×8 blocks of 4×2 pixels a
/// packet. Their parent is the pixel's position in the tile, row and column in sixteen bits each.
/// The first component of their throughput is their filter weight. If the queue has seeds, the rays
/// get those of the pixels.
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

/// Appends the camera rays of the `open` pixels of one 8×8 block, whose upper left corner is at
/// (`block_x`, `block_y`) in the tile.
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
        let FilmSamples {
            row,
            column,
            weight,
        } = sampling.film_samples::<LANES>(columns, rows, sample);
        let (row, column) = (F32x8::new(row), F32x8::new(column));
        let (org, dir) = if camera.has_lens() {
            let at = concentric_disk(points(seeds(columns, rows), sample, Dimension::Lens));
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

/// Appends the camera rays of the first `count` of these film samples, all through one eye. Their
/// parents are `pixels`.
pub(super) fn push_samples(
    rays: &mut RayQueue,
    camera: &Camera,
    places: FilmSamples<LANES>,
    count: usize,
    pixels: &[u32; LANES],
) {
    let eye = Vec3x8::splat(camera.eye.x, camera.eye.y, camera.eye.z);
    let dir = directions(camera, F32x8::new(places.row), F32x8::new(places.column));
    let counts = Vec3x8::new(F32x8::new(places.weight), F32x8::ZERO, F32x8::ZERO);
    rays.push(Mask8::first(count), eye, dir, counts, pixels);
}

/// The positions in the tile of a packet's 4×2 pixels, the first of which is at (`x`, `y`).
fn block_of(x: u32, y: u32) -> [u32; LANES] {
    std::array::from_fn(|k| (y + k as u32 / 4) << 16 | (x + k as u32 % 4))
}

/// Column and row of a packed position.
fn pixel_of(place: u32) -> (u32, u32) {
    (place & 0xffff, place >> 16)
}

/// Mask of the 4×2 pixels from (`x`, `y`) on that lie in the tile.
fn inside(tile: Tile, x: u32, y: u32) -> Mask8 {
    let row = (1u32 << tile.width.saturating_sub(x).min(4)) - 1;
    Mask8::from_bits(match tile.height.saturating_sub(y) {
        0 => 0,
        1 => row,
        _ => row | row << 4,
    })
}

/// Tracer that counts nodes, where an AOV needs their count.
type Counter<'a> = Option<PacketTracer<'a>>;

/// Results of some camera rays.
pub(super) struct TracedSamples<'a> {
    rays: &'a RayQueue<'a>,
    radiance: &'a [RadianceX8],
    /// True if the rays are the first of their pixels, and a hit or surface output is wanted.
    first: bool,
    aovs: Option<&'a AovBuffer<'a>>,
}

impl TracedSamples<'_> {
    /// The active rays with the positions of their pixels, packet by packet.
    fn lanes(&self) -> impl Iterator<Item = (usize, usize, (u32, u32))> {
        (0..self.radiance.len()).flat_map(|packet| {
            let places = self.rays.payload(packet).1;
            let lanes = self.rays.active(packet).lanes();
            lanes.map(move |lane| (packet, lane, pixel_of(places[lane])))
        })
    }

    /// Per ray: its radiance, the direct, reflected and refracted parts if an AOV needs them, and
    /// its filter weight.
    pub(super) fn outcomes(&self) -> impl Iterator<Item = ([f32; 3], [[f32; 3]; 3], f32)> {
        let aovs = self.aovs.filter(|aovs| !aovs.light[0].is_empty());
        self.lanes().map(move |(packet, lane, _)| {
            let light = |aovs: &AovBuffer| aovs.light.each_ref().map(|way| way[packet].lane(lane));
            let counts = self.rays.payload(packet).0[0][lane];
            let radiance = self.radiance[packet].lane(lane);
            (radiance, aovs.map_or([[0.0; 3]; 3], light), counts)
        })
    }

    /// Records hits and surfaces of first rays. `pixel` maps a position of the rays to a position
    /// in the tile.
    pub(super) fn keep(
        &self,
        pixels: &mut TileBuffer,
        counter: &mut Counter,
        pixel: impl Fn((u32, u32)) -> Option<(u32, u32)>,
    ) {
        let Some(aovs) = self.aovs.filter(|_| self.first) else {
            return;
        };
        for (packet, lane, place) in self.lanes() {
            let Some((x, y)) = pixel(place) else {
                continue;
            };
            let hit = &aovs.hits[packet];
            let prim_id = hit.prim_id.lane(lane);
            let t = match prim_id {
                NO_PRIM => 0.0,
                _ => hit.t.lane(lane),
            };
            pixels.set_hit(x, y, [t, hit.u.lane(lane), hit.v.lane(lane)], prim_id);
            if let Some(look) = aovs.surfaces.get(packet * LANES + lane) {
                pixels.set_surface(x, y, look);
            }
            if let Some(alone) = counter {
                let nodes = count_cost(alone, self.rays, packet, lane, RayCost::Nodes);
                pixels.set_layer(x, y, Aov::Cost, &[nodes]);
            }
        }
    }
}

/// Accumulators of the pixels of a tile, row by row.
#[derive(Default)]
pub(super) struct PixelAccumulators {
    pub(super) radiance: Vec<PixelAccumulator>,
    /// Direct, reflected and refracted light; empty where no AOV needs it.
    light: [Vec<PixelAccumulator>; 3],
}

impl PixelAccumulators {
    /// Clears the accumulators and resizes them to the given number of pixels.
    pub(super) fn fit(&mut self, count: usize, aovs: Aovs) {
        let clear = |all: &mut Vec<PixelAccumulator>, count: usize| {
            all.clear();
            all.resize(count, PixelAccumulator::default());
        };
        clear(&mut self.radiance, count);
        let count = if aovs.of_light() { count } else { 0 };
        self.light.iter_mut().for_each(|all| clear(all, count));
    }

    /// Adds samples to pixels, in rows of the given width.
    pub(super) fn add(&mut self, traced: &TracedSamples, width: u32) {
        for (packet, lane, (x, y)) in traced.lanes() {
            let at = (y * width + x) as usize;
            let counts = traced.rays.payload(packet).0[0][lane];
            self.radiance[at].add(traced.radiance[packet].lane(lane), counts);
            if let (Some(aovs), false) = (traced.aovs, self.light[0].is_empty()) {
                for (gathered, radiance) in self.light.iter_mut().zip(&aovs.light) {
                    gathered[at].add(radiance[packet].lane(lane), counts);
                }
            }
        }
    }

    /// Writes the sums of one accumulator to a pixel of the tile.
    pub(super) fn write_pixel(&self, at: usize, pixels: &mut TileBuffer, (x, y): (u32, u32)) {
        pixels.set(x, y, self.radiance[at].mean());
        let aovs = pixels.aovs();
        if aovs.is_empty() {
            return;
        }
        if aovs.of_light() {
            let light = self.light.each_ref().map(|all| all[at].mean());
            pixels.set_light(x, y, &RadianceAovs(light));
        }
        if aovs.has(Aov::Samples) {
            let count = self.radiance[at].count() as u32;
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(count)]);
        }
    }
}

/// Writes the results of each pixel's only camera ray to the tile's pixels.
fn write_pixels(traced: &TracedSamples, pixels: &mut TileBuffer) {
    for (packet, color) in traced.radiance.iter().enumerate() {
        let (active, places) = (traced.rays.active(packet), traced.rays.payload(packet).1);
        let (x, y) = pixel_of(places[0]);
        if active.bits() == 0xff && *places == block_of(x, y) {
            let row = |k: usize| color.plane_halves().map(|plane| plane[k]);
            pixels.set_run(x, y, row(0));
            pixels.set_run(x, y + 1, row(1));
        } else {
            for lane in active.lanes() {
                let (x, y) = pixel_of(places[lane]);
                pixels.set(x, y, color.lane(lane));
            }
        }
    }
    let aovs = pixels.aovs();
    if !aovs.of_light() && !aovs.has(Aov::Samples) {
        return;
    }
    for (packet, lane, (x, y)) in traced.lanes() {
        if let (Some(kept), true) = (traced.aovs, aovs.of_light()) {
            let light = kept.light.each_ref().map(|way| way[packet].lane(lane));
            pixels.set_light(x, y, &RadianceAovs(light));
        }
        if aovs.has(Aov::Samples) {
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(1)]);
        }
    }
}
