//! Camera rays of tiles, eight a packet.

use phalanx_scene::camera::Camera;
use phalanx_scene::film::Tile;
use phalanx_scene::sampling::{
    BlockPixels, Dimension, FilmSamples, Sampling, concentric_disk, points, seeds,
};
use phalanx_trace::packet::RayQueue;
use phalanx_trace::packet::camera::{self, through_lens};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};

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
pub(crate) fn push_block(
    rays: &mut RayQueue,
    camera: &Camera,
    tile: Tile,
    (block_x, block_y): (u32, u32),
    open: BlockPixels,
    sampling: &Sampling,
    sample: u32,
) {
    for packet in 0..8 {
        let (right, down) = (packet % 2 * 4, packet / 2 * 2);
        let (x, y) = (block_x + right, block_y + down);
        // Two rows of four.
        let requested = open >> (8 * down + right);
        let requested = Mask8::from_bits((requested & 0xf | requested >> 4 & 0xf0) as u32);
        let inside = inside(tile, x, y) & requested;
        let columns = std::array::from_fn(|k| tile.x + x + k as u32 % 4);
        let rows = std::array::from_fn(|k| tile.y + y + k as u32 / 4);
        let FilmSamples {
            row,
            column,
            weight,
        } = sampling.film_samples::<LANES>(columns, rows, sample);
        let (row, column) = (F32x8::new(row), F32x8::new(column));
        let (org, dir) = if camera.has_lens() {
            let lens_point = concentric_disk(points(seeds(columns, rows), sample, Dimension::Lens));
            through_lens(camera, row, column, lens_point.map(F32x8::new))
        } else {
            camera::rays(camera, row, column)
        };
        if rays.has_seeds() {
            rays.push_seeds(inside, &seeds(columns, rows));
        }
        let counts = Vec3x8::new(F32x8::new(weight), F32x8::ZERO, F32x8::ZERO);
        rays.push(inside, org, dir, counts, &block_of(x, y));
    }
}

/// Appends the camera rays of the first `count` of these film samples, without a lens. Their
/// parents are `pixels`.
pub(crate) fn push_samples(
    rays: &mut RayQueue,
    camera: &Camera,
    places: FilmSamples<LANES>,
    count: usize,
    pixels: &[u32; LANES],
) {
    let (row, column) = (F32x8::new(places.row), F32x8::new(places.column));
    let (org, dir) = camera::rays(camera, row, column);
    let counts = Vec3x8::new(F32x8::new(places.weight), F32x8::ZERO, F32x8::ZERO);
    rays.push(Mask8::first(count), org, dir, counts, pixels);
}

/// The positions in the tile of a packet's 4×2 pixels, the first of which is at (`x`, `y`).
pub(crate) fn block_of(x: u32, y: u32) -> [u32; LANES] {
    std::array::from_fn(|k| (y + k as u32 / 4) << 16 | (x + k as u32 % 4))
}

/// Column and row of a packed position.
pub(crate) fn pixel_of(place: u32) -> (u32, u32) {
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
