//! Tiles whose pixels get as many samples as their parts need: rounds of the packet engine, each of
//! which halves the cells that those before have left open.

use super::adaptive_noise::{corners, size_of};
use super::levels::CAMERA_RAYS;
use super::shadow_cache::ShadowCache;
use super::tile_renderer::{TracedSamples, WavefrontRenderer, push_samples};
use phalanx_scene::camera::Camera;
use phalanx_scene::film::Tile;
use phalanx_scene::film::TileBuffer;
use phalanx_scene::film::{Aov, RadianceAovs};
use phalanx_scene::sampling::{
    Adaptive, BLOCK, Cells, LightVisibility, MAX_HITS, SampleResult, Sampling,
};
use phalanx_trace::packet::RayQueue;
use phalanx_trace::simd::LANES;

/// Samples that are kept at once, of a block or more, if all come that may: with what belongs to
/// them about 110 bytes each.
const MAX_GROUP_SAMPLES: u32 = 1 << 16;

/// Rays that are traced together, at most: as many as a tile of the default side has pixels, for
/// the same reason.
const MAX_GROUP_BLOCKS: usize = 1024;

/// Their visibility of the lights is kept by ray of one wave.
const _: () = assert!(
    MAX_GROUP_BLOCKS <= CAMERA_RAYS,
    "they would be several waves"
);

/// A block of a group, and which of its asks.
pub(super) type RefineRequest = (u32, u32);

/// Room for the samples of a group, and for what came of those of a round.
#[derive(Default)]
pub(super) struct Scratch {
    cells: Vec<Cells>,
    requests: Vec<RefineRequest>,
    visibility: Vec<[LightVisibility; MAX_HITS]>,
    results: Vec<SampleResult>,
}

impl WavefrontRenderer<'_> {
    /// Paints a tile, and with it whatever else there is of its blocks: pixels beyond a region's
    /// border have a say in who needs more.
    pub(super) fn render_by_cells(
        &mut self,
        adaptive: Adaptive,
        tile: Tile,
        pixels: &mut TileBuffer,
    ) {
        let whole = tile.outward(BLOCK, self.camera.size());
        let corners: Vec<_> = corners(whole).collect();
        let spp = self.sampling.spp;
        let mut room = std::mem::take(&mut self.scratch_buffers);
        for group in corners.chunks((MAX_GROUP_SAMPLES / (BLOCK * BLOCK * spp)).max(1) as usize) {
            room.cells.resize_with(group.len(), Cells::default);
            for (cells, &(x, y)) in room.cells.iter_mut().zip(group) {
                let corner = (whole.x + x, whole.y + y);
                let size = size_of(whole, (x, y));
                cells.begin(adaptive, spp, (corner, size), pixels.aovs().of_light());
            }
            let mut first = true;
            loop {
                self.refine(&mut room, whole, first, tile, pixels);
                first = false;
                let ask = |more, cells: &mut Cells| cells.next_round() | more;
                if !room.cells.iter_mut().fold(false, ask) {
                    break;
                }
            }
            for cells in &room.cells {
                finish(cells, tile, pixels);
            }
        }
        self.scratch_buffers = room;
    }

    /// Answers all that the blocks of a group ask for. With the first samples of pixels come hits,
    /// where they are wanted.
    fn refine(
        &mut self,
        room: &mut Scratch,
        whole: Tile,
        first: bool,
        tile: Tile,
        pixels: &mut TileBuffer,
    ) {
        room.requests.clear();
        for (block, cells) in (0..).zip(&room.cells) {
            room.requests
                .extend((0..cells.requests().len() as u32).map(|ask| (block, ask)));
        }
        let keep_hits = pixels.record_hits();
        for asks in room.requests.chunks(MAX_GROUP_BLOCKS) {
            room.visibility.clear();
            room.visibility.resize(asks.len(), Default::default());
            let cells = &room.cells;
            let push = |rays: &mut RayQueue, camera: &Camera, sampling: &Sampling| {
                push_requests(rays, camera, sampling, whole, cells, asks);
            };
            let cache = ShadowCache {
                cells,
                requests: asks,
                visibility: &mut room.visibility,
                ancestors: &[],
            };
            let answers = &mut room.results;
            let number = if first { 0 } else { 1 };
            self.trace(
                asks.len(),
                number,
                keep_hits,
                Some(cache),
                push,
                |_, traced, counter| {
                    answers.clear();
                    answers.extend(traced.results());
                    traced.keep(pixels, counter, within(whole, tile));
                },
            );
            for ((&(block, ask), answer), sights) in asks.iter().zip(answers).zip(&room.visibility)
            {
                answer.visibility = *sights;
                room.cells[block as usize].add_result(ask as usize, answer);
            }
        }
    }
}

/// The place in a tile of a place in what surrounds it, where it has one.
pub(super) fn within(whole: Tile, tile: Tile) -> impl Fn((u32, u32)) -> Option<(u32, u32)> {
    move |(x, y)| {
        let x = (whole.x + x).checked_sub(tile.x)?;
        let y = (whole.y + y).checked_sub(tile.y)?;
        (x < tile.width && y < tile.height).then_some((x, y))
    }
}

/// Appends the camera rays that blocks of a tile ask for.
fn push_requests(
    rays: &mut RayQueue,
    camera: &Camera,
    sampling: &Sampling,
    whole: Tile,
    cells: &[Cells],
    asks: &[RefineRequest],
) {
    for eight in asks.chunks(LANES) {
        // Past the end the last is repeated.
        let asked: [_; LANES] = std::array::from_fn(|k| {
            let (block, ask) = eight[k.min(eight.len() - 1)];
            let cells = &cells[block as usize];
            let ask = &cells.requests()[ask as usize];
            let (x, y) = cells.corner();
            (x + ask.pixel.0, y + ask.pixel.1, ask.number)
        });
        let columns = asked.map(|(x, _, _)| x);
        let rows = asked.map(|(_, y, _)| y);
        let numbers = asked.map(|(_, _, number)| number);
        let places = asked.map(|(x, y, _)| (y - whole.y) << 16 | (x - whole.x));
        push_samples(
            rays,
            camera,
            sampling.film_samples_of(columns, rows, numbers),
            eight.len(),
            &places,
        );
    }
}

/// Gives the pixels of a tile what those of a block have gathered.
fn finish(cells: &Cells, tile: Tile, pixels: &mut TileBuffer) {
    let ((right, down), aovs) = (cells.corner(), pixels.aovs());
    for (at, sum) in (0..).zip(&cells.sums()) {
        let x = (right + at % BLOCK).checked_sub(tile.x);
        let y = (down + at / BLOCK).checked_sub(tile.y);
        let Some((x, y)) = x.zip(y).filter(|p| p.0 < tile.width && p.1 < tile.height) else {
            continue;
        };
        pixels.set(x, y, sum.radiance.mean());
        if aovs.of_light() {
            pixels.set_light(x, y, &RadianceAovs(sum.light.map(|way| way.mean())));
        }
        if aovs.has(Aov::Samples) {
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(sum.samples)]);
        }
    }
}

impl TracedSamples<'_> {
    /// What came of each ray, in their order, but for what it saw of the lights.
    fn results(&self) -> impl Iterator<Item = SampleResult> {
        self.outcomes()
            .map(|(radiance, light, weight)| SampleResult {
                radiance,
                light,
                weight,
                visibility: Default::default(),
            })
    }
}
