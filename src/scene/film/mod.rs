//! The film, a picture that is being rendered: linear radiance in planes, and the primary hits if
//! they are requested.
//!
//! A renderer fills its own [`TileBuffer`]. The worker copies each finished tile to the film.

mod aov;
mod nan;
mod tiles;

pub use aov::{Aov, AovChannel, Aovs, NO_ID, RadianceAovs, SurfaceAov, current_channel_name};
pub use tiles::{Tile, tiles};

use std::sync::{Mutex, PoisonError};

/// `prim_id` of a pixel whose primary ray hit nothing.
pub const NO_HIT: u32 = crate::NO_PRIM;

/// Linear, unclamped RGB radiance of every pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green and blue planes, each of width · height values.
    pub planes: [Vec<f32>; 3],
    /// Layers stored for every pixel.
    pub aovs: Aovs,
    /// The channels of the layers, each of width · height values.
    pub aov_planes: Vec<Vec<f32>>,
    /// Primary hits, if the render recorded them.
    pub hits: Option<Hits>,
}

/// Primary hits of every pixel, in the film's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hits {
    /// Primitive, or [`NO_HIT`].
    pub prim_id: Vec<u32>,
    /// Distance along the unit direction; 0 for a miss.
    pub t: Vec<f32>,
    /// Barycentric weight of the second vertex (triangles), else 0.
    pub u: Vec<f32>,
    /// Barycentric weight of the third vertex (triangles), else 0.
    pub v: Vec<f32>,
}

impl Hits {
    fn none(pixels: usize) -> Hits {
        Hits {
            prim_id: vec![NO_HIT; pixels],
            t: vec![0.0; pixels],
            u: vec![0.0; pixels],
            v: vec![0.0; pixels],
        }
    }
}

impl Film {
    /// A black film.
    pub fn new(width: u32, height: u32, record_hits: bool) -> Film {
        let pixels = width as usize * height as usize;
        // The system zeroes pages on the first write, so all workers share that work instead of one
        // of them zeroing everything in advance.
        Film {
            width,
            height,
            planes: [0, 1, 2].map(|_| vec![0.0; pixels]),
            aovs: Aovs::default(),
            aov_planes: Vec::new(),
            hits: record_hits.then(|| Hits::none(pixels)),
        }
    }

    /// Adds layers, which are 0.
    #[inline]
    pub fn with_aovs(mut self, aovs: Aovs) -> Film {
        let pixels = self.planes[0].len();
        self.aovs = aovs;
        self.aov_planes = aovs.channels().map(|_| vec![0.0; pixels]).collect();
        self
    }

    /// All planes but those of hits, each of one size: red, green, blue, and the channels of the
    /// layers.
    #[inline]
    pub fn all_planes(&self) -> Vec<&[f32]> {
        let all = self.planes.iter().chain(&self.aov_planes);
        all.map(Vec::as_slice).collect()
    }

    /// The planes of a layer, one for each of its channels; none if the film does not have it.
    #[inline]
    pub fn layer(&self, aov: Aov) -> &[Vec<f32>] {
        let first = self.aovs.before(aov);
        let channels = if self.aovs.has(aov) { aov.channels().len() } else { 0 };
        &self.aov_planes[first..first + channels]
    }

    /// The planes of [`Film::all_planes`], to be written to.
    #[inline]
    pub fn planes_mut(&mut self) -> Vec<&mut [f32]> {
        let all = self.planes.iter_mut().chain(&mut self.aov_planes);
        all.map(Vec::as_mut_slice).collect()
    }

    /// Stores a tile of the picture on a film of `window`, which the tile lies in.
    pub fn put(&mut self, window: Tile, tile: Tile, pixels: &TileBuffer) {
        let pitch = window.width as usize;
        let first = (tile.y - window.y) as usize * pitch + (tile.x - window.x) as usize;
        let planes = self.planes.iter_mut().chain(&mut self.aov_planes);
        let mut all = FilmBand {
            planes: planes.map(Vec::as_mut_slice).collect(),
            ..FilmBand::default()
        };
        if let Some(Hits { prim_id, t, u, v }) = &mut self.hits {
            (all.prim_id, all.tuv) = (prim_id, [t, u, v].map(Vec::as_mut_slice));
        }
        all.put(pixels, (first, pitch));
    }

