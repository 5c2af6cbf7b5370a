//! Tiles whose pixels get as many samples as their parts need: rounds of the packet engine, each of which halves the cells that
//! those before have left open.

use super::adaptive::{corners, size_of};
use super::film::Pixels;
use super::layers::{Aov, Light};
use super::packets::{PacketPainter, Traced, push_places};
use super::sights::Sights;
use super::tiles::Tile;
use crate::camera::Camera;
use crate::lanes::LANES;
use crate::packet::RayQueue;
use crate::sampling::{Adaptive, Answer, BLOCK, Cells, SIGHTS, Sampling, Sight};

/// Samples that are kept at once, if all that may come do: about a hundred bytes each.
const SAMPLES: u32 = 1 << 18;

/// Rays that are traced together, at most.
const TOGETHER: usize = 4096;

/// Where one round's samples and what came of them are kept from round to round, so that memory is asked for once.
#[derive(Default)]
pub(super) struct Room {
    cells: Vec<Cells>,
    asks: Vec<(u32, u32)>,
    sights: Vec<[Sight; SIGHTS]>,
    answers: Vec<Answer>,
}

impl PacketPainter<'_> {
    /// Paints a tile, and with it whatever else there is of its blocks: pixels beyond a region's border have a say in who needs more.
    pub(super) fn paint_by_cells(&mut self, adaptive: Adaptive, tile: Tile, pixels: &mut Pixels) {
        let whole = tile.outward(BLOCK, self.camera.size());
        let corners: Vec<_> = corners(whole).collect();
        let spp = self.sampling.spp;
        let mut room = std::mem::take(&mut self.room);
        for group in corners.chunks((SAMPLES / (BLOCK * BLOCK * spp)).max(1) as usize) {
            room.cells.resize_with(group.len(), Cells::default);
            for (cells, &(x, y)) in room.cells.iter_mut().zip(group) {
                let corner = (whole.x + x, whole.y + y);
                let size = size_of(whole, (x, y));
                cells.begin(adaptive, spp, (corner, size), pixels.aovs().of_light());
            }
            let mut first = true;
            loop {
                self.halve(&mut room, (whole, group), first, tile, pixels);
                first = false;
                if !room
                    .cells
                    .iter_mut()
                    .fold(false, |more, cells| cells.go_on() | more)
                {
                    break;
                }
            }
            for (cells, &corner) in room.cells.iter().zip(group) {
                finish(cells, (whole, corner), tile, pixels);
            }
        }
        self.room = room;
    }

    /// Answers all that the blocks of a group ask for. With the first samples of pixels come hits, where they are wanted.
    fn halve(
        &mut self,
        room: &mut Room,
        (whole, group): (Tile, &[(u32, u32)]),
        first: bool,
        tile: Tile,
        pixels: &mut Pixels,
    ) {
        room.asks.clear();
        for (block, cells) in (0..).zip(&room.cells) {
            room.asks
                .extend((0..cells.asks().len() as u32).map(|ask| (block, ask)));
        }
        let keep_hits = pixels.record_hits();
        for asks in room.asks.chunks(TOGETHER) {
            room.sights.clear();
            room.sights.resize(asks.len(), Default::default());
            let cells = &room.cells;
            let push = |rays: &mut RayQueue, camera: &Camera, sampling: &Sampling| {
                push_asks(rays, camera, sampling, whole, (cells, group, asks));
            };
            let sights = Sights {
                cells,
                asks,
                all: &mut room.sights,
                bounced: &[],
            };
            let answers = &mut room.answers;
            let number = if first { 0 } else { 1 };
            self.trace(
                asks.len(),
                number,
                keep_hits,
                Some(sights),
                push,
                |_, traced, counter| {
                    answers.clear();
                    answers.extend(traced.answers());
                    traced.keep(pixels, counter, within(whole, tile));
                },
            );
            for ((&(block, ask), answer), sights) in asks.iter().zip(answers).zip(&room.sights) {
                answer.sights = *sights;
                room.cells[block as usize].answer(ask as usize, answer);
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

/// Appends the camera rays that blocks of a tile, with these corners there, ask for.
fn push_asks(
    rays: &mut RayQueue,
    camera: &Camera,
    sampling: &Sampling,
    whole: Tile,
    (cells, corners, asks): (&[Cells], &[(u32, u32)], &[(u32, u32)]),
) {
    for eight in asks.chunks(LANES) {
        // Past the end the last is repeated.
        let asked: [_; LANES] = std::array::from_fn(|k| {
            let (block, ask) = eight[k.min(eight.len() - 1)];
            let ask = &cells[block as usize].asks()[ask as usize];
            let (x, y) = corners[block as usize];
            (x + ask.pixel.0, y + ask.pixel.1, ask.number)
        });
        let places = asked.map(|(x, y, _)| y << 16 | x);
        let columns = asked.map(|(x, _, _)| whole.x + x);
        let rows = asked.map(|(_, y, _)| whole.y + y);
        let numbers = asked.map(|(_, _, number)| number);
        push_places(
            rays,
            camera,
            sampling.places_of(columns, rows, numbers),
            eight.len(),
            &places,
        );
    }
}

/// Gives the pixels of a tile what those of a block have gathered.
fn finish(cells: &Cells, (whole, corner): (Tile, (u32, u32)), tile: Tile, pixels: &mut Pixels) {
    let within = within(whole, tile);
    let aovs = pixels.aovs();
    for (at, sum) in (0..).zip(&cells.sums()) {
        let (x, y) = (corner.0 + at % BLOCK, corner.1 + at / BLOCK);
        let inside = x < whole.width && y < whole.height;
        let Some((x, y)) = within((x, y)).filter(|_| inside) else {
            continue;
        };
        pixels.set(x, y, sum.radiance.mean());
        if aovs.of_light() {
            pixels.set_light(x, y, &Light(sum.light.map(|way| way.mean())));
        }
        if aovs.has(Aov::Samples) {
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(sum.samples)]);
        }
    }
}

impl Traced<'_> {
    /// What came of each ray, in their order, but for what it saw of the lights.
    fn answers(&self) -> impl Iterator<Item = Answer> {
        self.outcomes().map(|(radiance, light, weight)| Answer {
            radiance,
            light,
            weight,
            sights: Default::default(),
        })
    }
}
