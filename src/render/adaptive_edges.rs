//! Tiles whose pixels get as many samples as their parts need. The packet engine works in rounds.
//! Each round halves the cells that the earlier rounds left active.

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

/// Most samples that are held at once, for a block or more, if every possible sample is taken. With
/// what belongs to them they take about 110 bytes each.
const MAX_GROUP_SAMPLES: u32 = 1 << 16;

/// Most rays that are traced together: as many as a tile of the default side has pixels, for the
/// same reason.
const MAX_GROUP_BLOCKS: usize = 1024;

/// The visibility of the lights is kept per ray of a single wave.
const _: () = assert!(
    MAX_GROUP_BLOCKS <= CAMERA_RAYS,
    "they would be several waves"
);

/// A block of a group, and the index of one of its requests.
pub(super) type RefineRequest = (u32, u32);

/// Buffers for the samples of a group, and for the results of a round's samples.
#[derive(Default)]
pub(super) struct Scratch {
    cells: Vec<Cells>,
    requests: Vec<RefineRequest>,
    visibility: Vec<[LightVisibility; MAX_HITS]>,
    results: Vec<SampleResult>,
}

impl WavefrontRenderer<'_> {
    /// Renders a tile, and with it the rest of its blocks: pixels beyond a region's border also
    /// decide where more samples are needed.
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

    /// Traces all samples that the blocks of a group request. The first samples of pixels also give
    /// hits, where those are recorded.
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

/// Maps a position in `whole`, which surrounds the tile, to the position in the tile; `None`
/// outside the tile.
pub(super) fn within(whole: Tile, tile: Tile) -> impl Fn((u32, u32)) -> Option<(u32, u32)> {
    move |(x, y)| {
        let x = (whole.x + x).checked_sub(tile.x)?;
        let y = (whole.y + y).checked_sub(tile.y)?;
        (x < tile.width && y < tile.height).then_some((x, y))
    }
}

/// Appends the camera rays that blocks of a tile request.
fn push_requests(
    rays: &mut RayQueue,
    camera: &Camera,
    sampling: &Sampling,
    whole: Tile,
    cells: &[Cells],
    asks: &[RefineRequest],
) {
    for eight in asks.chunks(LANES) {
        // Lanes past the end repeat the last request.
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

/// Writes the sums that a block has accumulated to the pixels of a tile.
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
    /// Results of the rays in their order, without the visibility of the lights.
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