    /// Radiance of the pixel in column `x`, row `y`.
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        let i = y as usize * self.width as usize + x as usize;
        [self.planes[0][i], self.planes[1][i], self.planes[2][i]]
    }
}

/// The pixels of one tile, row by row from its top left, and their primary hits if the film stores
/// them.
#[derive(Debug)]
pub struct TileBuffer {
    width: usize,
    planes: [Vec<f32>; 3],
    aovs: Aovs,
    aov_planes: Vec<Vec<f32>>,
    hits: Option<Hits>,
}

impl TileBuffer {
    /// A buffer that has no tile yet.
    #[inline]
    pub fn new(record_hits: bool) -> TileBuffer {
        TileBuffer {
            width: 0,
            planes: Default::default(),
            aovs: Aovs::default(),
            aov_planes: Vec::new(),
            hits: record_hits.then(Hits::default),
        }
    }

    /// Adds layers.
    #[inline]
    pub fn with_aovs(mut self, aovs: Aovs) -> TileBuffer {
        self.aovs = aovs;
        self.aov_planes = aovs.channels().map(|_| Vec::new()).collect();
        self
    }

    /// Resizes the buffer to a tile, with black pixels and no hits.
    pub fn fit(&mut self, tile: Tile) {
        let count = tile.pixels() as usize;
        self.width = tile.width as usize;
        let refill = |plane: &mut Vec<f32>| {
            plane.clear();
            plane.resize(count, 0.0);
        };
        self.planes.iter_mut().for_each(refill);
        self.aov_planes.iter_mut().for_each(refill);
        if let Some(hits) = &mut self.hits {
            hits.prim_id.clear();
            hits.prim_id.resize(count, NO_HIT);
            [&mut hits.t, &mut hits.u, &mut hits.v]
                .into_iter()
                .for_each(refill);
        }
    }

    /// All planes of the tile but those of hits, as in [`Film::all_planes`].
    #[inline]
    pub fn planes(&self) -> Vec<&[f32]> {
        let all = self.planes.iter().chain(&self.aov_planes);
        all.map(Vec::as_slice).collect()
    }

    /// Red, green and blue, row by row.
    #[inline]
    pub fn radiance(&self) -> &[Vec<f32>; 3] {
        &self.planes
    }

    /// The requested layers.
    #[inline]
    pub fn aovs(&self) -> Aovs {
        self.aovs
    }

    /// Sets the surface layers of a pixel: the hit of its first camera ray.
    #[inline]
    pub fn set_surface(&mut self, x: u32, y: u32, surface: &SurfaceAov) {
        for aov in self.aovs.iter() {
            let (values, count) = surface.channels(aov);
            self.set_layer(x, y, aov, &values[..count]);
        }
    }

    /// Sets the light layers of a pixel: its radiance by the path along which it came.
    #[inline]
    pub fn set_light(&mut self, x: u32, y: u32, light: &RadianceAovs) {
        for (aov, rgb) in RadianceAovs::AOVS.into_iter().zip(&light.0) {
            if self.aovs.has(aov) {
                self.set_layer(x, y, aov, rgb);
            }
        }
    }

    /// Sets the first channels of a layer, which must be one of the requested ones.
    #[inline]
    pub fn set_layer(&mut self, x: u32, y: u32, aov: Aov, values: &[f32]) {
        let at = self.index(x, y);
        for (channel, value) in self.aov_planes[self.aovs.before(aov)..]
            .iter_mut()
            .zip(values)
        {
            channel[at] = *value;
        }
    }

    /// Returns true if the film stores hits.
    #[inline]
    pub fn record_hits(&self) -> bool {
        self.hits.is_some()
    }

    /// Sets the radiance of a pixel of the tile.
    #[inline]
    pub fn set(&mut self, x: u32, y: u32, rgb: [f32; 3]) {
        let at = self.index(x, y);
        for (plane, value) in self.planes.iter_mut().zip(rgb) {
            plane[at] = value;
        }
    }

    /// Sets the radiance of a run of pixels of one row of the tile, from (`x`, `y`) on.
    #[inline]
    pub fn set_run<const N: usize>(&mut self, x: u32, y: u32, rgb: [&[f32; N]; 3]) {
        let at = self.index(x, y);
        for (plane, values) in self.planes.iter_mut().zip(rgb) {
            plane[at..at + N].copy_from_slice(values);
        }
    }

    /// Sets the primary hit of a pixel of the tile as (t, u, v) and primitive, if the film stores
    /// hits.
    #[inline]
    pub fn set_hit(&mut self, x: u32, y: u32, [t, u, v]: [f32; 3], prim_id: u32) {
        let at = self.index(x, y);
        if let Some(hits) = &mut self.hits {
            hits.prim_id[at] = prim_id;
            (hits.t[at], hits.u[at], hits.v[at]) = (t, u, v);
        }
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width + x as usize
    }
}

/// Receives finished tiles from workers.
pub trait TileSink: Sync {
    /// Returns true if primary hits are requested.
    fn records_hits(&self) -> bool;
    /// The requested layers.
    fn aovs(&self) -> Aovs;
    /// Stores the pixels of a tile.
    fn put(&self, tile: Tile, pixels: &TileBuffer);
    /// Returns true if no more tiles are wanted.
    fn is_closed(&self) -> bool {
        false
    }
}

/// A film of a window of the picture that workers fill at the same time, in bands as high as a
/// tile.
pub struct SharedFilm<'a> {
    window: Tile,
    side: u32,
    aovs: Aovs,
    record_hits: bool,
    bands: Vec<Mutex<FilmBand<'a>>>,
}

/// A band: some rows of a film.
#[derive(Default)]
struct FilmBand<'a> {
    /// Planes of radiance and layers.
    planes: Vec<&'a mut [f32]>,
    /// Primitives of the hits; empty if the film stores no hits.
    prim_id: &'a mut [u32],
    tuv: [&'a mut [f32]; 3],
}

impl<'a> SharedFilm<'a> {
    /// A shared film of a window as large as `film`, for the window's tiles of this side.
    pub fn of(film: &'a mut Film, window: Tile, side: u32) -> SharedFilm<'a> {
        let (width, record_hits) = (film.width as usize, film.hits.is_some());
        let aovs = film.aovs;
        let cells = window.y / side..(window.y + window.height).div_ceil(side);
        let values = cells.map(|row| {
            let cell = Tile {
                y: row * side,
                height: side,
                ..window
            };
            width * cell.within(window).height as usize
        });
        let values: Vec<usize> = values.collect();
        let mut bands: Vec<FilmBand> = Vec::new();
        bands.resize_with(values.len(), FilmBand::default);
        for plane in film.planes.iter_mut().chain(&mut film.aov_planes) {
            part(plane, &values, &mut bands, |band, mine| {
                band.planes.push(mine)
            });
        }
        if let Some(Hits { prim_id, t, u, v }) = &mut film.hits {
            part(prim_id, &values, &mut bands, |band, mine| {
                band.prim_id = mine
            });
            for (k, column) in [t, u, v].into_iter().enumerate() {
                part(column, &values, &mut bands, |band, mine| band.tuv[k] = mine);
            }
        }
        SharedFilm {
            window,
            side,
            aovs,
            record_hits,
            bands: bands.into_iter().map(Mutex::new).collect(),
        }
    }
}

/// Splits a plane into the rows of each band.
fn part<'a, T>(
    mut plane: &'a mut [T],
    values: &[usize],
    bands: &mut [FilmBand<'a>],
    give: impl Fn(&mut FilmBand<'a>, &'a mut [T]),
) {
    for (band, &count) in bands.iter_mut().zip(values) {
        let (mine, rest) = plane.split_at_mut(count);
        give(band, mine);
        plane = rest;
    }
}

impl TileSink for SharedFilm<'_> {
    fn records_hits(&self) -> bool {
        self.record_hits
    }

    fn aovs(&self) -> Aovs {
        self.aovs
    }

    /// Stores a tile, which must be one of those that the film was split for.
    fn put(&self, tile: Tile, pixels: &TileBuffer) {
        let row = (tile.y / self.side - self.window.y / self.side) as usize;
        let top = (tile.y - tile.y % self.side).max(self.window.y);
        // A panic leaves no band in an invalid state: pixels are plain numbers.
        let mut band = self.bands[row]
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let pitch = self.window.width as usize;
        let first = (tile.y - top) as usize * pitch + (tile.x - self.window.x) as usize;
        band.put(pixels, (first, pitch));
    }
}

impl FilmBand<'_> {
    /// Stores the pixels of a tile from a value of the band on, in rows that are this far apart.
    fn put(&mut self, pixels: &TileBuffer, (first, pitch): (usize, usize)) {
        let place = (first, pitch, pixels.width);
        let planes = pixels.planes.iter().chain(&pixels.aov_planes);
        for (to, from) in self.planes.iter_mut().zip(planes) {
            put(to, from, place);
        }
        if let Some(Hits { prim_id, t, u, v }) = &pixels.hits {
            put(self.prim_id, prim_id, place);
            for (to, from) in self.tuv.iter_mut().zip([t, u, v]) {
                put(to, from, place);
            }
        }
    }
}

/// Copies rows of `width` values to rows that are `pitch` apart, from `first` on.
fn put<T: Copy>(to: &mut [T], from: &[T], (first, pitch, width): (usize, usize, usize)) {
    let rows = to[first..].chunks_mut(pitch);
    for (to, from) in rows.zip(from.chunks(width)) {
        to[..width].copy_from_slice(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that every tile's pixels get the values that they have on the film.
    #[test]
    fn pixels_land_where_their_tile_lies() {
        let sizes = [(1, 1, 8), (40, 24, 8), (33, 17, 16), (7, 100, 64)];
        let corners = [(0, 0), (8, 16), (13, 5)];
        for ((width, height, side), (left, top)) in
            sizes.into_iter().flat_map(|s| corners.map(|c| (s, c)))
        {
            let window = Tile {
                x: left,
                y: top,
                width,
                height,
            };
            let mut film = Film::new(width, height, true);
            let shared = SharedFilm::of(&mut film, window, side);
            let mut pixels = TileBuffer::new(shared.records_hits());
            for tile in tiles(window, side) {
                pixels.fit(tile);
                for (x, y) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y))) {
                    let number = (tile.y - top + y) * width + tile.x - left + x;
                    let value = number as f32;
                    pixels.set(x, y, [value, -value, 0.5 * value]);
                    if number % 3 > 0 {
                        pixels.set_hit(x, y, [value + 1.0, value + 2.0, value + 3.0], number);
                    }
                }
                shared.put(tile, &pixels);
            }
            let hits = film.hits.expect("they were asked for");
            for number in 0..width * height {
                let (at, value) = (number as usize, number as f32);
                let rgb = [0, 1, 2].map(|k: usize| film.planes[k][at]);
                assert_eq!(rgb, [value, -value, 0.5 * value], "{width}x{height}");
                let hit = (hits.prim_id[at], [hits.t[at], hits.u[at], hits.v[at]]);
                let want = match number % 3 {
                    0 => (NO_HIT, [0.0; 3]),
                    _ => (number, [1.0, 2.0, 3.0].map(|k| value + k)),
                };
                assert_eq!(hit, want, "{width}x{height}");
            }
        }
    }

    #[test]
    fn a_run_is_its_pixels_one_by_one() {
        let tile = Tile {
            x: 8,
            y: 16,
            width: 8,
            height: 3,
        };
        let [mut runs, mut single] = [0, 1].map(|_| TileBuffer::new(false));
        for pixels in [&mut runs, &mut single] {
            pixels.fit(tile);
        }
        let [r, g, b] = [0.0f32, 10.0, 20.0].map(|from| [1.0, 2.0, 3.0, 4.0].map(|k| from + k));
        runs.set_run(4, 1, [&r, &g, &b]);
        for k in 0..4 {
            single.set(4 + k as u32, 1, [r[k], g[k], b[k]]);
        }
        assert_eq!(runs.planes, single.planes);
        assert_eq!(
            runs.planes[1][12..],
            [
                11.0, 12.0, 13.0, 14.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            ]
        );
    }
}
